//! Thirteen Lennard-Jones atoms in a bath: distances, and the specific heat where the cluster melts.
//!
//! `H = Σ |p_i|²/2 + Σ_{j<i} 4 (r_ij^-12 - r_ij^-6) + Σ (|q_i|/2.5)^20`, in units of the well of a pair and of σ; the wall at 2.5 confines atoms that evaporate.
//! `Baoab` draws states of the Gibbs measure, with a bias of order `h²`. What is checked:
//!
//! * **Temperature**: momenta and positions have the temperature of the bath, `⟨q · ∂H/∂q⟩ = d kT`.
//! * **Specific heat**: `C = Var H/(kT)²` at each temperature agrees with the slope of `⟨H⟩` between neighbouring ones; 36 for a cold cluster, half of 39 momenta and 33 vibrations.
//! * **Melting**: the peak of `C` is published near `kT = 0.29` (D. D. Frantz, J. Chem. Phys. 102, 3747, 1995, arXiv:chem-ph/9406001, by Monte Carlo).
//!
//! `cargo run --release --features svg --example langevin_lennard_jones`, less than a minute

#[path = "support/plot.rs"]
mod plot;
#[path = "support/table.rs"]
mod table;

use std::error::Error;
use std::thread;

use wzvi::nalgebra::DVector;
use wzvi::plot::{Colour, Figure, Look};
use wzvi::prelude::*;

/// Atoms in a bath.
#[hamiltonian(
    drift = |q: &[[f64; 3]], p: &[[f64; 3]]| {
        let n = q.len();
        let kinetic: f64 = p.iter().map(|p| 0.5 * (p[0] * p[0] + p[1] * p[1] + p[2] * p[2])).sum();
        let wall: f64 =
            q.iter().map(|q| ((q[0] * q[0] + q[1] * q[1] + q[2] * q[2]) / 6.25).powi(10)).sum();
        let pairs: f64 = (0..n)
            .map(|i| {
                (0..i)
                    .map(|j| {
                        let square: f64 = (0..3).map(|k| (q[i][k] - q[j][k]).powi(2)).sum();
                        let attraction = 1.0 / (square * square * square);
                        4.0 * attraction * (attraction - 1.0)
                    })
                    .sum::<f64>()
            })
            .sum();
        kinetic + pairs + wall
    },
    friction = gamma,
    temperature = kt,
    embedding = Baoab,
)]
#[derive(Clone, Debug)]
pub struct LennardJones {
    /// Rate of the friction.
    pub gamma: f64,
    /// Temperature.
    pub kt: f64,
}

type Cluster = State<DVector<f64>>;

const ATOMS: usize = 13;
const H: f64 = 0.01;
const SPAN: f64 = 12_000.0;
const TEMPERATURES: [f64; 12] = [0.05, 0.1, 0.15, 0.2, 0.24, 0.26, 0.275, 0.29, 0.305, 0.32, 0.35, 0.4];

/// The icosahedron: one atom in the middle of twelve, at a distance that is nearly that of the minimum.
fn icosahedron() -> Cluster {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let scale = 1.08 / (1.0 + golden * golden).sqrt();
    let mut q = vec![0.0; 3];
    for axis in 0..3 {
        for (one, other) in [(1.0, golden), (1.0, -golden), (-1.0, golden), (-1.0, -golden)] {
            let mut place = [0.0; 3];
            (place[axis], place[(axis + 1) % 3]) = (scale * one, scale * other);
            q.extend(place);
        }
    }
    let p = vec![0.0; q.len()];
    State::new(q, p)
}

/// What is measured at one temperature.
struct Measured {
    kinetic: (f64, f64),
    configurational: (f64, f64),
    energy: (f64, f64),
    heat_capacity: f64,
}

fn measure(kt: f64) -> Result<Measured, wzvi::Error> {
    let cluster = LennardJones { gamma: 1.0, kt };
    let run = cluster.simulate::<Baoab>(H).start(icosahedron()).noise(StepNormals::seed(3)).until(SPAN);
    let run = run.observe("energy", |state| cluster.energy(state)).observe_temperatures().record_every(5);
    let averages = run.time_averages().discard(200.0).run()?;
    let of = |name: &str| averages.of(name).map(|average| (average.mean, average.standard_error));
    Ok(Measured {
        kinetic: of("kinetic temperature")?,
        configurational: of("configurational temperature")?,
        energy: of("energy")?,
        heat_capacity: averages.of("energy")?.variance / (kt * kt),
    })
}

/// How often pairs are so far from each other, by bins of 0.02.
fn distances(kt: f64) -> Result<Vec<(f64, f64)>, wzvi::Error> {
    let cluster = LennardJones { gamma: 1.0, kt };
    let run = cluster.simulate::<Baoab>(H).start(icosahedron()).noise(StepNormals::seed(4)).until(1000.0);
    let path = run.record_every(50).run()?;
    let mut counts = vec![0.0; 200];
    for state in path.states().iter().skip(200) {
        let [q, _] = state.points::<3>();
        for i in 0..ATOMS {
            for j in 0..i {
                let square: f64 = (0..3).map(|k| (q[i][k] - q[j][k]).powi(2)).sum();
                if let Some(count) = counts.get_mut((square.sqrt() / 0.02) as usize) {
                    *count += 1.0;
                }
            }
        }
    }
    let all: f64 = counts.iter().sum();
    let bins = counts.iter().enumerate().map(|(i, count)| (0.02 * (i as f64 + 0.5), count / (0.02 * all)));
    Ok(bins.filter(|(r, _)| *r > 0.8).collect())
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("{ATOMS} Lennard-Jones atoms, Baoab, h = {H}, γ = 1, {SPAN} time units for each temperature\n");
    let measured = thread::scope(|scope| {
        let halves = TEMPERATURES
            .chunks(TEMPERATURES.len() / 2)
            .map(|half| scope.spawn(|| half.iter().map(|&kt| measure(kt)).collect::<Result<Vec<_>, _>>()));
        let halves: Vec<_> = halves.collect();
        let joined = halves.into_iter().map(|half| half.join().map_err(|_| "a thread has ended early"));
        joined.collect::<Result<Vec<_>, _>>()
    })?;
    let measured: Vec<Measured> =
        measured.into_iter().collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect();
    let mut rows = Vec::new();
    for (i, (kt, now)) in TEMPERATURES.iter().zip(&measured).enumerate() {
        let gained = measured.get(i + 1).zip(TEMPERATURES.get(i + 1));
        let between = gained.map_or(String::new(), |(next, t)| {
            let error = (now.energy.1.powi(2) + next.energy.1.powi(2)).sqrt();
            format!("{:.1} ± {:.1}", (next.energy.0 - now.energy.0) / (t - kt), error / (t - kt))
        });
        rows.push([
            format!("{kt}"),
            format!("{:.5} ± {:.5}", now.kinetic.0, now.kinetic.1),
            format!("{:.5} ± {:.5}", now.configurational.0, now.configurational.1),
            format!("{:.3} ± {:.3}", now.energy.0, now.energy.1),
            format!("{:.1}", now.heat_capacity),
            between,
        ]);
    }
    let headings = ["kT", "kinetic", "configurational", "energy", "C by its variance", "C to the next kT"];
    table::print(headings, &rows);
    println!("\n  published: the peak of C is near kT = 0.29\n");
    let heat: Vec<(f64, f64)> =
        TEMPERATURES.iter().zip(&measured).map(|(&kt, now)| (kt, now.heat_capacity)).collect();
    let capacity = Figure::panel("Specific heat of 13 atoms", "kT [ε]", "C [k]")
        .points(Look::Dashed, "published peak", Colour::GREY, [(0.29, 30.0), (0.29, 130.0)])
        .points(Look::Joined, "Var H/(kT)²", Colour::BLUE, heat);
    let pairs = Figure::panel("Distances of pairs", "r [σ]", "density")
        .line("kT = 0.1", Colour::BLUE, distances(0.1)?)
        .line("kT = 0.35", Colour::VERMILION, distances(0.35)?);
    plot::save("langevin_lennard_jones", "melting", 2, (1000, 700), &[capacity, pairs])
}
