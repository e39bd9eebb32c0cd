//! The memory of a stepper of a system of elements, allocated once.

use super::costs::Costs;
use super::differentiate::ScalarSolution;
use super::factor_cache::FactorCache;
use super::jacobian::{VisitEntry, pattern};
use super::lanes::is_in_lanes;
use super::linear::LinearSolver;
use super::low_rank::RankOneTerms;
use super::past::PastUnknowns;
use super::preference::Preference;
use super::rounding::Rounding;
use super::tiles::{LEAST_IN_TILES, TilePlan, TiledSweeps, takes_tiles};
use super::{Elements, PairColumns, Quadrature, Unknowns};
use crate::algebra::memory::{Iteration, MemoryRequest, Method, SolverReport, StepMemory, Threads};
use crate::algebra::scalar::Scalar;
use crate::algebra::solve::NewtonScratch;
use crate::error::StepFailure;
use crate::ground::numbers::numbers;

/// Vectors of one step, unknowns of past steps, and the matrix.
#[derive(Default)]
pub struct LoopMemory<S: Scalar> {
    pub(super) degrees: usize,
    /// Number of unknowns that are remembered of each step.
    remembered: usize,
    pub(super) work: StepScratch<S>,
    pub(super) solver: IterationMemory<S>,
    /// The tiles of explicit steps of a large system.
    pub(super) plan: TilePlan,
    /// The values of implicit steps in numbers with derivatives.
    pub(super) values: Option<Box<ScalarSolution<S>>>,
}

/// The data of the iteration that outlast a step.
#[derive(Default)]
pub(super) struct IterationMemory<S: Scalar> {
    pub(super) iteration: Iteration,
    /// `∂u/∂v` where that is diagonal.
    pub(super) diagonal: Vec<S>,
    pub(super) past: PastUnknowns<S>,
    pub(super) preference: Preference,
    pub(super) costs: Costs,
    pub(super) linear: Option<LinearSolver<S>>,
    pub(super) kept: FactorCache<S>,
    pub(super) rounding: Option<Box<Rounding>>,
    /// The tiles of the fixed point of a large system.
    pub(super) sweeps: Option<Box<TiledSweeps>>,
    pub(super) care: CarefulScratch<S>,
}

/// The scratch of a careful step.
#[derive(Debug, Default)]
pub(super) struct CarefulScratch<S> {
    pub(super) start: Vec<S>,
    /// Marks of the equations that are solved to rounding.
    pub(super) are_settled: Vec<bool>,
    pub(super) room: NewtonScratch<Vec<S>>,
}

/// Scratch for the equations of one step: a single list, because the compiler knows only of parts of one list
/// that they do not overlap.
#[derive(Debug, Default)]
pub(super) struct StepScratch<S> {
    numbers: Vec<S>,
    columns: PairColumns,
}

/// The parts of a [`StepScratch`], with lengths that follow from the system, so that loops over several of
/// them need no bounds checks.
pub(super) struct StepLists<'a, S> {
    pub(super) x: &'a mut [S],
    pub(super) correction: &'a mut [S],
    /// The previous correction.
    pub(super) previous: &'a mut [S],
    pub(super) u: &'a mut [S],
    pub(super) momentum: &'a mut [S],
    /// Derivatives by momenta; where `u` follows from `v`, the `u` before the correction.
    pub(super) by_p: &'a mut [S],
    pub(super) stages: StageVectors<'a, S>,
    pub(super) columns: &'a mut PairColumns,
}

/// The coordinates of each stage, and the derivatives by them.
pub(super) struct StageVectors<'a, S> {
    numbers: &'a mut [S],
    degrees: usize,
    /// Whether the two lists of each stage are exchanged.
    is_turned: bool,
}

/// Padding between two lists of a large system, in numbers: simultaneous reads and writes then have different
/// offsets within a page, the last bits of an address, which processors compare first.
#[cfg_attr(not(debug_assertions), inline(always))]
fn padding(degrees: usize) -> usize {
    if degrees < LEAST_IN_TILES { 0 } else { 40 }
}

/// The first `length` numbers, and those after a padding of `apart`.
#[cfg_attr(not(debug_assertions), inline(always))]
fn split_padded<S>(numbers: &mut [S], length: usize, apart: usize) -> (&mut [S], &mut [S]) {
    let (list, rest) = numbers.split_at_mut(length + apart);
    (&mut list[..length], rest)
}

impl<S: Scalar> StepScratch<S> {
    /// Scratch for a system with this number of degrees of freedom.
    pub(super) fn new(scheme: &Quadrature, degrees: usize) -> Self {
        debug_assert!(!scheme.stages.is_empty(), "a discrete Lagrangian has a quadrature point");
        let numbers = vec![S::from_f64(0.0); Self::length(scheme, degrees)];
        Self { numbers, columns: PairColumns::default() }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn length(scheme: &Quadrature, degrees: usize) -> usize {
        let apart = (6 + 2 * scheme.stages.len()) * padding(degrees);
        3 * scheme.unknowns.count(degrees) + (3 + 2 * scheme.stages.len()) * degrees + apart
    }

    /// Whether it was made for such a system.
    pub(super) fn fits(&self, scheme: &Quadrature, degrees: usize) -> bool {
        self.numbers.len() == Self::length(scheme, degrees)
    }

    /// Its parts for the scheme and the degrees of freedom that it was made for.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn lists(&mut self, scheme: &Quadrature, degrees: usize) -> StepLists<'_, S> {
        let unknowns = scheme.unknowns.count(degrees);
        let Self { numbers, columns } = self;
        let numbers = &mut numbers[..Self::length(scheme, degrees)];
        let apart = padding(degrees);
        let (x, numbers) = split_padded(numbers, unknowns, apart);
        let (correction, numbers) = split_padded(numbers, unknowns, apart);
        let (previous, numbers) = split_padded(numbers, unknowns, apart);
        let (u, numbers) = split_padded(numbers, degrees, apart);
        let (momentum, numbers) = split_padded(numbers, degrees, apart);
        let (by_p, numbers) = split_padded(numbers, degrees, apart);
        StepLists {
            x,
            correction,
            previous,
            u,
            momentum,
            by_p,
            stages: StageVectors { numbers, degrees, is_turned: false },
            columns,
        }
    }
}

impl<S: Scalar> StepLists<'_, S> {
    /// The lists in numbers `f64`, if their numbers are `f64`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn plain(&mut self) -> Option<StepLists<'_, f64>> {
        let Self { x, correction, previous, u, momentum, by_p, stages, columns } = self;
        let StageVectors { numbers, degrees, is_turned } = stages;
        let stages =
            StageVectors { numbers: S::as_f64s_mut(numbers)?, degrees: *degrees, is_turned: *is_turned };
        Some(StepLists {
            x: S::as_f64s_mut(x)?,
            correction: S::as_f64s_mut(correction)?,
            previous: S::as_f64s_mut(previous)?,
            u: S::as_f64s_mut(u)?,
            momentum: S::as_f64s_mut(momentum)?,
            by_p: S::as_f64s_mut(by_p)?,
            stages,
            columns,
        })
    }
}

impl<S> StepLists<'_, S> {
    /// A copy of the references for a separate function: values whose address is passed do not stay in
    /// registers.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn lend(&mut self) -> StepLists<'_, S> {
        let Self { x, correction, previous, u, momentum, by_p, stages, columns } = self;
        let stages = StageVectors { numbers: stages.numbers, ..*stages };
        StepLists { x, correction, previous, u, momentum, by_p, stages, columns }
    }
}

impl<S> StageVectors<'_, S> {
    /// The start of a stage, and the distance from its coordinates to the derivatives by them.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn bounds(&self, stage: usize) -> (usize, usize) {
        let stride = self.degrees + padding(self.degrees);
        (2 * stride * stage, stride)
    }

    /// The coordinates of a stage, and the derivatives by them.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn at(&self, stage: usize) -> (&[S], &[S]) {
        let (start, stride) = self.bounds(stage);
        let (first, second) = self.numbers[start..][..2 * stride].split_at(stride);
        let (first, second) = (&first[..self.degrees], &second[..self.degrees]);
        if self.is_turned { (second, first) } else { (first, second) }
    }

    /// The numbers of a stage, to be written.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn at_mut(&mut self, stage: usize) -> (&mut [S], &mut [S]) {
        let (start, stride) = self.bounds(stage);
        let (first, second) = self.numbers[start..][..2 * stride].split_at_mut(stride);
        let (first, second) = (&mut first[..self.degrees], &mut second[..self.degrees]);
        if self.is_turned { (second, first) } else { (first, second) }
    }

    /// Exchanges the two lists of each stage.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn turn(&mut self) {
        self.is_turned = !self.is_turned;
    }
}

/// The parts of a [`LoopMemory`] that the solution of a step reads and writes.
pub(super) struct LoopScratch<'a, S: Scalar> {
    pub(super) lists: StepLists<'a, S>,
    pub(super) solver: &'a mut IterationMemory<S>,
    pub(super) known: u8,
    /// The threads that share the tiles.
    pub(super) threads: Threads,
    /// Whether vector instructions are ruled out.
    pub(super) is_exact: bool,
}

impl<S: Scalar> LoopMemory<S> {
    /// Scratch for the scheme and the degrees of freedom of this memory; with past steps where the iteration
    /// starts from them.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn scratch(&mut self, scheme: &Quadrature, degrees: usize) -> LoopScratch<'_, S> {
        let Self { work, solver, plan, .. } = self;
        let known = if scheme.remembers { solver.past.known } else { 0 };
        LoopScratch {
            lists: work.lists(scheme, degrees),
            solver,
            known,
            threads: plan.threads(),
            is_exact: false,
        }
    }

    /// Records the unknowns of a successful step.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn record(&mut self, scheme: &Quadrature, degrees: usize) {
        let StepLists { x, .. } = self.work.lists(scheme, degrees);
        self.solver.past.record(x);
    }
}

impl<S: Scalar> LoopScratch<'_, S> {
    /// The inverse of the Jacobian, if that is a diagonal matrix.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn inverses(&self) -> Option<&[S]> {
        if let Some(LinearSolver::Band(band)) = &self.solver.linear { band.inverses() } else { None }
    }

    /// Extrapolates the unknowns of past steps: `3x_n - 3x_{n-1} + x_{n-2}`, to a lower order if fewer are
    /// `known`, zero if none are.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn guess(&mut self, known: u8) {
        let x = &mut *self.lists.x;
        if known == 0 {
            return x.fill(S::from_f64(0.0));
        }
        let [a, b, c] = self.solver.past.lists.each_ref().map(|past| &past[..x.len()]);
        match known {
            1 => x.copy_from_slice(a),
            2 => {
                for (x, (&a, &b)) in x.iter_mut().zip(a.iter().zip(b)) {
                    *x = a * 2.0 - b;
                }
            }
            _ => {
                for (x, ((&a, &b), &c)) in x.iter_mut().zip(a.iter().zip(b).zip(c)) {
                    *x = (a - b) * 3.0 + c;
                }
            }
        }
    }
}

impl<S: Scalar> LoopScratch<'_, S> {
    /// As [`StepLists::lend`].
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn lend(&mut self) -> LoopScratch<'_, S> {
        LoopScratch { lists: self.lists.lend(), solver: self.solver, ..*self }
    }
}

/// Shows the data of earlier steps; scratch is meaningless outside its step.
impl<S: Scalar> std::fmt::Debug for LoopMemory<S> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { degrees, solver: IterationMemory { iteration, past, preference, .. }, .. } = self;
        formatter
            .debug_struct("LoopMemory")
            .field("degrees", degrees)
            .field("iteration", iteration)
            .field("past", past)
            .field("preference", preference)
            .finish_non_exhaustive()
    }
}

/// Copies the data of earlier steps; the copy allocates its own scratch at its first use.
impl<S: Scalar> Clone for LoopMemory<S> {
    fn clone(&self) -> Self {
        let mut copy = Self { plan: self.plan.alike(), ..Self::default() };
        copy.clone_from(self);
        copy
    }

    /// Copies the data of earlier steps and keeps its own allocations.
    fn clone_from(&mut self, other: &Self) {
        self.solver.past.copy(&other.solver.past);
        (self.solver.iteration, self.solver.preference) = (other.solver.iteration, other.solver.preference);
        self.solver.kept.clone_from(&other.solver.kept);
    }
}

numbers! {
    impl[S: Scalar] Numbers for LoopMemory<S> {
        kept: solver, values; fixed: plan; scratch: degrees, remembered, work
    }
}

numbers! {
    impl[S: Scalar] Numbers for IterationMemory<S> {
        kept: past, preference, kept; fixed: iteration; scratch: diagonal, costs, linear, rounding, sweeps, care
    }
}

/// By hand, as requests and copies are none of the parts: see `step_memory!`.
impl<S: Scalar> StepMemory for LoopMemory<S> {
    fn tell(&mut self, request: &MemoryRequest) {
        if let Some(values) = &mut self.values {
            values.memory.tell(request);
        }
        match request {
            MemoryRequest::Forget => {
                self.solver.past.known = 0;
                self.solver.preference = Preference::default();
                self.solver.kept.forget();
            }
            MemoryRequest::Hold => self.solver.past.known = self.solver.past.known.min(1),
            MemoryRequest::Pin(iteration) => self.solver.iteration = *iteration,
            MemoryRequest::Share(threads) => {
                self.plan.share(*threads);
                self.solver.sweeps = None;
            }
            MemoryRequest::Derivatives(_) => {}
        }
    }

    fn allows_lanes(&self) -> bool {
        self.solver.preference == Preference::default() && !self.solver.kept.may_serve()
    }

    fn adopt(&mut self, left: Self) {
        (self.solver.past, self.solver.preference) = (left.solver.past, left.solver.preference);
        if self.degrees == 0 {
            (self.degrees, self.remembered) = (left.degrees, left.remembered);
            (self.work, self.solver.linear, self.solver.costs) =
                (left.work, left.solver.linear, left.solver.costs);
            (self.solver.diagonal, self.solver.kept) = (left.solver.diagonal, left.solver.kept);
        } else {
            self.solver.kept.clone_from(&left.solver.kept);
        }
        let past = &mut self.solver.past;
        if self.remembered == 0 {
            past.known = 0;
        }
        if past.known == 0 && past.lists[0].len() != self.remembered {
            past.resize(self.remembered);
        }
    }

    fn hand_values(&mut self, to: &mut Self, are_solved: bool) {
        std::mem::swap(&mut self.values, &mut to.values);
        if let Some(values) = &mut to.values {
            values.are_solved = are_solved;
        }
    }

    fn report(&self) -> SolverReport {
        let method = match &self.solver.linear {
            _ if self.degrees == 0 => Method::Undecided,
            None => Method::Explicit,
            Some(linear) => linear.method(),
        };
        let linear_work = self.solver.kept.work;
        SolverReport { pinned: self.solver.iteration, method: Some(method), linear_work }
    }
}

impl<S: Scalar> LoopMemory<S> {
    /// The memory of a stepper: allocated at once if the system knows its size, else by the first step.
    pub fn new<H: Elements>(system: &H, scheme: &Quadrature) -> Self {
        let mut memory = Self::default();
        let degrees = system.degrees();
        if degrees != 0 && super::check(system, degrees).is_ok() {
            memory.allocate(system, scheme, degrees);
        }
        memory
    }

    /// Whether the memory is allocated for a state with this number of degrees of freedom, and thus checked.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn fits<H: Elements>(&self, system: &H, degrees: usize) -> bool {
        super::is_sized(system, self.degrees, degrees)
    }

    /// Allocates for `degrees`, after checking that the indices of the system are in range.
    #[cold]
    #[inline(never)]
    pub(super) fn fit<H: Elements>(
        &mut self,
        system: &H,
        scheme: &Quadrature,
        degrees: usize,
    ) -> Result<(), StepFailure> {
        super::check(system, degrees)?;
        self.allocate(system, scheme, degrees);
        Ok(())
    }

    fn allocate<H: Elements>(&mut self, system: &H, scheme: &Quadrature, degrees: usize) {
        let has_room_in_tiles =
            H::FACTS.has_tiles && S::as_f64s(&[]).is_some() && takes_tiles(scheme, degrees);
        self.work =
            if has_room_in_tiles { StepScratch::default() } else { StepScratch::new(scheme, degrees) };
        self.solver.diagonal = vec![S::from_f64(0.0); scheme.unknowns.diagonals(degrees)];
        (self.solver.rounding, self.plan, self.solver.sweeps) = (None, self.plan.alike(), None);
        let unknowns = scheme.unknowns.count(degrees);
        let is_implicit = scheme.unknowns != Unknowns::None;
        let remembered = if scheme.remembers { unknowns } else { 0 };
        self.remembered = remembered;
        // A copy already has its past.
        let past = &mut self.solver.past;
        if past.known == 0 || past.lists[0].len() != unknowns {
            *past = PastUnknowns::default();
            past.resize(remembered);
        }
        self.degrees = degrees;
        self.solver.kept.lose();
        let pattern = |visit: VisitEntry<'_>| pattern(system, scheme, degrees, visit);
        // Counted before the matrix is allocated: the pattern needs room of its own.
        let entries = if is_implicit { entries(&pattern) } else { 0 };
        if const { is_in_lanes::<S>() } {
            // Lanes have no factors, and take the decisions of a path alone.
            let linear = is_implicit.then(|| linear::<H, f64>(&pattern, scheme, degrees));
            self.solver.costs = Costs::of(entries, unknowns, linear.as_ref());
        } else {
            let has_factors = is_implicit && !scheme.takes_values_first::<S>();
            self.solver.linear = has_factors.then(|| linear::<H, S>(&pattern, scheme, degrees));
            self.solver.costs = Costs::of(entries, unknowns, self.solver.linear.as_ref());
        }
    }
}

/// The solver of the linear equations of a scheme.
fn linear<H: Elements, S: Scalar>(
    pattern: &dyn Fn(VisitEntry<'_>),
    scheme: &Quadrature,
    degrees: usize,
) -> LinearSolver<S> {
    let unknowns = scheme.unknowns.count(degrees);
    LinearSolver::new(pattern, unknowns, RankOneTerms::new::<H>(scheme, degrees))
}

/// How many entries a pattern has.
fn entries(pattern: &dyn Fn(VisitEntry<'_>)) -> usize {
    let mut entries = 0;
    pattern(&mut |_, _| entries += 1);
    entries
}
