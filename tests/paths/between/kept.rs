//! Runs with sections and recorded times go on from their checkpoints.

use fixtures::folder;

use wzvi::checkpoint::{Checkpoint, CheckpointError};
use wzvi::prelude::*;
use wzvi::section::Direction;
use wzvi::simulate::{Simulation, Unobserved};

use super::systems::{Oscillator, Shaken, start};

fn oscillator(
    steps: u64,
) -> Simulation<'static, Oscillator, Gauss<8>, wzvi::increments::NoNoise, Unobserved> {
    // p is zero at the node 0, and touches 1 nowhere.
    let run = Oscillator.simulate::<Gauss<8>>(0.25).start(start()).steps(steps);
    run.section(|state| state.q[0]).section_towards(Direction::Rising, |state| state.p[0])
}

#[test]
fn sections_go_on() {
    let folder = folder!("sections");
    let whole = oscillator(60).run().unwrap();
    assert!(whole.crossings().len() > 5);
    for stop in [0, 1, 6, 7, 25, 59, 60] {
        let to = || Checkpoint::to(folder.join(format!("{stop}"))).every_steps(3);
        oscillator(stop).checkpoint(to()).run().unwrap();
        assert_eq!(oscillator(60).checkpoint(to()).run().unwrap(), whole, "{stop}");
        assert_eq!(oscillator(60).checkpoint(to()).run().unwrap(), whole, "{stop}, again");
    }
    let other =
        oscillator(60).section(|state| state.q[0]).checkpoint(Checkpoint::to(folder.join("25"))).run();
    let Err(wzvi::Error::Checkpoint(error)) = other else { panic!("another run") };
    assert!(error.to_string().contains("sections"), "{error}");
}

#[test]
fn recorded_times_go_on() {
    let folder = folder!("times");
    let run = |end: f64| {
        let run = Shaken.simulate::<Midpoint>(0.1).start(start()).noise(Wiener::seed(9)).until(end);
        run.record_at([0.05, 0.31, 0.33, 0.4]).section(|state| state.p[0] + 0.2)
    };
    let whole = run(3.0).run().unwrap();
    for stop in [5, 17, 30] {
        let to = || Checkpoint::to(folder.join(format!("{stop}"))).every_steps(4);
        run(0.1 * f64::from(stop)).checkpoint(to()).run().unwrap();
        assert_eq!(run(3.0).checkpoint(to()).run().unwrap(), whole, "{stop}");
    }
}

/// A run that ends inside a step has no node to go on from.
#[test]
fn an_exact_end_is_an_end() {
    let folder = folder!("exact");
    let run = |end: f64| {
        let run = Shaken.simulate::<Midpoint>(0.1).start(start()).noise(Wiener::seed(9)).until(end).exactly();
        run.checkpoint(Checkpoint::to(folder.join("run")).every_steps(1)).run()
    };
    let first = run(1.05).unwrap();
    assert_eq!(run(1.05).unwrap(), first);
    let Err(wzvi::Error::Checkpoint(error)) = run(2.0) else { panic!("another end") };
    assert!(
        matches!(error, CheckpointError::OtherRun { .. }) && error.to_string().contains("exact end"),
        "{error}"
    );
}
