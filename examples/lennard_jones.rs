//! Clusters of 7 and 13 Lennard-Jones atoms: their minima, the breathing mode of the icosahedron, and its melting.
//!
//! `H = Σ |p_i|²/2 + Σ_{j<i} 4 (r_ij^-12 - r_ij^-6)`: energies in units of the well of a pair, lengths in units of σ.
//!
//! What is checked:
//! * Quenches of 7 atoms from random places end in the four known minima, of energies -16.505384, -15.935043,
//!   -15.593211 and -15.533060 (M. R. Hoare, P. Pal, *Adv. Phys.* 20, 161, 1971), and the icosahedron of 13 in the global
//!   minimum, -44.326801 (the Cambridge Cluster Database, D. J. Wales and others, lists both).
//! * The icosahedron breathes with the frequency `ω² = E''(R)/12` of its energy as a function of its radius; that of
//!   `Midpoint` is `tan(ω' h/2) = ω h/2`.
//! * Near its minimum half of the energy is kinetic (equipartition). It melts where the distances fluctuate by more than
//!   a tenth (R. S. Berry, T. L. Beck, H. L. Davis, J. Jellinek, *Adv. Chem. Phys.* 70 B, 75, 1988).
//!
//! Run with `cargo run --release --features svg --example lennard_jones`.

#[path = "support/plot.rs"]
mod plot;
#[path = "support/table.rs"]
mod table;

use std::error::Error;
use std::f64::consts::PI;

use wzvi::nalgebra::{DVector, Vector3};
use wzvi::plot::{Colour, Figure, Look};
use wzvi::prelude::*;

#[hamiltonian(
    drift = |q: &[[f64; 3]], p: &[[f64; 3]]| {
        let n = q.len();
        let kinetic: f64 = p.iter().map(|p| 0.5 * (p[0] * p[0] + p[1] * p[1] + p[2] * p[2])).sum();
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
        kinetic + pairs
    },
    embedding = [DeltaPlus, Midpoint],
)]
struct LennardJones;

type Cluster = State<DVector<f64>>;

fn main() -> Result<(), Box<dyn Error>> {
    seven()?;
    let icosahedron = thirteen()?;
    breath(&icosahedron)?;
    let panels = melting(&icosahedron)?;
    println!();
    plot::save("lennard_jones", "melting", 2, (1000, 640), &panels)
}

/// Falls to a minimum: steps of `DeltaPlus` that stop whenever the cluster climbs.
fn quench(mut state: Cluster) -> Result<Cluster, wzvi::Error> {
    let mut stepper = LennardJones.stepper::<DeltaPlus>(0.01)?;
    for _ in 0..200_000 {
        let slope = LennardJones.energy_gradient(&state).q;
        if state.p.dot(&slope) > 0.0 {
            state.p.fill(0.0);
        }
        // The energy is quadratic in the remaining distance: this is its last digit.
        if slope.amax() < 1e-8 {
            break;
        }
        stepper.step(&mut state, &[])?;
    }
    state.p.fill(0.0);
    Ok(state)
}

/// Atoms at random in a ball, none too close to another.
fn scattered(atoms: usize, seed: u64) -> Result<Cluster, wzvi::Error> {
    let mut wiener = Wiener::seed(seed);
    let mut places: Vec<Vector3<f64>> = Vec::new();
    let mut draw = 0.0;
    while places.len() < atoms {
        let mut place = Vector3::zeros();
        for k in 0..3 {
            place[k] = wiener.increment(k, draw, draw + 1.0)?;
        }
        draw += 1.0;
        if place.norm() < 1.8 && places.iter().all(|other| (place - other).norm() > 0.9) {
            places.push(place);
        }
    }
    let q: Vec<f64> = places.iter().flat_map(|place| place.iter().copied()).collect();
    Ok(State::new(q, vec![0.0; 3 * atoms]))
}

fn seven() -> Result<(), Box<dyn Error>> {
    const KNOWN: [(&str, f64); 4] = [
        ("pentagonal bipyramid", -16.505384),
        ("capped octahedron", -15.935043),
        ("tricapped tetrahedron", -15.593211),
        ("skew structure", -15.533060),
    ];
    println!("1. Where 300 quenches of 7 atoms end\n");
    let mut found = [(0_u32, f64::NAN); 4];
    let mut elsewhere = 0;
    for seed in 0..300 {
        let energy = LennardJones.energy(&quench(scattered(7, seed)?)?);
        match KNOWN.iter().position(|(_, known)| (energy - known).abs() < 1e-4) {
            Some(i) => found[i] = (found[i].0 + 1, energy),
            None => elsewhere += 1,
        }
    }
    let rows = [0, 1, 2, 3].map(|i| {
        [
            KNOWN[i].0.into(),
            found[i].0.to_string(),
            format!("{:.6}", found[i].1),
            format!("{:.6}", KNOWN[i].1),
        ]
    });
    table::print(["", "quenches", "energy", "literature"], &rows);
    println!("\n  {elsewhere} ended elsewhere.\n");
    Ok(())
}

/// The corners `(0, ±1, ±φ)` and their cyclic permutations around an atom in the middle.
fn directions() -> Vec<Vector3<f64>> {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let mut corners = Vec::new();
    for a in [-1.0, 1.0] {
        for b in [-golden, golden] {
            corners.extend([[0.0, a, b], [a, b, 0.0], [b, 0.0, a]].map(|c| Vector3::from(c).normalize()));
        }
    }
    corners
}

fn icosahedron(radius: f64) -> Cluster {
    let corners = directions();
    let q: Vec<f64> =
        [0.0; 3].into_iter().chain(corners.iter().flat_map(|c| (c * radius).data.0[0])).collect();
    State::new(q, vec![0.0; 39])
}

fn thirteen() -> Result<Cluster, Box<dyn Error>> {
    const KNOWN: f64 = -44.326801;
    // Disturbed, so that the quench has to find the symmetry.
    let mut start = icosahedron(1.15);
    for (i, x) in start.q.iter_mut().enumerate() {
        *x += 0.05 * (12.9 * i as f64).sin();
    }
    let state = quench(start)?;
    let energy = LennardJones.energy(&state);
    println!("2. A disturbed icosahedron of 13 atoms falls to {energy:.6}; literature {KNOWN:.6}.\n");
    Ok(icosahedron(radius(&state)))
}

/// Mean distance from the first atom, which is in the middle.
fn radius(state: &Cluster) -> f64 {
    let at = |i: usize| Vector3::from_column_slice(&state.q.as_slice()[3 * i..3 * i + 3]);
    (1..13).map(|i| (at(i) - at(0)).norm()).sum::<f64>() / 12.0
}

/// The symmetric vibration of the icosahedron.
fn breath(minimum: &Cluster) -> Result<(), Box<dyn Error>> {
    // E(R) of the perfect icosahedron: pairs at distances that are multiples of R.
    let distances: Vec<f64> = {
        let mut places = directions();
        places.push(Vector3::zeros());
        (0..13)
            .flat_map(|i| (0..i).map(move |j| (i, j)))
            .map(|(i, j)| (places[i] - places[j]).norm())
            .collect()
    };
    let sum = |f: &dyn Fn(f64) -> f64| distances.iter().map(|&c| f(c)).sum::<f64>();
    // With r = c R: E' = Σ 4 (-12 c^-12 R^-13 + 6 c^-6 R^-7) vanishes at R⁶ = 2 Σ c^-12 / Σ c^-6.
    let (twelve, six) = (sum(&|c| c.powi(-12)), sum(&|c| c.powi(-6)));
    let radius_0 = (2.0 * twelve / six).powf(1.0 / 6.0);
    let second = 4.0 * (156.0 * twelve * radius_0.powi(-14) - 42.0 * six * radius_0.powi(-8));
    let omega = (second / 12.0).sqrt();
    println!(
        "3. The icosahedron breathes, started 1e-5 too large: radius {:.6}, exact {radius_0:.6}\n",
        radius(minimum)
    );
    let mut rows = Vec::new();
    for h in [0.02, 0.01, 0.005] {
        let (mut before, mut zeros) = (0.0, Vec::new());
        let path = LennardJones
            .simulate::<Midpoint>(h)
            .start(icosahedron(radius_0 * (1.0 + 1e-5)))
            .until(20.0)
            .record_every(0)
            .inspect(|state, _| {
                let now = radius(state) - radius_0;
                if before * now < 0.0 {
                    zeros.push(state.t - h * now / (now - before));
                }
                before = now;
            })
            .run()?;
        let [first, .., last] = zeros.as_slice() else { return Err("no oscillation".into()) };
        let measured = PI * (zeros.len() - 1) as f64 / (last - first);
        let expected = 2.0 / h * (0.5 * h * omega).atan();
        rows.push([
            h.to_string(),
            format!("{measured:.5}"),
            format!("{expected:.5}"),
            format!("{:+.1e}", measured / expected - 1.0),
            format!("{:.1}", path.iterations().total as f64 / path.steps() as f64),
        ]);
    }
    table::print(["h", "frequency", "of the step", "off by", "iterations"], &rows);
    println!("\n  The cluster itself: ω = {omega:.5}.\n");
    Ok(())
}

/// Temperature and fluctuation of distances at several energies.
fn melting(minimum: &Cluster) -> Result<[Figure; 2], Box<dyn Error>> {
    const H: f64 = 0.01;
    /// Degrees of freedom without those of translation and rotation.
    const VIBRATIONS: f64 = 33.0;
    let ground = LennardJones.energy(minimum);
    println!("4. The icosahedron, heated: means over t from 100 to 900, DeltaPlus, h = {H}\n");
    let (mut rows, mut heats, mut wobbles) = (Vec::new(), Vec::new(), Vec::new());
    for per_atom in [0.02, 0.1, 0.3, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1] {
        let start = heated(minimum, 13.0 * per_atom)?;
        let energy = LennardJones.energy(&start);
        let (mut kinetic, mut count) = (0.0, 0.0);
        let mut distances = vec![(0.0_f64, 0.0_f64); 78];
        let path = LennardJones
            .simulate::<DeltaPlus>(H)
            .start(start)
            .until(900.0)
            .record_every(0)
            .inspect(|state, node| {
                if state.t < 100.0 || node.step % 10 != 0 {
                    return;
                }
                kinetic += 0.5 * state.p.norm_squared();
                count += 1.0;
                let at = |i: usize| Vector3::from_column_slice(&state.q.as_slice()[3 * i..3 * i + 3]);
                let pairs = (0..13).flat_map(|i| (0..i).map(move |j| (i, j)));
                for (sums, (i, j)) in distances.iter_mut().zip(pairs) {
                    let square = (at(i) - at(j)).norm_squared();
                    (sums.0, sums.1) = (sums.0 + square.sqrt(), sums.1 + square);
                }
            })
            .run()?;
        let temperature = 2.0 * kinetic / count / VIBRATIONS;
        let spread = |(sum, squares): &(f64, f64)| {
            let mean = sum / count;
            (squares / count - mean * mean).max(0.0).sqrt() / mean
        };
        let wobble = distances.iter().map(spread).sum::<f64>() / 78.0;
        let harmonic = (energy - ground) / VIBRATIONS;
        rows.push([
            format!("{:.2}", energy / 13.0),
            format!("{temperature:.4}"),
            format!("{harmonic:.4}"),
            format!("{wobble:.3}"),
            format!("{:.1e}", (LennardJones.energy(path.last()) - energy).abs()),
        ]);
        heats.push((energy / 13.0, temperature));
        wobbles.push((energy / 13.0, wobble));
    }
    table::print(["E/13", "temperature", "harmonic", "fluctuation", "drift of H"], &rows);
    let harmonic = [ground / 13.0, -2.3].map(|e| (e, (13.0 * e - ground) / VIBRATIONS));
    let melts = wobbles.windows(2).find(|pair| pair[1].1 > 0.1).ok_or("it does not melt")?;
    println!("\n  The fluctuation passes a tenth between E/13 = {:.2} and {:.2}.", melts[0].0, melts[1].0);
    let edge = [(-3.4, 0.1), (-2.3, 0.1)];
    Ok([
        Figure::panel("13 atoms: temperature by energy", "E/13", "temperature")
            .points(Look::Dashed, "harmonic, 2 <K>/33 = (E - E_0)/33", Colour::GREY, harmonic)
            .points(Look::Joined, "measured", Colour::BLUE, heats),
        Figure::panel("13 atoms: fluctuation of distances", "E/13", "mean of δr/<r>")
            .points(Look::Dashed, "a tenth: liquid above", Colour::GREY, edge)
            .points(Look::Joined, "measured", Colour::VERMILION, wobbles),
    ])
}

/// The cluster with random momenta of kinetic energy `energy`, at rest as a whole and not turning.
fn heated(minimum: &Cluster, energy: f64) -> Result<Cluster, wzvi::Error> {
    let mut wiener = Wiener::seed(13);
    let mut p = (0..13)
        .map(|i| {
            let mut p = Vector3::zeros();
            for k in 0..3 {
                p[k] = wiener.value(3 * i + k, 1.0)?;
            }
            Ok(p)
        })
        .collect::<Result<Vec<_>, wzvi::Error>>()?;
    let places: Vec<Vector3<f64>> =
        minimum.q.as_slice().chunks_exact(3).map(Vector3::from_column_slice).collect();
    let mean = p.iter().sum::<Vector3<f64>>() / 13.0;
    p.iter_mut().for_each(|p| *p -= mean);
    // The icosahedron has the inertia 2/3 Σ r² in every direction.
    let inertia = 2.0 / 3.0 * places.iter().map(Vector3::norm_squared).sum::<f64>();
    let turn = places.iter().zip(&p).map(|(q, p)| q.cross(p)).sum::<Vector3<f64>>() / inertia;
    p.iter_mut().zip(&places).for_each(|(p, q)| *p -= turn.cross(q));
    let kinetic: f64 = p.iter().map(|p| 0.5 * p.norm_squared()).sum();
    let scale = (energy / kinetic).sqrt();
    let p: Vec<f64> = p.iter().flat_map(|p| (p * scale).data.0[0]).collect();
    Ok(State::new(minimum.q.clone(), p))
}
