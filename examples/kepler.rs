//! Kepler's problem, `H = |p|²/2 - 1/|q|`, on an orbit of eccentricity 0.6: the errors of the ellipse, of the energy and of
//! the angular momentum after many periods.
//!
//! Both embeddings conserve the angular momentum to rounding (it is bilinear in q and p) and the energy within bounds. The
//! ellipse precesses, at a rate of order h² for both: the error of order h in `DeltaPlus` returns after each period.
//!
//! Run with `cargo run --release --features svg --example kepler`.
//!
//! Units: the semi-major axis and the gravitational parameter are 1, so that the period is 2π.

#[path = "support/plot.rs"]
mod plot;
#[path = "support/table.rs"]
mod table;

use std::error::Error;
use std::f64::consts::TAU;

use wzvi::nalgebra::SVector;
use wzvi::plot::{Colour, Figure, Look};
use wzvi::prelude::*;

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) - 1.0 / (x * x + y * y).sqrt(),
    embedding = [DeltaPlus, Midpoint],
    invariant = [|[x, y], [px, py]| x * py - y * px],
)]
struct Kepler;

type Point = SVector<f64, 2>;

const ECCENTRICITY: f64 = 0.6;
const PERIODS: u64 = 1000;

fn main() -> Result<(), Box<dyn Error>> {
    println!("Kepler orbit, e = {ECCENTRICITY}, {PERIODS} periods\n");
    let mut rows = Vec::new();
    for steps in [250, 500, 1000, 2000] {
        rows.push(follow::<DeltaPlus>(steps)?.row("DeltaPlus", steps));
        rows.push(follow::<Midpoint>(steps)?.row("Midpoint", steps));
    }
    table::print(
        [
            "scheme",
            "steps/period",
            "max |H - H(0)|",
            "max |L - L(0)|",
            "perihelion turns by [°/period]",
            "Newton/step",
        ],
        &rows,
    );
    println!();

    let steps = 500;
    let (first, second) = (follow::<DeltaPlus>(steps)?, follow::<Midpoint>(steps)?);
    let orbit = |name: &str, color, run: &Run| {
        Figure::panel(format!("{name}, {steps} steps per period"), "x [a]", "y [a]")
            .equal_axes()
            .line("one period in 250", color, run.orbit.iter().copied())
            .points(Look::Marks, "centre", Colour::INK, [(0.0, 0.0)])
    };
    plot::save(
        "kepler",
        "orbit",
        2,
        (900, 900),
        &[orbit("DeltaPlus", Colour::VERMILION, &first), orbit("Midpoint", Colour::BLUE, &second)],
    )?;
    let panel = |title: &str, unit: &str, of: fn(&Period) -> f64| {
        let curve = |run: &Run| {
            let curve = run.periods.iter().enumerate().map(move |(n, period)| (n as f64 + 1.0, of(period)));
            curve.collect::<Vec<_>>()
        };
        let panel = Figure::panel(title, "periods", unit).log_y();
        panel.line("DeltaPlus", Colour::VERMILION, curve(&first)).line(
            "Midpoint",
            Colour::BLUE,
            curve(&second),
        )
    };
    let panels = [
        panel("Largest energy error of each period", "|H - H(0)|", |period| period.energy),
        panel("Largest error of the angular momentum of each period", "|L - L(0)|", |period| period.momentum),
        Figure::panel("Direction of the perihelion", "periods", "angle [°]")
            .line("DeltaPlus", Colour::VERMILION, first.perihelia.iter().copied())
            .line("Midpoint", Colour::BLUE, second.perihelia.iter().copied()),
    ];
    plot::save("kepler", "conservation", 1, (1500, 560), &panels)
}

/// What one period did.
#[derive(Clone, Copy, Default)]
struct Period {
    /// Largest error of the energy.
    energy: f64,
    /// Largest error of the angular momentum.
    momentum: f64,
}

struct Run {
    periods: Vec<Period>,
    /// One period in 250.
    orbit: Vec<(f64, f64)>,
    /// Time in periods and direction of the Laplace-Runge-Lenz vector in degrees, unwound.
    perihelia: Vec<(f64, f64)>,
    iterations: f64,
}

fn follow<E>(steps: u64) -> Result<Run, wzvi::Error>
where
    Kepler: Discretized<E, Vector = Point>,
{
    let speed = ((1.0 + ECCENTRICITY) / (1.0 - ECCENTRICITY)).sqrt();
    let start = State::new([1.0 - ECCENTRICITY, 0.0], [0.0, speed]);
    let (energy, momentum) = (Kepler.energy(&start), Kepler.invariant(0, &start));
    let mut periods = vec![Period::default(); PERIODS as usize];
    let (mut orbit, mut perihelia, mut angle, mut before) = (Vec::new(), Vec::new(), 0.0, false);
    let path = Kepler
        .simulate::<E>(TAU / steps as f64)
        .start(start)
        .steps(PERIODS * steps)
        .record_every(0)
        .inspect(|state, node| {
            match node.step % (250 * steps) {
                step if step <= steps => orbit.push((state.q[0], state.q[1])),
                step if step == steps + 1 => orbit.push((f64::NAN, f64::NAN)),
                _ => {}
            }
            let Some(last) = node.step.checked_sub(1) else { return };
            let period = &mut periods[(last / steps) as usize];
            period.energy = period.energy.max((Kepler.energy(state) - energy).abs());
            period.momentum = period.momentum.max((Kepler.invariant(0, state) - momentum).abs());
            // At aphelion, where the direction of the axis is disturbed least.
            let inwards = state.q.dot(&state.p) < 0.0;
            if inwards && !before {
                let now = perihelion(state).to_degrees();
                angle += (now - angle + 180.0).rem_euclid(360.0) - 180.0;
                perihelia.push((state.t / TAU, angle));
            }
            before = inwards;
        })
        .run()?;
    let iterations = path.iterations().total as f64 / path.steps() as f64;
    Ok(Run { periods, orbit, perihelia, iterations })
}

/// Direction of `p × L - q/|q|`.
fn perihelion(state: &State<Point>) -> f64 {
    let (q, p) = (&state.q, &state.p);
    let momentum = Kepler.invariant(0, state);
    let axis = [p[1] * momentum - q[0] / q.norm(), -p[0] * momentum - q[1] / q.norm()];
    axis[1].atan2(axis[0])
}

impl Run {
    fn row(&self, name: &str, steps: u64) -> [String; 6] {
        let largest = |of: fn(&Period) -> f64| self.periods.iter().map(of).fold(0.0, f64::max);
        let turn = match self.perihelia.as_slice() {
            [first, .., last] => (last.1 - first.1) / (last.0 - first.0),
            _ => f64::NAN,
        };
        [
            name.into(),
            steps.to_string(),
            format!("{:.1e}", largest(|period| period.energy)),
            format!("{:.1e}", largest(|period| period.momentum)),
            format!("{turn:+.4}"),
            format!("{:.2}", self.iterations),
        ]
    }
}
