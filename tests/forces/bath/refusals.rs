//! What makes no sense, and steps that fail.

use wzvi::error::{BathError, ConfigError, StepFailure};
use wzvi::prelude::*;

use fixtures::bath::{Chain, Coupled, Oscillator, Rated, Rough};

const OSCILLATOR: Oscillator = Oscillator { m: 0.8, k: 1.3, b: 0.4, gamma: 0.5, kt: 0.7 };

fn refused<E>(system: &Oscillator, h: f64) -> ConfigError
where
    Oscillator: Discretized<E>,
{
    match system.stepper::<E>(h) {
        Err(error) => error,
        Ok(_) => panic!("{system:?} has steps of {h}"),
    }
}

#[test]
fn numbers_that_make_no_sense_are_refused() {
    let with = |gamma, kt| Oscillator { gamma, kt, ..OSCILLATOR };
    for (system, h, error) in [
        (with(-0.5, 1.0), 0.1, BathError::Friction { rate: -0.5 }),
        (with(0.5, -1.0), 0.1, BathError::Temperature { temperature: -1.0, degree: None, t: None }),
        (
            with(0.5, f64::INFINITY),
            0.1,
            BathError::Temperature { temperature: f64::INFINITY, degree: None, t: None },
        ),
        (with(0.5, 1.0), -0.1, BathError::Backwards { h: -0.1 }),
    ] {
        assert_eq!(refused::<Baoab>(&system, h), ConfigError::Bath(error));
        assert_eq!(refused::<Obabo>(&system, h), ConfigError::Bath(error));
        assert_eq!(refused::<Thermostat<Midpoint>>(&system, h), ConfigError::Bath(error));
    }
    assert!(matches!(
        refused::<Baoab>(&with(f64::INFINITY, 1.0), 0.1),
        ConfigError::Bath(BathError::Friction { .. })
    ));
    let light = Oscillator { m: -1.0, gamma: 1.0, ..OSCILLATOR };
    assert_eq!(
        refused::<Baoab>(&light, 0.1),
        ConfigError::Bath(BathError::Mass { degree: 0, inverse: -1.0 })
    );
    let coupled = |damping, n| Coupled { m: 1.0, n, k: 1.0, damping, kt: 1.0 };
    let error = |system: &Coupled| match system.stepper::<Baoab>(0.1) {
        Err(ConfigError::Bath(error)) => error,
        other => panic!("{other:?}"),
    };
    assert_eq!(error(&coupled([[1.0, 0.2], [0.3, 1.0]], 1.0)), BathError::Asymmetric { entry: [1, 0] });
    assert_eq!(error(&coupled([[1.0, 0.2], [0.2, 1.0]], -1.0)), BathError::Masses);
    // Eigenvalues 3 and -1.
    let BathError::Friction { rate } = error(&coupled([[1.0, 2.0], [2.0, 1.0]], 1.0)) else { panic!() };
    assert!((rate + 1.0).abs() < 8.0 * f64::EPSILON, "{rate}");
}

#[test]
fn the_number_of_increments_is_that_of_the_parts() {
    let state = State::new([0.3], [-0.4]);
    let cause = |outcome: Result<_, wzvi::error::StepError>| outcome.map_err(|error| error.cause);
    let step = |dw: &[f64]| {
        let mut after = state;
        let outcome = cause(OSCILLATOR.stepper::<Obabo>(0.1).expect("steps").step(&mut after, dw));
        assert!(outcome.is_ok() || after == state);
        outcome.map(|_| ())
    };
    assert_eq!(step(&[0.1, 0.2]), Ok(()));
    assert_eq!(step(&[0.1]), Err(StepFailure::Increments { expected: 2, got: 1 }));
    assert_eq!(step(&[0.1, f64::NAN]), Err(StepFailure::NonFiniteInput));
    let chain = Chain { gamma: -0.5, kt: 1.0 };
    let (mut state, start) = (State::new(vec![0.1; 3], vec![0.2; 3]), State::new(vec![0.1; 3], vec![0.2; 3]));
    // The size of the system is that of the state: what is wrong shows in the first step.
    let outcome = cause(chain.stepper::<Baoab>(0.1).expect("steps").step(&mut state, &[0.1; 3]));
    assert_eq!(outcome, Err(StepFailure::Bath(BathError::Friction { rate: -0.5 })));
    assert_eq!(state, start);
}

/// The size of the state shows in the first step, and with it that a list of rates is too short.
#[test]
fn lists_of_rates_that_are_too_short_are_refused() {
    fn outcome<E>(rates: usize, parts: usize) -> Result<(), StepFailure>
    where
        Rated: Discretized<E, Vector = wzvi::nalgebra::DVector<f64>>,
    {
        let system = Rated { rates: vec![0.1; rates], kt: 1.0 };
        let start = State::new(vec![0.1; 5], vec![0.2; 5]);
        let mut state = start.clone();
        let taken = system.stepper::<E>(0.1).expect("steps").step(&mut state, &vec![0.1; 5 * parts]);
        assert!(taken.is_ok() || state == start);
        taken.map(|_| ()).map_err(|error| error.cause)
    }
    for rates in [0, 4] {
        for outcome in [
            outcome::<Baoab>(rates, 1),
            outcome::<Obabo>(rates, 2),
            outcome::<Thermostat<Midpoint>>(rates, 2),
        ] {
            assert!(matches!(outcome, Err(StepFailure::Index { .. })), "{outcome:?}");
        }
    }
    for outcome in [outcome::<Baoab>(5, 1), outcome::<Obabo>(5, 2), outcome::<Thermostat<Midpoint>>(6, 2)] {
        assert_eq!(outcome, Ok(()));
    }
}

#[test]
fn friction_that_becomes_negative_is_an_error_of_the_step() {
    let system = Rough { m: 1.0, gamma: 0.5, edge: 0.35, kt: 1.0 };
    let start = State::new([0.3], [1.0]);
    let mut state = start;
    let mut stepper = system.stepper::<Baoab>(0.2).expect("steps");
    let error = stepper.step(&mut state, &[0.1]).expect_err("the middle of the step is beyond the edge");
    assert!(matches!(error.cause, StepFailure::Bath(BathError::Friction { rate }) if rate < 0.0), "{error}");
    assert_eq!((state, stepper.steps()), (start, 0));
    let mut stepper = system.stepper::<Thermostat<Midpoint>>(0.2).expect("steps");
    let error = stepper.step(&mut state, &[0.0, 0.1]).expect_err("the end of the step is beyond the edge");
    assert!(matches!(error.cause, StepFailure::Bath(BathError::Friction { rate }) if rate < 0.0), "{error}");
    assert_eq!((state, stepper.steps()), (start, 0));
}

#[test]
fn beyond_the_limit_of_stability_is_an_error() {
    // h ω = 4: Verlet doubles its amplitude many times in each step, until numbers overflow.
    let stiff = Oscillator { m: 1.0, k: 1600.0, b: 0.0, gamma: 0.1, kt: 1.0 };
    let run = stiff.simulate::<Baoab>(0.1).start(State::new([0.1], [0.0])).noise(StepNormals::seed(1));
    let (path, error) = run.steps(2000).run_partial().expect("a run");
    assert!(matches!(error, Some(wzvi::Error::Step(error)) if error.cause == StepFailure::NonFinite));
    assert!(path.iter().all(|state| state.q[0].is_finite() && state.p[0].is_finite()));
    // The mid-point between is stable for all.
    let run = stiff.simulate::<Thermostat<Midpoint>>(0.1).start(State::new([0.1], [0.0]));
    assert!(run.noise(StepNormals::seed(1)).steps(2000).run().is_ok());
}
