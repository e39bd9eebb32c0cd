//! What a stepper of a system of elements allocates, once.

use super::jacobian::{Linear, pattern};
use super::rounding::Rounding;
use super::{Elements, Scheme, Unknowns};
use crate::carry::{Carry, Compensation};
use crate::error::StepFailure;
use crate::memory::{Iteration, Method, StepMemory};
use crate::numbers::{Numbers, Tape};
use crate::scalar::Scalar;
use crate::solve::{Banded, Krylov, reverse_cuthill_mckee};

/// Numbers that a factorisation may hold: 2 GiB of `f64`.
const MOST_NUMBERS: usize = 1 << 28;

/// A band is taken if it is this narrow, or if it is factored by [`FEW_OPERATIONS`].
const NARROW: usize = 16;
/// Half a bandwidth up to which the order of the unknowns is kept.
const NARROW_AS_IT_IS: usize = 4;
/// Multiplications that are about as many as some iterations on products with the matrix need.
const FEW_OPERATIONS: usize = 1 << 22;
/// Entries per unknown of a pattern that is worth a renumbering.
const SPARSE: usize = 64;

/// Vectors of one step, unknowns of the steps before, and the matrix.
pub struct Memory<S> {
    pub(super) degrees: usize,
    pub(super) iteration: Iteration,
    pub(super) work: Work<S>,
    /// Unknowns of past steps, the latest first.
    pub(super) past: [Vec<S>; 3],
    pub(super) known: u8,
    /// Whether the fixed point contracted too slowly in the last step.
    pub(super) prefers_newton: bool,
    pub(super) linear: Option<Linear<S>>,
    /// The step size of factors that no state enters.
    pub(super) factored: Option<f64>,
    pub(super) rounding: Option<Box<Rounding>>,
}

/// Scratch of one step.
#[derive(Debug)]
pub(super) struct Work<S> {
    pub(super) x: Vec<S>,
    pub(super) correction: Vec<S>,
    /// The correction before.
    pub(super) previous: Vec<S>,
    pub(super) u: Vec<S>,
    pub(super) momentum: Vec<S>,
    pub(super) stages: Vec<Staged<S>>,
    pub(super) by_p: Vec<S>,
    /// `∂u/∂v` where that is diagonal.
    pub(super) diagonal: Vec<S>,
}

/// The coordinates of a stage, and the slopes by them.
#[derive(Clone, Debug)]
pub(super) struct Staged<S> {
    pub(super) q: Vec<S>,
    pub(super) by_q: Vec<S>,
}

impl<S> Default for Work<S> {
    fn default() -> Self {
        Self {
            x: Vec::new(),
            correction: Vec::new(),
            previous: Vec::new(),
            u: Vec::new(),
            momentum: Vec::new(),
            stages: Vec::new(),
            by_p: Vec::new(),
            diagonal: Vec::new(),
        }
    }
}

impl<S: Scalar> Work<S> {
    /// Scratch for the equations of a step of a system of so many degrees of freedom.
    pub(super) fn of_equations(scheme: &Scheme, degrees: usize) -> Self {
        debug_assert!(!scheme.stages.is_empty(), "a discrete Lagrangian has a quadrature point");
        let zeros = |length: usize| vec![S::from_f64(0.0); length];
        let unknowns = match scheme.unknowns {
            Unknowns::None => 0,
            Unknowns::Momenta => degrees,
            Unknowns::Both => 2 * degrees,
        };
        let staged = Staged { q: zeros(degrees), by_q: zeros(degrees) };
        Self {
            x: zeros(unknowns),
            correction: zeros(unknowns),
            previous: Vec::new(),
            u: zeros(degrees),
            momentum: zeros(degrees),
            stages: vec![staged; scheme.stages.len()],
            by_p: zeros(degrees),
            diagonal: Vec::new(),
        }
    }

    /// Scratch for their solution.
    pub(super) fn of_solution(scheme: &Scheme, degrees: usize) -> Self {
        let mut work = Self::of_equations(scheme, degrees);
        work.previous.clone_from(&work.correction);
        if scheme.unknowns == Unknowns::Momenta {
            work.diagonal.clone_from(&work.u);
        }
        work
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
            prefers_newton: false,
            linear: None,
            factored: None,
            rounding: None,
        }
    }
}

/// What the steps before left: scratch says nothing to anyone but the step that fills it.
impl<S: Scalar> std::fmt::Debug for Memory<S> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            degrees,
            iteration,
            past,
            known,
            prefers_newton,
            work: _,
            linear: _,
            factored: _,
            rounding: _,
        } = self;
        formatter
            .debug_struct("Memory")
            .field("degrees", degrees)
            .field("iteration", iteration)
            .field("past", &&past[..usize::from(*known).min(past.len())])
            .field("known", known)
            .field("prefers_newton", prefers_newton)
            .finish_non_exhaustive()
    }
}

/// What the steps before left; scratch is allocated anew where the copy is used.
impl<S: Scalar> Clone for Memory<S> {
    fn clone(&self) -> Self {
        let past = if self.known == 0 { Default::default() } else { self.past.clone() };
        let (iteration, known, prefers_newton) = (self.iteration, self.known, self.prefers_newton);
        Self { iteration, past, known, prefers_newton, ..Self::default() }
    }

    /// Keeps what is allocated.
    fn clone_from(&mut self, other: &Self) {
        if other.known > 0 {
            self.past.clone_from(&other.past);
        }
        (self.iteration, self.known, self.prefers_newton) =
            (other.iteration, other.known, other.prefers_newton);
    }
}

impl<S: Scalar> Numbers for Memory<S> {
    fn pass(&mut self, tape: &mut Tape) {
        let unknowns = tape.length(if self.known == 0 { 0 } else { self.past[0].len() });
        tape.count(&mut self.known);
        tape.flag(&mut self.prefers_newton);
        if unknowns != 0 {
            for past in &mut self.past {
                past.resize(unknowns, S::from_f64(0.0));
                past.iter_mut().for_each(|number| number.pass(tape));
            }
        }
    }
}

impl<S: Scalar> StepMemory for Memory<S> {
    fn pin(&mut self, iteration: Iteration) {
        self.iteration = iteration;
    }

    fn pinned(&self) -> Iteration {
        self.iteration
    }

    fn forget(&mut self) {
        self.known = 0;
        self.prefers_newton = false;
    }

    fn adopt(&mut self, left: Self) {
        (self.past, self.known, self.prefers_newton) = (left.past, left.known, left.prefers_newton);
        if self.degrees == 0 {
            (self.degrees, self.work, self.linear) = (left.degrees, left.work, left.linear);
            self.factored = left.factored;
        }
        let unknowns = self.work.x.len();
        if self.known == 0 && self.past[0].len() != unknowns {
            self.past.iter_mut().for_each(|past| past.resize(unknowns, S::from_f64(0.0)));
        }
    }

    fn method(&self) -> Option<Method> {
        Some(match &self.linear {
            _ if self.degrees == 0 => Method::Undecided,
            None => Method::Explicit,
            Some(Linear::Band(band)) => Method::Band { half_width: band.half_width() },
            Some(Linear::Krylov(_)) => Method::Krylov,
        })
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
        self.work = Work::of_solution(scheme, degrees);
        self.rounding = None;
        let unknowns = self.work.x.len();
        let is_implicit = scheme.unknowns != Unknowns::None;
        let remembered = if scheme.remembers { unknowns } else { 0 };
        // A copy comes with its past.
        if self.past[0].len() != remembered {
            let past = || vec![S::from_f64(0.0); remembered];
            self.past = [past(), past(), past()];
            self.known = 0;
        }
        self.degrees = degrees;
        self.factored = None;
        self.linear = is_implicit.then(|| linear(system, scheme, degrees, unknowns));
    }
}

/// A band if it is narrow or small, after a renumbering where that pays; else a basis for products with the matrix.
fn linear<H: Elements, S: Scalar>(system: &H, scheme: &Scheme, degrees: usize, unknowns: usize) -> Linear<S> {
    let krylov = || Linear::Krylov(Krylov::new(unknowns));
    // Derivatives that a number carries are not orthogonal to anything.
    let is_plain = size_of::<S>() == size_of::<f64>();
    let is_cheap = |half: usize| {
        half <= NARROW || unknowns.saturating_mul(half).saturating_mul(half) <= FEW_OPERATIONS || !is_plain
    };
    let (mut natural, mut entries) = (0_usize, 0_usize);
    pattern(system, scheme, degrees, |row, column| {
        natural = natural.max(row.abs_diff(column));
        entries += 1;
    });
    let band = |half: usize, position: Vec<usize>| {
        let band = is_cheap(half).then(|| Banded::new(unknowns, half, position, MOST_NUMBERS)).flatten();
        band.map_or_else(krylov, Linear::Band)
    };
    if natural <= NARROW_AS_IT_IS || entries > SPARSE.saturating_mul(unknowns) {
        return band(natural, Vec::new());
    }
    let mut pairs = Vec::with_capacity(entries / 2);
    pattern(system, scheme, degrees, |row, column| {
        if row < column {
            pairs.push((row, column));
        }
    });
    pairs.sort_unstable();
    pairs.dedup();
    let position = reverse_cuthill_mckee(unknowns, &pairs);
    let half = pairs.iter().map(|&(a, b)| position[a].abs_diff(position[b])).max().unwrap_or(0);
    if half < natural { band(half, position) } else { band(natural, Vec::new()) }
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
    type Part<const D: usize> = Compensation<S, D>;
    #[inline(always)]
    fn part<const D: usize>(&self, first: usize) -> Compensation<S, D> {
        Compensation::of(self, first)
    }
    fn keep(&mut self, coordinates: &[S], momenta: &[S]) {
        let zero = S::from_f64(0.0);
        self.coordinates.resize(coordinates.len(), zero);
        self.momenta.resize(momenta.len(), zero);
        self.coordinates.copy_from_slice(coordinates);
        self.momenta.copy_from_slice(momenta);
    }
}

impl<S: Scalar> Numbers for CompensationVec<S> {
    fn pass(&mut self, tape: &mut Tape) {
        for list in [&mut self.coordinates, &mut self.momenta] {
            let length = tape.length(list.len());
            list.resize(length, S::from_f64(0.0));
            list.iter_mut().for_each(|number| number.pass(tape));
        }
    }
}
