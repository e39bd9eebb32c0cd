//! Systems written by hand, as the compiler would write them: fixtures for the runtime.

use nalgebra::{DVector, SVector};
use wzvi_runtime::algebra::carry::{Carry, Plain};
use wzvi_runtime::algebra::scalar::{Constant, Mask, Over, Rounded, Scalar};
use wzvi_runtime::algebra::solve::{Block, Effort, Extrapolation, newton};
use wzvi_runtime::algebra::state::State;
use wzvi_runtime::error::{ConfigError, StepFailure};
use wzvi_runtime::scheme::embedding::{DeltaPlus, Midpoint};
use wzvi_runtime::scheme::plan::{Knowledge, NoiseClass, Plan, Solver};
use wzvi_runtime::scheme::system::{At, Hamiltonian, LagrangianGradient, Lift, Listed, Scheme, Segment};

pub(crate) type V1 = SVector<f64, 1>;

fn one<S: Scalar>(slice: &[S], what: fn(usize, usize) -> StepFailure) -> Result<S, StepFailure> {
    match slice {
        [x] => Ok(*x),
        _ => Err(what(1, slice.len())),
    }
}

fn dimension(expected: usize, got: usize) -> StepFailure {
    StepFailure::Dimension { expected, got }
}

fn increments(expected: usize, got: usize) -> StepFailure {
    StepFailure::Increments { expected, got }
}

fn finite<S: Scalar>(x: S, y: S) -> Result<(), StepFailure> {
    if (x.is_finite() & y.is_finite()).all() { Ok(()) } else { Err(StepFailure::NonFinite) }
}

/// Kubo: `H_0 = a (q² + p²)/2`, `H_1 = σ (q² + p²)/2`.
#[derive(Clone, Debug)]
pub(crate) struct Kubo {
    pub(crate) a: f64,
    pub(crate) sigma: f64,
}

impl Kubo {
    /// The solution of the Stratonovich system: the rotation by `φ = a t + σ W`.
    pub(crate) fn exact(&self, start: &State<V1>, t: f64, w: f64) -> [f64; 2] {
        let (sin, cos) = (self.a * t + self.sigma * w).sin_cos();
        let (q, p) = (start.q[0], start.p[0]);
        [p * sin + q * cos, p * cos - q * sin]
    }

    /// `θ` of the Cayley map.
    pub(crate) fn theta(&self, h: f64, dw: f64) -> f64 {
        0.5 * (self.a * h + self.sigma * dw)
    }
}

impl Hamiltonian for Kubo {
    type Vector = V1;
    fn degrees(&self) -> usize {
        1
    }
    fn noises(&self) -> usize {
        1
    }
    fn invariants(&self) -> usize {
        1
    }
    fn evaluate<S: Scalar>(&self, term: usize, q: &[S], p: &[S], _t: f64) -> S {
        match (term, q, p) {
            (0, [q], [p]) => (*q * *q + *p * *p) * (0.5 * self.a),
            (1, [q], [p]) => (*q * *q + *p * *p) * (0.5 * self.sigma),
            _ => S::from_f64(f64::NAN),
        }
    }
    fn differentiate<S: Scalar>(&self, term: usize, q: &[S], p: &[S], _t: f64, dq: &mut [S], dp: &mut [S]) {
        let factor = [self.a, self.sigma].get(term).copied().unwrap_or(f64::NAN);
        dq[0] = q[0] * factor;
        dp[0] = p[0] * factor;
    }
    fn invariant(&self, index: usize, state: &State<V1>) -> f64 {
        if index == 0 { state.q[0] * state.q[0] + state.p[0] * state.p[0] } else { f64::NAN }
    }
    fn energy_rate(&self, _k: usize, _state: &State<V1>) -> f64 {
        0.0
    }
}

impl Listed<Midpoint> for Kubo {
    type Scheme = Midpoint;
    const TEXT: &'static str = "";
}

impl Scheme<Kubo> for Midpoint {
    const PLAN: Plan = Plan {
        solver: Solver::Linear,
        unknowns: 2,
        order: 2,
        noise: NoiseClass::Multiplicative,
        consistent: true,
        conserves_energy: Knowledge::Proven,
        commuting: Knowledge::Proven,
    };
    type Prepared<K: Constant> = ();
    type Memory<S: Scalar> = ();
    type Compensated<S: Scalar> = Plain;
    type Carry<S: Scalar> = Plain;
    fn prepare<K: Constant>(system: &Kubo, _: Lift<'_, K>, h: K) -> Result<(), ConfigError> {
        if (h * system.a).is_finite().all() && system.sigma.is_finite() {
            Ok(())
        } else {
            Err(ConfigError::Parameter)
        }
    }
    fn advance<K: Constant, S: Over<K>, C: Carry<S>, const CAREFUL: bool>(
        system: &Kubo,
        _prepared: &(),
        At { h, q, p, dw, .. }: At<'_, S, K>,
        _memory: &mut (),
        _carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        let (q0, p0, dw) = (one(q, dimension)?, one(p, dimension)?, one(dw, increments)?);
        let theta = (dw * system.sigma + h * system.a) * 0.5;
        let factor = theta * 2.0 / (theta * theta + 1.0);
        let (q1, p1) = (q0 + factor * (p0 - theta * q0), p0 - factor * (q0 + theta * p0));
        finite(q1, p1)?;
        (q[0], p[0]) = (q1, p1);
        Ok(Effort::default())
    }
    fn discrete_lagrangian(system: &Kubo, s: &Segment<V1>, dw: &[f64]) -> f64 {
        let [dw] = dw else { return f64::NAN };
        let (p, q) = (s.p[0], 0.5 * (s.q0[0] + s.q1[0]));
        p * (s.q1[0] - s.q0[0]) - system.theta(s.h, *dw) * (p * p + q * q)
    }
    fn discrete_lagrangian_gradient(system: &Kubo, s: &Segment<V1>, dw: &[f64]) -> LagrangianGradient<V1> {
        let theta = system.theta(s.h, dw[0]);
        let middle = (s.q0 + s.q1) * 0.5;
        LagrangianGradient {
            q0: -s.p - middle * theta,
            q1: s.p - middle * theta,
            p: s.q1 - s.q0 - s.p * (2.0 * theta),
        }
    }
    fn step_momentum(system: &Kubo, before: &State<V1>, after: &State<V1>, h: f64, dw: &[f64]) -> V1 {
        before.p - (before.q + after.q) * (0.5 * system.theta(h, dw[0]))
    }
}

/// Pendulum: `H = p²/2 - ω² cos q`, deterministic, one Newton unknown `x = Q - q`.
#[derive(Clone, Debug)]
pub(crate) struct Pendulum {
    pub(crate) omega: f64,
}

impl Hamiltonian for Pendulum {
    type Vector = V1;
    fn degrees(&self) -> usize {
        1
    }
    fn noises(&self) -> usize {
        0
    }
    fn invariants(&self) -> usize {
        0
    }
    fn evaluate<S: Scalar>(&self, term: usize, q: &[S], p: &[S], _t: f64) -> S {
        match (term, q, p) {
            (0, [q], [p]) => *p * *p * 0.5 - q.cos() * (self.omega * self.omega),
            _ => S::from_f64(f64::NAN),
        }
    }
    fn differentiate<S: Scalar>(&self, _term: usize, q: &[S], p: &[S], _t: f64, dq: &mut [S], dp: &mut [S]) {
        dq[0] = q[0].sin() * (self.omega * self.omega);
        dp[0] = p[0];
    }
    fn invariant(&self, _index: usize, _state: &State<V1>) -> f64 {
        f64::NAN
    }
    fn energy_rate(&self, _k: usize, _state: &State<V1>) -> f64 {
        f64::NAN
    }
}

/// The equation of half the increment, `x = h/2 p0 - h kick / 4 sin(q0 + x)`, and its slope.
fn half_step<K: Constant, S: Over<K>>(h: K, kick: K, q0: S, p0: S, x: S) -> ([S; 1], [[S; 1]; 1]) {
    let (sin, cos) = (q0 + x).sin_cos();
    ([x - p0 * (h * 0.5) + sin * (h * 0.25 * kick)], [[cos * (h * 0.25 * kick) + 1.0]])
}

impl Listed<Midpoint> for Pendulum {
    type Scheme = Midpoint;
    const TEXT: &'static str = "";
}

impl Scheme<Pendulum> for Midpoint {
    const PLAN: Plan = Plan {
        solver: Solver::Newton,
        unknowns: 1,
        order: 2,
        noise: NoiseClass::None,
        consistent: true,
        conserves_energy: Knowledge::Proven,
        commuting: Knowledge::Proven,
    };
    /// `h ω²`
    type Prepared<K: Constant> = K;
    type Memory<S: Scalar> = Extrapolation<S, 1>;
    type Compensated<S: Scalar> = Plain;
    type Carry<S: Scalar> = Plain;
    fn prepare<K: Constant>(system: &Pendulum, lift: Lift<'_, K>, h: K) -> Result<K, ConfigError> {
        let omega = lift(0, system.omega);
        Some(h * omega * omega).filter(|x| x.is_finite().all()).ok_or(ConfigError::Parameter)
    }
    fn advance<K: Constant, S: Over<K>, C: Carry<S>, const CAREFUL: bool>(
        _: &Pendulum,
        &kick: &K,
        At { h, q, p, dw, .. }: At<'_, S, K>,
        memory: &mut Extrapolation<S, 1>,
        _carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        let (q0, p0) = (one(q, dimension)?, one(p, dimension)?);
        if !dw.is_empty() {
            return Err(increments(0, dw.len()));
        }
        let equations = Block {
            evaluate: |&[x]: &[S; 1]| half_step(h, kick, q0, p0, x),
            rounded: |&[x]: &[S; 1], lane: usize| {
                let [q0, p0] = [q0, p0].map(|number| Rounded::exact(number.lane(lane)));
                let [h, kick] = [h, kick].map(|number| number.lane(lane));
                half_step(h, kick, q0, p0, Rounded::nearest(x.lane(lane))).0
            },
        };
        let mut solution = memory.guess::<true>();
        let effort = newton::<_, 1, false, true, CAREFUL>(&mut solution, equations)?;
        let [x] = solution;
        let (q1, p1) = (q0 + x * 2.0, p0 - (q0 + x).sin() * kick);
        finite(q1, p1)?;
        memory.record::<true>([x]);
        (q[0], p[0]) = (q1, p1);
        Ok(effort)
    }
    fn discrete_lagrangian(system: &Pendulum, s: &Segment<V1>, dw: &[f64]) -> f64 {
        if !dw.is_empty() {
            return f64::NAN;
        }
        let (p, q) = (s.p[0], 0.5 * (s.q0[0] + s.q1[0]));
        p * (s.q1[0] - s.q0[0]) - s.h * system.evaluate(0, &[q], &[p], s.t)
    }
    fn discrete_lagrangian_gradient(
        system: &Pendulum,
        s: &Segment<V1>,
        _dw: &[f64],
    ) -> LagrangianGradient<V1> {
        let kick = s.h * system.omega * system.omega * (0.5 * (s.q0[0] + s.q1[0])).sin();
        let half = V1::from([0.5 * kick]);
        LagrangianGradient { q0: -s.p - half, q1: s.p - half, p: s.q1 - s.q0 - s.p * s.h }
    }
    fn step_momentum(system: &Pendulum, before: &State<V1>, after: &State<V1>, h: f64, _dw: &[f64]) -> V1 {
        let kick = h * system.omega * system.omega * (0.5 * (before.q[0] + after.q[0])).sin();
        before.p - V1::from([0.5 * kick])
    }
}

/// Rotors of size known at run time under Δ₊: `H_0 = Σ p²/2`, `H_k = σ cos q_k`; explicit.
#[derive(Clone, Debug)]
pub(crate) struct Rotors {
    pub(crate) count: usize,
    pub(crate) sigma: f64,
}

impl Hamiltonian for Rotors {
    type Vector = DVector<f64>;
    fn degrees(&self) -> usize {
        self.count
    }
    fn noises(&self) -> usize {
        self.count
    }
    fn invariants(&self) -> usize {
        0
    }
    fn evaluate<S: Scalar>(&self, term: usize, q: &[S], p: &[S], _t: f64) -> S {
        match term {
            _ if q.len() != self.count || p.len() != self.count => S::from_f64(f64::NAN),
            0 => p.iter().fold(S::from_f64(0.0), |sum, p| sum + *p * *p * 0.5),
            _ => q.get(term - 1).map_or(S::from_f64(f64::NAN), |q| q.cos() * self.sigma),
        }
    }
    fn differentiate<S: Scalar>(&self, term: usize, q: &[S], p: &[S], _t: f64, dq: &mut [S], dp: &mut [S]) {
        for i in 0..self.count {
            dp[i] = if term == 0 { p[i] } else { S::from_f64(0.0) };
            dq[i] = if term == i + 1 { q[i].sin() * -self.sigma } else { S::from_f64(0.0) };
        }
    }
    fn invariant(&self, _index: usize, _state: &State<DVector<f64>>) -> f64 {
        f64::NAN
    }
    fn energy_rate(&self, k: usize, state: &State<DVector<f64>>) -> f64 {
        self.sigma * state.q[k].sin() * state.p[k]
    }
}

impl Listed<DeltaPlus> for Rotors {
    type Scheme = DeltaPlus;
    const TEXT: &'static str = "";
}

impl Scheme<Rotors> for DeltaPlus {
    const PLAN: Plan = Plan {
        solver: Solver::Explicit,
        unknowns: 0,
        order: 1,
        noise: NoiseClass::Position,
        consistent: true,
        conserves_energy: Knowledge::Refuted,
        commuting: Knowledge::Proven,
    };
    type Prepared<K: Constant> = ();
    type Memory<S: Scalar> = ();
    type Compensated<S: Scalar> = Plain;
    type Carry<S: Scalar> = Plain;
    fn prepare<K: Constant>(_: &Rotors, _: Lift<'_, K>, _: K) -> Result<(), ConfigError> {
        Ok(())
    }
    fn advance<K: Constant, S: Over<K>, C: Carry<S>, const CAREFUL: bool>(
        system: &Rotors,
        _prepared: &(),
        At { h, q, p, dw, .. }: At<'_, S, K>,
        _memory: &mut (),
        _carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        for slice in [&*q, &*p] {
            if slice.len() != system.count {
                return Err(dimension(system.count, slice.len()));
            }
        }
        if dw.len() != system.count {
            return Err(increments(system.count, dw.len()));
        }
        let next = |i: usize, q: &[S], p: &[S]| {
            let p1 = p[i] + dw[i] * q[i].sin() * system.sigma;
            (q[i] + p1 * h, p1)
        };
        for i in 0..system.count {
            let (q1, p1) = next(i, q, p);
            finite(q1, p1)?;
        }
        for i in 0..system.count {
            (q[i], p[i]) = next(i, q, p);
        }
        Ok(Effort::default())
    }
    fn discrete_lagrangian(system: &Rotors, s: &Segment<DVector<f64>>, dw: &[f64]) -> f64 {
        let kinetic: f64 = s.p.dot(&(&s.q1 - &s.q0)) - 0.5 * s.h * s.p.dot(&s.p);
        kinetic - dw.iter().zip(s.q0.iter()).map(|(dw, q)| dw * system.sigma * q.cos()).sum::<f64>()
    }
    fn discrete_lagrangian_gradient(
        system: &Rotors,
        s: &Segment<DVector<f64>>,
        dw: &[f64],
    ) -> LagrangianGradient<DVector<f64>> {
        let kick = DVector::from_fn(system.count, |i, _| system.sigma * dw[i] * s.q0[i].sin());
        LagrangianGradient { q0: kick - &s.p, q1: s.p.clone(), p: &s.q1 - &s.q0 - &s.p * s.h }
    }
    fn step_momentum(
        _: &Rotors,
        _before: &State<DVector<f64>>,
        after: &State<DVector<f64>>,
        _h: f64,
        _dw: &[f64],
    ) -> DVector<f64> {
        after.p.clone()
    }
}

/// Increments without a generator: a Weyl sequence in `(-√(3h), √(3h))`, of variance `h`.
pub(crate) fn path(steps: usize, h: f64) -> Vec<f64> {
    let golden = 0.618_033_988_749_894_9;
    (0..steps).map(|i| ((i as f64 * golden + 0.3).fract() - 0.5) * (12.0 * h).sqrt()).collect()
}
