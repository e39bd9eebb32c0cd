//! The outer solar system over 10^6 days: the sun with the inner planets, Jupiter, Saturn, Uranus, Neptune and Pluto.
//!
//! `H = Σ |p_i|²/2m_i - Σ_{j<i} G m_i m_j / |q_i - q_j|`, in astronomical units, days and solar masses. Initial values and
//! masses are those of E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*, section I.2.4, table 2.2 (for
//! September 5, 1994 at 0h00, from the "Ahnerts Kalender für Sternfreunde 1994"), seen from the centre of mass.
//!
//! What is checked:
//! * Momentum and angular momentum are kept to rounding (they are bilinear: proven when this file is compiled), the energy
//!   up to h² by `Midpoint` and h by `DeltaPlus`.
//! * The periods are those of the planets (sidereal periods of NASA's planetary fact sheets).
//! * Pluto crosses the orbit of Neptune, but stays farther from it than from Uranus: over millions of years it never comes
//!   closer than some 17 astronomical units to Neptune, and 11 to Uranus (C. J. Cohen, E. C. Hubbard, *Astron. J.* 70, 10,
//!   1965; J. G. Williams, G. S. Benson, *Astron. J.* 76, 167, 1971).
//!
//! Run with `cargo run --release --features svg --example solar_system`.

#[path = "support/plot.rs"]
mod plot;
#[path = "support/table.rs"]
mod table;

use std::error::Error;

use wzvi::nalgebra::{SVector, Vector3};
use wzvi::plot::{Colour, Figure};
use wzvi::prelude::*;

#[hamiltonian(
    drift = |q: [[f64; 3]; 6], p: [[f64; 3]; 6]| {
        let kinetic: f64 = (0..6).map(|i| (0..3).map(|k| p[i][k] * p[i][k]).sum::<f64>() / (2.0 * mass[i])).sum();
        let potential: f64 = (0..6)
            .map(|i| {
                (0..i)
                    .map(|j| {
                        let square: f64 = (0..3).map(|k| (q[i][k] - q[j][k]).powi(2)).sum();
                        g * mass[i] * mass[j] / square.sqrt()
                    })
                    .sum::<f64>()
            })
            .sum();
        kinetic - potential
    },
    embedding = [DeltaPlus, Midpoint],
    invariant = [
        |q: [[f64; 3]; 6], p: [[f64; 3]; 6]| (0..6).map(|i| q[i][1] * p[i][2] - q[i][2] * p[i][1]).sum::<f64>(),
        |q: [[f64; 3]; 6], p: [[f64; 3]; 6]| (0..6).map(|i| q[i][2] * p[i][0] - q[i][0] * p[i][2]).sum::<f64>(),
        |q: [[f64; 3]; 6], p: [[f64; 3]; 6]| (0..6).map(|i| q[i][0] * p[i][1] - q[i][1] * p[i][0]).sum::<f64>(),
    ],
)]
struct OuterSolarSystem {
    /// Gravitational constant.
    g: f64,
    mass: [f64; BODIES],
}

type System = State<SVector<f64, { 3 * BODIES }>>;

const BODIES: usize = 6;
const NAMES: [&str; BODIES] = ["Sun", "Jupiter", "Saturn", "Uranus", "Neptune", "Pluto"];
/// The sun carries the inner planets.
const MASSES: [f64; BODIES] = [
    1.000_005_976_82,
    0.000_954_786_104_043,
    0.000_285_583_733_151,
    0.000_043_727_316_454_6,
    0.000_051_775_913_844_9,
    1.0 / 1.3e8,
];
const POSITIONS: [[f64; 3]; BODIES] = [
    [0.0, 0.0, 0.0],
    [-3.5023653, -3.8169847, -1.5507963],
    [9.0755314, -3.0458353, -1.6483708],
    [8.310_142, -16.2901086, -7.2521278],
    [11.4707666, -25.7294829, -10.8169456],
    [-15.5387357, -25.2225594, -3.1902382],
];
const VELOCITIES: [[f64; 3]; BODIES] = [
    [0.0, 0.0, 0.0],
    [0.00565429, -0.0041249, -0.00190589],
    [0.00168318, 0.00483525, 0.00192462],
    [0.00354178, 0.00137102, 0.00055029],
    [0.0028893, 0.00114527, 0.00039677],
    [0.00276725, -0.00170702, -0.00136504],
];
/// Sidereal periods in days.
const PERIODS: [f64; BODIES] = [f64::NAN, 4332.589, 10759.22, 30685.4, 60189.0, 90560.0];
const END: f64 = 1e6;

fn main() -> Result<(), Box<dyn Error>> {
    println!("The outer solar system over {END:e} days\n");
    let steps = [40.0, 20.0, 10.0];
    let first = steps.map(follow::<DeltaPlus>).into_iter().collect::<Result<Vec<_>, _>>()?;
    let second = steps.map(follow::<Midpoint>).into_iter().collect::<Result<Vec<_>, _>>()?;
    let mut rows = Vec::new();
    for (h, runs) in steps.into_iter().zip(first.iter().zip(&second)) {
        rows.push(runs.0.row("DeltaPlus", h));
        rows.push(runs.1.row("Midpoint", h));
    }
    table::print(
        ["scheme", "h [d]", "drift of H", "of the momentum", "of the angular momentum", "Newton/step"],
        &rows,
    );
    let order = |runs: &[Run]| (runs[1].energy / runs[2].energy).log2();
    println!(
        "\n  Orders of the energy from the last two: {:.2} (1 by theory) and {:.2} (2).\n",
        order(&first),
        order(&second)
    );
    let [.., finest] = second.as_slice() else { return Err("no run".into()) };
    periods(finest);
    approaches(finest)?;
    println!();
    let colors = [Colour::INK, Colour::OCHRE, Colour::GREEN, Colour::VIOLET, Colour::BLUE, Colour::VERMILION];
    let mut orbits =
        Figure::panel("Orbits of 250 years in the plane of Jupiter's start", "x [AU]", "y [AU]").equal_axes();
    for ((name, color), orbit) in NAMES.into_iter().zip(colors).zip(&finest.orbits) {
        orbits = orbits.line(name, color, orbit.iter().copied());
    }
    let years = |points: &[(f64, f64)]| points.iter().map(|&(t, y)| (t / 365.25, y)).collect::<Vec<_>>();
    let errors = Figure::panel("Energy, h = 10 days", "time [years]", "|H/H(0) - 1|")
        .log_y()
        .line("DeltaPlus", Colour::VERMILION, years(&first[2].energies))
        .line("Midpoint", Colour::BLUE, years(&finest.energies));
    let distances = Figure::panel("Pluto's distance", "time [years]", "distance [AU]")
        .line("from Neptune", Colour::BLUE, years(&finest.distances[1]))
        .line("from Uranus", Colour::VIOLET, years(&finest.distances[0]));
    let crossing = Figure::panel("Distance from the sun", "time [years]", "distance [AU]")
        .line("Neptune", Colour::BLUE, years(&finest.distances[2]))
        .line("Pluto", Colour::VERMILION, years(&finest.distances[3]));
    plot::save("solar_system", "planets", 2, (1000, 700), &[orbits, errors, distances, crossing])
}

/// Mean periods of whole revolutions around the sun.
fn periods(run: &Run) {
    println!("Periods, means of whole revolutions (Midpoint, h = 10)\n");
    let mut rows = Vec::new();
    let mut worst = 0.0_f64;
    for i in 1..BODIES {
        let Revolutions { first, last, count, .. } = &run.revolutions[i];
        let period = (last - first) / count;
        let off = period / PERIODS[i] - 1.0;
        worst = worst.max(off.abs());
        rows.push([
            NAMES[i].into(),
            format!("{count:.0}"),
            format!("{period:.1}"),
            format!("{}", PERIODS[i]),
            format!("{:+.3} %", 100.0 * off),
        ]);
    }
    table::print(["", "revolutions", "days", "fact sheet", "off by"], &rows);
    println!("\n  The largest difference is {:.2} %.\n", 100.0 * worst);
}

/// The smallest distance of each pair of planets.
fn approaches(run: &Run) -> Result<(), Box<dyn Error>> {
    println!("Closest approaches (Midpoint, h = 10)\n");
    let mut rows = Vec::new();
    for &(i, j, distance, t) in &run.closest {
        rows.push([
            format!("{} and {}", NAMES[j], NAMES[i]),
            format!("{distance:.2}"),
            format!("{:.0}", 1994.68 + t / 365.25),
        ]);
    }
    table::print(["", "AU", "year"], &rows);
    let of = |pair: (usize, usize)| run.closest.iter().find(|&&(i, j, ..)| (j, i) == pair).ok_or("no pair");
    let (neptune, uranus) = (of((4, 5))?.2, of((3, 5))?.2);
    println!(
        "\n  Pluto stays {neptune:.1} AU from Neptune, whose orbit it crosses, and comes to {uranus:.1} AU of Uranus:"
    );
    println!("  within the bounds of 17 and 11 AU for millions of years.");
    Ok(())
}

fn body(x: &SVector<f64, { 3 * BODIES }>, i: usize) -> Vector3<f64> {
    Vector3::new(x[3 * i], x[3 * i + 1], x[3 * i + 2])
}

/// Seen from the centre of mass.
fn start() -> System {
    let total: f64 = MASSES.iter().sum();
    let mean = |values: &[[f64; 3]; BODIES], k: usize| {
        values.iter().zip(MASSES).map(|(x, m)| m * x[k]).sum::<f64>() / total
    };
    let q = SVector::from_fn(|n, _| POSITIONS[n / 3][n % 3] - mean(&POSITIONS, n % 3));
    let p = SVector::from_fn(|n, _| MASSES[n / 3] * (VELOCITIES[n / 3][n % 3] - mean(&VELOCITIES, n % 3)));
    State { q, p, t: 0.0 }
}

/// How often a planet has come around.
#[derive(Clone, Copy, Default)]
struct Revolutions {
    before: Vector3<f64>,
    first: f64,
    last: f64,
    /// Whole revolutions between.
    count: f64,
}

impl Revolutions {
    /// A crossing of the half-plane through `axis` and the normal of the orbit.
    fn see(&mut self, now: Vector3<f64>, t: f64, h: f64, [axis, side]: [Vector3<f64>; 2]) {
        let (from, to) = (self.before.dot(&side), now.dot(&side));
        if from < 0.0 && to >= 0.0 && now.dot(&axis) > 0.0 {
            self.last = t - h * to / (to - from);
            if self.first == 0.0 {
                self.first = self.last;
            } else {
                self.count += 1.0;
            }
        }
        self.before = now;
    }
}

/// The result of a run.
#[derive(Default)]
struct Run {
    /// Largest relative errors.
    energy: f64,
    momentum: f64,
    angular: f64,
    iterations: f64,
    /// Relative error of the energy by time in days.
    energies: Vec<(f64, f64)>,
    revolutions: [Revolutions; BODIES],
    /// Of Pluto from Uranus and Neptune, of Neptune and Pluto from the sun.
    distances: [Vec<(f64, f64)>; 4],
    orbits: [Vec<(f64, f64)>; BODIES],
    /// Pairs, distance, time.
    closest: Vec<(usize, usize, f64, f64)>,
}

fn follow<E>(h: f64) -> Result<Run, wzvi::Error>
where
    OuterSolarSystem: Discretized<E, Vector = SVector<f64, { 3 * BODIES }>>,
{
    const PAIRS: [(usize, usize); 6] = [(2, 1), (3, 2), (4, 3), (5, 2), (5, 3), (5, 4)];
    let system = OuterSolarSystem { g: 2.959_122_082_86e-4, mass: MASSES };
    let start = start();
    let angular = |state: &System| Vector3::from_fn(|k, _| system.invariant(k, state));
    let (energy, spin) = (system.energy(&start), angular(&start));
    let momentum = |state: &System| -> Vector3<f64> { (0..BODIES).map(|i| body(&state.p, i)).sum() };
    let scale = (0..BODIES).map(|i| body(&start.p, i).norm()).fold(0.0, f64::max);
    let axis = body(&start.q, 1).normalize();
    let plane = [axis, spin.normalize().cross(&axis)];
    let mut run = Run { closest: PAIRS.map(|(i, j)| (i, j, f64::INFINITY, 0.0)).to_vec(), ..Run::default() };
    let every = (1000.0 / h).round() as u64;
    let path = system
        .simulate::<E>(h)
        .start(start)
        .until(END)
        .record_every(0)
        .inspect(|state, node| {
            let error = (system.energy(state) / energy - 1.0).abs();
            run.energy = run.energy.max(error);
            run.momentum = run.momentum.max(momentum(state).norm() / scale);
            run.angular = run.angular.max((angular(state) - spin).norm() / spin.norm());
            let at = |i: usize| body(&state.q, i) - body(&state.q, 0);
            let distance = |i: usize, j: usize| (at(i) - at(j)).norm();
            for (i, planet) in run.revolutions.iter_mut().enumerate() {
                planet.see(at(i), state.t, h, plane);
            }
            for (i, j, closest, t) in &mut run.closest {
                if distance(*i, *j) < *closest {
                    (*closest, *t) = (distance(*i, *j), state.t);
                }
            }
            if node.step % every == 0 {
                run.energies.push((state.t, error));
                let pairs = [(5, 3), (5, 4), (4, 0), (5, 0)];
                for (points, (i, j)) in run.distances.iter_mut().zip(pairs) {
                    points.push((state.t, distance(i, j)));
                }
            }
            if node.step % (every / 4) == 0 && state.t < 250.0 * 365.25 {
                for (i, orbit) in run.orbits.iter_mut().enumerate() {
                    orbit.push((body(&state.q, i).dot(&plane[0]), body(&state.q, i).dot(&plane[1])));
                }
            }
        })
        .run()?;
    run.iterations = path.iterations().total as f64 / path.steps() as f64;
    Ok(run)
}

impl Run {
    fn row(&self, name: &str, h: f64) -> [String; 6] {
        [
            name.into(),
            h.to_string(),
            format!("{:.1e}", self.energy),
            format!("{:.1e}", self.momentum),
            format!("{:.1e}", self.angular),
            format!("{:.2}", self.iterations),
        ]
    }
}
