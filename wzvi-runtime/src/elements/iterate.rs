//! One step: `x = φ(x)` solved to rounding.

use super::jacobian::Linear;
use super::memory::{Staged, Work};
use super::passes::{Corrected, add, are_finite, largest, subtract};
use super::{
    CONTRACTS, Curvature, Elements, Iteration, Memory, MomentumUpdate, Point, Scheme, Slopes, Stage, Unknowns,
};
use crate::carry::Carry;
use crate::error::StepFailure;
use crate::scalar::Scalar;
use crate::solve::{Effort, astray};
use crate::state::{State, Vector};

/// Corrections below this fraction of the largest unknown change nothing.
const ROUNDING: f64 = f64::EPSILON;
/// Residual of linear equations that are solved by iteration: each Newton iteration gains three digits.
const FORCING: f64 = 1e-3;
/// Corrections below this fraction of the largest unknown are not worth a factorisation: a choice of cost.
const NEARLY_SOLVED: f64 = 1e-9;
/// More iterations than any step needs that converges at all.
const MOST_ITERATIONS: u32 = 100;

/// The givens of one step.
pub(super) struct Step<'a, H, S> {
    pub(super) system: &'a H,
    pub(super) scheme: &'a Scheme,
    pub(super) t: f64,
    pub(super) h: f64,
    pub(super) q: &'a [S],
    pub(super) p: &'a [S],
    pub(super) dw: &'a [S],
    /// `u`, if both nodes are known and `P` alone is not.
    pub(super) increment: Option<&'a [S]>,
}

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

/// `P` of the step between two states, from `p_i = -D_1 L_d(q_i, q_{i+1}, P)`. NaN where that has no solution, or sizes do
/// not fit.
pub fn step_momentum<H: Elements>(
    system: &H,
    scheme: &Scheme,
    before: &State<H::Vector>,
    after: &State<H::Vector>,
    h: f64,
    dw: &[f64],
) -> H::Vector {
    let mut momentum = before.p.clone();
    match momentum_increment(system, scheme, before, after, h, dw) {
        Some(v) => momentum.components_mut().iter_mut().zip(v).for_each(|(p, v)| *p += v),
        None => momentum.components_mut().fill(f64::NAN),
    }
    momentum
}

/// `v = P - p_i`, if it is known.
fn momentum_increment<H: Elements>(
    system: &H,
    scheme: &Scheme,
    before: &State<H::Vector>,
    after: &State<H::Vector>,
    h: f64,
    dw: &[f64],
) -> Option<Vec<f64>> {
    let [q, p, end_q, end_p] = [&before.q, &before.p, &after.q, &after.p].map(Vector::components);
    if [p.len(), end_q.len(), end_p.len()] != [q.len(); 3] || dw.len() != system.noises() {
        return None;
    }
    let change = |start: &[f64], end: &[f64]| start.iter().zip(end).map(|(a, b)| b - a).collect::<Vec<_>>();
    if let MomentumUpdate::Multiple(factor) = scheme.update {
        return Some(change(p, end_p).into_iter().map(|dp| dp / factor).collect());
    }
    let u = change(q, end_q);
    let scheme = &Scheme { unknowns: Unknowns::Momenta, remembers: false, ..*scheme };
    let mut memory = Memory::default();
    memory.fit(system, scheme, q.len()).ok()?;
    let step = Step { system, scheme, t: before.t, h, q, p, dw, increment: Some(&u) };
    step.careful(&mut memory).ok()?;
    Some(memory.work.x)
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

impl<H: Elements, S: Scalar> Step<'_, H, S> {
    /// `φ` at `x`, for the scheme's unknowns, as the correction `x - φ(x)`, which is `(∂L_d/∂P, -D_1 L_d - p_i)` or the
    /// second of them; leaves `u`, `P`, the stages and slopes.
    pub(super) fn residual(&self, work: &mut Work<S>) {
        self.refresh(work);
        let Work { x, correction, u, momentum, stages, by_p, .. } = work;
        let is_both = self.scheme.unknowns == Unknowns::Both;
        if is_both {
            by_p.fill(S::from_f64(0.0));
        }
        let wanted = if is_both { Slopes::ALL } else { Slopes::BY_COORDINATES };
        for (stage, Staged { q, by_q }) in self.scheme.stages.iter().zip(&mut *stages) {
            self.place(stage, q, by_q, u);
            self.slopes(stage, q, momentum, wanted, by_q, by_p);
        }
        for (s, (stage, Staged { by_q, .. })) in self.scheme.stages.iter().zip(&*stages).enumerate() {
            let weight = stage.start;
            match (is_both, s) {
                (true, 0) => {
                    let unknowns = correction.as_chunks_mut().0.iter_mut().zip(x.as_chunks().0);
                    for (([c_u, c_v], &[u, v]), (&by_p, &by_q)) in unknowns.zip(by_p.iter().zip(by_q)) {
                        (*c_u, *c_v) = (u - by_p, v + by_q * weight);
                    }
                }
                (true, _) => {
                    for ([_, c], &by_q) in correction.as_chunks_mut().0.iter_mut().zip(by_q) {
                        *c = *c + by_q * weight;
                    }
                }
                (false, 0) => {
                    for (c, (&x, &by_q)) in correction.iter_mut().zip(x.iter().zip(by_q)) {
                        *c = x + by_q * weight;
                    }
                }
                (false, _) => {
                    for (c, &by_q) in correction.iter_mut().zip(by_q) {
                        *c = *c + by_q * weight;
                    }
                }
            }
        }
    }

    /// `Q = q_i + c u`, and room for the slopes there.
    fn place(&self, stage: &Stage, q: &mut [S], by_q: &mut [S], u: &[S]) {
        for ((point, slope), (&q, &u)) in q.iter_mut().zip(by_q).zip(self.q.iter().zip(u)) {
            *point = q + u * stage.point;
            *slope = S::from_f64(0.0);
        }
    }

    /// Adds to `u` what follows from `P`, where that does not read `u` itself: elements that read coordinates and momenta
    /// are at the node `q_i` then, by the choice of unknowns. What else these add goes to `by_q`.
    fn velocities(&self, momentum: &[S], by_q: &mut [S], u: &mut [S]) {
        for stage in self.scheme.stages {
            self.slopes(stage, self.q, momentum, Slopes::BY_MOMENTA, by_q, u);
        }
    }

    /// Adds the slopes of the parts at a stage.
    fn slopes(&self, stage: &Stage, q: &[S], p: &[S], wanted: Slopes, by_q: &mut [S], by_p: &mut [S]) {
        let at = self.at(stage, q, p);
        for &(part, weight) in stage.parts {
            self.system.slopes(part, weight, &at, wanted, by_q, by_p);
        }
    }

    /// Adds the second derivatives of the parts at a stage.
    pub(super) fn curvature(
        &self,
        stage: &Stage,
        q: &[S],
        p: &[S],
        wanted: Slopes,
        into: &mut impl Curvature<S>,
    ) {
        let at = self.at(stage, q, p);
        for &(part, weight) in stage.parts {
            self.system.curvature(part, weight, &at, wanted, into);
        }
    }

    fn at<'b>(&'b self, stage: &Stage, q: &'b [S], p: &'b [S]) -> Point<'b, S> {
        let (t, acting) = (self.t + stage.point * self.h, 0..self.dw.len());
        Point { q, p, t, h: self.h, dw: self.dw, acting }
    }

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

    /// `P` from the slopes that `D_1 L_d` has, all of them at `q_i`, then `u`.
    pub(super) fn explicit(&self, work: &mut Work<S>) {
        let Work { u, momentum, stages, by_p, .. } = work;
        let Some(Staged { by_q, .. }) = stages.first_mut() else { return };
        let zero = S::from_f64(0.0);
        by_q.fill(zero);
        u.fill(zero);
        for stage in self.scheme.stages.iter().filter(|stage| stage.start != 0.0) {
            self.slopes(stage, self.q, self.p, Slopes::BY_COORDINATES, by_q, by_p);
        }
        for (momentum, (&p, &force)) in momentum.iter_mut().zip(self.p.iter().zip(&*by_q)) {
            *momentum = p - force;
        }
        self.velocities(momentum, by_p, u);
    }

    /// From the guess in `memory`.
    fn iterate(
        &self,
        memory: &mut Memory<S>,
        known: u8,
        iteration: Iteration,
    ) -> Result<Solved, StepFailure> {
        memory.guess(known);
        let is_guess = known > 0;
        // A band that never changes is factored once.
        let has_factors = self.scheme.is_linear && memory.factored == Some(self.h);
        let is_constant = self.scheme.is_linear && matches!(memory.linear, Some(Linear::Band(_)));
        let mut newton = match iteration {
            Iteration::Newton => true,
            Iteration::Automatic => memory.prefers_newton || is_constant,
            Iteration::FixedPoint => false,
        };
        // Fresh factors in every iteration, or only where old ones contract too slowly.
        let mut is_stale = !has_factors || iteration == Iteration::Newton;
        let mut prefers_newton = true;
        let mut last = f64::INFINITY;
        // Whether that is of unknowns beyond rounding only.
        let mut is_beyond = false;
        let mut variation = f64::INFINITY;
        for iterations in 1..=MOST_ITERATIONS {
            let Memory { work, linear, factored, .. } = &mut *memory;
            std::mem::swap(&mut work.correction, &mut work.previous);
            self.residual(work);
            let was_refreshed = newton && is_stale;
            let mut stretch = 1.0;
            if newton {
                let Some(linear) = linear else { return Err(astray(iterations, last)) };
                if is_stale {
                    *factored = None;
                    self.linearise(work, linear)?;
                    *factored = is_constant.then_some(self.h);
                }
                is_stale = iteration == Iteration::Newton || matches!(linear, Linear::Krylov(_));
                let before = largest(&work.correction);
                self.correct(work, linear, FORCING)?;
                stretch = before / largest(&work.correction);
            }
            let mut relative = subtract(&mut work.x, &work.correction);
            if relative.is_nan() {
                // A fixed point that diverges overflows in the end.
                let diverges = iteration == Iteration::FixedPoint && (1.0..f64::INFINITY).contains(&last);
                let not_converged = StepFailure::NotConverged { iterations, correction: last };
                return Err(if diverges { not_converged } else { StepFailure::NonFinite });
            }
            let solved = Solved { iterations, prefers_newton: newton && prefers_newton };
            let ratio = relative / last;
            let predicts = last < f64::INFINITY && ratio < 0.5;
            let is_enough = relative <= ROUNDING || (predicts && relative * ratio <= 0.25 * ROUNDING);
            if is_enough && self.resolves(work, if predicts { ratio } else { 1.0 }) {
                return Ok(solved);
            }
            // A guess claims to be near the solution.
            let is_misled = newton && is_guess && iterations == 1 && relative >= 1.0;
            let is_slow = last < f64::INFINITY && ratio > CONTRACTS;
            let stagnates = is_slow && ratio > 0.5;
            let mut settles = false;
            // Far from the solution a fixed point that does not contract gives way to Newton's method anyway.
            let is_final = newton || iteration == Iteration::FixedPoint || relative <= NEARLY_SOLVED;
            if stagnates && is_final && !is_misled {
                let beyond = self.beyond_rounding(memory);
                if beyond == 0.0 {
                    let before = std::mem::replace(&mut variation, self.variation(&memory.work));
                    // Derivatives that a number carries converge after it.
                    let vary = size_of::<S>() != size_of::<f64>() && variation < 0.5 * before;
                    if !vary {
                        return Ok(solved);
                    }
                }
                // What is rounding may have been the larger part of the correction before.
                settles = beyond < 0.5 * if is_beyond { last } else { last.max(relative) };
                if settles {
                    (is_beyond, relative) = (true, beyond);
                }
            }
            // Fresh factors that do not halve the correction: the solution is not near.
            if is_misled || (was_refreshed && stagnates && !settles) {
                return Err(astray(iterations, relative));
            }
            if newton && iterations == 1 && iteration == Iteration::Automatic {
                // Where `J` is about the identity the fixed point contracts as well.
                prefers_newton = (stretch - 1.0).abs() > 0.5 * CONTRACTS;
            }
            last = relative;
            let is_worth = stagnates || relative > NEARLY_SOLVED;
            if is_slow && !settles && is_worth && iteration == Iteration::Automatic {
                // Old factors, or none, do not contract.
                if !newton && stagnates {
                    memory.guess(known);
                    last = f64::INFINITY;
                }
                (newton, is_stale, is_beyond) = (true, true, false);
            }
        }
        Err(StepFailure::NotConverged { iterations: MOST_ITERATIONS, correction: last })
    }

    /// `u` and `P` at the solution.
    pub(super) fn refresh(&self, work: &mut Work<S>) {
        let Work { x, u, momentum, by_p, .. } = work;
        if self.scheme.unknowns == Unknowns::Both {
            let unknowns = x.as_chunks().0;
            let known = momentum.iter_mut().zip(u).zip(self.p.iter().zip(unknowns));
            for ((momentum, u), (&p, &[x_u, x_v])) in known {
                (*u, *momentum) = (x_u, p + x_v);
            }
        } else {
            for ((momentum, u), (&p, &x)) in momentum.iter_mut().zip(&mut *u).zip(self.p.iter().zip(&*x)) {
                (*u, *momentum) = (S::from_f64(0.0), p + x);
            }
            match self.increment {
                Some(known) => u.copy_from_slice(known),
                None => self.velocities(momentum, by_p, u),
            }
        }
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

    /// `p_{i+1} - p_i` into `by_p`.
    fn finish(&self, work: &mut Work<S>) {
        let Work { x, u, momentum, stages, by_p: dp, correction, .. } = work;
        match self.scheme.unknowns {
            Unknowns::None => {
                let forces = stages.first().map_or(&[][..], |stage| &stage.by_q);
                dp.iter_mut().zip(forces).for_each(|(dp, &force)| *dp = -force);
            }
            Unknowns::Momenta => dp.copy_from_slice(x),
            Unknowns::Both => dp.iter_mut().zip(x.as_chunks().0).for_each(|(dp, &[_, v])| *dp = v),
        }
        match self.scheme.update {
            MomentumUpdate::Multiple(1.0) => {}
            MomentumUpdate::Multiple(factor) => dp.iter_mut().for_each(|dp| *dp = *dp * factor),
            MomentumUpdate::Slopes => {
                let ends = self.scheme.stages.iter().zip(stages).filter(|(stage, _)| stage.end != 0.0);
                for (stage, Staged { q, by_q }) in ends {
                    self.place(stage, q, by_q, u);
                    // Slopes with respect to momenta go where nobody looks.
                    self.slopes(stage, q, momentum, Slopes::BY_COORDINATES, by_q, correction);
                    dp.iter_mut().zip(&*by_q).for_each(|(dp, &force)| *dp = *dp - force * stage.end);
                }
            }
        }
    }
}
