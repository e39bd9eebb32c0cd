//! Burrau's problem: three bodies of masses 3, 4 and 5, let go at the corners of a triangle with these sides. They pass each other as close
//! as 4e-4 before the lightest is thrown out. Steps by a clock follow the motion; constant steps fail in the first encounters.
//!
//! Run with `cargo run --release --features svg --example close_encounter`, a few seconds.
//!
//! Units: the constant of gravity is 1.

#[path = "support/plot.rs"]
mod plot;
#[path = "support/table.rs"]
mod table;

use std::error::Error;
use std::time::Instant;

use wzvi::nalgebra::SVector;
use wzvi::plot::{Colour, Figure};
use wzvi::prelude::*;

#[hamiltonian(
    drift = |q: [[f64; 2]; 3], p: [[f64; 2]; 3]| {
        let kinetic = |i: usize| 0.5 * (p[i][0].powi(2) + p[i][1].powi(2)) / m[i];
        let pair = |i: usize, j: usize| {
            -m[i] * m[j] / ((q[i][0] - q[j][0]).powi(2) + (q[i][1] - q[j][1]).powi(2)).sqrt()
        };
        kinetic(0) + kinetic(1) + kinetic(2) + pair(0, 1) + pair(1, 2) + pair(2, 0)
    },
    clock = pairs,
    embedding = [Gauss<8>, Clocked<Gauss<8>>, Extended<Gauss<8>>, Logarithmic<1, 1>],
)]
struct Bodies {
    m: [f64; 3],
}

type BodiesState = State<SVector<f64, 6>>;

const BODIES: Bodies = Bodies { m: [3.0, 4.0, 5.0] };
const END: f64 = 63.0;
/// Of the three bodies at the end, to 20 digits by a Taylor method in 128 bits.
const SOLUTION: [f64; 6] = [
    2.839_433_972_491_500_3,
    8.112_854_442_046_96,
    -0.463_420_279_975_119_1,
    -2.852_228_362_934_024,
    -1.332_924_159_514_805,
    -2.585_929_964_470_377,
];

fn start() -> BodiesState {
    State::new([1.0, 3.0, -2.0, -1.0, 1.0, -1.0], [0.0; 6])
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("Burrau's three bodies to t = {END}\n");
    let constant = BODIES.simulate::<Gauss<8>>(0.005).start(start()).until(END).run_partial()?;
    if let (path, Some(error)) = constant {
        println!("  Gauss<8>, h = 0.005, ends at t = {:.2}: {error}\n", path.last().t);
    }
    let rows = [
        row::<Clocked<Gauss<8>>>("Clocked<Gauss<8>>", 0.3)?,
        row::<Extended<Gauss<8>>>("Extended<Gauss<8>>", 0.4)?,
        row::<Extended<Gauss<8>>>("Extended<Gauss<8>>", 0.2)?,
        row::<Composed<Logarithmic<1, 1>, KahanLi8>>("Composed<Logarithmic<1, 1>, KahanLi8>", 0.05)?,
    ];
    table::print(
        ["scheme", "eps", "steps", "positions at the end off by", "energy off by", "time [ms]"],
        &rows,
    );
    println!();

    let path = BODIES.simulate::<Extended<Gauss<8>>>(Eps(0.2)).start(start()).until(END).run()?;
    let orbit = |body: usize| path.iter().map(move |state| (state.q[2 * body], state.q[2 * body + 1]));
    let orbits = Figure::panel("Three bodies: the lightest is thrown out", "x", "y")
        .equal_axes()
        .line("mass 3", Colour::BLUE, orbit(0))
        .line("mass 4", Colour::VERMILION, orbit(1))
        .line("mass 5", Colour::GREEN, orbit(2));
    let lengths = path.intervals().iter().map(|interval| (interval.t, interval.h));
    let nearest = path.iter().map(|state| (state.t, nearest(state)));
    let steps = Figure::panel("The steps follow the distance of the closest pair", "time t", "h, distance")
        .log_y()
        .line("distance", Colour::GREY, nearest)
        .line("step h", Colour::BLUE, lengths);
    plot::save("close_encounter", "burrau", 2, (1200, 550), &[orbits, steps])
}

/// The distance of the closest pair.
fn nearest(state: &BodiesState) -> f64 {
    let distance =
        |i: usize, j: usize| (state.q[2 * i] - state.q[2 * j]).hypot(state.q[2 * i + 1] - state.q[2 * j + 1]);
    distance(0, 1).min(distance(1, 2)).min(distance(2, 0))
}

/// A run to the end, as a row of the table: the shortest time of three.
fn row<E>(name: &str, eps: f64) -> Result<[String; 6], wzvi::Error>
where
    Bodies: Discretized<E, Vector = SVector<f64, 6>>,
{
    let mut seconds = f64::INFINITY;
    let mut run = || -> Result<Trajectory<SVector<f64, 6>, E>, wzvi::Error> {
        let begin = Instant::now();
        let path = wzvi::simulate::Simulation::<Bodies, E>::new(&BODIES, eps).start(start()).until(END);
        let path = path.record_every(0).run()?;
        seconds = seconds.min(begin.elapsed().as_secs_f64());
        Ok(path)
    };
    run()?;
    run()?;
    let path = run()?;
    let off = (path.last().q - SVector::from(SOLUTION)).norm();
    let energy = (BODIES.energy(path.last()) - BODIES.energy(&start())).abs();
    Ok([
        name.to_owned(),
        eps.to_string(),
        path.steps().to_string(),
        format!("{off:.1e}"),
        format!("{energy:.1e}"),
        format!("{:.1}", 1e3 * seconds),
    ])
}
