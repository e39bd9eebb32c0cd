//! The outer solar system by Kepler's flow: the sun with the inner planets, Jupiter, Saturn, Uranus and Neptune, in the
//! coordinates of Jacobi. Each planet is seen from the centre of mass of the bodies inside of its orbit, so that
//!
//! ```text
//! H_A = Σ_i (|p_i|²/(2 μ_i) - G m_i η_{i-1}/|q_i|),    μ_i = m_i η_{i-1}/η_i,    η_i = m_0 + ... + m_i
//! H_B = Σ_i G m_i η_{i-1}/|q_i| - Σ_{i<j} G m_i m_j/|r_j - r_i|
//! r_j - r_i = q_j + Σ_{i<k<j} (m_k/η_k) q_k - (η_{i-1}/η_i) q_i    (without the last term for the sun, i = 0)
//! ```
//!
//! `H_A` is a sum of Kepler problems, whose flow is exact, and `H_B` smaller by the masses of the planets. `Aba864` and
//! `Aba1064` alternate these flows; other schemes know of `H = H_A + H_B` only that it is `T(p) + V(q)`.
//!
//! What is checked: with 20 steps for each of Jupiter's years, `Aba864` keeps the energy a thousand times better than the
//! kicks and drifts of `KahanLi8` with as many steps, which take 17 forces each in place of 7. The angular momentum is kept
//! to rounding. Initial values are those of `solar_system`.
//!
//! Run with `cargo run --release --features svg --example planets`.

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
    drift = [
        |q: [[f64; 3]; 4], p: [[f64; 3]; 4]| (0..4)
            .map(|i| {
                let square = |x: [f64; 3]| x.iter().map(|x| x * x).sum::<f64>();
                square(p[i]) / (2.0 * reduced[i]) - strength[i] / square(q[i]).sqrt()
            })
            .sum::<f64>(),
        |q: [[f64; 3]; 4], _| {
            // The body 0 is the sun, and the planet i has the coordinates q[i - 1].
            let distance = |i: usize, j: usize| {
                (0..3)
                    .map(|x| {
                        let between = (i + 1..j).map(|k| share[k - 1] * q[k - 1][x]).sum::<f64>();
                        let back = if i > 0 { (1.0 - share[i - 1]) * q[i - 1][x] } else { 0.0 };
                        (q[j - 1][x] + between - back).powi(2)
                    })
                    .sum::<f64>()
                    .sqrt()
            };
            // The sun and Jupiter are a Kepler problem by themselves.
            (2..5)
                .map(|j| {
                    let pairs: f64 = (0..j).map(|i| g * mass[i] * mass[j] / distance(i, j)).sum();
                    strength[j - 1] / (q[j - 1][0].powi(2) + q[j - 1][1].powi(2) + q[j - 1][2].powi(2)).sqrt() - pairs
                })
                .sum::<f64>()
        },
    ],
    embedding = Verlet,
    invariant = [spin = |q: [[f64; 3]; 4], p: [[f64; 3]; 4]| (0..4).map(|i| q[i][0] * p[i][1] - q[i][1] * p[i][0]).sum::<f64>()],
)]
struct Planets {
    /// Gravitational constant.
    g: f64,
    mass: [f64; 5],
    /// `μ_i`
    reduced: [f64; 4],
    /// `G m_i η_{i-1}`
    strength: [f64; 4],
    /// `m_i/η_i`
    share: [f64; 4],
}

/// Masses of the sun, positions and days.
const G: f64 = 2.959_122_082_86e-4;
const MASSES: [f64; 5] = [
    1.000_005_976_82,
    0.000_954_786_104_043,
    0.000_285_583_733_151,
    0.000_043_727_316_454_6,
    0.000_051_775_913_844_9,
];
const POSITIONS: [[f64; 3]; 5] = [
    [0.0, 0.0, 0.0],
    [-3.5023653, -3.8169847, -1.5507963],
    [9.0755314, -3.0458353, -1.6483708],
    [8.310_142, -16.2901086, -7.2521278],
    [11.4707666, -25.7294829, -10.8169456],
];
const VELOCITIES: [[f64; 3]; 5] = [
    [0.0, 0.0, 0.0],
    [0.00565429, -0.0041249, -0.00190589],
    [0.00168318, 0.00483525, 0.00192462],
    [0.00354178, 0.00137102, 0.00055029],
    [0.0028893, 0.00114527, 0.00039677],
];
/// Jupiter's year in days.
const YEAR: f64 = 4332.6;

impl Planets {
    fn new() -> Self {
        let inside = |i: usize| MASSES[..=i].iter().sum::<f64>();
        let of_planets = |of: &dyn Fn(usize) -> f64| std::array::from_fn(|i| of(i + 1));
        Self {
            g: G,
            mass: MASSES,
            reduced: of_planets(&|i| MASSES[i] * inside(i - 1) / inside(i)),
            strength: of_planets(&|i| G * MASSES[i] * inside(i - 1)),
            share: of_planets(&|i| MASSES[i] / inside(i)),
        }
    }

    /// In the coordinates of Jacobi.
    fn start(&self) -> State<SVector<f64, 12>> {
        let seen_from_inside = |values: &[[f64; 3]; 5], i: usize, x: usize| {
            let (inner, mass) = (&values[..=i], &MASSES[..=i]);
            let mean =
                inner.iter().zip(mass).map(|(value, m)| m * value[x]).sum::<f64>() / mass.iter().sum::<f64>();
            values[i + 1][x] - mean
        };
        let q = SVector::from_fn(|n, _| seen_from_inside(&POSITIONS, n / 3, n % 3));
        let p = SVector::from_fn(|n, _| self.reduced[n / 3] * seen_from_inside(&VELOCITIES, n / 3, n % 3));
        State { q, p, t: 0.0 }
    }
}

/// Jupiter's years of a run.
const YEARS: f64 = 1000.0;

/// A run with so many steps for each of Jupiter's years.
struct Run {
    steps: f64,
    seconds: f64,
    /// The largest relative errors.
    energy: f64,
    spin: f64,
}

fn follow<E>(steps: f64) -> Result<Run, wzvi::Error>
where
    Planets: Discretized<E, Vector = SVector<f64, 12>>,
{
    let system = Planets::new();
    let start = system.start();
    let run =
        || system.simulate::<E>(YEAR / steps).start(start).until(YEARS * YEAR).record_every(0).unwatched();
    let clock = Instant::now();
    run().run()?;
    let seconds = clock.elapsed().as_secs_f64();
    let (energy, spin) = (system.energy(&start), system.invariant(0, &start));
    let (mut energy_error, mut spin_error) = (0.0_f64, 0.0_f64);
    run()
        .inspect(|state, _| {
            energy_error = energy_error.max((system.energy(state) / energy - 1.0).abs());
            spin_error = spin_error.max((system.invariant(0, state) / spin - 1.0).abs());
        })
        .run()?;
    Ok(Run { steps, seconds, energy: energy_error, spin: spin_error })
}

fn runs<E>(steps: [f64; 4]) -> Result<Vec<Run>, wzvi::Error>
where
    Planets: Discretized<E, Vector = SVector<f64, 12>>,
{
    steps.into_iter().map(follow::<E>).collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("The outer solar system over {YEARS} of Jupiter's years\n");
    let schemes = [
        (
            "Aba864, by Kepler's flow",
            Colour::BLUE,
            runs::<Composed<Verlet, Aba864>>([5.0, 10.0, 20.0, 40.0])?,
        ),
        (
            "Aba1064, by Kepler's flow",
            Colour::GREEN,
            runs::<Composed<Verlet, Aba1064>>([5.0, 10.0, 20.0, 40.0])?,
        ),
        (
            "KahanLi8, by kicks and drifts",
            Colour::VERMILION,
            runs::<Composed<Verlet, KahanLi8>>([10.0, 20.0, 40.0, 80.0])?,
        ),
    ];
    let mut rows = Vec::new();
    let mut errors =
        Figure::panel("Energy error against time", "time of a run [s]", "largest |H/H(0) - 1|").log_log();
    for (name, colour, runs) in &schemes {
        for Run { steps, seconds, energy, spin } in runs {
            let (time, energy, spin) =
                (format!("{:.0}", 1e3 * seconds), format!("{energy:.1e}"), format!("{spin:.1e}"));
            rows.push([(*name).into(), format!("{steps}"), time, energy, spin]);
        }
        errors = errors.line(*name, *colour, runs.iter().map(|run| (run.seconds, run.energy)));
    }
    table::print(["scheme", "steps/year", "time [ms]", "drift of H", "of the angular momentum"], &rows);
    let of_twenty = |scheme: usize| schemes[scheme].2.iter().find(|run| run.steps == 20.0).ok_or("no run");
    let (kepler, kicks) = (of_twenty(0)?, of_twenty(2)?);
    println!(
        "\n  With 20 steps, Kepler's flow keeps the energy {:.0} times better than kicks and drifts.\n",
        kicks.energy / kepler.energy
    );
    plot::save("planets", "energy", 1, (900, 600), &[errors])
}
