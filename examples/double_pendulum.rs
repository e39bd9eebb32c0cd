//! The double pendulum: two starts 10⁻⁹ rad apart, the rate at which they separate (the largest Lyapunov exponent), and the
//! energy meanwhile. The mass matrix depends on the angles, so that the mid-point step is implicit in all four unknowns.
//!
//! Run with `cargo run --release --features svg --example double_pendulum`.
//!
//! Units: both masses, both lengths and gravity are 1.

#[path = "support/plot.rs"]
mod plot;
#[path = "support/table.rs"]
mod table;

use std::error::Error;

use wzvi::nalgebra::SVector;
use wzvi::plot::{Colour, Figure, Look};
use wzvi::prelude::*;

#[hamiltonian(
    drift = |[a, b], [pa, pb]| {
        let (sin, cos) = (a - b).sin_cos();
        let kinetic = (pa * pa + 2.0 * pb * pb - 2.0 * pa * pb * cos) / (2.0 * (1.0 + sin * sin));
        kinetic - 2.0 * a.cos() - b.cos()
    },
    embedding = Midpoint,
)]
struct DoublePendulum;

type Pair = State<SVector<f64, 2>>;

/// The start, in rad from hanging: both rods above the horizontal, at rest.
const START: [f64; 2] = [2.0, 2.5];
const APART: f64 = 1e-9;
const H: f64 = 0.01;
/// Time of the Lyapunov estimate.
const LONG: f64 = 5000.0;

fn main() -> Result<(), Box<dyn Error>> {
    let plan = <DoublePendulum as Discretized<Midpoint>>::PLAN;
    println!("Double pendulum from rest at {START:?} rad");
    println!("Midpoint: {:?}, {} coupled unknowns\n", plan.solver, plan.unknowns);

    let mut rows = Vec::new();
    for h in [0.04, 0.02, 0.01] {
        let path =
            DoublePendulum.simulate::<Midpoint>(h).start(start(0.0)).until(LONG).record_every(5).run()?;
        let newton = path.iterations().total as f64 / path.steps() as f64;
        rows.push([
            format!("{h}"),
            format!("{:.1e}", path.energy_drift(&DoublePendulum)),
            format!("{:.1e}", path.shadow_energy_drift(&DoublePendulum)),
            format!("{newton:.2}"),
            path.iterations().largest.to_string(),
            format!("{:.3}", lyapunov(h)?),
        ]);
    }
    table::print(
        ["h", "max |H - H(0)|", "of the modified energy", "Newton/step", "at most", "Lyapunov exponent"],
        &rows,
    );
    println!(
        "\n  Over t ≤ {LONG}; the exponent from two paths that are brought back to {APART:.0e} apart every time unit.\n"
    );

    let run = |apart: f64| {
        DoublePendulum.simulate::<Midpoint>(H).start(start(apart)).until(100.0).record_every(2).run()
    };
    let (first, second) = (run(0.0)?, run(APART)?);
    let exponent = lyapunov(H)?;
    let angle = |path: &Trajectory<SVector<f64, 2>, Midpoint>| {
        path.iter().map(|state| (state.t, state.q[1])).collect::<Vec<_>>()
    };
    let separations = first.iter().zip(&second).map(|(a, b)| (a.t, separation(a, b)));
    let energy = DoublePendulum.energy(&first.states()[0]);
    let errors = first.iter().map(|state| (state.t, DoublePendulum.energy(state) - energy));
    let time = "time t [√(l/g)]";
    let growth = (0..=100).map(|t| (f64::from(t), APART * (exponent * f64::from(t)).exp()));
    let panels = [
        Figure::panel("Angle of the lower rod from two starts 1e-9 rad apart", time, "angle [rad]")
            .line("first", Colour::BLUE, angle(&first))
            .line("second", Colour::VERMILION, angle(&second)),
        Figure::panel("Distance in phase space", time, "distance")
            .log_y()
            .y_range(1e-10..1e2)
            .line("measured", Colour::BLUE, separations)
            .points(
                Look::Dashed,
                format!("1e-9 exp({exponent:.2} t), from the long run"),
                Colour::GREY,
                growth,
            ),
        Figure::panel("Energy error", time, "H - H(0) [m g l]").line("first", Colour::BLUE, errors),
    ];
    plot::save("double_pendulum", "chaos", 1, (1500, 560), &panels)
}

fn start(apart: f64) -> Pair {
    State::new([START[0] + apart, START[1]], [0.0, 0.0])
}

fn separation(a: &Pair, b: &Pair) -> f64 {
    ((a.q - b.q).norm_squared() + (a.p - b.p).norm_squared()).sqrt()
}

/// Mean growth rate of a small separation (Benettin's method).
fn lyapunov(h: f64) -> Result<f64, wzvi::Error> {
    let mut steppers = [DoublePendulum.stepper::<Midpoint>(h)?, DoublePendulum.stepper::<Midpoint>(h)?];
    let (mut first, mut second, mut sum) = (start(0.0), start(APART), 0.0);
    let (units, steps) = (LONG as u64, (1.0 / h).round() as u64);
    for _ in 0..units {
        for _ in 0..steps {
            steppers[0].step(&mut first, &[])?;
            steppers[1].step(&mut second, &[])?;
        }
        let growth = separation(&first, &second) / APART;
        sum += growth.ln();
        second.q = first.q + (second.q - first.q) / growth;
        second.p = first.p + (second.p - first.p) / growth;
    }
    Ok(sum / (units * steps) as f64 / h)
}
