//! The chain in C, built and run here if there is a compiler.

use std::path::{Path, PathBuf};
use std::process::Command;

pub(crate) fn report() {
    println!("\nThe chain in C (hand_ode.c), ns per particle and step (iterations)\n");
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/elements/hand_ode.c");
    for (name, flags) in [("cc -O3", &["-O3"][..]), ("cc -O3 -march=native", &["-O3", "-march=native"])] {
        match build(&source, flags) {
            Some(program) => {
                for (n, steps) in [(32, 4_000), (1024, 100), (1_000_000, 1)] {
                    run(&program, name, n, steps);
                }
                // Nobody needs it any more.
                drop(std::fs::remove_file(program));
            }
            None => println!("  {name}: no C compiler; skipped"),
        }
    }
}

fn build(source: &Path, flags: &[&str]) -> Option<PathBuf> {
    let program = std::env::temp_dir().join(format!("hand_ode_{}_{}", std::process::id(), flags.len()));
    let status =
        Command::new("cc").args(flags).arg(source).arg("-o").arg(&program).arg("-lm").status().ok()?;
    status.success().then_some(program)
}

fn run(program: &Path, name: &str, n: usize, steps: usize) {
    let Ok(output) = Command::new(program).args([n.to_string(), steps.to_string()]).output() else {
        println!("  {name}: does not run");
        return;
    };
    for line in String::from_utf8_lossy(&output.stdout).lines() {
        if let [scheme, ns, iterations] = line.split(';').collect::<Vec<_>>()[..] {
            println!("  {name:22}{scheme:24}{n:>9}{:>18}", format!("{ns} ({iterations})"));
        }
    }
}
