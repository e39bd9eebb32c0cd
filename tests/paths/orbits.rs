//! A step that is far too long for the orbit: a run whose energy has changed, and stays changed, is no result.
//!
//! A deterministic run of constant step watches its energy (docs/guide/stability.md); what is right is never refused.

use fixtures::rest::ScaledWell;
use fixtures::small::{Kepler, Rotation};
use fixtures::{Uniform, larger};
use wzvi::error::{StepError, StepFailure};
use wzvi::prelude::*;

/// Two coupled modes, linear where `quartic` is zero.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) + 0.5 * (a * x * x + b * y * y + c * x * y)
        + 0.25 * quartic * (x * x * x * x + y * y * y * y),
    embedding = [Midpoint, Verlet, DeltaPlus, Lambda<1, 4>],
)]
struct Modes {
    a: f64,
    b: f64,
    c: f64,
    quartic: f64,
}

type Planar = State<wzvi::nalgebra::SVector<f64, 2>>;

/// Starts of an orbit of semi-axis one, from its pericentre and its apocentre.
fn ends_of_orbit(e: f64) -> [Planar; 2] {
    let speed = ((1.0 - e) / (1.0 + e)).sqrt();
    [State::new([1.0 - e, 0.0], [0.0, 1.0 / speed]), State::new([1.0 + e, 0.0], [0.0, speed])]
}

/// `Unresolved` with a time, or nothing.
fn alarm<V, E>(outcome: Result<Trajectory<V, E>, wzvi::Error>) -> Option<StepError> {
    match outcome {
        Ok(_) => None,
        Err(wzvi::Error::Step(error)) if matches!(error.cause, StepFailure::Unresolved { .. }) => Some(error),
        Err(error) => panic!("{error}"),
    }
}

/// Uniform numbers below one.
fn numbers(seed: u64) -> impl FnMut() -> f64 {
    let mut uniform = Uniform(seed);
    move || 0.5 * (uniform.draw() + 1.0)
}

/// Divided where it has to be, a step is divided until its halves agree: the mid-point at e = 0.99 takes the pericentre in parts of a
/// hundredth of the time that it spends there, and keeps its energy.
#[test]
fn divided_steps_resolve_the_pericentre() {
    for start in ends_of_orbit(0.99) {
        let run = || Kepler.simulate::<Midpoint>(1e-3).start(start).until(20.0);
        let path = run().retry(Retry::halving(10)).run().unwrap();
        let drift = path.energy_drift(&Kepler);
        println!("{:?} drift {drift:.2e}", path.iterations());
        // The alarm is a tenth of the mean of `p · dq/dt`, which is twice the kinetic energy: one, by the virial theorem.
        assert!((path.last().t - 20.0).abs() < 1e-9 && drift.is_finite());
        let energy = Kepler.energy(path.last());
        let at_end = (energy - Kepler.energy(&start)).abs();
        assert!(at_end < 0.1, "{start:?}: {energy}");
    }
}

/// Where `H` is not the energy that the mid-point keeps, at the few nodes of a passage, it is off by several times the mean motion, and it returns.
#[test]
fn the_energy_of_an_orbit_returns_after_each_passage() {
    let [_, apocentre] = ends_of_orbit(0.99);
    let run = Kepler.simulate::<Midpoint>(1e-3).start(apocentre).until(100.0);
    let path = run.retry(Retry::halving(12)).run().unwrap();
    let off = |state: &Planar| (Kepler.energy(state) + 0.5).abs();
    let (inside, outside): (Vec<_>, Vec<_>) = path.states().iter().partition(|state| state.q.norm() < 0.02);
    let largest = |states: &[&Planar]| states.iter().fold(0.0, |most, state| larger(most, off(state)));
    println!(
        "{} of {} nodes: {:.3}, others {:.3}",
        inside.len(),
        path.states().len(),
        largest(&inside),
        largest(&outside)
    );
    assert!(largest(&inside) > 1.0 && inside.len() < 100);
    assert!(largest(&outside) < 0.1);
}

/// Solvable is not enough: with few halvings allowed the halves do not agree, and the run ends with an error.
#[test]
fn halves_that_do_not_agree_are_no_step() {
    let [_, apocentre] = ends_of_orbit(0.99);
    let run = Kepler.simulate::<Midpoint>(1e-3).start(apocentre).until(20.0);
    let error = alarm(run.retry(Retry::halving(3)).run()).expect("an error");
    println!("{error}");
    assert!(error.t > 3.0 && error.t < 3.3, "{error}");
}

#[test]
fn stages_that_leap_over_the_pericentre_are_refused() {
    for start in ends_of_orbit(0.99) {
        let run = || Kepler.simulate::<Gauss<8>>(1e-2).start(start).until(20.0);
        let error = alarm(run().run()).expect("an alarm");
        println!("{error}");
        assert!(error.h == 1e-2 && error.step < 600, "{error}");
        let path = run().unwatched().run().unwrap();
        assert!((Kepler.energy(path.last()) + 0.5).abs() > 0.1);
        assert_eq!(path.iterations().suspected, 0);
        // Halved as a whole until the energy stays.
        let path = run().retry(Retry::halving(8)).run().unwrap();
        println!("{:?}", path.iterations());
        assert!((Kepler.energy(path.last()) + 0.5).abs() < 0.1);
    }
}

/// Orbits beside each other, in the plane.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| (0..q.len() / 2).map(|i| {
        0.5 * (p[2 * i] * p[2 * i] + p[2 * i + 1] * p[2 * i + 1]) - 1.0 / q[2 * i].hypot(q[2 * i + 1])
    }).sum::<f64>(),
    embedding = [Verlet, DeltaPlus],
)]
struct Orbits;

/// A large system is tested rarely while its energy is right, and its energy is found to be off some 64 steps later. The orbits leap over the pericentre at
/// t = 3.14 for the first time.
#[test]
fn large_systems_are_refused_and_accepted_like_small_ones() {
    let many = |e: f64| {
        let [_, State { q, p, .. }] = ends_of_orbit(e);
        State::new([q[0], q[1]].repeat(64), [p[0], p[1]].repeat(64))
    };
    macro_rules! checked {
        ($scheme:ty) => {{
            let run = |e: f64| Orbits.simulate::<$scheme>(1e-3).start(many(e)).until(4.0).record_every(0);
            let error = alarm(run(0.99).run()).expect("an alarm");
            println!("{error}");
            // The pericentre, the next test, and eight more of eight steps.
            assert!(error.step > 3141 && error.step < 3141 + 128 + 72, "{error}");
            assert_eq!(run(0.99).unwatched().run().unwrap().iterations().suspected, 0);
            assert!(run(0.3).run().is_ok());
        }};
    }
    checked!(Verlet);
    checked!(DeltaPlus);
}

/// What it watches is a first integral of linear steps of any frequency, so that no stable linear motion is suspected.
#[test]
fn stable_linear_motions_are_never_suspected() {
    let mut random = numbers(5);
    for case in 0..60 {
        // Frequencies over four decades; the fastest at the limit of the explicit schemes.
        let (a, b) = (1.0, 10.0_f64.powf(4.0 * random()));
        let c = (2.0 * random() - 1.0) * a * b.sqrt().min(1.0);
        let fastest = (0.5 * (a + b) + (0.25 * (a - b) * (a - b) + 0.25 * c * c).sqrt()).sqrt();
        let system = Modes { a, b, c, quartic: 0.0 };
        let start = State::new([random() - 0.5, random() - 0.5], [random() - 0.5, random() - 0.5]);
        let limit = 2.0 * (0.1 + 0.895 * random()) / fastest;
        macro_rules! watched {
            ($($scheme:ty, $h:expr);+) => {[$(
                system.simulate::<$scheme>($h).start(start).steps(2000).run().map(|path| path.iterations())
            ),+]};
        }
        // The composition is stable up to ωh = 1.57, the asymmetric scheme while `h² ω² (1/2 - l)² < 1`.
        let watched = watched!(
            Verlet, limit; DeltaPlus, limit; Composed<Verlet, Yoshida4>, 0.75 * limit; Lambda<1, 4>, limit;
            Midpoint, 100.0 * random() / fastest
        );
        for (scheme, iterations) in watched.into_iter().enumerate() {
            let iterations = iterations.unwrap_or_else(|error| panic!("{case}, {scheme}: {error}"));
            // What a composition keeps nearly may come and go.
            assert!(iterations.suspected == 0 || scheme == 2, "{case}, {scheme}: {iterations:?}");
        }
    }
}

/// Quartic forces of a tenth of the linear ones, up to half of the limit.
#[test]
fn resolved_nonlinear_motions_are_not_refused() {
    let mut random = numbers(11);
    for case in 0..60 {
        let (a, b) = (1.0, 10.0_f64.powf(2.0 * random()));
        let system = Modes { a, b, c: 0.0, quartic: 0.1 };
        let start = State::new([random() - 0.5, random() - 0.5], [random() - 0.5, random() - 0.5]);
        let h = random() / b.sqrt();
        for refused in [
            alarm(system.simulate::<Verlet>(h).start(start).steps(4000).run()),
            alarm(system.simulate::<Midpoint>(h).start(start).steps(4000).run()),
        ] {
            assert_eq!(refused, None, "{case}");
        }
    }
}

/// Units are the user's: the same steps in others are the same run.
#[test]
fn the_judgement_does_not_depend_on_units() {
    /// Kepler's problem with a unit of length and of momentum.
    #[hamiltonian(
        drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) / mass - strength / (x * x + y * y).sqrt(),
        embedding = Gauss<2>,
    )]
    struct Scaled {
        mass: f64,
        strength: f64,
    }
    let mut steps = Vec::new();
    // Powers of two, so that every number is the same but for its exponent.
    for (length, momentum) in [(1.0, 1.0), (2.0_f64.powi(40), 1.0), (2.0_f64.powi(-50), 2.0_f64.powi(-60))] {
        // Time in units of one: energies are length times momentum.
        let system = Scaled { mass: momentum / length, strength: length * length * momentum };
        let start = State::new([1.9 * length, 0.0], [0.0, momentum * (0.1_f64 / 1.9).sqrt()]);
        let error = alarm(system.simulate::<Gauss<2>>(0.05).start(start).until(100.0).run());
        steps.push(error.expect("an alarm").step);
    }
    assert_eq!(steps, vec![steps[0]; 3]);
}

/// At rest, and nearly: the motion is rounding, and no energy error.
#[test]
fn rounding_is_no_alarm() {
    for amplitude in [0.0, 1e-300, 1e-160, 1e-12, 1e-9] {
        let system = Modes { a: 1.0, b: 1e6, c: 0.0, quartic: 1e3 };
        let start = State::new([amplitude, amplitude], [0.0, -amplitude]);
        assert!(system.simulate::<Verlet>(1.5e-3).start(start).steps(10_000).run().is_ok());
        assert!(system.simulate::<Midpoint>(1.0).start(start).steps(10_000).run().is_ok());
    }
    // On a circle: kinetic energies of a half, and an orbit that rounding alone changes.
    let path =
        Kepler.simulate::<Midpoint>(1e-2).start(State::new([1.0, 0.0], [0.0, 1.0])).steps(100_000).run();
    assert_eq!(path.unwrap().iterations().suspected, 0);
}

/// What rounding does to the energy is no alarm, be it as large as the motion: nearly at rest, and where a step turns by nearly half a turn, its stages are next to nothing.
#[test]
fn rounding_as_large_as_the_motion_is_no_alarm() {
    let start = State::new([1.0], [0.0]);
    for exponent in [4, 6, 8] {
        let (omega, steps) = (10.0_f64.powi(exponent), 10_000);
        let oscillator = Rotation { omega };
        let runs = [
            oscillator.simulate::<Midpoint>(1.0).start(start).steps(steps).run().map(|path| *path.last()),
            oscillator.simulate::<Gauss<8>>(1.0).start(start).steps(steps).run().map(|path| *path.last()),
        ];
        for end in runs {
            let end = end.unwrap_or_else(|error| panic!("ωh = 1e{exponent}: {error}"));
            let radius = end.q[0].hypot(end.p[0]);
            println!("ωh = 1e{exponent}: {:e}", radius - 1.0);
            // What the slopes of eight stages round to in each step, if all err to one side.
            let rounding = 8.0 * steps as f64 * omega * f64::EPSILON;
            assert!((radius - 1.0).abs() < rounding, "ωh = 1e{exponent}: {radius}");
        }
    }
    for scale in [1e-6, 1.0, 1e6] {
        let well = ScaledWell { scale };
        for speed in [1e-12, 1e-11, 1e-10] {
            let start = State::new([scale], [speed * scale]);
            let path = well.simulate::<Midpoint>(0.1).start(start).steps(10_000).run();
            let path = path.unwrap_or_else(|error| panic!("{scale} {speed}: {error}"));
            assert!((path.last().q[0] / scale - 1.0).abs() < speed);
        }
    }
}
