//! Processes that are killed at random moments, many times over, and started again.

use std::path::Path;
use std::time::Duration;

use wzvi::checkpoint::Checkpoint;
use wzvi::prelude::*;

use super::systems::{DoublePendulum, KEPLER, PENDULUM, bits};
use fixtures::files::{contents, killed_until_done};
use fixtures::folder;

/// So many that there is something to kill.
const STEPS: u64 = 40_000;
/// What the child is to run, and where.
const ORDERS: &str = "WZVI_TEST_CHECKPOINT";

/// The runs that are killed, with a checkpoint every `often` steps: a trajectory as bits.
fn run(name: &str, file: Option<&Path>, steps: u64) -> Vec<u64> {
    // Half of a child's time goes into its checkpoints, so that many of the kills meet one.
    let to = |file: &Path| Checkpoint::to(file).every_steps(331).every(Duration::from_millis(1));
    macro_rules! bits_of {
        ($run:expr) => {
            match file {
                Some(file) => bits(&$run.checkpoint(to(file)).run().unwrap()),
                None => bits(&$run.run().unwrap()),
            }
        };
    }
    match name {
        "kepler" => bits_of!(KEPLER.run(steps, 0)),
        "double" => bits_of!(DoublePendulum.run(steps, 7)),
        "wiener" => bits_of!(PENDULUM.run(Wiener::seed(3), steps, 5)),
        "averaged" => bits_of!(PENDULUM.run(WongZakai::averaged(0.05).seed(3).exact(), steps, 0)),
        other => panic!("no run {other}"),
    }
}

#[test]
#[ignore = "the process that the next test kills"]
fn child() {
    let Ok(orders) = std::env::var(ORDERS) else { return };
    let [name, steps, file] = orders.splitn(3, ' ').collect::<Vec<_>>()[..] else { panic!("{orders}") };
    run(name, Some(Path::new(file)), steps.parse().unwrap());
}

fn survives(name: &str, steps: u64) {
    let folder = folder!(&format!("killed-{name}"));
    let file = folder.join("run");
    let order = format!("{name} {steps} {}", file.display());
    killed_until_done("checkpoint::killed::child", (ORDERS, order), &folder);
    // The child has finished: this reads what it left.
    assert_eq!(run(name, Some(&file), steps), run(name, None, steps), "{name}");
    assert!(!contents(&folder).iter().any(|(path, _)| path.extension() == Some("part".as_ref())));
}

#[test]
fn newton_with_memory() {
    survives("kepler", STEPS);
}

#[test]
fn compensated_sums_with_recorded_nodes() {
    survives("double", STEPS / 4);
}

#[test]
fn wiener_increments_with_recorded_nodes() {
    survives("wiener", STEPS / 4);
}

#[test]
fn averaged_increments() {
    survives("averaged", STEPS / 4);
}
