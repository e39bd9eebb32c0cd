//! Programs in C, built and run here if there is a compiler.

use std::path::{Path, PathBuf};
use std::process::Command;

/// What every program is built with.
pub(crate) const USUAL: &[&[&str]] = &[&["-O3"], &["-O3", "-march=native"]];

/// The same where pragmas ask for vectors: of the rules of C only that functions tell of their errors is left out.
pub(crate) const VECTORS: &[&[&str]] =
    &[&["-O3"], &["-O3", "-march=native", "-fopenmp-simd", "-fno-math-errno"]];

/// Runs a program, built in several ways, for sizes and numbers of steps.
pub(crate) fn report(what: &str, file: &str, sizes: &[(usize, u64)], ways: &[&[&str]]) {
    println!("\n{what} in C ({file}), ns per site and step (iterations)\n");
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("elements").join(file);
    for flags in ways {
        let name = format!("cc {}", flags.join(" "));
        match build(&source, flags) {
            Some(program) => {
                for &(n, steps) in sizes {
                    run(&program, &name, n, steps);
                }
                // Nobody needs it any more.
                drop(std::fs::remove_file(program));
            }
            None => println!("  {name}: no C compiler; skipped"),
        }
    }
}

fn build(source: &Path, flags: &[&str]) -> Option<PathBuf> {
    let program = std::env::temp_dir().join(format!("hand_{}_{}", std::process::id(), flags.len()));
    let status =
        Command::new("cc").args(flags).arg(source).arg("-o").arg(&program).arg("-lm").status().ok()?;
    status.success().then_some(program)
}

fn run(program: &Path, name: &str, n: usize, steps: u64) {
    let Ok(output) = Command::new(program).args([n.to_string(), steps.to_string()]).output() else {
        println!("  {name}: does not run");
        return;
    };
    for line in String::from_utf8_lossy(&output.stdout).lines() {
        if let [scheme, ns, iterations] = line.split(';').collect::<Vec<_>>()[..] {
            println!("  {name:58}{scheme:24}{n:>9}{:>18}", format!("{ns} ({iterations})"));
        }
    }
}
