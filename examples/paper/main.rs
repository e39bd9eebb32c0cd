//! The whole paper on one page, measured: `cargo run --release --features report --example paper`, then open `target/wzvi/paper/index.html`.
//!
//! J. Cresson, R. Safi, *Dynamics of stochastic Hamiltonian systems I: Wong-Zakai variational integrators*. Its figures with
//! its parameters, and its open questions: the errors of the approximations of the noise, for each step size.

mod additive;
mod diagram;
mod kubo;
mod linear;
mod wong_zakai;

use wzvi::report::Document;

/// Where the page goes.
const FOLDER: &str = "target/wzvi/paper";

fn main() -> Result<(), wzvi::Error> {
    let document = Document::new("Wong-Zakai variational integrators: the paper, measured").text(
        "Every figure of Cresson and Safi, Dynamics of stochastic Hamiltonian systems I, with their parameters, beside exact \
         solutions on the same Wiener path; then what the paper leaves open. Point at a mark, or move to it with the Tab key, to \
         read its numbers; the numbers of each figure are below it.",
    );
    let document = linear::append(document)?;
    let document = kubo::append(document)?;
    let document = additive::append(document)?;
    let document = diagram::append(document)?;
    let document = wong_zakai::append(document)?;
    let report = kubo::work_precision()?;
    report.print();
    let document = document.heading("How much error for how much time");
    let document = report.append_to(document, "kubo");
    document.write(FOLDER)?;
    println!("{FOLDER}/index.html");
    Ok(())
}

/// "agrees with" or "disagrees with", for a sentence.
fn agrees(holds: bool) -> &'static str {
    if holds { "This agrees with" } else { "This does not agree with" }
}

/// Root mean square.
fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (mut sum, mut n) = (0.0, 0.0);
    for value in values {
        sum += value * value;
        n += 1.0;
    }
    f64::sqrt(sum / n)
}
