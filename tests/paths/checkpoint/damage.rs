//! Files that are not what was written: every one is told apart, and left as it is.

use std::fs;
use std::path::Path;

use wzvi::checkpoint::{Checkpoint, CheckpointError};
use wzvi::prelude::*;

use super::systems::{KEPLER, PENDULUM, bits};
use fixtures::files::{self, contents, refused};
use fixtures::folder;

/// A run with recorded nodes, to be gone on with: they are in the file.
fn go_on(file: &Path, steps: u64) -> Result<Vec<u64>, wzvi::Error> {
    Ok(bits(&PENDULUM.run(Wiener::seed(7), steps, 4).checkpoint(Checkpoint::to(file)).run()?))
}

fn error_of(file: &Path, good: &[u8], changed: &[u8]) -> CheckpointError {
    files::error_of(file, good, changed, || go_on(&file.with_extension(""), 40))
}

#[test]
fn a_file_that_was_cut_or_flipped() {
    let run = folder!("damage").join("run");
    go_on(&run, 30).unwrap();
    files::every_damage_is_told(&run, 3, &|| go_on(&run, 40).map(drop));
    assert_eq!(go_on(&run, 40).unwrap(), whole());
}

fn whole() -> Vec<u64> {
    bits(&PENDULUM.run(Wiener::seed(7), 40, 4).run().unwrap())
}

#[test]
fn files_of_others() {
    let run = folder!("foreign").join("run");
    for content in ["{\"a\": 1}", "wzvi", "wzvi-checkpoints 1", "#!/bin/sh\n", "\0\0\0\0"] {
        fs::write(&run, content).unwrap();
        let error = refused(go_on(&run, 10));
        let is_cut = content == "wzvi";
        assert_eq!(matches!(error, CheckpointError::Damaged { .. }), is_cut, "{content}: {error:?}");
        assert_eq!(matches!(error, CheckpointError::Foreign { .. }), !is_cut, "{content}: {error:?}");
        assert_eq!(fs::read_to_string(&run).unwrap(), content);
    }
    let error = refused(go_on(&run, 10)).to_string();
    assert!(error.contains("not a file of wzvi") && error.contains("not changed"), "{error}");
}

#[test]
fn files_of_another_version() {
    let run = folder!("version").join("run");
    go_on(&run, 30).unwrap();
    let good = fs::read(&run).unwrap();
    let content = good.strip_prefix(b"wzvi-checkpoint 5 ").unwrap();
    // The last is what a version before wrote.
    let json = b"2 0123456789abcdef\n{}\n";
    for (version, rest) in [("0", content), ("1", content), ("4", content), ("10", content), ("3", json)] {
        let other = [format!("wzvi-checkpoint {version} ").as_bytes(), rest].concat();
        let error = error_of(&run, &good, &other);
        let found = version.to_owned();
        assert_eq!(error, CheckpointError::Version { path: run.clone(), found, expected: 5 });
        assert!(error.to_string().contains(&format!("version {version} of the format")), "{error}");
    }
}

/// What the temporary names of a file `run` start with.
const PREFIX: &str = ".wzvi-9b96d050f4020292-";

/// What a run that was stopped in the middle of a write leaves behind is no obstacle, and is cleared away.
#[test]
fn whatever_a_stopped_write_left() {
    let folder = folder!("stopped");
    let run = folder.join("run");
    go_on(&run, 30).unwrap();
    let good = fs::read(&run).unwrap();
    for length in (0..=good.len()).step_by(97) {
        let left = folder.join(format!("{PREFIX}{length:016x}.part"));
        fs::write(left, &good[..length]).unwrap();
        fs::write(folder.join("run.mine.part"), "mine").unwrap();
        fs::write(folder.join(format!("{PREFIX}0000.part")), "mine").unwrap();
        fs::write(&run, &good).unwrap();
        assert_eq!(go_on(&run, 40).unwrap(), whole());
        let names: Vec<_> = contents(&folder).into_iter().map(|(path, _)| path).collect();
        let mine = format!("{PREFIX}0000.part");
        assert_eq!(names, [&mine, "run", "run.mine.part"].map(|name| folder.join(name)));
    }
}

/// A link stays, and leads to the checkpoint, which by its own name is the same run.
#[cfg(unix)]
#[test]
fn links() {
    let folder = folder!("links");
    fs::create_dir(folder.join("far")).unwrap();
    let (link, real) = (folder.join("link"), folder.join("far").join("run"));
    std::os::unix::fs::symlink("far/run", &link).unwrap();
    go_on(&link, 20).unwrap();
    go_on(&real, 30).unwrap();
    assert_eq!(go_on(&link, 40).unwrap(), whole());
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(contents(&folder).len(), 2);
}

#[test]
fn folders_that_cannot_be_written_to() {
    let folder = folder!("folders");
    fs::write(folder.join("file"), "").unwrap();
    for path in [folder.join("missing/run"), folder.join("file/run"), folder.clone(), "/dev/null".into()] {
        // Before the first step.
        let steps = std::cell::Cell::new(0);
        let run = KEPLER.run(10, 0).checkpoint(Checkpoint::to(&path));
        let error = refused(run.inspect(|_, _| steps.set(steps.get() + 1)).run());
        assert!(matches!(&error, CheckpointError::File { .. }), "{error:?}");
        assert!(error.to_string().contains(path.to_str().unwrap()), "{error}");
        assert_eq!(steps.get(), 0);
    }
    assert_eq!(contents(&folder).len(), 1);
}

/// Where the process below writes.
const FULL: &str = "WZVI_TEST_FULL_DISK";

/// Files that grow beyond a limit are to it what a full disk is: some of the checkpoints fit.
#[test]
#[ignore = "the process that the next test runs with small files"]
fn child_on_a_full_disk() {
    let Ok(file) = std::env::var(FULL) else { return };
    let run = |checkpoint| KEPLER.run(2000, 1).checkpoint(checkpoint).run().unwrap();
    let path = run(Checkpoint::to(file).every_steps(100));
    assert!(matches!(path.unsaved(), Some(error) if error.path().ends_with("run")), "{:?}", path.unsaved());
    assert_eq!(bits(&path), bits(&KEPLER.run(2000, 1).run().unwrap()));
}

/// The run goes on, says so once, and goes on from what was written when there is room again.
#[cfg(unix)]
#[test]
fn a_full_disk_does_not_end_the_run() {
    let file = folder!("full").join("run");
    let test = std::env::current_exe().unwrap();
    // 64 blocks of 512 or 1024 bytes. Writing more would be a signal to end the process.
    let limits = "trap '' XFSZ; ulimit -f 64; exec \"$0\" \"$@\"";
    let child = std::process::Command::new("sh")
        .args(["-c", limits, test.to_str().unwrap()])
        .args(["checkpoint::damage::child_on_a_full_disk", "--exact", "--ignored", "--nocapture"])
        .env(FULL, &file)
        .output()
        .unwrap();
    let (said, warned) = (String::from_utf8_lossy(&child.stdout), String::from_utf8_lossy(&child.stderr));
    assert!(child.status.success() && said.contains("1 passed"), "{said}{warned}");
    assert_eq!(warned.matches("the run goes on without this checkpoint").count(), 1, "{warned}");
    let seen = std::cell::Cell::new(0);
    let path = KEPLER
        .run(2000, 1)
        .checkpoint(Checkpoint::to(&file))
        .inspect(|_, _| seen.set(seen.get() + 1))
        .run()
        .unwrap();
    assert_eq!(bits(&path), bits(&KEPLER.run(2000, 1).run().unwrap()));
    assert!(path.unsaved().is_none() && seen.get() < 1900, "{seen:?}");
}
