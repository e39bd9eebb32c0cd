//! Promises of a step: it fails with a typed error and leaves the state alone, or its result is finite.

use fixtures::extremes::{HenonHeiles, PENDULUM, Pendulum, Ring, bits, state};
use fixtures::small::KUBO;
use fixtures::small::Kubo;
use fixtures::steps::refused;
use wzvi::error::{ConfigError, StepFailure};
use wzvi::prelude::*;

mod allocations;

/// No drift, so that the pole is where the increment alone puts it.
#[hamiltonian(
    drift = |_q, _p| 0.0,
    noise = [|q, p| sigma * p * q],
    embedding = [Midpoint, Uncorrected<DeltaPlus>],
)]
struct Stretch {
    sigma: f64,
}

const STRETCH: Stretch = Stretch { sigma: 0.5 };

/// The step fails with the cause it returns, the state keeps its bits, and the stepper goes on like a fresh one.
fn failure<E, H: Discretized<E>>(system: &H, h: f64, bad: &State<H::Vector>, dw: &[f64]) -> StepFailure {
    let good = {
        let half = vec![0.5; system.degrees()];
        state::<H::Vector>(&half, &half)
    };
    let small = vec![0.01; system.noises()];
    let (mut used, mut fresh) = (system.stepper::<E>(h).unwrap(), system.stepper::<E>(h).unwrap());
    let error = refused(bad, |state| used.step(state, dw));
    assert_eq!((used.steps(), error.step, error.h), (0, 0, h));
    assert_eq!(error.t.to_bits(), bad.t.to_bits());
    assert!(error.to_string().contains("step 0"), "{error}");
    let (mut first, mut second) = (good.clone(), good);
    for _ in 0..10 {
        used.step(&mut first, &small).unwrap();
        fresh.step(&mut second, &small).unwrap();
        assert_eq!(bits(&first), bits(&second));
        // One that fails from the same state is as if it had not been.
        refused(&first, |state| used.step(state, &vec![f64::NAN; system.noises() + 1]));
        // So is one from another state.
        refused(bad, |state| used.step(state, dw));
    }
    error.cause
}

#[test]
fn what_is_not_finite_is_refused() {
    fn check<E, H: Discretized<E>>(system: &H, h: f64, start: &State<H::Vector>, dw: &[f64]) {
        assert_eq!(failure::<E, H>(system, h, start, dw), StepFailure::NonFiniteInput, "{start:?} {dw:?}");
    }
    let payload = f64::from_bits(0x7ff8_0000_dead_beef);
    for x in [f64::NAN, payload, f64::INFINITY, f64::NEG_INFINITY] {
        for (q, p) in [(x, -0.0), (-0.0, x), (x, x)] {
            let start = state(&[q], &[p]);
            check::<Midpoint, _>(&KUBO, 0.1, &start, &[0.1]);
            check::<Uncorrected<DeltaPlus>, _>(&KUBO, 0.1, &start, &[0.1]);
            for h in [0.1, -0.1] {
                check::<Midpoint, _>(&PENDULUM, h, &start, &[]);
                check::<DeltaPlus, _>(&PENDULUM, h, &start, &[]);
            }
            check::<Midpoint, _>(&Ring { k: 2.0 }, 0.1, &state(&[0.0, q, -0.0], &[p, 1.0, 1.0]), &[]);
        }
        let start = state(&[-0.0], &[0.5]);
        check::<Midpoint, _>(&KUBO, 0.1, &start, &[x]);
        check::<Corrected<DeltaPlus>, _>(&KUBO, 0.1, &start, &[x]);
        check::<Midpoint, _>(&KUBO, 0.1, &start.at(x), &[0.1]);
    }
}

#[test]
fn every_noise_has_one_increment() {
    let start = state(&[-0.0], &[0.5]);
    for dw in [&[][..], &[0.1, 0.1], &[0.1; 7]] {
        let expected = StepFailure::Increments { expected: 1, got: dw.len() };
        assert_eq!(failure::<Midpoint, _>(&KUBO, 0.1, &start, dw), expected);
        assert_eq!(failure::<Corrected<DeltaPlus>, _>(&KUBO, 0.1, &start, dw), expected);
    }
    let expected = StepFailure::Increments { expected: 0, got: 1 };
    assert_eq!(failure::<Midpoint, _>(&PENDULUM, 0.1, &start, &[0.0]), expected);
    // That the number is wrong is said even if the numbers are, too.
    let expected = StepFailure::Increments { expected: 1, got: 2 };
    assert_eq!(failure::<Midpoint, _>(&KUBO, 0.1, &start, &[f64::NAN; 2]), expected);
    let start = state(&[0.1, 0.1], &[0.5, 0.5]);
    let expected = StepFailure::Increments { expected: 2, got: 1 };
    assert_eq!(failure::<DeltaPlus, _>(&HenonHeiles, 0.1, &start, &[0.1]), expected);
}

/// A composition says how many degrees of freedom the system has, whichever list has another number.
#[test]
fn compositions_name_the_number_that_is_wrong() {
    type Steps = Composed<Midpoint, Yoshida4>;
    let ring = Ring { k: 2.0 };
    let prepared = Discretized::<Steps>::prepare(&ring, 0.1).unwrap();
    for (coordinates, momenta, got) in [(4, 4, 4), (2, 2, 2), (4, 3, 4), (3, 4, 4), (3, 2, 2)] {
        let (mut q, mut p) = (vec![0.5; coordinates], vec![0.5; momenta]);
        let (q, p, memory) = (&mut q, &mut p, &mut Default::default());
        let error = Discretized::<Steps>::advance(&ring, &prepared, 0.0, 0.1, q, p, &[], memory).unwrap_err();
        assert_eq!(error, StepFailure::Dimension { expected: 3, got });
    }
}

fn is_singular<E>(h: f64, start: &SystemState<Stretch>, dw: f64)
where
    Stretch: Discretized<E>,
{
    let cause = failure::<E, _>(&STRETCH, h, start, &[dw]);
    assert!(matches!(cause, StepFailure::Singular { .. }), "{h:e}, {dw:e}: {cause}");
}

#[test]
fn poles_are_singular() {
    let start = state(&[1.0], &[0.5]);
    // sigma = 1/2: 1 + sigma dW / 2 and 1 + sigma dW vanish exactly.
    is_singular::<Midpoint>(0.1, &start, -4.0);
    is_singular::<Uncorrected<DeltaPlus>>(0.1, &start, -2.0);
    // The other pole of the mid-point, at any size of the step.
    for (h, dw) in [0.1, 1e-8, 1e-100, 1e-200, 1e-300].into_iter().flat_map(|h| [(h, 4.0), (h, -4.0)]) {
        is_singular::<Midpoint>(h, &start, dw);
    }
    // Next to a pole the step exists: q' = q (1 + x)/(1 - x), p' = p (1 - x)/(1 + x) with x = sigma dW / 2.
    for dw in [-4.0 + 1e-6, 4.0 - 1e-6, -3.0, 1.0] {
        let mut state = start;
        STRETCH.stepper::<Midpoint>(0.1).unwrap().step(&mut state, &[dw]).unwrap();
        let x = 0.25 * dw;
        let expected = [(1.0 + x) / (1.0 - x), 0.5 * (1.0 - x) / (1.0 + x)];
        // Rounding of 1 ± x, magnified by its reciprocal.
        let bound = 4.0 * f64::EPSILON * (1.0 / (1.0 - x) + 1.0 / (1.0 + x)).abs();
        assert!(
            (state.q[0] - expected[0]).abs() <= bound * expected[0].abs().max(1.0),
            "{state:?} {expected:?}"
        );
        assert!(
            (state.p[0] - expected[1]).abs() <= bound * expected[1].abs().max(1.0),
            "{state:?} {expected:?}"
        );
    }
}

/// A force moves the pole of the stretch to `σ ΔW = 2 √(1 + h²/4)`, and the step at 2 is right: it takes `q` to about `16 q/h²`, and fails where that overflows.
#[test]
fn a_force_moves_the_pole() {
    #[hamiltonian(drift = |q, p| 0.5 * (p * p + q * q), noise = [|q, p| 0.5 * p * q], embedding = Midpoint)]
    struct Bound;
    for h in [0.1, 1e-3, 1e-8, 1e-30, 1e-100, 1e-200, 1e-300] {
        let mut state = State::new([1.0], [0.5]);
        let taken = Bound.stepper::<Midpoint>(h).unwrap().step(&mut state, &[4.0]);
        if h < 1e-154 {
            let cause = taken.unwrap_err().cause;
            assert!(matches!(cause, StepFailure::Singular { .. } | StepFailure::NonFinite), "{h:e}: {cause}");
            continue;
        }
        taken.unwrap();
        // With the mid-point `(x, y)`: `2 (x - q) = h y + 2 x` and `2 (y - p) = -h x - 2 y`.
        let y = -2.0 / h;
        let x = (1.0 - 4.0 * y) / h;
        let expected = [2.0 * x - 1.0, 2.0 * y - 0.5];
        let close = |found: f64, exact: f64| (found - exact).abs() <= 16.0 * f64::EPSILON * exact.abs();
        assert!(
            close(state.q[0], expected[0]) && close(state.p[0], expected[1]),
            "{h:e}: {state:?} {expected:?}"
        );
    }
}

#[test]
fn huge_increments_fail_or_stay_finite() {
    let start = state(&[0.3], &[0.5]);
    let radius = |state: &State<<Kubo as Hamiltonian>::Vector>| f64::hypot(state.q[0], state.p[0]);
    for dw in [1e2, 1e4, -1e6, 1e8, -1e8, 1e100, 1e154, 1e200, 1e300, f64::MAX, -f64::MAX] {
        let mut state = start;
        let outcome = KUBO.stepper::<Midpoint>(0.1).unwrap().step(&mut state, &[dw]);
        println!("Kubo, mid-point, dW = {dw:e}: {outcome:?} {state:?} {:e}", radius(&state) - radius(&start));
        if dw.abs() <= 1e8 {
            // The Cayley map is a rotation, whatever its argument theta = dW/2. One unknown is eliminated, the other
            // then follows as theta times a difference that is rounded: a few roundings times theta.
            let bound = 4.0 * f64::EPSILON * (1.0 + 0.5 * dw.abs()) * radius(&start);
            assert!((radius(&state) - radius(&start)).abs() <= bound, "{dw:e}: {state:?}");
        }
        assert!(state.q[0].is_finite() && state.p[0].is_finite(), "{outcome:?}");
        let mut state = start;
        let outcome = KUBO.stepper::<Uncorrected<DeltaPlus>>(0.1).unwrap().step(&mut state, &[dw]);
        assert!(state.q[0].is_finite() && state.p[0].is_finite(), "{outcome:?}");
    }
    // Beyond its poles the mid-point of the stretch tends to -1, by 8/dw; what is absurd is refused.
    for dw in [1e20, -1e200, 1e300] {
        is_singular::<Midpoint>(0.1, &start, dw);
    }
    for dw in [1e12, -1e13] {
        let mut state = start;
        STRETCH.stepper::<Midpoint>(0.1).unwrap().step(&mut state, &[dw]).unwrap();
        let distance = (state.q[0] + start.q[0]).abs().max((state.p[0] + start.p[0]).abs());
        let bound = 8.0 / dw.abs() + 4.0 * f64::EPSILON;
        assert!(distance <= bound, "{dw:e}: {state:?}");
    }
    let cause = failure::<Uncorrected<DeltaPlus>, _>(&KUBO, 0.1, &start, &[f64::MAX]);
    assert_eq!(cause, StepFailure::NonFinite);
}

#[test]
fn what_overflows_or_does_not_converge_says_so() {
    // Far above the escape energy the explicit step overflows in the end; each failure leaves the last good state.
    let mut state = state(&[3.0, -4.0], &[1.0, 2.0]);
    let mut stepper = HenonHeiles.stepper::<DeltaPlus>(0.1).unwrap();
    let mut last = state;
    let error = loop {
        match stepper.step(&mut state, &[0.0, 0.0]) {
            Ok(_) => last = state,
            Err(error) => break error,
        }
        assert!(stepper.steps() < 1000);
    };
    assert_eq!(error.cause, StepFailure::NonFinite);
    assert_eq!((bits(&state), error.step, error.t), (bits(&last), stepper.steps(), last.t));

    // A step far beyond the basin of the mid-point: an error, or a solution of the equations.
    let (mut failures, mut solutions) = (0, 0);
    for i in 0..300 {
        let start = self::state(&[0.1 * f64::from(i), 1.0], &[-3.0, f64::from(i)]);
        let mut state = start;
        let h = [2.0, 20.0, 200.0][i as usize % 3];
        match HenonHeiles.stepper::<Midpoint>(h).unwrap().step(&mut state, &[0.5, 0.5]) {
            Err(error) => {
                assert!(
                    matches!(
                        error.cause,
                        StepFailure::NotConverged { .. }
                            | StepFailure::NoSolution { .. }
                            | StepFailure::Singular { .. }
                            | StepFailure::NonFinite
                    ),
                    "{error}"
                );
                assert_eq!(bits(&state), bits(&start));
                failures += 1;
            }
            Ok(_) => {
                let middle = State { q: 0.5 * (start.q + state.q), p: 0.5 * (start.p + state.p), t: 0.0 };
                let mut q = h * HenonHeiles.energy_gradient(&middle).p;
                let mut p = -h * HenonHeiles.energy_gradient(&middle).q;
                for k in 0..2 {
                    q += 0.5 * HenonHeiles.noise_gradient(k, &middle).p;
                    p -= 0.5 * HenonHeiles.noise_gradient(k, &middle).q;
                }
                let residual = (start.q + q - state.q).amax().max((start.p + p - state.p).amax());
                let size = middle.q.amax().max(middle.p.amax()).max(start.q.amax()).max(start.p.amax());
                // Rounding of terms as large as the square of the state, magnified by the condition of the Jacobian.
                assert!(residual <= 1e-12 * (1.0 + h * size * size), "{residual:e} at {start:?}: {state:?}");
                solutions += 1;
            }
        }
    }
    println!("mid-point with h from 2 to 200: {solutions} solutions, {failures} failures");
    assert!(failures > 0 && solutions > 0);
}

#[test]
fn what_cannot_be_prepared_is_a_mistake_of_the_configuration() {
    for h in [0.0, -0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let error = PENDULUM.stepper::<Midpoint>(h).unwrap_err();
        assert!(matches!(error, ConfigError::StepSize(got) if got.to_bits() == h.to_bits()), "{error}");
    }
    for bad in [f64::NAN, -f64::NAN] {
        let named = |parameter| ConfigError::NotANumber { parameter };
        assert_eq!(Pendulum { omega: bad }.stepper::<Midpoint>(0.1).unwrap_err(), named("omega"));
        assert_eq!(Pendulum { omega: bad }.stepper::<DeltaPlus>(0.1).unwrap_err(), named("omega"));
        assert_eq!(Kubo { a: bad, sigma: 1.0 }.stepper::<Midpoint>(0.1).unwrap_err(), named("a"));
        assert_eq!(Kubo { a: 1.0, sigma: bad }.stepper::<Midpoint>(0.1).unwrap_err(), named("sigma"));
        assert_eq!(Ring { k: bad }.stepper::<Midpoint>(0.1).unwrap_err(), named("k"));
    }
    // An infinite parameter fails at the stepper or at the first step, never silently.
    for omega in [f64::INFINITY, f64::MAX] {
        let system = Pendulum { omega };
        if let Ok(mut stepper) = system.stepper::<Midpoint>(0.1) {
            let mut state = state(&[0.3], &[0.5]);
            let outcome = stepper.step(&mut state, &[]);
            assert!(outcome.is_err(), "{outcome:?} {state:?}");
        }
        if let Ok(mut stepper) = (Ring { k: omega }).stepper::<Midpoint>(0.1) {
            let mut state = state(&[0.3, 0.1, 0.0], &[0.5, 0.0, 0.0]);
            assert!(stepper.step(&mut state, &[]).is_err() || state.p.iter().all(|p| p.is_finite()));
        }
    }
}

/// A part of what `tests/laws` runs.
#[test]
fn a_step_is_finite_or_an_error_and_then_leaves_every_bit() {
    fixtures::extremes::steps_are_finite_or_errors(60);
}

#[test]
fn moving_the_state_forgets_the_steps_before() {
    let mut used = PENDULUM.stepper::<Midpoint>(0.1).unwrap();
    let mut moving = state(&[1.0], &[0.5]);
    for _ in 0..10 {
        used.step(&mut moving, &[]).unwrap();
    }
    let (mut one, mut other) = (state(&[2.0], &[-0.5]), state(&[2.0], &[-0.5]));
    used.step(&mut one, &[]).unwrap();
    PENDULUM.stepper::<Midpoint>(0.1).unwrap().step(&mut other, &[]).unwrap();
    assert_eq!(bits(&one), bits(&other));
}

#[test]
fn time_is_start_plus_n_h_exactly() {
    for (t0, h) in [(0.0, 0.1), (0.3, 0.02), (-7.1, 1.0 / 3.0), (2.5, -0.07), (1e6, 1e-3)] {
        let mut stepper = KUBO.stepper::<Midpoint>(h).unwrap();
        let mut state = state(&[0.3], &[0.5]).at(t0);
        for n in 1..=5000_u32 {
            stepper.step(&mut state, &[0.01]).unwrap();
            assert_eq!(state.t.to_bits(), (t0 + f64::from(n) * h).to_bits(), "t0 = {t0}, h = {h}, step {n}");
            if n % 1000 == 0 {
                // A failed step does not move the clock.
                stepper.step(&mut state, &[f64::NAN]).unwrap_err();
            }
        }
    }
}

/// An increment that leaves no digit of the state is an error, not an answer.
#[test]
fn absurd_increments_are_refused() {
    for dw in [1e10, 1e16, 1e100, 1e200, f64::MAX] {
        for start in [[0.5, 0.5], [0.0, 1.0], [1.0, 0.0]] {
            let cause = failure::<Midpoint, _>(&KUBO, 0.1, &state(&start[..1], &start[1..]), &[dw]);
            assert!(
                matches!(cause, StepFailure::Singular { .. } | StepFailure::NonFinite),
                "{dw:e}: {cause:?}"
            );
        }
    }
}
