//! Runs that end by themselves: standard errors that are small enough, antithetic pairs, deadlines and Ctrl-C.

use fixtures::edge::Edge;
use fixtures::small::{Kubo, TwoAdditive, kubo_levels, kubo_run};
use fixtures::stepped::every_split;
use std::io::{BufRead as _, BufReader};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::sleep;
use std::time::{Duration, Instant};

use wzvi::ensemble::{Ensemble, Statistics, TargetStatus};
use wzvi::error::Error;
use wzvi::prelude::*;

fn kubo(seed: u64) -> Ensemble<'static, Kubo, Midpoint> {
    kubo_from_start(seed).until(1.0)
}

fn kubo_from_start(seed: u64) -> Ensemble<'static, Kubo, Midpoint> {
    let run = kubo_run(0.05).seed(seed);
    run.observe("q", |state| state.q[0]).observe("p", |state| state.p[0])
}

#[test]
fn a_run_ends_when_its_error_is_small_enough() {
    let run = || kubo(3).paths(1_000_000).until_error("q", 4e-3).until_error("p", 5e-3);
    let one = every_split(run);
    assert_eq!(one.met_targets(), Some(true));
    assert!(one.standard_error("q").unwrap() <= 4e-3 && one.standard_error("p").unwrap() <= 5e-3);
    let paths = one.last().unwrap().count();
    // A block earlier it was not.
    let before = kubo(3).paths(paths - 512).run().unwrap();
    assert!(before.error_bound("q").unwrap() > 4e-3 || before.error_bound("p").unwrap() > 5e-3);
    assert!(paths.is_multiple_of(512) && paths > 10_000 && paths < 40_000, "{paths}");
    // They are the first paths of the run without target.
    let given = kubo(3).paths(paths).run().unwrap();
    assert_eq!(given.nodes(), one.nodes());
    assert_eq!(given.met_targets(), None);
    assert!(!one.is_partial());

    let limited = kubo(3).paths(5000).until_error("q", 1e-4).run().unwrap();
    assert_eq!((limited.met_targets(), limited.last().unwrap().count()), (Some(false), 5000));
    let easy = kubo(3).paths(5000).until_error("q", 10.0).run().unwrap();
    assert_eq!((easy.met_targets(), easy.last().unwrap().count()), (Some(true), 1024));
}

#[test]
fn targets_that_make_no_sense_are_refused() {
    for run in [
        kubo(1).paths(10).until_error("x", 1e-3),
        kubo(1).paths(10).until_error("q", 0.0),
        kubo(1).paths(10).until_error("q", f64::NAN),
        kubo(1).paths(11).antithetic(),
        kubo(1).paths(10).antithetic().first_passage("event0", |state| state.q[0]),
    ] {
        assert!(matches!(run.run(), Err(Error::Config(_))));
    }
}

/// Linear dynamics, additive noise: the mean of a pair is the path without noise, the energy of both the same in the mean.
#[test]
fn odd_observables_have_their_exact_mean() {
    let system = TwoAdditive { sigma: 0.3, gamma: -0.8 };
    let run =
        || system.ensemble::<Midpoint>(0.1).start(State::new([1.0], [0.0])).paths(4096).seed(5).steps(33);
    let paired = run().antithetic().run().unwrap();
    let quiet = TwoAdditive { sigma: 0.0, gamma: -0.0 };
    let quiet =
        quiet.ensemble::<Midpoint>(0.1).start(State::new([1.0], [0.0])).paths(1).seed(5).steps(33).run();
    for name in ["q", "p"] {
        // 33 steps and 4096 additions round by 1e-16 each, mostly to both sides.
        assert!(
            (paired.mean(name).unwrap() - quiet.as_ref().unwrap().mean(name).unwrap()).abs() < 1e-14,
            "{name}"
        );
        assert!(
            paired.standard_error(name).unwrap() < 1e-15 && paired.variance(name).unwrap() > 0.5,
            "{name}"
        );
    }
    // Of an even one both paths say the same where the start is zero: half as many samples.
    let even = |run: Ensemble<'_, TwoAdditive, Midpoint>| {
        run.start(State::new([0.0], [0.0])).observe("q²", |state| state.q[0] * state.q[0]).run().unwrap()
    };
    let (alone, paired) = (even(run()), even(run().antithetic()));
    let ratio = paired.standard_error("q²").unwrap() / alone.standard_error("q²").unwrap();
    // χ² of 4096 and 2048 samples: each variance of q⁴-like samples to √(56/4/2048) = 8 %, the error to half of that, four times.
    assert!((ratio / 2f64.sqrt() - 1.0).abs() < 0.2, "{ratio}");
    assert_eq!(paired.last().unwrap().count(), 4096);

    // Both paths of a pair from zero are each other's negatives, to the bit: the error is zero, and a target is met as soon as any can
    // be. Something that no path changes stays unknown.
    let exact = run()
        .antithetic()
        .paths(1 << 20)
        .start(State::new([0.0], [0.0]))
        .observe("q", |state| state.q[0])
        .observe("never", |state| f64::from(state.q[0] > 1e9))
        .until_error("q", 1e-3)
        .until_error("never", 1e-3);
    let exact = exact.paths(2048).run().unwrap();
    assert_eq!(exact.target("never").unwrap(), TargetStatus::Constant);
    assert_eq!(exact.target("q").unwrap(), TargetStatus::Met);
    // The mean over all paths is rounded as it comes.
    assert!(exact.mean("q").unwrap().abs() < 1e-15 && exact.error_bound("q").unwrap() == 0.0);
    assert!(exact.error_bound("never").unwrap().is_nan() && exact.standard_error("never").unwrap() == 0.0);
    let exact =
        run().antithetic().paths(1 << 20).start(State::new([0.0], [0.0])).observe("q", |state| state.q[0]);
    let exact = exact.until_error("q", 1e-3).run().unwrap();
    assert_eq!((exact.met_targets(), exact.last().unwrap().count()), (Some(true), 1024));
}

/// Variances of few antithetic paths have no bias, whatever the correlation within pairs: here of 6 paths in 3 pairs, over many runs.
/// The divisor `n - 1` of independent paths gives 6/5 of the variance of an odd observable, 4/5 of that of an even one.
#[test]
fn variances_of_pairs_are_unbiased() {
    let system = TwoAdditive { sigma: 0.3, gamma: -0.8 };
    let run = |paths: u64, seed| {
        let run =
            system.ensemble::<Midpoint>(0.1).start(State::new([0.0], [0.0])).paths(paths).seed(seed).steps(3);
        run.observe("odd", |state| state.q[0])
            .observe("even", |state| state.q[0].powi(2))
            .observe("both", |state| state.q[0].exp())
    };
    let many = run(100_000, 1).run().unwrap();
    let runs: Vec<Statistics> = (2..4002).map(|seed| run(6, seed).antithetic().run().unwrap()).collect();
    for (a, b) in [("odd", "odd"), ("even", "even"), ("both", "both"), ("odd", "both"), ("even", "both")] {
        let estimates: Vec<f64> =
            runs.iter().map(|run| run.covariance(a, b).unwrap() / many.covariance(a, b).unwrap()).collect();
        let n = estimates.len() as f64;
        let mean = estimates.iter().sum::<f64>() / n;
        let error = (estimates.iter().map(|x| (x - mean).powi(2)).sum::<f64>()).sqrt() / n;
        println!("{a} {b}: {mean} ± {error}");
        // Four standard errors; the reference is known to √(2/100 000) of itself, and three times that where squares are observed.
        assert!((mean - 1.0).abs() < 4.0 * error + 0.015 && error < 0.04, "{a} {b}: {mean} ± {error}");
    }
}

/// Neither odd nor even: over 200 runs, deviations from the common mean in units of the standard error have squares that add up
/// to 199 ± 20; five such. The error of independent paths would be off by the correlation within pairs.
#[test]
fn the_error_of_pairs_is_their_own() {
    let runs: Vec<Statistics> =
        (0..200).map(|seed| kubo(seed).until(0.5).paths(512).antithetic().run().unwrap()).collect();
    for (index, name) in ["q", "p"].into_iter().enumerate() {
        let n = runs.len() as f64;
        let mean = runs.iter().map(|run| run.mean(name).unwrap()).sum::<f64>() / n;
        let score = |error: fn(&Statistics, usize) -> f64| -> f64 {
            runs.iter().map(|run| ((run.mean(name).unwrap() - mean) / error(run, index)).powi(2)).sum()
        };
        let paired = score(|run, index| run.last().unwrap().standard_error(index));
        let independent = score(|run, index| {
            (run.last().unwrap().variance(index) / run.last().unwrap().count() as f64).sqrt()
        });
        println!("{name}: {paired:.0}, as independent paths {independent:.0}");
        assert!((paired - (n - 1.0)).abs() < 5.0 * (2.0 * n).sqrt(), "{name}: {paired}");
        assert!((independent - (n - 1.0)).abs() > 5.0 * (2.0 * n).sqrt(), "{name}: {independent}");
    }
}

#[test]
fn pairs_are_the_same_in_every_split() {
    let run = || kubo(8).paths(1234).antithetic().record_every(7).quantiles();
    let one = run().threads(1).run_in::<2>().unwrap();
    for threads in [1, 3, 8] {
        assert!(run().threads(threads).run().unwrap() == one);
    }
    assert!(run().run_in::<8>().unwrap() == one);
    assert!(matches!(run().run_in::<1>(), Err(Error::Config(_))));
    // Path 2k is path k of the run without pairs.
    let (paired, alone) = (
        kubo(8).paths(40).antithetic().keep_paths(10_000).run().unwrap(),
        kubo(8).paths(20).keep_paths(10_000).run().unwrap(),
    );
    let (paired, alone) = (paired.paths().unwrap(), alone.paths().unwrap());
    for path in 0..20 {
        assert_eq!(paired.at(2 * path, 1), alone.at(path, 1));
        assert_ne!(paired.at(2 * path + 1, 1), alone.at(path, 1));
    }
}

/// A pair of which one path failed does not count for the error, and disturbs nobody.
#[test]
fn a_pair_may_lose_a_path() {
    let edge = Edge { a: 1.0, sigma: 0.4 };
    let run = || {
        edge.ensemble::<DeltaPlus>(0.05)
            .start(State::new([1.0], [0.0]))
            .paths(600)
            .seed(4)
            .until(1.0)
            .antithetic()
            .allow_losses(1.0)
            .observe("q0", |state| state.q[0])
    };
    let one = run().run_in::<2>().unwrap();
    assert!(one.failed() > 10 && one.failed() < 500, "{}", one.failed());
    assert!(run().run().unwrap() == one && run().threads(3).run_in::<4>().unwrap() == one);
    assert!(one.standard_error("q0").unwrap().is_finite());
}

/// What a stopped run knows is what the same number of paths gives, bit for bit.
#[test]
fn a_stopped_run_keeps_what_is_done() {
    for threads in [1, 3] {
        let asked = AtomicU64::new(0);
        let run = kubo(2).paths(100_000_000).threads(threads);
        let partial = run.stop_when(|| asked.fetch_add(1, Ordering::Relaxed) > 1000).run().unwrap();
        assert!(partial.is_partial());
        let paths = partial.last().unwrap().count();
        assert!(paths.is_multiple_of(64) && paths < 100_000, "{paths}");
        let whole = kubo(2).paths(paths).run().unwrap();
        assert_eq!(whole.nodes(), partial.nodes());
        assert!(!whole.is_partial());
    }
    let nothing = kubo(2).paths(1000).stop_when(|| true).run().unwrap();
    assert!(nothing.is_partial() && nothing.mean("q").unwrap().is_nan());
}

/// Steps by the million: a block takes minutes, but a stop does not wait for it.
#[test]
fn a_stop_does_not_wait_for_a_block() {
    let start = Instant::now();
    let end = || start.elapsed() > Duration::from_millis(50);
    let run = kubo_from_start(2).paths(1_000_000).steps(1 << 40).stop_when(end).run().unwrap();
    assert!(run.is_partial());
}

/// Another thread hears how far the run is, and ends it; what begins later with the same handle ends at once.
#[test]
fn a_handle_stops_from_another_thread() {
    let reports = Arc::new(AtomicU64::new(0));
    let counts = Arc::clone(&reports);
    let handle = Handle::reporting(move |progress| {
        assert!(progress.done <= progress.all && progress.all == 1 << 40);
        counts.fetch_add(1, Ordering::Relaxed);
    });
    let run = std::thread::scope(|scope| {
        scope.spawn(|| {
            while handle.progress().done < 1000 {
                sleep(Duration::from_millis(1));
            }
            handle.stop();
        });
        kubo(2).paths(1 << 40).handle(&handle).run().unwrap()
    });
    let done = run.last().unwrap().count();
    assert!(run.is_partial() && done >= 1000 && reports.load(Ordering::Relaxed) > 0, "{done}");
    assert_eq!(run.mean("q"), kubo(2).paths(done).run().unwrap().mean("q"));
    let later = kubo(2).paths(1000).handle(&handle).run().unwrap();
    assert!(later.is_partial() && later.last().unwrap().count() == 0);
    let levels = kubo_levels(0.1).seed(1).until(1.0);
    let levels = levels.observe("q", |state| state.q[0]).target(1e-9).handle(&handle).run().unwrap();
    assert!(levels.is_partial() && levels.levels().is_empty());
}

const CHILD: &str = "WZVI_TEST_CONTROL";

/// Minutes of work, unless it is stopped; says so on standard output when it has begun.
#[test]
#[ignore = "the process that other tests start"]
fn child() {
    let Ok(order) = std::env::var(CHILD) else { return };
    let begun = AtomicBool::new(false);
    let paths = if order == "short" { 3_000_000 } else { 2_000_000_000 };
    let run = kubo(2).paths(paths).observe("observable0", move |state| state.q[0]).stop_when(|| {
        if !begun.swap(true, Ordering::Relaxed) {
            println!("begun");
        }
        false
    });
    let run = run.handle(&Handle::new().on_interrupt());
    let run = if order == "quiet" { run.quiet() } else { run };
    let run = run.run().unwrap();
    println!(
        "partial {} paths {} mean {}",
        run.is_partial(),
        run.last().unwrap().count(),
        run.mean("q").unwrap()
    );
}

/// GNU's `env` alone knows it.
const DEFAULT_SIGNAL: &[&str] = if cfg!(target_os = "linux") { &["--default-signal=INT"] } else { &[] };

/// Under `env`, because who starts the tests may ignore Ctrl-C, and children inherit that.
fn command(order: &str) -> Command {
    let mut command = Command::new("env");
    command.args(DEFAULT_SIGNAL).arg(std::env::current_exe().unwrap());
    command.args(["control::child", "--exact", "--ignored", "--nocapture"]).env(CHILD, order);
    command
}

/// A real Ctrl-C: the statistics are those of the paths that were done, and nothing was written to a standard error that is a pipe.
#[cfg(unix)]
#[test]
fn control_c_gives_the_statistics_so_far() {
    let mut child = command("long").stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines().map(Result::unwrap);
    assert!(lines.any(|line| line.contains("begun")));
    // Time for some paths.
    sleep(Duration::from_millis(500));
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    let last: Vec<String> = lines.collect();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success());
    let line = last.iter().find(|line| line.contains("partial")).unwrap();
    let words: Vec<&str> = line[line.find("partial").unwrap()..].split_whitespace().collect();
    let paths: u64 = words[3].parse().unwrap();
    assert_eq!(words[1], "true");
    assert!(paths > 0 && paths.is_multiple_of(64), "{line}");
    // `f64` prints and reads without loss.
    assert_eq!(kubo(2).paths(paths).run().unwrap().mean("q").unwrap(), words[5].parse::<f64>().unwrap());
    assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// On a terminal, which `script` makes, there is a line of progress; with `quiet` there is none.
#[cfg(target_os = "linux")]
#[test]
fn a_terminal_shows_progress() {
    for (order, shows) in [("long", true), ("quiet", false)] {
        let exe = std::env::current_exe().unwrap();
        // Its shell becomes the test, so that the signal of `timeout` gets there.
        let inner = format!(
            "exec env --default-signal=INT timeout --foreground -s INT 2 '{}' control::child --exact --ignored --nocapture",
            exe.display()
        );
        let mut terminal = Command::new("script")
            .args(["-qec", &inner, "/dev/null"])
            .env(CHILD, order)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        // Open until the end: `script` may leave when its input ends.
        let input = terminal.stdin.take();
        let output = terminal.wait_with_output().unwrap();
        drop(input);
        let text = String::from_utf8_lossy(&output.stdout);
        assert_eq!(text.contains("paths/s") && text.contains(" left"), shows, "{text}");
        assert!(text.contains("partial true"), "{text}");
        // The line is gone in the end.
        if shows {
            let (last, end) = (text.rfind("paths/s").unwrap(), text.rfind("\x1b[K").unwrap());
            assert!(end > last, "{text}");
        }
    }
}

/// Where losses are not allowed they are an error that keeps what is known.
#[test]
fn losses_are_said() {
    let edge = Edge { a: 1.0, sigma: 0.4 };
    let run =
        || edge.ensemble::<DeltaPlus>(0.05).start(State::new([1.0], [0.0])).paths(600).seed(4).until(1.0);
    let Err(Error::Losses(error)) = run().until_error("q", 10.0).run() else { panic!("no error") };
    assert_eq!((error.begun, error.allowed), (600, 0.01));
    assert!(error.failed > 6 && error.statistics.failed() == error.failed);
    assert_eq!(error.first, error.statistics.failures()[0]);
    let text = error.to_string();
    assert!(text.contains(&format!("{} of 600", error.failed)) && text.contains("Retry::halving"), "{text}");
    let allowed = run().allow_losses(1.0).record_every(10).run().unwrap();
    for node in allowed.nodes() {
        assert_eq!(node.count() + node.lost(), 600);
    }
    let lost = allowed.last().unwrap().lost();
    assert_eq!(lost, allowed.failed());
    let text = allowed.to_string();
    assert_eq!(text.matches(&format!("({lost} lost)")).count(), 3, "{text}");
    assert!(matches!(run().allow_losses(1.5).run(), Err(Error::Config(_))));
}

/// An event that no path shows has a status of its own, however small its variance.
#[test]
fn what_never_happens_is_not_met() {
    let never = |state: &State<wzvi::nalgebra::SVector<f64, 1>>| f64::from(u8::from(state.q[0] > 2.0));
    let run =
        kubo(3).observe("never", never).paths(3000).until_error("never", 0.1).until_error("q", 0.1).run();
    let run = run.unwrap();
    assert_eq!((run.met_targets(), run.last().unwrap().count()), (Some(false), 3000));
    assert_eq!(run.target("never").unwrap(), TargetStatus::Constant);
    assert_eq!(run.target("q").unwrap(), TargetStatus::Met);
    assert!(run.target("p").is_err() && run.to_string().contains("the same on all paths"));
}

/// A name that does not exist is an error that lists those that do.
#[test]
fn unknown_names_are_errors() {
    let run = kubo(3).paths(4).first_passage("rise", |state| state.q[0] - 0.5).run().unwrap();
    let texts = [
        run.mean("typo").unwrap_err().to_string(),
        run.covariance("q", "typo").unwrap_err().to_string(),
        run.histogram("typo").unwrap_err().to_string(),
    ];
    for text in texts {
        assert!(text.contains("`typo`") && text.contains("`q`, `p`"), "{text}");
    }
    assert!(run.passage("typo").unwrap_err().to_string().contains("`rise`"));
    assert!(run.quantile("q", 0.5).unwrap_err().to_string().contains(".quantiles()"));
    assert!(run.histogram("q").unwrap_err().to_string().contains(".histogram("));
    let lean = kubo(3).paths(4).covariances(false).run().unwrap();
    assert!(lean.covariance("q", "p").unwrap_err().to_string().contains(".covariances(true)"));
    assert_eq!(lean.variance("q"), run.variance("q"));
    assert_eq!(fixtures::table(&lean.tables(), "covariances").rows(), 2 * 2);
}

/// More than memory holds is refused before it is asked for.
#[test]
fn statistics_beyond_memory_are_refused() {
    let many = || {
        let run = kubo(1).paths(4).record_every(1);
        (0..4000).fold(run, |run, i| run.observe(format!("o{i}"), |state| state.q[0]))
    };
    let Err(Error::Config(error)) = many().run() else { panic!("no error") };
    assert!(error.to_string().contains(".covariances(false)"), "{error}");
    assert_eq!(many().covariances(false).record_every(0).run().unwrap().observables().len(), 4002);
    assert!(matches!(kubo(1).paths(4).histogram("q", 0.0, 1.0, 1 << 40).run(), Err(Error::Config(_))));
}

/// A run whose observables are slow hears a stop between two of them: without, all paths of a chunk would come first.
#[test]
fn slow_observables_hear_a_stop() {
    let observed = AtomicU64::new(0);
    let slow = |state: &State<wzvi::nalgebra::SVector<f64, 1>>| {
        // As long as the scheduler waits between two questions.
        sleep(Duration::from_millis(10));
        observed.fetch_add(1, Ordering::Relaxed);
        state.q[0]
    };
    let run = kubo(1).observe("slow", slow).paths(5120).threads(1);
    let run = run.stop_when(|| observed.load(Ordering::Relaxed) >= 20).run().unwrap();
    let observed = observed.load(Ordering::Relaxed);
    assert!(run.is_partial() && (20..256).contains(&observed), "{observed} observations");
}
