//! On any number of ranks, the bits of one process.

use super::ranks::{Plan, STALL, TARGET, on_ranks, run, run_with_paths, saved, took};
use fixtures::edge::bits;
use fixtures::folder;

/// Many blocks and a part of one.
const PATHS: u64 = 300 * 512 + 17;

#[test]
fn of_one_process() {
    let folder = folder!("cluster-bits");
    let expected = bits(&run_with_paths(PATHS).run().unwrap());
    for (ranks, plan) in [(1, Plan::Plain), (2, Plan::Plain), (4, Plan::Plain), (2, Plan::Threads)] {
        assert!(on_ranks(ranks, plan, PATHS, &folder).well() == expected, "{plan:?} on {ranks} ranks");
    }
}

/// More ranks than blocks: most have nothing to do.
#[test]
fn of_a_single_block() {
    let folder = folder!("cluster-few");
    for paths in [1, 513] {
        let outcome = run_with_paths(paths).run();
        let expected = outcome.map_or_else(|error| error.to_string(), |statistics| bits(&statistics));
        assert_eq!(on_ranks(4, Plan::Plain, paths, &folder).well(), expected);
    }
}

/// A checkpoint that ranks wrote is that of one process, and the other way round.
#[test]
fn of_a_checkpoint() {
    let folder = folder!("cluster-checkpoint");
    let file = folder.join("checkpoint");
    let kept = |paths| run(paths).checkpoint(wzvi::checkpoint::Checkpoint::to(&file));
    let expected = |paths| bits(&run(paths).run().unwrap());
    on_ranks(2, Plan::Kept, 20 * 512, &folder).well();
    assert_eq!(saved(&file), 20 * 512);
    assert_eq!(bits(&kept(40 * 512).run().unwrap()), expected(40 * 512));
    assert_eq!(on_ranks(4, Plan::Kept, 60 * 512 + 1, &folder).well(), expected(60 * 512 + 1));
}

/// Where the error is small enough does not depend on who is how far.
#[test]
fn until_an_error_is_small_enough() {
    let folder = folder!("cluster-target");
    let paths = 1 << 20;
    let expected = run(paths).until_error("q", TARGET).run().unwrap();
    let count = expected.last().unwrap().count();
    assert!(expected.met_targets() == Some(true) && count > 20_000 && count < paths / 2, "{count}");
    assert!(on_ranks(3, Plan::Target, paths, &folder).well() == bits(&expected));
}

/// A rank that sleeps holds up nobody: others do its blocks, and the statistics are those of one process.
#[test]
fn of_a_run_in_which_a_rank_stalls() {
    let folder = folder!("cluster-stalls");
    // Some seconds for rank 0 without optimisation: the other is still asleep at the end.
    let paths = 200 * 512;
    let ended = on_ranks(2, Plan::Stalls, paths, &folder);
    let error = String::from_utf8_lossy(&ended.output.stderr).into_owned();
    assert!(
        error.contains("rank 1 of 2 has not answered for") && error.contains("ends without it"),
        "{error}"
    );
    assert!(took(&folder, 0) < STALL, "rank 0 returned after {:?}", took(&folder, 0));
    assert!(took(&folder, 1) >= STALL);
    let event = |_: &_| 1.0;
    assert!(ended.well() == bits(&run(paths).first_passage("event0", event).run().unwrap()));
}

/// It does not hold up whoever stops the run either.
#[test]
fn of_a_run_that_is_stopped_while_a_rank_stalls() {
    let folder = folder!("cluster-stalls-stops");
    let ended = on_ranks(2, Plan::StallsAndStops, 100_000 * 512, &folder);
    // Stopped after two seconds, and waited one more for those that are about to answer.
    assert!(took(&folder, 0) < STALL / 2, "rank 0 returned after {:?}", took(&folder, 0));
    assert!(ended.well().contains("is_partial: true"));
}

/// What is done when one rank stops is that of the first paths, and a restart goes on from there.
#[test]
fn of_a_run_that_was_stopped() {
    let folder = folder!("cluster-stops");
    let paths = 1000 * 512;
    let part = on_ranks(2, Plan::Stops, paths, &folder).well();
    let done = saved(&folder.join("checkpoint"));
    assert!((10 * 512..1000 * 512).contains(&done), "{done}");
    let partial = format!("{:?}", run(done).run().unwrap())
        .replace("is_partial: false", "is_partial: true")
        .replace(&format!("paths: {done}, "), &format!("paths: {paths}, "));
    assert!(part == partial);
    assert!(on_ranks(2, Plan::Kept, paths, &folder).well() == bits(&run(paths).run().unwrap()));
}
