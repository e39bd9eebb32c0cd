//! Runs by a clock: their ends, the states between their nodes, noise, friction, checkpoints and ensembles.

use std::f64::consts::PI;

use fixtures::folder;
use wzvi::nalgebra::SVector;
use wzvi::prelude::*;

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) - 1.0 / x.hypot(y),
    clock = curvature,
    embedding = [Clocked<Verlet>, Clocked<Gauss<4>>, Clocked<Gauss<8>>, Extended<Gauss<8>>],
    invariant = [|[x, y], [px, py]| x * py - y * px],
)]
struct Kepler;

/// Kepler's problem in a gas.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) - 1.0 / x.hypot(y),
    friction = gamma,
    clock = |[x, y], [px, py]| (x * x + y * y).powf(0.75),
    embedding = [Clocked<Verlet>, Clocked<Gauss<4>>],
)]
struct InGas {
    gamma: f64,
}

/// A quartic well that is shaken.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.25 * q.powi(4),
    noise = [|q, p| -s * q],
    clock = |q, p| 1.0 / (1.0 + q * q).sqrt(),
    embedding = [Clocked<Midpoint>, Clocked<Verlet>],
)]
struct Shaken {
    s: f64,
}

type Orbit = State<SVector<f64, 2>>;

/// An orbit of the semi-major axis 1 and this eccentricity, at its pericentre.
fn pericentre(e: f64) -> Orbit {
    State::new([1.0 - e, 0.0], [0.0, ((1.0 + e) / (1.0 - e)).sqrt()])
}

/// The place on that orbit at a time: Kepler's equation `E - e sin E = t`, by Newton's method.
fn place(e: f64, t: f64) -> [f64; 2] {
    let mut anomaly = t;
    for _ in 0..60 {
        anomaly -= (anomaly - e * anomaly.sin() - t) / (1.0 - e * anomaly.cos());
    }
    [anomaly.cos() - e, (1.0 - e * e).sqrt() * anomaly.sin()]
}

fn distance(state: &Orbit, place: [f64; 2]) -> f64 {
    (state.q[0] - place[0]).hypot(state.q[1] - place[1])
}

/// Ten orbits of e = 0.9 and a bit more, to the table of MATH3 A3 within a factor of three: `Gauss<8>` has
/// 3e-11 for 21 000 evaluations and 3e-12 for 29 000 there.
#[test]
fn a_run_ends_at_its_time() {
    let end = 20.0 * PI + 1.0;
    let run = Kepler.simulate::<Clocked<Gauss<8>>>(Eps(0.3)).start(pericentre(0.9)).until(end).run().unwrap();
    let evaluations = 8 * run.iterations().total;
    assert!(evaluations < 21_000, "{evaluations}");
    assert_eq!(run.last().t, end);
    assert!(distance(run.last(), place(0.9, end)) < 9e-11, "{:e}", distance(run.last(), place(0.9, end)));
    // Two different roundings per step, and no drift.
    assert!(run.energy_drift(&Kepler) < 1e-10);
    assert!(run.invariant_drift(&Kepler, 0).unwrap() < 1e-13);
    // Intervals are adjacent, and follow `r^(3/2)`.
    let intervals = run.intervals();
    assert_eq!(intervals.len() as u64, run.steps());
    for (interval, state) in intervals.iter().zip(run.iter()) {
        assert_eq!(interval.t, state.t);
        let curvature = state.q.norm().powf(1.5) / 5_f64.powf(0.25);
        assert!((interval.rho.unwrap() * curvature - 1.0).abs() < 0.2, "{interval:?}");
    }
    let nowhere =
        Kepler.simulate::<Clocked<Gauss<8>>>(Eps(0.3)).start(pericentre(0.9)).until(0.0).run().unwrap();
    assert_eq!((nowhere.steps(), nowhere.last()), (0, &pericentre(0.9)));
    // Back to the start, where the clock starts elsewhere on the orbit: within the error of both runs.
    let back = Kepler.simulate::<Clocked<Gauss<8>>>(Eps(0.3)).start(*run.last()).until(0.0).run().unwrap();
    assert!(distance(back.last(), [0.1, 0.0]) < 1e-9, "{:?}", back.last());
}

/// Orders in the position at a time, by side steps too: 2, 4 and 8, and those of compositions.
#[test]
fn errors_fall_with_the_order_of_the_scheme() {
    fn error<E>(eps: f64, t: f64) -> f64
    where
        Kepler: Discretized<E, Vector = SVector<f64, 2>>,
    {
        let start = pericentre(0.6);
        let path = wzvi::simulate::Simulation::<Kepler, E>::new(&Kepler, eps);
        let path = path.start(start).record_at([0.37 * t]).until(t).run().unwrap();
        let recorded = distance(&path.states()[1], place(0.6, 0.37 * t));
        recorded.max(distance(path.last(), place(0.6, t)))
    }
    fn order<E>(eps: f64) -> f64
    where
        Kepler: Discretized<E, Vector = SVector<f64, 2>>,
    {
        (error::<E>(eps, 17.3) / error::<E>(0.5 * eps, 17.3)).log2()
    }
    // The distance from the limit at these steps; errors stay above 1e-12.
    for (found, order) in [
        (order::<Clocked<Verlet>>(0.02), 2.0),
        (order::<Clocked<Gauss<4>>>(0.25), 8.0),
        (order::<Clocked<Composed<Verlet, Yoshida4>>>(0.05), 4.0),
        (order::<Composed<Clocked<Verlet>, Yoshida4>>(0.05), 4.0),
        (order::<Composed<Clocked<Verlet>, KahanLi6>>(0.2), 6.0),
        (order::<Composed<Clocked<Verlet>, KahanLi8>>(0.2), 8.0),
    ] {
        assert!((found - order).abs() < 0.15, "{found} {order}");
    }
}

/// Recorded times, sections and states between nodes have the full order of the scheme.
#[test]
fn what_is_between_nodes_is_as_exact_as_the_nodes() {
    let run = || Kepler.simulate::<Clocked<Gauss<8>>>(Eps(0.25)).start(pericentre(0.9)).until(10.0);
    let times = [1.0, 2.5, PI, 2.0 * PI + 1e-3, 9.0];
    let recorded = run().record_at(times).section(|s| s.q[1]).run().unwrap();
    assert_eq!(recorded.len(), times.len() + 2);
    // Nodes are off by 1e-12 at these steps (the test above, ten times as long).
    for (t, state) in times.into_iter().zip(&recorded.states()[1..]) {
        assert_eq!(state.t, t);
        assert!(distance(state, place(0.9, t)) < 1e-12, "{t}: {:e}", distance(state, place(0.9, t)));
    }
    let crossings: Vec<f64> = recorded.crossings().iter().map(|crossing| crossing.state.t / PI).collect();
    assert_eq!(crossings.len(), 3);
    for (t, exact) in crossings.iter().zip([1.0, 2.0, 3.0]) {
        assert!((t - exact).abs() < 1e-12, "{t}");
    }
    let path = run().run().unwrap();
    // Nothing that is recorded changes the run.
    assert_eq!(path.last(), recorded.last());
    for t in times {
        let state = path.state_at(&Kepler, t).unwrap();
        assert!(distance(&state, place(0.9, t)) < 1e-12, "{t}");
    }
    assert!(path.time_scale().is_err());
}

/// With friction: the angular momentum falls by the factor `e^{-γ t}` exactly, whatever the steps.
#[test]
fn friction_takes_the_length_of_each_step() {
    let gas = InGas { gamma: 0.02 };
    let path = gas.simulate::<Clocked<Gauss<4>>>(Eps(0.1)).start(pericentre(0.9)).until(20.0).run().unwrap();
    for state in path.iter() {
        let momentum = state.q[0] * state.p[1] - state.q[1] * state.p[0];
        let exact = (1.0_f64 - 0.81).sqrt() * (-0.02 * state.t).exp();
        assert!((momentum - exact).abs() < 1e-13, "{}", state.t);
    }
    let finer =
        gas.simulate::<Clocked<Gauss<4>>>(Eps(0.05)).start(pericentre(0.9)).until(20.0).run().unwrap();
    assert!((path.last().q - finer.last().q).norm() < 1e-8);
    // Work and heat: the energy that is lost is the heat, up to the quadrature along the steps.
    assert!((finer.heat() - (gas.energy(finer.last()) - gas.energy(&pericentre(0.9)))).abs() < 1e-3);
}

/// Steps follow the motion along one Wiener path: its value at the end is that of the path, for any `eps`.
#[test]
fn noise_is_that_of_the_times() {
    let shaken = Shaken { s: 0.5 };
    let run = |eps: f64| {
        let run = shaken.simulate::<Clocked<Midpoint>>(Eps(eps)).start(State::new([1.0], [0.0])).until(5.0);
        run.noise(Wiener::seed(7)).run().unwrap()
    };
    let w = Wiener::seed(7).value(0, 5.0).unwrap();
    let fine = run(4e-4);
    let mut before = f64::INFINITY;
    for eps in [0.1, 0.02, 0.004] {
        let path = run(eps);
        // Sums of as many roundings as there are steps.
        assert!((path.wiener(0).last().unwrap() - w).abs() < 1e-13 * path.steps() as f64);
        let error = (path.last().q[0] - fine.last().q[0]).abs();
        assert!(error < before, "{eps}: {error}");
        before = error;
    }
    assert!(before < 3e-3, "{before}");
    // A state between nodes is on the same path.
    let path = run(0.02);
    let between = path.at(&shaken).noise(Wiener::seed(7)).state(3.21).unwrap();
    let recorded = shaken.simulate::<Clocked<Midpoint>>(Eps(0.02)).start(State::new([1.0], [0.0])).until(5.0);
    let recorded = recorded.noise(Wiener::seed(7)).record_at([3.21]).run().unwrap();
    assert_eq!(recorded.states()[1], between);
}

/// A path of an ensemble is a run; what is recorded at a time is the same for any number of threads.
#[test]
fn paths_of_an_ensemble_are_runs() {
    let shaken = Shaken { s: 0.5 };
    let many = |threads: usize| {
        let many = shaken.ensemble::<Clocked<Midpoint>>(Eps(0.05)).start(State::new([1.0], [0.0])).paths(130);
        many.seed(3).until(2.0).record_at([0.7, 1.0]).threads(threads)
    };
    let (one, two) = (many(1).run().unwrap(), many(2).run().unwrap());
    let means = |many: &wzvi::ensemble::Statistics| -> Vec<f64> {
        many.nodes().iter().flat_map(|node| (0..3).map(|i| node.mean(i))).collect()
    };
    assert_eq!(means(&one), means(&two));
    let alone = |path: u64| {
        let run =
            shaken.simulate::<Clocked<Midpoint>>(Eps(0.05)).start(State::new([1.0], [0.0])).plain_sums();
        run.noise(StepNormals::seed(3).path(path)).until(2.0).record_at([0.7, 1.0]).run().unwrap()
    };
    let mean = (0..130).map(|path| alone(path).states()[2].q[0]).sum::<f64>() / 130.0;
    assert!((mean - one.nodes()[2].mean(0)).abs() < 1e-14);
    assert_eq!(many(1).replay(17).unwrap().0.last(), alone(17).last());
    let said = many(1).record_every(2).run().map(drop).unwrap_err().to_string();
    assert!(said.contains(".record_at(times)"), "{said}");
}

#[test]
fn a_run_by_a_clock_resumes() {
    resumes::<Clocked<Gauss<8>>>("density.checkpoint");
    resumes::<Extended<Gauss<8>>>("extended.checkpoint");
    resumes::<Clocked<Composed<Verlet, Yoshida4>>>("inner.checkpoint");
}

fn resumes<E>(name: &str)
where
    Kepler: Discretized<E>,
{
    let file = folder!("clock").join(name);
    let run = |end: f64| {
        let run = Kepler.simulate::<E>(Eps(0.2)).start(pericentre(0.9)).until(end);
        run.section(|s| s.q[1]).on_time(7.0, |s| s.p[0] += 0.1)
    };
    let whole = run(12.0).run().unwrap();
    // The last step of the shorter run ends at its time, and is none of those that a longer run goes on from.
    let part = run(8.0).checkpoint(Checkpoint::to(&file).every_steps(5)).run().unwrap();
    assert!(part.last().t == 8.0 && part.steps() < whole.steps());
    let resumed = run(12.0).checkpoint(Checkpoint::to(&file).every_steps(5)).run().unwrap();
    assert_eq!(resumed.states(), whole.states());
    assert_eq!(resumed.intervals(), whole.intervals());
    assert_eq!(resumed.crossings(), whole.crossings());
    assert_eq!(resumed.events(), whole.events());
    // An end before the file.
    let said =
        run(2.0).checkpoint(Checkpoint::to(&file).every_steps(5)).run().map(drop).unwrap_err().to_string();
    assert!(said.contains("give a later end"), "{said}");
}

/// The last step, which the end of the run cuts, has the noise of the whole step; what happens at the end of
/// a run by a clock is recorded.
#[test]
fn the_last_step_keeps_its_noise() {
    let shaken = Shaken { s: 0.3 };
    let run = |end: f64| {
        let run = shaken.simulate::<Clocked<Midpoint>>(Eps(0.05)).start(State::new([1.0], [0.0]));
        run.noise(StepNormals::seed(3)).until(end)
    };
    let (path, longer) = (run(1.0).run().unwrap(), run(2.0).run().unwrap());
    let begin = path.intervals().last().unwrap().t;
    for t in [begin + 0.3 * (1.0 - begin), begin + 0.8 * (1.0 - begin), 1.0] {
        let state = |path: &Trajectory<_, _>| path.at(&shaken).noise(StepNormals::seed(3)).state(t).unwrap();
        let (one, other) = (state(&path), state(&longer));
        assert!((one.p[0] - other.p[0]).abs() < 1e-14, "{t}: {one:?} {other:?}");
    }
}

#[test]
fn clocks_that_are_none_are_refused() {
    let run = |eps: f64| Kepler.simulate::<Clocked<Verlet>>(Eps(eps)).start(pericentre(0.9)).until(10.0);
    for eps in [0.0, -0.2, f64::NAN, f64::INFINITY] {
        let said = run(eps).run().map(drop).unwrap_err().to_string();
        assert!(said.starts_with("`Eps("), "{said}");
    }
    let said = run(80.0).run().map(drop).unwrap_err().to_string();
    assert!(said.contains("take a smaller `Eps`"), "{said}");
    let steps = Kepler.simulate::<Clocked<Verlet>>(Eps(0.2)).start(pericentre(0.9)).steps(9).record_at([0.1]);
    let said = steps.run().map(drop).unwrap_err().to_string();
    assert!(said.contains("write `.until(0.1)`"), "{said}");
    let centre =
        Kepler.simulate::<Clocked<Verlet>>(Eps(0.2)).start(State::new([0.0, 0.0], [1.0, 0.0])).until(1.0);
    let said = centre.run().map(drop).unwrap_err().to_string();
    assert!(said.contains("the clock is"), "{said}");
    for said in [
        run(0.2).retry(Retry::halving(2)).run().map(drop).unwrap_err(),
        run(0.2).time_averages().run().map(drop).unwrap_err(),
        run(0.2).tangent().map(drop).unwrap_err(),
        run(0.2).whole_steps().run().map(drop).unwrap_err(),
    ] {
        assert!(said.to_string().contains("clock"), "{said}");
    }
}
