//! A process that is killed at random moments, many times over, and started again. That all kinds of runs go on, whatever they remember, is in `resume`.

use std::path::Path;
use std::time::Duration;

use wzvi::checkpoint::Checkpoint;
use wzvi::prelude::*;

use super::systems::{PENDULUM, bits};
use fixtures::files::{contents, killed_until_done};
use fixtures::folder;

/// Where the child is to write.
const ORDERS: &str = "WZVI_TEST_CHECKPOINT";

/// A trajectory as bits.
fn run(file: Option<&Path>) -> Vec<u64> {
    // So many steps that there is something to kill.
    let run = PENDULUM.run(Wiener::seed(3), 10_000, 5);
    let run = match file {
        // Half of a child's time goes into its checkpoints, so that many of the kills meet one.
        Some(file) => run.checkpoint(Checkpoint::to(file).every_steps(331).every(Duration::from_millis(1))),
        None => run,
    };
    bits(&run.run().unwrap())
}

#[test]
#[ignore = "the process that the next test kills"]
fn child() {
    if let Ok(file) = std::env::var(ORDERS) {
        run(Some(Path::new(&file)));
    }
}

#[test]
fn survives() {
    let folder = folder!("killed");
    let file = folder.join("run");
    killed_until_done("checkpoint::killed::child", (ORDERS, file.display().to_string()), &folder);
    // The child has finished: this reads what it left.
    assert_eq!(run(Some(&file)), run(None));
    assert!(!contents(&folder).iter().any(|(path, _)| path.extension() == Some("part".as_ref())));
}
