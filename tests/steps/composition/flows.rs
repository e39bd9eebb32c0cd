//! Kicks and drifts: how often they evaluate forces, that reuse is not to be seen, and that they are the steps of the adjoint pair.

use wzvi::prelude::*;
use wzvi::scalar::Scalar;
use wzvi::state::Vector;
use wzvi::system::Segment;

use super::counted::{Counted, sines};
use super::{HenonHeiles, Pendulum, check_gradient, check_symplectic_and_symmetric};
use fixtures::extremes::state;
use fixtures::steps::{apart, has_order, lanes_are_steppers, refused};

/// Separable, with time in the force, with noises of both kinds.
#[hamiltonian(
    drift = |[x, y], [px, py], t| 0.5 * px * px + py.cosh() + 0.25 * (x * x + y * y).powi(2) + 0.3 * x * (1.7 * t).sin(),
    noise = [|[x, y], _| 0.4 * x * y, |_, [px, py]| 0.3 * px * py],
    embedding = [Verlet, DeltaPlus, DeltaMinus],
)]
struct Forced;

#[hamiltonian(
    drift = |q, p, t| 0.5 * p * p + 0.25 * q.powi(4) + 0.3 * q * (1.7 * t).sin(),
    embedding = [Verlet, DeltaPlus, DeltaMinus],
)]
struct Duffing;

/// Masses change with time: no flow is known, but the halves of `Verlet` are.
#[hamiltonian(
    drift = |q, p, t| 0.5 * p * p * (1.0 + 0.1 * t) + 0.25 * q.powi(4),
    embedding = [Verlet, DeltaPlus, DeltaMinus],
)]
struct Heavier;

/// Evaluations of the force in each of ten steps after the first.
fn evaluations<E>() -> [u32; 2]
where
    Pendulum: Discretized<E>,
{
    let (h, mut q, mut p) = (0.1, [Counted(0.3)], [Counted(0.2)]);
    let prepared = Discretized::<E>::prepare(&Pendulum, h).unwrap();
    let mut memory = Default::default();
    let mut step = |n: u32| {
        let t = f64::from(n) * h;
        Discretized::<E>::advance(&Pendulum, &prepared, t, h, &mut q, &mut p, &[], &mut memory).unwrap();
    };
    sines();
    step(0);
    let first = sines();
    (1..11).for_each(&mut step);
    let later = sines();
    assert_eq!(later % 10, 0);
    [first, later / 10]
}

#[test]
fn forces_at_shared_nodes_are_evaluated_once() {
    assert_eq!(evaluations::<Verlet>(), [2, 1]);
    assert_eq!(evaluations::<Composed<Verlet, Yoshida4>>(), [4, 3]);
    assert_eq!(evaluations::<Composed<Verlet, Suzuki4>>(), [6, 5]);
    assert_eq!(evaluations::<Composed<Verlet, KahanLi6>>(), [10, 9]);
    assert_eq!(evaluations::<Composed<Verlet, KahanLi8>>(), [18, 17]);
    // These start and end with a drift.
    assert_eq!(evaluations::<Composed<Verlet, BlanesMoan4>>(), [6, 6]);
    assert_eq!(evaluations::<Composed<Verlet, BlanesMoan6>>(), [10, 10]);
}

/// The same steps, with a stepper for all of them and with a new one for each.
fn check_reuse<E, H: Discretized<E>>(system: &H, [q, p]: [&[f64]; 2]) {
    let h = 0.05;
    let mut stepper = system.stepper::<E>(h).unwrap();
    let mut state = State { t: 0.3, ..self::state::<H::Vector>(q, p) };
    for n in 0..20 {
        let mut anew = state.clone();
        stepper.step(&mut state, &[]).unwrap();
        system.stepper::<E>(h).unwrap().step(&mut anew, &[]).unwrap();
        assert_eq!((&state.q, &state.p), (&anew.q, &anew.p));
        // A state that the caller moved, by a bit, or to another time.
        match n {
            5 => state.q.components_mut()[0] = state.q.components()[0].next_up(),
            10 => state.p.components_mut()[0] += 0.1,
            15 => state.t += 0.25,
            _ => {}
        }
    }
}

#[test]
fn reuse_is_not_to_be_seen() {
    check_reuse::<Verlet, _>(&Pendulum, [&[0.3], &[0.2]]);
    check_reuse::<Verlet, _>(&Duffing, [&[0.3], &[0.2]]);
    check_reuse::<Composed<Verlet, KahanLi6>, _>(&HenonHeiles, [&[0.3, 0.1], &[0.2, 0.0]]);
    check_reuse::<Verlet, _>(&Chain::<7>, [&[0.1, 0.2, 0.3, 0.1, 0.0, -0.1, -0.2], &[0.1; 7]]);
}

/// `Verlet` is its two halves; where it is made of flows, up to the rounding of few operations with numbers below 2.
fn check_halves<H: Discretized<Verlet> + Discretized<DeltaPlus> + Discretized<DeltaMinus>>(
    system: &H,
    [q, p]: [&[f64]; 2],
    dw: &[f64],
    rounding: f64,
) {
    let (h, half): (f64, Vec<f64>) = (0.1, dw.iter().map(|dw| 0.5 * dw).collect());
    let start = State { t: 0.7, ..state::<H::Vector>(q, p) };
    let (mut whole, mut halves) = (start.clone(), start);
    system.stepper::<Verlet>(h).unwrap().step(&mut whole, dw).unwrap();
    system.stepper::<DeltaPlus>(0.5 * h).unwrap().step(&mut halves, &half).unwrap();
    system.stepper::<DeltaMinus>(0.5 * h).unwrap().step(&mut halves, &half).unwrap();
    for (a, b) in [(&whole.q, &halves.q), (&whole.p, &halves.p)] {
        for (a, b) in a.components().iter().zip(b.components()) {
            assert!((a - b).abs() <= rounding, "{a} {b}");
        }
    }
}

#[test]
fn verlet_is_its_two_halves() {
    check_halves(&HenonHeiles, [&[0.12, 0.1], &[0.3, -0.25]], &[], 4.0 * f64::EPSILON);
    check_halves(&Duffing, [&[0.4], &[0.3]], &[], 4.0 * f64::EPSILON);
    check_halves(&Forced, [&[0.4, 0.2], &[0.3, 0.1]], &[0.2, -0.1], 4.0 * f64::EPSILON);
    check_halves(&Heavier, [&[0.4], &[0.3]], &[], 0.0);
}

macro_rules! chain {
    ($name:ident, [$($generics:tt)*], $state:ty) => {
        #[hamiltonian(
            drift = |q: $state, p: $state, t| p.iter().map(|p| 0.5 * p * p).sum::<f64>()
                + (1..q.len()).map(|i| 0.25 * (q[i] - q[i - 1]).powi(4)).sum::<f64>() + q[0] * t.sin(),
            noise = [|q, _| 0.3 * q[1] * q[2], |_, p| 0.2 * p[3]],
            embedding = Verlet,
        )]
        struct $name$($generics)*;
    };
}

chain!(Noisy, [], [f64; 5]);
chain!(NoisyInLoops, [<const N: usize>], [f64; N]);

#[hamiltonian(
    drift = |q: [f64; N], p: [f64; N]| p.iter().map(|p| 0.5 * p * p).sum::<f64>()
        + (0..N - 1).map(|i| 0.5 * (q[i + 1] - q[i]).powi(2) + 0.25 * (q[i + 1] - q[i]).powi(4)).sum::<f64>(),
    embedding = Verlet,
)]
struct Chain<const N: usize>;

/// The steps of elements and of straight-line code.
#[test]
fn loops_are_what_they_would_be_written_out() {
    let start: [&[f64]; 2] = [&[0.1, 0.3, -0.2, 0.4, 0.0], &[0.2, -0.1, 0.3, 0.1, -0.4]];
    let pair = (&Noisy, &NoisyInLoops::<5>);
    // Roundings of some hundred operations with numbers below 1.
    assert!(apart::<Verlet, _, _>(pair, start, (0.1, 20), &[0.2, -0.07]) < 1e-14);
    assert!(apart::<Composed<Verlet, BlanesMoan6>, _, _>(pair, start, (0.1, 20), &[0.2, -0.07]) < 1e-14);
}

#[test]
fn steps_are_symplectic_and_symmetric() {
    check_symplectic_and_symmetric::<Verlet, _>(&Duffing, 0.3);
    check_symplectic_and_symmetric::<Composed<Verlet, KahanLi8>, _>(&Duffing, 0.3);
    check_symplectic_and_symmetric::<Composed<Verlet, BlanesMoan6>, _>(&Duffing, 0.3);
}

#[test]
fn a_step_that_fails_changes_nothing() {
    fn check<E, H: Discretized<E>>(system: &H, degrees: usize) {
        let mut stepper = system.stepper::<E>(0.1).unwrap().compensated();
        let mut q = vec![0.3; degrees];
        let p = vec![0.1; degrees];
        let mut state = self::state::<H::Vector>(&q, &p);
        stepper.step(&mut state, &[]).unwrap();
        q[0] = 1e200;
        let good = state.clone();
        let bad = self::state::<H::Vector>(&q, &p).at(good.t);
        let error = refused(&bad, |state| stepper.step(state, &[]));
        assert!(matches!(error.cause, wzvi::error::StepFailure::NonFinite), "{error}");
        let mut other = good.clone();
        stepper.step(&mut state, &[]).unwrap();
        let mut anew = system.stepper::<E>(0.1).unwrap().compensated();
        anew.step(&mut other, &[]).unwrap();
        let gap = |a: &H::Vector, b: &H::Vector| (a.components()[0] - b.components()[0]).abs();
        assert!(gap(&state.q, &other.q) <= f64::EPSILON, "what was carried is all that differs");
        let dimension = stepper.step(&mut State { p: H::Vector::zeros(degrees), ..state }, &[1.0]);
        assert!(dimension.is_err());
    }
    check::<Verlet, _>(&Duffing, 1);
    check::<Composed<Verlet, BlanesMoan4>, _>(&Chain::<40>, 40);
}

#[test]
fn the_discrete_lagrangian_is_that_of_its_parts() {
    check_gradient::<Verlet, _>(&Duffing);
    check_gradient::<Composed<Verlet, BlanesMoan4>, _>(&Duffing);
    // The halves have the discrete Lagrangian of the whole, at the segment that each of them makes.
    let start = State::new([0.5], [0.4]);
    let mut between = start;
    Duffing.stepper::<DeltaPlus>(0.125).unwrap().step(&mut between, &[]).unwrap();
    let mut end = between;
    Duffing.stepper::<DeltaMinus>(0.125).unwrap().step(&mut end, &[]).unwrap();
    let part = |q0, q1, p, t| Segment { q0, q1, p, t, h: 0.125 };
    let sum = Discretized::<DeltaPlus>::discrete_lagrangian(
        &Duffing,
        &part(start.q, between.q, between.p, 0.0),
        &[],
    ) + Discretized::<DeltaMinus>::discrete_lagrangian(
        &Duffing,
        &part(between.q, end.q, between.p, 0.125),
        &[],
    );
    let whole = Segment { q0: start.q, q1: end.q, p: start.p, t: 0.0, h: 0.25 };
    let ours = Discretized::<Verlet>::discrete_lagrangian(&Duffing, &whole, &[]);
    assert!((ours - sum).abs() < 4.0 * f64::EPSILON, "{ours} {sum}");
}

/// Paths of an ensemble are those that its noise drives alone.
#[test]
fn ensembles_take_flows_side_by_side() {
    let start: [&[f64]; 2] = [&[0.4, 0.1], &[0.3, 0.2]];
    // Sums of single paths are compensated.
    lanes_are_steppers::<Verlet, _>(&Forced, start, 0.05);
    lanes_are_steppers::<Composed<Verlet, BlanesMoan4>, _>(&Forced, start, 0.05);
}

#[test]
fn plans_and_equations_say_that_it_is_explicit() {
    let plan = <Pendulum as Discretized<Composed<Verlet, KahanLi8>>>::PLAN;
    assert_eq!((plan.solver, plan.unknowns, plan.order, plan.consistent), (Solver::Explicit, 0, 8, true));
    let verlet = <Pendulum as Discretized<Verlet>>::EQUATIONS;
    assert!(verlet.contains("kick of h/2 at t + h"));
    let starts = |text: &str, lines: &str| assert!(text.starts_with(lines), "{text}");
    let yoshida = <Pendulum as Discretized<Composed<Verlet, Yoshida4>>>::EQUATIONS;
    starts(
        yoshida,
        "A step of size h is, one after the other, a step of size\n  1.3512071919596575 h\n  -1.7024143839193153 h\n",
    );
    // The equations of the composed step stand in the text, its order and modified energy do not.
    let (equations, _) = verlet.split_once("\nFacts\n").unwrap();
    assert!(yoshida.contains(equations) && yoshida.contains("within O(h^4)"), "{yoshida}");
    assert!(verlet.contains("modified energy") && !yoshida.contains("modified energy"), "{yoshida}");
    starts(
        <Pendulum as Discretized<Composed<Verlet, Aba864>>>::EQUATIONS,
        "A step of size h is, one after the other, a\n  drift of 0.0711334264982231 h\n  kick of 0.1830836874721972 h\n",
    );
    let by_pair = <Heavier as Discretized<Composed<Verlet, BlanesMoan4>>>::EQUATIONS;
    assert!(by_pair.contains("by steps of DeltaMinus (drift) and DeltaPlus (kick)"), "{by_pair}");
    assert!(!<Heavier as Discretized<Verlet>>::EQUATIONS.contains("kick"));
}

/// The step of NaN parameters is refused, not taken.
#[test]
fn parameters_are_checked() {
    #[hamiltonian(drift = |q, p| 0.5 * p * p + 0.5 * k * q * q, embedding = Verlet)]
    struct Spring {
        k: f64,
    }
    assert!(Spring { k: f64::NAN }.stepper::<Verlet>(0.1).is_err());
    let doubled = Scalar::is_identical(0.0, -0.0);
    assert!(!doubled, "zeros of both signs are two numbers");
}

/// The table of BlanesMoan4, as a user would write one.
struct Own;

impl wzvi::compose::Partitioned for Own {
    const ORDER: u32 = 4;
    const STARTS_WITH_DRIFT: bool = true;
    const SEQUENCE: &'static [f64] = <BlanesMoan4 as wzvi::compose::Partitioned>::SEQUENCE;
}

/// On a force that reads the time. Between steps of these sizes an order of `n` shows as `n` to within 0.25.
#[test]
fn tables_have_their_orders() {
    let start: [&[f64]; 2] = [&[0.9], &[0.4]];
    has_order::<Composed<Verlet, Srkn6>, _>(&Duffing, start, (1.6, 7), 6, 0.25);
    has_order::<Composed<Verlet, Aba864>, _>(&Duffing, start, (1.6, 8), 4, 0.25);
    has_order::<Composed<Verlet, Aba1064>, _>(&Duffing, start, (1.6, 8), 4, 0.25);
    has_order::<Composed<Verlet, wzvi::compose::Table<Own>>, _>(&Duffing, start, (1.6, 6), 4, 0.25);
    assert_eq!(evaluations::<Composed<Verlet, Srkn6>>(), [14, 14]);
    assert_eq!(evaluations::<Composed<Verlet, Aba864>>(), [7, 7]);
}
