//! Steps of the references, and the orders of their ends.

use fixtures::reference::{data, list, number, numbers};
use serde_json::Value;
use wzvi::prelude::*;
use wzvi::state::Vector;

use super::systems::{CarAxis, DoublePendulum, Sphere, Top, WarmSphere};

fn largest_difference<V: Vector>(found: &V, expected: &[f64]) -> f64 {
    let pairs = found.components().iter().zip(expected);
    pairs.map(|(found, expected)| (found - expected).abs()).fold(0.0, f64::max)
}

fn start<V: Vector>(case: &Value) -> State<V> {
    fixtures::extremes::state(&numbers(&case["q0"]), &numbers(&case["p0"]))
}

/// Every step of a list to `1e-13`: 34 digits of the references against roundings of numbers of order one,
/// magnified by at most a hundred over ten steps.
#[track_caller]
fn follows<E, H: Discretized<E>>(system: &H, case: &Value, steps: &Value) {
    let mut state = start::<H::Vector>(case);
    let mut stepper = system.stepper::<E>(number(&case["h"])).unwrap();
    for (i, step) in list(steps).iter().enumerate() {
        stepper.step(&mut state, &[]).unwrap();
        let apart = largest_difference(&state.q, &numbers(&step["q"]))
            .max(largest_difference(&state.p, &numbers(&step["p"])));
        assert!(apart < 1e-13, "step {i}: {apart:e}");
    }
}

#[test]
fn steps_are_those_of_the_references() {
    let rattle = data("rattle_steps");
    let cases = list(&rattle["cases"]);
    let sphere = Sphere { g: 1.0 };
    follows::<Rattle, _>(&sphere, &cases[0], &cases[0]["trajectory"]);
    follows::<Composed<Rattle, KahanLi6>, _>(&sphere, &cases[1], &cases[1]["trajectory"]);
    let all = data("constraints");
    follows::<Rattle, _>(&DoublePendulum, &all["double_pendulum"], &all["double_pendulum"]["rattle"]);
    follows::<Rattle, _>(&Top, &all["lagrange_top"], &all["lagrange_top"]["rattle"]);
    follows::<Rattle, _>(&CarAxis, &all["car_axis"], &all["car_axis"]["rattle"]);
}

/// Normals of the reference, one for each coordinate.
#[test]
fn a_path_in_a_bath_is_that_of_the_reference() {
    let case = &data("constrained_langevin")["sphere"];
    let (h, gamma, kt) = (number(&case["h"]), number(&case["friction"]), number(&case["kT"]));
    let system = WarmSphere { gamma, kt };
    let mut state = start(case);
    let mut stepper = system.stepper::<GBaoab>(h).unwrap();
    for (normals, step) in list(&case["normals"]).iter().zip(list(&case["trajectory"])) {
        let dw: Vec<f64> = numbers(normals).iter().map(|normal| h.sqrt() * normal).collect();
        let energy = system.energy(&state);
        let before = stepper.exchanged().heat;
        stepper.step(&mut state, &dw).unwrap();
        let apart = largest_difference(&state.q, &numbers(&step["q"]))
            .max(largest_difference(&state.p, &numbers(&step["p"])));
        assert!(apart < 1e-13, "{apart:e}");
        // What the bath gave, the energy has gained, up to the error of kicks and drifts, O(h³).
        let gained = system.energy(&state) - energy;
        let heat = stepper.exchanged().heat - before;
        assert!((gained - heat).abs() < 0.05 * heat.abs(), "{gained} {heat}");
    }
}

/// The error of the coordinates at the end, with so many steps.
fn error<E, H: Discretized<E>>(system: &H, case: &Value, steps: u32) -> f64 {
    let end = number(&case["T"]);
    let path = system
        .simulate::<E>(end / f64::from(steps))
        .start(start(case))
        .steps(u64::from(steps))
        .unwatched()
        .run()
        .unwrap();
    largest_difference(&path.last().q, &numbers(&case["exact_q"]))
}

/// The order between two numbers of steps is within a tenth of the expected one, as far as the leading term
/// of the error decides.
#[track_caller]
fn has_order<E, H: Discretized<E>>(system: &H, case: &Value, steps: u32, order: f64) {
    let [coarse, fine] = [steps, 2 * steps].map(|steps| error::<E, H>(system, case, steps));
    let found = (coarse / fine).log2();
    assert!((found - order).abs() < 0.1, "{coarse:e} {fine:e}: {found}");
}

fn has_orders<H>(system: &H, case: &Value, steps: [u32; 3])
where
    H: Discretized<Rattle> + Discretized<Composed<Rattle, Suzuki4>> + Discretized<Composed<Rattle, KahanLi6>>,
{
    has_order::<Rattle, _>(system, case, steps[0], 2.0);
    has_order::<Composed<Rattle, Suzuki4>, _>(system, case, steps[1], 4.0);
    has_order::<Composed<Rattle, KahanLi6>, _>(system, case, steps[2], 6.0);
}

#[test]
fn ends_have_the_orders_of_their_compositions() {
    let all = data("constraints");
    has_orders(&DoublePendulum, &all["double_pendulum"], [128, 128, 128]);
    has_orders(&Top, &all["lagrange_top"], [64, 64, 32]);
}

/// The road moves, and with it the manifold.
#[test]
fn a_moving_manifold_has_the_orders() {
    let all = data("constraints");
    has_orders(&CarAxis, &all["car_axis"], [1200, 600, 1200]);
}

/// The multipliers of the motion at the start: 36 digits of the reference.
#[test]
fn multipliers_are_those_of_the_motion() {
    let all = data("constraints");
    let check = |multipliers: Option<Vec<f64>>, case: &Value| {
        let expected = numbers(&case["lambda_exact_at_0"]);
        let multipliers = multipliers.unwrap();
        assert_eq!(multipliers.len(), expected.len());
        for (found, expected) in multipliers.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-13, "{found} {expected}");
        }
    };
    fn of<H: Hamiltonian>(system: &H, case: &Value) -> Option<Vec<f64>> {
        let state = start::<H::Vector>(case);
        system.multipliers(&state)
    }
    check(of(&DoublePendulum, &all["double_pendulum"]), &all["double_pendulum"]);
    check(of(&Top, &all["lagrange_top"]), &all["lagrange_top"]);
    check(of(&CarAxis, &all["car_axis"]), &all["car_axis"]);
}
