//! Schemes that are steps of others: against steps to 36 digits, their orders, and what a step promises.

mod counted;
mod flows;
mod forced;
mod parts;
mod stages;

use fixtures::reference;
use fixtures::small::{Driven, HenonHeiles, Pendulum};
use fixtures::steps::{asymmetry, way_back};
use wzvi::prelude::*;
use wzvi::system::Segment;

type Line = wzvi::nalgebra::SVector<f64, 1>;

#[test]
fn steps_are_those_of_the_reference() {
    let file = reference::data("composition_steps");
    // Some fifty roundings per step, of numbers below 2.
    let (mut checked, bound) = (0, 1e-14);
    for case in reference::list(&file["cases"]) {
        macro_rules! follow {
            ($($name:literal => $weights:ty),+) => {
                match (reference::text(&case["scheme"]), reference::text(&case["system"])) {
                    $(
                        ($name, "henon_heiles") => {
                            reference::follow::<Composed<Verlet, $weights>, _>(&HenonHeiles, case, bound)
                        }
                        ($name, "pendulum") => {
                            reference::follow::<Composed<Verlet, $weights>, _>(&Pendulum, case, bound)
                        }
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

/// The order between `steps` to the time 1.6 and twice as many, from three runs: no exact solution is needed.
fn order<E, H: Discretized<E, Vector = Line>>(system: &H, start: [f64; 2], steps: u32) -> f64 {
    let [a, b, c] = [1, 2, 4].map(|factor| {
        let mut stepper = system.stepper::<E>(1.6 / f64::from(factor * steps)).unwrap();
        let mut state = State::new([start[0]], [start[1]]);
        for _ in 0..factor * steps {
            stepper.step(&mut state, &[]).unwrap();
        }
        [state.q[0], state.p[0]]
    });
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
            let measured = order::<$scheme, _>(&Driven, [0.6, 0.4], $steps);
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

/// The gradient of the discrete Lagrangian of any segment by central differences, whose error is of the order of `1e-5²` by truncation and
/// `1e-16 / 1e-5` by rounding.
fn check_gradient<E, H: Discretized<E, Vector = Line>>(system: &H) {
    let segment =
        |[q0, q1, p]: [f64; 3]| Segment { q0: [q0].into(), q1: [q1].into(), p: [p].into(), t: 0.3, h: 0.25 };
    let at = [0.5, 0.7, 0.4];
    let gradient = system.discrete_lagrangian_gradient(&segment(at), &[]);
    for (k, exact) in [gradient.q0[0], gradient.q1[0], gradient.p[0]].into_iter().enumerate() {
        let [ahead, behind] = [1e-5, -1e-5].map(|d| {
            let mut moved = at;
            moved[k] += d;
            system.discrete_lagrangian(&segment(moved), &[])
        });
        let slope = (ahead - behind) / 2e-5;
        assert!((slope - exact).abs() < 1e-9, "{k}: {slope} {exact}");
    }
}

/// `dq' ∧ dp' = dq ∧ dp` by dual numbers, and the step of `-h` leads back.
fn check_symplectic_and_symmetric<E, H: Discretized<E>>(system: &H, h: f64) {
    let (start, at): ([&[f64]; 2], _) = ([&[0.4], &[0.3]], [0.2, h]);
    assert!(asymmetry::<E, _>(system, start, at, &[], 1.0) < 1e-14);
    assert!(way_back::<E, _>(system, start, at, &[]) < 4e-15);
}

#[test]
fn steps_extremise_their_discrete_lagrangian() {
    check_gradient::<Verlet, _>(&Driven);
    check_gradient::<Composed<Midpoint, Yoshida4>, _>(&Driven);
    check_gradient::<Composed<Verlet, BlanesMoan4>, _>(&Driven);
    let path =
        Driven.simulate::<Composed<Verlet, Suzuki4>>(0.1).start(State::new([0.6], [0.4])).steps(50).run();
    // Roundings of five steps, each of numbers below 2.
    assert!(path.unwrap().euler_lagrange_residual(&Driven).unwrap() < 1e-14);
}
