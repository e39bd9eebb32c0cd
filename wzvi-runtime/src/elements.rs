//! Systems of elements: what `#[hamiltonian]` generates for a phase space whose size it does not know, and the step
//! that is made of it.
//!
//! The compiler gives the discrete Lagrangian as a table of [`Stage`]s, each with the weights of `q_i` and `q_{i+1}` in its
//! coordinates and the parts of the step Hamiltonian that are evaluated there, and the derivatives of these parts. The
//! unknowns are the increments `u = q_{i+1} - q_i` and `v = P - p_i` of the discrete Euler-Lagrange equations
//!
//! ```text
//! L_d = P · u - Σ_s F_s(P, Q_s, T_s),  Q_s = q_i + c_s u,  T_s = t_i + c_s h,  P = p_i + v
//! ∂L_d/∂P = 0:        u = Σ_s ∂F_s/∂p
//! p_i = -D_1 L_d:     v = -Σ_s start_s ∂F_s/∂q
//! p_{i+1} = D_2 L_d:  p_{i+1} - p_i = v - Σ_s end_s ∂F_s/∂q
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
mod scheme;
#[doc(hidden)]
pub mod sites;

pub use iterate::{advance, step_momentum};
pub use memory::{CompensationVec, Memory};
pub use scheme::{MomentumUpdate, Scheme, Stage, Unknowns};

use std::ops::Range;

pub use crate::memory::{Iteration, Method};

use crate::error::{ConfigError, StepFailure};
use crate::scalar::Scalar;
use crate::state::{State, Vector};
use crate::system::{Hamiltonian, LagrangianGradient, Segment};

/// Fixed-point iterations and old factors are kept while corrections shrink to this fraction.
pub const CONTRACTS: f64 = 0.2;

/// By what slopes are wanted: what an element does not read costs nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slopes {
    /// By coordinates.
    pub by_q: bool,
    /// By momenta.
    pub by_p: bool,
}

impl Slopes {
    /// By all.
    pub const ALL: Self = Self { by_q: true, by_p: true };
    /// By coordinates. Elements that read both halves of the phase space add those by momenta, too.
    pub const BY_COORDINATES: Self = Self { by_q: true, by_p: false };
    /// By momenta. Elements that read both halves of the phase space add those by coordinates, too.
    pub const BY_MOMENTA: Self = Self { by_q: false, by_p: true };
}

/// Where elements are evaluated, and by what they are weighted.
#[derive(Clone, Debug)]
pub struct Point<'a, S> {
    /// Coordinates.
    pub q: &'a [S],
    /// Momenta.
    pub p: &'a [S],
    /// Time.
    pub t: f64,
    /// The increment of the drift.
    pub h: f64,
    /// The increments of the noises.
    pub dw: &'a [S],
    /// The noises that act, of those that have an increment.
    pub acting: Range<usize>,
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

/// The part that is the drift, `h H_0`.
const DRIFT: usize = 0;
/// The part that is the noises, `Σ_k ΔW_k H_k`.
const NOISE: usize = 1;

/// A system whose Hamiltonians are sums of elements.
///
/// Elements with one rule for their increments are a *part*: the drift (part 0), the noises (part 1), what a scheme adds to
/// them, and at last, for values only, the first integrals, from part [`Elements::INTEGRALS`] on. A part is weighted by
/// `weight` and by its increments.
pub trait Elements: Hamiltonian {
    /// What the elements read and the compiler has not shown to be there.
    #[doc(hidden)]
    const PLACES: places::Places;

    /// The part that is the first of the first integrals.
    const INTEGRALS: usize;

    /// A part of the list `table` of [`Elements::PLACES`], or of the list inside of it at the indices `outer`.
    #[doc(hidden)]
    fn entries(&self, table: usize, outer: &[usize], range: Range<usize>) -> places::Entries;

    /// The weighted value of a part; 0 for one that does not exist. All slices have the degrees of freedom that were
    /// checked.
    fn value<S: Scalar>(&self, part: usize, weight: f64, at: &Point<'_, S>) -> S;

    /// Adds the weighted slopes of a part to `by_q` and `by_p`.
    fn slopes<S: Scalar>(
        &self,
        part: usize,
        weight: f64,
        at: &Point<'_, S>,
        wanted: Slopes,
        by_q: &mut [S],
        by_p: &mut [S],
    );

    /// Adds the weighted second derivatives of a part. All noises act.
    fn curvature<S: Scalar, C: Curvature<S>>(
        &self,
        part: usize,
        weight: f64,
        at: &Point<'_, S>,
        wanted: Slopes,
        into: &mut C,
    );
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

/// Whether `q` and `p` are those of a state of the system.
fn fits<H: Elements, S>(system: &H, q: &[S], p: &[S]) -> bool {
    q.len() == p.len() && check(system, q.len()).is_ok()
}

/// The part that Hamiltonian `term` belongs to, and the noises of it that act.
fn part_of(term: usize) -> (usize, Range<usize>) {
    match term.checked_sub(1) {
        None => (DRIFT, 0..0),
        Some(noise) => (NOISE, noise..term),
    }
}

/// [`Hamiltonian::evaluate`]
pub fn evaluate<H: Elements, S: Scalar>(system: &H, term: usize, q: &[S], p: &[S], t: f64) -> S {
    if term > system.noises() || !fits(system, q, p) {
        return S::from_f64(f64::NAN);
    }
    let dw = vec![S::from_f64(1.0); term];
    let (part, acting) = part_of(term);
    system.value(part, 1.0, &Point { q, p, t, h: 1.0, dw: &dw, acting })
}

/// [`Hamiltonian::differentiate`]
pub fn differentiate<H: Elements, S: Scalar>(
    system: &H,
    term: usize,
    q: &[S],
    p: &[S],
    t: f64,
    by_q: &mut [S],
    by_p: &mut [S],
) {
    let is_known =
        term <= system.noises() && fits(system, q, p) && by_q.len() == q.len() && by_p.len() == q.len();
    let start = S::from_f64(if is_known { 0.0 } else { f64::NAN });
    by_q.fill(start);
    by_p.fill(start);
    if is_known {
        let dw = vec![S::from_f64(1.0); term];
        let (part, acting) = part_of(term);
        system.slopes(part, 1.0, &Point { q, p, t, h: 1.0, dw: &dw, acting }, Slopes::ALL, by_q, by_p);
    }
}

/// [`Hamiltonian::invariant`]
pub fn invariant<H: Elements>(system: &H, number: usize, state: &State<H::Vector>) -> f64 {
    let (q, p) = (state.q.components(), state.p.components());
    if number >= system.invariants() || !fits(system, q, p) {
        return f64::NAN;
    }
    let at = Point { q, p, t: state.t, h: 1.0, dw: &[], acting: 0..0 };
    system.value(H::INTEGRALS + number, 1.0, &at)
}

/// [`Hamiltonian::energy_rate`]
pub fn energy_rate<H: Elements>(system: &H, k: usize, state: &State<H::Vector>) -> f64 {
    if k >= system.noises() {
        return f64::NAN;
    }
    let (noise, drift) = (system.noise_gradient(k, state), system.energy_gradient(state));
    let dot = |a: &H::Vector, b: &H::Vector| -> f64 {
        a.components().iter().zip(b.components()).map(|(a, b)| a * b).sum()
    };
    dot(&noise.p, &drift.q) - dot(&noise.q, &drift.p)
}

/// What the discrete Lagrangian is evaluated at: a segment whose sizes were checked, and increments.
struct Evaluated<'a, V> {
    segment: &'a Segment<V>,
    dw: &'a [f64],
}

impl<'a, V: Vector> Evaluated<'a, V> {
    /// `None` if sizes do not fit.
    fn new<H: Elements>(system: &H, segment: &'a Segment<V>, dw: &'a [f64]) -> Option<Self> {
        let (q0, q1, p) = (segment.q0.components(), segment.q1.components(), segment.p.components());
        let fits = q1.len() == q0.len() && dw.len() == system.noises() && fits(system, q0, p);
        fits.then_some(Self { segment, dw })
    }

    /// `q_{i+1} - q_i`
    fn increment(&self) -> impl Iterator<Item = f64> {
        let ends = self.segment.q0.components().iter().zip(self.segment.q1.components());
        ends.map(|(start, end)| end - start)
    }

    /// Calls `take` with each part of the step Hamiltonian, its stage, its weight and its point.
    fn for_each(&self, scheme: &Scheme, mut take: impl FnMut(usize, &Stage, f64, &Point<'_, f64>)) {
        let Segment { q0, p, t, h, .. } = self.segment;
        for stage in scheme.stages {
            let q: Vec<f64> =
                q0.components().iter().zip(self.increment()).map(|(q, u)| q + stage.point * u).collect();
            let (t, acting) = (t + stage.point * h, 0..self.dw.len());
            let at = Point { q: &q, p: p.components(), t, h: *h, dw: self.dw, acting };
            stage.parts.iter().for_each(|&(part, weight)| take(part, stage, weight, &at));
        }
    }
}

/// `L_d = P · (q_{i+1} - q_i) - F`, NaN if sizes do not fit.
pub fn discrete_lagrangian<H: Elements>(
    system: &H,
    scheme: &Scheme,
    segment: &Segment<H::Vector>,
    dw: &[f64],
) -> f64 {
    let Some(evaluated) = Evaluated::new(system, segment, dw) else { return f64::NAN };
    let mut value: f64 = segment.p.components().iter().zip(evaluated.increment()).map(|(p, u)| p * u).sum();
    evaluated.for_each(scheme, |part, _, weight, at| value -= system.value(part, weight, at));
    value
}

/// The gradient of [`discrete_lagrangian`], NaN if sizes do not fit.
pub fn discrete_lagrangian_gradient<H: Elements>(
    system: &H,
    scheme: &Scheme,
    segment: &Segment<H::Vector>,
    dw: &[f64],
) -> LagrangianGradient<H::Vector> {
    let Some(evaluated) = Evaluated::new(system, segment, dw) else {
        let d = segment.q0.components().len();
        let nan = || {
            let mut nan = H::Vector::zeros(d);
            nan.components_mut().fill(f64::NAN);
            nan
        };
        return LagrangianGradient { q0: nan(), q1: nan(), p: nan() };
    };
    let mut gradient =
        LagrangianGradient { q0: segment.p.clone(), q1: segment.p.clone(), p: segment.q1.clone() };
    let [by_start, by_end, by_momentum] =
        [&mut gradient.q0, &mut gradient.q1, &mut gradient.p].map(Vector::components_mut);
    by_start.iter_mut().for_each(|p| *p = -*p);
    by_momentum.iter_mut().zip(evaluated.increment()).for_each(|(by_p, u)| *by_p = u);
    let mut force = vec![0.0; by_start.len()];
    let mut velocity = force.clone();
    evaluated.for_each(scheme, |part, stage, weight, at| {
        force.fill(0.0);
        velocity.fill(0.0);
        system.slopes(part, weight, at, Slopes::ALL, &mut force, &mut velocity);
        for i in 0..force.len() {
            by_start[i] -= stage.start * force[i];
            by_end[i] -= stage.end * force[i];
            by_momentum[i] -= velocity[i];
        }
    });
    gradient
}
