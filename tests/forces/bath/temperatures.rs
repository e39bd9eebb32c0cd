//! Temperatures that depend on the time, or differ by degree of freedom.

use std::slice::from_ref;

use wzvi::bath::{A, B, O};
use wzvi::ensemble::Statistics;
use wzvi::error::{BathError, ConfigError, StepFailure};
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

/// Two particles whose friction is a diagonal matrix; the masses are powers of two.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.25 * px * px + 2.0 * py * py + 0.5 * (x - y).powi(2) + 0.5 * x * x,
    damping = [[1.4, 0.0], [0.0, g]],
    temperature = [2.0, t2],
    embedding = [Baoab, Thermostat<Midpoint>],
)]
struct DiagonalMatrix {
    g: f64,
    t2: f64,
}

/// The same by rates.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.25 * px * px + 2.0 * py * py + 0.5 * (x - y).powi(2) + 0.5 * x * x,
    friction = [0.7, 4.0 * g],
    temperature = [2.0, t2],
    embedding = [Baoab, Thermostat<Midpoint>],
)]
struct DiagonalRates {
    g: f64,
    t2: f64,
}

/// A matrix of a field, which may couple.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.25 * px * px + 2.0 * py * py + 0.5 * (x - y).powi(2) + 0.5 * x * x,
    damping = gamma,
    temperature = [2.0, t2],
    embedding = Baoab,
)]
struct MatrixOfField {
    gamma: [[f64; 2]; 2],
    t2: f64,
}

type FirstO = Splitting<(O, A, B)>;

/// Free particles whose friction, masses or both are matrices, at a temperature of the time.
macro_rules! heated {
    ($name:ident, $($system:tt)*) => {
        #[hamiltonian(
            $($system)*,
            temperature = |t| 0.4 + 1.3 * t,
            embedding = Splitting<(O, A, B)>,
        )]
        struct $name;
    };
}
heated!(OneRate, drift = |[x, y], [px, py]| px * px + 0.5 * py * py + 0.3 * px * py, friction = 0.9);
heated!(
    OneRateOfPlace,
    drift = |[x, y], [px, py]| px * px + 0.5 * py * py + 0.3 * px * py,
    friction = |[x, y]| x + y
);
heated!(
    Matrix,
    drift = |[x, y], [px, py]| px * px + 0.5 * py * py + 0.3 * px * py,
    damping = [[1.1, 0.4], [0.4, 0.6]]
);
heated!(RatesByPlace, drift = |[x, y], [px, py]| px * px + 0.5 * py * py, friction = |[x, y]| [x, 3.0 * y]);

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

/// A large chain goes tile by tile: the bits of a small one, and the energy is gained as heat and work.
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
        // Threads change no bit of the heats; one after the other, the sum of a degree of freedom has one
        // term for each step.
        assert_eq!(path.heat_by_degree(), run(2).heat_by_degree());
        let sum: f64 = path.heat_by_degree().iter().sum();
        assert!(path.heat_by_degree().len() == n && (sum - path.heat()).abs() < 1e-12 * gained.abs());
    }
}

/// `dH = Q + W`, and the heats of the degrees of freedom add up to `Q`.
#[test]
fn each_bath_has_its_heat() {
    let heated = Heated { gamma: 0.7, hot: vec![3.0, 0.2, 0.0, 1.0], slope: 0.1 };
    let start = State::new(vec![0.1; 4], vec![0.2, -0.1, 0.0, 0.5]);
    macro_rules! check {
        ($scheme:ty) => {{
            let run = || heated.simulate::<$scheme>(0.1).start(start.clone()).noise(StepNormals::seed(3));
            let path = run().until(20.05).run().unwrap();
            let (heats, gained) = (path.heat_by_degree(), heated.energy(path.last()) - heated.energy(&start));
            assert!((heats.iter().sum::<f64>() - path.heat()).abs() < 1e-12 && heats.len() == 4);
            assert!((path.heat() + path.work() - gained).abs() < 1e-12);
            // The kinetic energy that each momentum gains in its O parts, from the steps themselves.
            let averages = run().observe("x", |state| state.q[0]).until(20.05).time_averages().run().unwrap();
            assert_eq!(averages.heat_by_degree, heats);
            assert!(averages.to_string().contains("no equilibrium"), "{averages}");
            // In an ensemble, path by path.
            let statistics = heated
                .ensemble::<$scheme>(0.1)
                .start(start.clone())
                .paths(4)
                .seed(3)
                .until(20.05)
                .observe_work();
            let statistics = statistics.keep_paths(1 << 20).run().unwrap();
            let place = statistics.index("heat 0").unwrap();
            let kept = statistics.paths().unwrap();
            let last = kept.at(0, statistics.nodes().len() - 1).unwrap();
            let noise = StepNormals::seed(3).path(0);
            let single =
                heated.simulate::<$scheme>(0.1).start(start.clone()).noise(noise).until(20.05).run().unwrap();
            for (own, observed) in single.heat_by_degree().iter().zip(&last[place..]) {
                assert!((own - observed).abs() < 1e-12, "{own} {observed}");
            }
            assert_eq!(kept.at(0, 0).unwrap()[place..], [0.0; 4]);
            assert!(statistics.to_string().contains("no equilibrium: the temperatures of the degrees"));
        }};
    }
    check!(Baoab);
    check!(Thermostat<Midpoint>);
    // One bath has one heat.
    let one = OneNumber { kt: 0.8 };
    let run = one.simulate::<Baoab>(0.1).start(State::new([0.0; 2], [0.0; 2])).noise(StepNormals::seed(1));
    assert!(run.steps(3).run().unwrap().heat_by_degree().is_empty());
    // The heat of a momentum without a force is what its kinetic energy gains.
    let ramp = Ramp { m: 1.7, g: 0.6, start: 0.4, slope: 1.3 };
    let start = State::new([0.0; 2], [0.3, -0.2]);
    let path = ramp.simulate::<Obabo>(0.3).start(start).noise(StepNormals::seed(2)).steps(7).run().unwrap();
    for (heat, (p, p0)) in path.heat_by_degree().iter().zip(path.last().p.iter().zip(&start.p)) {
        assert!((heat - (p * p - p0 * p0) / (2.0 * 1.7)).abs() < 1e-14);
    }
}

#[test]
fn heats_survive_halved_steps() {
    let ramp = Ramp { m: 1.7, g: 0.6, start: 0.4, slope: 1.3 };
    let start = State::new([0.0; 2], [0.3, -0.2]);
    let run = ramp.simulate::<Thermostat<Midpoint>>(0.3).start(start).noise(Wiener::seed(2));
    let path = run.retry(Retry::halving(3)).until(2.0).run().unwrap();
    for (heat, (p, p0)) in path.heat_by_degree().iter().zip(path.last().p.iter().zip(&start.p)) {
        assert!((heat - (p * p - p0 * p0) / (2.0 * 1.7)).abs() < 1e-14);
    }
}

#[test]
fn what_needs_one_temperature_is_refused_where_there_is_none() {
    let why = |result: Result<Statistics, wzvi::Error>| match result.unwrap_err() {
        wzvi::Error::Config(ConfigError::NoEquilibrium { why, .. }) => why,
        other => panic!("{other}"),
    };
    let heated = Heated { gamma: 0.7, hot: vec![3.0, 0.2, 0.0], slope: 0.0 };
    let start = State::new(vec![0.1; 3], vec![0.2; 3]);
    let run = || heated.ensemble::<Baoab>(0.1).start(start.clone()).paths(4).seed(3).steps(2);
    assert!(why(run().observe_jarzynski().run()).contains("differ"));
    assert!(why(run().observe_temperatures().run()).contains("differ"));
    assert!(run().observe_equipartition().run().is_ok());
    let path =
        heated.simulate::<Baoab>(0.1).start(start).noise(StepNormals::seed(3)).steps(50).run().unwrap();
    let shares = path.equipartition(&heated);
    assert!(shares.kinetic_temperature.temperature.is_nan() && !shares.kinetic[0].temperature.is_nan());
    assert!(shares.to_string().starts_with("no one temperature"), "{shares}");
    let heating = OneRate;
    let run =
        || heating.ensemble::<FirstO>(0.1).start(State::new([0.0; 2], [0.1; 2])).paths(4).seed(3).steps(2);
    assert!(why(run().observe_jarzynski().run()).contains("time"));
    // One temperature of the time is one at each time.
    assert!(run().observe_temperatures().run().is_ok());
    let cold = OneNumber { kt: 0.0 };
    let run = |system: &OneNumber| {
        let run =
            system.ensemble::<Baoab>(0.1).start(State::new([0.0; 2], [0.1; 2])).paths(4).seed(3).steps(2);
        run.observe_jarzynski().run()
    };
    assert!(why(run(&cold)).contains("is 0"));
    // Without explicit time the energy is a constant of the equation, and the work is that of the scheme
    // alone.
    let weight = run(&OneNumber { kt: 0.8 }).unwrap().mean("exp(-work/kT)").unwrap();
    assert!((weight - 1.0).abs() < 0.01 && weight != 1.0, "{weight}");
}

#[test]
fn diagonal_friction_matrices_have_temperatures_by_site() {
    let start = || State::new([0.3, -0.2], [0.1, 0.4]);
    macro_rules! end {
        ($scheme:ty, $system:expr) => {{
            let system = $system;
            let run = system.simulate::<$scheme>(0.1).start(start()).noise(StepNormals::seed(5));
            let path = run.steps(40).run().unwrap();
            (path.last().clone(), path.heat_by_degree().to_vec())
        }};
    }
    let (g, t2) = (0.3, 0.25);
    let gamma = [[1.4, 0.0], [0.0, g]];
    assert_eq!(end!(Baoab, DiagonalMatrix { g, t2 }), end!(Baoab, DiagonalRates { g, t2 }));
    assert_eq!(end!(Baoab, MatrixOfField { gamma, t2 }), end!(Baoab, DiagonalRates { g, t2 }));
    type Around = Thermostat<Midpoint>;
    assert_eq!(end!(Around, DiagonalMatrix { g, t2 }), end!(Around, DiagonalRates { g, t2 }));
    let coupled = MatrixOfField { gamma: [[1.4, 0.1], [0.1, g]], t2 };
    match coupled.stepper::<Baoab>(0.1).map(drop).unwrap_err() {
        ConfigError::Bath(BathError::Coupled { entry: [0, 1] }) => {}
        other => panic!("{other}"),
    }
}

/// The covariance of the momenta after an O part, by `Σ' = -A Σ - Σ Aᵀ + 2 T(t) Γ` with `A = Γ M⁻¹` and small
/// steps of Runge and Kutta.
fn covariance(gamma: [[f64; 2]; 2], inverse_mass: [[f64; 2]; 2], h: f64) -> [[f64; 2]; 2] {
    use std::array::from_fn;
    type Two = [[f64; 2]; 2];
    let a: Two = from_fn(|i| from_fn(|j| (0..2).map(|k| gamma[i][k] * inverse_mass[k][j]).sum()));
    let rate = |t: f64, s: Two| -> Two {
        from_fn(|i| {
            from_fn(|j| {
                let drained: f64 = (0..2).map(|k| a[i][k] * s[k][j] + s[i][k] * a[j][k]).sum();
                2.0 * (0.4 + 1.3 * t) * gamma[i][j] - drained
            })
        })
    };
    let moved = |s: Two, by: f64, k: Two| -> Two { from_fn(|i| from_fn(|j| s[i][j] + by * k[i][j])) };
    let dt = h / 1000.0;
    (0..1000).fold([[0.0; 2]; 2], |s, n| {
        let t = f64::from(n) * dt;
        let k1 = rate(t, s);
        let k2 = rate(t + 0.5 * dt, moved(s, 0.5 * dt, k1));
        let k3 = rate(t + 0.5 * dt, moved(s, 0.5 * dt, k2));
        let k4 = rate(t + dt, moved(s, dt, k3));
        from_fn(|i| from_fn(|j| s[i][j] + dt / 6.0 * (k1[i][j] + 2.0 * k2[i][j] + 2.0 * k3[i][j] + k4[i][j])))
    })
}

/// Friction of the place is taken where the step is, so that one O part has the law of a constant one.
#[test]
fn matrices_have_the_exact_law_under_a_linear_temperature() {
    let h = 0.8;
    let (coupled, apart) = ([[2.0, 0.3], [0.3, 1.0]], [[2.0, 0.0], [0.0, 1.0]]);
    macro_rules! check {
        ($system:ident, $gamma:expr, $inverse_mass:expr) => {{
            let (system, exact) = ($system, covariance($gamma, $inverse_mass, h));
            let mut found = [[0.0; 2]; 2];
            for normal in 0..2 {
                let (mut stepper, mut state) =
                    (system.stepper::<FirstO>(h).unwrap(), State::new([0.4, 0.25], [0.0; 2]));
                let mut dw = [0.0; 2];
                dw[normal] = h.sqrt();
                stepper.step(&mut state, &dw).unwrap();
                for (i, row) in found.iter_mut().enumerate() {
                    for (j, entry) in row.iter_mut().enumerate() {
                        *entry += state.p[i] * state.p[j];
                    }
                }
            }
            for (found, exact) in found.iter().flatten().zip(exact.iter().flatten()) {
                // The reference has an error of (h/1000)⁴ and the rounding of 1000 sums.
                assert!((found - exact).abs() < 1e-12, "{}: {found} for {exact}", stringify!($system));
            }
        }};
    }
    // Γ = γ M, with M the inverse of `coupled`.
    let of_rate = |rate: f64| {
        let determinant = 2.0 - 0.09;
        [
            [rate / determinant, -0.3 * rate / determinant],
            [-0.3 * rate / determinant, 2.0 * rate / determinant],
        ]
    };
    check!(OneRate, of_rate(0.9), coupled);
    check!(OneRateOfPlace, of_rate(0.65), coupled);
    check!(Matrix, [[1.1, 0.4], [0.4, 0.6]], coupled);
    check!(RatesByPlace, [[0.4 / 2.0, 0.0], [0.0, 0.75]], apart);
}

/// A run at a temperature of the time that was stopped and goes on has the bits of one that was not.
#[test]
fn resumed_runs_have_the_bits_of_whole_ones() {
    let heated = Heated { gamma: 0.7, hot: vec![3.0, 0.2, 0.0], slope: 0.1 };
    let folder = fixtures::folder!("timed");
    let file = || Checkpoint::to(folder.join("kept"));
    let start = State::new(vec![0.1; 3], vec![0.2; 3]);
    let run =
        |steps| heated.simulate::<Baoab>(0.1).start(start.clone()).noise(StepNormals::seed(3)).steps(steps);
    let whole = run(60).run().unwrap();
    run(37).checkpoint(file()).run().unwrap();
    let resumed = run(60).checkpoint(file()).run().unwrap();
    assert_eq!(resumed, whole);
    assert!(resumed.heat_by_degree() == whole.heat_by_degree() && resumed.heat_by_degree().len() == 3);
}
