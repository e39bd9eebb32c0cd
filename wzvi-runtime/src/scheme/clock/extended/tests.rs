//! Steps are symplectic in `(q, t, p, p_t)`, also where `D` is not 0: by dual numbers.

use super::super::evaluation::SystemIn;
use super::gauss::ExtendedGauss;
use super::logarithmic::SplittingWord;
use super::pair::PairWord;
use super::{ExtendedMemory, ExtendedState, ExtendedStep, TimeNode, advance};
use crate::algebra::scalar::{Constant, Dual, Number, Reals, Scalar};
use crate::algebra::shape::Fixed;
use crate::algebra::state_sum::CompensatedSum;
use crate::error::StepFailure;
use crate::ground::numbers::{Numbers as _, Tape};
use crate::scheme::clock::{Attractive, Clock, Extended, Extends, Logarithmic};
use crate::scheme::compose::{Composes, General, Nystrom, SingleStep, Verlet, Yoshida4};
use crate::scheme::elements::{CommonRange, ElementInput, Elements, EvaluationPoint, Partials, Role, Sums};
use crate::scheme::gauss::Field;
use crate::scheme::plan::Facts;
use crate::scheme::system::{LiftParameter, StepArguments};

/// Kepler's problem in the plane with the clock `r^{3/2}`; or a force of changing size on a particle, with a
/// clock of place and momentum.
#[derive(Debug)]
struct Kepler;
#[derive(Debug)]
struct Driven;

impl Elements for Kepler {
    const FACTS: Facts = Facts::autonomous(2);
    type Shape = Fixed<2>;
    type Structure = Nystrom;
    type Vector = nalgebra::SVector<f64, 2>;
    type CommonRange = CommonRange;

    fn value<S: Scalar>(&self, role: Role, _: f64, at: &EvaluationPoint<'_, S>) -> S {
        let (q, p) = (at.q, at.p);
        let square = q[0] * q[0] + q[1] * q[1];
        let kinetic = (p[0] * p[0] + p[1] * p[1]) * 0.5;
        let potential = -square.sqrt().recip();
        match role {
            Role::Drift => kinetic + potential,
            Role::Clock => square.powf(S::from_f64(0.75)),
            Role::Summand(0) => kinetic,
            Role::Summand(1) => potential,
            _ => S::from_f64(0.0),
        }
    }

    fn gradient<S: Scalar, T: Number<S>>(
        &self,
        role: Role,
        _: f64,
        at: &EvaluationPoint<'_, S, impl ElementInput<S> + ?Sized>,
        wanted: Partials,
        by_q: &mut (impl Sums<S> + ?Sized),
        by_p: &mut (impl Sums<S> + ?Sized),
    ) {
        let [x, y] = [0, 1].map(|i| T::of(at.q[i]));
        let square = x * x + y * y;
        let factor = match role {
            Role::Drift | Role::Summand(1) => (square * square.sqrt()).recip(),
            Role::Clock => square.powf(T::from_f64(-0.25)) * 1.5,
            _ => T::from_f64(0.0),
        };
        if wanted.by_q {
            by_q.add(0, x * factor);
            by_q.add(1, y * factor);
        }
        if wanted.by_p && matches!(role, Role::Drift | Role::Summand(0)) {
            by_p.add(0, T::of(at.p[0]));
            by_p.add(1, T::of(at.p[1]));
        }
    }
}

impl Field for Kepler {
    const IS_NYSTROM: bool = true;
    const IN_LANES: bool = true;
    type Noises = Fixed<0>;
    type Parameters = Reals<0>;

    fn parameters<K: Constant>(&self, _: LiftParameter<'_, K>) -> [K; 0] {
        []
    }
}

impl Clock for Kepler {
    const CLOCK: &'static str = "Clock\n  Q = r^(3/2)\n";
}
impl Extends for Kepler {}
impl Attractive for Kepler {}

/// `H = p² (1 + q²/4)/2 + q⁴/4 - 0.3 q cos t`, `Q = 1/√(1 + q² + p²/2)`
impl Elements for Driven {
    const FACTS: Facts = {
        let mut facts = Facts::autonomous(1);
        facts.kind.reads_time = true;
        facts
    };
    type Shape = Fixed<1>;
    type Structure = General;
    type Vector = nalgebra::SVector<f64, 1>;
    type CommonRange = CommonRange;

    fn value<S: Scalar>(&self, role: Role, _: f64, at: &EvaluationPoint<'_, S>) -> S {
        let (q, p) = (at.q[0], at.p[0]);
        match role {
            Role::Drift => {
                p * p * (q * q * 0.25 + 1.0) * 0.5 + q.powi(4) * 0.25 - q * S::of_constant(at.t.cos()) * 0.3
            }
            Role::Clock => (q * q + p * p * 0.5 + 1.0).sqrt().recip(),
            _ => S::from_f64(0.0),
        }
    }

    fn gradient<S: Scalar, T: Number<S>>(
        &self,
        role: Role,
        _: f64,
        at: &EvaluationPoint<'_, S, impl ElementInput<S> + ?Sized>,
        _: Partials,
        by_q: &mut (impl Sums<S> + ?Sized),
        by_p: &mut (impl Sums<S> + ?Sized),
    ) {
        let (q, p) = (T::of(at.q[0]), T::of(at.p[0]));
        match role {
            Role::Drift => {
                by_q.add(0, p * p * q * 0.25 + q * q * q - T::of_constant(at.t.cos()) * 0.3);
                by_p.add(0, p * (q * q * 0.25 + 1.0));
            }
            Role::Clock => {
                let cube = (q * q + p * p * 0.5 + 1.0).sqrt().recip().powi(3);
                by_q.add(0, -(q * cube));
                by_p.add(0, -(p * cube * 0.5));
            }
            _ => {}
        }
    }
}

impl Field for Driven {
    const IS_NYSTROM: bool = false;
    const IN_LANES: bool = false;
    type Noises = Fixed<0>;
    type Parameters = Reals<0>;

    fn parameters<K: Constant>(&self, _: LiftParameter<'_, K>) -> [K; 0] {
        []
    }
}

impl Clock for Driven {
    const CLOCK: &'static str = "Clock\n  Q = 1/√(1 + q² + p²/2)\n";
}
impl Extends for Driven {}

/// A point of the extended phase space, `q`, `t`, `p`, `p_t`, after a step, by one of the numbers before it.
fn column<H: Elements, T: ExtendedStep<H, Dual<1>>>(
    step: &T,
    system: &H,
    start: &[f64],
    along: usize,
) -> Vec<f64> {
    let degrees = start.len() / 2 - 1;
    let lift = |i: usize| match i == along {
        true => Dual::variable(start[i], 0),
        false => Dual::constant(start[i]),
    };
    let time = TimeNode { t: lift(degrees), lost: Dual::from_f64(0.0), momentum: lift(2 * degrees + 1) };
    let q = (0..degrees).map(lift).collect();
    let p = (degrees + 1..2 * degrees + 1).map(lift).collect();
    let mut state = ExtendedState { time, q, p, carry: CompensatedSum::default() };
    let system = SystemIn { system, parameters: &[] };
    step.take(&system, Dual::from_f64(0.3), &mut state, &mut T::Memory::default()).unwrap();
    let ExtendedState { time, q, p, .. } = state;
    let end = q.into_iter().chain([time.t]).chain(p).chain([time.momentum]);
    end.map(|number| number.derivative[0]).collect()
}

/// `MᵀJM = J` to the rounding of the entries.
fn is_symplectic<H: Elements, T: ExtendedStep<H, Dual<1>>>(step: &T, system: &H, start: &[f64]) {
    let half = start.len() / 2;
    let columns: Vec<_> = (0..2 * half).map(|along| column(step, system, start, along)).collect();
    let size = columns.iter().flatten().fold(1.0, |size: f64, entry| size.max(entry.abs()));
    for (a, first) in columns.iter().enumerate() {
        for (b, second) in columns.iter().enumerate() {
            let form: f64 =
                (0..half).map(|i| first[i] * second[half + i] - first[half + i] * second[i]).sum();
            let exact = f64::from(b == a + half) - f64::from(a == b + half);
            // Some thousand roundings: stages, and Newton's method for one number, are solved to a few.
            assert!((form - exact).abs() < 1e-12 * size * size, "{a}, {b}: {form} instead of {exact}");
        }
    }
}

#[test]
fn steps_are_symplectic_in_the_extended_phase_space() {
    // `D` is 0.1 here, and not 0 as on the motion of a run.
    let (q, p) = ([0.5, 0.2], [-0.4, 1.6]);
    let energy = 0.5 * (0.4 * 0.4 + 1.6 * 1.6) - 1.0 / f64::sqrt(0.5 * 0.5 + 0.2 * 0.2);
    let kepler = [q[0], q[1], 0.7, p[0], p[1], 0.1 - energy];
    is_symplectic(&ExtendedGauss::<1>, &Driven, &[0.7, 0.3, 0.4, -0.05]);
    is_symplectic(&ExtendedGauss::<3>, &Driven, &[0.7, 0.3, 0.4, -0.05]);
    is_symplectic(&PairWord(&<Yoshida4 as Composes<Extended<Verlet>>>::word()), &Kepler, &kepler);
    let word = <Yoshida4 as Composes<Logarithmic<3, 2>>>::word();
    is_symplectic(&SplittingWord::<3, 2>(&word), &Kepler, &kepler);
    // At a constant `p_t`: the time is a quadrature, which dual numbers of the other numbers follow.
    let columns: Vec<_> =
        [0, 1, 3, 4].map(|along| column(&ExtendedGauss::<3>, &Kepler, &kepler, along)).into();
    for (a, first) in columns.iter().enumerate() {
        for (b, second) in columns.iter().enumerate() {
            let form: f64 = (0..2).map(|i| first[i] * second[3 + i] - first[3 + i] * second[i]).sum();
            let exact = f64::from(b == a + 2) - f64::from(a == b + 2);
            assert!((form - exact).abs() < 1e-12, "{a}, {b}: {form} instead of {exact}");
        }
    }
    // The step is symplectic in all six variables, too: `p_t` is a parameter with a derivative.
    is_symplectic(&ExtendedGauss::<3>, &Kepler, &kepler);
}

/// A quadratic equation without a solution, and a clock that grows faster than the step: no step, but an
/// error, and the state as it was.
#[test]
fn steps_without_a_solution_fail() {
    let system = SystemIn { system: &Kepler, parameters: &[] };
    let word = <SingleStep as Composes<Extended<Verlet>>>::word();
    let mut memory = ExtendedMemory::default();
    for eps in [10.0, 100.0] {
        let (mut q, mut p) = ([0.5, 0.2], [0.4, 1.6]);
        let at = StepArguments { t: 0.0, h: eps, q: &mut q[..], p: &mut p[..], dw: &[] };
        let taken = advance(&PairWord(&word), &system, at, &mut memory);
        assert!(matches!(taken, Err(StepFailure::NoSolution { .. })), "{eps}: {taken:?}");
        assert_eq!((q, p), ([0.5, 0.2], [0.4, 1.6]));
    }
    // The kick takes more than the energy at infinity, and `T + p_t` is negative.
    let word = <SingleStep as Composes<Logarithmic<1, 1>>>::word();
    let mut memory = ExtendedMemory::default();
    let (mut q, mut p) = ([2.0, 0.0], [2.0, 0.0]);
    let at = StepArguments { t: 0.0, h: 3.0, q: &mut q[..], p: &mut p[..], dw: &[] };
    let taken = advance(&SplittingWord::<1, 1>(&word), &system, at, &mut memory);
    assert!(matches!(taken, Err(StepFailure::ClockTooCoarse { .. })), "{taken:?}");
    assert_eq!((q, p), ([2.0, 0.0], [2.0, 0.0]));
}

/// The words of a checkpoint have `p_t`, the time with its rounding error, and the stages of the last step.
#[test]
fn a_memory_is_restored_to_the_bit() {
    fn check<H: Elements, T: ExtendedStep<H, f64>>(step: &T, system: &H, q: &[f64], p: &[f64]) {
        let system = SystemIn { system, parameters: &[] };
        let (mut q, mut p, mut memory) =
            (q.to_vec(), p.to_vec(), ExtendedMemory::<f64, T::Memory>::default());
        let steps = |q: &mut Vec<f64>, p: &mut Vec<f64>, memory: &mut ExtendedMemory<f64, T::Memory>| {
            let (mut t, mut states) = (memory.state.time.t, Vec::new());
            for _ in 0..5 {
                let at = StepArguments { t, h: 0.3, q: &mut q[..], p: &mut p[..], dw: &[] };
                advance(step, &system, at, memory).unwrap();
                t = memory.reading.t;
                states.extend([&q[..], p, &[t]].concat().into_iter().map(f64::to_bits));
            }
            states
        };
        steps(&mut q, &mut p, &mut memory);
        let mut restored = ExtendedMemory::<f64, T::Memory>::default();
        Tape::read(Tape::write(|tape| memory.pass(tape)), |tape| restored.pass(tape)).unwrap();
        let (mut own_q, mut own_p) = (q.clone(), p.clone());
        let on = steps(&mut q, &mut p, &mut memory);
        assert_eq!(steps(&mut own_q, &mut own_p, &mut restored), on);
    }
    check(&ExtendedGauss::<3>, &Driven, &[0.7], &[0.4]);
    check(&ExtendedGauss::<3>, &Kepler, &[0.5, 0.2], &[-0.4, 1.6]);
    let word = <Yoshida4 as Composes<Extended<Verlet>>>::word();
    check(&PairWord(&word), &Kepler, &[0.5, 0.2], &[-0.4, 1.6]);
    let word = <Yoshida4 as Composes<Logarithmic<3, 2>>>::word();
    check(&SplittingWord::<3, 2>(&word), &Kepler, &[0.5, 0.2], &[-0.4, 1.6]);
}
