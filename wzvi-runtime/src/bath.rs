//! What a system says of the heat bath that it is in: `friction`, `damping` and `temperature` of `#[hamiltonian]`.

use crate::scalar::Scalar;
use crate::system::Hamiltonian;

/// A system `dp = -∂H/∂q dt - Γ M⁻¹ p dt + noise of covariance 2 kT Γ dt` with the quadratic kinetic energy `p · M⁻¹ p / 2`, which the compiler has
/// proven; generated.
pub trait Damped: Hamiltonian {
    /// Whether [`Damped::damping`] is the matrix `Γ` (mass/time), and not rates (1/time).
    const IS_MATRIX: bool;
    /// Whether it depends on the coordinates.
    const PER_STATE: bool;
    /// Whether `M` is diagonal. Where it is not, rates are all the same.
    const HAS_DIAGONAL_MASSES: bool;

    /// `Γ` by rows, or the rates `(Γ M⁻¹)_ii`, one per degree of freedom. NaN for lists that do not fit.
    fn damping<S: Scalar>(&self, q: &[S], into: &mut [S]);

    /// `kT`, if the system has a temperature; else the bath is at rest.
    fn temperature(&self) -> Option<f64>;

    /// `M⁻¹`: its diagonal, one number per degree of freedom, or its rows.
    fn inverse_mass(&self, into: &mut [f64]) {
        let degrees = if Self::HAS_DIAGONAL_MASSES { into.len() } else { into.len().isqrt() };
        let zeros = vec![0.0; degrees];
        let (mut p, mut by_q, mut velocity) = (zeros.clone(), zeros.clone(), zeros.clone());
        // The velocities are linear in the momenta and read nothing else.
        if Self::HAS_DIAGONAL_MASSES {
            p.fill(1.0);
            self.differentiate(0, &zeros, &p, 0.0, &mut by_q, into);
            return;
        }
        for (column, start) in (0..degrees).enumerate() {
            p.fill(0.0);
            p[start] = 1.0;
            self.differentiate(0, &zeros, &p, 0.0, &mut by_q, &mut velocity);
            velocity.iter().enumerate().for_each(|(row, v)| into[row * degrees + column] = *v);
        }
    }
}
