//! One step: `x = φ(x)` solved to rounding.

use super::change::Change;
use super::costs::Costs;
use super::lanes::{ConvergenceRate, is_in_lanes};
use super::linear::LinearSolver;
use super::memory::{IterationMemory, LoopScratch, StepLists};
use super::passes::{largest, subtract};
use super::preference::SolvedBy;
use super::rounding::variation;
use super::step::LoopStep;
use super::{Elements, Iteration, LoopMemory, Quadrature};
use crate::algebra::scalar::{Mask, Scalar};
use crate::algebra::solve::{CONTRACTION, Effort, astray};
use crate::algebra::state_sum::StateSum;
use crate::error::StepFailure;
use crate::scheme::system::StepArguments;

/// Residual of linear equations solved by iteration: each Newton iteration gains three digits.
const FORCING: f64 = 1e-3;
/// Corrections below this fraction of the largest unknown are not worth a factorisation: a tuning parameter.
pub(super) const NEARLY_SOLVED: f64 = 1e-9;
/// Iteration limit, above what any converging step needs.
const MOST_ITERATIONS: u32 = 100;

/// One step from `(q, p)` at `t` in place; on `Err` nothing but scratch is changed.
///
/// # Errors
/// [`StepFailure`]: sizes that do not fit, no convergence, a singular Jacobian, a state that is not finite.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn advance<H: Elements + Sync, S: Scalar, C: StateSum<S>, const CAREFUL: bool>(
    (system, parameters): (&H, &[S::Constant]),
    scheme: &Quadrature,
    at: StepArguments<'_, S, S::Constant>,
    memory: &mut LoopMemory<S>,
    carry: &mut C,
) -> Result<Effort, StepFailure> {
    if CAREFUL || !memory.fits(system, at.q.len()) {
        return advance_anyhow::<H, S, C, CAREFUL>((system, parameters), scheme, at, memory, carry);
    }
    advance_fitting::<H, S, C, false>((system, parameters), scheme, at, memory, carry)
}

/// [`advance`] with a memory of another size, or for a careful step: rare, and compiled once for all schemes.
#[cold]
#[inline(never)]
fn advance_anyhow<H: Elements + Sync, S: Scalar, C: StateSum<S>, const CAREFUL: bool>(
    (system, parameters): (&H, &[S::Constant]),
    scheme: &Quadrature,
    at: StepArguments<'_, S, S::Constant>,
    memory: &mut LoopMemory<S>,
    carry: &mut C,
) -> Result<Effort, StepFailure> {
    // A memory of another size is replaced only if the step succeeds.
    let mut anew = None;
    let fitting = if memory.fits(system, at.q.len()) {
        &mut *memory
    } else {
        let mut fitting = memory.clone();
        fitting.fit(system, scheme, at.q.len())?;
        anew.insert(fitting)
    };
    let effort = advance_fitting::<H, S, C, CAREFUL>((system, parameters), scheme, at, fitting, carry)?;
    if let Some(fitting) = anew {
        *memory = fitting;
    }
    Ok(effort)
}

/// The step with a memory that fits the state.
#[cfg_attr(not(debug_assertions), inline(always))]
fn advance_fitting<H: Elements + Sync, S: Scalar, C: StateSum<S>, const CAREFUL: bool>(
    (system, parameters): (&H, &[S::Constant]),
    scheme: &Quadrature,
    StepArguments { t, h, q, p, dw }: StepArguments<'_, S, S::Constant>,
    memory: &mut LoopMemory<S>,
    carry: &mut C,
) -> Result<Effort, StepFailure> {
    let [q, p] = super::sized_mut(system, [q, p])?;
    let dw = super::increments(system, dw)?;
    let step = LoopStep { system, scheme, t, h, parameters, q, p, dw, increment: None };
    let degrees = step.degrees();
    if scheme.takes_values_first::<S>() {
        let effort = step.differentiate::<CAREFUL>(memory)?;
        let mut lists = memory.work.lists(scheme, degrees);
        step.finish(&mut lists);
        lists.store(q, p, carry)?;
        return Ok(effort);
    }
    let (effort, solution) = if CAREFUL {
        let effort = step.careful(memory)?;
        let mut lists = memory.work.lists(scheme, degrees);
        step.finish(&mut lists);
        lists.store(q, p, carry)?;
        // With noise, too: where a solution is followed over parts of a step, each part starts from the one
        // before.
        memory.record(scheme, degrees);
        (effort, SolvedBy::Newton { may_contract: false })
    } else {
        let mut scratch = memory.scratch(scheme, degrees);
        // One correction starts from zero.
        let remembers = scheme.remembers && !step.takes_one_correction(&scratch);
        let solved = step.solve(&mut scratch)?;
        let is_recorded = if !C::CARRIES && step.is_in_tiles(&mut scratch) {
            scratch.store_in_tiles(scheme, remembers, q, p)?;
            true
        } else {
            step.finish(&mut scratch.lists);
            scratch.lists.store(q, p, carry)?;
            false
        };
        match (remembers, is_recorded) {
            (true, true) => memory.solver.past.count(),
            (true, false) => memory.record(scheme, degrees),
            (false, _) => memory.solver.past.known = 0,
        }
        (Effort::fast(solved.iterations), solved.solution)
    };
    memory.solver.preference.learn(solution);
    if memory.solver.preference.is_newton()
        && let Some(linear) = &memory.solver.linear
    {
        memory.solver.kept.succeed(linear.cost(memory.solver.costs));
    }
    Ok(effort)
}

/// The outcome of the fast iteration.
pub(super) struct IterationOutcome {
    pub(super) iterations: u32,
    pub(super) solution: SolvedBy,
}

/// The state of the fast iteration.
pub(super) struct IterationState<S: Scalar> {
    pub(super) iterations: u32,
    /// Number of past steps from which the start is extrapolated; 0 for a start from zero.
    known: u8,
    pinned: Iteration,
    /// Whether corrections are Newton's rather than those of the fixed point.
    is_newton: bool,
    /// Whether the next correction needs new factors.
    is_stale: bool,
    /// Whether `J` was close to the identity in the first iteration.
    may_contract: bool,
    /// The previous correction relative to the largest unknown.
    pub(super) last: S,
    /// The paths side by side whose equations are solved.
    pub(super) solved: S::Mask,
    /// Whether `last` covers only unknowns whose equations are not at rounding.
    is_beyond: bool,
    variation: f64,
    pub(super) costs: Costs,
}

/// An applied correction.
struct Correction<S> {
    /// Relative to the largest unknown.
    relative: S,
    /// The change of the points at which the equations are evaluated, if already known; of fixed-point
    /// corrections only.
    change: Option<Change>,
    /// Ratio of the fixed-point correction to this one.
    stretch: f64,
    /// Whether it uses the Jacobian at its own iterate.
    is_fresh: bool,
    /// Whether it uses factors that existed before.
    is_kept: bool,
}

impl<H: Elements + Sync, S: Scalar> LoopStep<'_, H, S> {
    /// Solves for the unknowns by the fast iteration.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn solve(self, scratch: &mut LoopScratch<'_, S>) -> Result<IterationOutcome, StepFailure> {
        if const { is_in_lanes::<S>() } {
            // Paths run one by one if steps begin with another method. A path that turns out to need one ends
            // with an error.
            debug_assert!(
                !self.scheme.linearity.is_constant(),
                "`Properties::in_lanes` is false where a step is one correction"
            );
            let known = scratch.known;
            return self.iterate(scratch, known, Iteration::FixedPoint);
        }
        scratch.solver.kept.begin();
        let mut solved = self.attempt(scratch);
        let mut is_apart = false;
        if const { H::FACTS.has_tiles && S::MAY_BE_F64 }
            && solved.is_err()
            && self.may_have_been_unusual(scratch)
        {
            (scratch.is_exact, is_apart) = (true, true);
            solved = self.attempt_exactly(scratch.lend());
        }
        // The start may have been misleading: restart from zero, by Newton's method unless another is pinned.
        if solved.is_err() && (scratch.known > 0 || scratch.solver.iteration == Iteration::Automatic) {
            is_apart = true;
            solved = self.iterate_again(scratch.lend());
        }
        if is_apart {
            // Lists may have been exchanged in the lent scratch only.
            scratch.leave_tiles();
            self.refresh(&mut scratch.lists);
        }
        solved
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn attempt(self, scratch: &mut LoopScratch<'_, S>) -> Result<IterationOutcome, StepFailure> {
        let (pinned, known) = (scratch.solver.iteration, scratch.known);
        match self.takes_one_correction(scratch) {
            true => self.correct_once(scratch),
            false => self.iterate(scratch, known, pinned),
        }
    }

    /// [`LoopStep::attempt`] without vector instructions; separate, since a second call would keep the first
    /// from being inlined.
    #[cold]
    #[inline(never)]
    fn attempt_exactly(self, mut scratch: LoopScratch<'_, S>) -> Result<IterationOutcome, StepFailure> {
        self.attempt(&mut scratch)
    }

    /// Whether the equations are uncoupled and their Jacobian constant, so that one correction solves them to
    /// rounding.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn takes_one_correction(self, scratch: &LoopScratch<'_, S>) -> bool {
        let is_constant = self.scheme.linearity.is_constant();
        is_constant && scratch.solver.iteration == Iteration::Automatic && scratch.inverses().is_some()
    }

    /// Solves uncoupled equations with a constant Jacobian by one correction from zero.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn correct_once(self, scratch: &mut LoopScratch<'_, S>) -> Result<IterationOutcome, StepFailure> {
        if !self.starts_with_factors(scratch.lend(), Iteration::Automatic) {
            // The Jacobian does not depend on the unknowns.
            let LoopScratch {
                lists,
                solver: IterationMemory { diagonal, linear: Some(linear), kept, .. },
                ..
            } = scratch.lend()
            else {
                return Err(StepFailure::NonFinite);
            };
            self.renew(&lists, diagonal, linear, kept, Iteration::Automatic)?;
        }
        if !self.solve_diagonal(scratch) {
            return Err(StepFailure::NonFinite);
        }
        Ok(IterationOutcome { iterations: 1, solution: SolvedBy::Newton { may_contract: false } })
    }

    /// Solves from zero, by Newton's method unless another iteration is pinned.
    #[cold]
    #[inline(never)]
    fn iterate_again(self, mut scratch: LoopScratch<'_, S>) -> Result<IterationOutcome, StepFailure> {
        let (asked, is_tried) =
            (scratch.solver.iteration, !self.starts_with_newton(&scratch, scratch.solver.iteration));
        let pinned = if asked == Iteration::Automatic { Iteration::Newton } else { asked };
        let mut solved = self.iterate(&mut scratch, 0, pinned)?;
        if is_tried && asked == Iteration::Automatic {
            solved.solution = SolvedBy::GaveWay;
        }
        Ok(solved)
    }

    /// Solves from the extrapolation of `known` past steps; leaves `u` and `P`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn iterate(
        self,
        scratch: &mut LoopScratch<'_, S>,
        known: u8,
        pinned: Iteration,
    ) -> Result<IterationOutcome, StepFailure> {
        let mut iteration = self.begin(scratch, known, pinned);
        let is_tried = !iteration.is_newton;
        self.start(scratch, known);
        while iteration.iterations < MOST_ITERATIONS {
            iteration.iterations += 1;
            let taken = self.apply_correction(scratch, &mut iteration)?;
            if self.is_solved(scratch, &mut iteration, &taken)? {
                let IterationState { iterations, is_newton, may_contract, .. } = iteration;
                let solution = match (is_tried, is_newton) {
                    (_, false) => SolvedBy::FixedPoint,
                    (true, true) => SolvedBy::GaveWay,
                    (false, true) => SolvedBy::Newton { may_contract },
                };
                return Ok(IterationOutcome { iterations, solution });
            }
        }
        Err(StepFailure::NotConverged { iterations: MOST_ITERATIONS, correction: iteration.last.magnitude() })
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn begin(self, scratch: &mut LoopScratch<'_, S>, known: u8, pinned: Iteration) -> IterationState<S> {
        let is_newton = !const { is_in_lanes::<S>() } && self.starts_with_newton(scratch, pinned);
        let has_factors = is_newton && self.starts_with_factors(scratch.lend(), pinned);
        IterationState {
            iterations: 0,
            known,
            pinned,
            is_newton,
            is_stale: !has_factors,
            may_contract: false,
            last: S::from_f64(f64::INFINITY),
            solved: S::Mask::from_bool(false),
            is_beyond: false,
            variation: f64::INFINITY,
            costs: scratch.solver.costs,
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn starts_with_newton(self, scratch: &LoopScratch<'_, S>, pinned: Iteration) -> bool {
        let has_constant_band = self.scheme.linearity.is_constant()
            && matches!(scratch.solver.linear, Some(LinearSolver::Band(_)));
        match pinned {
            Iteration::Newton => true,
            Iteration::Automatic => scratch.solver.preference.is_newton() || has_constant_band,
            Iteration::FixedPoint => false,
        }
    }

    /// Applies a correction of the fixed point or of Newton's method.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn apply_correction(
        self,
        scratch: &mut LoopScratch<'_, S>,
        iteration: &mut IterationState<S>,
    ) -> Result<Correction<S>, StepFailure> {
        let StepLists { correction, previous, .. } = &mut scratch.lists;
        std::mem::swap(correction, previous);
        let (mut is_fresh, mut is_kept) = (false, false);
        let (mut stretch, mut change) = (1.0, None);
        let relative = if !const { is_in_lanes::<S>() } && iteration.is_newton {
            scratch.leave_tiles();
            self.residual_at(&mut scratch.lists);
            let is_krylov = match &scratch.solver.linear {
                Some(linear) => matches!(linear, LinearSolver::Krylov(_)),
                None => return Err(astray(iteration.iterations, iteration.last.magnitude())),
            };
            // Krylov's method takes products with the current Jacobian, whatever its preconditioner.
            is_fresh = iteration.is_stale || is_krylov;
            is_kept = !iteration.is_stale;
            stretch = self.correct_by_newton(scratch.lend(), iteration.is_stale, iteration.pinned)?;
            iteration.is_stale = iteration.pinned == Iteration::Newton && !is_krylov;
            let relative = subtract(self.scheme.unknowns, scratch.lists.x, scratch.lists.correction);
            self.refresh(&mut scratch.lists);
            relative
        } else {
            let swept = self.sweep(scratch, iteration.solved);
            change = swept.change;
            swept.relative
        };
        if relative.magnitude().is_nan() {
            // A diverging fixed point eventually overflows.
            let (iterations, correction) = (iteration.iterations, iteration.last.magnitude());
            let diverges =
                iteration.pinned == Iteration::FixedPoint && (1.0..f64::INFINITY).contains(&correction);
            let not_converged = StepFailure::NotConverged { iterations, correction };
            return Err(if diverges { not_converged } else { StepFailure::NonFinite });
        }
        Ok(Correction { relative, change, stretch, is_fresh, is_kept })
    }

    /// Turns a fixed-point correction into Newton's, with new factors if the old ones are stale. Returns the
    /// ratio of the two, fixed point to Newton.
    #[inline(never)]
    fn correct_by_newton(
        self,
        scratch: LoopScratch<'_, S>,
        is_stale: bool,
        pinned: Iteration,
    ) -> Result<f64, StepFailure> {
        let LoopScratch {
            mut lists,
            solver: IterationMemory { diagonal, linear: Some(linear), kept, .. },
            ..
        } = scratch
        else {
            return Err(StepFailure::NonFinite);
        };
        if is_stale {
            self.renew(&lists, diagonal, linear, kept, pinned)?;
        } else if matches!(linear, LinearSolver::Krylov(_)) {
            self.differentiate_velocities(&lists, diagonal);
        }
        let kind = self.scheme.unknowns;
        let before = largest(kind, lists.correction);
        let mut products = self.correct(&mut lists, diagonal, linear, FORCING);
        let mut is_old = !is_stale;
        while let Err(StepFailure::NotConverged { iterations, .. }) = products {
            let all = kept.wants_all();
            kept.count(Some(iterations));
            // New factors help only if the present ones belong to another Jacobian or were too incomplete.
            if !is_old && all == kept.wants_all() {
                break;
            }
            self.renew(&lists, diagonal, linear, kept, pinned)?;
            is_old = false;
            products = self.correct(&mut lists, diagonal, linear, FORCING);
        }
        kept.count(products?);
        let after = largest(kind, lists.correction);
        let [first, second] = [before[0] / after[0], before[1] / after[1]];
        // The ratio of the kind of unknown that Newton's method changes more.
        Ok(if (first - 1.0).abs() >= (second - 1.0).abs() || second.is_nan() { first } else { second })
    }

    /// Whether the equations are solved; if not, `iteration` says how to make the next correction.
    ///
    /// # Errors
    /// If the iterate is not near a solution.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn is_solved(
        self,
        scratch: &mut LoopScratch<'_, S>,
        iteration: &mut IterationState<S>,
        taken: &Correction<S>,
    ) -> Result<bool, StepFailure> {
        if const { is_in_lanes::<S>() } {
            return self.are_solved(&scratch.lists, iteration, taken.relative);
        }
        let IterationState { iterations, known, pinned, is_newton, .. } = *iteration;
        let (mut relative, last) = (taken.relative.lane(0), iteration.last.lane(0));
        let pace = ConvergenceRate::of(relative, last);
        if self.is_resolved(scratch, taken, is_newton, pace) {
            return Ok(true);
        }
        // An extrapolated start should be near the solution.
        let is_misled = is_newton && known > 0 && iterations == 1 && relative >= 1.0;
        let stagnates = pace.stagnates();
        // Far from the solution, Newton's method replaces a fixed point that does not contract.
        let is_final = is_newton || pinned == Iteration::FixedPoint || relative <= NEARLY_SOLVED;
        let mut settles = false;
        if stagnates && is_final && !is_misled {
            let beyond = self.beyond_rounding(scratch.lists.lend(), &mut scratch.solver.rounding);
            if beyond == 0.0 && !varies(scratch, iteration) {
                return Ok(true);
            }
            // Rounding may have dominated the previous correction.
            settles = beyond < CONTRACTION * if iteration.is_beyond { last } else { last.max(relative) };
            if settles {
                (iteration.is_beyond, relative) = (true, beyond);
            }
        }
        if is_misled && taken.is_kept {
            // Try the existing factors again from zero.
            self.start(scratch, 0);
            (iteration.known, iteration.last) = (0, S::from_f64(f64::INFINITY));
            return Ok(false);
        }
        // Fresh factors did not halve the correction: the solution is not near.
        if is_misled || (taken.is_fresh && stagnates && !settles) {
            return Err(astray(iterations, relative));
        }
        if is_newton && iterations == 1 && pinned == Iteration::Automatic {
            // If `J` is close to the identity, the fixed point contracts, too.
            iteration.may_contract = (taken.stretch - 1.0).abs() <= 0.5 * iteration.costs.slowest;
        }
        iteration.last = S::from_f64(relative);
        if pace.needs_more(is_newton, iteration.costs) && !settles && pinned == Iteration::Automatic {
            // The fixed point, or Newton's method with old factors, contracts too slowly.
            iteration.is_stale =
                !is_newton || !matches!(scratch.solver.linear, Some(LinearSolver::Krylov(_)));
            if !is_newton && stagnates {
                iteration.is_stale = !self.starts_with_factors(scratch.lend(), pinned);
                self.start(scratch, known);
                iteration.last = S::from_f64(f64::INFINITY);
            }
            (iteration.is_newton, iteration.is_beyond) = (true, false);
        }
        Ok(false)
    }

    /// Whether the remaining error is at rounding: by the contraction of the largest correction, if each one
    /// confirms it ([`LoopStep::resolves`]), or, for the fixed point, by the change of the points of
    /// evaluation. The criterion is the same at all system sizes, whichever test is cheaper.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn is_resolved(
        self,
        scratch: &LoopScratch<'_, S>,
        taken: &Correction<S>,
        is_newton: bool,
        pace: ConvergenceRate<f64>,
    ) -> bool {
        let may_look = !is_newton && taken.change.is_none() && size_of::<S>() == size_of::<f64>();
        taken.change == Some(Change::Unseen)
            || (pace.is_enough() && self.resolves(&scratch.lists, pace.expected(), S::magnitude))
            || (may_look && self.changes_nothing(&scratch.lists).all())
    }
}

/// Whether the derivatives that the unknowns carry still converge: they do so after the values.
fn varies<S: Scalar>(scratch: &LoopScratch<'_, S>, iteration: &mut IterationState<S>) -> bool {
    let variation = variation(scratch.lists.x, scratch.lists.correction);
    let before = std::mem::replace(&mut iteration.variation, variation);
    size_of::<S>() != size_of::<f64>() && variation < CONTRACTION * before
}
