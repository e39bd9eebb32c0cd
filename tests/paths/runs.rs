//! One path: the builder, and what the trajectory knows.

use std::cell::Cell;

use fixtures::are_refused;
use fixtures::extremes::PENDULUM;
use fixtures::small::{KUBO, Kubo};
use wzvi::Error;
use wzvi::calculus::Nodes;
use wzvi::error::{ConfigError, NoiseError, PathError, StepFailure};
use wzvi::increments::Interval;
use wzvi::noise::Truncation;
use wzvi::prelude::*;

type V1 = wzvi::nalgebra::SVector<f64, 1>;

/// Each kicked by a noise of its own.
#[hamiltonian(
    drift = |_q: &[f64], p: &[f64]| p.iter().map(|p| 0.5 * p * p).sum::<f64>(),
    noise = [|q, _p, k| sigma * q[k].cos(); self.count],
    embedding = DeltaPlus,
)]
struct Rotors {
    count: usize,
    sigma: f64,
}

const H: f64 = 0.02;

/// Increments without a generator: a Weyl sequence in `(-√(3h), √(3h))`, of variance `h`.
fn path(steps: usize, h: f64) -> Vec<f64> {
    let golden = 0.618_033_988_749_894_9;
    (0..steps).map(|i| ((i as f64 * golden + 0.3).fract() - 0.5) * (12.0 * h).sqrt()).collect()
}

/// The rotation by this angle.
fn turned(start: &State<V1>, angle: f64) -> [f64; 2] {
    let (sin, cos) = angle.sin_cos();
    let (q, p) = (start.q[0], start.p[0]);
    [p * sin + q * cos, p * cos - q * sin]
}

fn start() -> State<V1> {
    State::new([0.0], [1.0])
}

fn run(every: u64) -> Trajectory<V1, Midpoint> {
    let noise = Increments::from(path(1000, H));
    KUBO.simulate::<Midpoint>(H).start(start()).noise(noise).until(20.0).record_every(every).run().unwrap()
}

#[test]
fn a_run_is_its_steps() {
    let dw = path(1000, H);
    let trajectory = run(1);
    assert_eq!((trajectory.len(), trajectory.steps(), trajectory.processes()), (1001, 1000, 1));
    let mut stepper = KUBO.stepper::<Midpoint>(H).unwrap();
    let mut state = start();
    for (node, dw) in trajectory.iter().zip(&dw) {
        assert_eq!(*node, state);
        stepper.step(&mut state, &[*dw]).unwrap();
    }
    assert_eq!((*trajectory.last(), trajectory.last().t), (state, 20.0));
    assert!(
        trajectory.increments().map(|row| row[0]).eq(dw.iter().copied()),
        "the increments of the steps are kept"
    );
    assert!(trajectory.times().enumerate().all(|(n, t)| t == n as f64 * H));

    // Kubo keeps |z|: what is left is the rounding of 1000 steps, each of a few ulps.
    assert!(trajectory.energy_drift(&KUBO) <= 1000.0 * f64::EPSILON, "{:e}", trajectory.energy_drift(&KUBO));
    assert!(trajectory.invariant_drift(&KUBO, 0).unwrap() <= 1000.0 * f64::EPSILON);
    assert!(trajectory.invariant_drift(&KUBO, 1).is_err());
    assert!(trajectory.energy_drift(&PENDULUM) > 0.1);

    // Each step is the rotation by 2 atan θ: exactly a t + σ W(t) up to 2θ³/3 of each step.
    let (mut angle, mut off) = (0.0, 0.0);
    for ((state, w), dw) in trajectory.iter().zip(trajectory.wiener(0)).zip(dw.iter().chain([&0.0])) {
        let [q, p] = turned(&start(), angle);
        // Rounding of 1000 steps.
        assert!((state.q[0] - q).hypot(state.p[0] - p) <= 1000.0 * f64::EPSILON);
        let [q, p] = turned(&start(), KUBO.a * state.t + KUBO.sigma * w);
        assert!((state.q[0] - q).hypot(state.p[0] - p) <= off + 1000.0 * f64::EPSILON);
        let theta = 0.5 * (KUBO.a * H + KUBO.sigma * dw);
        angle += 2.0 * theta.atan();
        off += 2.0 / 3.0 * theta.abs().powi(3);
    }
}

#[test]
fn recording_less_changes_nothing_else() {
    let all = run(1);
    for every in [7, 10, 1000, 5000] {
        let some = run(every);
        let step = usize::try_from(every).unwrap();
        let mut expected: Vec<_> = all.states().iter().step_by(step).copied().collect();
        let mut wiener: Vec<_> = all.wiener(0).into_iter().step_by(step).collect();
        if 1000 % every != 0 {
            expected.push(*all.last());
            wiener.extend(all.wiener(0).last());
        }
        assert_eq!(some.states(), expected, "every {every}");
        assert_eq!(some.last(), all.last());
        assert_eq!(some.len() - 1, some.increments().len());
        // Sums of sums, all compensated: one rounding each.
        let off = |(a, b): (&f64, &f64)| (a - b).abs() <= 4.0 * f64::EPSILON;
        assert!(some.wiener(0).iter().zip(&wiener).all(off) && some.wiener(0).len() == wiener.len());
    }
    let ends = run(0);
    assert_eq!((ends.len(), ends.last(), ends.stride()), (2, all.last(), 0));
    assert_eq!(run(1), all, "same input, same bits");
}

#[test]
fn observers_see_the_recorded_nodes() {
    for (every, stride) in [(0, 1), (1, 1), (10, 10), (300, 300)] {
        let all = run(1);
        let mut seen = Vec::new();
        let mut last_w = 0.0;
        let trajectory = KUBO
            .simulate::<Midpoint>(H)
            .start(start())
            .noise(Increments::from(path(1000, H)))
            .steps(1000)
            .record_every(every)
            .inspect(|state, node| {
                seen.push((node.step, *state));
                last_w = node.wiener[0];
                assert_eq!(node.increments.len(), 1);
            })
            .run()
            .unwrap();
        let mut steps: Vec<_> = (0..=1000).step_by(stride).collect();
        if steps.last() != Some(&1000) {
            steps.push(1000);
        }
        let expected: Vec<_> = steps.into_iter().map(|n| (n as u64, all.states()[n])).collect();
        assert_eq!(seen, expected, "every {every}");
        assert_eq!(Some(&last_w), all.wiener(0).last());
        if every > 0 {
            assert!(trajectory.iter().eq(seen.iter().map(|(_, state)| state)));
        }
    }
}

#[test]
fn what_is_missing_or_senseless_is_said_before_the_run() {
    let run = |simulation: Result<Trajectory<V1, Midpoint>, Error>| simulation.unwrap_err();
    let kubo = || KUBO.simulate::<Midpoint>(H);
    let noise = || Increments::from(path(1000, H));
    let missing = |error: Error, remedy: &str| {
        assert!(matches!(error, Error::Config(ConfigError::Missing(_))), "{error:?}");
        assert!(error.to_string().contains(remedy), "{error}");
    };
    missing(run(kubo().noise(noise()).until(1.0).run()), ".start(");
    missing(run(kubo().noise(noise()).start(start()).run()), ".until(");
    missing(run(kubo().start(start()).until(1.0).run()), ".noise(");
    for end in [-1.0, f64::NAN, f64::INFINITY, 1e300] {
        let error = run(kubo().start(start()).noise(noise()).until(end).run());
        assert!(matches!(error, Error::Config(ConfigError::End { .. })), "{error:?}");
    }
    let error = run(kubo().start(start()).noise(noise()).steps(u64::MAX).run());
    assert!(matches!(error, Error::Config(ConfigError::End { .. })), "{error:?}");
    // Nodes without a time of their own.
    let late = start().at(1e15);
    for h in [0.1, -0.1] {
        let error = run(KUBO.simulate::<Midpoint>(h).start(late).noise(noise()).steps(3).run());
        assert_eq!(error, ConfigError::End { start: 1e15, end: 1e15 + 3.0 * h, h }.into());
    }
    let error = run(kubo().start(start()).noise(noise()).steps(1 << 52).run());
    assert!(matches!(error, Error::Config(ConfigError::Setting(_))), "{error:?}");
    let error = run(KUBO.simulate::<Midpoint>(0.0).start(start()).noise(noise()).until(1.0).run());
    assert_eq!(error, ConfigError::StepSize(0.0).into());
    let error = run(kubo().start(State::new([f64::NAN], [0.0])).noise(noise()).until(1.0).run());
    assert_eq!(error, ConfigError::Start(StepFailure::NonFiniteInput).into());
    let error = run(kubo().start(start()).noise(Increments::from([[0.1, 0.1]])).steps(1).run());
    assert_eq!(error, NoiseError::Processes { expected: 1, got: 2 }.into());

    let rotors = Rotors { count: 3, sigma: 0.5 };
    let short = State::new(vec![0.0; 3], vec![0.0; 2]);
    let error = rotors.simulate::<DeltaPlus>(0.1).start(short).noise(noise()).steps(1).run().unwrap_err();
    assert_eq!(error, ConfigError::Start(StepFailure::Dimension { expected: 3, got: 2 }).into());
}

/// A sum over no sites is 0, as in Rust; there is nothing to step.
#[test]
fn an_empty_system_has_no_energy_and_no_run() {
    let (rotors, empty) = (Rotors { count: 0, sigma: 0.5 }, State::new(Vec::<f64>::new(), Vec::<f64>::new()));
    assert_eq!(rotors.energy(&empty), 0.0);
    let error =
        rotors.simulate::<DeltaPlus>(0.1).start(empty).noise(Wiener::seed(1)).steps(1).run().unwrap_err();
    assert_eq!(error, ConfigError::Start(StepFailure::Dimension { expected: 1, got: 0 }).into());
    assert!(error.to_string().contains("q or p is empty"), "{error}");
}

/// Two sums over sites, which need none.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| p.iter().map(|p| 0.5 * p * p).sum::<f64>() + q.windows(2).map(|w| 0.5 * (w[1] - w[0]).powi(2)).sum::<f64>(),
    embedding = [DeltaPlus, Midpoint, Verlet, Gauss<2>],
)]
struct Springs;

/// Wells in space, whose sums run over all points that there are.
#[hamiltonian(
    drift = |q: &[[f64; 3]], p: &[[f64; 3]]| {
        p.iter().map(|p| 0.5 * (p[0] * p[0] + p[1] * p[1] + p[2] * p[2])).sum::<f64>()
            + q.iter().map(|q| 0.5 * (q[0] * q[0] + q[1] * q[1] + q[2] * q[2])).sum::<f64>()
    },
    embedding = [DeltaPlus, Midpoint, Verlet, Gauss<2>],
)]
struct Wells;

#[test]
fn no_step_moves_a_state_of_another_size() {
    fn refuses<E, H>(system: &H, length: usize, expected: usize)
    where
        H: Discretized<E, Vector = wzvi::nalgebra::DVector<f64>>,
    {
        let mut state = State::new(vec![0.5; length], vec![0.25; length]);
        let error = system.stepper::<E>(0.1).unwrap().step(&mut state, &[]).unwrap_err();
        assert_eq!(error.cause, StepFailure::Dimension { expected, got: length });
        assert_eq!(state, State::new(vec![0.5; length], vec![0.25; length]));
    }
    fn of<E>()
    where
        Springs: Discretized<E, Vector = wzvi::nalgebra::DVector<f64>>,
        Wells: Discretized<E, Vector = wzvi::nalgebra::DVector<f64>>,
    {
        refuses::<E, _>(&Springs, 0, 1);
        [(1, 3), (2, 3), (4, 6), (8, 9), (3001, 3003)]
            .into_iter()
            .for_each(|(length, expected)| refuses::<E, _>(&Wells, length, expected));
    }
    of::<DeltaPlus>();
    of::<Midpoint>();
    of::<Verlet>();
    of::<Gauss<2>>();
    of::<Composed<Verlet, KahanLi6>>();
    of::<Composed<Midpoint, Yoshida4>>();
    of::<Composed<Verlet, Chin4>>();
}

#[test]
fn a_deterministic_system_takes_no_noise_and_any() {
    let run = || PENDULUM.simulate::<Midpoint>(0.1).start(State::new([1.0], [0.5])).until(50.0);
    let silent = run().run().unwrap();
    assert_eq!(run().noise(Increments::from([[1.0, 2.0]])).run().unwrap(), silent);
    assert_eq!((silent.processes(), silent.len()), (0, 501));
    assert!(silent.increments().all(<[f64]>::is_empty));
    assert_eq!(silent.wiener(0), vec![0.0; 501]);
    let iterations = silent.iterations();
    assert!(iterations.total >= 500 && (1..=6).contains(&iterations.largest), "{iterations:?}");
    // (h ω)²/24 relative, at most, for this amplitude.
    assert!(silent.energy_drift(&PENDULUM) < 1e-3);
}

/// A source that passes on what it is given, as [`Increments`] would not.
#[derive(Clone)]
struct Unchecked(Vec<f64>);

impl Noise for Unchecked {
    fn increments(&mut self, interval: &Interval, dw: &mut [f64]) -> Result<(), NoiseError> {
        let step = interval.step as usize;
        let next =
            self.0.get(step).ok_or(NoiseError::Exhausted { step: interval.step, available: self.0.len() })?;
        dw.fill(*next);
        Ok(())
    }
}

#[test]
fn a_run_that_breaks_off_keeps_what_it_has() {
    let run = |dw: Vec<f64>, every| {
        let kubo = KUBO.simulate::<Midpoint>(H).start(start()).noise(Unchecked(dw)).steps(10);
        (kubo.clone().record_every(every).run(), kubo.record_every(every).run_partial().unwrap())
    };
    let mut dw = path(10, H);
    dw[7] = f64::NAN;
    for every in [0, 1, 3, 7, 20] {
        let (error, (partial, cause)) = run(dw.clone(), every);
        let Err(Error::Step(step)) = error else { panic!("{error:?}") };
        assert_eq!((step.step, step.t, step.cause), (7, 7.0 * H, StepFailure::NonFiniteInput));
        assert!(matches!(cause, Some(Error::Step(same)) if same.step == 7));
        assert_eq!((partial.steps(), partial.last().t), (7, 7.0 * H));
        assert_eq!(partial.states().last(), Some(partial.last()));
        assert_eq!(*partial.last(), *run(path(7, H), 0).1.0.last());
    }
    let (error, (partial, _)) = run(path(4, H), 1);
    assert_eq!(error, Err(NoiseError::Exhausted { step: 4, available: 4 }.into()));
    assert_eq!(partial.len(), 5);
    let (complete, (same, none)) = run(path(10, H), 1);
    assert_eq!((complete, none), (Ok(same), None));
}

#[test]
fn backward_steps_undo_forward_ones() {
    // Every l = 1/2 step is its own inverse with h and the increments reversed.
    let forward = run(1);
    let dw: Vec<f64> = path(1000, H).into_iter().rev().map(|dw| -dw).collect();
    let back = KUBO.simulate::<Midpoint>(-H).start(*forward.last()).noise(Increments::from(dw)).until(0.0);
    let back = back.run().unwrap();
    assert_eq!((back.len(), back.last().t, back.step_size()), (1001, 0.0, -H));
    let (end, begin) = (back.last(), start());
    // Rounding of 2000 steps.
    assert!((end.q - begin.q).norm() + (end.p - begin.p).norm() <= 2000.0 * f64::EPSILON, "{end:?}");
    assert!(back.euler_lagrange_residual(&KUBO).unwrap() <= 8.0 * f64::EPSILON);
}

#[test]
fn paths_solve_the_euler_lagrange_equations() {
    let kubo = run(1);
    // Sums of numbers of size one.
    assert!(kubo.euler_lagrange_residual(&KUBO).unwrap() <= 8.0 * f64::EPSILON);
    assert!(kubo.euler_lagrange_residual(&Kubo { a: 1.6, ..KUBO }).unwrap() > 1e-4);
    let residuals = kubo.euler_lagrange(&KUBO).unwrap();
    assert_eq!(residuals.values().len(), 999);

    let pendulum =
        PENDULUM.simulate::<Midpoint>(0.1).start(State::new([1.0], [0.5])).steps(200).run().unwrap();
    assert!(pendulum.euler_lagrange_residual(&PENDULUM).unwrap() <= 8.0 * f64::EPSILON);

    let rotors = Rotors { count: 3, sigma: 0.5 };
    let dw: Vec<[f64; 3]> = path(300, 0.1).chunks(3).map(|row| [row[0], row[1], row[2]]).collect();
    let rotors_path = rotors
        .simulate::<DeltaPlus>(0.1)
        .start(State::new(vec![0.1, 0.2, 0.3], vec![1.0, 0.0, -1.0]))
        .noise(Increments::from(dw))
        .steps(100)
        .run()
        .unwrap();
    // q grows to size 10.
    assert!(rotors_path.euler_lagrange_residual(&rotors).unwrap() <= 40.0 * f64::EPSILON);
    let system = rotors_path.euler_lagrange_residual(&Rotors { count: 4, sigma: 0.5 });
    assert!(matches!(system, Err(PathError::System { path: (3, 3), .. })), "{system:?}");
}

#[test]
fn questions_without_an_answer_are_typed_errors() {
    assert_eq!(run(10).euler_lagrange_residual(&KUBO), Err(PathError::Gaps { every: 10 }));
    assert_eq!(run(0).euler_lagrange_residual(&KUBO), Err(PathError::Gaps { every: 0 }));
    assert_eq!(run(7).time_scale(), Err(PathError::Uneven { every: 7, steps: 1000 }));
    // The last step is half as long as the others; one step alone is even, and its own.
    let exact = |end| PENDULUM.simulate::<Midpoint>(0.1).start(State::new([1.0], [0.5])).until(end).run();
    assert_eq!(exact(1.05).unwrap().time_scale(), Err(PathError::Uneven { every: 1, steps: 11 }));
    let single = exact(0.05).unwrap();
    assert_eq!(single.time_scale().unwrap().step_size(), 0.05);
    let residual = single.euler_lagrange_residual(&PENDULUM).unwrap();
    assert!(residual <= 4.0 * f64::EPSILON, "{residual}");
    let none =
        KUBO.simulate::<Midpoint>(H).start(start()).noise(Increments::from([0.1])).until(0.0).run().unwrap();
    assert_eq!((none.len(), none.last()), (1, &start()));
    assert_eq!(none.time_scale(), Err(PathError::Empty));
    assert_eq!(none.euler_lagrange_residual(&KUBO), Err(PathError::Empty));
    assert_eq!(none.energy_drift(&KUBO), 0.0);
}

#[test]
fn observables_are_functions_on_the_time_scale() {
    let trajectory =
        PENDULUM.simulate::<Midpoint>(0.1).start(State::new([1.0], [0.5])).until(10.0).run().unwrap();
    let (q, p) = (trajectory.observable(|s| s.q[0]).unwrap(), trajectory.observable(|s| s.p[0]).unwrap());
    // Δ₊ q = p_∘ at the mid-points: the first equation of the mid-point embedding.
    let (slope, mean) = (q.delta_plus(), p.extension());
    for (slope, mean) in slope.values().iter().zip(mean.values().iter().skip(1).step_by(2)) {
        // Rounding of a difference of numbers of size one, divided by h.
        assert!((slope - mean).abs() <= 8.0 * f64::EPSILON / 0.1);
    }
    assert_eq!(q.scale().size::<Nodes>(), 101);
    let coarse =
        PENDULUM.simulate::<Midpoint>(0.1).start(State::new([1.0], [0.5])).until(10.0).record_every(4);
    assert_eq!(coarse.run().unwrap().time_scale().unwrap().step_size(), 0.4);
}

#[test]
fn a_source_is_told_what_it_serves() {
    #[derive(Default)]
    struct Source {
        told: Option<(bool, f64, usize, f64)>,
        asked: Cell<u64>,
    }
    impl Noise for Source {
        fn prepare(&mut self, plan: &Plan, h: f64, processes: usize, start: f64) -> Result<(), NoiseError> {
            self.told = Some((plan.truncates_increments(), h, processes, start));
            Ok(())
        }
        fn increments(&mut self, interval: &Interval, dw: &mut [f64]) -> Result<(), NoiseError> {
            let step = self.asked.replace(self.asked.get() + 1);
            assert_eq!((interval.step, interval.h, interval.start), (step, 0.1, 2.0));
            dw.fill(0.0);
            Ok(())
        }
    }
    let mut source = Source::default();
    KUBO.simulate::<Midpoint>(0.1).start(start().at(2.0)).noise(&mut source).until(3.0).run().unwrap();
    assert_eq!((source.told, source.asked.get()), (Some((true, 0.1, 1, 2.0)), 10));
    let rotors = Rotors { count: 2, sigma: 0.5 };
    let mut source = Source::default();
    let rest = State::new(vec![0.0; 2], vec![0.0; 2]).at(2.0);
    rotors.simulate::<DeltaPlus>(0.1).start(rest).noise(&mut source).until(3.0).run().unwrap();
    assert_eq!(source.told, Some((false, 0.1, 2, 2.0)));
}

/// A run by an implicit scheme truncates increments; a later run with the same source, by a scheme that does not, is that of a new one.
#[test]
fn a_borrowed_source_is_as_it_was_after_a_run() {
    fn after<N: Noise>(noise: &mut N) -> Option<wzvi::increments::Identity> {
        let rest = State::new(vec![0.0; 2], vec![0.0; 2]);
        let rotors = Rotors { count: 2, sigma: 0.5 };
        rotors.simulate::<DeltaPlus>(0.1).start(rest).noise(&mut *noise).steps(3).run().expect("a run");
        noise.identity()
    }
    fn check<N: Noise + Clone>(new: N, truncation: fn(&N) -> Truncation) {
        let mut used = new.clone();
        KUBO.simulate::<Midpoint>(0.1).start(start()).noise(&mut used).steps(3).run().expect("a run");
        assert_eq!(truncation(&used), Truncation::Unset);
        assert_eq!(after(&mut used), after(&mut new.clone()));
    }
    check(Wiener::seed(1), Wiener::truncation);
    check(WongZakai::averaged(0.1).seed(1), WongZakai::truncation);
    check(StepNormals::seed(1), StepNormals::truncation);
}

/// Chosen times are recorded beside the regular ones, with the increments in between; observables are columns of the recorded nodes.
#[test]
fn chosen_nodes_and_named_observables() {
    let all = run(1);
    let base =
        || KUBO.simulate::<Midpoint>(H).start(start()).noise(Increments::from(path(1000, H))).steps(1000);
    let observed = || base().observe("q", |state| state.q[0]).observe("time", |state| state.t);
    // 2.0 is regular; 20.0 is the end.
    for (every, expected) in [
        (None, vec![0, 4, 100, 333, 1000]),
        (Some(0), vec![0, 4, 100, 333, 1000]),
        (Some(100), vec![0, 4, 100, 200, 300, 333, 400, 500, 600, 700, 800, 900, 1000]),
        (Some(1), (0..=1000).collect()),
    ] {
        let run = observed().record_at([0.0, 0.08, 2.0, 333.0 * H, 20.0]);
        let run = match every {
            Some(every) => run.record_every(every),
            None => run,
        };
        let trajectory = run.run().unwrap();
        let states: Vec<_> = expected.iter().map(|&n: &usize| all.states()[n]).collect();
        assert_eq!(trajectory.states(), states, "{every:?}");
        let w = all.wiener(0);
        for (got, &n) in trajectory.wiener(0).iter().zip(&expected) {
            // Compensated sums of the same numbers, in other pieces.
            assert!((got - w[n]).abs() <= 4.0 * f64::EPSILON * w[n].abs().max(1.0));
        }
        assert!(trajectory.observed("q").unwrap().iter().zip(&states).all(|(q, state)| *q == state.q[0]));
        assert_eq!(trajectory.observed("time").unwrap().len(), expected.len());
        let error = trajectory.observed("p").unwrap_err();
        assert!(error.to_string().contains("`q`, `time`"), "{error}");
        assert_eq!(trajectory.time_scale().is_ok(), every == Some(1), "{every:?}");
    }
    let whole = base().record_every(0).record_at([20.0]).run().unwrap();
    assert!(whole.len() == 2 && whole.time_scale().is_ok());
    are_refused(base().record_at([20.1]).run(), "20.1");
    are_refused(base().record_at([2.0, 0.08]).run(), "in the order of the run");
    are_refused(observed().observe("q", |_| 0.0).run(), "`q`");
}
