//! One step: `x = φ(x)` solved to rounding.

use super::change::Change;
use super::linear::Linear;
use super::memory::{Lists, Scratch, Solver};
use super::passes::{Corrected, largest, subtract};
use super::preference::Solution;
use super::rounding::variation;
use super::step::Step;
use super::{CONTRACTS, Elements, Iteration, Memory, Quadrature, Unknowns};
use crate::algebra::carry::Carry;
use crate::algebra::scalar::Scalar;
use crate::algebra::solve::{Effort, astray};
use crate::error::StepFailure;
use crate::scheme::system::At;

/// Corrections below this fraction of the largest unknown change nothing.
const ROUNDING: f64 = f64::EPSILON;
/// Residual of linear equations that are solved by iteration: each Newton iteration gains three digits.
const FORCING: f64 = 1e-3;
/// Corrections below this fraction of the largest unknown are not worth a factorisation: a choice of cost.
const NEARLY_SOLVED: f64 = 1e-9;
/// More iterations than any step needs that converges at all.
const MOST_ITERATIONS: u32 = 100;

/// One step from `(q, p)` at `t` in place; on `Err` nothing but scratch is changed.
///
/// # Errors
/// [`StepFailure`]: sizes that do not fit, no convergence, a singular Jacobian, a state that is not finite.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn advance<H: Elements + Sync, S: Scalar, C: Carry<S>, const CAREFUL: bool>(
    system: &H,
    scheme: &Quadrature,
    at: At<'_, S>,
    memory: &mut Memory<S>,
    carry: &mut C,
) -> Result<Effort, StepFailure> {
    if CAREFUL || !memory.fits(system, at.q.len()) {
        return advance_anyhow::<H, S, C, CAREFUL>(system, scheme, at, memory, carry);
    }
    advance_fitting::<H, S, C, false>(system, scheme, at, memory, carry)
}

/// The same where a memory may be of another size, or the step takes care: rare, and compiled once for all schemes.
#[cold]
#[inline(never)]
fn advance_anyhow<H: Elements + Sync, S: Scalar, C: Carry<S>, const CAREFUL: bool>(
    system: &H,
    scheme: &Quadrature,
    at: At<'_, S>,
    memory: &mut Memory<S>,
    carry: &mut C,
) -> Result<Effort, StepFailure> {
    // What the steps before left belongs to another size, and stays if this one fails.
    let mut anew = None;
    if CAREFUL && memory.is_new() {
        // Its blocks are known also if it fails.
        memory.fit(system, scheme, at.q.len())?;
    }
    let fitting = if memory.fits(system, at.q.len()) {
        &mut *memory
    } else {
        let mut fitting = memory.clone();
        fitting.fit(system, scheme, at.q.len())?;
        anew.insert(fitting)
    };
    let effort = advance_fitting::<H, S, C, CAREFUL>(system, scheme, at, fitting, carry)?;
    if let Some(fitting) = anew {
        *memory = fitting;
    }
    Ok(effort)
}

/// The step in a memory of the size of the state.
#[cfg_attr(not(debug_assertions), inline(always))]
fn advance_fitting<H: Elements + Sync, S: Scalar, C: Carry<S>, const CAREFUL: bool>(
    system: &H,
    scheme: &Quadrature,
    At { t, h, q, p, dw }: At<'_, S>,
    memory: &mut Memory<S>,
    carry: &mut C,
) -> Result<Effort, StepFailure> {
    let [q, p] = super::sized_mut(system, [q, p])?;
    let dw = super::increments(system, dw)?;
    let step = Step { system, scheme, t, h, q, p, dw, increment: None };
    let degrees = step.degrees();
    let (effort, solution) = if CAREFUL {
        let effort = step.careful(memory)?;
        let mut lists = memory.work.lists(scheme, degrees);
        step.finish(&mut lists);
        for degree in (0..degrees).filter(|&degree| memory.blocks.holds(degree)) {
            (lists.u[degree], lists.by_p[degree]) = (S::from_f64(0.0), S::from_f64(0.0));
        }
        lists.store(q, p, carry)?;
        // With noise, too: a part of a step that is followed starts where the one before ended.
        memory.record(scheme, degrees);
        (effort, Solution::Newton { may_contract: false })
    } else {
        let mut scratch = memory.scratch(scheme, degrees);
        let solved = step.solve(&mut scratch)?;
        if !C::CARRIES && step.is_in_windows(&mut scratch) {
            scratch.store_windows(scheme, q, p);
            memory.known = if scheme.remembers { (memory.known + 1).min(3) } else { 0 };
        } else {
            step.finish(&mut scratch.lists);
            scratch.lists.store(q, p, carry)?;
            if scheme.remembers {
                memory.record(scheme, degrees);
            }
        }
        (Effort::fast(solved.iterations), solved.solution)
    };
    memory.solver.preference.learn(solution);
    if memory.solver.preference.is_newton()
        && let Some(linear) = &memory.solver.linear
    {
        memory.solver.kept.succeed(linear.cost());
    }
    Ok(effort)
}

impl<S: Scalar> Scratch<'_, S> {
    /// `3x_n - 3x_{n-1} + x_{n-2}` of the past, as far as `known`, or zero.
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

impl<S: Scalar> Memory<S> {
    /// Takes the unknowns of a step that succeeded.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn record(&mut self, scheme: &Quadrature, degrees: usize) {
        let Lists { x, .. } = self.work.lists(scheme, degrees);
        if self.solver.past[0].len() != x.len() {
            self.solver.past.iter_mut().for_each(|past| past.resize(x.len(), S::from_f64(0.0)));
        }
        self.solver.past.rotate_right(1);
        self.solver.past[0].copy_from_slice(x);
        self.known = (self.known + 1).min(3);
    }
}

/// What the short way took.
struct Solved {
    iterations: u32,
    solution: Solution,
}

/// Where the short way is.
struct IterationState {
    iterations: u32,
    /// Past steps that make the start; 0 for zero.
    known: u8,
    pinned: Iteration,
    /// Whether corrections are Newton's, and not those of the fixed point.
    is_newton: bool,
    /// Whether factors are to be made: in every iteration, or only where old ones contract too slowly.
    is_stale: bool,
    /// Whether `J` of the first iteration was about the identity.
    may_contract: bool,
    /// The correction before, relative to the largest unknown.
    last: f64,
    /// Whether that is of unknowns beyond rounding only.
    is_beyond: bool,
    variation: f64,
}

/// A correction that was taken.
struct Taken {
    /// Relative to the largest unknown.
    relative: f64,
    /// What it changed of what the equations are evaluated at, where that is known already: of corrections of the fixed point only.
    change: Option<Change>,
    /// How much longer the correction of the fixed point would have been.
    stretch: f64,
    /// Whether it is that of the Jacobian where it was made.
    is_fresh: bool,
    /// Whether it comes from factors that were there.
    is_kept: bool,
}

impl<H: Elements + Sync, S: Scalar> Step<'_, H, S> {
    /// Solves for the unknowns by the short way.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn solve(self, scratch: &mut Scratch<'_, S>) -> Result<Solved, StepFailure> {
        let (pinned, known) = (scratch.solver.iteration, scratch.known);
        scratch.solver.kept.begin();
        let takes_one = self.takes_one_correction(scratch);
        let attempt = |scratch: &mut Scratch<'_, S>| match takes_one {
            true => self.correct_once(scratch),
            false => self.iterate(scratch, known, pinned),
        };
        let mut first = attempt(scratch);
        if first.is_err() && self.may_have_been_unusual(scratch) {
            scratch.is_exact = true;
            first = attempt(scratch);
        }
        match first {
            // A start that misleads is given up for zero, and what was tried for Newton's method from there.
            Err(_) if known > 0 || pinned == Iteration::Automatic => {
                let solved = self.iterate_again(scratch.lend());
                // Which of two lists is which was known there.
                scratch.leave_windows();
                self.refresh(&mut scratch.lists);
                solved
            }
            first => first,
        }
    }

    /// Whether the equations are linear and none has an unknown of another: one correction leaves nothing but rounding.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn takes_one_correction(self, scratch: &Scratch<'_, S>) -> bool {
        let is_linear = self.scheme.is_linear && scratch.solver.iteration == Iteration::Automatic;
        is_linear && scratch.inverses().is_some()
    }

    /// That correction, from zero.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn correct_once(self, scratch: &mut Scratch<'_, S>) -> Result<Solved, StepFailure> {
        self.start(scratch, 0);
        if !self.starts_with_factors(scratch.lend(), Iteration::Automatic) {
            let Scratch { lists, solver: Solver { diagonal, linear: Some(linear), kept, .. }, .. } =
                scratch.lend()
            else {
                return Err(StepFailure::NonFinite);
            };
            self.renew(&lists, diagonal, linear, kept, Iteration::Automatic)?;
        }
        match self.sweep(scratch, true).relative {
            relative if relative.is_nan() => Err(StepFailure::NonFinite),
            _ => Ok(Solved { iterations: 1, solution: Solution::Newton { may_contract: false } }),
        }
    }

    /// From zero, by Newton's method unless another is pinned.
    #[cold]
    #[inline(never)]
    fn iterate_again(self, mut scratch: Scratch<'_, S>) -> Result<Solved, StepFailure> {
        let (asked, is_tried) =
            (scratch.solver.iteration, !self.starts_with_newton(&scratch, scratch.solver.iteration));
        let pinned = if asked == Iteration::Automatic { Iteration::Newton } else { asked };
        let mut solved = self.iterate(&mut scratch, 0, pinned)?;
        if is_tried && asked == Iteration::Automatic {
            solved.solution = Solution::GaveWay;
        }
        Ok(solved)
    }

    /// From the guess of so many steps before; leaves `u` and `P`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn iterate(
        self,
        scratch: &mut Scratch<'_, S>,
        known: u8,
        pinned: Iteration,
    ) -> Result<Solved, StepFailure> {
        let mut iteration = self.begin(scratch, known, pinned);
        let is_tried = !iteration.is_newton;
        self.start(scratch, known);
        while iteration.iterations < MOST_ITERATIONS {
            iteration.iterations += 1;
            let taken = self.take(scratch, &mut iteration)?;
            if self.is_solved(scratch, &mut iteration, &taken)? {
                let IterationState { iterations, is_newton, may_contract, .. } = iteration;
                let solution = match (is_tried, is_newton) {
                    (_, false) => Solution::FixedPoint,
                    (true, true) => Solution::GaveWay,
                    (false, true) => Solution::Newton { may_contract },
                };
                return Ok(Solved { iterations, solution });
            }
        }
        Err(StepFailure::NotConverged { iterations: MOST_ITERATIONS, correction: iteration.last })
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn begin(self, scratch: &mut Scratch<'_, S>, known: u8, pinned: Iteration) -> IterationState {
        let is_newton = self.starts_with_newton(scratch, pinned);
        let has_factors = is_newton && self.starts_with_factors(scratch.lend(), pinned);
        IterationState {
            iterations: 0,
            known,
            pinned,
            is_newton,
            is_stale: !has_factors,
            may_contract: false,
            last: f64::INFINITY,
            is_beyond: false,
            variation: f64::INFINITY,
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn starts_with_newton(self, scratch: &Scratch<'_, S>, pinned: Iteration) -> bool {
        let has_constant_band =
            self.scheme.is_linear && matches!(scratch.solver.linear, Some(Linear::Band(_)));
        match pinned {
            Iteration::Newton => true,
            Iteration::Automatic => scratch.solver.preference.is_newton() || has_constant_band,
            Iteration::FixedPoint => false,
        }
    }

    /// Takes the correction of the fixed point, or Newton's.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn take(
        self,
        scratch: &mut Scratch<'_, S>,
        iteration: &mut IterationState,
    ) -> Result<Taken, StepFailure> {
        let Lists { correction, previous, .. } = &mut scratch.lists;
        std::mem::swap(correction, previous);
        let (mut is_fresh, mut is_kept) = (false, false);
        let (mut stretch, mut change) = (1.0, None);
        let relative = if iteration.is_newton {
            scratch.leave_windows();
            self.residual_as::<S::OfElements<H::Exact>>(&mut scratch.lists);
            let is_krylov = match &scratch.solver.linear {
                Some(linear) => matches!(linear, Linear::Krylov(_)),
                None => return Err(astray(iteration.iterations, iteration.last)),
            };
            // Products are those with the Jacobian where it is, whatever factors they go with.
            is_fresh = iteration.is_stale || is_krylov;
            is_kept = !iteration.is_stale;
            stretch = self.correct_by_newton(scratch.lend(), iteration.is_stale, iteration.pinned)?;
            iteration.is_stale = iteration.pinned == Iteration::Newton && !is_krylov;
            let relative = subtract(self.scheme.unknowns, scratch.lists.x, scratch.lists.correction);
            self.refresh(&mut scratch.lists);
            relative
        } else {
            let swept = self.sweep(scratch, false);
            change = swept.change;
            swept.relative
        };
        if relative.is_nan() {
            // A fixed point that diverges overflows in the end.
            let (iterations, correction) = (iteration.iterations, iteration.last);
            let diverges =
                iteration.pinned == Iteration::FixedPoint && (1.0..f64::INFINITY).contains(&correction);
            let not_converged = StepFailure::NotConverged { iterations, correction };
            return Err(if diverges { not_converged } else { StepFailure::NonFinite });
        }
        Ok(Taken { relative, change, stretch, is_fresh, is_kept })
    }

    /// Makes the correction of the fixed point Newton's, with new factors where the old ones are stale; how much shorter
    /// it is.
    #[inline(never)]
    fn correct_by_newton(
        self,
        scratch: Scratch<'_, S>,
        is_stale: bool,
        pinned: Iteration,
    ) -> Result<f64, StepFailure> {
        let Scratch { mut lists, solver: Solver { diagonal, linear: Some(linear), kept, .. }, .. } = scratch
        else {
            return Err(StepFailure::NonFinite);
        };
        if is_stale {
            self.renew(&lists, diagonal, linear, kept, pinned)?;
        } else if matches!(linear, Linear::Krylov(_)) {
            self.differentiate_velocities(&lists, diagonal);
        }
        let kind = self.scheme.unknowns;
        let before = largest(kind, lists.correction);
        let mut products = self.correct(&mut lists, diagonal, linear, FORCING);
        let mut is_old = !is_stale;
        while let Err(StepFailure::NotConverged { iterations, .. }) = products {
            let all = kept.wants_all();
            kept.count(Some(iterations));
            // Neither the factors of another Jacobian are a guide to this one, nor those that lack too much.
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
        // That of the kind which it changes more.
        Ok(if (first - 1.0).abs() >= (second - 1.0).abs() || second.is_nan() { first } else { second })
    }

    /// Whether no more corrections are needed; else how the next one is to be made.
    ///
    /// # Errors
    /// If the solution is not near.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn is_solved(
        self,
        scratch: &mut Scratch<'_, S>,
        iteration: &mut IterationState,
        taken: &Taken,
    ) -> Result<bool, StepFailure> {
        let IterationState { iterations, known, pinned, is_newton, last, .. } = *iteration;
        let mut relative = taken.relative;
        let ratio = relative / last;
        let predicts = last < f64::INFINITY && ratio < 0.5;
        if self.is_resolved(scratch, taken, is_newton, predicts.then_some(ratio)) {
            return Ok(true);
        }
        // A guess claims to be near the solution.
        let is_misled = is_newton && known > 0 && iterations == 1 && relative >= 1.0;
        let is_slow = last < f64::INFINITY && ratio > CONTRACTS;
        let stagnates = is_slow && ratio > 0.5;
        // Far from the solution a fixed point that does not contract gives way to Newton's method anyway.
        let is_final = is_newton || pinned == Iteration::FixedPoint || relative <= NEARLY_SOLVED;
        let mut settles = false;
        if stagnates && is_final && !is_misled {
            let beyond = self.beyond_rounding(scratch.lists.lend(), &mut scratch.solver.rounding);
            if beyond == 0.0 && !varies(scratch, iteration) {
                return Ok(true);
            }
            // What is rounding may have been the larger part of the correction before.
            settles = beyond < 0.5 * if iteration.is_beyond { last } else { last.max(relative) };
            if settles {
                (iteration.is_beyond, relative) = (true, beyond);
            }
        }
        if is_misled && taken.is_kept {
            // Factors that served other steps may serve this one from zero.
            self.start(scratch, 0);
            (iteration.known, iteration.last) = (0, f64::INFINITY);
            return Ok(false);
        }
        // Fresh factors that do not halve the correction: the solution is not near.
        if is_misled || (taken.is_fresh && stagnates && !settles) {
            return Err(astray(iterations, relative));
        }
        if is_newton && iterations == 1 && pinned == Iteration::Automatic {
            // Where `J` is about the identity the fixed point contracts as well.
            iteration.may_contract = (taken.stretch - 1.0).abs() <= 0.5 * CONTRACTS;
        }
        iteration.last = relative;
        let is_worth = stagnates || relative > NEARLY_SOLVED;
        if is_slow && !settles && is_worth && pinned == Iteration::Automatic {
            // Old factors, or none, do not contract.
            iteration.is_stale = !is_newton || !matches!(scratch.solver.linear, Some(Linear::Krylov(_)));
            if !is_newton && stagnates {
                iteration.is_stale = !self.starts_with_factors(scratch.lend(), pinned);
                self.start(scratch, known);
                iteration.last = f64::INFINITY;
            }
            (iteration.is_newton, iteration.is_beyond) = (true, false);
        }
        Ok(false)
    }

    /// Whether what is left of the correction that was taken is rounding: from the contraction if that is known, or, of the fixed
    /// point, from what it changed. The same at all sizes, whichever of the two costs less where.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn is_resolved(
        self,
        scratch: &Scratch<'_, S>,
        taken: &Taken,
        is_newton: bool,
        ratio: Option<f64>,
    ) -> bool {
        let is_enough = |relative: f64| {
            relative <= ROUNDING || ratio.is_some_and(|ratio| relative * ratio <= 0.25 * ROUNDING)
        };
        taken.change == Some(Change::Unseen)
            || (is_enough(taken.relative)
                && resolves(self.scheme.unknowns, [self.q, self.p], &scratch.lists, ratio.unwrap_or(1.0)))
            || (!is_newton && taken.change.is_none() && self.changes_nothing(&scratch.lists))
    }
}

/// Whether what is left of each correction, by the contraction of all and of its own unknown, is below the rounding of
/// the state that it changes.
#[cfg_attr(not(debug_assertions), inline(always))]
fn resolves<S: Scalar>(unknowns: Unknowns, [q, p]: [&[S]; 2], lists: &Lists<'_, S>, ratio: f64) -> bool {
    let Lists { x, correction, previous, .. } = lists;
    if unknowns == Unknowns::Both {
        let state = q.iter().zip(p).map(|(&q, &p)| [q, p]);
        Corrected::<S, 2>::of(x, correction, previous).0.are_small(state, ratio)
    } else {
        let (groups, [x, correction, previous]) = Corrected::<S, 4>::of(x, correction, previous);
        let (state, rest) = p.as_chunks::<4>();
        groups.are_small(state.iter().copied(), ratio)
            && Corrected::<S, 1>::of(x, correction, previous).0.are_small(rest.iter().map(|&p| [p]), ratio)
    }
}

/// Whether derivatives that the unknowns carry, which converge after them, still do.
fn varies<S: Scalar>(scratch: &Scratch<'_, S>, iteration: &mut IterationState) -> bool {
    let variation = variation(scratch.lists.x, scratch.lists.correction);
    let before = std::mem::replace(&mut iteration.variation, variation);
    size_of::<S>() != size_of::<f64>() && variation < 0.5 * before
}
