//! A process that is killed at random moments, many times over, and started again.

use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use wzvi::checkpoint::Checkpoint;
use wzvi::prelude::*;

use fixtures::edge::{EDGE, bits};
use fixtures::{files::contents, folder};

/// What the child is to run, and where.
const ORDERS: &str = "WZVI_TEST_ENSEMBLE_CHECKPOINT";
/// So many that there is something to kill.
const PATHS: u64 = 8000;

fn run(file: Option<&Path>) -> String {
    let run = EDGE.summed::<DeltaPlus>().paths(PATHS);
    let run = match file {
        // Much of a child's time goes into its checkpoints, so that some of the kills meet one.
        Some(file) => run.checkpoint(Checkpoint::to(file).every_paths(4000).every(Duration::from_millis(30))),
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
    let mut random = 0x9E37_79B9_7F4A_7C15_u64;
    let (mut kills, mut parts) = (0, 0);
    loop {
        let start = Instant::now();
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args(["checkpoint::killed::child", "--exact", "--ignored", "--quiet"])
            .env(ORDERS, &file)
            .stdout(Stdio::null())
            .stderr(Stdio::inherit())
            .spawn()
            .unwrap();
        // Xorshift; a moment of the first 16 ms, then of the first 32, ..., so that any machine is killed and gets to the end.
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        let moment = Duration::from_micros((random >> 50) * (kills + 1));
        while start.elapsed() < moment && child.try_wait().unwrap().is_none() {
            sleep(Duration::from_micros(200));
        }
        if let Some(status) = child.try_wait().unwrap() {
            assert!(status.success());
            break;
        }
        child.kill().unwrap();
        child.wait().unwrap();
        kills += 1;
        parts +=
            u32::from(contents(&folder).iter().any(|(path, _)| path.extension() == Some("part".as_ref())));
    }
    println!("{kills} kills, {parts} in the middle of a replacement");
    assert!(kills > 0, "it finished before it could be killed");
    // The child has finished: this reads what it left.
    assert_eq!(run(Some(&file)), run(None));
    assert!(!contents(&folder).iter().any(|(path, _)| path.extension() == Some("part".as_ref())));
}
