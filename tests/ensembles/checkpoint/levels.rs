//! A multilevel run that goes on from its checkpoint is the one that never stopped.

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use wzvi::checkpoint::{Checkpoint, CheckpointError};
use wzvi::ensemble::{Multilevel, MultilevelEstimate, Observed};
use wzvi::prelude::*;

use fixtures::files::{differences, killed_until_done, refused};
use fixtures::folder;

/// What the child is to run, and where.
const ORDERS: &str = "WZVI_TEST_LEVELS_CHECKPOINT";

/// A driven oscillator; all its paths have values.
#[hamiltonian(drift = |q, p| 0.5 * (p * p + a * q * q), noise = [|q, p| -sigma * q], embedding = [DeltaPlus])]
struct Driven {
    a: f64,
    sigma: f64,
}

const DRIVEN: Driven = Driven { a: 1.5, sigma: 0.5 };

fn asked(target: f64) -> Multilevel<'static, Driven, DeltaPlus, Observed> {
    let run = DRIVEN.multilevel::<DeltaPlus>(0.25).start(State::new([1.0], [0.5])).seed(5).until(2.0);
    run.observe("energy", |state| state.p[0].powi(2) + state.q[0].powi(2)).target(target).threads(2)
}

fn bits(estimate: &MultilevelEstimate) -> String {
    format!("{estimate:?}")
}

fn run(file: &Path) -> MultilevelEstimate {
    // Much of the time goes into checkpoints, so that some of the kills meet one.
    let often = Checkpoint::to(file).every_paths(512).every(Duration::from_millis(10));
    asked(0.01).checkpoint(often).run().unwrap()
}

#[test]
#[ignore = "the process that the next test kills"]
fn child() {
    if let Ok(file) = std::env::var(ORDERS) {
        run(Path::new(&file));
    }
}

#[test]
fn survives() {
    let folder = folder!("killed-levels");
    let file = folder.join("run");
    killed_until_done("checkpoint::levels::child", (ORDERS, file.display().to_string()), &folder);
    assert_eq!(bits(&run(&file)), bits(&asked(0.01).run().unwrap()));
}

/// Stopped after so many questions whether to stop, at any place of any level, and continued by the next run, which is stopped later.
#[test]
fn stops_anywhere() {
    let whole = asked(0.01).run().unwrap();
    assert!(whole.met_target() && whole.levels().len() > 3, "{whole}");
    let file = folder!("stopped-levels").join("run");
    let mut costs = Vec::new();
    let last = loop {
        let asked_for = AtomicU64::new(0);
        let stop = move || asked_for.fetch_add(1, Ordering::Relaxed) > 300;
        let found = asked(0.01).stop_when(stop).checkpoint(Checkpoint::to(&file)).run().unwrap();
        if !found.is_partial() {
            break found;
        }
        costs.push(found.cost());
    };
    assert!(costs.len() > 5 && costs.is_sorted(), "{costs:?}");
    assert_eq!(bits(&last), bits(&whole));
    // Finished: nothing is left to do.
    let never = asked(0.01).checkpoint(Checkpoint::to(&file)).run().unwrap();
    assert_eq!(bits(&never), bits(&whole));
}

#[test]
fn another_run_is_refused() {
    let file = folder!("other-levels").join("run");
    asked(0.05).checkpoint(Checkpoint::to(&file)).run().unwrap();
    let fields =
        |run: Multilevel<'_, Driven, DeltaPlus, Observed>| differences(&file, |to| run.checkpoint(to).run());
    assert_eq!(fields(asked(0.04)), ["the target"]);
    assert_eq!(fields(asked(0.05).weak_order(0.5)), ["the weak order"]);
    assert_eq!(fields(asked(0.05).finest(7)), ["the finest level"]);
    assert_eq!(fields(asked(0.05).paths(1 << 20)), ["the most paths of a level"]);
    assert_eq!(fields(asked(0.05).paths(1 << 50)), ["the most paths of an observable with one value"]);
    assert_eq!(fields(asked(0.05).seed(6)), ["noise seed"]);
    let ensemble =
        DRIVEN.ensemble::<DeltaPlus>(0.25).start(State::new([1.0], [0.5])).seed(5).paths(64).until(2.0);
    let error = refused(ensemble.checkpoint(Checkpoint::to(&file)).run());
    assert!(matches!(error, CheckpointError::Kind { kind: "a multilevel run", .. }), "{error}");
}
