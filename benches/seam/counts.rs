//! Instructions per site and step.

use std::process::Command;

use crate::{Case, SPELLINGS};

/// The table, with the largest ratio of neighbours behind each row.
pub(crate) fn report(cases: &[Case], problems: &[&str], sizes: &[usize]) {
    println!("instructions per site and step");
    let sizes: String = sizes.iter().map(|sites| format!("{:>9}", format!("N = {sites}"))).collect();
    println!("{:27}{sizes}{:>10}", "", "largest");
    for problem in problems {
        for spelling in SPELLINGS {
            let row: Vec<Option<f64>> = cases
                .iter()
                .enumerate()
                .filter(|(_, case)| case.problem == *problem && case.spelling == spelling)
                .map(|(number, case)| instructions(number, case))
                .collect();
            let counts: String = row
                .iter()
                .map(|count| count.map_or("        -".into(), |count| format!("{count:>9.1}")))
                .collect();
            let ratios = row.windows(2).filter_map(|pair| Some(pair[1]? / pair[0]?));
            let largest = ratios.fold(0.0, f64::max);
            println!("{problem:18}{spelling:9}{counts}{largest:>10.2}");
        }
    }
}

fn instructions(number: usize, case: &Case) -> Option<f64> {
    let steps = (1_000 / case.sites as u64).max(20);
    let run = |steps: u64| callgrind(&["--run", &number.to_string(), &steps.to_string()]);
    Some((run(3 * steps)? - run(steps)?) / (2 * case.sites as u64 * steps) as f64)
}

/// Instructions of this program with `arguments`.
fn callgrind(arguments: &[&str]) -> Option<f64> {
    // Without the string instructions of the C library, each byte of which counts as an instruction.
    const PLAIN: &str =
        "glibc.cpu.x86_rep_stosb_threshold=1000000000:glibc.cpu.x86_rep_movsb_threshold=1000000000";
    let output = Command::new("valgrind")
        .env("GLIBC_TUNABLES", PLAIN)
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(std::env::current_exe().ok()?)
        .args(arguments)
        .output()
        .ok()?;
    let report = String::from_utf8_lossy(&output.stderr);
    let (_, collected) = report.split_once("Collected :")?;
    collected.split_whitespace().next()?.parse().ok()
}
