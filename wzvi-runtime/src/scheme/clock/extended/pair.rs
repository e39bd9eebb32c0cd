//! The explicit pair of `K = g(q) (H + p_t)` for `H = p · M⁻¹ p/2 + V(q)`: [`Extended<Verlet>`].
//!
//! `DeltaPlus` and `DeltaMinus` of `K` need the solution of one scalar equation each, for `D = H + p_t` and
//! for `γ`, the value of `g` at the end:
//!
//! ```text
//! Plus(e)    a = p - e g V',   D = T(a - e D g') + V + p_t,   P = a - e D g',   q' = q + e g M⁻¹P,   t' = t + e g
//! Minus(e)   γ = g(q + e γ M⁻¹P),   q' = q + e γ M⁻¹P,   D = T(P) + V(q') + p_t,   p' = P - e (γ V' + D g')(q'),
//!            t' = t + e γ
//! ```
//!
//! The equation for `D` is quadratic, `A D² + B D + C = 0` with `A = e² g' · M⁻¹g'/2`,
//! `B = -(1 + e g' · M⁻¹a)`, `C = T(a) + V + p_t`; its root that goes to `C` with `e` is
//! `2C/(-B + √(B² - 4AC))`. The equation for `γ` is solved by Newton's method, with the slope
//! `1 - e g' · M⁻¹P`. A step of `Verlet` is `Plus(ε/2)`, then `Minus(ε/2)`: symmetric and symplectic, as its
//! compositions are. `V'` and `g'` at a node serve both sides of it.
//!
//! [`Extended<Verlet>`]: super::super::Extended

use std::marker::PhantomData;

use super::super::evaluation::{SystemIn, is_positive};
use super::super::{ClockReading, Extended, Extends, text};
use super::{ExtendedMemory, ExtendedState, ExtendedStep, add, advance, prepare, properties};
use crate::algebra::memory::step_memory;
use crate::algebra::scalar::{ComputesWith, Constant, Scalar};
use crate::algebra::solve::Effort;
use crate::algebra::state_sum::{PlainSum, StateSum};
use crate::error::{ConfigError, StepFailure, wrong};
use crate::scheme::compose::{
    BasicMethod, ComposedWord, Composes, SingleStep, Symmetric, Verlet, WholeOf, plan,
};
use crate::scheme::elements::{Elements, PairColumns, Role};
use crate::scheme::plan::{KeptEnergy, Plan};
use crate::scheme::system::{Discretized, LiftParameter, Movable, Properties, Scheme, StepArguments};
use crate::scheme::word::{Substep, Weighted, Word};

/// Steps `W` of the explicit pair.
#[derive(Clone, Copy, Debug)]
pub struct ExplicitPair<W>(PhantomData<W>);

impl<H> Discretized<Extended<Verlet>> for H
where
    H: Elements + Extends + Discretized<Verlet>,
    SingleStep: Composes<Extended<Verlet>, H::Structure, Steps: Scheme<H>>,
{
    type Scheme = WholeOf<H, Extended<Verlet>>;
    type Prepared = <Self::Scheme as Scheme<H>>::Prepared<f64>;
    const EQUATIONS: &'static str = text::ExtendedText::<H, Verlet>::PAIR;
}

impl<K> Symmetric<K> for Extended<Verlet> {
    type Basic = Self;
    type Adjoint = Self;
    type Part = BasicMethod;
    type Steps<W> = ExplicitPair<W>;
    const STEP: &'static [Weighted<BasicMethod>] = &[
        Weighted { part: BasicMethod::Itself, weight: 0.5 },
        Weighted { part: BasicMethod::Adjoint, weight: 0.5 },
    ];
}

impl<H, T, W> Scheme<H> for ExplicitPair<ComposedWord<Extended<Verlet>, T, W>>
where
    H: Elements + Extends,
    W: Composes<Extended<Verlet>, T, Part = BasicMethod> + Composes<Verlet, T>,
    <W as Composes<Verlet, T>>::Steps: Scheme<H>,
{
    const PLAN: Plan = plan(H::FACTS.explicit(), <W as Composes<Extended<Verlet>, T>>::ORDER);
    const PROPERTIES: Properties =
        properties(Properties::of(&<Self as Scheme<H>>::PLAN, 1), KeptEnergy::Nearly);
    /// The word of a step, and the parameters.
    type Prepared<K: Constant> = (Word<BasicMethod>, Vec<K>);
    type Memory<S: Scalar> = ExtendedMemory<S::Constant, PairNode<S::Constant>>;
    type Unclocked = <W as Composes<Verlet, T>>::Steps;
    type CompensatedSum<S: Scalar> = PlainSum;
    type Sum<S: Scalar> = PlainSum;

    fn prepare<K: Constant>(
        system: &H,
        lift: LiftParameter<'_, K>,
        _: K,
    ) -> Result<Self::Prepared<K>, ConfigError> {
        if H::READS_TIME {
            return wrong(
                "the explicit steps of `Extended<Verlet>` take no Hamiltonian and no clock that read the \
                 time; write `Extended<Gauss<S>>`",
            );
        }
        Ok((<W as Composes<Extended<Verlet>, T>>::word(), prepare(system, lift)?))
    }

    fn resize<K: Constant>(
        _: &H,
        _: LiftParameter<'_, K>,
        _: &mut Self::Prepared<K>,
        _: K,
    ) -> Result<(), ConfigError> {
        Ok(())
    }

    fn advance<K: Constant, S: ComputesWith<K>, C: StateSum<S>, const CAREFUL: bool>(
        system: &H,
        (word, parameters): &Self::Prepared<K>,
        at: StepArguments<'_, S, K, impl Movable<S> + ?Sized>,
        memory: &mut Self::Memory<S>,
        _: &mut C,
    ) -> Result<Effort, StepFailure> {
        let system = SystemIn { system, parameters: S::varied(parameters) };
        advance(&PairWord(word), &system, at.lists().shared(), memory)
    }

    fn reading(memory: &Self::Memory<f64>) -> ClockReading {
        memory.reading
    }
}

/// Steps of both halves of the pair.
pub(super) struct PairWord<'a>(pub(super) &'a Word<BasicMethod>);

/// The forces at the last node, which the next step begins with.
#[derive(Debug, Default)]
pub struct PairNode<N: Scalar> {
    /// The coordinates of the node; empty where none is known.
    place: Vec<N>,
    /// `g`
    period: N,
    /// `V`
    potential: N,
    /// `g'`
    by_period: Vec<N>,
    /// `V'`
    by_potential: Vec<N>,
    /// Momenta of zero.
    zeros: Vec<N>,
    /// `M⁻¹P`, or `M⁻¹a`
    velocity: Vec<N>,
    /// `M⁻¹g'`
    gradient: Vec<N>,
    /// `a`
    kicked: Vec<N>,
    /// The rounding errors of coordinates and momenta.
    lost: [Vec<N>; 2],
    columns: PairColumns,
}

step_memory! {
    impl[N: Scalar] StepMemory for PairNode<N> {
        kept: ;
        scratch: place, period, potential, by_period, by_potential, zeros, velocity, gradient, kicked, lost,
            columns
    }
}

impl<H: Elements + Extends, N: Constant<Constant = N>> ExtendedStep<H, N> for PairWord<'_> {
    type Memory = PairNode<N>;

    fn take(
        &self,
        system: &SystemIn<'_, H, N>,
        eps: N,
        state: &mut ExtendedState<N>,
        node: &mut PairNode<N>,
    ) -> Result<Effort, StepFailure> {
        let degrees = state.q.len();
        node.fit(degrees, &mut state.carry);
        for Substep { part, weight, node: reached, .. } in &self.0.substeps {
            let none = StepFailure::NoSolution { reached: reached.clamp(0.0, 1.0) };
            match part {
                BasicMethod::Itself => plus(system, eps * *weight, state, node, none)?,
                BasicMethod::Adjoint => minus(system, eps * *weight, state, node, none)?,
            }
        }
        let [lost_q, lost_p] = &node.lost;
        state.carry.keep(lost_q, lost_p);
        Ok(Effort::fast(0))
    }
}

impl<N: Constant<Constant = N>> PairNode<N> {
    /// Lists for so many degrees of freedom, and the rounding errors of the state.
    fn fit(&mut self, degrees: usize, carry: &mut impl StateSum<N>) {
        let zero = N::from_f64(0.0);
        let Self { by_period, by_potential, zeros, velocity, gradient, kicked, .. } = self;
        for list in [by_period, by_potential, zeros, velocity, gradient, kicked] {
            list.resize(degrees, zero);
        }
        for (own, lost) in self.lost.iter_mut().zip(carry.lists(degrees)) {
            own.clear();
            own.extend_from_slice(lost);
        }
    }

    /// `g` and `g'`
    fn read_clock<H: Elements + Extends>(
        &mut self,
        system: &SystemIn<'_, H, N>,
        q: &[N],
    ) -> Result<(), StepFailure> {
        let zero = N::from_f64(0.0);
        self.place.clear();
        self.period = system.period(zero, q, &self.zeros)?;
        system.by_q(Role::Clock, zero, [q, &self.zeros], &mut self.by_period, &mut self.columns);
        Ok(())
    }

    /// `V` and `V'`, after the clock was read there.
    fn read_potential<H: Elements>(&mut self, system: &SystemIn<'_, H, N>, q: &[N]) {
        let (zero, at) = (N::from_f64(0.0), [q, &self.zeros[..]]);
        self.potential = system.value(Role::Drift, zero, at);
        system.by_q(Role::Drift, zero, at, &mut self.by_potential, &mut self.columns);
        self.place.clear();
        self.place.extend_from_slice(q);
    }

    /// All of that, unless it is known.
    fn read<H: Elements + Extends>(
        &mut self,
        system: &SystemIn<'_, H, N>,
        q: &[N],
    ) -> Result<(), StepFailure> {
        let is_known =
            self.place.len() == q.len() && self.place.iter().zip(q).all(|(a, b)| a.is_identical(*b));
        if !is_known {
            self.read_clock(system, q)?;
            self.read_potential(system, q);
        }
        Ok(())
    }
}

/// `Σ_i a_i b_i`
fn dot<N: Scalar>(a: &[N], b: &[N]) -> N {
    a.iter().zip(b).fold(N::from_f64(0.0), |sum, (a, b)| sum + *a * *b)
}

/// `Plus(e)`
fn plus<H: Elements + Extends, N: Constant<Constant = N>>(
    system: &SystemIn<'_, H, N>,
    e: N,
    ExtendedState { time, q, p, .. }: &mut ExtendedState<N>,
    node: &mut PairNode<N>,
    none: StepFailure,
) -> Result<(), StepFailure> {
    node.read(system, q)?;
    let PairNode {
        period,
        potential,
        by_period,
        by_potential,
        velocity,
        gradient,
        kicked,
        lost,
        columns,
        ..
    } = node;
    let (g, zero) = (*period, N::from_f64(0.0));
    for ((a, p), force) in kicked.iter_mut().zip(&*p).zip(&*by_potential) {
        *a = *p - e * g * *force;
    }
    system.by_p(Role::Drift, zero, [q, kicked], velocity, columns);
    system.by_p(Role::Drift, zero, [q, by_period], gradient, columns);
    let a = e * e * dot(by_period, gradient) * 0.5;
    let minus_b = e * dot(by_period, velocity) + 1.0;
    let c = dot(kicked, velocity) * 0.5 + *potential + time.momentum;
    let discriminant = minus_b * minus_b - a * c * 4.0;
    // Where `-B` is not positive, the root that goes to `C` has met the other one.
    if !is_positive(minus_b.lane(0)) || !is_positive(discriminant.lane(0)) {
        return Err(none);
    }
    let excess = c * 2.0 / (minus_b + discriminant.sqrt());
    add(p, &mut lost[1], |i| -e * (g * by_potential[i] + excess * by_period[i]));
    system.by_p(Role::Drift, zero, [q, p], velocity, columns);
    let duration = e * g;
    add(q, &mut lost[0], |i| duration * velocity[i]);
    time.move_time(duration);
    Ok(())
}

/// The most corrections of `γ`: Newton's method takes 3 to 6.
const MOST_CORRECTIONS: u32 = 30;
/// The relative change of `γ` below which only rounding may keep it from falling further.
const NEARLY_SOLVED: f64 = 1e-11;

/// `Minus(e)`
fn minus<H: Elements + Extends, N: Constant<Constant = N>>(
    system: &SystemIn<'_, H, N>,
    e: N,
    ExtendedState { time, q, p, .. }: &mut ExtendedState<N>,
    node: &mut PairNode<N>,
    none: StepFailure,
) -> Result<(), StepFailure> {
    let (zero, one) = (N::from_f64(0.0), N::from_f64(1.0));
    system.by_p(Role::Drift, zero, [q, p], &mut node.velocity, &mut node.columns);
    // From the value at the last node, to first order.
    let mut gamma = node.period * (one + e * 2.0 * dot(&node.by_period, &node.velocity));
    if !is_positive(gamma.lane(0)) {
        gamma = node.period;
    }
    let (mut last, mut solved, mut corrections) = (f64::INFINITY, 0, 0);
    // A correction of a dual number makes one order of its derivatives right, two make all.
    let wanted = if size_of::<N>() == size_of::<f64>() { 1 } else { 3 };
    while solved < wanted {
        if corrections == MOST_CORRECTIONS {
            return Err(none);
        }
        let duration = e * gamma;
        for ((there, here), (velocity, lost)) in
            node.kicked.iter_mut().zip(&*q).zip(node.velocity.iter().zip(&node.lost[0]))
        {
            *there = *here + (duration * *velocity + *lost);
        }
        let there = std::mem::take(&mut node.kicked);
        let read = node.read_clock(system, &there);
        node.kicked = there;
        read?;
        let slope = one - e * dot(&node.by_period, &node.velocity);
        if !is_positive(slope.lane(0)) {
            return Err(none);
        }
        let correction = (node.period - gamma) / slope;
        gamma = gamma + correction;
        corrections += 1;
        let change = (correction.lane(0) / gamma.lane(0)).abs();
        if change <= 2.0 * f64::EPSILON || change < NEARLY_SOLVED && change >= last || solved > 0 {
            solved += 1;
        }
        last = change;
    }
    let duration = e * gamma;
    add(q, &mut node.lost[0], |i| duration * node.velocity[i]);
    let kinetic = dot(p, &node.velocity) * 0.5;
    node.read_potential(system, q);
    let excess = kinetic + node.potential + time.momentum;
    let (force, slope) = (&node.by_potential, &node.by_period);
    add(p, &mut node.lost[1], |i| -e * (gamma * force[i] + excess * slope[i]));
    time.move_time(duration);
    Ok(())
}
