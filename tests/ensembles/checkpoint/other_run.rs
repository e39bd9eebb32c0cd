//! A checkpoint of another run is refused, by the name of what differs.

use std::path::Path;

use wzvi::checkpoint::Checkpoint;
use wzvi::ensemble::Ensemble;
use wzvi::noise::Truncation;
use wzvi::prelude::*;

use fixtures::edge::{Cubes, EDGE, Edge, bits, whole};
use fixtures::files::differences;
use fixtures::folder;

/// The fields that differ.
fn fields<H, E>(file: &Path, run: Ensemble<'_, H, E>) -> Vec<String>
where
    H: Discretized<E> + Sync,
{
    differences(file, |to| run.checkpoint(to).run())
}

#[test]
fn every_setting_is_told_apart() {
    let file = folder!("other").join("run");
    EDGE.kept(&file).paths(1024).run().unwrap();
    let base = || EDGE.run::<DeltaPlus>();
    let fields = |run| fields(&file, run);
    assert_eq!(fields(base().seed(8)), ["noise seed"]);
    assert_eq!(fields(base().steps(25)), ["the number of steps", "the steps before the recorded nodes"]);
    assert_eq!(fields(base().record_every(12)), ["the steps before the recorded nodes"]);
    assert_eq!(fields(base().record_at([0.4])), ["the steps before the recorded nodes"]);
    let truncated = fields(base().truncation(Truncation::On(2.0)));
    assert_eq!(truncated, ["the largest normal increment", "noise truncation"]);
    assert_eq!(fields(base().histogram("q", 0.0, 1.0, 3)), ["the histograms"]);
    assert_eq!(fields(base().first_passage("event0", |state| state.q[0])), ["the events"]);
    assert_eq!(fields(base().observe("observable0", |_| 1.0)), ["the observables"]);
    let more = Cubes { sums: Vec::new(), lost: 1 };
    assert_eq!(
        fields(base().statistic(more)),
        ["the statistics that were added", "their settings (checksum)"]
    );
    assert_eq!(fields(base().start(State::new([1.0], [-0.5]))), ["p[0] of the start"]);
    assert_eq!(fields(base().start(State::new([1.0], [0.5]).at(1.0))), ["t of the start"]);
    let heavier = Edge { a: 1.0_f64.next_up(), ..EDGE };
    assert_eq!(fields(heavier.run::<DeltaPlus>()), ["the parameter a"]);
    assert_eq!(bits(&base().checkpoint(Checkpoint::to(&file)).run().unwrap()), whole());
}

#[test]
fn another_scheme_step_or_observable() {
    let file = folder!("other-scheme").join("run");
    let start = || State::new([1.0], [0.5]);
    let run = || EDGE.ensemble::<DeltaPlus>(0.05).start(start()).paths(600).seed(7).steps(4);
    let observed = |of: fn(&SystemState<Edge>) -> f64| run().observe("observable0", of);
    let of_q = || observed(|state| state.q[0]);
    of_q().checkpoint(Checkpoint::to(&file)).run().unwrap();
    let values = ["what the observables and events are on path 0 (checksum)"];
    assert_eq!(fields(&file, observed(|state| state.p[0])), values);
    // The same value at the start, but not a step later: q is 1 there.
    assert_eq!(fields(&file, observed(|state| state.q[0].powi(2))), values);
    assert_eq!(fields(&file, observed(|state| state.q[0] * (1.0 + 1e-12 * state.t))), values);
    assert_eq!(fields(&file, of_q().quantiles()), ["quantiles"]);
    assert_eq!(fields(&file, of_q().keep_paths(1 << 30)), ["paths are kept"]);
    assert_eq!(fields(&file, run()), ["the observables"]);
    assert_eq!(fields(&file, of_q().antithetic()), ["noise antithetic"]);
    let scheme = EDGE.ensemble::<Midpoint>(0.05).start(start()).paths(600).seed(7).steps(4);
    assert!(fields(&file, scheme.observe("observable0", |state| state.q[0])).contains(&"the scheme".into()));
    let step = EDGE.ensemble::<DeltaPlus>(0.051).start(start()).paths(600).seed(7).steps(4);
    assert!(fields(&file, step.observe("observable0", |state| state.q[0])).contains(&"the step size".into()));
}
