//! What a generated step costs against one written by hand for the same job.
//!
//! `cargo bench --workspace --bench instructions` runs every scene in this process for the time of a step, and again under
//! `valgrind --tool=callgrind` for the number of its instructions: two runs of different length, so that everything
//! outside of the loop cancels. Without valgrind the counts are left out. `-- --check` fails where a generated step
//! takes more than 1.1 times the instructions of the one by hand.

#![allow(clippy::unwrap_used, reason = "a benchmark stops at the first error")]

mod by_hand;
mod scenes;

use std::process::{Command, ExitCode};
use std::time::Instant;

use scenes::{Case, Outcome};

const COUNTED_STEPS: u64 = 4_000;
const TIMED_STEPS: u64 = 200_000;
const REPETITIONS: usize = 15;
const ALLOWED_RATIO: f64 = 1.1;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [flag, case, steps] = arguments.as_slice()
        && flag == "--run"
    {
        let case = scenes::CASES.iter().find(|known| known.name == case);
        if let (Some(case), Ok(steps)) = (case, steps.parse()) {
            std::hint::black_box((case.run)(steps));
            return ExitCode::SUCCESS;
        }
        return ExitCode::FAILURE;
    }
    let only = arguments.iter().find(|argument| !argument.starts_with("--"));
    let is_wanted = |case: &&Case| only.is_none_or(|only| case.name.contains(only.as_str()));
    let mut failed = false;
    println!("{:34}{:>10}{:>8}{:>10}{:>8}{:>9}", "case", "instr", "ratio", "ns", "ratio", "Newton");
    for pair in scenes::PAIRS {
        let cases: Vec<&Case> =
            pair.iter().filter_map(|name| scenes::CASES.iter().find(|c| c.name == *name)).collect();
        if !cases.iter().any(is_wanted) {
            continue;
        }
        let outcomes: Vec<Outcome> = cases.iter().map(|case| (case.run)(1_000)).collect();
        let counts: Vec<Option<f64>> = cases.iter().map(|case| instructions(case.name)).collect();
        let times = nanoseconds(&cases);
        // The one by hand comes last.
        let last = cases.len() - 1;
        for (i, case) in cases.iter().enumerate() {
            let ratio = counts[i].zip(counts[last]).map(|(count, by_hand)| count / by_hand);
            failed |= ratio.is_some_and(|ratio| ratio > ALLOWED_RATIO);
            println!(
                "{:34}{:>10}{:>8}{:>10.2}{:>8.2}{:>9.2}",
                case.name,
                counts[i].map_or("-".into(), |count| format!("{count:.1}")),
                ratio.map_or("-".into(), |ratio| format!("{ratio:.2}")),
                times[i],
                times[i] / times[last],
                outcomes[i].iterations as f64 / 1_000.0,
            );
            let apart = outcomes[i].distance(&outcomes[last]);
            assert!(apart < 1e-11, "{} ends {apart:.1e} away from the one by hand", case.name);
        }
    }
    if failed && arguments.iter().any(|argument| argument == "--check") {
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}

/// Median time of a step, the cases taking turns.
fn nanoseconds(cases: &[&Case]) -> Vec<f64> {
    let mut samples = vec![Vec::new(); cases.len()];
    for _ in 0..REPETITIONS {
        for (case, samples) in cases.iter().zip(&mut samples) {
            let start = Instant::now();
            std::hint::black_box((case.run)(TIMED_STEPS));
            samples.push(start.elapsed().as_secs_f64() * 1e9 / TIMED_STEPS as f64);
        }
    }
    let median = |mut samples: Vec<f64>| {
        samples.sort_by(f64::total_cmp);
        samples[samples.len() / 2]
    };
    samples.into_iter().map(median).collect()
}

/// Instructions of a step as callgrind counts them.
fn instructions(case: &str) -> Option<f64> {
    let short = callgrind(case, COUNTED_STEPS)?;
    let long = callgrind(case, 2 * COUNTED_STEPS)?;
    Some((long - short) / COUNTED_STEPS as f64)
}

fn callgrind(case: &str, steps: u64) -> Option<f64> {
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(std::env::current_exe().ok()?)
        .args(["--run", case, &steps.to_string()])
        .output()
        .ok()?;
    let report = String::from_utf8_lossy(&output.stderr);
    let (_, collected) = report.split_once("Collected :")?;
    collected.split_whitespace().next()?.parse().ok()
}
