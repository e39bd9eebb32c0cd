//! The statistics of an ensemble in files for data frames: noise pushes a particle over the barrier of a double well.
//!
//! `cargo run --release --features columnar --example ensemble_files` writes CSV, JSON and Parquet to
//! `target/wzvi/ensemble_files`.

use wzvi::prelude::*;

/// `H_0 = p²/2 + (q² - 1)²/4`, pushed by white noise in the momentum.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.25 * (q * q - 1.0).powi(2),
    noise = [|q, p| -sigma * q],
    embedding = [Midpoint],
)]
pub struct DoubleWell {
    /// Intensity of the noise.
    pub sigma: f64,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let well = DoubleWell { sigma: 0.2 };
    let statistics = well
        .ensemble::<Midpoint>(0.05)
        .start(State::new([-1.0], [0.0]))
        .paths(20_000)
        .seed(7)
        .until(20.0)
        .record_at([5.0, 10.0])
        .observe("q", |state| state.q[0])
        .observe("energy", |state| well.energy(state))
        .quantiles()
        .histogram("q", -2.0, 2.0, 80)
        .first_passage("over the barrier", |state| state.q[0])
        .run()?;
    println!("t      mean of q        energy           its median  99 % below");
    for node in statistics.nodes() {
        let quantile = |fraction| node.quantiles(1).map_or(f64::NAN, |all| all.at(fraction));
        println!(
            "{:4} {:7.4} ± {:.4}  {:7.4} ± {:.4} {:10.4} {:10.4}",
            node.time(),
            node.mean(0),
            node.standard_error(0),
            node.mean(1),
            node.standard_error(1),
            quantile(0.5),
            quantile(0.99),
        );
    }
    // E[H] grows by σ²/2 per unit of time, exactly for the continuous system.
    println!("energy expected at the end: {:.4}", 0.5 * 0.2 * 0.2 * 20.0);
    for passages in statistics.passages() {
        println!(
            "{}: {} of {} paths, mean time {:.3} ± {:.3} of these, {} still on the way",
            passages.name(),
            passages.passed(),
            passages.passed() + passages.censored(),
            passages.mean(),
            passages.standard_error(),
            passages.censored()
        );
    }
    let folder = "target/wzvi/ensemble_files";
    statistics.write_csv(folder)?;
    statistics.write_json(format!("{folder}/statistics.json"))?;
    statistics.write_parquet(folder)?;
    for table in statistics.tables() {
        println!("{folder}/{}: {} rows", table.name(), table.rows());
    }
    Ok(())
}
