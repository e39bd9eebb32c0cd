//! One-step schemes of the program: order, noise, lanes, refusals.

use allocation_counter::measure;
use fixtures::bath::Oscillator;
use fixtures::own::RungeKutta4;
use fixtures::small::{DoubleWell, HenonHeiles, Kubo};
use wzvi::embedding::Own;
use wzvi::error::{ConfigError, StepFailure};
use wzvi::prelude::*;
use wzvi::scalar::{Dual, Scalar};
use wzvi::system::Scratch;

type Rk4 = Own<RungeKutta4>;

/// Neighbours of a ring of any size, with a force in turn.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        p.iter().map(|p| 0.5 * p * p).sum::<f64>() + q.windows(2).map(|w| 0.25 * (w[1] - w[0]).powi(4)).sum::<f64>()
    },
    force = |q: &[f64], p: &[f64], t| (0..q.len()).map(|i| -0.1 * t * q[i]),
    embedding = Midpoint,
)]
#[derive(Clone, Debug)]
struct Pushed;

#[test]
fn the_order_is_that_of_the_scheme() {
    let start: [&[f64]; 2] = [&[0.12, 0.25], &[0.3, -0.2]];
    fixtures::steps::has_order::<Rk4, _>(&HenonHeiles, start, (4.0, 40), 4, 0.15);
}

#[test]
fn increments_move_the_step_hamiltonian() {
    // F = θ (q² + p²)/2: the first four terms of a rotation.
    let (kubo, h, dw) = (Kubo { a: 0.7, sigma: 0.9 }, 0.05, 0.11);
    let theta = kubo.a * h + kubo.sigma * dw;
    let (cos, sin) = (1.0 - theta.powi(2) / 2.0 + theta.powi(4) / 24.0, theta - theta.powi(3) / 6.0);
    let mut state = State::new([0.3], [0.8]);
    kubo.stepper::<Rk4>(h).unwrap().step(&mut state, &[dw]).unwrap();
    let exact = [cos * 0.3 + sin * 0.8, cos * 0.8 - sin * 0.3];
    for (ours, exact) in [state.q[0], state.p[0]].into_iter().zip(exact) {
        // Some twenty roundings of numbers below one.
        assert!((ours - exact).abs() < 20.0 * f64::EPSILON, "{ours} {exact}");
    }
    assert_eq!(<Kubo as Discretized<Rk4>>::PLAN.strong_order(), Some(1.0));
}

/// After the first two, which make room for a state, for its lists and for what forces exchange.
#[test]
fn steps_allocate_nothing() {
    fn check<H: Discretized<Rk4>>(system: &H, mut state: State<H::Vector>) {
        let mut steps = fixtures::steps::steps_after::<Rk4, _>(2, system, &mut state, 0.01);
        assert_eq!(measure(|| steps(100)).count_total, 0);
    }
    check(&Kubo { a: 0.7, sigma: 0.9 }, State::new([0.3], [0.8]));
    check(&HenonHeiles, State::new([0.12, 0.25], [0.3, -0.2]));
    check(&Pushed, State::new(vec![0.1; 40], vec![0.2; 40]));
}

#[test]
fn paths_of_an_ensemble_have_the_bits_of_single_ones() {
    let kubo = Kubo { a: 0.7, sigma: 0.9 };
    fixtures::steps::lanes_are_steppers::<Rk4, _>(&kubo, [&[0.3], &[0.8]], 0.02);
}

#[test]
fn dual_numbers_differentiate_the_step() {
    let start = [0.3, 0.8];
    let end = |q: f64, p: f64| {
        let mut state = State::new([q], [p]);
        DoubleWell { sigma: 0.3 }.stepper::<Rk4>(0.1).unwrap().step(&mut state, &[0.2]).unwrap();
        state.q[0]
    };
    let mut q = [Dual { value: start[0], derivative: [1.0] }];
    let mut p = [Dual::from_f64(start[1])];
    let (well, dw) = (DoubleWell { sigma: 0.3 }, [Dual::from_f64(0.2)]);
    let prepared = Discretized::<Rk4>::prepare(&well, 0.1).unwrap();
    Discretized::<Rk4>::advance(&well, &prepared, 0.0, 0.1, &mut q, &mut p, &dw, &mut Scratch::default())
        .unwrap();
    let difference = (end(start[0] + 1e-5, start[1]) - end(start[0] - 1e-5, start[1])) / 2e-5;
    assert_eq!(q[0].value, end(start[0], start[1]));
    // The difference has errors of h² and of rounding over h.
    assert!((q[0].derivative[0] - difference).abs() < 1e-9, "{} {difference}", q[0].derivative[0]);
}

#[test]
fn sizes_and_forces_are_those_of_the_state() {
    let start = State::new(vec![0.1, 0.5, -0.4, 0.9], vec![0.0, 0.3, 0.2, -0.1]);
    let end =
        |h: f64| Pushed.simulate::<Rk4>(h).start(start.clone()).until(2.0).run().unwrap().last().q.clone();
    let midpoint = |h: f64| Pushed.simulate::<Midpoint>(h).start(start.clone()).until(2.0).run().unwrap();
    let [coarse, fine] = [2e-3, 1e-3].map(|h| (end(0.01) - &midpoint(h).last().q).norm());
    // The mid-point rule is off by some h², which is all that is between them.
    assert!(fine < 1e-4 && (coarse / fine - 4.0).abs() < 0.1, "{coarse} {fine}");
    let order = ((end(0.05) - end(0.002)).norm() / (end(0.025) - end(0.002)).norm()).log2();
    // The next term of the error is smaller by h, times what the springs harden.
    assert!((order - 4.0).abs() < 0.1, "{order}");
}

#[test]
fn a_step_to_nowhere_leaves_the_state() {
    let well = DoubleWell { sigma: 0.3 };
    let mut stepper = well.stepper::<Rk4>(0.1).unwrap();
    let error = fixtures::steps::refused(&State::new([1e200], [0.0]), |state| stepper.step(state, &[0.2]));
    assert_eq!(error.cause, StepFailure::NonFinite);
}

#[test]
fn friction_is_refused() {
    let damped = Oscillator { m: 1.0, k: 1.0, b: 0.0, gamma: 0.1, kt: 0.5 };
    let error = damped.stepper::<Rk4>(0.1).err().unwrap();
    assert!(matches!(error, ConfigError::Setting(what) if what.contains("no friction")));
}
