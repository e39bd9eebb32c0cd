//! One step: `x = φ(x)` solved to rounding.

use super::jacobian::Linear;
use super::memory::Work;
use super::{CONTRACTS, Elements, Iteration, Memory, Point, Terms};
use crate::carry::Carry;
use crate::error::StepFailure;
use crate::scalar::{Mask, Scalar};
use crate::solve::{Effort, STAGNATION, astray};

/// Corrections below this fraction of the largest unknown change nothing.
const ROUNDING: f64 = f64::EPSILON;
/// Residual of linear equations that are solved by iteration: each Newton iteration gains three digits.
const FORCING: f64 = 1e-3;
/// Corrections that move the coordinates by less than this fraction are rounding of the forces.
const MOVES_NOTHING: f64 = 64.0 * f64::EPSILON;
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
    /// What is iterated on.
    pub unknowns: Unknowns,
    /// Whether past steps start the iteration: not where increments decide.
    pub remembers: bool,
    /// Whether there are noises.
    pub has_noise: bool,
}

/// The groups of terms that share a quadrature point.
pub(super) fn stages(scheme: &Scheme) -> impl Iterator<Item = (usize, f64, Terms)> {
    let terms = |drift, noise| Terms { drift, noise, by_q: true, by_p: true };
    let together = !scheme.has_noise || scheme.drift_l == scheme.noise_l;
    let first = (0, scheme.drift_l, terms(true, together));
    let second = (1, scheme.noise_l, terms(false, true));
    [Some(first), (!together).then_some(second)].into_iter().flatten()
}

/// The givens of one step.
pub(super) struct Step<'a, H, S> {
    pub(super) system: &'a H,
    pub(super) scheme: &'a Scheme,
    t: f64,
    h: f64,
    pub(super) q: &'a [S],
    p: &'a [S],
    dw: &'a [S],
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
        memory.fit(system, scheme, q.len())?;
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
    step.finish(&mut memory.work);
    // by_p becomes the increment of the momenta; sums are made before anything is stored.
    let Work { u, by_p: dp, by_q, stage, .. } = &mut memory.work;
    let (lost_q, lost_p) = (&mut by_q[0], &mut stage[0]);
    for (i, (u, lost)) in u.iter_mut().zip(lost_q.iter_mut()).enumerate() {
        (*u, *lost) = C::add(q[i], *u, carry.of_coordinate(i));
    }
    for (i, (dp, lost)) in dp.iter_mut().zip(lost_p.iter_mut()).enumerate() {
        (*dp, *lost) = C::add(p[i], *dp, carry.of_momentum(i));
    }
    if !S::are_finite(u.iter().chain(dp.iter()).copied()).all() {
        return Err(StepFailure::NonFinite);
    }
    q.copy_from_slice(u);
    p.copy_from_slice(dp);
    if C::CARRIES {
        carry.keep(lost_q, lost_p);
    }
    memory.record();
    memory.prefers_newton = prefers_newton;
    Ok(effort)
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

/// The largest correction, and the same against the largest unknown; NaN if any part is.
pub(super) struct Size {
    pub(super) relative: f64,
    pub(super) largest: f64,
}

impl<H: Elements, S: Scalar> Step<'_, H, S> {
    /// `φ` at `x`, for the scheme's unknowns, as the correction `x - φ(x)`; leaves `u`, `P`, the stages and slopes.
    pub(super) fn residual(&self, work: &mut Work<S>) {
        let Work { x, correction, u, momentum, stage, by_q, by_p, .. } = work;
        let zero = S::from_f64(0.0);
        let d = self.q.len();
        let is_both = self.scheme.unknowns == Unknowns::Both;
        let value = |x: &[S], i: usize| if is_both { x[2 * i + 1] } else { x[i] };
        for (i, (momentum, &p)) in momentum.iter_mut().zip(self.p).enumerate() {
            *momentum = p + value(x, i);
        }
        if is_both {
            for (i, u) in u.iter_mut().enumerate() {
                *u = x[2 * i];
            }
        } else {
            self.velocities(momentum, by_p, u);
        }
        by_p.fill(zero);
        for (s, l, terms) in stages(self.scheme) {
            for (point, (&q, &u)) in stage[s].iter_mut().zip(self.q.iter().zip(&*u)) {
                *point = q + u * l;
            }
            by_q[s].fill(zero);
            let at = self.at(&stage[s], momentum, l);
            self.system.slopes(Terms { by_p: is_both, ..terms }, &at, &mut by_q[s], by_p);
        }
        for i in 0..d {
            let mut force = zero;
            for (s, l, _) in stages(self.scheme) {
                force = force + by_q[s][i] * (1.0 - l);
            }
            if is_both {
                correction[2 * i] = x[2 * i] - by_p[i];
                correction[2 * i + 1] = x[2 * i + 1] + force;
            } else {
                correction[i] = x[i] + force;
            }
        }
    }

    /// `u` from `P`, where it does not read `u` itself.
    fn velocities(&self, momentum: &[S], by_p: &mut [S], u: &mut [S]) {
        u.fill(S::from_f64(0.0));
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
        momentum.copy_from_slice(self.p);
        by_q[0].fill(zero);
        for (_, l, terms) in stages(self.scheme).filter(|(_, l, _)| *l == 0.0) {
            let at = self.at(self.q, self.p, l);
            self.system.slopes(Terms { by_p: false, ..terms }, &at, &mut by_q[0], by_p);
        }
        for (momentum, &force) in momentum.iter_mut().zip(&by_q[0]) {
            *momentum = *momentum - force;
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
        let mut newton = match iteration {
            Iteration::Newton => true,
            Iteration::Automatic => memory.prefers_newton,
            Iteration::FixedPoint => false,
        };
        // Fresh factors in every iteration, or only where old ones contract too slowly.
        let mut is_stale = true;
        let mut prefers_newton = true;
        let mut last = f64::INFINITY;
        for iterations in 1..=MOST_ITERATIONS {
            let Memory { work, linear, .. } = memory;
            self.residual(work);
            let was_refreshed = newton && is_stale;
            let mut stretch = 1.0;
            if newton {
                let Some(linear) = linear else { return Err(astray(iterations, last)) };
                if is_stale {
                    self.linearise(work, linear)?;
                }
                is_stale = iteration == Iteration::Newton || matches!(linear, Linear::Krylov(_));
                let before = largest(&work.correction);
                self.correct(work, linear, FORCING)?;
                stretch = before / largest(&work.correction);
            }
            let Size { relative, largest } = subtract(&mut work.x, &work.correction);
            if relative.is_nan() {
                return Err(StepFailure::NonFinite);
            }
            let ratio = relative / last;
            let predicts = last < f64::INFINITY && ratio < 0.5;
            if relative <= ROUNDING || (predicts && relative * ratio <= 0.25 * ROUNDING) {
                return Ok(Solved { iterations, prefers_newton: newton && prefers_newton });
            }
            // A guess claims to be near the solution.
            let is_misled = newton && is_guess && iterations == 1 && relative >= 1.0;
            let is_slow = last < f64::INFINITY && ratio > CONTRACTS;
            let is_small = is_slow && self.is_rounding(work, largest);
            if is_small && ratio > 0.5 {
                return Ok(Solved { iterations, prefers_newton: newton && prefers_newton });
            }
            // Fresh factors that do not halve the correction: the solution is not near.
            if is_misled || (was_refreshed && is_slow && ratio > 0.5) {
                return Err(astray(iterations, relative));
            }
            if newton && iterations == 1 && iteration == Iteration::Automatic {
                // Where `J` is about the identity the fixed point contracts as well.
                prefers_newton = (stretch - 1.0).abs() > 0.5 * CONTRACTS;
            }
            last = relative;
            if is_slow && !is_small && iteration == Iteration::Automatic {
                // Old factors, or none, do not contract. Near rounding nothing does.
                if !newton && ratio > 0.5 {
                    memory.guess(known);
                    last = f64::INFINITY;
                }
                (newton, is_stale) = (true, true);
            }
        }
        Err(StepFailure::NotConverged { iterations: MOST_ITERATIONS, correction: last })
    }

    /// `u` and `P` at the solution.
    pub(super) fn refresh(&self, work: &mut Work<S>) {
        let Work { x, u, momentum, by_p, .. } = work;
        let is_both = self.scheme.unknowns == Unknowns::Both;
        for (i, (momentum, &p)) in momentum.iter_mut().zip(self.p).enumerate() {
            *momentum = p + if is_both { x[2 * i + 1] } else { x[i] };
        }
        if is_both {
            for (i, u) in u.iter_mut().enumerate() {
                *u = x[2 * i];
            }
        } else {
            self.velocities(momentum, by_p, u);
        }
    }

    /// Whether every correction is small against the unknown and the state that it changes, or moves the coordinates by
    /// rounding: forces of long waves are small differences of large coordinates.
    #[cold]
    pub(super) fn is_rounding(&self, work: &Work<S>, correction: f64) -> bool {
        let norm = |x: &[S]| x.iter().fold(0.0_f64, |largest, x| largest.max(x.magnitude()));
        // `∂u/∂P`, for a kinetic energy that is about quadratic.
        let moved = correction * norm(&work.u);
        if size_of::<S>() == size_of::<f64>() && moved <= MOVES_NOTHING * norm(self.q) * norm(&work.momentum)
        {
            return true;
        }
        let is_both = self.scheme.unknowns == Unknowns::Both;
        let largest = work.x.iter().fold(0.0_f64, |largest, x| largest.max(x.magnitude()));
        work.correction.iter().enumerate().all(|(k, &correction)| {
            let state = match (is_both, k % 2) {
                (true, 0) => self.q[k / 2],
                (true, _) => self.p[k / 2],
                (false, _) => self.p[k],
            };
            correction.relative_to(work.x[k], Some(state)) <= STAGNATION
                || correction.magnitude() <= STAGNATION * largest
        })
    }

    /// `p_{i+1} - p_i` into `by_p`.
    fn finish(&self, work: &mut Work<S>) {
        let Work { u, momentum, stage, by_q, by_p, .. } = work;
        let zero = S::from_f64(0.0);
        let is_explicit = self.scheme.unknowns == Unknowns::None;
        for (s, l, terms) in stages(self.scheme).filter(|(_, l, _)| *l != 0.0) {
            // With one quadrature point `l < 1` the forces at the solution follow from `v`.
            if !is_explicit && l != 1.0 && self.has_one_point() {
                continue;
            }
            for (point, (&q, &u)) in stage[s].iter_mut().zip(self.q.iter().zip(&*u)) {
                *point = q + u * l;
            }
            by_q[s].fill(zero);
            let at = self.at(&stage[s], momentum, l);
            self.system.slopes(Terms { by_p: false, ..terms }, &at, &mut by_q[s], by_p);
        }
        let is_both = self.scheme.unknowns == Unknowns::Both;
        for (i, dp) in by_p.iter_mut().enumerate() {
            let v = match self.scheme.unknowns {
                Unknowns::None => -by_node(&by_q[0], self.scheme, i),
                _ => work.x[if is_both { 2 * i + 1 } else { i }],
            };
            let l = self.scheme.drift_l;
            if !is_explicit && l != 1.0 && self.has_one_point() {
                *dp = v * (1.0 / (1.0 - l));
                continue;
            }
            *dp = v;
            for (s, l, _) in stages(self.scheme).filter(|(_, l, _)| *l != 0.0) {
                *dp = *dp - by_q[s][i] * l;
            }
        }
        if is_explicit {
            // `v` is `P - p_i`, of which the sum has taken digits: the slopes are still there if nothing is at l = 1.
            let all_at_start = stages(self.scheme).all(|(_, l, _)| l == 0.0);
            if !all_at_start {
                for (i, dp) in by_p.iter_mut().enumerate() {
                    let mut sum = momentum[i] - self.p[i];
                    for (s, l, _) in stages(self.scheme).filter(|(_, l, _)| *l != 0.0) {
                        sum = sum - by_q[s][i] * l;
                    }
                    *dp = sum;
                }
            }
        }
    }

    fn has_one_point(&self) -> bool {
        !self.scheme.has_noise || self.scheme.drift_l == self.scheme.noise_l
    }
}

/// The slope that an explicit step found at `q_i`.
fn by_node<S: Scalar>(by_q: &[S], scheme: &Scheme, i: usize) -> S {
    if stages(scheme).any(|(_, l, _)| l == 0.0) { by_q[i] } else { S::from_f64(0.0) }
}

/// `x -= correction`, and how large that was.
fn subtract<S: Scalar>(x: &mut [S], correction: &[S]) -> Size {
    for (x, &c) in x.iter_mut().zip(correction) {
        *x = *x - c;
    }
    size_of_correction(x, correction)
}

/// How large a correction is that leads to `x`.
pub(super) fn size_of_correction<S: Scalar>(x: &[S], correction: &[S]) -> Size {
    let (size, change) = (largest(x), largest(correction));
    if !change.is_finite() {
        return Size { relative: f64::NAN, largest: f64::NAN };
    }
    let mut relative = if change == 0.0 { 0.0 } else { change / (size + f64::MIN_POSITIVE) };
    if size_of::<S>() != size_of::<f64>() {
        // Numbers that carry derivatives or lanes converge in every part.
        for (&x, &c) in x.iter().zip(correction) {
            if c.magnitude() != 0.0 || !(c.relative_to(x, None) == 0.0) {
                let part = c.relative_to(x, Some(S::from_f64(size)));
                relative = if part > relative || part.is_nan() { part } else { relative };
            }
        }
    }
    Size { relative, largest: change }
}

/// The largest magnitude; NaN if any is. In lanes, so that it does not wait for itself.
pub(super) fn largest<S: Scalar>(x: &[S]) -> f64 {
    let mut lanes = [0.0_f64; 8];
    // Sums of squares show NaN and infinity, which a maximum may swallow.
    let mut poison = [0.0_f64; 8];
    let (chunks, rest) = x.as_chunks::<8>();
    let mut take = |lane: usize, x: S| {
        let size = x.magnitude();
        lanes[lane] = if size > lanes[lane] { size } else { lanes[lane] };
        poison[lane] += size * 0.0;
    };
    for chunk in chunks {
        for (lane, &x) in chunk.iter().enumerate() {
            take(lane, x);
        }
    }
    for (lane, &x) in rest.iter().enumerate() {
        take(lane, x);
    }
    let most = lanes.into_iter().fold(0.0, f64::max);
    most + poison.into_iter().sum::<f64>()
}
