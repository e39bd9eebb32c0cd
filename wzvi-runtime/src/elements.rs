//! Systems of elements: what `#[hamiltonian]` generates for a phase space whose size it does not know, and the step
//! that is made of it.
//!
//! The unknowns are the increments `u = q_{i+1} - q_i` and `v = P - p_i` of the discrete Euler-Lagrange equations
//!
//! ```text
//! u = Σ_m c_m ∂H_m/∂p(P, Q_m),  v = -Σ_m (1 - l_m) c_m ∂H_m/∂q(P, Q_m),  Q_m = q_i + l_m u,  P = p_i + v
//! p_{i+1} - p_i = v - Σ_m l_m c_m ∂H_m/∂q(P, Q_m)
//! ```
//!
//! An implicit step iterates `x ← φ(x)` while that contracts by [`CONTRACTS`] or better, which for steps that are not
//! stiff is several times cheaper than Newton's method, and otherwise by Newton's method with the factors of an earlier
//! iteration as long as they contract as well. Either way it ends when each correction is at the rounding
//! of its unknown, or each equation at the rounding of its own terms, so that the choice changes the cost and no digit that
//! counts. Where neither converges the stepper solves the step with care.
//!
//! The linear equations of Newton's method are solved in the band that a renumbering of the unknowns leaves where that is
//! narrow or small ([`Method::Band`]: chains, rings, networks, anything of a hundred unknowns), else by GMRES from
//! products with the Jacobian, which is never stored ([`Method::Krylov`]: lattices, random graphs, all pairs).

mod careful;
mod iterate;
mod jacobian;
mod memory;
mod passes;
#[doc(hidden)]
pub mod places;
mod rounding;
#[doc(hidden)]
pub mod sites;

pub use iterate::{Scheme, Unknowns, advance};
pub use memory::{CompensationVec, Memory};

pub use crate::memory::{Iteration, Method};

use crate::error::{ConfigError, StepFailure};
use crate::scalar::Scalar;
use crate::state::{State, Vector};
use crate::system::{Hamiltonian, LagrangianGradient, Segment};

/// Fixed-point iterations and old factors are kept while corrections shrink to this fraction.
pub const CONTRACTS: f64 = 0.2;

/// Which Hamiltonians are summed up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Terms {
    /// The drift, weighted by the step size.
    pub drift: bool,
    /// The noises, weighted by their increments.
    pub noise: bool,
    /// The factor of the counter-term, weighted by products of increments; 0 for none.
    pub counter: f64,
    /// Whether slopes with respect to coordinates are wanted.
    pub by_q: bool,
    /// Whether slopes with respect to momenta are wanted.
    pub by_p: bool,
}

/// Where elements are evaluated.
#[derive(Clone, Copy, Debug)]
pub struct Point<'a, S> {
    /// Coordinates.
    pub q: &'a [S],
    /// Momenta.
    pub p: &'a [S],
    /// Time.
    pub t: f64,
    /// The weight of the drift.
    pub h: f64,
    /// The weights of the noises.
    pub dw: &'a [S],
}

/// Second derivatives of a sum of elements, entry by entry. Pairs of different variables come once.
pub trait Curvature<S> {
    /// `∂²/∂q_i ∂q_j`
    fn add_qq(&mut self, i: usize, j: usize, is_diagonal: bool, value: S);
    /// `∂²/∂q_i ∂p_j`
    fn add_qp(&mut self, i: usize, j: usize, is_diagonal: bool, value: S);
    /// `∂²/∂p_i ∂p_j`
    fn add_pp(&mut self, i: usize, j: usize, is_diagonal: bool, value: S);
}

/// A system whose Hamiltonians are sums of elements.
pub trait Elements: Hamiltonian {
    /// What the elements read and the compiler has not shown to be there.
    #[doc(hidden)]
    const PLACES: places::Places;

    /// A part of the list `table` of [`Elements::PLACES`], or of the list inside of it at the indices `outer`.
    #[doc(hidden)]
    fn entries(&self, table: usize, outer: &[usize], range: std::ops::Range<usize>) -> places::Entries;

    /// Adds the weighted slopes to `by_q` and `by_p`. All slices have the degrees of freedom that were checked.
    fn slopes<S: Scalar>(&self, terms: Terms, at: &Point<'_, S>, by_q: &mut [S], by_p: &mut [S]);

    /// Adds the weighted second derivatives.
    fn curvature<S: Scalar, C: Curvature<S>>(&self, terms: Terms, at: &Point<'_, S>, into: &mut C);
}

/// Whether a state of `got` degrees of freedom fits the system.
///
/// # Errors
/// [`StepFailure::Dimension`] if it does not, [`StepFailure::Index`] if an integer of the system is out of range.
pub fn check<H: Elements>(system: &H, got: usize) -> Result<(), StepFailure> {
    let expected = system.degrees();
    if expected != 0 && expected != got {
        return Err(StepFailure::Dimension { expected, got });
    }
    places::check(system, got)
}

/// The check that the making of a stepper does.
///
/// # Errors
/// [`ConfigError::Index`] if an index is out of range.
pub fn prepare<H: Elements>(system: &H) -> Result<(), ConfigError> {
    match system.degrees() {
        0 => Ok(()),
        degrees => {
            places::index_error(system, degrees).map_or(Ok(()), |error| Err(ConfigError::Index(error)))
        }
    }
}

/// `P` of the step between two states: the step is taken once more. NaN if that fails.
pub fn step_momentum<H: Elements>(
    system: &H,
    scheme: &Scheme,
    before: &State<H::Vector>,
    h: f64,
    dw: &[f64],
) -> H::Vector {
    let (mut q, mut p) = (before.q.clone(), before.p.clone());
    let mut memory = Memory::<f64>::default();
    let solved = advance::<H, f64, crate::carry::Plain, true>(
        system,
        scheme,
        before.t,
        h,
        q.components_mut(),
        p.components_mut(),
        dw,
        &mut memory,
        &mut crate::carry::Plain,
    );
    let momentum = p.components_mut();
    match (solved, memory.momentum()) {
        (Ok(_), Some(known)) => momentum.copy_from_slice(known),
        _ => momentum.fill(f64::NAN),
    }
    p
}

/// `L_d = P · (q_{i+1} - q_i) - Σ_m c_m H_m(P, Q_m)`, NaN if sizes do not fit.
pub fn discrete_lagrangian<H: Elements>(
    system: &H,
    scheme: &Scheme,
    segment: &Segment<H::Vector>,
    dw: &[f64],
) -> f64 {
    let (q0, q1, p) = (segment.q0.components(), segment.q1.components(), segment.p.components());
    if q0.len() != q1.len() || dw.len() != system.noises() {
        return f64::NAN;
    }
    let point =
        |l: f64| -> Vec<f64> { q0.iter().zip(q1).map(|(start, end)| start + l * (end - start)).collect() };
    let pairing: f64 = p.iter().zip(q0.iter().zip(q1)).map(|(p, (start, end))| p * (end - start)).sum();
    let time = |l: f64| segment.t + l * segment.h;
    let drift = system.evaluate(0, &point(scheme.drift_l), p, time(scheme.drift_l));
    let stage = point(scheme.noise_l);
    let noise: f64 = dw
        .iter()
        .enumerate()
        .map(|(k, dw)| dw * system.evaluate(k + 1, &stage, p, time(scheme.noise_l)))
        .sum();
    let counter = match scheme.counter {
        0.0 => 0.0,
        factor if check(system, q0.len()).is_ok() && p.len() == q0.len() => {
            let (mut force, mut velocity) = (vec![0.0; q0.len()], vec![0.0; q0.len()]);
            let at = Point { q: &stage, p, t: time(scheme.noise_l), h: segment.h, dw };
            let terms = Terms { drift: false, noise: true, counter: 0.0, by_q: true, by_p: true };
            system.slopes(terms, &at, &mut force, &mut velocity);
            factor * force.iter().zip(&velocity).map(|(force, velocity)| force * velocity).sum::<f64>()
        }
        _ => f64::NAN,
    };
    pairing - segment.h * drift - noise - counter
}

/// The gradient of [`discrete_lagrangian`], NaN if sizes do not fit.
pub fn discrete_lagrangian_gradient<H: Elements>(
    system: &H,
    scheme: &Scheme,
    segment: &Segment<H::Vector>,
    dw: &[f64],
) -> LagrangianGradient<H::Vector> {
    let (q0, q1, p) = (segment.q0.components(), segment.q1.components(), segment.p.components());
    let d = q0.len();
    let mut gradient =
        LagrangianGradient { q0: H::Vector::zeros(d), q1: H::Vector::zeros(d), p: H::Vector::zeros(d) };
    let fits = q1.len() == d && p.len() == d && dw.len() == system.noises() && check(system, d).is_ok();
    if !fits {
        for part in [&mut gradient.q0, &mut gradient.q1, &mut gradient.p] {
            part.components_mut().fill(f64::NAN);
        }
        return gradient;
    }
    for (_, l, terms) in iterate::stages(scheme) {
        let stage: Vec<f64> = q0.iter().zip(q1).map(|(start, end)| start + l * (end - start)).collect();
        let (mut by_q, mut by_p) = (vec![0.0; d], vec![0.0; d]);
        let at = Point { q: &stage, p, t: segment.t + l * segment.h, h: segment.h, dw };
        system.slopes(terms, &at, &mut by_q, &mut by_p);
        for i in 0..d {
            gradient.q0.components_mut()[i] -= (1.0 - l) * by_q[i];
            gradient.q1.components_mut()[i] -= l * by_q[i];
            gradient.p.components_mut()[i] -= by_p[i];
        }
    }
    for i in 0..d {
        gradient.q0.components_mut()[i] -= p[i];
        gradient.q1.components_mut()[i] += p[i];
        gradient.p.components_mut()[i] += q1[i] - q0[i];
    }
    gradient
}
