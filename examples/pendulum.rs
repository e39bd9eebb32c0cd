//! The pendulum, `H = p²/2 - cos q`: phase portrait with its separatrix, energy over a long time, the period against the
//! exact one, and the cost of a step, for the two basic embeddings.
//!
//! Run with `cargo run --release --features svg --example pendulum`.
//!
//! Units: mass, length and gravity are 1, so that small swings have period 2π and energy is in units of m g l.

#[path = "support/plot.rs"]
mod plot;
#[path = "support/table.rs"]
mod table;

use std::error::Error;
use std::f64::consts::TAU;
use std::time::Instant;

use wzvi::nalgebra::SVector;
use wzvi::plot::{Colour, Figure, Look};
use wzvi::prelude::*;

type Point = SVector<f64, 1>;

#[hamiltonian(
    drift = |q, p| 0.5 * p * p - q.cos(),
    embedding = [DeltaPlus, Midpoint],
)]
struct Pendulum;

/// The widest swing of the long run, in rad.
const SWING: f64 = 2.5;
const STEPS: u64 = 200_000;

fn main() -> Result<(), Box<dyn Error>> {
    println!("Pendulum, H = p²/2 - cos q, released at rest from q = {SWING} rad\n");
    let exact = exact_period(SWING);
    let rows = [0.2, 0.1, 0.05, 0.025]
        .into_iter()
        .flat_map(|h| [row::<DeltaPlus>("DeltaPlus", h, exact), row::<Midpoint>("Midpoint", h, exact)]);
    let rows = rows.collect::<Result<Vec<_>, _>>()?;
    table::print(["scheme", "h", "max |H - H(0)|", "period", "error", "Newton/step", "ns/step"], &rows);
    println!("\n  {STEPS} steps each; exact period 2π / agm(1, cos(q/2)) = {exact:.6}");
    println!(
        "  The energy error does not grow; halving h divides it by 2 (DeltaPlus) and by 4 (Midpoint).\n"
    );

    plot::save("pendulum", "portrait", 1, (1500, 1000), &[portrait()?])?;
    plot::save("pendulum", "energy", 1, (1500, 620), &[energy()?])?;
    Ok(())
}

/// `4 K(sin(q/2)) = 2π / agm(1, cos(q/2))`.
fn exact_period(swing: f64) -> f64 {
    let (mut a, mut g) = (1.0, (0.5 * swing).cos());
    while a - g > 1e-15 {
        (a, g) = (0.5 * (a + g), f64::sqrt(a * g));
    }
    TAU / a
}

fn row<E>(name: &str, h: f64, exact: f64) -> Result<[String; 7], wzvi::Error>
where
    Pendulum: Discretized<E, Vector = Point>,
{
    let start = State::new([SWING], [0.0]);
    let (mut worst, energy) = (0.0_f64, Pendulum.energy(&start));
    // Times at which p passes zero from above, where the swing is at its end.
    let (mut before, mut turns) = ((0.0, 0.0), Vec::new());
    Pendulum
        .simulate::<E>(h)
        .start(start)
        .steps(STEPS)
        .record_every(0)
        .inspect(|state, _| {
            worst = worst.max((Pendulum.energy(state) - energy).abs());
            let now = (state.t, state.p[0]);
            if before.1 > 0.0 && now.1 <= 0.0 {
                turns.push(before.0 + (now.0 - before.0) * before.1 / (before.1 - now.1));
            }
            before = now;
        })
        .run()?;
    let period = (turns[turns.len() - 1] - turns[0]) / (turns.len() - 1) as f64;

    // The best of several runs excludes other work of the machine.
    let (mut cost, mut iterations) = (f64::INFINITY, 0.0);
    for _ in 0..5 {
        let clock = Instant::now();
        let path = Pendulum.simulate::<E>(h).start(start).steps(STEPS).record_every(0).run()?;
        cost = cost.min(clock.elapsed().as_secs_f64() / STEPS as f64);
        iterations = path.iterations().total as f64 / STEPS as f64;
    }
    Ok([
        name.into(),
        format!("{h}"),
        format!("{worst:.2e}"),
        format!("{period:.6}"),
        format!("{:.1e}", (period - exact).abs()),
        format!("{iterations:.2}"),
        format!("{:.1}", cost * 1e9),
    ])
}

/// Swings inside the separatrix, rotations outside, at h = 0.05.
fn portrait() -> Result<Figure, wzvi::Error> {
    let mut panel = Figure::panel(
        "Pendulum: phase portrait, Midpoint, h = 0.05",
        "angle q [rad]",
        "momentum p [m √(g l³)]",
    )
    .x_range(-TAU..TAU)
    .y_range(-3.0..3.0);
    let mut labels = ["swings", "rotations"];
    let swings = [0.5, 1.0, 1.5, 2.0, 2.5, 2.9].map(|q| (0, q, 0.0, 14.0));
    let rotations = [2.1, 2.3, 2.6].map(|p| (1, -TAU, p, 14.0));
    for (kind, q, p, time) in swings.into_iter().chain(rotations) {
        let path = Pendulum.simulate::<Midpoint>(0.05).start(State::new([q], [p])).until(time).run()?;
        let points: Vec<(f64, f64)> = path.iter().map(|state| (state.q[0], state.p[0])).collect();
        let color = [Colour::BLUE, Colour::VERMILION][kind];
        // The portrait is 2π-periodic in q and symmetric in p.
        for shift in if kind == 0 { vec![-TAU, 0.0, TAU] } else { vec![0.0] } {
            let label = std::mem::take(&mut labels[kind]);
            panel = panel.line(label, color, points.iter().map(|&(q, p)| (q + shift, p)));
        }
        if kind == 1 {
            panel = panel.line("", color, points.iter().map(|&(q, p)| (-q, -p)));
        }
    }
    let separatrix = |sign: f64| {
        (-200..=200)
            .map(move |i| f64::from(i) * TAU / 200.0)
            .map(move |q| (q, sign * 2.0 * (0.5 * q).cos().abs()))
    };
    Ok(panel.points(Look::Dashed, "separatrix p = ±2 cos(q/2)", Colour::GREY, separatrix(1.0)).points(
        Look::Dashed,
        "",
        Colour::GREY,
        separatrix(-1.0),
    ))
}

fn energy() -> Result<Figure, wzvi::Error> {
    let panel = Figure::panel(
        "Pendulum: largest energy error of each swing, h = 0.05, released at 2.5 rad",
        "time t [√(l/g)]",
        "max |H - H(0)| [m g l]",
    )
    .log_y()
    .y_range(1e-4..1e-1);
    let panel = panel.line("DeltaPlus", Colour::VERMILION, errors::<DeltaPlus>()?);
    Ok(panel.line("Midpoint", Colour::BLUE, errors::<Midpoint>()?))
}

/// The largest error of each swing.
fn errors<E>() -> Result<Vec<(f64, f64)>, wzvi::Error>
where
    Pendulum: Discretized<E, Vector = Point>,
{
    const SWINGS: usize = 1000;
    let start = State::new([SWING], [0.0]);
    let (energy, period) = (Pendulum.energy(&start), exact_period(SWING));
    let mut worst = [0.0_f64; SWINGS];
    Pendulum
        .simulate::<E>(0.05)
        .start(start)
        .until(SWINGS as f64 * period)
        .whole_steps()
        .record_every(0)
        .inspect(|state, _| {
            let swing = ((state.t / period) as usize).min(SWINGS - 1);
            worst[swing] = worst[swing].max((Pendulum.energy(state) - energy).abs());
        })
        .run()?;
    Ok(worst.iter().enumerate().map(|(swing, &error)| ((swing as f64 + 0.5) * period, error)).collect())
}
