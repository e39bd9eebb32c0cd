//! Runs that go on from a checkpoint are those that never stopped.

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use wzvi::checkpoint::{Checkpoint, CheckpointError};
use wzvi::ensemble::Statistics;
use wzvi::error::{ConfigError, Error};
use wzvi::prelude::*;

use fixtures::edge::{EDGE, Edge, PATHS, bits, whole};
use fixtures::files::{contents, differences, refused};
use fixtures::folder;

/// From the checkpoint after each block, which is found by stopping there: a run of so many blocks.
#[test]
fn from_every_block() {
    let expected = whole();
    for blocks in 0..=4 {
        let file = folder!(&format!("block-{blocks}")).join("run");
        if blocks > 0 {
            EDGE.kept(&file).paths(512 * blocks).run().unwrap();
        }
        assert_eq!(bits(&EDGE.kept(&file).run().unwrap()), expected, "{blocks}");
    }
}

/// A finished run that is started again runs the last part of a chunk, nothing else.
#[test]
fn what_is_done_is_not_done_again() {
    let file = folder!("again").join("run");
    let calls = AtomicU64::new(0);
    for paths in [PATHS, PATHS % 64] {
        let run = EDGE.run::<Midpoint>().first_passage("event0", |state| {
            // Once at each node of a path; at the start to tell it from others.
            calls.fetch_add(u64::from(state.t > 0.0), Ordering::Relaxed);
            1.0
        });
        run.checkpoint(Checkpoint::to(&file)).run().unwrap();
        let counted = calls.swap(0, Ordering::Relaxed);
        // Some paths fail before the end, and path 0 is asked at three nodes more.
        assert!(counted <= 24 * paths + 3 && counted > 20 * paths, "{counted} nodes of {paths} paths");
    }
}

/// The part of a chunk that was the last is no longer one.
#[test]
fn with_more_paths() {
    let file = folder!("more").join("run");
    for paths in [1, 511, 512, 513, 1500, PATHS] {
        let run = EDGE.kept(&file).paths(paths).run().unwrap();
        assert_eq!(bits(&run), bits(&EDGE.run::<DeltaPlus>().paths(paths).run().unwrap()), "{paths}");
    }
    let error = refused(EDGE.kept(&file).paths(2111).run());
    assert_eq!(error, CheckpointError::MorePaths { path: file.clone(), done: 2112, paths: 2111 });
    assert!(error.to_string().contains("ask for at least 2112"), "{error}");
    assert!(EDGE.kept(&file).paths(2112).run().is_ok());
}

/// The same where each path has its own start, however few paths there were: of a function, and of a list
/// that has more states than paths.
#[test]
fn with_more_paths_from_starts_of_their_own() {
    let folder = folder!("more-starts");
    let base = || EDGE.ensemble::<DeltaPlus>(0.05).seed(7).steps(24).allow_losses(1.0).keep_paths(1 << 20);
    let drawn =
        |shift: f64| base().starts(move |draw| State::new([1.0 + 0.1 * draw.normal() + shift], [0.5]));
    let list = |shift: f64| (0..800).map(move |i| State::new([1.0 + shift + 1e-3 * f64::from(i)], [0.5]));
    let listed = |shift: f64| base().starts_from(list(shift));
    let to = |name: &str| Checkpoint::to(folder.join(name));
    for paths in [3, 64, 65, 300, 512, 513, 800, 640] {
        let run = drawn(0.0).paths(paths).checkpoint(to("drawn")).run();
        if paths == 640 {
            // More paths are done.
            assert!(matches!(refused(run), CheckpointError::MorePaths { done: 768, paths: 640, .. }));
            continue;
        }
        assert_eq!(bits(&run.unwrap()), bits(&drawn(0.0).paths(paths).run().unwrap()), "{paths}");
        let run = listed(0.0).paths(paths).checkpoint(to("listed")).run().unwrap();
        assert_eq!(bits(&run), bits(&listed(0.0).paths(paths).run().unwrap()), "{paths}");
    }
    // Other starts are another run, from the first path on or from a later one.
    let later = base()
        .starts(|draw| State::new([1.0 + 0.1 * draw.normal()], [if draw.path() == 37 { 0.6 } else { 0.5 }]));
    for (run, path) in [(drawn(1e-15), "q[0] of the start"), (later, "the start of path 37 (checksum)")] {
        let found = differences(&folder.join("drawn"), |to| run.paths(900).checkpoint(to).run());
        assert_eq!(found[0], path);
    }
    let found = differences(&folder.join("listed"), |to| listed(1e-15).paths(800).checkpoint(to).run());
    assert_eq!(found[0], "the states where paths start (checksum)");
    let found = differences(&folder.join("listed"), |to| drawn(0.0).paths(800).checkpoint(to).run());
    assert!(found.contains(&"the states where paths start".to_owned()), "{found:?}");
}

/// A run until an error is small enough ends where one ends that was never stopped, also if that is at the checkpoint.
#[test]
fn until_an_error_is_small_enough() {
    let file = folder!("target").join("run");
    let run = |target| EDGE.summed::<DeltaPlus>().paths(1 << 20).until_error("q", target);
    let mut ends = Vec::new();
    for target in [1e-2, 6e-3, 4e-3] {
        let kept = || run(target).checkpoint(Checkpoint::to(&file)).run().unwrap();
        let expected = run(target).run().unwrap();
        assert_eq!(expected.met_targets(), Some(true));
        assert_eq!(bits(&kept()), bits(&expected), "{target}");
        assert_eq!(bits(&kept()), bits(&expected), "{target}, again");
        ends.push(expected.last().unwrap().count());
    }
    assert!(ends[0] < ends[1] && ends[1] < ends[2], "{ends:?}");
}

/// A run that is stopped keeps all blocks that it has finished.
#[test]
fn a_run_that_was_stopped() {
    let file = folder!("stopped-run").join("run");
    let calls = AtomicU64::new(0);
    let run = || {
        let run = EDGE.ensemble::<DeltaPlus>(0.05).start(State::new([1.0], [0.5])).seed(7).steps(24);
        run.paths(20 * 512 + 100).antithetic().quantiles().threads(1).allow_losses(1.0)
    };
    let stopped = run().stop_when(|| calls.fetch_add(1, Ordering::Relaxed) > 40);
    let part = stopped.checkpoint(Checkpoint::to(&file)).run().unwrap();
    let done = part.last().unwrap().count() + part.failed();
    assert!(part.is_partial() && done % 64 == 0 && done > 0 && done < 20 * 512, "{done}");
    let whole = run().checkpoint(Checkpoint::to(&file)).run().unwrap();
    assert_eq!(bits(&whole), bits(&run().run().unwrap()));
}

/// Threads, lanes and instructions are no part of what a run is.
#[test]
fn on_other_threads() {
    let file = folder!("threads").join("run");
    EDGE.kept(&file).paths(1024).threads(3).run().unwrap();
    let run = EDGE.kept(&file).threads(1).instructions(wzvi::ensemble::InstructionSet::Baseline);
    assert_eq!(bits(&run.run_in::<1>().unwrap()), whole());
}

#[test]
fn a_system_without_failures_and_with_the_standard_observables() {
    let file = folder!("standard").join("run");
    let run =
        |paths| EDGE.ensemble::<Midpoint>(0.01).start(State::new([2.0], [0.0])).paths(paths).seed(1).steps(3);
    run(1000).checkpoint(Checkpoint::to(&file)).run().unwrap();
    let on = run(3000).checkpoint(Checkpoint::to(&file)).run().unwrap();
    assert_eq!(on, run(3000).run().unwrap());
}

/// All paths fail: so does the run, each time.
#[test]
fn a_run_without_a_path_that_arrives() {
    let file = folder!("failing").join("run");
    let run = || {
        let start = State::new([-1.0], [0.0]);
        EDGE.ensemble::<DeltaPlus>(0.1)
            .start(start)
            .paths(1100)
            .seed(1)
            .steps(3)
            .checkpoint(Checkpoint::to(&file))
    };
    let first = run().run();
    assert!(matches!(first, Err(Error::Step(_))), "{first:?}");
    assert_eq!(run().run(), first);
}

#[test]
fn settings_that_make_no_sense() {
    let folder = folder!("settings");
    let to = || Checkpoint::to(folder.join("run"));
    let settings = [
        (to().every_paths(0), "at least 1"),
        (to().every_paths(9).every(std::time::Duration::ZERO), "no time at all"),
    ];
    for (checkpoint, cause) in settings {
        let error = EDGE.run::<DeltaPlus>().checkpoint(checkpoint).run().unwrap_err();
        assert!(
            matches!(&error, Error::Config(ConfigError::Setting(text)) if text.contains(cause)),
            "{error}"
        );
    }
    assert!(contents(&folder).is_empty());
}

/// Ways to lose the file of a run.
type Loss = fn(&Path);

fn take(file: &Path) {
    fs::write(file, "another").unwrap();
}

fn remove(file: &Path) {
    fs::remove_file(file).unwrap();
}

fn remove_folder(file: &Path) {
    fs::remove_dir_all(file.parent().unwrap()).unwrap();
}

fn put_folder(file: &Path) {
    remove(file);
    fs::create_dir(file).unwrap();
}

/// Whatever happens to the file, the run goes on with its statistics, says at its end what it could not save, and leaves the file of another alone.
#[test]
fn a_checkpoint_that_is_lost_does_not_end_the_run() {
    let edge = Edge { a: 1.0, sigma: 0.1 };
    let run = |lose: &(dyn Fn(u64) + Sync), file: Option<&Path>| {
        let calls = AtomicU64::new(0);
        let ensemble = edge.ensemble::<DeltaPlus>(0.05).start(State::new([1.0], [0.5])).paths(8 * 512);
        let ensemble = ensemble.seed(7).steps(2).threads(1).observe("q", |state| {
            // Two nodes for each of 512 paths are a block.
            lose(calls.fetch_add(1, Ordering::Relaxed));
            state.q[0]
        });
        match file {
            Some(file) => ensemble.checkpoint(Checkpoint::to(file).every_paths(1)).run(),
            None => ensemble.run(),
        }
        .unwrap()
    };
    // All but what could not be saved.
    let found = |statistics: &Statistics| format!("{:?}", statistics.tables());
    let whole = found(&run(&|_| {}, None));
    let losses: [(&str, Loss, Option<&str>); 4] = [
        ("taken", take, Some("was changed during the run")),
        ("removed", remove, None),
        ("folder", remove_folder, Some("cannot write")),
        ("special", put_folder, Some("cannot")),
    ];
    for (name, lose, unsaved) in losses {
        let file = folder!(name).join("inner").join("run");
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        let statistics = run(
            &|call| {
                if call == 5000 {
                    lose(&file)
                }
            },
            Some(&file),
        );
        assert_eq!(found(&statistics), whole, "{name}");
        let said = statistics.unsaved().map(ToString::to_string);
        match (&said, unsaved) {
            (Some(said), Some(unsaved)) => assert!(said.contains(unsaved), "{name}: {said}"),
            (None, None) => assert!(fs::read(&file).is_ok_and(|bytes| bytes.starts_with(b"wzvi-ensemble"))),
            _ => panic!("{name}: {said:?}"),
        }
        assert_eq!(name == "taken", fs::read(&file).is_ok_and(|bytes| bytes == b"another"), "{name}");
    }
}
