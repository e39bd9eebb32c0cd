//! One step: `x = φ(x)` solved to rounding.

use super::jacobian::Linear;
use super::memory::{Staged, Work};
use super::passes::{Corrected, add, are_finite, largest, subtract};
use super::step::Step;
use super::{CONTRACTS, Elements, Iteration, Memory, MomentumUpdate, Scheme, Unknowns};
use crate::carry::Carry;
use crate::error::StepFailure;
use crate::scalar::Scalar;
use crate::solve::{Effort, astray};

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
#[expect(clippy::too_many_arguments, reason = "as `Discretized::advance_carrying`")]
pub fn advance<H: Elements, S: Scalar, C: Carry<S>, const CAREFUL: bool>(
    system: &H,
    scheme: &Scheme,
    t: f64,
    h: f64,
    q: &mut [S],
    p: &mut [S],
    dw: &[S],
    memory: &mut Memory<S>,
    carry: &mut C,
) -> Result<Effort, StepFailure> {
    if memory.degrees != q.len() || q.is_empty() {
        // What the steps before left belongs to another size, and stays if this one fails.
        let mut fitting = memory.clone();
        fitting.fit(system, scheme, q.len())?;
        let effort = advance::<H, S, C, CAREFUL>(system, scheme, t, h, q, p, dw, &mut fitting, carry)?;
        *memory = fitting;
        return Ok(effort);
    }
    if p.len() != q.len() {
        return Err(StepFailure::Dimension { expected: q.len(), got: p.len() });
    }
    if dw.len() != system.noises() {
        return Err(StepFailure::Increments { expected: system.noises(), got: dw.len() });
    }
    let step = Step { system, scheme, t, h, q, p, dw, increment: None };
    let (effort, prefers_newton) = if CAREFUL {
        (step.careful(memory)?, scheme.unknowns != Unknowns::None)
    } else {
        let solved = step.solve(memory)?;
        (Effort::fast(solved.iterations), solved.prefers_newton)
    };
    if !C::CARRIES && scheme.unknowns == Unknowns::None && scheme.update == MomentumUpdate::Multiple(1.0) {
        // `P` is the new momentum.
        let Work { u, momentum, .. } = &mut memory.work;
        if !(add(u, q) && are_finite(momentum)) {
            return Err(StepFailure::NonFinite);
        }
        q.copy_from_slice(u);
        p.copy_from_slice(momentum);
    } else {
        step.finish(&mut memory.work);
        store(&mut memory.work, q, p, carry)?;
    }
    memory.record();
    memory.prefers_newton = prefers_newton;
    Ok(effort)
}

/// Adds the increments of a step to the state. Sums are made before anything is stored.
fn store<S: Scalar, C: Carry<S>>(
    work: &mut Work<S>,
    q: &mut [S],
    p: &mut [S],
    carry: &mut C,
) -> Result<(), StepFailure> {
    // What the sums lose takes the place of slopes and stages.
    let Work { u, by_p: dp, stages, .. } = work;
    let Some(Staged { q: lost_q, by_q: lost_p }) = stages.first_mut() else {
        return Err(StepFailure::NonFinite);
    };
    let is_finite = if C::CARRIES {
        for (i, (u, (&q, lost))) in u.iter_mut().zip(q.iter().zip(&mut *lost_q)).enumerate() {
            (*u, *lost) = C::add(q, *u, carry.of_coordinate(i));
        }
        for (i, (dp, (&p, lost))) in dp.iter_mut().zip(p.iter().zip(&mut *lost_p)).enumerate() {
            (*dp, *lost) = C::add(p, *dp, carry.of_momentum(i));
        }
        are_finite(u) && are_finite(dp)
    } else {
        add(u, q) && add(dp, p)
    };
    if !is_finite {
        return Err(StepFailure::NonFinite);
    }
    q.copy_from_slice(u);
    p.copy_from_slice(dp);
    if C::CARRIES {
        carry.keep(lost_q, lost_p);
    }
    Ok(())
}

impl<S: Scalar> Memory<S> {
    /// `3x_n - 3x_{n-1} + x_{n-2}` of the past, as far as `known`, or zero.
    pub(super) fn guess(&mut self, known: u8) {
        let x = &mut self.work.x;
        let [a, b, c] = &self.past;
        match known {
            0 => x.fill(S::from_f64(0.0)),
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

    /// Takes the unknowns of a step that succeeded.
    fn record(&mut self) {
        if !self.past[0].is_empty() {
            self.past.rotate_right(1);
            self.past[0].copy_from_slice(&self.work.x);
            self.known = (self.known + 1).min(3);
        }
    }
}

/// What the short way took.
struct Solved {
    iterations: u32,
    /// Whether the next step should not start with the fixed point.
    prefers_newton: bool,
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
    prefers_newton: bool,
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
    /// How much longer the correction of the fixed point would have been.
    stretch: f64,
    /// Whether it comes from factors that were made for it.
    is_fresh: bool,
}

impl<H: Elements, S: Scalar> Step<'_, H, S> {
    /// Solves for the unknowns by the short way.
    fn solve(&self, memory: &mut Memory<S>) -> Result<Solved, StepFailure> {
        if self.scheme.unknowns == Unknowns::None {
            self.explicit(&mut memory.work);
            return Ok(Solved { iterations: 0, prefers_newton: false });
        }
        let (pinned, known) = (memory.iteration, memory.known);
        let first = self.iterate(memory, known, pinned);
        let solved = match first {
            // A start that misleads is given up for zero, and what was tried for Newton's method from there.
            Err(_) if known > 0 || pinned == Iteration::Automatic => {
                let last_resort = if pinned == Iteration::Automatic { Iteration::Newton } else { pinned };
                self.iterate(memory, 0, last_resort)?
            }
            first => first?,
        };
        self.refresh(&mut memory.work);
        Ok(solved)
    }

    /// From the guess in `memory`.
    fn iterate(&self, memory: &mut Memory<S>, known: u8, pinned: Iteration) -> Result<Solved, StepFailure> {
        memory.guess(known);
        let mut iteration = self.begin(memory, known, pinned);
        while iteration.iterations < MOST_ITERATIONS {
            iteration.iterations += 1;
            let taken = self.take(memory, &mut iteration)?;
            if self.is_solved(memory, &mut iteration, &taken)? {
                let prefers_newton = iteration.is_newton && iteration.prefers_newton;
                return Ok(Solved { iterations: iteration.iterations, prefers_newton });
            }
        }
        Err(StepFailure::NotConverged { iterations: MOST_ITERATIONS, correction: iteration.last })
    }

    fn begin(&self, memory: &Memory<S>, known: u8, pinned: Iteration) -> IterationState {
        // A band that never changes is factored once.
        let has_factors = self.scheme.is_linear && memory.factored == Some(self.h);
        IterationState {
            iterations: 0,
            known,
            pinned,
            is_newton: match pinned {
                Iteration::Newton => true,
                Iteration::Automatic => memory.prefers_newton || self.has_constant_band(memory),
                Iteration::FixedPoint => false,
            },
            is_stale: !has_factors || pinned == Iteration::Newton,
            prefers_newton: true,
            last: f64::INFINITY,
            is_beyond: false,
            variation: f64::INFINITY,
        }
    }

    fn has_constant_band(&self, memory: &Memory<S>) -> bool {
        self.scheme.is_linear && matches!(memory.linear, Some(Linear::Band(_)))
    }

    /// Takes the correction of the fixed point, or Newton's.
    fn take(&self, memory: &mut Memory<S>, iteration: &mut IterationState) -> Result<Taken, StepFailure> {
        let is_constant = self.has_constant_band(memory);
        let Memory { work, linear, factored, .. } = memory;
        std::mem::swap(&mut work.correction, &mut work.previous);
        self.residual(work);
        let is_fresh = iteration.is_newton && iteration.is_stale;
        let mut stretch = 1.0;
        if iteration.is_newton {
            let Some(linear) = linear else { return Err(astray(iteration.iterations, iteration.last)) };
            if is_fresh {
                *factored = None;
                self.linearise(work, linear)?;
                *factored = is_constant.then_some(self.h);
            }
            iteration.is_stale = iteration.pinned == Iteration::Newton || matches!(linear, Linear::Krylov(_));
            let before = largest(&work.correction);
            self.correct(work, linear, FORCING)?;
            stretch = before / largest(&work.correction);
        }
        let relative = subtract(&mut work.x, &work.correction);
        if relative.is_nan() {
            // A fixed point that diverges overflows in the end.
            let (iterations, correction) = (iteration.iterations, iteration.last);
            let diverges =
                iteration.pinned == Iteration::FixedPoint && (1.0..f64::INFINITY).contains(&correction);
            let not_converged = StepFailure::NotConverged { iterations, correction };
            return Err(if diverges { not_converged } else { StepFailure::NonFinite });
        }
        Ok(Taken { relative, stretch, is_fresh })
    }

    /// Whether no more corrections are needed; else how the next one is to be made.
    ///
    /// # Errors
    /// If the solution is not near.
    fn is_solved(
        &self,
        memory: &mut Memory<S>,
        iteration: &mut IterationState,
        taken: &Taken,
    ) -> Result<bool, StepFailure> {
        let IterationState { iterations, known, pinned, is_newton, last, .. } = *iteration;
        let mut relative = taken.relative;
        let ratio = relative / last;
        let predicts = last < f64::INFINITY && ratio < 0.5;
        let is_enough = relative <= ROUNDING || (predicts && relative * ratio <= 0.25 * ROUNDING);
        if is_enough && self.resolves(&memory.work, if predicts { ratio } else { 1.0 }) {
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
            let beyond = self.beyond_rounding(memory);
            if beyond == 0.0 && !self.varies(memory, iteration) {
                return Ok(true);
            }
            // What is rounding may have been the larger part of the correction before.
            settles = beyond < 0.5 * if iteration.is_beyond { last } else { last.max(relative) };
            if settles {
                (iteration.is_beyond, relative) = (true, beyond);
            }
        }
        // Fresh factors that do not halve the correction: the solution is not near.
        if is_misled || (taken.is_fresh && stagnates && !settles) {
            return Err(astray(iterations, relative));
        }
        if is_newton && iterations == 1 && pinned == Iteration::Automatic {
            // Where `J` is about the identity the fixed point contracts as well.
            iteration.prefers_newton = (taken.stretch - 1.0).abs() > 0.5 * CONTRACTS;
        }
        iteration.last = relative;
        let is_worth = stagnates || relative > NEARLY_SOLVED;
        if is_slow && !settles && is_worth && pinned == Iteration::Automatic {
            // Old factors, or none, do not contract.
            if !is_newton && stagnates {
                memory.guess(known);
                iteration.last = f64::INFINITY;
            }
            (iteration.is_newton, iteration.is_stale, iteration.is_beyond) = (true, true, false);
        }
        Ok(false)
    }

    /// Whether derivatives that the unknowns carry, which converge after them, still do.
    fn varies(&self, memory: &Memory<S>, iteration: &mut IterationState) -> bool {
        let variation = self.variation(&memory.work);
        let before = std::mem::replace(&mut iteration.variation, variation);
        size_of::<S>() != size_of::<f64>() && variation < 0.5 * before
    }

    /// Whether what is left of each correction, by the contraction of all and of its own unknown, is below the rounding of
    /// the state that it changes.
    fn resolves(&self, work: &Work<S>, ratio: f64) -> bool {
        let Work { x, correction, previous, .. } = work;
        if self.scheme.unknowns == Unknowns::Both {
            let state = self.q.iter().zip(self.p).map(|(&q, &p)| [q, p]);
            Corrected::<S, 2>::of(x, correction, previous).0.are_small(state, ratio)
        } else {
            let (groups, [x, correction, previous]) = Corrected::<S, 4>::of(x, correction, previous);
            let (state, rest) = self.p.as_chunks::<4>();
            groups.are_small(state.iter().copied(), ratio)
                && Corrected::<S, 1>::of(x, correction, previous)
                    .0
                    .are_small(rest.iter().map(|&p| [p]), ratio)
        }
    }
}
