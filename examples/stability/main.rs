//! Where the schemes hold and where they stop: one table of stiff and extreme cases, with what each costs.
//!
//! Run with `cargo run --release --example stability`; the table is also written to `target/wzvi/stability/table.csv`
//! and, as a page, to `target/wzvi/stability/index.html`.
//! `docs/guide/stability.md` explains each way to fail, and what to do.

mod cases;
mod systems;
#[path = "../support/table.rs"]
mod table;

use std::error::Error;
use std::fs;
use std::path::PathBuf;

use wzvi::report::{Document, Machine};

/// One line of the table.
pub(crate) struct Row {
    pub(crate) case: String,
    pub(crate) scheme: &'static str,
    pub(crate) outcome: String,
    pub(crate) steps: u64,
    /// Newton iterations per step: mean and largest.
    pub(crate) iterations: Option<(f64, u32)>,
    /// What the case measures, and how much of it there was.
    pub(crate) drift: (&'static str, f64),
    /// Nanoseconds per step.
    pub(crate) time: f64,
}

impl Row {
    fn cells(&self) -> [String; 7] {
        let iterations = match self.iterations {
            Some((mean, largest)) => format!("{mean:.2} ({largest})"),
            None => String::from("-"),
        };
        [
            self.case.clone(),
            self.scheme.to_owned(),
            self.outcome.clone(),
            self.steps.to_string(),
            iterations,
            format!("{} {:.1e}", self.drift.0, self.drift.1),
            format!("{:.0}", self.time),
        ]
    }
}

const HEADS: [&str; 7] = ["case", "scheme", "outcome", "steps", "Newton mean (max)", "worst", "ns/step"];

fn main() -> Result<(), Box<dyn Error>> {
    let mut lines = vec![HEADS.map(str::to_owned)];
    let mut page = Document::new("Where the schemes hold and where they stop")
        .text(
            "Stiff and extreme cases, each run once by the scheme that stands beside it. A case survives if every step has a solution that \
             continues its state; what does not is a typed error, which leaves the state as it was. docs/guide/stability.md explains each way to \
             fail, and what to do.",
        )
        .list([
            "outcome: ✓ survived; ◐ survived in so many parts of a step, after retries; ✗ the error that ended the run, and where",
            "steps: those that were taken; Newton mean (max): iterations in a step, where there are any",
            "worst: the largest of what the case measures, such as the error of the energy, relative to its size at the start",
            "ns/step: nanoseconds of a step in this run, on a machine that may do other things",
        ])
        .text(format!("{}.", Machine::here().line()));
    for (title, rows) in cases::all()? {
        let cells: Vec<[String; 7]> = rows.iter().map(Row::cells).collect();
        println!("\n{title}\n");
        let shown: Vec<[String; 7]> =
            cells.iter().map(|line| line.each_ref().map(|cell| powers(cell))).collect();
        table::print(HEADS, &shown);
        let rows = shown.iter().map(marked).collect();
        page = page.table(title, HEADS.map(str::to_owned).to_vec(), rows);
        lines.extend(cells);
    }
    let folder = PathBuf::from("target/wzvi/stability");
    fs::create_dir_all(&folder)?;
    let quoted = |line: &[String; 7]| {
        line.each_ref().map(|cell| format!("\"{}\"", cell.replace('"', "\"\""))).join(",")
    };
    let text: Vec<String> = lines.iter().map(quoted).collect();
    fs::write(folder.join("table.csv"), text.join("\n") + "\n")?;
    page.write(&folder)?;
    println!("\ntable: {}, {}", folder.join("table.csv").display(), folder.join("index.html").display());
    Ok(())
}

/// A text with `10⁸` for `1e8`, and `2.5·10⁻⁹` for `2.5e-9`.
fn powers(text: &str) -> String {
    let mut shown = String::new();
    for word in text.split_inclusive(' ') {
        let number = word.trim_end_matches([' ', ',', ')']);
        let parts = number.split_once('e').filter(|_| number.parse::<f64>().is_ok());
        match parts {
            None => shown.push_str(word),
            Some((mantissa, "0")) => {
                shown.push_str(mantissa);
                shown.push_str(&word[number.len()..]);
            }
            Some((mantissa, exponent)) => {
                if mantissa != "1" {
                    shown.push_str(&format!("{mantissa}·"));
                }
                shown.push_str("10");
                shown.extend(exponent.chars().map(|letter| match letter.to_digit(10) {
                    Some(digit) => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit as usize],
                    None => '⁻',
                }));
                shown.push_str(&word[number.len()..]);
            }
        }
    }
    shown
}

/// The cells of a line for the page: with a mark before the outcome, so that colour is not all that tells.
fn marked(cells: &[String; 7]) -> Vec<String> {
    let mut cells = cells.to_vec();
    if let Some(outcome) = cells.get_mut(2) {
        let mark = match outcome.as_str() {
            outcome if outcome.starts_with("survived") => '✓',
            outcome if outcome.starts_with("error") => '✗',
            _ => '◐',
        };
        *outcome = format!("{mark} {outcome}");
    }
    cells
}
