//! Multilevel runs: exact means of the system and of each step size, the rates of the theory, the same bits however they are
//! split.

use fixtures::are_refused;
use fixtures::edge::Edge;
use fixtures::small::{DoubleWell, KUBO, Kubo, TwoAdditive, WALKER, kubo_levels, kubo_run};
use wzvi::ensemble::{InstructionSet, LevelError, LevelFailure, Multilevel, Observed};
use wzvi::error::Error;
use wzvi::noise::{Truncation, clip_bound};
use wzvi::prelude::*;

fn kubo(h: f64, target: f64, seed: u64) -> Multilevel<'static, Kubo, Midpoint, Observed> {
    kubo_levels(h).seed(seed).until(1.0).observe("q", |state| state.q[0]).target(target)
}

/// `E q` of Kubo's oscillator after `steps` steps to `t = 1`: each turns `p + iq` by the factor `(1 + iθ)/(1 - iθ)` with
/// `θ = (a h + σ ΔW)/2`, whose mean is an integral; Simpson's rule, with the truncated increments of the run.
fn scheme_mean(h: f64) -> f64 {
    let (intervals, bound) = (8000, clip_bound(h, Truncation::DEFAULT));
    let mut sum = [0.0; 3];
    for i in 0..=intervals {
        let x = 20.0 * f64::from(i) / f64::from(intervals) - 10.0;
        let weight = if i == 0 || i == intervals { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
        let density = weight * (-0.5 * x * x).exp();
        let theta = 0.5 * (KUBO.a * h + KUBO.sigma * h.sqrt() * x.clamp(-bound, bound));
        let square = 1.0 + theta * theta;
        for (sum, value) in sum.iter_mut().zip([(2.0 - square) / square, 2.0 * theta / square, 1.0]) {
            *sum += density * value;
        }
    }
    let (re, im) = (sum[0] / sum[2], sum[1] / sum[2]);
    re.hypot(im).powf(1.0 / h) * (im.atan2(re) / h).sin()
}

/// The levels add up to the mean of the finest step size, with the standard error that is stated: 60 runs give a sum of squares of
/// 60 ± 11, and five such deviations are exceeded once in a million times.
#[test]
fn the_sum_is_unbiased_and_its_error_is_right() {
    let (runs, target, exact) = (60, 4e-3, (-0.5f64).exp() * 1.5f64.sin());
    let (mut scores, mut squares, mut met) = (0.0, 0.0, 0);
    for seed in 0..runs {
        let estimate = kubo(0.25, target, seed).run().unwrap();
        let finest = estimate.levels().last().unwrap();
        scores += ((estimate.mean() - scheme_mean(finest.h())) / estimate.standard_error()).powi(2);
        squares += (estimate.mean() - exact).powi(2);
        met += u32::from(estimate.met_target() && estimate.error() <= 1.01 * target);
        assert!(!estimate.is_partial());
    }
    let runs = runs as f64;
    println!("sum of squares {scores:.1}, root mean square error {:.1e}", (squares / runs).sqrt());
    assert!((scores - runs).abs() < 5.0 * (2.0 * runs).sqrt(), "{scores}");
    // A mean of 60 squares is below `target²` unless it is 5 deviations of √(2/60) off.
    assert!(squares / runs < target * target * (1.0 + 5.0 * (2.0 / runs).sqrt()), "{squares}");
    assert_eq!(f64::from(met), runs);
}

/// Each level on its own: the fine paths of level `l` and the coarse ones of level `l + 1` have the same mean, that of the step
/// size; five standard errors.
#[test]
fn every_level_has_the_mean_of_its_step_size() {
    let estimate = kubo(0.5, 1e-3, 5).run().unwrap();
    println!("{estimate}");
    assert!(estimate.levels().len() >= 5);
    for (number, level) in estimate.levels().iter().enumerate() {
        let error = (level.fine_variance() / level.paths() as f64).sqrt();
        assert!((level.fine_mean() - scheme_mean(level.h())).abs() < 5.0 * error);
        if number > 0 {
            let exact = scheme_mean(level.h()) - scheme_mean(2.0 * level.h());
            let error = (level.variance() / level.paths() as f64).sqrt();
            assert!(
                (level.mean() - exact).abs() < 5.0 * error,
                "{number}: {} for {exact} ± {error}",
                level.mean()
            );
        }
    }
    // The slope of their logarithms is a sum with known weights, so that it has a known error.
    let differences = estimate.levels()[1..].iter().map(|level| {
        let exact = (scheme_mean(level.h()) - scheme_mean(2.0 * level.h())).abs();
        [level.h().ln(), exact.ln(), (level.variance() / level.paths() as f64).sqrt() / exact]
    });
    let differences: Vec<[f64; 3]> = differences.collect();
    let centre = differences.iter().map(|[x, ..]| x).sum::<f64>() / differences.len() as f64;
    let size: f64 = differences.iter().map(|[x, ..]| (x - centre).powi(2)).sum();
    let slope: f64 = differences.iter().map(|[x, y, _]| (x - centre) / size * y).sum();
    let error = differences.iter().map(|[x, _, e]| ((x - centre) / size * e).powi(2)).sum::<f64>().sqrt();
    let found = estimate.mean_slope().unwrap();
    println!("{found} for {slope} ± {error}");
    assert!(error < 0.2 && (found - slope).abs() < 5.0 * error, "{found} for {slope} ± {error}");
}

/// Strong order one: variances fall by four from level to level.
#[test]
fn variances_fall_with_twice_the_strong_order() {
    let estimate = kubo(0.125, 2.5e-4, 1).run().unwrap();
    println!("{estimate}");
    let finest = estimate.levels();
    for pair in finest[1..].windows(2) {
        let factor = pair[0].variance() / pair[1].variance();
        // A variance of n samples of kurtosis κ is known to √((κ - 1)/n): with κ < 9 and n >= 256 to 18 %, two of them to 25 %.
        // Four such, and the next order in h, are what is allowed for the finest.
        let known = (8.0 / pair[1].paths() as f64 + 8.0 / pair[0].paths() as f64).sqrt();
        let next_order = 4.0 * pair[0].h();
        assert!((factor / 4.0 - 1.0).abs() < 4.0 * known + next_order, "{factor}, {known}");
    }
    let slope = estimate.variance_slope().unwrap();
    assert!((1.8..2.2).contains(&slope), "{slope}");
    // Less work than paths of the finest step size alone.
    assert!(estimate.plain_cost() > 10.0 * estimate.cost() as f64);
}

/// `E H(t) = H(0) + (σ² + γ²) t / 2`. The scheme turns and shifts; its energy grows by the mean square of the shift, which is what
/// the system has but for order `h²`.
#[test]
fn additive_noise_heats_as_it_must() {
    let system = TwoAdditive { sigma: 0.5, gamma: -1.0 };
    let target = 4e-3;
    let (mut squares, runs) = (0.0, 20);
    for seed in 0..runs {
        let start = State::new([1.0], [0.0]);
        let run = system.multilevel::<Midpoint>(0.5).start(start).seed(seed).until(2.0);
        let estimate = run
            .observe("observable0", |state| 0.5 * (state.q[0].powi(2) + state.p[0].powi(2)))
            .target(target);
        let estimate = estimate.run().unwrap();
        assert!(estimate.met_target());
        squares += (estimate.mean() - (0.5 + 1.25)).powi(2);
    }
    let mean = squares / runs as f64;
    assert!(mean < target * target * (1.0 + 5.0 * (2.0 / runs as f64).sqrt()), "{}", mean.sqrt());
}

#[test]
fn every_split_gives_the_same_bits() {
    let well = DoubleWell { sigma: 0.3 };
    let run = || {
        let run = well.multilevel::<Midpoint>(0.125).start(State::new([1.0], [0.5])).seed(2).until(1.0);
        run.observe("observable0", |state| state.q[0] * state.p[0])
    };
    let one = run().threads(1).instructions(InstructionSet::Baseline).target(5e-3).run_in::<1>().unwrap();
    assert!(one.levels().len() >= 3 && one.met_target());
    for threads in [1, 2, 3] {
        for set in [InstructionSet::Baseline, InstructionSet::Avx2, InstructionSet::Avx512] {
            assert_eq!(run().threads(threads).instructions(set).target(5e-3).run().unwrap(), one);
        }
    }
    assert_eq!(run().target(5e-3).run_in::<4>().unwrap(), one);
    let other = run().seed(3).target(5e-3).run().unwrap();
    assert_ne!(other.mean(), one.mean());
}

/// Optimised builds only have loops for each set of instructions.
#[test]
fn an_ensemble_has_the_same_bits_on_every_set_of_instructions() {
    let run = || {
        let run = kubo_run(0.05).seed(9).until(1.0).paths(1101);
        run.observe("q", |state| state.q[0]).record_every(7).keep_paths(1 << 20)
    };
    let one = run().threads(1).instructions(InstructionSet::Baseline).run().unwrap();
    for set in [InstructionSet::Avx2, InstructionSet::Avx512] {
        assert!(run().threads(2).instructions(set).run().unwrap() == one, "{set:?}");
    }
}

/// Level 0 is the ensemble with the same seed; finer levels have their own normals.
#[test]
fn the_coarsest_level_is_the_ensemble() {
    let estimate = kubo(0.25, 1e-2, 9).run().unwrap();
    let run = |h: f64, paths| {
        let run = kubo_run(h).seed(9).until(1.0);
        run.paths(paths).observe("q", |state| state.q[0]).run().unwrap().mean("q").unwrap()
    };
    let levels = estimate.levels();
    let same = run(levels[0].h(), levels[0].paths());
    assert_eq!(levels[0].mean(), same);
    assert!((levels[1].fine_mean() - run(levels[1].h(), levels[1].paths())).abs() > 1e-4);
}

#[test]
fn a_path_that_fails_is_an_error_with_its_level() {
    let edge = Edge { a: 1.0, sigma: 0.4 };
    let run = || edge.multilevel::<DeltaPlus>(0.05).start(State::new([1.0], [0.0])).seed(4).until(1.0);
    let failures = edge.ensemble::<DeltaPlus>(0.05).start(State::new([1.0], [0.0])).seed(4).until(1.0);
    let failures = failures.paths(256).allow_losses(1.0).run().unwrap();
    let first = failures.failures()[0];
    for threads in [1, 3] {
        let outcome = run().threads(threads).observe("observable0", |state| state.q[0]).target(1e-2).run();
        let Err(Error::Level(error)) = outcome else { panic!("{outcome:?}") };
        let cause = LevelFailure::Step(first.error);
        assert_eq!(error, LevelError { level: 0, path: first.path, h: 0.05, cause });
        let text = Error::from(error).to_string();
        assert!(text.contains("level 0") && text.contains("smaller step size"), "{text}");
    }
    let logarithm = kubo_levels(0.25).seed(9).until(1.0);
    let outcome = logarithm.observe("observable0", |state| state.q[0].ln()).target(1e-2).run();
    let Err(Error::Level(LevelError { level: 0, cause: LevelFailure::NonFinite(value), .. })) = outcome
    else {
        panic!("{outcome:?}")
    };
    assert!(value.is_nan());
}

/// An observable that is undefined just beyond what the coarsest level reaches: the next level has normals of its own, and with some seed
/// goes farther.
#[test]
fn a_path_may_fail_on_a_finer_level_only() {
    let run = |seed| kubo_run(0.5).seed(seed).until(0.5);
    let found = (0..50).find_map(|seed| {
        let coarsest = run(seed).paths(1024).observe("q", |state| state.q[0]).quantiles().run().unwrap();
        let least = coarsest.quantile("q", 0.0).unwrap();
        let defined = move |state: &State<_>| {
            let state: &State<wzvi::nalgebra::SVector<f64, 1>> = state;
            if state.q[0] < least { f64::NAN } else { state.q[0] }
        };
        let levels = kubo_levels(0.5).seed(seed).until(0.5);
        levels.observe("q", defined).target(1e-2).run().err()
    });
    let Some(Error::Level(LevelError { level, h, cause, .. })) = found else { panic!("{found:?}") };
    assert!(
        level > 0 && (h == 0.5 / f64::from(1 << level) || h == 1.0 / f64::from(1 << level)),
        "{level} {h}"
    );
    assert!(matches!(cause, LevelFailure::NonFinite(value) if value.is_nan()));
}

#[test]
fn limits_are_kept_and_said() {
    let few = kubo_levels(0.25).seed(1).until(1.0).paths(1000);
    let estimate = few.observe("observable0", |state| state.q[0]).target(1e-3).run().unwrap();
    assert!(!estimate.met_target() && !estimate.is_partial());
    // In whole blocks.
    assert!(estimate.levels().iter().all(|level| level.paths() <= 1024), "{estimate}");
    let coarse = kubo(0.25, 1e-3, 1).finest(2).run().unwrap();
    assert!(!coarse.met_target() && coarse.levels().len() == 3 && coarse.bias() > 5e-4);
    assert!(coarse.to_string().contains("target not met"));
    let stopped = kubo_levels(0.25).seed(1).until(1.0);
    let stopped =
        stopped.stop_when(|| true).observe("observable0", |state| state.q[0]).target(1e-3).run().unwrap();
    assert!(stopped.is_partial() && stopped.mean().is_nan() && stopped.levels().is_empty());
}

#[test]
fn what_makes_no_sense_is_refused() {
    let base = || kubo_levels(0.25).seed(1).until(1.0);
    let q = |state: &State<_>| -> f64 {
        let state: &State<wzvi::nalgebra::SVector<f64, 1>> = state;
        state.q[0]
    };
    are_refused(base().observe("q", q).run(), "target");
    are_refused(base().observe("q", q).target(0.0).run(), "target");
    are_refused(base().observe("q", q).target(f64::NAN).run(), "target");
    are_refused(base().observe("q", q).target(1e-2).weak_order(-1.0).run(), "weak order");
    are_refused(base().observe("q", q).target(1e-2).finest(1).run(), "finest");
    are_refused(base().observe("q", q).target(1e-2).paths(0).run(), "paths");
    are_refused(base().observe("q", q).until(0.0).target(1e-2).run(), "step");
    are_refused(base().observe("q", q).threads(0).target(1e-2).run(), "threads");
    let unseeded = kubo_levels(0.25).until(1.0);
    are_refused(unseeded.observe("q", q).target(1e-2).run(), "seed");
    // Another time than asked for.
    let ends = |h: f64, end: f64| {
        let run = kubo_levels(h).seed(1).until(end);
        run.observe("q", q).target(2e-2).run()
    };
    are_refused(ends(0.3, 1.0), "1.2");
    assert!(ends(0.1, 0.3).is_ok() && ends(1.0 / 3.0, 1.0).is_ok());
}

/// A driven oscillator: its energy at the end is that of the end.
#[hamiltonian(drift = |q, p, t| 0.5 * (p * p + q * q) - q * (2.0 * t).cos(), noise = [|q, p| 0.1 * q], embedding = [Midpoint])]
pub struct Driven;

/// Observables are asked at the time of the state.
#[test]
fn observables_know_the_time() {
    let run =
        || Driven.multilevel::<Midpoint>(0.25).start(State { t: 0.5, ..State::new([1.0], [0.0]) }).seed(1);
    let time = run().until(2.0).paths(1024).observe("t", |state| state.t).target(1e-2).run().unwrap();
    assert_eq!(time.mean(), 2.0);
    let target = 5e-3;
    let levels =
        run().until(2.0).observe("energy", |state| Driven.energy(state)).target(target).run().unwrap();
    let finest = levels.levels().last().unwrap().h();
    let one = Driven.ensemble::<Midpoint>(finest).start(State { t: 0.5, ..State::new([1.0], [0.0]) }).seed(2);
    let one = one.until(2.0).paths(20_000).observe("energy", |state| Driven.energy(state)).run().unwrap();
    let error = one.standard_error("energy").unwrap().hypot(levels.standard_error());
    let (mean, expected) = (levels.mean(), one.mean("energy").unwrap());
    assert!((mean - expected).abs() < 5.0 * error, "{mean}, expected {expected} ± {error}");
    // At the time of the start it would be another one.
    let wrong =
        Driven.ensemble::<Midpoint>(finest).start(State { t: 0.5, ..State::new([1.0], [0.0]) }).seed(2);
    let at_start = |state: &State<_>| Driven.energy(&State { t: 0.5, ..*state });
    let wrong = wrong.until(2.0).paths(20_000).observe("energy", at_start).run().unwrap();
    assert!((wrong.mean("energy").unwrap() - expected).abs() > 50.0 * error);
}

/// An event with probability 0.001: none of the first 1024 paths of the coarsest level sees it for every third seed. Whoever believes the
/// variance of the others says zero, and is sure of it.
#[test]
fn rare_events_are_not_certain_to_be_absent() {
    // P(p(1) > 3.0902) for a Wiener process.
    let (exact, target, runs) = (1e-3, 2.5e-4, 20);
    let mut far = 0;
    for seed in 0..runs {
        let run = WALKER.multilevel::<Midpoint>(0.5).start(State::new([0.0], [0.0])).seed(seed).until(1.0);
        let estimate = run.observe("far", |state| f64::from(u8::from(state.p[0] > 3.0902))).target(target);
        let estimate = estimate.run().unwrap();
        assert!(estimate.met_target() && !estimate.is_constant(), "{estimate}");
        assert!(estimate.error_bound() >= estimate.standard_error());
        far += u32::from((estimate.mean() - exact).abs() > 1.96 * target);
    }
    // More than 6 of 20 with probability 0.06 each: 1e-4.
    assert!(far <= 6, "{far}");
}

/// What is the same on all paths has no error that is known.
#[test]
fn a_constant_is_not_certain() {
    let run = WALKER.multilevel::<Midpoint>(0.5).start(State::new([0.0], [0.0])).seed(1).until(1.0);
    let estimate =
        run.paths(5000).observe("never", |state| f64::from(u8::from(state.p[0] > 9.0))).target(1e-3);
    let estimate = estimate.run().unwrap();
    assert!(estimate.is_constant() && !estimate.met_target() && estimate.mean() == 0.0);
    assert!((5000..6100).contains(&estimate.levels()[0].paths()), "{estimate}");
    assert!(estimate.to_string().contains("the same on all paths"));
}

/// An ensemble that is asked for an error is the same run, and says what it cannot do in it.
#[test]
fn an_ensemble_becomes_a_multilevel_run() {
    let ensemble = || kubo_run(0.25).seed(3).until(1.0).observe("q", |state| state.q[0]);
    let begun = ensemble().multilevel(0.02).run().unwrap();
    let same = kubo(0.25, 0.02, 3).run().unwrap();
    assert_eq!((begun.mean(), begun.standard_error()), (same.mean(), same.standard_error()));
    let error = ensemble().antithetic().multilevel(0.02).run().unwrap_err().to_string();
    assert!(error.contains("`multilevel` has no use for `antithetic`"), "{error}");
}
