//! Steps of any Hamiltonian: masses that depend on the coordinates, and noise whose flow keeps the
//! constraints.

use fixtures::reference::{data, list, number, numbers};
use wzvi::plan::NoiseClass;
use wzvi::prelude::*;

use super::systems::{GeneralAxis, GeneralSphere, Turned};

fn start() -> State<<Turned as Hamiltonian>::Vector> {
    State::new([0.6, 0.0, -0.8], [0.4, 0.7, 0.3])
}

/// Where the kinetic energy is that of the references, so are the steps: to `1e-13`, as the steps that know
/// it.
#[test]
fn general_steps_are_those_of_the_references() {
    let rattle = data("rattle_steps");
    let cases = list(&rattle["cases"]);
    let sphere = GeneralSphere { g: 1.0, nothing: 0.0 };
    let check = |state: &State<<GeneralSphere as Hamiltonian>::Vector>, step: &serde_json::Value| {
        for (found, expected) in [(&state.q, &step["q"]), (&state.p, &step["p"])] {
            for (found, expected) in found.iter().zip(numbers(expected)) {
                assert!((found - expected).abs() < 1e-13, "{found} {expected}");
            }
        }
    };
    let h = number(&cases[0]["h"]);
    let (mut state, mut stepper) = (start(), sphere.stepper::<Rattle>(h).unwrap());
    for step in list(&cases[0]["trajectory"]) {
        stepper.step(&mut state, &[]).unwrap();
        check(&state, step);
    }
    let (mut state, mut stepper) =
        (start(), sphere.stepper::<Composed<Rattle, KahanLi6>>(number(&cases[1]["h"])).unwrap());
    for step in list(&cases[1]["trajectory"]) {
        stepper.step(&mut state, &[]).unwrap();
        check(&state, step);
    }
    let case = &data("constraints")["car_axis"];
    let axis = GeneralAxis { nothing: 0.0 };
    let mut state = fixtures::extremes::state(&numbers(&case["q0"]), &numbers(&case["p0"]));
    let multipliers = axis.multipliers(&state).unwrap();
    for (found, expected) in multipliers.iter().zip(numbers(&case["lambda_exact_at_0"])) {
        assert!((found - expected).abs() < 1e-13);
    }
    let mut stepper = axis.stepper::<Rattle>(number(&case["h"])).unwrap();
    for step in list(&case["rattle"]) {
        stepper.step(&mut state, &[]).unwrap();
        for (found, expected) in state.q.iter().zip(numbers(&step["q"])) {
            assert!((found - expected).abs() < 1e-13, "{found} {expected}");
        }
    }
}

/// Rotations about the vertical commute with the sphere, with the drift and with the angular momentum: paths
/// are those without noise, turned by `σ W(t)`; the energy and the angular momentum do not see it.
#[test]
fn noise_that_rotates_turns_the_motion() {
    let plan = <Turned as Discretized<Rattle>>::PLAN;
    assert_eq!(plan.noise, NoiseClass::Multiplicative);
    assert!(plan.consistent && plan.conserves_energy == Knowledge::Proven);
    assert_eq!(plan.strong_order(), Some(1.0));
    let (still, turned) = (Turned { sigma: 0.0 }, Turned { sigma: 0.7 });
    let (h, steps) = (0.01, 200);
    let mut errors = Vec::new();
    for halved in [1_u32, 2] {
        let h = h / f64::from(halved);
        let noise = Wiener::seed(3);
        let run = turned.simulate::<Rattle>(h).start(start()).noise(noise.clone());
        let path = run.steps(steps * u64::from(halved)).run().unwrap();
        let plain = still.simulate::<Rattle>(h).start(start()).noise(noise);
        let plain = plain.steps(steps * u64::from(halved)).run().unwrap();
        let w: f64 = path.increments().map(|row| row[0]).sum();
        let (sin, cos) = (0.7 * w).sin_cos();
        let (a, b) = (path.last(), plain.last());
        let [x, y] = [cos * b.q[0] - sin * b.q[1], sin * b.q[0] + cos * b.q[1]];
        errors.push((a.q[0] - x).abs().max((a.q[1] - y).abs()));
        let momentum = |state: &State<_>| turned.invariant(0, state);
        assert!((momentum(a) - momentum(&start())).abs() < 1e-13);
        assert!((a.q.norm() - 1.0).abs() < 1e-15 && a.q.dot(&a.p).abs() < 1e-14);
    }
    // Each step turns by twice the arc tangent of half of its angle: an error of the third order in √h of each.
    assert!(errors[0] < 5e-3 && errors[1] < 0.8 * errors[0], "{errors:?}");
}

/// Energy is kept nearly, by a symmetric step of order two.
#[test]
fn masses_may_depend_on_the_place() {
    let system = Turned { sigma: 0.0 };
    let end = |h: f64| {
        let run = system.simulate::<Rattle>(h).start(start()).noise(Wiener::seed(1));
        let path = run.until(2.0).run().unwrap();
        path.last().q
    };
    let exact = {
        let run = system.simulate::<Composed<Rattle, KahanLi6>>(0.01).start(start()).noise(Wiener::seed(1));
        run.until(2.0).run().unwrap().last().q
    };
    let [coarse, fine] = [0.05, 0.025].map(|h| (end(h) - exact).norm());
    assert!(((coarse / fine).log2() - 2.0).abs() < 0.1, "{coarse:e} {fine:e}");
}
