//! The paper's second example: `dq = p dt + σ dW1`, `dp = -q dt + γ dW2` with σ = 0, γ = 1, from rest, h = 0.02, t ≤ 200.
//! With additive noise the scheme of order one is consistent as it stands.
//!
//! The exact solution is `z(t + h) = R(h) z(t) + ∫ R(t + h - s) (σ dW1, γ dW2)`, with the rotation R. The paper compares
//! with `E[exact | increments]`, which has an error of its own, because it does not know the path within a step. Here the
//! exact solution is computed on the same path, from its increments and areas; the remaining error is 5e-4 at t = 200.
//!
//! Run with `cargo run --release --features svg --example additive_noise`.

#[path = "support/plot.rs"]
mod plot;
#[path = "support/table.rs"]
mod table;

use std::error::Error;

use table::Mean;
use wzvi::nalgebra::SVector;
use wzvi::noise::{Interval, NoiseError, Paths};
use wzvi::plot::{Colour, Figure, Look};
use wzvi::prelude::*;

#[hamiltonian(
    drift = |q, p| 0.5 * (p * p + q * q),
    noise = [|_, p| sigma * p, |q, _| -gamma * q],
    embedding = [DeltaPlus, Midpoint],
)]
struct Driven {
    sigma: f64,
    gamma: f64,
}

type Point = SVector<f64, 1>;
type Z = [f64; 2];

const DRIVEN: Driven = Driven { sigma: 0.0, gamma: 1.0 };
const H: f64 = 0.02;
const STEPS: u64 = 10_000;
/// Steps between recorded nodes.
const STRIDE: u64 = 100;
const PATHS: u64 = 1000;

/// The four solutions at the end of one step of one path, `[q, p]` each.
#[derive(Clone, Copy)]
struct Solutions {
    exact: Z,
    conditional: Z,
    delta_plus: Z,
    midpoint: Z,
}

/// Calls `see(node, solutions)` at every node of a path.
fn follow(noise: &mut Wiener, mut see: impl FnMut(u64, Solutions)) -> Result<(), wzvi::Error> {
    let mut delta_plus = DRIVEN.stepper::<DeltaPlus>(H)?;
    let mut midpoint = DRIVEN.stepper::<Midpoint>(H)?;
    let rest: State<Point> = State::new([0.0], [0.0]);
    let (mut first, mut second, mut exact, mut conditional) = (rest, rest, [0.0; 2], [0.0; 2]);
    for step in 0..STEPS {
        let dw = exact_step(noise, &Interval { start: 0.0, h: H, step }, &mut exact)?;
        conditional_step(H, dw, &mut conditional);
        delta_plus.step(&mut first, &dw)?;
        midpoint.step(&mut second, &dw)?;
        let [delta_plus, midpoint] = [first, second].map(|state| [state.q[0], state.p[0]]);
        see(step + 1, Solutions { exact, conditional, delta_plus, midpoint });
    }
    Ok(())
}

fn rotate([q, p]: Z, angle: f64) -> Z {
    let (sin, cos) = angle.sin_cos();
    [cos * q + sin * p, cos * p - sin * q]
}

/// The exact solution over one step, but for O(h²) in the weights of the noise; answers the increments.
///
/// `∫ f dW = f(h) ΔW - ∫ f' (W - W(0)) ds` with `f` a sine or a cosine of `h - s`, and `f'` replaced by its mean.
fn exact_step(noise: &mut Wiener, interval: &Interval, z: &mut Z) -> Result<Z, NoiseError> {
    let (begin, end, h) = (interval.begin(), interval.end(), interval.h);
    let Driven { sigma, gamma } = DRIVEN;
    let (sin, cos) = h.sin_cos();
    let mut dw = [0.0; 2];
    *z = rotate(*z, h);
    for (process, (dw, intensity)) in dw.iter_mut().zip([sigma, gamma]).enumerate() {
        if intensity == 0.0 {
            continue;
        }
        *dw = noise.increment(process, begin, end)?;
        let mean = noise.area(process, begin, end)? / h;
        let by_sine = intensity * sin * mean;
        let by_cosine = intensity * (*dw - (1.0 - cos) * mean);
        // dW1 acts on q and turns towards -p, dW2 acts on p and turns towards q.
        let kick = if process == 0 { [by_cosine, -by_sine] } else { [by_sine, by_cosine] };
        *z = [z[0] + kick[0], z[1] + kick[1]];
    }
    Ok(dw)
}

/// `E[exact | increments]`: the paper's reference solution.
fn conditional_step(h: f64, dw: Z, z: &mut Z) {
    let Driven { sigma, gamma } = DRIVEN;
    let (sine, versine) = (h.sin() / h, 2.0 * (0.5 * h).sin().powi(2) / h);
    let [q, p] = rotate(*z, h);
    *z = [
        q + sigma * sine * dw[0] + gamma * versine * dw[1],
        p - sigma * versine * dw[0] + gamma * sine * dw[1],
    ];
}

fn energy([q, p]: Z) -> f64 {
    0.5 * (q * q + p * p)
}

fn main() -> Result<(), Box<dyn Error>> {
    let end = H * STEPS as f64;
    println!("dq = p dt, dp = -q dt + dW from rest, h = {H}, t ≤ {end}\n");
    one_path()?;

    let mut distances = [Mean::default(); 3];
    let mut energies = vec![[Mean::default(); 3]; (STEPS / STRIDE) as usize];
    let mut noise = Wiener::seed(1).unit(H);
    for path in 0..PATHS {
        noise.set_path(path);
        follow(&mut noise, |node, Solutions { exact, conditional, delta_plus, midpoint }| {
            if node == STEPS {
                for (mean, [q, p]) in distances.iter_mut().zip([conditional, delta_plus, midpoint]) {
                    mean.add((q - exact[0]).powi(2) + (p - exact[1]).powi(2));
                }
            }
            if node % STRIDE == 0 {
                let means = &mut energies[(node / STRIDE - 1) as usize];
                for (mean, z) in means.iter_mut().zip([exact, delta_plus, midpoint]) {
                    mean.add(energy(z));
                }
            }
        })?;
    }
    let growth = 0.5 * (DRIVEN.sigma.powi(2) + DRIVEN.gamma.powi(2));
    let last = energies[energies.len() - 1]
        .map(|mean| format!("{:.1} ± {:.1}", mean.value(), mean.standard_error()));
    let distance = distances.map(|mean| {
        let rms = mean.value().sqrt();
        format!("{rms:.4} ± {:.4}", 0.5 * mean.standard_error() / rms)
    });
    let [on_exact, on_first, on_second] = last;
    let [conditional, first, second] = distance;
    let row = |name: &str, distance: String, energy: String| [name.to_owned(), distance, energy];
    println!("\nOver {PATHS} paths, at t = {end}\n");
    table::print(
        ["", "rms distance from exact", "E[H]"],
        &[
            row("exact", String::new(), on_exact),
            row("E[exact | increments]", conditional, String::new()),
            row("DeltaPlus", first, on_first),
            row("Midpoint", second, on_second),
        ],
    );
    println!(
        "\n  Predicted: distance 0.0816 of E[exact | increments]; E[H] = (σ² + γ²) t/2 = {:.1}\n",
        growth * end
    );

    let time = |n: usize| (n + 1) as f64 * STRIDE as f64 * H;
    let curve = |which: usize| {
        let curve = energies.iter().enumerate().map(move |(n, means)| (time(n), means[which].value()));
        curve.collect::<Vec<_>>()
    };
    let panel = Figure::panel(format!("Mean energy of {PATHS} paths"), "time t", "E[H]")
        .points(Look::Broad, "exact solution", Colour::GREY, curve(0))
        .line("DeltaPlus", Colour::VERMILION, curve(1))
        .line("Midpoint", Colour::BLUE, curve(2))
        .points(Look::Dashed, "(σ² + γ²) t/2", Colour::INK, [(0.0, 0.0), (end, growth * end)]);
    plot::save("additive_noise", "energy", 1, (1400, 700), &[panel])
}

/// The paper's figure, and the distances to the exact solution on the same path.
fn one_path() -> Result<(), Box<dyn Error>> {
    let mut path = Vec::new();
    follow(&mut Wiener::seed(1).unit(H), |node, solutions| {
        if node % 10 == 0 {
            path.push((node as f64 * H, solutions));
        }
    })?;
    let curve = |of: fn(&Solutions) -> Z| path.iter().map(move |(t, all)| (*t, of(all)[0]));
    let distance = |of: fn(&Solutions) -> Z| {
        path.iter().map(move |(t, all)| {
            let ([q, p], exact) = (of(all), all.exact);
            (*t, (q - exact[0]).hypot(p - exact[1]))
        })
    };
    let panels = [
        Figure::panel("From rest, driven by one path", "time t", "q")
            .points(Look::Broad, "exact", Colour::GREY, curve(|all| all.exact))
            .line("DeltaPlus", Colour::VERMILION, curve(|all| all.delta_plus)),
        Figure::panel("Distance from the exact solution", "time t", "|z - exact|")
            .line("DeltaPlus", Colour::VERMILION, distance(|all| all.delta_plus))
            .line("Midpoint", Colour::BLUE, distance(|all| all.midpoint))
            .line("E[exact | increments]", Colour::GREEN, distance(|all| all.conditional)),
    ];
    plot::save("additive_noise", "path", 1, (1700, 620), &panels)
}
