//! Hénon and Heiles: Poincaré sections `x = 0, px > 0` of `H = |p|²/2 + |q|²/2 + x² y - y³/3` at E = 1/12, where nearly
//! every orbit keeps to a curve, and E = 1/8, where some fill an area (M. Hénon, C. Heiles, Astron. J. 69, 1964, figures 4 and 5).
//!
//! Crossings are found on the dense output of long steps, so that points of the section are as exact as the steps themselves. The dimension of the
//! set of points distinguishes the orbits: one for a curve, two for an area.
//!
//! Run with `cargo run --release --features svg --example henon_heiles`.

#[path = "support/plot.rs"]
mod plot;
#[path = "support/table.rs"]
mod table;

use std::collections::BTreeSet;
use std::error::Error;

use wzvi::plot::{Colour, Figure, Look};
use wzvi::prelude::*;
use wzvi::section::Direction;

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py + x * x + y * y) + x * x * y - y * y * y / 3.0,
    embedding = Gauss<8>,
)]
struct HenonHeiles;

const H: f64 = 0.25;
const END: f64 = 40_000.0;

fn main() -> Result<(), Box<dyn Error>> {
    println!("Hénon-Heiles, Gauss<8>, h = {H}, t ≤ {END}\n");
    let colors = [
        Colour::BLUE,
        Colour::VERMILION,
        Colour::GREEN,
        Colour::OCHRE,
        Colour::PURPLE,
        Colour::VIOLET,
        Colour::INK,
    ];
    // (y, py) on the section.
    let regular = [(0.0, 0.05), (0.0, 0.12), (0.0, 0.17), (0.0, -0.17), (0.0, 0.3), (0.18, 0.0), (-0.3, 0.0)];
    let mixed = [(0.0, 0.07), (0.0, 0.15), (0.0, 0.4), (0.15, 0.0), (0.25, 0.0), (-0.15, 0.0), (-0.27, 0.0)];
    let (mut rows, mut panels) = (Vec::new(), Vec::new());
    for (name, energy, starts) in [("1/12", 1.0 / 12.0, regular), ("1/8", 0.125, mixed)] {
        let mut panel = Figure::panel(format!("E = {name}: section x = 0, px > 0"), "y", "py")
            .equal_axes()
            .line("boundary at this energy", Colour::GREY, edge(energy));
        for ((y, py), color) in starts.into_iter().zip(colors) {
            let Section { points, drift, off } = section(energy, y, py)?;
            let dimension = dimension(&points);
            rows.push([
                name.into(),
                format!("({y}, {py})"),
                points.len().to_string(),
                format!("{drift:.1e}"),
                format!("{off:.1e}"),
                format!("{dimension:.2}"),
                if dimension > 1.3 { "fills an area" } else { "keeps to a curve" }.into(),
            ]);
            panel = panel.points(Look::FineDots, "", color, points);
        }
        panels.push(panel);
    }
    let headings =
        ["E", "start (y, py)", "crossings", "max |H - E| on it", "max |x| on it", "dimension", "the orbit"];
    table::print(headings, &rows);
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
    /// The largest error of the energy at the crossings.
    drift: f64,
    /// The largest distance of a crossing from the section.
    off: f64,
}

/// The orbit of energy `energy` that starts on the section.
fn section(energy: f64, y: f64, py: f64) -> Result<Section, Box<dyn Error>> {
    let square = 2.0 * energy - py * py - y * y + 2.0 * y * y * y / 3.0;
    if square < 0.0 {
        return Err(format!("no orbit of energy {energy} passes (y, py) = ({y}, {py})").into());
    }
    let path = HenonHeiles
        .simulate::<Gauss<8>>(H)
        .start(State::new([0.0, y], [square.sqrt(), py]))
        .until(END)
        .record_every(0)
        .section_towards(Direction::Rising, |state| state.q[0])
        .run()?;
    let states = || path.crossings().iter().map(|crossing| &crossing.state);
    Ok(Section {
        points: states().map(|state| (state.q[1], state.p[1])).collect(),
        drift: states().map(|state| (HenonHeiles.energy(state) - energy).abs()).fold(0.0, f64::max),
        off: states().map(|state| state.q[0].abs()).fold(0.0, f64::max),
    })
}

/// The box-counting dimension: the number of occupied squares of side `a` grows like `a^(-dimension)`, here from 0.08 to 0.01.
fn dimension(points: &[(f64, f64)]) -> f64 {
    let squares = |side: f64| {
        let square = |&(y, py): &(f64, f64)| [y, py].map(|x| (x / side).floor() as i64);
        points.iter().map(square).collect::<BTreeSet<_>>().len() as f64
    };
    (squares(0.01) / squares(0.08)).ln() / 8.0_f64.ln()
}
