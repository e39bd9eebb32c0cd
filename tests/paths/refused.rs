//! Settings and inputs that make no sense are typed errors, at the first call that can know.

use fixtures::small::KUBO;
use fixtures::{are_refused, table};
use wzvi::error::{ConfigError, NoiseError, PathError, StepFailure};
use wzvi::increments::Interval;
use wzvi::prelude::*;

/// A noise that moves nothing.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * omega * omega * q * q,
    noise = [|_, _| sigma],
    invariant = [|q, p| 0.5 * p * p + 0.5 * omega * omega * q * q],
    embedding = [Midpoint, Verlet],
)]
#[derive(Clone, Copy)]
struct Still {
    omega: f64,
    sigma: f64,
}

#[hamiltonian(drift = |q, p| 0.5 * (p * p + q * q), embedding = Midpoint)]
struct Oscillator;

const STILL: Still = Still { omega: 1.0, sigma: 0.5 };

fn start() -> State<wzvi::nalgebra::SVector<f64, 1>> {
    State::new([1.0], [0.25])
}

fn words<T>(outcome: Result<T, wzvi::Error>) -> String {
    match outcome {
        Err(error) => error.to_string(),
        Ok(_) => panic!("it ran"),
    }
}

/// A source of one number.
#[derive(Clone, Copy)]
struct Constant(f64);

impl Noise for Constant {
    fn increments(&mut self, _: &Interval, dw: &mut [f64]) -> Result<(), NoiseError> {
        dw.fill(self.0);
        Ok(())
    }
}

#[test]
fn increments_have_to_be_numbers_where_they_move_nothing() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut state = start();
        let mut stepper = STILL.stepper::<Midpoint>(0.1).unwrap();
        let error = stepper.step(&mut state, &[bad]).unwrap_err();
        assert_eq!((error.cause, state), (StepFailure::NonFiniteInput, start()));
        stepper.step(&mut state, &[0.1]).unwrap();
        assert!(stepper.step(&mut state, &[bad]).is_err());
        let run = STILL.simulate::<Verlet>(0.1).start(start()).steps(3).noise(Constant(bad)).run();
        assert!(matches!(run, Err(wzvi::Error::Step(error)) if error.cause == StepFailure::NonFiniteInput));
    }
    assert!(STILL.simulate::<Verlet>(0.1).start(start()).steps(3).noise(Constant(0.5)).run().is_ok());
}

#[test]
fn what_a_path_or_a_run_does_not_have() {
    let run = || STILL.simulate::<Midpoint>(0.1).start(start()).noise(Wiener::seed(1));
    let path = run().steps(4).run().unwrap();
    assert_eq!(path.invariant_drift(&STILL, 3), Err(PathError::Invariant { index: 3, known: 1 }));
    assert!(path.invariant_drift(&STILL, 0).unwrap() < 1e-15);
    for both in [run().until(1.0).steps(3), run().steps(3).until(1.0), run().until(1.0).steps(3).until(1.0)] {
        assert!(words(both.run()).contains("`until(1)` and `steps(3)`"));
    }
    // The later of two of a kind.
    assert_eq!(run().until(9.0).until(1.0).run().unwrap().steps(), 10);
    let near = run().until(1.0).record_at([0.1, 0.300_000_000_000_000_04, 0.300_000_000_000_000_1]);
    assert!(words(near.run()).contains("same node"));
    assert!(words(run().until(1e300).run()).contains("t = 1e300 in steps of 0.1"));
    let nan = Still { omega: f64::NAN, ..STILL };
    assert_eq!(nan.stepper::<Midpoint>(0.1).err(), Some(ConfigError::NotANumber { parameter: "omega" }));
    assert!(
        words(nan.simulate::<Midpoint>(0.1).start(start()).steps(1).noise(Wiener::seed(1)).run())
            .contains("`omega`")
    );
}

#[test]
fn a_multilevel_run_takes_what_was_said_or_refuses_it() {
    let run = || STILL.ensemble::<Midpoint>(0.25).start(start()).observe("q", |state| state.q[0]).until(1.0);
    let seeded = || run().seed(3);
    for (asked, what) in [
        (seeded().observe("p", |state| state.p[0]), "a second observable"),
        (seeded().until_error("no such", 0.1), "`until_error`"),
        (seeded().inspect(|_, _| ()), "`inspect`"),
        (seeded().covariances(true), "`covariances`"),
        (seeded().allow_losses(0.5), "`allow_losses`"),
        (seeded().record_every(2), "`record_every`"),
        (seeded().record_at([0.5]), "`record_at`"),
        (seeded().keep_crossings(3), "`keep_crossings`"),
        (seeded().keep_paths(1 << 20), "`keep_paths`"),
        (seeded().section(|state| state.q[0]), "`section`"),
        (seeded().first_passage("far", |state| state.q[0] - 9.0), "`first_passage`"),
        (seeded().unwatched(), "`unwatched`"),
        (seeded().retry(Retry::halving(2)), "`retry`"),
        (run().noise(wzvi::noise::StepNormals::seed(3).antithetic()), "`antithetic`"),
    ] {
        let words = words(asked.multilevel(0.1).run());
        assert!(
            words.contains(&format!("`multilevel` has no use for {what}: leave it out")),
            "{what}: {words}"
        );
    }
    // Levels of the paper's experiment would converge to the solution of another equation.
    let run = KUBO.multilevel::<Uncorrected<DeltaPlus>>(0.25).start(start()).seed(1).until(1.0);
    are_refused(run.observe("q", |state| state.q[0]).target(0.1).run(), "limit");
}

#[test]
fn settings_of_no_use_are_refused_in_few_words() {
    let run = || {
        let run = STILL.ensemble::<Midpoint>(0.25).start(start()).observe("q", |state| state.q[0]);
        run.paths(4).seed(3).until(1.0)
    };
    for (asked, what) in [
        (run().keep_crossings(3), "a section"),
        (run().histogram("q", 1e300, -1e300, 4), "from 1e300 to -1e300"),
        (run().until_error("q", -1e300), "-1e300"),
        (run().allow_losses(1e300), "1e300"),
    ] {
        let words = words(asked.run());
        assert!(words.contains(what) && words.len() < 200, "{words}");
    }
    assert!(run().section(|state| state.q[0]).keep_crossings(3).run().is_ok());
    let path = |h: f64| STILL.simulate::<Midpoint>(h).start(start()).noise(Wiener::seed(1)).until(1.0);
    for time in [f64::NAN, f64::INFINITY, -1.0, -1e300] {
        let words = words(path(0.1).time_averages().discard(time).run());
        assert!(words.contains("`discard(") && words.len() < 200, "{words}");
    }
    assert!(words(path(1e300).run()).contains("overflows"));
}

#[test]
fn a_tangent_takes_what_was_said_or_refuses_it() {
    let run = || STILL.simulate::<Midpoint>(0.1).start(start()).noise(Wiener::seed(1)).until(1.0);
    for (asked, what) in [
        (run().section(|state| state.q[0]), "`section`"),
        (run().observe("q", |state| state.q[0]), "`observe`"),
        (run().record_at([0.5]), "`record_at`"),
        (run().record_every(5), "no use"),
        (run().retry(Retry::halving(2)), "`retry`"),
    ] {
        assert!(words(asked.tangent()).contains(what), "{what}");
    }
    assert!(run().quiet().threads(1).unwatched().until(0.95).tangent().is_ok());
}

/// Steps can be halved where the noise has increments inside of them. Rows of numbers have none, whichever is
/// set first.
#[test]
fn a_noise_of_whole_steps_does_not_drive_their_halves() {
    fn refused<T>(outcome: Result<T, wzvi::Error>) {
        match outcome {
            Err(wzvi::Error::Noise(NoiseError::Setting(words))) => {
                assert!(words.contains("`retry(...)`") && words.contains("leave `retry` out"), "{words}");
            }
            other => panic!("{:?}", other.err()),
        }
    }
    let rows = || Increments::from([0.1, 0.2]);
    let path = || STILL.simulate::<Midpoint>(0.1).start(start()).steps(2);
    let paths = || STILL.ensemble::<Midpoint>(0.1).start(start()).steps(2).paths(4);
    let halving = Retry::halving(2);
    refused(path().noise(rows()).retry(halving).run());
    refused(path().retry(halving).noise(rows()).run());
    refused(path().retry(halving).noise(&mut rows()).run_partial());
    refused(path().retry(halving).noise(rows()).time_averages().run());
    refused(paths().noise(rows()).retry(halving).run());
    refused(paths().retry(halving).noise(rows()).replay(1));
    assert!(path().retry(Retry::never()).noise(rows()).run().is_ok());
    assert!(path().retry(halving).noise(&mut Wiener::seed(1)).run().is_ok());
    // A system without noise asks for none.
    let free = Oscillator.simulate::<Midpoint>(0.1).start(start()).steps(2);
    assert!(free.retry(halving).noise(rows()).run().is_ok());
}

/// A single path counts steps, an ensemble paths. Nothing is written before that is clear.
#[test]
fn a_checkpoint_counts_what_its_run_has() {
    let folder = fixtures::folder!("counts");
    let file = || Checkpoint::to(folder.join("file"));
    let path = || STILL.simulate::<Midpoint>(0.1).start(start()).steps(2).noise(Wiener::seed(1));
    let paths = || STILL.ensemble::<Midpoint>(0.1).start(start()).steps(2).paths(4).seed(1);
    let levels = || {
        let run = STILL.multilevel::<Midpoint>(0.1).start(start()).steps(2).seed(1);
        run.observe("q", |state| state.q[0]).target(0.1)
    };
    are_refused(path().checkpoint(file().every_paths(10)).run(), "write `.every_steps(number)`");
    are_refused(path().checkpoint(file().every_steps(1).every_paths(10)).run(), "`every_paths(10)`");
    are_refused(path().checkpoint(file().every_paths(10)).time_averages().run(), "`every_paths(10)`");
    are_refused(paths().checkpoint(file().every_steps(7)).run(), "write `.every_paths(number)`");
    are_refused(levels().checkpoint(file().every_steps(7)).run(), "`every_steps(7)`");
    assert!(!folder.join("file").exists());
    assert!(paths().checkpoint(file().every_paths(10)).run().is_ok());
}

/// All errors are in one module, wherever in the run time they are raised.
#[test]
fn errors_have_one_public_place() {
    use std::any::type_name;
    use wzvi::error as all;
    let names = [
        type_name::<all::Error>(),
        type_name::<all::CheckpointError>(),
        type_name::<all::Damage>(),
        type_name::<all::Difference>(),
        type_name::<all::DomainError>(),
        type_name::<all::FileError>(),
        type_name::<all::LevelError>(),
        type_name::<all::LevelFailure>(),
        type_name::<all::PathError>(),
        type_name::<all::PlotError>(),
        type_name::<all::ReportError>(),
        type_name::<all::SeriesError>(),
        type_name::<all::StatisticsError>(),
        type_name::<all::StoppedError>(),
    ];
    let elsewhere = [
        type_name::<wzvi::Error>(),
        type_name::<wzvi::checkpoint::CheckpointError>(),
        type_name::<wzvi::checkpoint::Damage>(),
        type_name::<wzvi::checkpoint::Difference>(),
        type_name::<wzvi::calculus::DomainError>(),
        type_name::<wzvi::ensemble::FileError>(),
        type_name::<wzvi::ensemble::LevelError>(),
        type_name::<wzvi::ensemble::LevelFailure>(),
        type_name::<wzvi::trajectory::PathError>(),
        type_name::<wzvi::plot::PlotError>(),
        type_name::<wzvi::report::ReportError>(),
        type_name::<wzvi::series::SeriesError>(),
        type_name::<wzvi::ensemble::StatisticsError>(),
        type_name::<all::StoppedError>(),
    ];
    assert_eq!(names, elsewhere);
}

#[test]
fn states_and_tables_for_people() {
    let state = State::<wzvi::nalgebra::SVector<f64, 2>>::new([1.0, 2.0], [3.0, -4.5e300]);
    assert_eq!(state.to_string(), "q: [1, 2], p: [3, -4.5e300], t: 0");
    let sweep = |draw: &mut wzvi::ensemble::Draw| Still { omega: 1.0 + draw.path() as f64, sigma: 0.5 };
    let run = STILL.ensemble::<Midpoint>(0.1).start(start()).systems(sweep).paths(3).seed(1).until(0.2);
    let tables = run.observe("omega", |state| state.q[0]).keep_paths(1 << 20).run().unwrap().tables();
    let columns = |name: &str| -> Vec<String> {
        table(&tables, name).columns().iter().map(|(name, _)| name.clone()).collect()
    };
    assert_eq!(columns("run").last().unwrap(), "sigma");
    assert_eq!(columns("paths"), ["path", "time", "omega_", "omega"]);
    let mut text = Vec::new();
    table(&tables, "paths").write_csv(&mut text).unwrap();
    let text = String::from_utf8(text).unwrap();
    assert!(text.lines().nth(1).unwrap().starts_with("0,0.0,1.0,"), "{text}");
    assert!(text.lines().last().unwrap().starts_with("2,0.2,3.0,"), "{text}");
}
