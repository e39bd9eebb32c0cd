//! Lagrange's top by its rotation matrix: nutation of the axis for three starts, the three integrals along the path, and the error
//! against the run time for orders 2, 4 and 6.
//!
//! Run with `cargo run --release --features svg --example top`, a few seconds.
//!
//! Units: the moment of inertia across the axis is 1, and so is weight times distance to the fixed point.

#[path = "support/plot.rs"]
mod plot;
#[path = "support/table.rs"]
mod table;

use std::error::Error;
use std::f64::consts::TAU;
use std::time::Instant;

use wzvi::constraints::RigidBody;
use wzvi::nalgebra::{Rotation3, SVector, Vector3};
use wzvi::plot::{Colour, Figure};
use wzvi::prelude::*;

#[hamiltonian(
    drift = |q: Rotation, p| {
        let kinetic = |i: usize| {
            (p[i][0] * p[i][0] + p[i][1] * p[i][1]) / (2.0 * across) + p[i][2] * p[i][2] / (2.0 * along)
        };
        kinetic(0) + kinetic(1) + kinetic(2) + q[2][2]
    },
    embedding = Rattle,
    invariant = [
        vertical = |q, p| (0..3).map(|a| q[0][a] * p[1][a] - q[1][a] * p[0][a]).sum::<f64>(),
        axial = |q, p| (0..3).map(|i| q[i][0] * p[i][1] - q[i][1] * p[i][0]).sum::<f64>(),
    ],
)]
struct Top {
    /// Masses of the columns of `q`.
    across: f64,
    along: f64,
}

type TopState = State<SVector<f64, 9>>;

const INERTIA: [f64; 3] = [1.0, 1.0, 0.5];
/// Radians per time.
const SPIN: f64 = 8.0;
/// Of the axis from the vertical, in radians.
const TILT: f64 = 0.7;

/// The axis at [`TILT`], with the angular velocity `precession` about the vertical and [`SPIN`] about the axis.
fn start(body: &RigidBody, precession: f64) -> TopState {
    let attitude = Rotation3::from_axis_angle(&Vector3::x_axis(), TILT);
    let vertical = attitude.inverse() * Vector3::z();
    body.state(attitude, precession * vertical + SPIN * Vector3::z())
}

fn main() -> Result<(), Box<dyn Error>> {
    let body = RigidBody::new(INERTIA)?;
    let [across, _, along] = body.masses();
    let top = Top { across, along };
    println!("Lagrange's top, spin {SPIN}, tilt {TILT}\n");

    let mut panels = Vec::new();
    for (title, precession) in [
        ("The axis is pushed back: loops", -0.4),
        ("The axis is let go: cusps", 0.0),
        ("The axis is pushed on: waves", 0.12),
    ] {
        let path = top.simulate::<Rattle>(0.01).start(start(&body, precession)).until(40.0).run()?;
        let axis = path.iter().map(|state| (state.q[2], state.q[5]));
        let edge = (0..=360).map(|k| (f64::from(k) * TAU / 360.0).sin_cos());
        let panel = Figure::panel(title, "x of the axis", "y of the axis")
            .equal_axes()
            .line("the sphere from above", Colour::GREY, edge)
            .line("the axis", Colour::BLUE, axis);
        panels.push(panel);
    }

    let path = top.simulate::<Rattle>(0.01).start(start(&body, 0.0)).until(1000.0).record_every(100).run()?;
    let first = path.states()[0];
    let momentum = |state: &TopState| body.angular_momentum_in_space(state).z;
    let axial = |state: &TopState| body.angular_momentum_in_body(state).z;
    let drift = |of: &dyn Fn(&TopState) -> f64| {
        path.iter().map(|state| (of(state) - of(&first)).abs()).fold(0.0, f64::max)
    };
    println!("  100 000 steps of 0.01; largest deviations from the start:");
    println!("  energy {:.1e}", drift(&|state| top.energy(state)));
    println!(
        "  angular momentum about the vertical {:.1e}, about the axis {:.1e}",
        drift(&momentum),
        drift(&axial)
    );
    let error_of_matrix = |state: &TopState| {
        let attitude = body.attitude(state);
        (attitude.matrix().tr_mul(attitude.matrix()) - wzvi::nalgebra::Matrix3::identity()).amax()
    };
    println!("  QᵀQ - 1: {:.1e}\n", drift(&error_of_matrix));

    let reference = end::<Composed<Rattle, KahanLi6>>(&top, &body, 1e-3)?.0;
    let mut figure = Figure::panel("Error of the axis at t = 5", "run time [s]", "error").log_log();
    let mut rows = Vec::new();
    let schemes: [(&str, usize, Run, f64); 3] = [
        ("Rattle", Colour::BLUE, end::<Rattle>, 0.02),
        ("Suzuki4", Colour::VERMILION, end::<Composed<Rattle, Suzuki4>>, 0.05),
        ("KahanLi6", Colour::GREEN, end::<Composed<Rattle, KahanLi6>>, 0.1),
    ];
    for (name, colour, run, largest) in schemes {
        let mut points = Vec::new();
        for halvings in 0..5 {
            let h = largest / f64::from(1 << halvings);
            let (axis, seconds) = run(&top, &body, h)?;
            let error = (axis - reference).norm();
            points.push((seconds, error));
            rows.push([
                name.to_owned(),
                format!("{h:.1e}"),
                format!("{error:.1e}"),
                format!("{:.2}", 1e3 * seconds),
            ]);
        }
        figure = figure.line(name, colour, points);
    }
    table::print(["scheme", "step", "error at t = 5", "time [ms]"], &rows);
    println!();
    panels.push(figure);
    plot::save("top", "nutation", 2, (1200, 1000), &panels)
}

/// A run to the end and its time.
type Run = fn(&Top, &RigidBody, f64) -> Result<(Vector3<f64>, f64), wzvi::Error>;

/// The axis at t = 5, and the seconds that the run takes, the least of five.
fn end<E>(top: &Top, body: &RigidBody, h: f64) -> Result<(Vector3<f64>, f64), wzvi::Error>
where
    Top: Discretized<E, Vector = SVector<f64, 9>>,
{
    let mut seconds = f64::INFINITY;
    let mut axis = Vector3::zeros();
    for _ in 0..5 {
        let begin = Instant::now();
        let path = top.simulate::<E>(h).start(start(body, 0.0)).until(5.0).record_every(u64::MAX).run()?;
        seconds = seconds.min(begin.elapsed().as_secs_f64());
        axis = body.attitude(path.last()) * Vector3::z();
    }
    Ok((axis, seconds))
}
