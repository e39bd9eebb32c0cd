//! One step: `x = φ(x)` solved to rounding.

use super::memory::Work;
use super::{CONTRACTS, Curvature, Elements, Iteration, Memory, Point, Terms};
use crate::carry::Carry;
use crate::error::StepFailure;
use crate::scalar::{Mask, Scalar};
use crate::solve::Banded;
use crate::system::Solved;

/// Corrections below this fraction of the largest unknown change nothing.
const ROUNDING: f64 = f64::EPSILON;
/// Stagnation counts as convergence below this fraction of the state.
const STAGNATION: f64 = 1e-9;
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
struct Step<'a, H, S> {
    system: &'a H,
    scheme: &'a Scheme,
    t: f64,
    h: f64,
    q: &'a [S],
    p: &'a [S],
    dw: &'a [S],
}

/// One step from `(q, p)` at `t` in place; on `Err` nothing but scratch is changed.
///
/// # Errors
/// [`StepFailure`]: sizes that do not fit, no convergence, a singular Jacobian, a state that is not finite.
#[expect(clippy::too_many_arguments, reason = "as `Discretized::advance_carrying`")]
pub fn advance<H: Elements, S: Scalar, C: Carry<S>>(
    system: &H,
    scheme: &Scheme,
    t: f64,
    h: f64,
    q: &mut [S],
    p: &mut [S],
    dw: &[S],
    memory: &mut Memory<S>,
    carry: &mut C,
) -> Result<Solved, StepFailure> {
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
    let iterations = step.solve(memory)?;
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
        memory.forget();
        return Err(StepFailure::NonFinite);
    }
    q.copy_from_slice(u);
    p.copy_from_slice(dp);
    if C::CARRIES {
        carry.keep(lost_q, lost_p);
    }
    memory.record();
    Ok(Solved { iterations })
}

impl<S: Scalar> Memory<S> {
    /// `3x_n - 3x_{n-1} + x_{n-2}` of the past, as far as it is known, or zero.
    fn guess(&mut self) {
        let x = &mut self.work.x;
        let [a, b, c] = &self.past;
        match self.known {
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

/// The largest correction against the largest unknown, and the same against the state; NaN if any part is.
struct Size {
    relative: f64,
    correction: f64,
}

impl<H: Elements, S: Scalar> Step<'_, H, S> {
    /// `φ` at `x`, for the scheme's unknowns, as the correction `x - φ(x)`; leaves `u`, `P`, the stages and slopes.
    fn residual(&self, work: &mut Work<S>) {
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

    fn at<'b>(&'b self, q: &'b [S], p: &'b [S], l: f64) -> Point<'b, S> {
        Point { q, p, t: self.t + l * self.h, h: self.h, dw: self.dw }
    }

    /// Solves for the unknowns; the number of iterations.
    fn solve(&self, memory: &mut Memory<S>) -> Result<u32, StepFailure> {
        if self.scheme.unknowns == Unknowns::None {
            self.explicit(&mut memory.work);
            return Ok(0);
        }
        memory.guess();
        let pinned = memory.iteration;
        let first = self.iterate(memory, pinned);
        // A start that misleads is given up for zero, and what was tried for Newton's method from there.
        let may_try_again = memory.known > 0 || pinned == Iteration::Automatic;
        if first.is_ok() || !may_try_again {
            return first;
        }
        memory.forget();
        memory.guess();
        let last_resort = if pinned == Iteration::Automatic { Iteration::Newton } else { pinned };
        self.iterate(memory, last_resort)
    }

    /// `v` from the terms at `q_i`, then `u`.
    fn explicit(&self, work: &mut Work<S>) {
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

    fn iterate(&self, memory: &mut Memory<S>, iteration: Iteration) -> Result<u32, StepFailure> {
        let Memory { work, matrix, has_factors, .. } = memory;
        let mut newton =
            iteration == Iteration::Newton || (*has_factors && iteration == Iteration::Automatic);
        let mut last = f64::INFINITY;
        for iterations in 1..=MOST_ITERATIONS {
            self.residual(work);
            if newton {
                let Some(matrix) = matrix.as_mut() else {
                    return Err(StepFailure::NotConverged { iterations, correction: last });
                };
                if !*has_factors || iteration == Iteration::Newton {
                    *has_factors = false;
                    self.assemble(work, matrix);
                    matrix.factor()?;
                    *has_factors = true;
                }
                matrix.solve(&mut work.correction);
            }
            let Size { relative, correction } = subtract(&mut work.x, &work.correction);
            if relative.is_nan() {
                *has_factors = false;
                return Err(StepFailure::NonFinite);
            }
            let ratio = relative / last;
            let predicts = last < f64::INFINITY && ratio < 0.5;
            if relative <= ROUNDING || (predicts && relative * ratio <= 0.25 * ROUNDING) {
                self.refresh(work);
                return Ok(iterations);
            }
            let is_slow = last < f64::INFINITY && ratio > CONTRACTS;
            let is_small = is_slow && self.is_rounding(work, correction);
            if is_small && ratio > 0.5 {
                self.refresh(work);
                return Ok(iterations);
            }
            if iterations == MOST_ITERATIONS {
                return Err(StepFailure::NotConverged { iterations, correction });
            }
            if iteration == Iteration::Automatic && is_slow && !is_small {
                // Old factors, or none, do not contract. Near rounding nothing does.
                (newton, *has_factors) = (matrix.is_some(), false);
            }
            last = relative;
        }
        Err(StepFailure::NotConverged { iterations: MOST_ITERATIONS, correction: last })
    }

    /// `u` and `P` at the solution.
    fn refresh(&self, work: &mut Work<S>) {
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
    fn is_rounding(&self, work: &Work<S>, correction: f64) -> bool {
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

    /// `I - φ'` at the current stages.
    fn assemble(&self, work: &mut Work<S>, matrix: &mut Banded<S>) {
        let Work { stage, momentum, diagonal, .. } = work;
        matrix.reset();
        if self.scheme.unknowns == Unknowns::Momenta {
            diagonal.fill(S::from_f64(0.0));
            for (_, l, terms) in stages(self.scheme) {
                let at = self.at(self.q, momentum, l);
                self.system.curvature(Terms { by_q: false, ..terms }, &at, &mut Diagonal(diagonal));
            }
        }
        for (s, l, terms) in stages(self.scheme) {
            let at = self.at(&stage[s], momentum, l);
            match self.scheme.unknowns {
                Unknowns::Both => self.system.curvature(terms, &at, &mut Coupled { matrix: &mut *matrix, l }),
                _ => {
                    let terms = Terms { by_p: false, ..terms };
                    self.system.curvature(terms, &at, &mut Reduced { matrix: &mut *matrix, diagonal, l });
                }
            }
        }
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
    let (mut largest_x, mut largest, mut nan) = (0.0_f64, 0.0_f64, false);
    let mut relative = 0.0_f64;
    for (x, &c) in x.iter_mut().zip(correction) {
        *x = *x - c;
        let (size, change) = (x.magnitude(), c.magnitude());
        nan |= change.is_nan();
        largest_x = if size > largest_x { size } else { largest_x };
        largest = if change > largest { change } else { largest };
    }
    if nan || largest.is_infinite() {
        return Size { relative: f64::NAN, correction: f64::NAN };
    }
    if size_of::<S>() != size_of::<f64>() {
        // Numbers that carry derivatives or lanes converge in every part.
        for (&x, &c) in x.iter().zip(correction) {
            if c.magnitude() != 0.0 || !(c.relative_to(x, None) == 0.0) {
                let part = c.relative_to(x, Some(S::from_f64(largest_x)));
                relative = if part > relative || part.is_nan() { part } else { relative };
            }
        }
    }
    let by_value = if largest == 0.0 { 0.0 } else { largest / (largest_x + f64::MIN_POSITIVE) };
    Size { relative: if relative > by_value { relative } else { by_value }, correction: largest }
}

/// `∂u/∂v`, which the choice of unknowns has shown to be diagonal where it is needed.
struct Diagonal<'a, S>(&'a mut [S]);

impl<S: Scalar> Curvature<S> for Diagonal<'_, S> {
    #[inline(always)]
    fn add_qq(&mut self, _: usize, _: usize, _: bool, _: S) {}
    #[inline(always)]
    fn add_qp(&mut self, _: usize, _: usize, _: bool, _: S) {}
    #[inline(always)]
    fn add_pp(&mut self, i: usize, _: usize, is_diagonal: bool, value: S) {
        if is_diagonal {
            self.0[i] = self.0[i] + value;
        }
    }
}

/// `∂(v - φ_v)/∂v` with `∂u/∂v = D`: `I + Σ (1 - l) (l F_qq D + F_qp)`.
struct Reduced<'a, S> {
    matrix: &'a mut Banded<S>,
    diagonal: &'a [S],
    l: f64,
}

impl<S: Scalar> Curvature<S> for Reduced<'_, S> {
    #[inline(always)]
    fn add_qq(&mut self, i: usize, j: usize, is_diagonal: bool, value: S) {
        let weighted = value * (self.l * (1.0 - self.l));
        self.matrix.add(i, j, weighted * self.diagonal[j]);
        if !is_diagonal {
            self.matrix.add(j, i, weighted * self.diagonal[i]);
        }
    }
    #[inline(always)]
    fn add_qp(&mut self, i: usize, j: usize, _: bool, value: S) {
        self.matrix.add(i, j, value * (1.0 - self.l));
    }
    #[inline(always)]
    fn add_pp(&mut self, _: usize, _: usize, _: bool, _: S) {}
}

/// The Jacobian of `(u - φ_u, v - φ_v)`, unknowns `u_0, v_0, u_1, v_1, ...`
struct Coupled<'a, S> {
    matrix: &'a mut Banded<S>,
    l: f64,
}

impl<S: Scalar> Curvature<S> for Coupled<'_, S> {
    #[inline(always)]
    fn add_qq(&mut self, i: usize, j: usize, is_diagonal: bool, value: S) {
        let weighted = value * (self.l * (1.0 - self.l));
        self.matrix.add(2 * i + 1, 2 * j, weighted);
        if !is_diagonal {
            self.matrix.add(2 * j + 1, 2 * i, weighted);
        }
    }
    #[inline(always)]
    fn add_qp(&mut self, i: usize, j: usize, _: bool, value: S) {
        self.matrix.add(2 * i + 1, 2 * j + 1, value * (1.0 - self.l));
        self.matrix.add(2 * j, 2 * i, -(value * self.l));
    }
    #[inline(always)]
    fn add_pp(&mut self, i: usize, j: usize, is_diagonal: bool, value: S) {
        self.matrix.add(2 * i, 2 * j + 1, -value);
        if !is_diagonal {
            self.matrix.add(2 * j, 2 * i + 1, -value);
        }
    }
}
