//! Errors of averages that single paths dominate, and of rates.

use fixtures::walkers;
use wzvi::ensemble::TargetStatus;
use wzvi::prelude::*;

#[test]
fn an_error_that_one_path_dominates_meets_no_target() {
    let (mut met, mut dominated, mean) = (0, 0, 4.5_f64.exp());
    for seed in 0..40 {
        let run = walkers!(1.0, seed).paths(1 << 14).observe("x", |state| (3.0 * state.p[0]).exp());
        let run = run.until_error("x", 0.3 * mean).run().expect("an ensemble");
        let end = run.nodes().last().expect("the end");
        let is_small = end.error_bound(0) <= 0.3 * mean;
        match run.target("x").expect("a target") {
            TargetStatus::Met => {
                assert!(is_small && end.largest_share(0) <= 0.1);
                met += 1;
            }
            TargetStatus::Dominated => {
                assert!(is_small && end.largest_share(0) > 0.1);
                dominated += 1;
            }
            _ => assert!(!is_small),
        }
    }
    println!("met {met}, dominated {dominated}");
    assert!(dominated > met, "{met} {dominated}");
    // No path has a share in the variance of a normal.
    let run = walkers!(1.0, 1).paths(1 << 14).observe("p", |state| state.p[0]).until_error("p", 0.02).run();
    let run = run.expect("an ensemble");
    assert_eq!(run.target("p").expect("a target"), TargetStatus::Met);
}

#[test]
fn the_error_of_a_rate_covers_any_law_of_the_times() {
    // The hazard of a Wiener process at a distance rises from nothing.
    let run = |paths, seed| {
        let run = walkers!(0.05, seed).paths(paths).first_passage("one", |state| state.p[0] - 1.0);
        let statistics = run.run().expect("an ensemble");
        let passages = statistics.passage("one").expect("an event");
        (passages.rate(), passages.rate_error())
    };
    // A twentieth of the error of a run below, which is 10 %.
    let (truth, error) = run(200_000, 1 << 20);
    assert!(error < 0.005 * truth, "{truth} {error}");
    let runs = 600;
    let covered = (0..runs).filter(|&seed| {
        let (rate, error) = run(384, seed);
        (rate - truth).abs() <= 1.96 * error
    });
    let fraction = covered.count() as f64 / runs as f64;
    println!("{fraction}");
    // 95 % and two deviations of 0.9 %: `rate / √passed` covers 87 %.
    assert!((0.932..0.968).contains(&fraction), "{fraction}");
}
