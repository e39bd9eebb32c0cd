//! Temperatures that depend on the time, or differ by degree of freedom.

use std::slice::from_ref;

use wzvi::error::{BathError, StepFailure};
use wzvi::prelude::*;

use fixtures::stepped::{failed, paths_are_steppers};

/// Free particles with masses, rates and temperatures of their own.
#[hamiltonian(
    drift = |[x, y], [px, py]| px * px / (2.0 * m) + py * py / (2.0 * m),
    friction = [g, 2.0 * g],
    temperature = [|t| start + slope * t, |t| start],
    embedding = [Baoab, Obabo, Gjf, Thermostat<Midpoint>],
)]
#[derive(Clone, Copy, Debug)]
struct Ramp {
    m: f64,
    g: f64,
    start: f64,
    slope: f64,
}

/// A chain at temperatures by site and time.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let n = q.len();
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + (1..n).map(|i| 0.5 * (q[i] - q[i - 1]).powi(2)).sum::<f64>()
            + 0.5 * q[0] * q[0] + 0.5 * q[n - 1] * q[n - 1]
    },
    friction = gamma,
    temperature = [|i, t| hot[i] + slope * t; hot.len()],
    embedding = [Baoab, Thermostat<Midpoint>],
)]
#[derive(Clone, Debug)]
struct Heated {
    gamma: f64,
    hot: Vec<f64>,
    slope: f64,
}

/// One temperature in three spellings.
macro_rules! spelled {
    ($name:ident, $($temperature:tt)*) => {
        #[hamiltonian(
            drift = |[x, y], [px, py]| 0.5 * (px * px + py * py + x * x + y * y + x * y),
            friction = 0.7,
            temperature = $($temperature)*,
            embedding = Baoab,
        )]
        struct $name {
            kt: f64,
        }
    };
}
spelled!(OneNumber, kt);
spelled!(TwoOfOne, [kt, kt]);
spelled!(Sites, [|_i| kt; 2]);
spelled!(Instant, |_t| kt);

/// The variances of both momenta after so many steps from rest: the sum of the squares of what each normal makes of them.
fn variances<E>(ramp: Ramp, h: f64, steps: u64) -> [f64; 2]
where
    Ramp: Discretized<E>,
{
    let per_step = ramp.increments(2);
    let mut variances = [0.0; 2];
    for drawn in 0..steps as usize * per_step {
        let (mut stepper, mut state) = (ramp.stepper::<E>(h).unwrap(), State::new([0.0; 2], [0.0; 2]));
        for step in 0..steps as usize {
            let mut dw = vec![0.0; per_step];
            if drawn / per_step == step {
                dw[drawn % per_step] = h.sqrt();
            }
            stepper.step(&mut state, &dw).unwrap();
        }
        variances.iter_mut().zip(&state.p).for_each(|(sum, p)| *sum += p * p);
    }
    variances
}

/// `m [T_1 - c² T_0 - (T_1 - T_0) (1 - c²)/(2 γ t)]`, `c = e^{-γ t}`, of a momentum that starts from rest while the temperature goes from `T_0` to `T_1` in the time `t`:
/// exact at any step size, since the temperature is linear in each step.
#[test]
fn momenta_have_the_exact_variance_under_a_linear_temperature() {
    for (g, h) in [(0.6, 0.3), (1e-4, 0.5), (20.0, 0.4)] {
        let ramp = Ramp { m: 1.7, g, start: 0.4, slope: 1.3 };
        let exact = |rate: f64, slope: f64| {
            let (t, first) = (4.0 * h, ramp.start);
            let (last, lost) = (first + slope * t, -(-2.0 * rate * t).exp_m1());
            ramp.m * (last - (1.0 - lost) * first - (last - first) * lost / (2.0 * rate * t))
        };
        let exact = [exact(g, ramp.slope), exact(2.0 * g, 0.0)];
        for variances in [
            variances::<Baoab>(ramp, h, 4),
            variances::<Obabo>(ramp, h, 4),
            variances::<Thermostat<Midpoint>>(ramp, h, 4),
        ] {
            for (found, exact) in variances.iter().zip(exact) {
                // The exact formula itself loses digits where γ t is small.
                let tolerance = 1e-13 + 4.0 * f64::EPSILON / (g * h);
                assert!((found / exact - 1.0).abs() < tolerance, "γ = {g}: {found} for {exact}");
            }
        }
        // The map of `Gjf` with the temperature in the middle of each step.
        let x = 0.5 * g * h;
        let (kept, share) = ((1.0 - x) / (1.0 + x), 4.0 * x / ((1.0 + x) * (1.0 + x)));
        let of_gjf = (0..4).fold(0.0, |variance, step| {
            let middle = ramp.start + ramp.slope * (f64::from(step) + 0.5) * h;
            variance * kept * kept + share * middle * ramp.m
        });
        let found = variances::<Gjf>(ramp, h, 4)[0];
        assert!((found / of_gjf - 1.0).abs() < 1e-13, "{found} for {of_gjf}");
    }
}

#[test]
fn one_temperature_in_any_spelling_has_an_equilibrium() {
    let run = |state: &mut dyn FnMut(&mut State<_>)| {
        let mut at = State::new([0.3, -0.2], [0.1, 0.4]);
        (0..20).for_each(|_| state(&mut at));
        at
    };
    macro_rules! end {
        ($name:ident) => {{
            assert!(!<$name as Discretized<Baoab>>::PLAN.is_out_of_equilibrium);
            assert!(!<$name as Discretized<Baoab>>::EQUATIONS.contains("no equilibrium"));
            let system = $name { kt: 0.8 };
            let mut stepper = system.stepper::<Baoab>(0.1).unwrap();
            run(&mut |state| assert!(stepper.step(state, &[0.2, -0.1]).is_ok()))
        }};
    }
    let one = end!(OneNumber);
    assert!(one == end!(TwoOfOne) && one == end!(Sites) && one == end!(Instant));
    let plan = <Ramp as Discretized<Baoab>>::PLAN;
    assert!(plan.is_out_of_equilibrium && plan.to_string().contains("no equilibrium"), "{plan}");
    assert!(<Heated as Discretized<Baoab>>::EQUATIONS.contains("no equilibrium"));
}

#[test]
fn paths_are_those_of_lanes() {
    let heated = Heated { gamma: 0.7, hot: vec![1.0, 0.2, 0.0, 3.0], slope: 0.1 };
    let start = State::new(vec![0.1; 4], vec![0.2, -0.1, 0.0, 0.5]);
    let run = || heated.ensemble::<Baoab>(0.1).start(start.clone());
    assert_eq!(failed(&paths_are_steppers(run, from_ref(&heated), (0.1, 20), (8, 9))), 0);
    let run = || heated.ensemble::<Thermostat<Midpoint>>(0.1).start(start.clone());
    assert_eq!(failed(&paths_are_steppers(run, from_ref(&heated), (0.1, 20), (8, 9))), 0);
}

#[test]
fn a_temperature_that_turns_negative_says_where_and_when() {
    let heated = Heated { gamma: 0.7, hot: vec![1.0, 0.25, 2.0], slope: -1.0 };
    let mut state = State::new(vec![0.1; 3], vec![0.2; 3]);
    let mut stepper = heated.stepper::<Baoab>(0.1).unwrap();
    let dw = [0.1; 3];
    stepper.step(&mut state, &dw).unwrap();
    stepper.step(&mut state, &dw).unwrap();
    let before = state.clone();
    let error = stepper.step(&mut state, &dw).unwrap_err();
    let StepFailure::Bath(BathError::Temperature { temperature, degree: Some(1), t: Some(t) }) = error.cause
    else {
        panic!("{error}");
    };
    assert!((t - 0.3).abs() < 1e-15 && (temperature + 0.05).abs() < 1e-15, "{error}");
    assert!(error.to_string().contains("degree of freedom 1"), "{error}");
    assert_eq!(state, before);
    let nan = Heated { hot: vec![1.0, f64::NAN, 2.0], ..heated };
    assert!(nan.simulate::<Baoab>(0.1).start(before).noise(StepNormals::seed(1)).steps(1).run().is_err());
}

/// A large chain goes window by window: the bits of a small one, and the energy is gained as heat and work.
#[test]
fn large_chains_have_the_bits_of_one_pass() {
    for slope in [0.0, 0.1] {
        let n = 300;
        let hot: Vec<f64> = (0..n).map(|i| 1.0 + 0.5 * (i as f64).sin()).collect();
        let heated = Heated { gamma: 0.7, hot, slope };
        let start = State::new(vec![0.0; n], vec![0.3; n]);
        let run = |threads| {
            let run =
                heated.simulate::<Baoab>(0.1).start(start.clone()).noise(StepNormals::seed(4)).steps(30);
            run.plain_sums().threads(threads).run().unwrap()
        };
        let path = run(1);
        assert_eq!(path.last(), run(2).last());
        let gained = heated.energy(path.last()) - heated.energy(&start);
        assert!((path.heat() + path.work() - gained).abs() < 1e-12 * gained.abs());
    }
}
