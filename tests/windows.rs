//! Large systems are stepped window by window, in vector instructions: their bits are those of one pass over all sites, number
//! by number.
//!
//! The reference is the same generated step on [`Lanes<1>`], which takes no windows and no vector registers. Nothing is
//! compared but for equality.

#![allow(clippy::unwrap_used, reason = "a test may stop")]

use wzvi::lanes::Lanes;
use wzvi::prelude::*;

/// Springs to both walls, and between sites one to three apart.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let v = |d: f64| 0.5 * d * d + 0.25 * beta * d.powi(4);
        let n = q.len();
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + (1..n).map(|i| v(q[i] - q[i - 1])).sum::<f64>()
            + (2..n).map(|i| 0.1 * v(q[i] - q[i - 2])).sum::<f64>()
            + (0..n - 3).map(|i| 0.03 * v(q[i] - q[i + 3])).sum::<f64>()
            + (0..n - 2).map(|i| 0.2 * v(q[i] - 2.0 * q[i + 1] + q[i + 2] * q[i])).sum::<f64>()
            + v(q[0]) + v(q[n - 1])
    },
    embedding = DeltaPlus,
)]
struct Chain {
    beta: f64,
}

/// A ring of pendulums, which has functions, with neighbours up to three sites apart.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let n = q.len();
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + (0..n).map(|i| 0.5 * k * (q[(i + 1) % n] - q[i]).powi(2) - q[i].cos()).sum::<f64>()
            + (0..n).map(|i| 0.1 * (q[(i + 3) % n] - q[(i + 1) % n]).sin() * q[i]).sum::<f64>()
    },
    embedding = DeltaPlus,
)]
struct SineGordon {
    k: f64,
}

/// Masses and springs by site, and a kick by a noise of its own at each.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        (0..p.len()).map(|i| p[i] * p[i] / (2.0 * self.mass[i])).sum::<f64>()
            + (1..q.len()).map(|i| self.spring[i] * (q[i] - q[i - 1]).exp()).sum::<f64>()
    },
    noise = [|q, p, k| 0.3 * q[k] + 0.1 * q[k] * q[k]; self.mass.len()],
    embedding = DeltaPlus,
)]
struct Kicked {
    mass: Vec<f64>,
    spring: Vec<f64>,
}

/// The field φ⁴ on a torus of `rows` times `columns`.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + (0..rows)
                .map(|i| {
                    (0..columns)
                        .map(|j| {
                            let own = q[i * columns + j];
                            let right = q[i * columns + (j + 1) % columns];
                            let down = q[(i + 1) % rows * columns + j];
                            let bonds = (right - own) * (right - own) + (down - own) * (down - own);
                            0.5 * bonds + 0.25 * (own * own - 1.0) * (own * own - 1.0)
                        })
                        .sum::<f64>()
                })
                .sum::<f64>()
    },
    embedding = DeltaPlus,
)]
struct Torus {
    rows: usize,
    columns: usize,
}

/// Angles on a box with open faces, and momenta in the same loops.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        (0..nx)
            .map(|i| {
                (0..ny)
                    .map(|j| {
                        (0..nz)
                            .map(|k| {
                                let own = q[(i * ny + j) * nz + k];
                                0.5 * p[(i * ny + j) * nz + k] * p[(i * ny + j) * nz + k]
                                    + 0.25 * own * own * own * own
                            })
                            .sum::<f64>()
                    })
                    .sum::<f64>()
            })
            .sum::<f64>()
            - (0..nx - 1)
                .map(|i| (0..ny * nz).map(|k| (q[(i + 1) * ny * nz + k] - q[i * ny * nz + k]).cos()).sum::<f64>())
                .sum::<f64>()
    },
    embedding = DeltaPlus,
)]
struct Block {
    nx: usize,
    ny: usize,
    nz: usize,
}

const H: f64 = 0.05;

fn numbers(n: usize, seed: f64) -> Vec<f64> {
    (0..n).map(|i| (1.3 * i as f64 + seed).sin()).collect()
}

/// Steps both ways.
fn check<H: Discretized<DeltaPlus>>(system: &H, mut q: Vec<f64>, mut p: Vec<f64>, what: &str) {
    let alone = |list: &[f64]| -> Vec<Lanes<1>> { list.iter().map(|&x| Lanes::new([x])).collect() };
    let (mut own_q, mut own_p) = (alone(&q), alone(&p));
    let prepared = system.prepare(self::H).unwrap();
    let (mut memory, mut own_memory) = (system.memory(), Default::default());
    for step in 0..5 {
        let dw = numbers(system.noises(), 0.7 * f64::from(step));
        system.advance(&prepared, 0.0, self::H, &mut q, &mut p, &dw, &mut memory).unwrap();
        let dw = alone(&dw);
        system.advance(&prepared, 0.0, self::H, &mut own_q, &mut own_p, &dw, &mut own_memory).unwrap();
        for (i, (a, b)) in q.iter().chain(&p).zip(own_q.iter().chain(&own_p)).enumerate() {
            assert_eq!(a.to_bits(), b[0].to_bits(), "{what}: number {i} of {} after step {step}", q.len());
        }
    }
}

/// Below and above the width of registers, the size from which windows are taken, and that of windows.
fn sizes() -> impl Iterator<Item = usize> {
    (3..40).chain(90..101).chain([128, 200, 511, 512, 513, 514, 1023, 1024, 1025, 1500])
}

#[test]
fn chains_have_the_bits_of_one_pass() {
    for n in sizes() {
        check(&Chain { beta: 0.25 }, numbers(n, 0.2), numbers(n, 1.1), "chain");
        check(&SineGordon { k: 0.7 }, numbers(n, 0.2), numbers(n, 1.1), "ring");
        let (mass, spring) = ((0..n).map(|i| 1.0 + 0.1 * i as f64).collect(), numbers(n, 2.0));
        check(&Kicked { mass, spring }, numbers(n, 0.2), numbers(n, 1.1), "kicked");
    }
}

#[test]
fn lattices_have_the_bits_of_one_pass() {
    let sides = [
        (1, 1),
        (2, 3),
        (3, 2),
        (9, 11),
        (11, 9),
        (1, 700),
        (700, 1),
        (31, 33),
        (40, 64),
        (5, 600),
        (100, 13),
    ];
    for (rows, columns) in sides {
        let n = rows * columns;
        check(&Torus { rows, columns }, numbers(n, 0.2), numbers(n, 1.1), "torus");
    }
    for (nx, ny, nz) in [(2, 1, 1), (5, 5, 5), (3, 20, 30), (20, 3, 30), (20, 30, 3)] {
        let n = nx * ny * nz;
        check(&Block { nx, ny, nz }, numbers(n, 0.2), numbers(n, 1.1), "block");
    }
}

#[test]
fn rare_arguments_of_functions_have_the_bits_of_one_pass() {
    let mut q = numbers(600, 0.2);
    // Beyond what the reduction by π/2 in lanes takes.
    q[301] = 1e9;
    check(&SineGordon { k: 0.7 }, q, numbers(600, 1.1), "far away");
}

#[test]
fn a_step_that_fails_changes_nothing() {
    for bad in [f64::NAN, f64::INFINITY, 1e200] {
        for place in [0, 299, 599] {
            let (mut q, p) = (numbers(600, 0.2), numbers(600, 1.1));
            q[place] = bad;
            let before = (q.clone(), p.clone());
            let (mut state, chain) = (State::new(q, p), Chain { beta: 0.25 });
            let mut stepper = chain.stepper::<DeltaPlus>(H).unwrap();
            assert!(stepper.step(&mut state, &[]).is_err());
            let after = state.q.iter().chain(state.p.iter());
            let same = after.zip(before.0.iter().chain(&before.1)).all(|(a, b)| a.to_bits() == b.to_bits());
            assert!(same, "{bad} at {place}");
        }
    }
}
