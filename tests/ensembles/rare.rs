//! Errors of what is rare, of heavy tails and of rates; observables of each path's own system.

use fixtures::small::{WALKER, Walker};
use fixtures::{column, table, walkers};
use wzvi::prelude::*;

#[test]
fn an_event_that_was_never_seen_has_no_error_bound() {
    let run = walkers!(0.5, 2).paths(512).observe("never", |state| f64::from(u8::from(state.p[0] > 50.0)));
    let run = run.first_passage("far", |state| state.p[0] - 50.0).run().expect("an ensemble");
    assert!(run.nodes().last().expect("the end").error_bound(0).is_nan());
    let tables = run.tables();
    let numbers = |of: &str, name: &str| column(table(&tables, of), name).to_vec();
    assert!(numbers("moments", "error_bound").iter().all(|bound| bound.is_nan()));
    assert!(numbers("passages", "rate_error").iter().all(|error| error.is_nan()));
    assert_eq!(numbers("passages", "rate"), [0.0]);
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

/// A coarser path has the noise of the finer one: momenta that are Wiener processes are the same on both.
#[test]
fn coarse_paths_have_the_noise_of_fine_ones() {
    let run = WALKER.multilevel::<Midpoint>(0.25).start(State::new([0.0], [0.0])).until(1.0).seed(3);
    let estimate = run.observe("p", |state| state.p[0]).target(0.1).run().expect("an estimate");
    let [coarsest, finer @ ..] = estimate.levels() else { panic!("{estimate}") };
    assert!(coarsest.variance() > 0.5 && !finer.is_empty(), "{estimate}");
    for level in finer {
        // A dozen roundings of numbers up to 4.
        assert!(level.variance().sqrt() < 1e-14, "{estimate}");
    }
}
