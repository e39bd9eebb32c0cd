//! Systems with friction, as the compiler describes them to the run time.

use wzvi::bath::{Around, Damped, Splitting};
use wzvi::prelude::*;
use wzvi::scalar::Scalar;

/// `impl Damped` of diagonal friction, and the schemes with their O parts.
macro_rules! damped {
    (
        $system:ty, per_state: $per_state:expr, matrix: $matrix:expr, diagonal_masses: $diagonal:expr,
        |$own:ident, $q:ident, $gamma:ident| $damping:expr,
        splittings: [$($splitting:ty),*], around: [$($around:ty),*]
    ) => {
        impl Damped for $system {
            const PER_STATE: bool = $per_state;
            const IS_MATRIX: bool = $matrix;
            const HAS_DIAGONAL_MASSES: bool = $diagonal;

            fn damping<S: Scalar>(&self, $q: &[S], $gamma: &mut [S]) {
                let $own = self;
                $damping
            }

            fn temperature(&self) -> Option<f64> {
                self.kt
            }
        }

        $(wzvi::__private::composition! {
            [impl wzvi::system::Discretized<$splitting> for $system]
            $splitting, Splitting<$splitting>, 2, "", []
        })*

        $(wzvi::__private::composition! {
            [impl wzvi::system::Discretized<Thermostat<$around>> for $system]
            Thermostat<$around>, Around<$around>, 1, "", []
        })*
    };
}

/// `p²/2m + k q²/2 + b q⁴/4`
#[hamiltonian(
    drift = |q, p| 0.5 * p * p / m + 0.5 * k * q * q + 0.25 * b * q.powi(4),
    embedding = [Verlet, Midpoint, Gauss<2>, Gauss<3>],
)]
#[derive(Clone, Debug)]
pub(crate) struct Oscillator {
    pub(crate) m: f64,
    pub(crate) k: f64,
    pub(crate) b: f64,
    /// Rate of the friction.
    pub(crate) gamma: f64,
    pub(crate) kt: Option<f64>,
}

damped! {
    Oscillator, per_state: false, matrix: false, diagonal_masses: true,
    |own, _q, gamma| gamma[0] = S::from_f64(own.gamma),
    splittings: [Baoab, Obabo], around: [Verlet, Midpoint, Gauss<2>, Gauss<3>]
}

/// Two coupled masses with a friction matrix.
#[hamiltonian(
    drift = |[x, y], [px, py]| {
        0.5 * (px * px / m + py * py / n) + k * (0.5 * (x * x + 2.0 * y * y) + 0.25 * (x - y).powi(4))
    },
    embedding = [Verlet, Midpoint],
)]
#[derive(Clone, Debug)]
pub(crate) struct Coupled {
    pub(crate) m: f64,
    pub(crate) n: f64,
    pub(crate) k: f64,
    pub(crate) damping: [[f64; 2]; 2],
    pub(crate) kt: Option<f64>,
}

damped! {
    Coupled, per_state: false, matrix: true, diagonal_masses: true,
    |own, _q, gamma| {
        for (i, row) in own.damping.iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                gamma[2 * i + j] = S::from_f64(*entry);
            }
        }
    },
    splittings: [Baoab, Obabo], around: [Midpoint]
}

/// Friction that depends on the place: `γ(q) = γ (1 + q²)`.
#[hamiltonian(drift = |q, p| 0.5 * p * p / m + 0.5 * q * q, embedding = [Verlet, Midpoint])]
#[derive(Clone, Debug)]
pub(crate) struct Rough {
    pub(crate) m: f64,
    pub(crate) gamma: f64,
    /// Makes the friction negative above `q = edge`.
    pub(crate) edge: f64,
    pub(crate) kt: Option<f64>,
}

damped! {
    Rough, per_state: true, matrix: false, diagonal_masses: true,
    |own, q, gamma| {
        let inside = q[0].less(S::from_f64(own.edge));
        let rate = (q[0] * q[0] + S::from_f64(1.0)) * own.gamma;
        gamma[0] = S::select(inside, rate, -rate);
    },
    splittings: [Baoab, Obabo], around: [Midpoint]
}

/// Two masses, with a friction matrix that depends on the place.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px / m + py * py / n) + 0.5 * k * (x * x + 2.0 * y * y),
    embedding = [Verlet, Midpoint],
)]
#[derive(Clone, Debug)]
pub(crate) struct RoughPlane {
    pub(crate) m: f64,
    pub(crate) n: f64,
    pub(crate) k: f64,
    pub(crate) kt: Option<f64>,
}

impl RoughPlane {
    /// `Γ` at a place: of rank one where `x = 0`.
    pub(crate) fn friction(x: f64, y: f64) -> [[f64; 2]; 2] {
        [[1.0 + x * x, 0.5 + 0.1 * y], [0.5 + 0.1 * y, 0.5 + 0.3 * y * y]]
    }
}

damped! {
    RoughPlane, per_state: true, matrix: true, diagonal_masses: true,
    |_own, q, gamma| {
        let one = S::from_f64(1.0);
        gamma[0] = one + q[0] * q[0];
        gamma[1] = one * 0.5 + q[1] * 0.1;
        gamma[2] = gamma[1];
        gamma[3] = one * 0.5 + q[1] * q[1] * 0.3;
    },
    splittings: [Baoab], around: [Midpoint]
}

/// A chain of any length, thermostatted at its first site only.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        (0..q.len()).map(|i| 0.5 * p[i] * p[i] + 0.5 * q[i] * q[i]).sum::<f64>()
            + (0..q.len() - 1).map(|i| 0.25 * (q[i + 1] - q[i]).powi(4)).sum::<f64>()
    },
    embedding = [Verlet, Midpoint],
)]
#[derive(Clone, Debug)]
pub(crate) struct Chain {
    pub(crate) gamma: f64,
    pub(crate) kt: Option<f64>,
}

damped! {
    Chain, per_state: false, matrix: false, diagonal_masses: true,
    |own, _q, gamma| {
        gamma.fill(S::from_f64(0.0));
        gamma[0] = S::from_f64(own.gamma);
    },
    splittings: [Baoab, Obabo], around: [Midpoint]
}

/// Multiplicative noise of its own beside the bath.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * q * q,
    noise = [|q, p| sigma * q],
    embedding = [Verlet, Midpoint],
)]
#[derive(Clone, Debug)]
pub(crate) struct Driven {
    pub(crate) sigma: f64,
    pub(crate) gamma: f64,
    pub(crate) kt: Option<f64>,
}

damped! {
    Driven, per_state: false, matrix: false, diagonal_masses: true,
    |own, _q, gamma| gamma[0] = S::from_f64(own.gamma),
    splittings: [Baoab, Obabo], around: [Midpoint]
}

/// Masses that are no diagonal matrix, and one rate, which may depend on the place: `γ (1 + s x²)`.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (a * px * px + 2.0 * b * px * py + c * py * py) + 0.5 * k * (x * x + y * y),
    embedding = [Verlet, Midpoint],
)]
#[derive(Clone, Debug)]
pub(crate) struct Linked {
    pub(crate) a: f64,
    pub(crate) b: f64,
    pub(crate) c: f64,
    pub(crate) k: f64,
    pub(crate) gamma: f64,
    pub(crate) kt: Option<f64>,
}

damped! {
    Linked, per_state: false, matrix: false, diagonal_masses: false,
    |own, _q, gamma| gamma.fill(S::from_f64(own.gamma)),
    splittings: [Baoab], around: [Midpoint]
}

/// The same with a rate that depends on the place.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (a * px * px + 2.0 * b * px * py + c * py * py) + 0.5 * k * (x * x + y * y),
    embedding = [Verlet, Midpoint],
)]
#[derive(Clone, Debug)]
pub(crate) struct RoughLinked {
    pub(crate) a: f64,
    pub(crate) b: f64,
    pub(crate) c: f64,
    pub(crate) k: f64,
    pub(crate) gamma: f64,
    pub(crate) kt: Option<f64>,
}

damped! {
    RoughLinked, per_state: true, matrix: false, diagonal_masses: false,
    |own, q, gamma| gamma.fill((q[0] * q[0] + S::from_f64(1.0)) * own.gamma),
    splittings: [Baoab], around: [Midpoint]
}

/// A wall at `q = 0`, where energies are undefined.
#[hamiltonian(drift = |q, p| 0.5 * p * p + q + 2.0 / q.sqrt(), embedding = Verlet)]
#[derive(Clone, Debug)]
pub(crate) struct Wall {
    pub(crate) gamma: f64,
    pub(crate) kt: Option<f64>,
}

damped! {
    Wall, per_state: false, matrix: false, diagonal_masses: true,
    |own, _q, gamma| gamma[0] = S::from_f64(own.gamma),
    splittings: [Baoab], around: []
}
