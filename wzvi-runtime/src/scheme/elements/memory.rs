//! The memory of a stepper of a system of elements, allocated once.

use super::costs::Costs;
use super::differentiate::Values;
use super::jacobian::{Visit, pattern};
use super::kept::Kept;
use super::linear::Linear;
use super::preference::Preference;
use super::rounding::Rounding;
use super::side_by_side::is_side_by_side;
use super::windows::{LEAST_IN_WINDOWS, Sweeps, WindowPlan, takes_windows};
use super::{Elements, PairColumns, Quadrature, Unknowns};
use crate::algebra::memory::{Iteration, Method, Report, Request, StepMemory, Threads};
use crate::algebra::scalar::Scalar;
use crate::algebra::solve::Room;
use crate::error::StepFailure;
use crate::ground::numbers::{Numbers, Tape};

/// Vectors of one step, unknowns of past steps, and the matrix.
#[derive(Default)]
pub struct Memory<S: Scalar> {
    pub(super) degrees: usize,
    /// Number of unknowns that are remembered of each step.
    remembered: usize,
    pub(super) work: Work<S>,
    pub(super) known: u8,
    pub(super) solver: Solver<S>,
    /// The windows of explicit steps of a large system.
    pub(super) plan: WindowPlan,
    /// Where numbers carry derivatives, the values of implicit steps.
    pub(super) values: Option<Box<Values<S>>>,
}

/// The data of the iteration that outlast a step.
#[derive(Default)]
pub(super) struct Solver<S: Scalar> {
    pub(super) iteration: Iteration,
    /// `∂u/∂v` where that is diagonal.
    pub(super) diagonal: Vec<S>,
    /// Unknowns of past steps, the latest first.
    pub(super) past: [Vec<S>; 3],
    pub(super) preference: Preference,
    pub(super) costs: Costs,
    pub(super) linear: Option<Linear<S>>,
    pub(super) kept: Kept<S>,
    pub(super) rounding: Option<Box<Rounding>>,
    /// The windows of the fixed point of a large system.
    pub(super) sweeps: Option<Box<Sweeps>>,
    pub(super) care: Care<S>,
}

/// The scratch of a careful step.
#[derive(Debug, Default)]
pub(super) struct Care<S> {
    pub(super) start: Vec<S>,
    /// Which equations are solved to rounding.
    pub(super) are_settled: Vec<bool>,
    pub(super) room: Room<Vec<S>>,
}

/// Scratch for the equations of one step: a single list, because the compiler knows only of parts of one list
/// that they do not overlap.
#[derive(Debug, Default)]
pub(super) struct Work<S> {
    numbers: Vec<S>,
    columns: PairColumns,
}

/// The parts of a [`Work`], with lengths that follow from the system, so that loops over several of them need
/// no bounds checks.
pub(super) struct Lists<'a, S> {
    pub(super) x: &'a mut [S],
    pub(super) correction: &'a mut [S],
    /// The previous correction.
    pub(super) previous: &'a mut [S],
    pub(super) u: &'a mut [S],
    pub(super) momentum: &'a mut [S],
    /// Slopes by momenta; where `u` follows from `v`, the `u` before the correction.
    pub(super) by_p: &'a mut [S],
    pub(super) stages: Stages<'a, S>,
    pub(super) columns: &'a mut PairColumns,
}

/// The coordinates of each stage, and the slopes by them.
pub(super) struct Stages<'a, S> {
    numbers: &'a mut [S],
    degrees: usize,
    /// Whether the two lists of each stage are exchanged.
    is_turned: bool,
}

/// Padding between two lists of a large system, in numbers: simultaneous reads and writes then have different
/// offsets within a page, the last bits of an address, which processors compare first.
#[cfg_attr(not(debug_assertions), inline(always))]
fn apart(degrees: usize) -> usize {
    if degrees < LEAST_IN_WINDOWS { 0 } else { 40 }
}

/// The first `length` numbers, and those after a padding of `apart`.
#[cfg_attr(not(debug_assertions), inline(always))]
fn split_apart<S>(numbers: &mut [S], length: usize, apart: usize) -> (&mut [S], &mut [S]) {
    let (list, rest) = numbers.split_at_mut(length + apart);
    (&mut list[..length], rest)
}

impl<S: Scalar> Work<S> {
    /// Scratch for a system with this number of degrees of freedom.
    pub(super) fn new(scheme: &Quadrature, degrees: usize) -> Self {
        debug_assert!(!scheme.stages.is_empty(), "a discrete Lagrangian has a quadrature point");
        let numbers = vec![S::from_f64(0.0); Self::length(scheme, degrees)];
        Self { numbers, columns: PairColumns::default() }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn length(scheme: &Quadrature, degrees: usize) -> usize {
        let apart = (6 + 2 * scheme.stages.len()) * apart(degrees);
        3 * scheme.unknowns.count(degrees) + (3 + 2 * scheme.stages.len()) * degrees + apart
    }

    /// Whether it was made for such a system.
    pub(super) fn fits(&self, scheme: &Quadrature, degrees: usize) -> bool {
        self.numbers.len() == Self::length(scheme, degrees)
    }

    /// Its parts for the scheme and the degrees of freedom that it was made for.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn lists(&mut self, scheme: &Quadrature, degrees: usize) -> Lists<'_, S> {
        let unknowns = scheme.unknowns.count(degrees);
        let Self { numbers, columns } = self;
        let numbers = &mut numbers[..Self::length(scheme, degrees)];
        let apart = apart(degrees);
        let (x, numbers) = split_apart(numbers, unknowns, apart);
        let (correction, numbers) = split_apart(numbers, unknowns, apart);
        let (previous, numbers) = split_apart(numbers, unknowns, apart);
        let (u, numbers) = split_apart(numbers, degrees, apart);
        let (momentum, numbers) = split_apart(numbers, degrees, apart);
        let (by_p, numbers) = split_apart(numbers, degrees, apart);
        Lists {
            x,
            correction,
            previous,
            u,
            momentum,
            by_p,
            stages: Stages { numbers, degrees, is_turned: false },
            columns,
        }
    }
}

impl<S: Scalar> Lists<'_, S> {
    /// The lists in numbers `f64`, if their numbers are `f64`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn plain(&mut self) -> Option<Lists<'_, f64>> {
        let Self { x, correction, previous, u, momentum, by_p, stages, columns } = self;
        let Stages { numbers, degrees, is_turned } = stages;
        let stages = Stages { numbers: S::plain_mut(numbers)?, degrees: *degrees, is_turned: *is_turned };
        Some(Lists {
            x: S::plain_mut(x)?,
            correction: S::plain_mut(correction)?,
            previous: S::plain_mut(previous)?,
            u: S::plain_mut(u)?,
            momentum: S::plain_mut(momentum)?,
            by_p: S::plain_mut(by_p)?,
            stages,
            columns,
        })
    }
}

impl<S> Lists<'_, S> {
    /// A copy of the references for a separate function: values whose address is passed do not stay in
    /// registers.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn lend(&mut self) -> Lists<'_, S> {
        let Self { x, correction, previous, u, momentum, by_p, stages, columns } = self;
        let stages = Stages { numbers: stages.numbers, ..*stages };
        Lists { x, correction, previous, u, momentum, by_p, stages, columns }
    }
}

impl<S> Stages<'_, S> {
    /// The start of a stage, and the distance from its coordinates to the slopes by them.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn bounds(&self, stage: usize) -> (usize, usize) {
        let stride = self.degrees + apart(self.degrees);
        (2 * stride * stage, stride)
    }

    /// The coordinates of a stage, and the slopes by them.
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

/// The parts of a [`Memory`] that the solution of a step reads and writes.
pub(super) struct Scratch<'a, S: Scalar> {
    pub(super) lists: Lists<'a, S>,
    pub(super) solver: &'a mut Solver<S>,
    pub(super) known: u8,
    /// The threads that share the windows.
    pub(super) threads: Threads,
    /// Whether vector instructions are ruled out.
    pub(super) is_exact: bool,
}

impl<S: Scalar> Memory<S> {
    /// Scratch for the scheme and the degrees of freedom of this memory; with past steps where the iteration
    /// starts from them.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn scratch(&mut self, scheme: &Quadrature, degrees: usize) -> Scratch<'_, S> {
        let Self { work, solver, plan, known, .. } = self;
        let known = if scheme.remembers { *known } else { 0 };
        Scratch {
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
        let Lists { x, .. } = self.work.lists(scheme, degrees);
        if self.solver.past[0].len() != x.len() {
            self.solver.past.iter_mut().for_each(|past| past.resize(x.len(), S::from_f64(0.0)));
        }
        self.solver.past.rotate_right(1);
        self.solver.past[0].copy_from_slice(x);
        self.count_past();
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn count_past(&mut self) {
        self.known = (self.known + 1).min(3);
    }
}

impl<S: Scalar> Scratch<'_, S> {
    /// The inverse of the Jacobian, if that is a diagonal matrix.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn inverses(&self) -> Option<&[S]> {
        if let Some(Linear::Band(band)) = &self.solver.linear { band.inverses() } else { None }
    }

    /// Extrapolates the unknowns of past steps: `3x_n - 3x_{n-1} + x_{n-2}`, to a lower order if fewer are
    /// `known`, zero if none are.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn guess(&mut self, known: u8) {
        let x = &mut *self.lists.x;
        if known == 0 {
            return x.fill(S::from_f64(0.0));
        }
        let [a, b, c] = self.solver.past.each_ref().map(|past| &past[..x.len()]);
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

impl<S: Scalar> Scratch<'_, S> {
    /// As [`Lists::lend`].
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn lend(&mut self) -> Scratch<'_, S> {
        Scratch { lists: self.lists.lend(), solver: self.solver, ..*self }
    }
}

/// Shows the data of earlier steps; scratch is meaningless outside its step.
impl<S: Scalar> std::fmt::Debug for Memory<S> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { degrees, known, solver: Solver { iteration, past, preference, .. }, .. } = self;
        formatter
            .debug_struct("Memory")
            .field("degrees", degrees)
            .field("iteration", iteration)
            .field("past", &&past[..usize::from(*known).min(past.len())])
            .field("known", known)
            .field("preference", preference)
            .finish_non_exhaustive()
    }
}

/// Copies the data of earlier steps; the copy allocates its own scratch at its first use.
impl<S: Scalar> Clone for Memory<S> {
    fn clone(&self) -> Self {
        let mut copy = Self { plan: self.plan.alike(), ..Self::default() };
        copy.clone_from(self);
        copy
    }

    /// Copies the data of earlier steps and keeps its own allocations.
    fn clone_from(&mut self, other: &Self) {
        if other.known > 0 {
            self.solver.past.clone_from(&other.solver.past);
        }
        self.known = other.known;
        (self.solver.iteration, self.solver.preference) = (other.solver.iteration, other.solver.preference);
        self.solver.kept.clone_from(&other.solver.kept);
    }
}

/// By hand: past unknowns are there once a step is known, and values for one type of numbers only.
impl<S: Scalar> Numbers for Memory<S> {
    fn pass(&mut self, tape: &mut Tape) {
        // `iteration` and `plan` are settings, all other fields without a name are scratch.
        let Self { known, solver, values, degrees: _, remembered: _, work: _, plan: _ } = self;
        let Solver {
            past,
            preference,
            kept,
            iteration: _,
            diagonal: _,
            costs: _,
            linear: _,
            rounding: _,
            sweeps: _,
            care: _,
        } = solver;
        let unknowns = tape.length(if *known == 0 { 0 } else { past[0].len() });
        tape.count(known);
        preference.pass(tape);
        if unknowns != 0 {
            for past in past {
                past.resize(unknowns, S::from_f64(0.0));
                past.iter_mut().for_each(|number| number.pass(tape));
            }
        }
        kept.pass(tape);
        if const { S::IS_PLAIN_DUAL } {
            let mut is_there = values.is_some();
            tape.flag(&mut is_there);
            if is_there {
                values.get_or_insert_default().memory.pass(tape);
            }
        }
    }
}

impl<S: Scalar> StepMemory for Memory<S> {
    fn tell(&mut self, request: &Request) {
        if let Some(values) = &mut self.values {
            values.memory.tell(request);
        }
        match request {
            Request::Forget => {
                self.known = 0;
                self.solver.preference = Preference::default();
                self.solver.kept.forget();
            }
            Request::Hold => self.known = self.known.min(1),
            Request::Pin(iteration) => self.solver.iteration = *iteration,
            Request::Share(threads) => {
                self.plan.share(*threads);
                self.solver.sweeps = None;
            }
            Request::Derivatives(_) => {}
        }
    }

    fn goes_side_by_side(&self) -> bool {
        self.solver.preference == Preference::default() && !self.solver.kept.may_serve()
    }

    fn adopt(&mut self, left: Self) {
        (self.solver.past, self.known, self.solver.preference) =
            (left.solver.past, left.known, left.solver.preference);
        if self.degrees == 0 {
            (self.degrees, self.remembered) = (left.degrees, left.remembered);
            (self.work, self.solver.linear, self.solver.costs) =
                (left.work, left.solver.linear, left.solver.costs);
            (self.solver.diagonal, self.solver.kept) = (left.solver.diagonal, left.solver.kept);
        } else {
            self.solver.kept.clone_from(&left.solver.kept);
        }
        if self.remembered == 0 {
            self.known = 0;
        }
        if self.known == 0 && self.solver.past[0].len() != self.remembered {
            self.solver.past.iter_mut().for_each(|past| past.resize(self.remembered, S::from_f64(0.0)));
        }
    }

    fn hand_values(&mut self, to: &mut Self, are_solved: bool) {
        std::mem::swap(&mut self.values, &mut to.values);
        if let Some(values) = &mut to.values {
            values.are_solved = are_solved;
        }
    }

    fn report(&self) -> Report {
        let method = match &self.solver.linear {
            _ if self.degrees == 0 => Method::Undecided,
            None => Method::Explicit,
            Some(linear) => linear.method(),
        };
        let linear_work = self.solver.kept.work;
        Report { pinned: self.solver.iteration, method: Some(method), linear_work }
    }
}

impl<S: Scalar> Memory<S> {
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
        let has_room_in_windows =
            H::FACTS.has_windows && S::plain(&[]).is_some() && takes_windows(scheme, degrees);
        self.work = if has_room_in_windows { Work::default() } else { Work::new(scheme, degrees) };
        self.solver.diagonal = vec![S::from_f64(0.0); scheme.unknowns.diagonals(degrees)];
        (self.solver.rounding, self.plan, self.solver.sweeps) = (None, self.plan.alike(), None);
        let unknowns = scheme.unknowns.count(degrees);
        let is_implicit = scheme.unknowns != Unknowns::None;
        let remembered = if scheme.remembers { unknowns } else { 0 };
        self.remembered = remembered;
        // A copy already has its past.
        if self.known == 0 || self.solver.past[0].len() != unknowns {
            let past = || vec![S::from_f64(0.0); remembered];
            self.solver.past = [past(), past(), past()];
            self.known = 0;
        }
        self.degrees = degrees;
        self.solver.kept.lose();
        let pattern = |visit: Visit<'_>| pattern(system, scheme, degrees, visit);
        // Counted before the matrix is allocated: the pattern needs room of its own.
        let entries = if is_implicit { entries(&pattern) } else { 0 };
        if const { is_side_by_side::<S>() } {
            // Lanes have no factors, and take the decisions of a path alone.
            let linear = is_implicit.then(|| Linear::<f64>::new(&pattern, unknowns));
            self.solver.costs = Costs::of(entries, unknowns, linear.as_ref());
        } else {
            let has_factors = is_implicit && !scheme.takes_values_first::<S>();
            self.solver.linear = has_factors.then(|| Linear::new(&pattern, unknowns));
            self.solver.costs = Costs::of(entries, unknowns, self.solver.linear.as_ref());
        }
    }
}

/// How many entries a pattern has.
fn entries(pattern: &dyn Fn(Visit<'_>)) -> usize {
    let mut entries = 0;
    pattern(&mut |_, _| entries += 1);
    entries
}
