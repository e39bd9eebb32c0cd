//! What a stepper of a system of elements allocates, once.

use super::iterate::{Scheme, Unknowns};
use super::{Curvature, Elements, Iteration, Point, Terms};
use crate::carry::{Carry, Compensation};
use crate::error::StepFailure;
use crate::scalar::Scalar;
use crate::solve::Banded;

/// Numbers that a factorisation may hold: 2 GiB of `f64`.
const MOST_NUMBERS: usize = 1 << 28;

/// Vectors of one step, unknowns of the steps before, and the matrix.
#[derive(Clone, Debug)]
pub struct Memory<S> {
    pub(super) degrees: usize,
    pub(super) iteration: Iteration,
    pub(super) work: Work<S>,
    /// Unknowns of past steps, the latest first.
    pub(super) past: [Vec<S>; 3],
    pub(super) known: u8,
    pub(super) matrix: Option<Banded<S>>,
    /// Whether the matrix holds the factors of some iteration.
    pub(super) has_factors: bool,
}

/// Scratch of one step.
#[derive(Clone, Debug)]
pub(super) struct Work<S> {
    pub(super) x: Vec<S>,
    pub(super) correction: Vec<S>,
    pub(super) u: Vec<S>,
    pub(super) momentum: Vec<S>,
    pub(super) stage: [Vec<S>; 2],
    pub(super) by_q: [Vec<S>; 2],
    pub(super) by_p: Vec<S>,
    /// `∂u/∂v` where that is diagonal.
    pub(super) diagonal: Vec<S>,
}

impl<S> Default for Work<S> {
    fn default() -> Self {
        Self {
            x: Vec::new(),
            correction: Vec::new(),
            u: Vec::new(),
            momentum: Vec::new(),
            stage: [Vec::new(), Vec::new()],
            by_q: [Vec::new(), Vec::new()],
            by_p: Vec::new(),
            diagonal: Vec::new(),
        }
    }
}

impl<S> Default for Memory<S> {
    fn default() -> Self {
        Self {
            degrees: 0,
            iteration: Iteration::default(),
            work: Work::default(),
            past: [Vec::new(), Vec::new(), Vec::new()],
            known: 0,
            matrix: None,
            has_factors: false,
        }
    }
}

impl<S: Scalar> Memory<S> {
    /// The memory of a stepper: allocated at once if the system knows its size, else by the first step.
    pub fn new<H: Elements>(system: &H, scheme: &Scheme) -> Self {
        let mut memory = Self::default();
        let degrees = system.degrees();
        if degrees != 0 && super::check(system, degrees).is_ok() {
            memory.allocate(system, scheme, degrees);
        }
        memory
    }

    /// Pins how implicit steps are iterated.
    pub fn pin(&mut self, iteration: Iteration) {
        self.iteration = iteration;
    }

    /// Forgets past steps: they are no guide from another state.
    pub fn forget(&mut self) {
        self.known = 0;
        self.has_factors = false;
    }

    /// `P` of the last step.
    pub(super) fn momentum(&self) -> Option<&[S]> {
        (self.degrees != 0).then_some(&self.work.momentum)
    }

    /// Makes room for `degrees`, after checking that the indices of the system fit.
    pub(super) fn fit<H: Elements>(
        &mut self,
        system: &H,
        scheme: &Scheme,
        degrees: usize,
    ) -> Result<(), StepFailure> {
        super::check(system, degrees)?;
        self.allocate(system, scheme, degrees);
        Ok(())
    }

    fn allocate<H: Elements>(&mut self, system: &H, scheme: &Scheme, degrees: usize) {
        let zeros = |wanted: bool| vec![S::from_f64(0.0); if wanted { degrees } else { 0 }];
        let is_implicit = scheme.unknowns != Unknowns::None;
        let unknowns = match scheme.unknowns {
            Unknowns::None => 0,
            Unknowns::Momenta => degrees,
            Unknowns::Both => 2 * degrees,
        };
        let two_stages = scheme.drift_l != scheme.noise_l;
        self.work = Work {
            x: vec![S::from_f64(0.0); unknowns],
            correction: vec![S::from_f64(0.0); unknowns],
            u: zeros(true),
            momentum: zeros(true),
            stage: [zeros(true), zeros(two_stages)],
            by_q: [zeros(true), zeros(two_stages)],
            by_p: zeros(true),
            diagonal: zeros(scheme.unknowns == Unknowns::Momenta),
        };
        let past = || vec![S::from_f64(0.0); if scheme.remembers { unknowns } else { 0 }];
        self.past = [past(), past(), past()];
        (self.known, self.has_factors) = (0, false);
        self.degrees = degrees;
        self.matrix = if is_implicit { matrix(system, scheme, degrees, unknowns) } else { None };
    }
}

/// Room for the Jacobian, found by a sweep over the indices; `None` if it does not fit.
fn matrix<H: Elements, S: Scalar>(
    system: &H,
    scheme: &Scheme,
    degrees: usize,
    unknowns: usize,
) -> Option<Banded<S>> {
    let mut pattern = Pattern { both: scheme.unknowns == Unknowns::Both, pairs: Vec::new() };
    let zeros = vec![0.0; degrees];
    let dw = vec![0.0; system.noises()];
    let at = Point { q: &zeros, p: &zeros, t: 0.0, h: 1.0, dw: &dw };
    system.curvature(Terms { drift: true, noise: true, by_q: true, by_p: true }, &at, &mut pattern);
    pattern.pairs.sort_unstable();
    pattern.pairs.dedup();
    Banded::new(unknowns, &pattern.pairs, MOST_NUMBERS)
}

/// Which unknowns the Jacobian couples.
struct Pattern {
    both: bool,
    pairs: Vec<(usize, usize)>,
}

impl Pattern {
    fn add(&mut self, a: usize, b: usize) {
        if a != b {
            self.pairs.push((a.min(b), a.max(b)));
        }
    }
}

impl Curvature<f64> for Pattern {
    fn add_qq(&mut self, i: usize, j: usize, _: bool, _: f64) {
        if self.both {
            self.add(2 * i + 1, 2 * j);
            self.add(2 * j + 1, 2 * i);
        } else {
            self.add(i, j);
        }
    }
    fn add_qp(&mut self, i: usize, j: usize, _: bool, _: f64) {
        if self.both {
            self.add(2 * i + 1, 2 * j + 1);
            self.add(2 * j, 2 * i);
        } else {
            self.add(i, j);
        }
    }
    fn add_pp(&mut self, i: usize, j: usize, _: bool, _: f64) {
        if self.both {
            self.add(2 * i, 2 * j + 1);
            self.add(2 * j, 2 * i + 1);
        }
    }
}

/// [`Compensation`] of a size that is known at run time; empty until the first step.
#[derive(Clone, Debug, PartialEq)]
pub struct CompensationVec<S> {
    coordinates: Vec<S>,
    momenta: Vec<S>,
}

impl<S> Default for CompensationVec<S> {
    fn default() -> Self {
        Self { coordinates: Vec::new(), momenta: Vec::new() }
    }
}

impl<S: Scalar> Carry<S> for CompensationVec<S> {
    const CARRIES: bool = true;

    #[inline(always)]
    fn of_coordinate(&self, i: usize) -> S {
        self.coordinates.get(i).copied().unwrap_or(S::from_f64(0.0))
    }
    #[inline(always)]
    fn of_momentum(&self, i: usize) -> S {
        self.momenta.get(i).copied().unwrap_or(S::from_f64(0.0))
    }
    #[inline(always)]
    fn add(base: S, increment: S, carried: S) -> (S, S) {
        Compensation::<S, 1>::add(base, increment, carried)
    }
    fn keep(&mut self, coordinates: &[S], momenta: &[S]) {
        let zero = S::from_f64(0.0);
        self.coordinates.resize(coordinates.len(), zero);
        self.momenta.resize(momenta.len(), zero);
        self.coordinates.copy_from_slice(coordinates);
        self.momenta.copy_from_slice(momenta);
    }
}
