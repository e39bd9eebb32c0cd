//! Runs: ensembles, halved steps, checkpoints, heat, room.

use wzvi::checkpoint::Checkpoint;
use wzvi::nalgebra::SVector;
use wzvi::prelude::*;

use std::slice::from_ref;

use fixtures::bath::{Chain, Driven, Kicked, Oscillator, Rough, Wall};
use fixtures::stepped::{failed, paths_are_steppers};

const OSCILLATOR: Oscillator = Oscillator { m: 0.8, k: 1.3, b: 0.4, gamma: 0.6, kt: 0.7 };

fn check_lanes<H: Discretized<E> + Sync, E>(system: &H, h: f64, start: State<H::Vector>) {
    let run = || system.ensemble::<E>(h).start(start.clone());
    assert_eq!(failed(&paths_are_steppers(run, from_ref(system), (h, 40), (8, 9))), 0);
}

#[test]
fn a_path_of_an_ensemble_is_a_path() {
    let start = || State::new([0.3], [-0.4]);
    check_lanes::<_, Baoab>(&OSCILLATOR, 0.1, start());
    check_lanes::<_, Thermostat<Midpoint>>(&OSCILLATOR, 0.1, start());
    check_lanes::<_, Baoab>(&Driven { sigma: 0.4, gamma: 1.2, kt: 0.9 }, 0.1, start());
    check_lanes::<_, Thermostat<Midpoint>>(&Driven { sigma: 0.4, gamma: 1.2, kt: 0.9 }, 0.1, start());
    let chain = Chain { gamma: 0.5, kt: 1.0 };
    let start = || State::new(vec![0.1, 0.4, -0.2], vec![0.3, 0.0, -0.5]);
    check_lanes::<_, Baoab>(&chain, 0.1, start());
    check_lanes::<_, Thermostat<Midpoint>>(&chain, 0.1, start());
}

#[test]
fn energy_is_gained_as_heat() {
    // The mid-point keeps a quadratic energy: what it gains is heat, to rounding.
    let harmonic = Oscillator { b: 0.0, ..OSCILLATOR };
    let start = || State::new([0.3], [-0.4]);
    let run = harmonic.simulate::<Thermostat<Midpoint>>(0.3).start(start()).noise(StepNormals::seed(2));
    let path = run.steps(1000).run().expect("a path");
    let gained = harmonic.energy(path.last()) - harmonic.energy(&start());
    // A thousand steps with energies of the size of 1.
    assert!((gained - path.heat()).abs() < 1000.0 * 4.0 * f64::EPSILON, "{gained} {}", path.heat());
    assert!(path.heat() != 0.0 && path.shadow_work() == Some(path.work()), "{} {}", path.heat(), path.work());
    // Otherwise to the error of the energy, of order h²: on one Brownian path, with the noise of each fine step.
    fn error<E>(halvings: u32) -> f64
    where
        Oscillator: Discretized<E>,
    {
        let (h, start) = (0.2 / f64::from(1 << halvings), State::new([0.3], [-0.4]));
        let run = OSCILLATOR.simulate::<E>(h).start(start).noise(Wiener::seed(4));
        let path = run.until(20.0).run().expect("a path");
        let gained = OSCILLATOR.energy(path.last()) - OSCILLATOR.energy(&start);
        (gained - path.heat()).abs()
    }
    // A step of `Obabo` has two parts with friction, and the heat of both.
    for error in [error::<Baoab>, error::<Obabo>] {
        let errors: Vec<f64> = (0..5).map(error).collect();
        // Errors of either sign: over four halvings at least by 4³.
        assert!(errors[4] < errors[0] / 64.0, "{errors:?}");
    }
    // Halved steps count theirs, and so does a last step that is shorter.
    let run = harmonic.simulate::<Thermostat<Midpoint>>(0.3).start(start()).noise(Wiener::seed(4));
    let path = run.until(10.0).retry(Retry::halving(3)).run().expect("a path");
    let gained = harmonic.energy(path.last()) - harmonic.energy(&start());
    assert!((gained - path.heat()).abs() < 40.0 * 4.0 * f64::EPSILON);
}

#[test]
fn steps_that_fail_are_halved_with_their_normals() {
    // Friction is negative beyond the edge, which is no matter of step size; below it everything is as it is.
    let system = Rough { m: 1.0, gamma: 0.5, edge: 0.9, kt: 0.3 };
    let run = || system.simulate::<Baoab>(0.2).start(State::new([0.0], [0.1])).noise(StepNormals::seed(1));
    let (path, error) = run().retry(Retry::halving(6)).steps(4000).run_partial().expect("a run");
    let Some(wzvi::Error::Step(error)) = error else { panic!("{error:?}") };
    assert!(error.to_string().contains("friction"), "{error}");
    assert_eq!(path.steps(), error.step);
    // A wall that whole steps jump over and halved ones do not.
    let wall = Wall { gamma: 1.0, kt: 4.0 };
    let run = || wall.simulate::<Baoab>(1.0).start(State::new([1.0], [0.0])).noise(StepNormals::seed(1));
    let (_, error) = run().steps(300).run_partial().expect("a run");
    assert!(
        matches!(error, Some(wzvi::Error::Step(error)) if error.cause == wzvi::error::StepFailure::NonFinite)
    );
    let path = run().steps(300).retry(Retry::halving(12)).run().expect("a path");
    assert!(path.iterations().halved > 0 && path.iter().all(|state| state.q[0] > 0.0));
}

#[test]
fn checkpoints_bring_back_the_path_and_its_heat() {
    let folder = fixtures::folder!("resumed");
    check_resumed::<Baoab>(&folder.join("baoab"));
    check_resumed::<Thermostat<Gauss<2>>>(&folder.join("gauss"));
}

fn check_resumed<E>(file: &std::path::Path)
where
    Oscillator: Discretized<E, Vector = SVector<f64, 1>>,
{
    let run = |steps| {
        let run = OSCILLATOR.simulate::<E>(0.1).start(State::new([0.3], [-0.4])).noise(StepNormals::seed(3));
        run.steps(steps).record_every(5)
    };
    let whole = run(60).run().expect("a path");
    let to = || Checkpoint::to(file).every_steps(7);
    run(31).checkpoint(to()).run().expect("a path");
    let resumed = run(60).checkpoint(to()).run().expect("a path");
    assert!(resumed == whole && whole.heat() != 0.0);
}

#[test]
fn what_is_between_nodes_passes_through_them() {
    let start = State::new([0.3], [-0.4]);
    let run = OSCILLATOR.simulate::<Baoab>(0.1).start(start).noise(StepNormals::seed(6));
    let path = run.section(|state| state.q[0]).steps(2000).run().expect("a path");
    let signs = path.states().windows(2).filter(|pair| pair[0].q[0] * pair[1].q[0] < 0.0).count();
    assert!(path.crossings().len() >= signs && signs > 10);
    // On a line through the sections, the crossing is between its nodes, where q vanishes.
    assert!(path.crossings().iter().all(|crossing| crossing.state.q[0].abs() < 1e-12));
    let mut dense = wzvi::dense::DenseOutput::of(&start);
    let (mut state, mut stepper) = (start, OSCILLATOR.stepper::<Obabo>(0.1).expect("steps"));
    stepper.step_densely(&mut state, &[0.2, -0.1], &mut dense).expect("a step");
    assert_eq!((dense.at(0.0), dense.at(1.0)), (start, state));
}

#[test]
fn steps_allocate_nothing() {
    check_room::<_, Baoab>(&OSCILLATOR, State::new([0.3], [-0.4]));
    check_room::<_, Thermostat<Midpoint>>(&OSCILLATOR, State::new([0.3], [-0.4]));
    check_room::<_, Thermostat<Gauss<2>>>(&OSCILLATOR, State::new([0.3], [-0.4]));
    check_room::<_, Baoab>(
        &fixtures::bath::RoughPlane { m: 0.6, n: 2.0, k: 1.0, kt: 1.0 },
        State::new([0.1, 0.2], [0.3, 0.4]),
    );
    let chain = Chain { gamma: 0.5, kt: 1.0 };
    check_room::<_, Baoab>(&chain, State::new(vec![0.1, 0.4, -0.2], vec![0.3, 0.0, -0.5]));
    check_room::<_, Thermostat<Midpoint>>(&chain, State::new(vec![0.1, 0.4, -0.2], vec![0.3, 0.0, -0.5]));
    let kicked = Kicked { sites: 3, gamma: 0.5, kt: 1.0 };
    check_room::<_, Baoab>(&kicked, State::new(vec![0.1, 0.4, -0.2], vec![0.3, 0.0, -0.5]));
}

/// `q ← q` and `p ← p - 0.3 ΔW_k`: the work of all kicks in the middle of the step is that along the way.
#[test]
fn kicks_work_at_every_site() {
    let kicked = Kicked { sites: 200, gamma: 0.0, kt: 0.0 };
    let list = |scale: f64| (0..200).map(|i| scale * f64::from(i).sin()).collect::<Vec<_>>();
    let mut state = State::new(vec![0.4; 200], list(1.0));
    let (before, dw) = (kicked.energy(&state), [list(0.1), vec![0.0; 200]].concat());
    let mut stepper = kicked.stepper::<Baoab>(1e-9).expect("steps");
    stepper.step(&mut state, &dw).expect("a step");
    let (gain, work) = (kicked.energy(&state) - before, stepper.exchanged().work);
    assert!(work.abs() > 1.0, "{work}");
    // The rounding of sums of 200 terms of order one; drifts of 1e-9 between springs of no length.
    assert!((gain - work).abs() < 1e-13 * 200.0, "{gain} by {work}");
}

fn check_room<H: Discretized<E>, E>(system: &H, mut state: State<H::Vector>) {
    let degrees = wzvi::state::Vector::components(&state.q).len();
    let dw = vec![0.1; system.increments(degrees)];
    let mut stepper = system.stepper::<E>(0.05).expect("steps");
    // The first step may be solved with care, and of a system whose size the state knows it is the one that makes room.
    let mut hard = 0;
    for _ in 0..50 {
        hard += u32::from(stepper.step(&mut state, &dw).expect("a step").is_hard);
    }
    assert!(hard <= 1, "{hard}");
    let counted = allocation_counter::measure(|| {
        for _ in 0..20 {
            stepper.step(&mut state, &dw).expect("a step");
        }
    });
    assert_eq!(counted.count_total, 0, "{}", std::any::type_name::<(H, E)>());
}
