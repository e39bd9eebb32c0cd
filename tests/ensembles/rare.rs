//! Errors of what is rare, of heavy tails and of rates; observables of each path's own system.

use wzvi::ensemble::{Column, TargetStatus};
use wzvi::prelude::*;

/// A particle whose momentum is a Wiener process.
#[hamiltonian(drift = |q, p| 0.5 * p * p / m, noise = [|q, _| -q], embedding = Midpoint)]
#[derive(Clone, Debug)]
pub struct Walker {
    pub m: f64,
}

const WALKER: Walker = Walker { m: 1.0 };

/// Its paths from rest.
macro_rules! walkers {
    ($h:expr, $seed:expr) => {
        WALKER.ensemble::<Midpoint>($h).start(State::new([0.0], [0.0])).seed($seed).until(1.0).threads(1)
    };
}

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
fn an_event_that_was_never_seen_has_no_error_bound() {
    let run = walkers!(0.5, 2).paths(512).observe("never", |state| f64::from(u8::from(state.p[0] > 50.0)));
    let run = run.first_passage("far", |state| state.p[0] - 50.0).run().expect("an ensemble");
    assert!(run.nodes().last().expect("the end").error_bound(0).is_nan());
    let tables = run.tables();
    let column = |table: &str, name: &str| {
        let table = tables.iter().find(|known| known.name() == table).expect("a table");
        let (_, column) = table.columns().iter().find(|(known, _)| known == name).expect("a column");
        let Column::Number(numbers) = column else { panic!("numbers") };
        numbers.clone()
    };
    assert!(column("moments", "error_bound").iter().all(|bound| bound.is_nan()));
    assert!(column("passages", "rate_error").iter().all(|error| error.is_nan()));
    assert_eq!(column("passages", "rate"), [0.0]);
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

#[test]
fn temperatures_are_those_of_the_path_s_own_system() {
    let masses = [0.1, 1.0, 2.0, 4.0];
    let run = WALKER.ensemble::<Midpoint>(0.1).systems_from(masses.map(|m| Walker { m }));
    let run =
        run.start(State::new([0.0], [1.0])).seed(1).until(0.1).observe_temperatures().observe_equipartition();
    let run = run.run().expect("an ensemble");
    let exact = masses.iter().map(|m| 1.0 / m).sum::<f64>() / 4.0;
    let start = &run.nodes()[0];
    for (index, name) in run.observables().iter().enumerate() {
        let expected = if name.starts_with("kinetic") { exact } else { 0.0 };
        assert!((start.mean(index) - expected).abs() < 1e-14, "{name} {} {expected}", start.mean(index));
    }
}

#[test]
fn rare_events_take_no_more_than_twice_the_paths_of_a_multilevel_run() {
    // Beyond 3.09 deviations: probability 0.001. Momenta are the same at all step sizes, and the levels differ by nothing that can be seen.
    let target = 2e-4;
    let run = WALKER.multilevel::<Midpoint>(0.25).start(State::new([0.0], [0.0])).until(1.0).seed(3);
    let run = run.observe("rare", |state| f64::from(u8::from(state.p[0] > 3.09))).target(target).threads(1);
    let estimate = run.run().expect("an estimate");
    println!("{estimate}");
    assert!(estimate.met_target());
    // Bounds of all levels fall as 1/n or more slowly than 1/n²: twice the paths on each is a quarter of the squared error at least.
    let allowed = 0.75_f64.sqrt() * target;
    assert!(estimate.error_bound() > 0.25 * allowed, "{} {allowed}", estimate.error_bound());
}
