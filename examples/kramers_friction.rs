//! The rate at which a particle leaves a well, over three decades of friction: Kramers' turnover.
//!
//! `H = p²/2 + (q² - 1)²` with friction `γ` and the temperature `kT = 0.2`, a fifth of the barrier; `ω_0² = 8` at the bottom, `ω_b² = 4` at the top. Strong
//! friction slows the passage over the barrier, weak friction the gain of energy up to it (H. A. Kramers, Physica 7, 1940):
//!
//! ```text
//! k_0 = ω_0/2π e^{-B/kT},   γ large: k = (√(γ²/4 + ω_b²) - γ/2)/ω_b k_0,   γ small: k = γ J/kT k_0,   J = ∮ p dq = 8/3 at the barrier
//! ```
//!
//! Between them both factors act, the second as `A(γ J/kT)` (V. I. Mel'nikov, S. V. Meshkov, J. Chem. Phys. 85, 1986), with
//! `A(x) = exp(1/2π ∫ ln(1 - e^{-x (λ² + 1/4)})/(λ² + 1/4) dλ)`, to corrections of the order `kT/B`, which are up to a quarter here
//! for weak friction.
//!
//! `Gjf` allows long steps: the distribution of positions is right to order `h²`, exactly in a harmonic well, and the diffusion of a free particle is exact. Diffusion limits
//! the rate where friction is strong. That of `Baoab` is too fast by `(γh/2) coth(γh/2)`, which is 8 % at the last of these frictions, and so is its rate.
//!
//! `cargo run --release --features svg --example kramers_friction`, less than a minute

#[path = "support/plot.rs"]
mod plot;
#[path = "support/table.rs"]
mod table;

use std::error::Error;
use std::f64::consts::TAU;

use wzvi::plot::{Colour, Figure, Look};
use wzvi::prelude::*;

/// A particle in one of two wells, with friction and a temperature.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + (q * q - 1.0).powi(2),
    friction = gamma,
    temperature = kt,
    embedding = Gjf,
)]
#[derive(Clone, Debug)]
pub struct Well {
    /// Rate of the friction.
    pub gamma: f64,
    /// Temperature.
    pub kt: f64,
}

const KT: f64 = 0.2;
const BARRIER: f64 = 1.0;
const BOTTOM: f64 = 2.828_427_124_746_190_3;
const TOP: f64 = 2.0;
/// The action of an orbit that just reaches the barrier.
const ACTION: f64 = 8.0 / 3.0;
const H: f64 = 0.1;
const PATHS: u64 = 4096;

/// The rate of transition state theory.
fn slowest_attempt() -> f64 {
    BOTTOM / TAU * (-BARRIER / KT).exp()
}

fn with_much_friction(gamma: f64) -> f64 {
    (0.25 * gamma * gamma + TOP * TOP).sqrt() / TOP - 0.5 * gamma / TOP
}

fn with_little_friction(gamma: f64) -> f64 {
    gamma * ACTION / KT
}

/// `A(x)`, by Simpson's rule.
fn depopulation(x: f64) -> f64 {
    let (intervals, end) = (20_000, 100.0);
    let step = end / f64::from(intervals);
    let value = |i: i32| {
        let square = (f64::from(i) * step).powi(2) + 0.25;
        (-(-x * square).exp()).ln_1p() / square
    };
    let weight = |i: i32| if i == 0 || i == intervals { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
    let sum: f64 = (0..=intervals).map(|i| weight(i) * value(i)).sum();
    // Both sides of zero.
    (2.0 * sum * step / 3.0 / TAU).exp()
}

fn expected(gamma: f64) -> f64 {
    slowest_attempt() * with_much_friction(gamma) * depopulation(with_little_friction(gamma))
}

/// The rate at which paths from the equilibrium in one well get to the bottom of the other one, and its standard error.
fn measured(gamma: f64) -> Result<(f64, f64), Box<dyn Error>> {
    let well = Well { gamma, kt: KT };
    let run = well.ensemble::<Gjf>(H).paths(PATHS).seed(1);
    let run = run.until(3.0 / expected(gamma)).whole_steps();
    let deviation = KT.sqrt();
    let run = run
        .starts(|draw| State::new([-1.0 + deviation / BOTTOM * draw.normal()], [deviation * draw.normal()]));
    let statistics = run.first_passage("other well", |state| state.q[0] - 1.0).run()?;
    let passages = statistics.passage("other well")?;
    Ok((passages.rate(), passages.rate_error()))
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("escape from a well at kT = {KT} B, Gjf, h = {H}, {PATHS} paths for each friction\n");
    let (mut rows, mut points) = (Vec::new(), Vec::new());
    for step in 0..=12 {
        let gamma = 10.0_f64.powf(-2.0 + 0.25 * f64::from(step));
        let (rate, error) = measured(gamma)?;
        let k = slowest_attempt();
        rows.push([
            format!("{gamma:.4}"),
            format!("{rate:.3e} ± {error:.0e}"),
            format!("{:.3e}", k * with_little_friction(gamma)),
            format!("{:.3e}", k * with_much_friction(gamma)),
            format!("{:.3e}", expected(gamma)),
            format!("{:.3}", rate / expected(gamma)),
        ]);
        points.push((gamma, rate));
    }
    let headings =
        ["friction γ", "rate", "little friction", "much friction", "Mel'nikov, Meshkov", "rate over it"];
    table::print(headings, &rows);
    println!();
    let curve = |rate: fn(f64) -> f64, from: f64, to: f64| {
        (0..=80).map(move |i| {
            let gamma = from * (to / from).powf(f64::from(i) / 80.0);
            (gamma, rate(gamma))
        })
    };
    let panel = Figure::panel("Rate of escape, kT = B/5", "friction γ", "rate")
        .log_log()
        .points(
            Look::Dashed,
            "little friction",
            Colour::BLUE,
            curve(|gamma| slowest_attempt() * with_little_friction(gamma), 8e-3, 0.08),
        )
        .points(
            Look::Dashed,
            "much friction",
            Colour::VERMILION,
            curve(|gamma| slowest_attempt() * with_much_friction(gamma), 8e-3, 12.0),
        )
        .line("Mel'nikov and Meshkov", Colour::GREEN, curve(expected, 8e-3, 12.0))
        .points(Look::Dots, "paths", Colour::INK, points);
    plot::save("kramers_friction", "turnover", 1, (1100, 800), &[panel])
}
