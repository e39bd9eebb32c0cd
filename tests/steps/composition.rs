//! Schemes that are steps of others: against steps to 36 digits, their orders, and what a step promises.

mod counted;
mod flows;
mod forced;
mod kepler;
mod parts;
mod stages;

use fixtures::reference;
use fixtures::small::{Driven, HenonHeiles, Pendulum};
use fixtures::steps::{asymmetry, has_order, lagrangian_gradient_off, way_back};
use wzvi::prelude::*;

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

/// On a Hamiltonian that is not separable and depends on the time. Between steps of these sizes an order of `n` shows as
/// `n` to within 0.25.
#[test]
fn orders_are_those_of_the_plan() {
    macro_rules! orders {
        ($($scheme:ty, $order:literal, $steps:literal);+ $(;)?) => {$(
            has_order::<$scheme, _>(&Driven, [&[0.6], &[0.4]], (1.6, $steps), $order, 0.25);
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

/// On any segment.
fn check_gradient<E, H: Discretized<E>>(system: &H) {
    let off = lagrangian_gradient_off::<E, _>(system, [&[0.5], &[0.7], &[0.4]], [0.3, 0.25]);
    assert!(off < 1e-9, "{}: {off:e}", std::any::type_name::<E>());
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
