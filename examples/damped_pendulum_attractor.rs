//! The driven and damped pendulum: a motion of period one, one of period three, and a strange attractor.
//!
//! `q'' = -sin q - γ q' + a cos(ω t)` with `γ = 1/2` and `ω = 2/3`. The state is recorded once in each period of the drive: a periodic path gives a few
//! points, and a chaotic one fills a set of fractal dimension (E. Ott, *Chaos in Dynamical Systems*, section 1.5; J. P. Gollub, G. L. Baker, *Chaotic Dynamics*, 1990,
//! section 3.3, have this pendulum). What is checked:
//!
//! * **Friction**: the flow shrinks areas by `e^{-γ t}`, for any drive, and each step of `Gauss<3>` by `e^{-γ h}` to rounding.
//! * **Energy**: the work of the drive minus the loss by friction is the change of the energy, to the error of the scheme.
//! * **Dimension**: a motion of period three has the dimension 0; the attractor at `a = 1.5` lies between a curve and an area.
//!
//! `cargo run --release --features svg --example damped_pendulum_attractor`, a few seconds

#[path = "support/plot.rs"]
mod plot;
#[path = "support/table.rs"]
mod table;

use std::collections::BTreeSet;
use std::error::Error;
use std::f64::consts::{PI, TAU};

use wzvi::plot::{Colour, Figure, Look};
use wzvi::prelude::*;

/// A pendulum with friction and a drive.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p - q.cos(),
    force = |_q, _p, t| amplitude * (omega * t).cos(),
    friction = gamma,
    embedding = Gauss<3>,
)]
#[derive(Clone, Debug)]
pub struct Pendulum {
    /// Of the drive.
    pub amplitude: f64,
    /// Angular frequency of the drive.
    pub omega: f64,
    /// Rate of the friction.
    pub gamma: f64,
}

const OMEGA: f64 = 2.0 / 3.0;
const GAMMA: f64 = 0.5;
/// Steps in a period of the drive.
const STEPS: u64 = 64;
/// Periods that are discarded, and that are recorded.
const FORGOTTEN: u64 = 300;
const SEEN: u64 = 20_000;

struct Section {
    points: Vec<(f64, f64)>,
    /// The work of the scheme alone, and all of it.
    imbalance: f64,
    work: f64,
}

fn section(amplitude: f64) -> Result<Section, Box<dyn Error>> {
    let pendulum = Pendulum { amplitude, omega: OMEGA, gamma: GAMMA };
    let start = State::new([0.2], [0.0]);
    let run = pendulum.simulate::<Gauss<3>>(TAU / OMEGA / STEPS as f64).start(start);
    let path = run.steps(STEPS * (FORGOTTEN + SEEN)).record_every(STEPS).run()?;
    let turned = |q: f64| (q + PI).rem_euclid(TAU) - PI;
    let seen = path.states().iter().skip(FORGOTTEN as usize);
    Ok(Section {
        points: seen.map(|state| (turned(state.q[0]), state.p[0])).collect(),
        imbalance: path.shadow_work().unwrap_or(f64::NAN).abs(),
        work: path.work(),
    })
}

/// `det ∂(q', p')/∂(q, p)` of one step, by differences of long steps in both directions.
fn shrinking() -> Result<f64, Box<dyn Error>> {
    let pendulum = Pendulum { amplitude: 1.5, omega: OMEGA, gamma: GAMMA };
    let mut stepper = pendulum.stepper::<Gauss<3>>(TAU / OMEGA / STEPS as f64)?;
    let apart = 1e-4;
    let mut columns = [[0.0; 2]; 2];
    for (axis, column) in columns.iter_mut().enumerate() {
        for (sign, weight) in [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)] {
            let moved = |which: usize| if axis == which { sign * apart } else { 0.0 };
            let mut state = State::new([0.7 + moved(0)], [0.3 + moved(1)]);
            stepper.step(&mut state, &[])?;
            column[0] += weight * state.q[0] / (12.0 * apart);
            column[1] += weight * state.p[0] / (12.0 * apart);
        }
    }
    let [[a, b], [c, d]] = columns;
    Ok(a * d - b * c)
}

/// Squares of side `a` with points in them grow in number like `a^(-dimension)`.
fn dimension(points: &[(f64, f64)]) -> f64 {
    let squares = |side: f64| {
        let square = |&(q, p): &(f64, f64)| [q, p].map(|x| (x / side).floor() as i64);
        points.iter().map(square).collect::<BTreeSet<_>>().len() as f64
    };
    (squares(0.02) / squares(0.16)).ln() / 8.0_f64.ln()
}

fn main() -> Result<(), Box<dyn Error>> {
    println!(
        "Pendulum with γ = {GAMMA}, ω = 2/3, Gauss<3>, {STEPS} steps in a period of the drive, {SEEN} periods\n"
    );
    let h = TAU / OMEGA / STEPS as f64;
    let (determinant, exact) = (shrinking()?, (-GAMMA * h).exp());
    println!("an area shrinks in a step by {determinant:.12}, e^(-γ h) is {exact:.12}\n");
    let (mut rows, mut panels) = (Vec::new(), Vec::new());
    let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
    for (amplitude, color) in [(0.9, Colour::BLUE), (1.09, Colour::GREEN), (1.5, Colour::VERMILION)] {
        let Section { points, imbalance, work } = section(amplitude)?;
        let dimension = dimension(&points);
        let places: BTreeSet<_> =
            points.iter().map(|&(q, p)| [q, p].map(|x| (x * 1e6).round() as i64)).collect();
        rows.push([
            format!("{amplitude}"),
            if places.len() < 100 { places.len().to_string() } else { "all different".into() },
            format!("{dimension:.2}"),
            format!("{work:.1}"),
            format!("{:.1e}", imbalance / work),
        ]);
        let look = if places.len() < 100 { Look::Dots } else { Look::FineDots };
        let figure = Figure::panel(format!("a = {amplitude}"), "angle q", "q'").x_range(-PI..PI);
        for &(_, speed) in &points {
            ends = [ends[0].min(speed), ends[1].max(speed)];
        }
        panels.push(figure.points(look, "", color, points));
    }
    // One scale for all: a section of one point would be drawn as large as its rounding.
    let panels: Vec<Figure> =
        panels.into_iter().map(|panel| panel.y_range(ends[0] - 0.2..ends[1] + 0.2)).collect();
    let headings = [
        "amplitude a",
        "points of the section",
        "dimension",
        "work of the drive",
        "error of the energy balance / work",
    ];
    table::print(headings, &rows);
    println!();
    plot::save("damped_pendulum_attractor", "sections", 3, (900, 800), &panels)
}
