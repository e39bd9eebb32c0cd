//! A process that is killed at random moments, many times over, and started again.

use std::path::Path;
use std::time::Duration;

use wzvi::checkpoint::Checkpoint;
use wzvi::prelude::*;

use fixtures::edge::{EDGE, bits};
use fixtures::files::{contents, killed_until_done};
use fixtures::folder;

/// What the child is to run, and where.
const ORDERS: &str = "WZVI_TEST_ENSEMBLE_CHECKPOINT";
/// So many that there is something to kill.
const PATHS: u64 = 5000;

fn run(file: Option<&Path>) -> String {
    let run = EDGE.summed::<DeltaPlus>().paths(PATHS);
    let run = match file {
        // Much of a child's time goes into its checkpoints, so that some of the kills meet one.
        Some(file) => run.checkpoint(Checkpoint::to(file).every_paths(2000).every(Duration::from_millis(30))),
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
