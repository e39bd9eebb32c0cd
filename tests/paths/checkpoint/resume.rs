//! What goes on from a checkpoint is what would have been without it.

use std::cell::RefCell;

use wzvi::checkpoint::{Checkpoint, CheckpointError};
use wzvi::increments::{Identity, Interval, NoiseError};
use wzvi::nalgebra::SVector;
use wzvi::prelude::*;
use wzvi::simulate::{Simulation, Summation, Unobserved};

use super::systems::{DoublePendulum, Folding, KEPLER, PENDULUM, Wells, bits};
use fixtures::files::{contents, refused};
use fixtures::folder;

const STEPS: u64 = 12;

/// Stops after every number of steps up to [`STEPS`] and goes on, then in three parts; `run(steps, every)` is the run.
fn resumes_from_everywhere<'a, H, E, N, S, const D: usize>(
    name: &str,
    run: impl Fn(u64, u64) -> Simulation<'a, H, E, N, Unobserved, S>,
) where
    H: Discretized<E, Vector = SVector<f64, D>> + 'a,
    N: Noise,
    S: Summation<H, E>,
{
    let folder = folder!(name);
    // Each checkpoint waits for the disk: a stride that divides the steps, one that does not, and none.
    for every in [0, 3, 5] {
        let whole = bits(&run(STEPS, every).run().unwrap());
        for stop in 0..=STEPS {
            let to = || Checkpoint::to(folder.join(format!("{every}-{stop}"))).every_steps(7);
            let part = bits(&run(stop, every).checkpoint(to()).run().unwrap());
            assert_eq!(part, bits(&run(stop, every).run().unwrap()), "{name} {every} {stop}");
            let middle = stop.midpoint(STEPS);
            assert_eq!(run(middle, every).checkpoint(to()).run().unwrap().steps(), middle);
            let resumed = bits(&run(STEPS, every).checkpoint(to()).run().unwrap());
            assert_eq!(resumed, whole, "{name}: record_every({every}), stopped after {stop}");
        }
    }
}

#[test]
fn newton_with_memory() {
    resumes_from_everywhere("kepler", |steps, every| KEPLER.run(steps, every));
}

#[test]
fn compensated_sums() {
    assert!(DoublePendulum.stepper::<Midpoint>(0.01).unwrap().is_compensated());
    resumes_from_everywhere("double", |steps, every| DoublePendulum.run(steps, every));
}

/// As those of a stepper, and of no run with compensated sums.
#[test]
fn plain_sums() {
    resumes_from_everywhere("plain", |steps, every| DoublePendulum.run(steps, every).plain_sums());
    let path = |steps| DoublePendulum.run(steps, 0).plain_sums().run().unwrap();
    let mut stepper = DoublePendulum.stepper::<Midpoint>(0.01).unwrap().plain();
    let mut state = *path(0).last();
    for _ in 0..200 {
        stepper.step(&mut state, &[]).unwrap();
    }
    assert_eq!(path(200).last(), &state);
    assert_ne!(DoublePendulum.run(200, 0).run().unwrap().last(), &state);
    // Nor does one go on as the other.
    let folder = folder!("sums");
    let to = || Checkpoint::to(folder.join("kept")).every_steps(7);
    DoublePendulum.run(STEPS, 0).checkpoint(to()).run().unwrap();
    assert!(DoublePendulum.run(STEPS + 1, 0).plain_sums().checkpoint(to()).run().is_err());
}

#[test]
fn wiener_increments() {
    resumes_from_everywhere("wiener", |steps, every| PENDULUM.run(Wiener::seed(7).path(3), steps, every));
}

#[test]
fn averaged_increments_of_every_sampling() {
    type Of = fn(WongZakai) -> WongZakai;
    let samplings: [(&str, Of); 4] = [
        ("left", WongZakai::left),
        ("centred", WongZakai::centred),
        ("exact", WongZakai::exact),
        ("exact_centred", WongZakai::exact_centred),
    ];
    // As long as a step, and longer.
    for ((name, of), eps) in samplings.into_iter().zip([0.02, 0.07, 0.02, 0.07]) {
        let noise = || of(WongZakai::averaged(eps).seed(7));
        resumes_from_everywhere(name, |steps, every| PENDULUM.run(noise(), steps, every));
    }
}

#[test]
fn given_increments() {
    let rows: Vec<[f64; 2]> = (0..STEPS).map(|n| [0.1 * (n as f64).sin(), -0.0]).collect();
    resumes_from_everywhere("given", |steps, every| {
        PENDULUM.run(Increments::from(rows.clone()), steps, every)
    });
}

/// Steps in halves leave nothing behind that a checkpoint would miss.
#[test]
fn steps_that_are_halved() {
    let run = |steps, every| Folding.run(steps, every);
    let halved = run(STEPS, 0).run().unwrap().iterations().halved;
    assert!((2..STEPS).contains(&halved), "{halved}");
    resumes_from_everywhere("halved", run);
}

/// A step after a hard one is checked, also where a checkpoint lies between them.
#[test]
fn steps_after_hard_ones() {
    assert_eq!(Wells.run(STEPS, 0).run().unwrap().iterations().hard, STEPS);
    resumes_from_everywhere("hard", |steps, every| Wells.run(steps, every));
}

#[test]
fn a_finished_run_is_returned_at_once_and_left_alone() {
    let folder = folder!("finished");
    let run = || KEPLER.run(100, 3).checkpoint(Checkpoint::to(folder.join("run")));
    let first = run().run().unwrap();
    let files = contents(&folder);
    assert_eq!(files.len(), 1);
    let seen = RefCell::new(0);
    let again = run().inspect(|_, _| *seen.borrow_mut() += 1).run().unwrap();
    assert_eq!((bits(&first), *seen.borrow()), (bits(&again), 0));
    assert_eq!(contents(&folder), files);
}

/// A path that is stopped has what it did, and its checkpoint has that, too.
#[test]
fn a_handle_stops_a_path_that_goes_on_later() {
    let folder = folder!("stopped-by-handle");
    let run = |steps| PENDULUM.run(Wiener::seed(7), steps, 1000);
    let checkpoint = || Checkpoint::to(folder.join("run"));
    let handle = Handle::new();
    let stopped = run(1 << 40).checkpoint(checkpoint()).handle(&handle);
    let stopped = stopped.record_every(1 << 30).inspect(|_, _| handle.stop());
    let (path, error) = stopped.run_partial().unwrap();
    let done = path.steps();
    assert!(
        matches!(error, Some(wzvi::Error::Stopped(stopped)) if stopped.done == done && done > 0),
        "{error:?}"
    );
    assert_eq!(handle.progress().done, done);
    let path = run(done + 10).record_every(1 << 30).checkpoint(checkpoint()).run().unwrap();
    assert_eq!(bits(&path), bits(&run(done + 10).record_every(1 << 30).run().unwrap()));
    let error = run(1 << 40).record_every(0).handle(&handle).run().unwrap_err();
    assert!(error.to_string().contains(".run_partial()"), "{error}");
}

#[test]
fn an_earlier_end_is_refused() {
    let folder = folder!("beyond");
    let run = |steps| KEPLER.run(steps, 0).checkpoint(Checkpoint::to(folder.join("run"))).run();
    run(50).unwrap();
    let files = contents(&folder);
    let error = refused(run(49));
    assert_eq!(error, CheckpointError::Beyond { path: folder.join("run"), step: 50, steps: 49 });
    assert!(error.to_string().contains("at step 50, beyond the 49 steps"), "{error}");
    assert_eq!(contents(&folder), files);
}

/// An observer sees each node once, over both runs, with the same Wiener path.
#[test]
fn observers_see_what_is_new() {
    let folder = folder!("observed");
    let whole = RefCell::new(Vec::new());
    let parts = RefCell::new(Vec::new());
    let look = |seen: &RefCell<Vec<Vec<u64>>>, state: &State<SVector<f64, 1>>, step: u64, wiener: &[f64]| {
        let numbers = [state.q[0], state.p[0], state.t, wiener[0], wiener[1]];
        seen.borrow_mut().push([step].into_iter().chain(numbers.map(f64::to_bits)).collect());
    };
    let run = |steps| PENDULUM.run(Wiener::seed(1), steps, 0);
    let checkpoint = || Checkpoint::to(folder.join("run"));
    run(40).inspect(|state, node| look(&whole, state, node.step, node.wiener)).run().unwrap();
    // The sums are kept for those who look later.
    run(10).checkpoint(checkpoint()).run().unwrap();
    for steps in [25, 40] {
        run(steps)
            .checkpoint(checkpoint())
            .inspect(|state, node| look(&parts, state, node.step, node.wiener))
            .run()
            .unwrap();
    }
    assert_eq!(parts.into_inner(), whole.into_inner()[11..]);
}

/// Increments by a rule, from a source that says what it is, or does not.
#[derive(Clone)]
struct Rule {
    slope: f64,
    says: bool,
}

impl Noise for Rule {
    fn increments(&mut self, interval: &Interval, dw: &mut [f64]) -> Result<(), NoiseError> {
        dw.fill(self.slope * (interval.step as f64).sin());
        Ok(())
    }

    fn identity(&self) -> Option<Identity> {
        self.says.then(|| Identity::of("Rule").with("slope", self.slope))
    }
}

#[test]
fn a_source_of_ones_own() {
    let source = Rule { slope: 0.1, says: true };
    resumes_from_everywhere("rule", |steps, every| PENDULUM.run(source.clone(), steps, every));

    let folder = folder!("rule-by-reference");
    let checkpoint = || Checkpoint::to(folder.join("run"));
    let mut source = Rule { slope: 0.1, says: true };
    PENDULUM.run(&mut source, 5, 0).checkpoint(checkpoint()).run().unwrap();
    let mut other = Rule { slope: 0.2, says: true };
    let error = refused(PENDULUM.run(&mut other, 9, 0).checkpoint(checkpoint()).run());
    assert!(error.to_string().contains("noise slope is 0.1 there and 0.2 here"), "{error}");

    let silent = Rule { slope: 0.1, says: false };
    let error = refused(PENDULUM.run(silent.clone(), 5, 0).checkpoint(checkpoint()).run());
    assert_eq!(error, CheckpointError::Noise);
    // A deterministic system does not ask.
    KEPLER.run(5, 0).noise(silent).checkpoint(Checkpoint::to(folder.join("kepler"))).run().unwrap();
}

/// The state at a failed step is that of the uninterrupted run, and the error says the same.
#[test]
fn failures_are_the_same_failures() {
    let folder = folder!("failure");
    let rows: Vec<[f64; 2]> = (0..10).map(|_| [0.1, 0.2]).collect();
    let run = |steps| PENDULUM.run(Increments::from(rows.clone()), steps, 2);
    let (whole, expected) = run(20).run_partial().unwrap();
    for _ in 0..2 {
        let to = Checkpoint::to(folder.join("run")).every_steps(3);
        let (path, error) = run(20).checkpoint(to).run_partial().unwrap();
        assert_eq!((bits(&path), error), (bits(&whole), expected.clone()));
    }
    assert!(matches!(expected, Some(wzvi::Error::Noise(NoiseError::Exhausted { step: 10, available: 10 }))));

    // A step that fails counts from the start of the first run.
    let fall = || KEPLER.simulate::<Midpoint>(0.05).start(State::new([1.0, 0.0], [0.0, 0.0])).steps(1000);
    let (whole, expected) = fall().run_partial().unwrap();
    assert!(matches!(expected, Some(wzvi::Error::Step(_))), "{expected:?}");
    for every in [1, 7] {
        let to = || Checkpoint::to(folder.join(format!("fall{every}"))).every_steps(every);
        for _ in 0..2 {
            let (path, error) = fall().checkpoint(to()).run_partial().unwrap();
            assert_eq!((bits(&path), &error), (bits(&whole), &expected));
        }
    }
}

#[test]
fn backward_runs_go_on_too() {
    let folder = folder!("backward");
    let run = |steps| {
        let start = State::new([0.5], [0.0]).at(1.0);
        PENDULUM.simulate::<Midpoint>(-0.02).start(start).noise(Wiener::seed(4)).steps(steps)
    };
    let to = || Checkpoint::to(folder.join("run"));
    run(33).checkpoint(to()).run().unwrap();
    let resumed = run(80).checkpoint(to()).run().unwrap();
    assert_eq!(bits(&resumed), bits(&run(80).run().unwrap()));
}

#[test]
fn settings_that_make_no_sense() {
    let folder = folder!("settings");
    let path = folder.join("run");
    let to = || Checkpoint::to(&path);
    for checkpoint in [to().every_steps(0), to().every_steps(1).every(std::time::Duration::ZERO)] {
        let error = KEPLER.run(5, 0).checkpoint(checkpoint).run();
        assert!(matches!(error, Err(wzvi::Error::Config(_))), "{error:?}");
    }
    assert_eq!(contents(&folder), []);
}
