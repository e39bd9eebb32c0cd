//! Timings of two dozen scenes, in nanoseconds, for comparing two builds: a change of the inside keeps each within 5 %.
//!
//! Run `cargo bench --workspace --bench probe` on an idle machine, the old and the new build alternating, and take the best of three.

#![allow(missing_docs, clippy::unwrap_used, reason = "a benchmark stops at the first error")]
use std::time::Instant;
use wzvi::prelude::*;

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let v = |d: f64| 0.5 * d * d + 0.25 * beta * d.powi(4);
        let n = q.len();
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + (1..n).map(|i| v(q[i] - q[i - 1])).sum::<f64>()
            + v(q[0]) + v(q[n - 1])
    },
    embedding = [DeltaPlus, Verlet, Midpoint],
)]
struct Fput {
    beta: f64,
}

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let n = q.len();
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + (0..n).map(|i| 0.5 * (q[(i + 1) % n] - q[i]).powi(2) + k * (1.0 - q[i].cos())).sum::<f64>()
    },
    embedding = [DeltaPlus, Verlet, Midpoint],
)]
struct Ring {
    k: f64,
}

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let kinetic: f64 = p.iter().map(|p| 0.5 * p * p).sum();
        let potential: f64 = (0..side)
            .map(|i| {
                (0..side)
                    .map(|j| {
                        let own = q[i * side + j];
                        let right = q[i * side + (j + 1) % side];
                        let down = q[(i + 1) % side * side + j];
                        let bonds = (right - own) * (right - own) + (down - own) * (down - own);
                        let well = own * own - 1.0;
                        0.5 * bonds + 0.25 * well * well
                    })
                    .sum::<f64>()
            })
            .sum();
        kinetic + potential
    },
    embedding = [DeltaPlus, Verlet, Midpoint],
)]
struct Lattice {
    side: usize,
}

#[hamiltonian(
    drift = |q: &[[f64; 3]], p: &[[f64; 3]]| {
        let n = q.len();
        let kinetic: f64 = p.iter().map(|p| 0.5 * (p[0] * p[0] + p[1] * p[1] + p[2] * p[2])).sum();
        let pairs: f64 = (0..n)
            .map(|i| {
                (0..i)
                    .map(|j| {
                        let [x, y, z] = [q[i][0] - q[j][0], q[i][1] - q[j][1], q[i][2] - q[j][2]];
                        g / (x * x + y * y + z * z + softening).sqrt()
                    })
                    .sum::<f64>()
            })
            .sum();
        kinetic - pairs
    },
    embedding = [DeltaPlus],
)]
struct Bodies {
    g: f64,
    softening: f64,
}

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + bonds.iter().zip(strength).map(|(&[a, b], k)| k * (1.0 - (q[a] - q[b]).cos())).sum::<f64>()
    },
    embedding = [DeltaPlus, Midpoint],
)]
struct Network {
    bonds: Vec<[usize; 2]>,
    strength: Vec<f64>,
}

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| q.iter().zip(p).map(|(q, p)| 0.5 * (p * p + q * q)).sum::<f64>(),
    embedding = [Midpoint],
)]
struct Sites {}

#[hamiltonian(drift = |q, p| 0.5 * a * (q * q + p * p), noise = [|q, p| 0.5 * sigma * (q * q + p * p)], embedding = [Midpoint])]
struct Kubo {
    a: f64,
    sigma: f64,
}

#[hamiltonian(drift = |q, p| 0.5 * p * p - q.cos(), embedding = [Midpoint, Gauss<8>])]
struct Pendulum;

fn steps<H, E>(name: &str, system: &H, n: usize, per: usize, q: impl Fn(usize) -> f64, h: f64, count: usize)
where
    H: Discretized<E, Vector = wzvi::nalgebra::DVector<f64>> + wzvi::integrate::Integrate,
{
    let mut best = f64::INFINITY;
    for _ in 0..9 {
        let mut s = State::new((0..n).map(&q).collect::<Vec<_>>(), vec![0.0; n]);
        let mut stepper = Stepper::<H, E>::new(system, h).unwrap().threads(1).unwrap();
        for _ in 0..4 {
            stepper.step(&mut s, &[]).unwrap();
        }
        let t = Instant::now();
        for _ in 0..count {
            stepper.step(&mut s, &[]).unwrap();
        }
        best = best.min(t.elapsed().as_secs_f64() * 1e9 / count as f64);
        if !s.q[0].is_finite() {
            println!("nan");
        }
    }
    println!("{name:28} {:9.3} ns/site", best / per as f64);
}

fn main() {
    let pi = std::f64::consts::PI;
    let fput = Fput { beta: 0.25 };
    for n in [128usize, 1024, 65536] {
        let q = |i: usize| (pi * (i + 1) as f64 / (n + 1) as f64).sin();
        let c = (2_000_000 / n).max(20);
        steps::<_, DeltaPlus>(&format!("chain {n} DeltaPlus"), &fput, n, n, q, 0.05, c);
        steps::<_, Verlet>(&format!("chain {n} Verlet"), &fput, n, n, q, 0.05, c);
        steps::<_, Midpoint>(&format!("chain {n} Midpoint"), &fput, n, n, q, 0.05, c / 4);
    }
    let ring = Ring { k: 1.0 };
    steps::<_, Verlet>("ring 1024 Verlet", &ring, 1024, 1024, |i| (i as f64 * 0.37).sin(), 0.05, 500);
    steps::<_, Midpoint>("ring 1024 Midpoint", &ring, 1024, 1024, |i| (i as f64 * 0.37).sin(), 0.05, 100);
    let lattice = Lattice { side: 256 };
    let n = 65536;
    steps::<_, DeltaPlus>("lattice 256^2 DeltaPlus", &lattice, n, n, |i| (i as f64 * 0.37).sin(), 0.05, 20);
    steps::<_, Verlet>("lattice 256^2 Verlet", &lattice, n, n, |i| (i as f64 * 0.37).sin(), 0.05, 20);
    steps::<_, Midpoint>("lattice 256^2 Midpoint", &lattice, n, n, |i| (i as f64 * 0.37).sin(), 0.05, 8);
    let bodies = Bodies { g: 1.0, softening: 0.01 };
    for n in [16usize, 64, 512] {
        steps::<_, DeltaPlus>(
            &format!("bodies {n} DeltaPlus (per pair)"),
            &bodies,
            3 * n,
            n * (n - 1) / 2,
            |i| (i as f64 * 0.73).sin() * 3.0,
            0.001,
            400_000 / (n * n) + 5,
        );
    }
    let sites = 4096;
    let mut seed = 1u64;
    let mut next = || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 33) as usize % sites
    };
    let bonds: Vec<[usize; 2]> = (0..3 * sites)
        .map(|k| {
            let mut b = next();
            if b == k / 3 {
                b = (b + 1) % sites;
            }
            [k / 3, b]
        })
        .collect();
    let strength = vec![1.0; bonds.len()];
    let network = Network { bonds, strength };
    steps::<_, DeltaPlus>(
        "network DeltaPlus",
        &network,
        sites,
        sites,
        |i| (i as f64 * 0.37).sin(),
        0.05,
        100,
    );
    steps::<_, Midpoint>("network Midpoint", &network, sites, sites, |i| (i as f64 * 0.37).sin(), 0.05, 30);
    steps::<_, Midpoint>(
        "uncoupled 1024 Midpoint",
        &Sites {},
        1024,
        1024,
        |i| (i as f64 * 0.37).sin(),
        0.05,
        2000,
    );
    // ensembles
    let mut best = [f64::INFINITY; 3];
    for _ in 0..7 {
        let t = Instant::now();
        let kubo = Kubo { a: 1.5, sigma: 1.0 };
        let s = kubo
            .ensemble::<Midpoint>(0.01)
            .start(State::new([0.0], [1.0]))
            .paths(2048)
            .seed(7)
            .steps(500)
            .observe("q", |s| s.q[0])
            .threads(1)
            .run()
            .unwrap();
        best[0] = best[0].min(t.elapsed().as_secs_f64() * 1e9 / (2048.0 * 500.0));
        assert!(s.mean("q").unwrap().is_finite());
        let t = Instant::now();
        let s = Pendulum
            .ensemble::<Gauss<8>>(0.1)
            .starts(|d| State::new([0.1 + 0.001 * (d.path() % 512) as f64], [0.0]))
            .paths(512)
            .steps(500)
            .observe("q", |s| s.q[0])
            .threads(1)
            .run()
            .unwrap();
        best[1] = best[1].min(t.elapsed().as_secs_f64() * 1e9 / (512.0 * 500.0));
        assert!(s.mean("q").unwrap().is_finite());
        let t = Instant::now();
        let s = Pendulum
            .ensemble::<Midpoint>(0.1)
            .starts(|d| State::new([0.1 + 0.001 * (d.path() % 512) as f64], [0.0]))
            .paths(512)
            .steps(500)
            .observe("q", |s| s.q[0])
            .threads(1)
            .run()
            .unwrap();
        best[2] = best[2].min(t.elapsed().as_secs_f64() * 1e9 / (512.0 * 500.0));
        assert!(s.mean("q").unwrap().is_finite());
    }
    println!(
        "ensemble Kubo Midpoint {:8.2}; pendulum Gauss<8> {:8.2}; pendulum Midpoint {:8.2} ns/path/step",
        best[0], best[1], best[2]
    );
}
