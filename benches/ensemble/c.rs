//! The baselines in C, if there is a compiler.

use std::path::Path;
use std::process::Command;

/// Problem, nanoseconds per path and step with 8 lanes and with one, on one thread.
pub(crate) fn measure() -> Vec<(&'static str, f64, f64)> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("ensemble/hand_sde.c");
    let program = std::env::temp_dir().join(format!("wzvi-hand-sde-{}", std::process::id()));
    let options = "-O3 -march=native -mprefer-vector-width=512 -D_GNU_SOURCE -fopenmp -w -o";
    let compiled = Command::new("gcc").args(options.split(' ')).arg(&program).arg(source).arg("-lm").status();
    if !compiled.is_ok_and(|status| status.success()) {
        println!("no gcc: nothing to compare with in C");
        return Vec::new();
    }
    let all = [
        ("p1", "1024", "midpoint_8lanes", "midpoint_scalar"),
        ("p2", "1024", "midpoint_8lanes", "midpoint_scalar"),
        ("p7", "1024", "midpoint_newton1_8lanes", "midpoint_newton1_scalar"),
    ];
    let measured = all.map(|(problem, paths, lanes, scalar)| {
        let output =
            Command::new(&program).arg(problem).env("PATHS", paths).env("REPS", "15").output().unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        (problem, shortest(&text, lanes), shortest(&text, scalar))
    });
    drop(std::fs::remove_file(program));
    measured.into()
}

/// `problem,peer,version,method,threads,paths,steps,h,repetition,wall,...`
fn shortest(text: &str, method: &str) -> f64 {
    let lines = text.lines().filter_map(|line| {
        let fields: Vec<&str> = line.split(',').collect();
        let number = |i: usize| fields.get(i)?.parse::<f64>().ok();
        let is_wanted = fields.get(3) == Some(&method) && number(4)? == 1.0;
        is_wanted.then_some(1e9 * number(9)? / (number(5)? * number(6)?))
    });
    lines.fold(f64::INFINITY, f64::min)
}
