//! Runs that end by themselves: standard errors that are small enough, antithetic pairs, deadlines and Ctrl-C.

#![cfg(feature = "ensemble")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that unwraps says what it expects")]
#![allow(missing_docs, reason = "test systems")]

use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::sleep;
use std::time::{Duration, Instant};

use wzvi::ensemble::{Ensemble, InstructionSet, Statistics};
use wzvi::error::Error;
use wzvi::prelude::*;

#[hamiltonian(
    drift = |q, p| 0.5 * a * (q * q + p * p),
    noise = [|q, p| 0.5 * sigma * (q * q + p * p)],
    embedding = [Midpoint],
)]
pub struct Kubo {
    pub a: f64,
    pub sigma: f64,
}

const KUBO: Kubo = Kubo { a: 1.5, sigma: 1.0 };

#[hamiltonian(
    drift = |q, p| 0.5 * (q * q + p * p),
    noise = [|q, p| sigma * p, |q, p| gamma * q],
    embedding = [Midpoint],
)]
pub struct Additive {
    pub sigma: f64,
    pub gamma: f64,
}

/// Undefined for negative `q`, where some paths go.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + q * q.sqrt(),
    noise = [|q, p| -s * q],
    embedding = [DeltaPlus],
)]
pub struct Edge {
    pub s: f64,
}

fn kubo(seed: u64) -> Ensemble<'static, Kubo, Midpoint> {
    let run = KUBO.ensemble::<Midpoint>(0.05).start(State::new([0.0], [1.0])).seed(seed).until(1.0);
    run.observe(|state| state.q[0]).named("q").observe(|state| state.p[0]).named("p")
}

#[test]
fn a_run_ends_when_its_error_is_small_enough() {
    let run = || kubo(3).paths(1_000_000).until_error("q", 4e-3).until_error("p", 5e-3);
    let one = run().threads(1).instructions(InstructionSet::Baseline).run_in::<1>().unwrap();
    assert_eq!(one.met_targets(), Some(true));
    assert!(one.standard_error("q") <= 4e-3 && one.standard_error("p") <= 5e-3);
    let paths = one.last().unwrap().count();
    // A block earlier it was not.
    let before = kubo(3).paths(paths - 512).run().unwrap();
    assert!(before.standard_error("q") > 4e-3 || before.standard_error("p") > 5e-3);
    assert!(paths % 512 == 0 && paths > 10_000 && paths < 40_000, "{paths}");
    for threads in [1, 2, 5] {
        assert!(run().threads(threads).run().unwrap() == one);
    }
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
        kubo(1).paths(10).antithetic().first_passage(|state| state.q[0]),
    ] {
        assert!(matches!(run.run(), Err(Error::Config(_))));
    }
}

/// Linear dynamics, additive noise: the mean of a pair is the path without noise, the energy of both the same in the mean.
#[test]
fn odd_observables_have_their_exact_mean() {
    let system = Additive { sigma: 0.3, gamma: 0.8 };
    let run =
        || system.ensemble::<Midpoint>(0.1).start(State::new([1.0], [0.0])).paths(4096).seed(5).steps(33);
    let paired = run().antithetic().run().unwrap();
    let quiet = Additive { sigma: 0.0, gamma: 0.0 };
    let quiet =
        quiet.ensemble::<Midpoint>(0.1).start(State::new([1.0], [0.0])).paths(1).seed(5).steps(33).run();
    for name in ["q0", "p0"] {
        // 33 steps and 4096 additions round by 1e-16 each, mostly to both sides.
        assert!((paired.mean(name) - quiet.as_ref().unwrap().mean(name)).abs() < 1e-14, "{name}");
        assert!(paired.standard_error(name) < 1e-15 && paired.variance(name) > 0.5, "{name}");
    }
    // Of an even one both paths say the same where the start is zero: half as many samples.
    let even = |run: Ensemble<'_, Additive, Midpoint>| {
        run.start(State::new([0.0], [0.0]))
            .observe(|state| state.q[0] * state.q[0])
            .named("q²")
            .run()
            .unwrap()
    };
    let (alone, paired) = (even(run()), even(run().antithetic()));
    let ratio = paired.standard_error("q²") / alone.standard_error("q²");
    // χ² of 4096 and 2048 samples: each variance of q⁴-like samples to √(56/4/2048) = 8 %, the error to half of that, four times.
    assert!((ratio / 2f64.sqrt() - 1.0).abs() < 0.2, "{ratio}");
    assert_eq!(paired.last().unwrap().count(), 4096);
}

/// Neither odd nor even: over 200 runs, deviations from the common mean in units of the standard error have squares that add up
/// to 199 ± 20; five such. The error of independent paths would be off by the correlation within pairs.
#[test]
fn the_error_of_pairs_is_their_own() {
    let runs: Vec<Statistics> =
        (0..200).map(|seed| kubo(seed).until(0.5).paths(512).antithetic().run().unwrap()).collect();
    for (index, name) in ["q", "p"].into_iter().enumerate() {
        let n = runs.len() as f64;
        let mean = runs.iter().map(|run| run.mean(name)).sum::<f64>() / n;
        let score = |error: fn(&Statistics, usize) -> f64| -> f64 {
            runs.iter().map(|run| ((run.mean(name) - mean) / error(run, index)).powi(2)).sum()
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
    let one = run().threads(1).instructions(InstructionSet::Baseline).run_in::<2>().unwrap();
    for threads in [1, 3] {
        for set in [InstructionSet::Baseline, InstructionSet::Avx2, InstructionSet::Avx512] {
            assert!(run().threads(threads).instructions(set).run().unwrap() == one);
        }
    }
    assert!(run().run_in::<4>().unwrap() == one);
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
    let edge = Edge { s: 0.4 };
    let run = || {
        edge.ensemble::<DeltaPlus>(0.05)
            .start(State::new([1.0], [0.0]))
            .paths(600)
            .seed(4)
            .until(1.0)
            .antithetic()
            .observe(|state| state.q[0])
            .named("q0")
    };
    let one = run().run_in::<2>().unwrap();
    assert!(one.failed() > 10 && one.failed() < 500, "{}", one.failed());
    assert!(run().run().unwrap() == one && run().threads(3).run_in::<4>().unwrap() == one);
    assert!(one.standard_error("q0").is_finite());
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
        assert!(paths % 512 == 0 && paths < 100_000, "{paths}");
        let whole = kubo(2).paths(paths).run().unwrap();
        assert_eq!(whole.nodes(), partial.nodes());
        assert!(!whole.is_partial());
    }
    let nothing = kubo(2).paths(1000).stop_when(|| true).run().unwrap();
    assert!(nothing.is_partial() && nothing.mean("q").is_nan());
}

/// Steps by the million: a block takes minutes, but a stop does not wait for it.
#[test]
fn a_stop_does_not_wait_for_a_block() {
    let start = Instant::now();
    let end = || start.elapsed() > Duration::from_millis(50);
    let run = kubo(2).paths(1_000_000).steps(1 << 40).stop_when(end).run().unwrap();
    assert!(run.is_partial() && start.elapsed() < Duration::from_secs(10));
}

const CHILD: &str = "WZVI_TEST_CONTROL";

/// Minutes of work, unless it is stopped; says so on standard output when it has begun.
#[test]
#[ignore = "the process that other tests start"]
fn child() {
    let Ok(order) = std::env::var(CHILD) else { return };
    let begun = AtomicBool::new(false);
    let paths = if order == "short" { 3_000_000 } else { 2_000_000_000 };
    let run = kubo(2).paths(paths).observe(move |state| state.q[0]).stop_when(|| {
        if !begun.swap(true, Ordering::Relaxed) {
            println!("begun");
        }
        false
    });
    let run = if order == "quiet" { run.quiet() } else { run };
    let run = run.run().unwrap();
    println!("partial {} paths {} mean {}", run.is_partial(), run.last().unwrap().count(), run.mean("q"));
}

/// GNU's `env` alone knows it.
const DEFAULT_SIGNAL: &[&str] = if cfg!(target_os = "linux") { &["--default-signal=INT"] } else { &[] };

/// Under `env`, because who starts the tests may ignore Ctrl-C, and children inherit that.
fn command(order: &str) -> Command {
    let mut command = Command::new("env");
    command.args(DEFAULT_SIGNAL).arg(std::env::current_exe().unwrap());
    command.args(["child", "--exact", "--ignored", "--nocapture"]).env(CHILD, order);
    command
}

/// A real Ctrl-C after a real second: the statistics are those of the paths that were done, and nothing was written to a standard
/// error that is a pipe.
#[cfg(all(unix, feature = "interrupt"))]
#[test]
fn control_c_gives_the_statistics_so_far() {
    let child = command("long").stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    sleep(Duration::from_millis(2500));
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).unwrap();
    let line = text.lines().find(|line| line.contains("partial")).unwrap();
    let words: Vec<&str> = line[line.find("partial").unwrap()..].split_whitespace().collect();
    let paths: u64 = words[3].parse().unwrap();
    assert_eq!(words[1], "true");
    assert!(paths > 0 && paths.is_multiple_of(512), "{line}");
    // `f64` prints and reads without loss.
    assert_eq!(kubo(2).paths(paths).run().unwrap().mean("q"), words[5].parse::<f64>().unwrap());
    assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// On a terminal, which `script` makes, there is a line of progress; with `quiet` there is none.
#[cfg(all(target_os = "linux", feature = "interrupt"))]
#[test]
fn a_terminal_shows_progress() {
    for (order, shows) in [("long", true), ("quiet", false)] {
        let exe = std::env::current_exe().unwrap();
        // Its shell becomes the test, so that the signal of `timeout` gets there.
        let inner = format!(
            "exec env --default-signal=INT timeout --foreground -s INT 3 '{}' child --exact --ignored --nocapture",
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
