//! Where one rank fails, all end, and say why.

use std::fs;

use wzvi::checkpoint::Checkpoint;

use super::ranks::{Plan, on_ranks, run, saved};
use fixtures::edge::bits;
use fixtures::folder;

/// So many that few are begun when the checkpoint has its first blocks.
const PATHS: u64 = 1000 * 512 + 17;

/// What is done is in the checkpoint, and a restart goes on from there, on ranks and without.
#[test]
fn a_rank_that_dies() {
    let folder = folder!("cluster-dies");
    let (file, copy) = (folder.join("checkpoint"), folder.join("copy"));
    let ended = on_ranks(2, Plan::Dies, PATHS, &folder);
    let error = ended.badly();
    assert!(error.contains("rank 1") && error.contains("signal"), "{error}");
    assert_eq!(ended.said, [None, None]);
    let done = saved(&file);
    assert!((10 * 512..PATHS).contains(&done), "{done}");
    fs::copy(&file, &copy).unwrap();

    let event = |_: &_| 1.0;
    let expected = bits(&run(PATHS).first_passage("event0", event).run().unwrap());
    let on = run(PATHS).first_passage("event0", event).checkpoint(Checkpoint::to(&copy)).run().unwrap();
    assert!(bits(&on) == expected);
    assert!(on_ranks(4, Plan::Survives, PATHS, &folder).well() == expected);
    assert_eq!(saved(&file), PATHS / 64 * 64);
}

#[test]
fn a_rank_that_panics() {
    let folder = folder!("cluster-panics");
    for (plan, rank) in [(Plan::Panics, 1), (Plan::RootPanics, 0)] {
        let ended = on_ranks(2, plan, PATHS, &folder);
        let error = ended.badly();
        assert!(error.contains("an observable that fails"), "{error}");
        let told = format!("wzvi: rank {rank} of 2 ends the run on all ranks: it panicked");
        assert!(error.contains(&told), "{error}");
        assert_eq!(ended.said, [None, None]);
    }
}

/// Errors are values on every rank; the processes live on.
#[test]
fn ranks_that_cannot_run() {
    let folder = folder!("cluster-refused");
    let said = |plan, ranks| {
        let ended = on_ranks(ranks, plan, PATHS, &folder);
        assert!(ended.output.status.success());
        ended.said.into_iter().map(Option::unwrap).collect::<Vec<_>>()
    };
    let other = said(Plan::OtherSeed, 3);
    assert!(
        other[2]
            .contains("rank 2 has settings other than those of rank 0 (noise seed: 8; there noise seed: 7)"),
        "{other:?}"
    );
    assert!(
        other[..2].iter().all(|text| text.contains("rank 2 ended the run: rank 2 has settings")),
        "{other:?}"
    );

    let mistaken = said(Plan::Mistaken, 2);
    assert!(mistaken[1].starts_with("0 paths: take at least 1"), "{mistaken:?}");
    assert!(mistaken[0].contains("rank 1 ended the run: 0 paths: take at least 1"), "{mistaken:?}");

    let unwritable = said(Plan::Unwritable, 2);
    assert!(unwritable[0].starts_with("cannot write"), "{unwritable:?}");
    assert!(unwritable[1].contains("rank 0 ended the run: cannot write"), "{unwritable:?}");

    // A checkpoint that another run takes ends nothing.
    let expected = bits(&run(PATHS).first_passage("event0", |_| 1.0).run().unwrap());
    let found = on_ranks(2, Plan::Taken, PATHS, &folder).well();
    assert!(found.contains("unsaved: Some(Taken"), "{found}");
    // All but what could not be saved.
    assert!(found.split("unsaved: ").next() == expected.split("unsaved: ").next());

    let single = said(Plan::Single, 1);
    assert!(single[0].contains("Threading::Funneled"), "{single:?}");
}
