//! Escape from a double well: when does noise lift a particle over the barrier?
//!
//! `H0 = p²/2 + (q² - 1)²/4`, `H1 = -s q`: kicks in the momentum, no friction, from rest at the bottom of one well. Kramers'
//! rate `ω/2π e^{-B/kT}` does not apply: without friction there is no temperature, the energy grows for ever, `E H(t)
//! = H(0) + s² t/2`, and every path escapes. Known results:
//!
//! * **Exactly**, for any `s`: `H - s² t/2` is a martingale, so the mean time to the energy `B = 1/4` of the barrier is `2B/s²` from
//!   the bottom; and if `τ` is the time to the other well, `E H(τ) = s² E τ/2`.
//! * **For weak noise**: the distribution of the time follows the averaged equation of Stratonovich and of Kramers' weak friction
//!   (`support/energy_diffusion.rs`), the same for all `s` in units of `2B/s²`.
//!
//! The energy is tested after each step only. It diffuses with the coefficient `s p`, and overshoots the barrier by `0.5826 s |p| √h` on average
//! before the crossing is detected (M. Broadie, P. Glasserman, S. Kou, Math. Finance 7 (1997) 325). The mean time is longer accordingly.
//!
//! `cargo run --release --features svg --example kramers`, less than a minute

#[path = "support/energy_diffusion.rs"]
mod energy_diffusion;
#[path = "support/plot.rs"]
mod plot;
#[path = "support/table.rs"]
mod table;

use std::error::Error;

use energy_diffusion::Well;
use wzvi::ensemble::Passages;
use wzvi::plot::{Colour, Figure, Look};
use wzvi::prelude::*;

/// A particle between two wells, kicked.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.25 * (q * q - 1.0).powi(2),
    noise = [|q, p| -s * q],
    embedding = [Midpoint],
)]
pub struct DoubleWell {
    /// Intensity of the kicks.
    pub s: f64,
}

const BARRIER: f64 = 0.25;
const H: f64 = 0.01;
const PATHS: u64 = 16_384;
/// Length of a run, in mean times: one path in a few thousand has not escaped.
const SPAN: f64 = 5.5;
/// `-ζ(1/2)/√(2π)`: the mean overshoot of a random walk over a far barrier, in standard deviations of a step.
const OVERSHOOT: f64 = 0.582_597_157_939_010_7;

/// What passages to one event say, in units of the mean time `2B/s²`.
struct Escape {
    mean: f64,
    error: f64,
    /// At the ends of the bins of the histogram: time and the fraction that has not passed.
    survival: Vec<(f64, f64)>,
    density: Vec<(f64, f64)>,
}

fn escape(passages: &Passages, unit: f64) -> Escape {
    let all = (passages.passed() + passages.censored()) as f64;
    // The remaining time of paths that have not escaped is at most as long as the mean over all paths.
    let mean = passages.passed() as f64 / passages.rate() / all + passages.censored() as f64 / all * unit;
    let histogram = passages.histogram();
    let (mut left, mut survival, mut density) = (all, vec![(0.0, 1.0)], vec![]);
    for (bin, &count) in histogram.counts().iter().enumerate() {
        left -= count as f64;
        let [from, to] = [bin, bin + 1].map(|bin| histogram.edge(bin) / unit);
        survival.push((to, left / all));
        density.push((0.5 * (from + to), count as f64 / (all * (to - from))));
    }
    Escape { mean: mean / unit, error: passages.standard_error() / unit, survival, density }
}

/// One path, for the eye: `(t, q)` until it has been in both wells for a while.
fn sample(s: f64, unit: f64) -> Result<Vec<(f64, f64)>, wzvi::Error> {
    let system = DoubleWell { s };
    let run = system.simulate::<Midpoint>(H).start(State::new([1.0], [0.0])).noise(Wiener::seed(4));
    let path = run.until(1.5 * unit).record_every(10).run()?;
    Ok(path.states().iter().map(|state| (state.t / unit, state.q[0])).collect())
}

fn main() -> Result<(), Box<dyn Error>> {
    let well = Well {
        potential: |q: f64| 0.25 * (q * q - 1.0).powi(2),
        bottom: 1.0,
        ends: [0.0, 2.0],
        barrier: BARRIER,
    };
    let theory = well.survival(SPAN);
    let survival = |time: f64| theory.get((time * 1000.0).round() as usize).map_or(0.0, |point| point.1);
    let area: f64 = theory.windows(2).map(|pair| pair[1].1 * (pair[1].0 - pair[0].0)).sum();
    println!(
        "Averaged equation: mean time {area:.4} up to t = {SPAN}, exactly 1 in all; unit of time 2B/s²\n"
    );
    let speed = well.integral(2, BARRIER) / well.integral(1, BARRIER);

    let (mut rows, mut escapes) = (vec![], vec![]);
    for (s, color) in [(0.2, Colour::OCHRE), (0.1, Colour::GREEN), (0.05, Colour::BLUE)] {
        let (system, unit) = (DoubleWell { s }, 2.0 * BARRIER / (s * s));
        let statistics = system
            .ensemble::<Midpoint>(H)
            .start(State::new([1.0], [0.0]))
            .paths(PATHS)
            .seed(7)
            .until(SPAN * unit)
            .first_passage("barrier", |state| BARRIER - system.energy(state))
            .first_passage("other well", |state| state.q[0])
            .run()?;
        let passages = |name| statistics.passage(name).map(|passages| escape(passages, unit));
        let (barrier, other) = (passages("barrier")?, passages("other well")?);
        let seen = 1.0 + OVERSHOOT * s * speed * H.sqrt() / BARRIER;
        let distance = |(time, left): &(f64, f64)| (left - survival(time / seen)).abs();
        let farthest = barrier.survival.iter().map(distance).fold(0.0, f64::max);
        rows.push([
            format!("{s}"),
            format!("{unit:.1}"),
            format!("{:.4} ± {:.4}", barrier.mean, barrier.error),
            format!("{seen:.4}"),
            format!("{:+.1}", (barrier.mean - seen) / barrier.error),
            format!("{farthest:.3}"),
            format!("{:.4} ± {:.4}", other.mean, other.error),
            format!("{:.4}", BARRIER * other.mean),
        ]);
        escapes.push((s, color, barrier));
    }
    println!("Times in units of 2B/s², {PATHS} paths, h = {H}; exactly 1 to the barrier\n");
    table::print(
        [
            "s",
            "2B/s²",
            "to the barrier",
            "seen at nodes",
            "off, se",
            "distribution",
            "to the other well",
            "E H there",
        ],
        &rows,
    );
    println!(
        "\n  seen at nodes: the exact mean 1 with the correction for looking at nodes only; off: from that, in standard errors"
    );
    println!(
        "  distribution: largest distance from the averaged equation, which is for s → 0; chance makes {:.3} (95 %)",
        1.36 / (PATHS as f64).sqrt()
    );
    println!("  E H there: mean energy on arrival in the other well, s² E τ/2, above the barrier's 0.25\n");

    let x = "time t [2B/s²]";
    let mut curves = Figure::panel("Not yet at the barrier", x, "probability").log_y();
    let mut densities = Figure::panel("Density of the time to the barrier", x, "density [s²/2B]");
    for (s, color, escape) in escapes {
        let some = escape.survival.iter().copied().filter(|point| point.1 > 1e-3);
        curves = curves.points(Look::Dots, format!("s = {s}"), color, some.collect::<Vec<_>>());
        if s != 0.2 {
            densities = densities.points(Look::Dots, format!("s = {s}"), color, escape.density);
        }
    }
    let late = theory.iter().copied().filter(|point| point.1 > 1e-3).collect::<Vec<_>>();
    curves = curves.line("averaged equation", Colour::INK, late);
    let slope = theory.windows(2).step_by(10).map(|w| (0.5 * (w[0].0 + w[1].0), (w[0].1 - w[1].1) * 1000.0));
    densities = densities.line("averaged equation", Colour::INK, slope.collect::<Vec<_>>());
    let path = Figure::panel("One path, s = 0.1", x, "position q")
        .line("", Colour::VERMILION, sample(0.1, 50.0)?)
        .points(Look::Dashed, "barrier", Colour::GREY, [(0.0, 0.0), (1.5, 0.0)]);
    plot::save("kramers", "escape", 3, (900, 700), &[path, curves, densities])?;
    Ok(())
}
