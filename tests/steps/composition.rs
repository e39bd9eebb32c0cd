//! Schemes that are steps of others: against steps to 36 digits, their orders, and what a step promises.

mod counted;
mod flows;
mod forced;
mod parts;

use fixtures::small::{Driven, HenonHeiles, Pendulum};
use serde_json::Value;
use wzvi::prelude::*;
use wzvi::state::Vector;
use wzvi::system::Segment;

/// The path to the end of the given trajectory, step by step.
fn follow<E, H: Discretized<E>>(system: &H, case: &Value) {
    let list = |value: &Value| -> Vec<f64> {
        value.as_array().unwrap().iter().map(|x| x.as_str().unwrap().parse().unwrap()).collect()
    };
    let mut state = State { q: vector::<H>(&list(&case["q0"])), p: vector::<H>(&list(&case["p0"])), t: 0.0 };
    let h = case["h"].as_str().unwrap().parse().unwrap();
    let mut stepper = system.stepper::<E>(h).unwrap();
    for node in case["trajectory"].as_array().unwrap() {
        stepper.step(&mut state, &[]).unwrap();
        for (ours, exact) in [(&state.q, &node["q"]), (&state.p, &node["p"])] {
            for (ours, exact) in ours.components().iter().zip(list(exact)) {
                // Some fifty roundings per step, of numbers below 2.
                assert!((ours - exact).abs() < 1e-14, "{}: {ours} {exact}", case["scheme"]);
            }
        }
    }
}

fn vector<H: Hamiltonian>(components: &[f64]) -> H::Vector {
    let mut vector = H::Vector::zeros(components.len());
    vector.components_mut().copy_from_slice(components);
    vector
}

#[test]
fn steps_are_those_of_the_reference() {
    let text = include_str!("../data/composition_steps.json");
    let file: Value = serde_json::from_str(text).unwrap();
    let mut checked = 0;
    for case in file["cases"].as_array().unwrap() {
        macro_rules! follow {
            ($($name:literal => $weights:ty),+) => {
                match (case["scheme"].as_str().unwrap(), case["system"].as_str().unwrap()) {
                    $(
                        ($name, "henon_heiles") => follow::<Composed<Verlet, $weights>, _>(&HenonHeiles, case),
                        ($name, "pendulum") => follow::<Composed<Verlet, $weights>, _>(&Pendulum, case),
                    )+
                    _ => continue,
                }
            };
        }
        follow!(
            "Yoshida4" => Yoshida4, "Suzuki4" => Suzuki4, "KahanLi6_s9" => KahanLi6, "KahanLi8_s17a" => KahanLi8,
            "BM4_S6" => BlanesMoan4, "BM6_S10" => BlanesMoan6, "SRKN6_14a" => Srkn6
        );
        checked += 1;
    }
    assert_eq!(checked, 14);
}

/// The state at the time `end`, after `steps` steps.
fn end<E>(end: f64, steps: u32) -> [f64; 2]
where
    Driven: Discretized<E, Vector = wzvi::nalgebra::SVector<f64, 1>>,
{
    let path =
        Driven.simulate::<E>(end / f64::from(steps)).start(State::new([0.6], [0.4])).steps(steps.into());
    let last = *path.run().unwrap().last();
    [last.q[0], last.p[0]]
}

/// The order between `steps` and twice as many, from three runs: no exact solution is needed.
fn order<E>(steps: u32) -> f64
where
    Driven: Discretized<E, Vector = wzvi::nalgebra::SVector<f64, 1>>,
{
    let [a, b, c] = [1, 2, 4].map(|factor| end::<E>(1.6, factor * steps));
    let gap = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    (gap(a, b) / gap(b, c)).log2()
}

/// On a Hamiltonian that is not separable and depends on the time. Between steps of these sizes an order of `n` shows as
/// `n` to within 0.25.
#[test]
fn orders_are_those_of_the_plan() {
    macro_rules! orders {
        ($($scheme:ty, $order:literal, $steps:literal);+ $(;)?) => {$(
            assert_eq!(<Driven as Discretized<$scheme>>::PLAN.order, $order);
            let measured = order::<$scheme>($steps);
            assert!((measured - f64::from($order)).abs() < 0.25, "{}: {measured}", stringify!($scheme));
        )+};
    }
    orders! {
        Verlet, 2, 40;
        Composed<Midpoint, Yoshida4>, 4, 20;
        Composed<Verlet, Yoshida4>, 4, 20;
        Composed<Midpoint, Suzuki4>, 4, 10;
        Composed<Verlet, Suzuki4>, 4, 10;
        Composed<Verlet, BlanesMoan4>, 4, 6;
        Composed<Verlet, BlanesMoan6>, 6, 6;
        Composed<Midpoint, Yoshida6>, 6, 10;
        Composed<Verlet, Yoshida6>, 6, 10;
        Composed<Midpoint, KahanLi6>, 6, 6;
        Composed<Verlet, KahanLi6>, 6, 6;
        Composed<Midpoint, KahanLi8>, 8, 4;
        Composed<Verlet, KahanLi8>, 8, 4;
        Composed<Midpoint, SuzukiUmeno8>, 8, 5;
        Composed<Verlet, SuzukiUmeno8>, 8, 5;
    }
}

/// The discrete Lagrangian of any segment by its definition: its gradient by central differences, whose error is of the
/// order of `1e-5²` by truncation and `1e-16 / 1e-5` by rounding.
fn check_gradient<E>()
where
    Driven: Discretized<E, Vector = wzvi::nalgebra::SVector<f64, 1>>,
{
    let segment = |q0: f64, q1: f64, p: f64| Segment {
        q0: [q0].into(),
        q1: [q1].into(),
        p: [p].into(),
        t: 0.3,
        h: 0.25,
    };
    let (q0, q1, p, d) = (0.5, 0.7, 0.4, 1e-5);
    let gradient =
        <Driven as Discretized<E>>::discrete_lagrangian_gradient(&Driven, &segment(q0, q1, p), &[]);
    let value = |a: f64, b: f64, c: f64| -> f64 {
        <Driven as Discretized<E>>::discrete_lagrangian(&Driven, &segment(a, b, c), &[])
    };
    let slopes = [
        (value(q0 + d, q1, p) - value(q0 - d, q1, p)) / (2.0 * d),
        (value(q0, q1 + d, p) - value(q0, q1 - d, p)) / (2.0 * d),
        (value(q0, q1, p + d) - value(q0, q1, p - d)) / (2.0 * d),
    ];
    for (slope, exact) in slopes.iter().zip([gradient.q0[0], gradient.q1[0], gradient.p[0]]) {
        assert!((slope - exact).abs() < 1e-9, "{slope} {exact}");
    }
}

#[test]
fn steps_extremise_their_discrete_lagrangian() {
    check_gradient::<Verlet>();
    check_gradient::<Composed<Midpoint, Yoshida4>>();
    check_gradient::<Composed<Verlet, BlanesMoan4>>();
    let path =
        Driven.simulate::<Composed<Verlet, Suzuki4>>(0.1).start(State::new([0.6], [0.4])).steps(50).run();
    // Roundings of five steps, each of numbers below 2.
    assert!(path.unwrap().euler_lagrange_residual(&Driven).unwrap() < 1e-14);
}
