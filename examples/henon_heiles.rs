//! Hénon and Heiles: Poincaré sections `x = 0, px > 0` of `H = |p|²/2 + |q|²/2 + x² y - y³/3` at E = 1/12, where nearly
//! every orbit keeps to a curve, and E = 1/8, where some fill an area.
//!
//! Run with `cargo run --release --example henon_heiles`.

#[path = "support/plot.rs"]
mod plot;
#[path = "support/table.rs"]
mod table;

use std::error::Error;

use plot::{BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, Panel, SKY, VERMILION};
use wzvi::prelude::*;

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py + x * x + y * y) + x * x * y - y * y * y / 3.0,
    embedding = Midpoint,
)]
struct HenonHeiles;

const H: f64 = 0.02;
const END: f64 = 8000.0;

fn main() -> Result<(), Box<dyn Error>> {
    println!("Hénon-Heiles, Midpoint, h = {H}, t ≤ {END}\n");
    let colors = [BLUE, VERMILION, GREEN, ORANGE, PURPLE, SKY, BLACK];
    // (y, py) on the section.
    let regular = [(0.0, 0.05), (0.0, 0.12), (0.0, 0.17), (0.0, -0.17), (0.0, 0.3), (0.18, 0.0), (-0.3, 0.0)];
    let mixed = [(0.0, 0.07), (0.0, 0.15), (0.0, 0.4), (0.15, 0.0), (0.25, 0.0), (-0.15, 0.0), (-0.27, 0.0)];
    let (mut rows, mut panels) = (Vec::new(), Vec::new());
    for (name, energy, starts) in [("1/12", 1.0 / 12.0, regular), ("1/8", 0.125, mixed)] {
        let mut panel = Panel::new(&format!("E = {name}: section x = 0, px > 0"), "y", "py")
            .equal_axes()
            .line("edge of what the energy allows", GREY, edge(energy));
        for ((y, py), color) in starts.into_iter().zip(colors) {
            let Section { points, drift, iterations } = section(energy, y, py)?;
            rows.push([
                name.into(),
                format!("({y}, {py})"),
                points.len().to_string(),
                format!("{drift:.1e}"),
                format!("{iterations:.2}"),
            ]);
            panel = panel.dots("", color, 3, points);
        }
        panels.push(panel);
    }
    table::print(["E", "start (y, py)", "crossings", "max |H - E|", "Newton/step"], &rows);
    println!();
    plot::save("henon_heiles", "sections", 2, (1000, 1000), &panels)
}

/// Where `px = 0` on the section: `py² + y² - 2 y³/3 = 2 E`, in polar coordinates by bisection.
fn edge(energy: f64) -> impl Iterator<Item = (f64, f64)> {
    (0..=360).map(move |degree| {
        let (sin, cos) = f64::from(degree).to_radians().sin_cos();
        let inside = |r: f64| r * r * (1.0 - 2.0 / 3.0 * r * cos.powi(3)) < 2.0 * energy;
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if inside(middle) { low = middle } else { high = middle }
        }
        (low * cos, low * sin)
    })
}

struct Section {
    points: Vec<(f64, f64)>,
    drift: f64,
    iterations: f64,
}

/// The orbit of energy `energy` that starts on the section.
fn section(energy: f64, y: f64, py: f64) -> Result<Section, Box<dyn Error>> {
    let square = 2.0 * energy - py * py - y * y + 2.0 * y * y * y / 3.0;
    if square < 0.0 {
        return Err(format!("no orbit of energy {energy} passes (y, py) = ({y}, {py})").into());
    }
    let start = State::new([0.0, y], [square.sqrt(), py]);
    let (mut points, mut drift) = (vec![(y, py)], 0.0_f64);
    let mut before = start;
    let path = HenonHeiles
        .simulate::<Midpoint>(H)
        .start(start)
        .until(END)
        .record_every(0)
        .inspect(|state, _| {
            drift = drift.max((HenonHeiles.energy(state) - energy).abs());
            if before.q[0] < 0.0 && state.q[0] >= 0.0 {
                let part = -before.q[0] / (state.q[0] - before.q[0]);
                let between = |from: f64, to: f64| from + part * (to - from);
                points.push((between(before.q[1], state.q[1]), between(before.p[1], state.p[1])));
            }
            before = *state;
        })
        .run()?;
    let iterations = path.iterations().total as f64 / path.steps() as f64;
    Ok(Section { points, drift, iterations })
}
