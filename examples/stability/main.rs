//! Where the schemes hold and where they stop: one table of stiff and extreme cases, with their cost.
//!
//! Run with `cargo run --release --features report --example stability`; the table is also written to `target/wzvi/stability/table.csv`
//! and, as a page, to `target/wzvi/stability/index.html`.
//! `docs/guide/stability.md` explains each kind of failure, and what to do.

mod cases;
mod systems;
#[path = "../support/table.rs"]
mod table;

use std::error::Error;
use std::fs;
use std::path::PathBuf;

use wzvi::report::{Document, Machine};

/// The measure of a case without exact solution: the size of its state.
pub(crate) const SIZE: &str = "size";

/// One line of the table.
pub(crate) struct Row {
    pub(crate) case: String,
    pub(crate) scheme: &'static str,
    /// What ended the run, and where.
    pub(crate) error: Option<String>,
    /// The parts that its steps were divided into.
    pub(crate) parts: u64,
    pub(crate) steps: u64,
    /// Newton iterations per step: mean and largest.
    pub(crate) iterations: Option<(f64, u32)>,
    /// What the case measures, and how much of it there was.
    pub(crate) drift: (&'static str, f64),
    /// Nanoseconds per step.
    pub(crate) time: f64,
}

impl Row {
    /// The outcome in words, with a mark, so that it does not depend on colour alone.
    fn outcome(&self) -> String {
        let word = match (&self.error, self.drift) {
            (Some(error), _) => return format!("✗ {error}"),
            (None, (SIZE, _)) => "solved",
            (None, (_, error)) if error <= 1e-3 => "✓ accurate",
            (None, (_, error)) if error <= 0.1 => "◐ rough",
            (None, _) => "✗ wrong",
        };
        if self.parts > 1 { format!("{word}, {} parts", self.parts) } else { word.to_owned() }
    }

    fn cells(&self) -> [String; 7] {
        let iterations = match self.iterations {
            Some((mean, largest)) => format!("{mean:.2} ({largest})"),
            None => String::from("-"),
        };
        [
            self.case.clone(),
            self.scheme.to_owned(),
            self.outcome(),
            self.steps.to_string(),
            iterations,
            format!("{} {:.2e}", self.drift.0, self.drift.1),
            format!("{:.0}", self.time),
        ]
    }
}

const HEADS: [&str; 7] = ["case", "scheme", "outcome", "steps", "Newton mean (max)", "worst", "ns/step"];

/// Headings and rows of the map: the outcome of each scheme on each case, where it was run. A remedy is a column of its own.
fn map(rows: &[Row]) -> (Vec<String>, Vec<Vec<String>>) {
    let mut heads = vec!["case".to_owned()];
    let mut lines: Vec<Vec<String>> = vec![];
    for row in rows {
        let (case, scheme) = match row.case.rsplit_once(", ") {
            Some((case, remedy @ ("retry" | "polar"))) => (case, format!("{}, {remedy}", row.scheme)),
            _ => (row.case.as_str(), row.scheme.to_owned()),
        };
        let case = powers(case);
        let known = lines.iter().position(|line| line[0] == case);
        let line = known.unwrap_or_else(|| {
            lines.push(vec![case]);
            lines.len() - 1
        });
        let column = heads.iter().position(|head| *head == scheme).unwrap_or(heads.len());
        if column == heads.len() {
            heads.push(scheme);
        }
        if lines[line].len() <= column {
            lines[line].resize(column + 1, String::new());
        }
        // Where it ended is in the tables.
        let outcome = row.outcome().replace("error: ", "");
        lines[line][column] = outcome.split(" at t").next().unwrap_or("").to_owned();
    }
    lines.iter_mut().for_each(|line| line.resize(heads.len(), String::new()));
    (heads, lines)
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut lines = vec![HEADS.map(str::to_owned)];
    let mut page = Document::new("Where the schemes hold and where they stop")
        .text(
            "Stiff and extreme cases, each run once. A run that reaches its end is judged by its largest error. \
             docs/guide/stability.md explains each kind of failure, and what to do about it.",
        )
        .list([
            "✓ accurate: a largest error of 10⁻³ or less; ◐ rough: of 0.1 or less; ✗ wrong: above 0.1",
            "✗ unresolved, no solution, ...: the error that ended the run, with the state unchanged",
            "solved: every step has a solution, and no exact one is known; empty: not run",
            "parts: how many parts a retry divided each step into; slow, fast: the spring starts at rest, or stretches at 0.1",
            "Verlet is stable below ω h = 2, but its nodes lie on a flat ellipse, so the radius is wrong; at ω h = 2 the start (1, 0) only changes its sign",
        ]);
    let tables = cases::all()?;
    page = page.heading("Scheme by case");
    for (title, rows) in &tables {
        let (heads, lines) = map(rows);
        // Those of one scheme show no more here than in their tables.
        if heads.len() > 2 {
            page = page.table(*title, heads, lines);
        }
    }
    page = page
        .heading("All cases, as measured")
        .list([
            "steps: the steps taken; Newton mean (max): iterations per step, where there are any",
            "worst: the largest error of the energy (dH), a radius (r), a place (dq), an angle or a return to the start, in units of its scale",
            "size: of the largest coordinate, for masses; |ln r|, for the noise σ q p",
            "ns/step: nanoseconds per step in this run, on a machine that may be busy; with a retry, runs that started again are included",
        ])
        .text(format!("{}.", Machine::here().line()));
    for (title, rows) in tables {
        let cells: Vec<[String; 7]> = rows.iter().map(Row::cells).collect();
        println!("\n{title}\n");
        let shown: Vec<[String; 7]> =
            cells.iter().map(|line| line.each_ref().map(|cell| powers(cell))).collect();
        table::print(HEADS, &shown);
        page = page.table(title, HEADS.map(str::to_owned).to_vec(), shown.iter().map(Into::into).collect());
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

/// A text with `10⁸` for `1e8`, `2.5·10⁻⁹` for `2.5e-9`, `50` for `5e1` and `0` for `0e0`.
fn powers(text: &str) -> String {
    let mut shown = String::new();
    for word in text.split_inclusive(' ') {
        let number = word.trim_end_matches([' ', ',', ')']);
        let parts = number.split_once('e').zip(number.parse::<f64>().ok());
        match parts {
            None => shown.push_str(word),
            Some((_, value)) if value == 0.0 || (1.0..100.0).contains(&value) => {
                shown.push_str(&format!("{value}{}", &word[number.len()..]));
            }
            Some(((mantissa, exponent), _)) => {
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
