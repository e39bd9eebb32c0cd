//! Files that are not what was written: every one is told apart, and left as it is.

use std::fs;
use std::path::Path;

use wzvi::checkpoint::{Checkpoint, CheckpointError};
use wzvi::prelude::*;

use fixtures::edge::{EDGE, bits};
use fixtures::files::{error_of, every_damage_is_told, refused};
use fixtures::folder;

fn go_on(file: &Path) -> Result<wzvi::ensemble::Statistics, wzvi::Error> {
    let start = State::new([1.0], [0.5]);
    let run = EDGE.ensemble::<DeltaPlus>(0.05).start(start).paths(600).seed(7).steps(4).threads(1);
    run.checkpoint(Checkpoint::to(file)).run()
}

#[test]
fn a_file_that_was_cut_or_flipped() {
    let file = folder!("damage").join("run");
    let expected = bits(&go_on(&file).unwrap());
    every_damage_is_told(&file, 97, &|| go_on(&file).map(drop));
    assert_eq!(bits(&go_on(&file).unwrap()), expected);
}

#[test]
fn files_of_others() {
    let folder = folder!("foreign");
    let file = folder.join("run");
    fs::write(&file, "wzvi-ensembles 1").unwrap();
    assert_eq!(refused(go_on(&file)), CheckpointError::Foreign { path: file.clone() });
    fs::remove_file(&file).unwrap();
    // A checkpoint, but not of an ensemble; and the other way round.
    let path =
        || EDGE.simulate::<DeltaPlus>(0.1).start(State::new([1.0], [0.0])).noise(Wiener::seed(1)).steps(3);
    path().checkpoint(Checkpoint::to(&file)).run().unwrap();
    let error = refused(go_on(&file));
    assert_eq!(error, CheckpointError::Kind { path: file.clone(), kind: "a single path" });
    assert!(error.to_string().contains("a checkpoint of a single path"), "{error}");
    fs::remove_file(&file).unwrap();
    go_on(&file).unwrap();
    let error = path().checkpoint(Checkpoint::to(&file)).run().map(|_| ()).unwrap_err();
    assert_eq!(error, CheckpointError::Kind { path: file.clone(), kind: "an ensemble" }.into());

    let good = fs::read(&file).unwrap();
    let other = [b"wzvi-ensemble 4 ", good.strip_prefix(b"wzvi-ensemble 5 ").unwrap()].concat();
    let version = CheckpointError::Version { path: file.clone(), found: "4".into(), expected: 5 };
    assert_eq!(error_of(&file, &good, &other, || go_on(&file)), version);
}
