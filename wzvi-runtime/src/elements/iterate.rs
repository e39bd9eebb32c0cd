//! One step: `x = φ(x)` solved to rounding.

use super::jacobian::Linear;
use super::memory::Work;
use super::passes::{Corrected, add, are_finite, largest, subtract};
use super::{CONTRACTS, Elements, Iteration, Memory, Point, Terms};
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

/// Which unknowns are iterated on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unknowns {
    /// None: `v` and then `u` are assigned.
    None,
    /// `v`, from which `u` follows.
    Momenta,
    /// `u` and `v`.
    Both,
}

/// What the compiler decided about a scheme.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scheme {
    /// Quadrature point of the drift.
    pub drift_l: f64,
    /// Quadrature point of the noises.
    pub noise_l: f64,
    /// The factor `1/2 - l` of the counter-term; 0 if there is none.
    pub counter: f64,
    /// What is iterated on.
    pub unknowns: Unknowns,
    /// Whether past steps start the iteration: not where increments decide.
    pub remembers: bool,
    /// Whether the Jacobian reads the step size and parameters only.
    pub is_linear: bool,
    /// Whether there are noises.
    pub has_noise: bool,
}

/// The groups of terms that share a quadrature point.
pub(super) fn stages(scheme: &Scheme) -> impl Iterator<Item = (usize, f64, Terms)> {
    let terms = |drift, noise| {
        let counter = if noise { scheme.counter } else { 0.0 };
        Terms { drift, noise, counter, by_q: true, by_p: true }
    };
    let together = !scheme.has_noise || scheme.drift_l == scheme.noise_l;
    let first = (0, scheme.drift_l, terms(true, together));
    let second = (1, scheme.noise_l, terms(false, true));
    [Some(first), (!together).then_some(second)].into_iter().flatten()
}

/// The givens of one step.
pub(super) struct Step<'a, H, S> {
    pub(super) system: &'a H,
    pub(super) scheme: &'a Scheme,
    pub(super) t: f64,
    pub(super) h: f64,
    pub(super) q: &'a [S],
    pub(super) p: &'a [S],
    pub(super) dw: &'a [S],
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
    let step = Step { system, scheme, t, h, q, p, dw };
    let (effort, prefers_newton) = if CAREFUL {
        (step.careful(memory)?, scheme.unknowns != Unknowns::None)
    } else {
        let solved = step.solve(memory)?;
        (Effort::fast(solved.iterations), solved.prefers_newton)
    };
    if !C::CARRIES && step.is_at_start() {
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
    let Work { u, by_p: dp, by_q, stage, .. } = work;
    let (lost_q, lost_p) = (&mut by_q[0], &mut stage[0]);
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
    /// `φ` at `x`, for the scheme's unknowns, as the correction `x - φ(x)`; leaves `u`, `P`, the stages and slopes.
    pub(super) fn residual(&self, work: &mut Work<S>) {
        self.refresh(work);
        let Work { x, correction, u, momentum, stage, by_q, by_p, .. } = work;
        let zero = S::from_f64(0.0);
        let is_both = self.scheme.unknowns == Unknowns::Both;
        if is_both {
            by_p.fill(zero);
        }
        for (s, l, terms) in stages(self.scheme) {
            self.place(&mut stage[s], &mut by_q[s], u, l);
            let at = self.at(&stage[s], momentum, l);
            self.system.slopes(Terms { by_p: is_both, ..terms }, &at, &mut by_q[s], by_p);
        }
        for (s, l, _) in stages(self.scheme) {
            let (weight, force) = (1.0 - l, &by_q[s]);
            match (is_both, s) {
                (true, 0) => {
                    let unknowns = correction.as_chunks_mut().0.iter_mut().zip(x.as_chunks().0);
                    for (([c_u, c_v], &[u, v]), (&by_p, &force)) in unknowns.zip(by_p.iter().zip(force)) {
                        (*c_u, *c_v) = (u - by_p, v + force * weight);
                    }
                }
                (true, _) => {
                    for ([_, c], &force) in correction.as_chunks_mut().0.iter_mut().zip(force) {
                        *c = *c + force * weight;
                    }
                }
                (false, 0) => {
                    for (c, (&x, &force)) in correction.iter_mut().zip(x.iter().zip(force)) {
                        *c = x + force * weight;
                    }
                }
                (false, _) => {
                    for (c, &force) in correction.iter_mut().zip(force) {
                        *c = *c + force * weight;
                    }
                }
            }
        }
    }

    /// `Q_l = q_i + l u`, and room for the slopes there.
    fn place(&self, stage: &mut [S], by_q: &mut [S], u: &[S], l: f64) {
        for ((point, slope), (&q, &u)) in stage.iter_mut().zip(by_q).zip(self.q.iter().zip(u)) {
            *point = q + u * l;
            *slope = S::from_f64(0.0);
        }
    }

    /// Adds to `u` what follows from `P`, where that does not read `u` itself.
    fn velocities(&self, momentum: &[S], by_p: &mut [S], u: &mut [S]) {
        for (_, l, terms) in stages(self.scheme) {
            // Elements that read both are at the node `q_i` here, by the choice of unknowns.
            let at = self.at(self.q, momentum, l);
            self.system.slopes(Terms { by_q: false, ..terms }, &at, by_p, u);
        }
    }

    pub(super) fn at<'b>(&'b self, q: &'b [S], p: &'b [S], l: f64) -> Point<'b, S> {
        Point { q, p, t: self.t + l * self.h, h: self.h, dw: self.dw }
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

    /// `v` from the terms at `q_i`, then `u`.
    pub(super) fn explicit(&self, work: &mut Work<S>) {
        let Work { u, momentum, by_q, by_p, .. } = work;
        let zero = S::from_f64(0.0);
        by_q[0].fill(zero);
        u.fill(zero);
        for (_, l, terms) in stages(self.scheme).filter(|(_, l, _)| *l == 0.0) {
            let at = self.at(self.q, self.p, l);
            self.system.slopes(Terms { by_p: false, ..terms }, &at, &mut by_q[0], by_p);
        }
        for (momentum, (&p, &force)) in momentum.iter_mut().zip(self.p.iter().zip(&by_q[0])) {
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
            self.velocities(momentum, by_p, u);
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
        let Work { x, u, momentum, stage, by_q, by_p, correction, .. } = work;
        let l = self.scheme.drift_l;
        let is_both = self.scheme.unknowns == Unknowns::Both;
        let is_explicit = self.scheme.unknowns == Unknowns::None;
        if self.is_at_start() {
            by_p.iter_mut().zip(&by_q[0]).for_each(|(dp, &force)| *dp = -force);
            return;
        }
        if is_explicit {
            for (dp, (&momentum, &p)) in by_p.iter_mut().zip(momentum.iter().zip(self.p)) {
                *dp = momentum - p;
            }
        } else if is_both {
            by_p.iter_mut().zip(x.as_chunks().0).for_each(|(dp, &[_, v])| *dp = v);
        } else {
            by_p.copy_from_slice(x);
        }
        if !is_explicit && l != 1.0 && self.has_one_point() {
            // With one quadrature point `l < 1` the forces at the solution follow from `v`.
            let factor = 1.0 / (1.0 - l);
            by_p.iter_mut().for_each(|dp| *dp = *dp * factor);
            return;
        }
        // Slopes with respect to momenta go where nobody looks.
        for (s, l, terms) in stages(self.scheme).filter(|(_, l, _)| *l != 0.0) {
            self.place(&mut stage[s], &mut by_q[s], u, l);
            let at = self.at(&stage[s], momentum, l);
            self.system.slopes(Terms { by_p: false, ..terms }, &at, &mut by_q[s], correction);
            by_p.iter_mut().zip(&by_q[s]).for_each(|(dp, &force)| *dp = *dp - force * l);
        }
    }

    /// Whether the step is explicit with all its quadrature points at its start.
    fn is_at_start(&self) -> bool {
        self.scheme.unknowns == Unknowns::None && stages(self.scheme).all(|(_, l, _)| l == 0.0)
    }

    fn has_one_point(&self) -> bool {
        !self.scheme.has_noise || self.scheme.drift_l == self.scheme.noise_l
    }
}
