//! A particle in the bucket of a synchrotron: noise of the accelerating voltage heats it until it is lost.
//!
//! `H0 = p²/2 + ω² (1 - cos q)`, `H1 = -s q`: `q` is the phase against the voltage, `p` the deviation from the energy of the beam,
//! both scaled, and the noise kicks `p`. Two results are known:
//!
//! * **Exactly**: `E H(t) = H(0) + s² t/2`, whatever the potential, since `dH = s²/2 dt + s p dW`.
//! * **For weak noise**: a particle leaves the bucket when its energy reaches `2ω²`. The mean time for that from the centre is `4ω²/s²`
//!   exactly, and its distribution that of the averaged equation (`support/energy_diffusion.rs`).
//!
//! Paths run until the standard error of the last mean is below a target. Both embeddings are symplectic for every path of the noise, and
//! neither changes the growth of the energy.
//!
//! Electrons radiate: radiation damps their oscillation, and its quanta excite it, up to an equilibrium of temperature `kT`. The same bucket with `friction` and
//! `temperature` then has, at any step and to the scheme's error,
//!
//! * **Exactly**: `⟨p²⟩ = kT` and `⟨1 - cos q⟩ = 1 - I_1(x)/I_0(x)` with `x = ω²/kT`: the spread of the energy and the length of the bunch.
//! * **For weak damping**: a life time, `1/τ = γ J/kT ω/2π e^{-2ω²/kT}` with the action `J = 16 ω` of the separatrix (H. A. Kramers, Physica 7, 1940), to
//!   corrections of the order `kT/2ω²`.
//!
//! `cargo run --release --features svg --example synchrotron`, less than a minute

#[path = "support/energy_diffusion.rs"]
mod energy_diffusion;
#[path = "support/plot.rs"]
mod plot;
#[path = "support/table.rs"]
mod table;

use std::error::Error;

use energy_diffusion::Well;
use wzvi::plot::{Colour, Figure, Look};
use wzvi::prelude::*;

/// Longitudinal motion with noise of the voltage.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + omega * omega * (1.0 - q.cos()),
    noise = [|q, p| -s * q],
    embedding = [DeltaPlus, Midpoint],
)]
pub struct Synchrotron {
    /// Angular frequency of small oscillations.
    pub omega: f64,
    /// Intensity of the noise.
    pub s: f64,
}

/// The same with radiation: damping, and the heat of its quanta.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + omega * omega * (1.0 - q.cos()),
    friction = gamma,
    temperature = kt,
    embedding = Baoab,
)]
pub struct Ring {
    /// Angular frequency of small oscillations.
    pub omega: f64,
    /// Rate of the damping.
    pub gamma: f64,
    /// Temperature of the equilibrium.
    pub kt: f64,
}

const BEAM: Synchrotron = Synchrotron { omega: 1.0, s: 0.1 };
const H: f64 = 0.05;
const END: f64 = 800.0;
const STRIDE: u64 = 1600;
/// Standard error of the mean energy at the end.
const TARGET: f64 = 0.025;
const LIMIT: u64 = 100_000;
/// `-ζ(1/2)/√(2π)`, as in the example `kramers`.
const OVERSHOOT: f64 = 0.582_597_157_939_010_7;

fn main() -> Result<(), Box<dyn Error>> {
    let barrier = 2.0 * BEAM.omega * BEAM.omega;
    let run = BEAM
        .ensemble::<Midpoint>(H)
        .start(State::new([0.0], [0.0]))
        .paths(LIMIT)
        .seed(7)
        .until(END)
        .record_every(STRIDE)
        .observe("energy", |state| BEAM.energy(state))
        .until_error("energy", TARGET)
        .first_passage("loss", |state| barrier - BEAM.energy(state))
        .run()?;
    let paths = run.last().map_or(0, |end| end.count());
    let other = BEAM
        .ensemble::<DeltaPlus>(H)
        .start(State::new([0.0], [0.0]))
        .paths(paths)
        .seed(7)
        .until(END)
        .record_every(STRIDE)
        .observe("observable0", |state| BEAM.energy(state))
        .run()?;

    println!(
        "Mean energy of {paths} particles, ω = {}, s = {}, h = {H}; the last error had to be below {TARGET}\n",
        BEAM.omega, BEAM.s
    );
    let exact = |t: f64| 0.5 * BEAM.s * BEAM.s * t;
    let mut rows = vec![];
    for (node, other) in run.nodes().iter().zip(other.nodes()).skip(1) {
        let (t, mean, error) = (node.time(), node.mean(0), node.standard_error(0));
        rows.push([
            format!("{t:.0}"),
            format!("{:.4}", exact(t)),
            format!("{mean:.4} ± {error:.4}"),
            format!("{:+.1}", (mean - exact(t)) / error),
            format!("{:.4} ± {:.4}", other.mean(0), other.standard_error(0)),
            format!("{:+.1}", (other.mean(0) - exact(t)) / other.standard_error(0)),
        ]);
    }
    table::print(["t", "exactly s² t/2", "Midpoint", "off, se", "DeltaPlus", "off, se"], &rows);

    // The loss of particles, in units of the mean time.
    let unit = 2.0 * barrier / BEAM.s.powi(2);
    let potential = |q: f64| BEAM.omega * BEAM.omega * (1.0 - q.cos());
    let ends = [-std::f64::consts::PI, std::f64::consts::PI];
    let bucket = Well { potential, bottom: 0.0, ends, barrier };
    let theory = bucket.survival(END / unit);
    let speed = bucket.integral(2, barrier) / bucket.integral(1, barrier);
    let seen = 1.0 + OVERSHOOT * BEAM.s * speed * H.sqrt() / barrier;
    let survival = |t: f64| theory.get((t / (unit * seen) * 1000.0).round() as usize).map_or(0.0, |at| at.1);
    let losses = run.passage("loss")?;
    let histogram = losses.histogram();
    let (mut left, mut measured) = (paths as f64, vec![(0.0, 1.0)]);
    for (bin, &count) in histogram.counts().iter().enumerate() {
        left -= count as f64;
        measured.push((histogram.edge(bin + 1), left / paths as f64));
    }
    let farthest = measured.iter().map(|&(t, left)| (left - survival(t)).abs()).fold(0.0, f64::max);
    println!("\nParticles still in the bucket (averaged equation: weak noise; ± is one standard error)\n");
    let mut rows = vec![];
    for &(t, left) in measured.iter().skip(10).step_by(10) {
        let error = (left * (1.0 - left) / paths as f64).sqrt();
        rows.push([format!("{t:.0}"), format!("{left:.4} ± {error:.4}"), format!("{:.4}", survival(t))]);
    }
    table::print(["t", "measured", "averaged"], &rows);
    let chance = 1.36 / (paths as f64).sqrt();
    println!("\n  largest distance {farthest:.4}; chance makes {chance:.4} (95 %)\n");

    let means = |run: &wzvi::ensemble::Statistics| -> Vec<(f64, f64)> {
        run.nodes().iter().map(|node| (node.time(), node.mean(0))).collect()
    };
    let band = |sign: f64| -> Vec<(f64, f64)> {
        run.nodes().iter().map(|node| (node.time(), sign * 2.0 * node.standard_error(0))).collect()
    };
    let off = |run: &wzvi::ensemble::Statistics| -> Vec<(f64, f64)> {
        run.nodes().iter().map(|node| (node.time(), node.mean(0) - exact(node.time()))).collect()
    };
    let x = "time t [1/ω]";
    let energy = Figure::panel("Mean energy", x, "mean of H [ω²]")
        .line("exactly s² t/2", Colour::INK, [(0.0, 0.0), (END, exact(END))])
        .points(Look::Marks, "Midpoint", Colour::BLUE, means(&run));
    let deviation = Figure::panel("Deviation from it", x, "mean of H - s² t/2 [ω²]")
        .points(Look::Dashed, "two standard errors", Colour::GREY, band(1.0))
        .points(Look::Dashed, "", Colour::GREY, band(-1.0))
        .points(Look::Joined, "Midpoint", Colour::BLUE, off(&run))
        .points(Look::Joined, "DeltaPlus", Colour::VERMILION, off(&other));
    let curve = theory.iter().step_by(5).map(|&(t, left)| (t * unit, left)).collect::<Vec<_>>();
    let bucket = Figure::panel("Particles still in the bucket", x, "fraction")
        .points(Look::Dots, "measured", Colour::BLUE, measured)
        .line("averaged equation", Colour::INK, curve);
    plot::save("synchrotron", "heating", 3, (900, 700), &[energy, deviation, bucket])?;
    radiation()
}

/// `I_n(x)` as the mean of `e^{x cos q} cos(n q)` over the circle: equidistant points are exact to rounding here.
fn bessel(n: f64, x: f64) -> f64 {
    let angle = |i: u32| f64::from(i) * std::f64::consts::TAU / 256.0;
    (0..256).map(|i| (x * (angle(i).cos() - 1.0)).exp() * (n * angle(i)).cos()).sum::<f64>() / 256.0
}

/// Damped bunches: their equilibrium, how they get there, and how long they live.
fn radiation() -> Result<(), Box<dyn Error>> {
    const DAMPING: f64 = 0.01;
    const STEP: f64 = 0.1;
    println!("\nWith radiation damping, ω = 1, γ = {DAMPING}, Baoab, h = {STEP}\n");
    let (mut rows, mut figures) = (vec![], vec![]);
    let mut approach = Figure::panel("Radiation damps to an equilibrium", "time t [1/ω]", "mean of p² [ω²]");
    for (kt, color) in [(0.3, Colour::BLUE), (0.4, Colour::GREEN), (0.5, Colour::VERMILION)] {
        let ring = Ring { omega: 1.0, gamma: DAMPING, kt };
        let rate = DAMPING * 16.0 / kt / std::f64::consts::TAU * (-2.0 / kt).exp();
        let run = ring.ensemble::<Baoab>(STEP).paths(4096).seed(3).start(State::new([1.5], [0.0]));
        let run = run
            .observe("p²", |state| state.p[0].powi(2))
            .observe("1 - cos q", |state| 1.0 - state.q[0].cos());
        let run = run.first_passage("loss", |state| std::f64::consts::PI + 0.5 - state.q[0].abs());
        let run = run.record_every(100).until(1500.0).run()?;
        let losses = run.passage("loss")?;
        let end = run.last().ok_or("an ensemble has an end")?;
        let x = 1.0 / kt;
        rows.push([
            format!("{kt}"),
            format!("{:.4} ± {:.4}", end.mean(0), end.standard_error(0)),
            format!("{:.4} ± {:.4}", end.mean(1), end.standard_error(1)),
            format!("{:.4}", 1.0 - bessel(1.0, x) / bessel(0.0, x)),
            format!("{:.2e} ± {:.0e}", losses.rate(), losses.rate() / (losses.passed() as f64).sqrt()),
            format!("{rate:.2e}"),
        ]);
        let means = run.nodes().iter().map(|node| (node.time(), node.mean(0)));
        approach = approach.line(format!("kT = {kt}"), color, means.collect::<Vec<_>>()).points(
            Look::Dashed,
            "",
            color,
            [(0.0, kt), (1500.0, kt)],
        );
    }
    figures.push(approach);
    table::print(["kT", "mean p²", "mean 1 - cos q", "exactly", "loss rate", "Kramers, weak damping"], &rows);
    println!();
    plot::save("synchrotron", "radiation", 1, (1000, 700), &figures)
}
