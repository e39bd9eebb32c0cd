//! Two methods that set the same thing are refused, in either order, by their names.

use wzvi::error::Error;
use wzvi::noise::Truncation;
use wzvi::prelude::*;

use fixtures::small::KUBO;

fn words<T>(outcome: Result<T, Error>) -> String {
    match outcome {
        Ok(_) => "it runs".into(),
        Err(error @ Error::Config(_)) => error.to_string(),
        Err(error) => panic!("{error:?}"),
    }
}

#[test]
fn two_settings_of_one_thing_are_refused() {
    let start = || State::new([0.0], [1.0]);
    let path = || KUBO.simulate::<Midpoint>(0.1).start(start()).noise(Wiener::seed(7));
    let bare = || KUBO.ensemble::<Midpoint>(0.1).paths(4).steps(3);
    let paths = || bare().start(start());
    let observed = || paths().observe("q", |state| state.q[0]);
    let levels =
        || KUBO.multilevel::<Midpoint>(0.1).start(start()).observe("q", |state| state.q[0]).target(0.5);
    let measured = || {
        let run = KUBO.work_precision().start(start()).until(1.0).step_sizes([0.5]).scheme::<Midpoint>();
        run.paths(2).repetitions(0).quiet()
    };
    let of_path = || path().until(1.0).observe("q", |state| state.q[0]);
    let exact = |_: f64, _: &[f64]| State::new([0.0], [1.0]);
    let on_path = |_: f64, _: &mut Wiener| Ok(State::new([0.0], [1.0]));
    let own = |_: &mut wzvi::ensemble::Draw| KUBO.clone();
    let refused: Vec<(&str, String)> = vec![
        // A single path.
        ("`until(1)` and `steps(3)`", words(path().until(1.0).steps(3).run())),
        ("`until(1)` and `steps(3)`", words(path().steps(3).until(1.0).run())),
        ("`until(1)` and `steps(3)`", words(path().steps(3).until(1.0).tangent())),
        (
            "`stop_when(...)` before and after `time_averages`",
            words(of_path().stop_when(|| false).time_averages().stop_when(|| false).run()),
        ),
        // An ensemble.
        ("`until(1)` and `steps(3)`", words(paths().seed(1).until(1.0).run())),
        ("`seed(1)` and `noise(...)`", words(paths().seed(1).noise(Wiener::seed(7)).run())),
        ("`seed(1)` and `noise(...)`", words(paths().noise(Wiener::seed(7)).seed(1).run())),
        ("`seed(1)` and `noise(...)`", words(paths().noise(StepNormals::seed(1)).seed(1).run())),
        ("`seed(1)` and `noise(...)`", words(paths().noise(Increments::from([0.1; 3])).seed(1).replay(0))),
        ("`start(...)` and starts", words(paths().seed(1).starts(|_| State::new([0.0], [1.0])).run())),
        ("`start(...)` and starts", words(bare().seed(1).starts_from(vec![start(); 4]).start(start()).run())),
        (
            "`starts_from(...)` and `starts(...)`",
            words(bare().seed(1).starts(|_| State::new([0.0], [1.0])).starts_from(vec![start(); 4]).run()),
        ),
        (
            "`systems_from(...)` and `systems(...)`",
            words(paths().seed(1).systems_from(vec![KUBO; 4]).systems(own).run()),
        ),
        ("`antithetic()` and a noise", words(paths().antithetic().noise(Wiener::seed(7)).run())),
        (
            "`truncation(...)` and `noise(...)`",
            words(paths().truncation(Truncation::Off).noise(Wiener::seed(7)).run()),
        ),
        (
            "`truncation(...)` and a noise with a truncation of its own",
            words(paths().truncation(Truncation::On(2.0)).noise(StepNormals::seed(7).untruncated()).run()),
        ),
        (
            "`truncation(...)` and a noise with a truncation of its own",
            words(paths().noise(StepNormals::seed(7).truncated(3)).truncation(Truncation::On(2.0)).run()),
        ),
        // A multilevel run.
        ("`until(1)` and `steps(10)`", words(levels().seed(1).steps(10).until(1.0).run())),
        (
            "`seed(1)` and `noise(...)`",
            words(observed().noise(StepNormals::seed(7)).multilevel(0.5).seed(1).run()),
        ),
        (
            "`target(0.5)` and `multilevel(0.25)`",
            words(observed().seed(1).multilevel(0.25).target(0.5).run()),
        ),
        // A measurement.
        ("`value(...)` and `exact(...)`", words(measured().exact(exact).value(start()).run())),
        (
            "`reference(0.1)` and `exact(...)`",
            words(measured().reference::<Midpoint>(0.1).exact(exact).run()),
        ),
        (
            "`exact_on_path(...)` and `exact(...)`",
            words(measured().exact_on_path(on_path).exact(exact).run()),
        ),
        (
            "`value(...)` and `reference(0.1)`",
            words(measured().value(start()).reference::<Midpoint>(0.1).run()),
        ),
    ];
    let observed_twice = measured().value(start()).observe("q", |state| state.q[0]);
    let observed_twice = words(observed_twice.expectation("q", |state| state.q[0], 0.0).run());
    assert!(observed_twice.contains("two observables have the name `q`"), "{observed_twice}");
    for (names, said) in &refused {
        assert!(said.contains(names) && said.contains("leave one of them out"), "{names}: {said}");
    }
}

/// A later call of the same method replaces the one before, and a setting that has been made before the noise
/// acts on it.
#[test]
fn later_calls_of_one_method_replace_earlier_ones() {
    let run = || KUBO.ensemble::<Midpoint>(0.1).start(State::new([0.0], [1.0])).paths(4).steps(3);
    let plain = run().seed(2).run().unwrap();
    assert!(run().seed(1).seed(2).run().unwrap() == plain);
    assert!(
        run().start(State::new([3.0], [1.0])).start(State::new([0.0], [1.0])).seed(2).run().unwrap() == plain
    );
    let noise = || StepNormals::seed(2);
    assert!(run().noise(StepNormals::seed(1)).noise(noise()).run().unwrap() == plain);
    let pairs = run().noise(noise()).antithetic().run().unwrap();
    assert!(run().antithetic().noise(noise()).run().unwrap() == pairs && pairs != plain);
    assert!(run().noise(noise().antithetic()).run().unwrap() == pairs);
}
