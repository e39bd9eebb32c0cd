//! Runs with sections and recorded times go on from their checkpoints.

use fixtures::folder;

use wzvi::checkpoint::Checkpoint;
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

/// A run that ended inside a step goes on from its last whole step: the path is that of a run that never stopped, to the bit, and the earlier end is
/// none of its nodes. So does one that ended at a node up to rounding, whose time there is that of the end.
#[test]
fn ends_inside_steps_go_on() {
    let folder = folder!("ends");
    for stop in [0.05, 0.3, 1.05, 1.7, 2.96] {
        let to = || Checkpoint::to(folder.join(format!("{stop}"))).every_steps(4);
        let run = |end: f64| {
            let run = Shaken.simulate::<Midpoint>(0.1).start(start()).noise(Wiener::seed(9)).until(end);
            run.section(|state| state.p[0] + 0.2).record_at([0.02, 0.05]).record_every(3)
        };
        let first = run(stop).checkpoint(to()).run().unwrap();
        assert_eq!((first.last().t, &first), (stop, &run(stop).run().unwrap()), "{stop}");
        assert_eq!(run(stop).checkpoint(to()).run().unwrap(), first, "{stop}, again");
        for end in [3.01, 3.4, 3.44] {
            let whole = run(end).run().unwrap();
            assert_eq!(run(end).checkpoint(to()).run().unwrap(), whole, "{stop} {end}");
            assert!(stop == 0.05 || stop == 0.3 || whole.times().all(|t| t != stop), "{stop}");
        }
    }
    // Averages go on, too, over whole steps.
    let run = |end: f64| {
        let run = Oscillator.simulate::<Gauss<8>>(0.1).start(start()).until(end);
        run.observe("q", |state| state.q[0] + state.t)
    };
    let to = || Checkpoint::to(folder.join("averages"));
    run(0.3).checkpoint(to()).time_averages().run().unwrap();
    run(7.77).checkpoint(to()).time_averages().run().unwrap();
    let resumed = run(20.0).checkpoint(to()).time_averages().run().unwrap();
    let whole = run(20.0).time_averages().run().unwrap();
    let of =
        |run: &wzvi::series::TimeAverages<_>| (run.averages[0].mean, run.averages[0].variance, run.steps);
    assert_eq!(of(&resumed), of(&whole));
}
