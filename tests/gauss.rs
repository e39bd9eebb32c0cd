//! Gauss methods: against steps to 36 digits, their orders, and what a step promises.

#![allow(clippy::unwrap_used, reason = "a test may stop")]

use serde_json::Value;
use wzvi::nalgebra::SVector;
use wzvi::prelude::*;

type Point = SVector<f64, 1>;

#[hamiltonian(
    drift = |q, p| 0.5 * p * p - q.cos(),
    embedding = [Midpoint, Gauss<1>, Gauss<2>, Gauss<3>, Gauss<4>, Gauss<5>, Gauss<6>, Gauss<8>, Gauss<16>],
)]
struct Pendulum;

#[hamiltonian(
    drift = |q, p, t| 0.5 * p * p + 0.5 * q * q + 0.25 * q.powi(4) - 0.3 * q * (1.3 * t).cos(),
    embedding = [Gauss<2>, Gauss<4>, Gauss<8>],
)]
struct Duffing;

/// Neither separable nor independent of time.
#[hamiltonian(
    drift = |q, p, t| 0.5 * (1.0 + 0.3 * q * q) * p * p + 0.25 * q.powi(4) + 0.2 * q * (1.7 * t).sin(),
    embedding = [Gauss<2>, Gauss<3>, Gauss<4>, Gauss<6>, Gauss<8>],
)]
struct Driven;

fn follow<E, H: Discretized<E, Vector = Point>>(system: &H, case: &Value) {
    let number = |value: &Value| -> f64 { value.as_str().unwrap().parse().unwrap() };
    let mut state = State::new([number(&case["q0"][0])], [number(&case["p0"][0])]);
    state.t = number(&case["t0"]);
    let mut stepper = system.stepper::<E>(number(&case["h"])).unwrap();
    for node in case["trajectory"].as_array().unwrap() {
        stepper.step(&mut state, &[]).unwrap();
        let exact = [number(&node["q"][0]), number(&node["p"][0])];
        for (ours, exact) in [state.q[0], state.p[0]].into_iter().zip(exact) {
            // Ten roundings per step, of numbers below 2.
            assert!((ours - exact).abs() < 5e-15, "{} {}: {ours} {exact}", case["system"], case["s"]);
        }
    }
}

#[test]
fn steps_are_those_of_the_reference() {
    let file: Value = serde_json::from_str(include_str!("data/gauss_steps.json")).unwrap();
    for case in file["cases"].as_array().unwrap() {
        match (case["system"].as_str().unwrap(), case["s"].as_u64().unwrap()) {
            ("pendulum", 2) => follow::<Gauss<2>, _>(&Pendulum, case),
            ("pendulum", 4) => follow::<Gauss<4>, _>(&Pendulum, case),
            ("pendulum", 8) => follow::<Gauss<8>, _>(&Pendulum, case),
            ("duffing_forced", 2) => follow::<Gauss<2>, _>(&Duffing, case),
            ("duffing_forced", 4) => follow::<Gauss<4>, _>(&Duffing, case),
            ("duffing_forced", 8) => follow::<Gauss<8>, _>(&Duffing, case),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn one_stage_is_the_mid_point_to_the_last_digit() {
    let start = State::new([2.0], [0.0]);
    let gauss = Pendulum.simulate::<Gauss<1>>(0.1).start(start).steps(1000).run();
    let midpoint = Pendulum.simulate::<Midpoint>(0.1).start(start).steps(1000).run();
    let states = |path: &[State<Point>]| path.iter().map(|state| (state.q, state.p)).collect::<Vec<_>>();
    assert_eq!(states(gauss.unwrap().states()), states(midpoint.unwrap().states()));
}

fn end<E>(steps: u32) -> [f64; 2]
where
    Driven: Discretized<E, Vector = Point>,
{
    let path =
        Driven.simulate::<E>(1.6 / f64::from(steps)).start(State::new([0.6], [0.4])).steps(steps.into());
    let last = *path.run().unwrap().last();
    [last.q[0], last.p[0]]
}

/// On a Hamiltonian that is not separable and depends on the time.
#[test]
fn orders_are_those_of_the_plan() {
    macro_rules! orders {
        ($($stages:literal, $steps:literal);+) => {$(
            assert_eq!(<Driven as Discretized<Gauss<$stages>>>::PLAN.order, 2 * $stages);
            let [a, b, c] = [1, 2, 4].map(|factor| end::<Gauss<$stages>>(factor * $steps));
            let gap = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
            let order = (gap(a, b) / gap(b, c)).log2();
            assert!((order - 2.0 * f64::from($stages)).abs() < 0.4, "{}: {order}", $stages);
        )+};
    }
    orders!(2, 10; 3, 6; 4, 4; 6, 3);
    // Of order 16 two steps are left before rounding.
    let gap = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    assert!(gap(end::<Gauss<8>>(2), end::<Gauss<8>>(8)) < 1e-11);
}

/// From (2, 0) to T = 100 against the exact elliptic solution.
#[test]
fn a_hundred_time_units_are_right_to_thirteen_digits() {
    let exact = [1.982_325_653_157_030_5, 0.179_640_742_590_940_2];
    macro_rules! check {
        ($($scheme:ty, $steps:literal, $error:literal);+ $(;)?) => {$(
            let path = Pendulum.simulate::<$scheme>(100.0 / f64::from($steps)).start(State::new([2.0], [0.0]));
            let last = *path.steps($steps).record_every(0).run().unwrap().last();
            let error = (last.q[0] - exact[0]).hypot(last.p[0] - exact[1]);
            assert!(error < $error, "{}: {error:e}", stringify!($scheme));
        )+};
    }
    check! {
        Gauss<4>, 600, 5e-10;
        Gauss<8>, 100, 1e-10;
        Gauss<8>, 200, 1.5e-13;
        Gauss<16>, 40, 2e-10;
        Gauss<16>, 60, 1.5e-13;
    }
}
