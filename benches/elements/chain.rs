//! FPUT-beta.

use wzvi::prelude::*;

use crate::measure::{Case, Explicit, FixedPoint, Forces, KickDriftKick, Runner, generated, generated_on};

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

/// The same of points in space.
#[hamiltonian(
    drift = |q: &[[f64; 3]], p: &[[f64; 3]]| {
        let n = q.len();
        p.iter().map(|p| 0.5 * (p[0] * p[0] + p[1] * p[1] + p[2] * p[2])).sum::<f64>()
            + (1..n)
                .map(|i| {
                    let [x, y, z] = [q[i][0] - q[i - 1][0], q[i][1] - q[i - 1][1], q[i][2] - q[i - 1][2]];
                    let square = x * x + y * y + z * z;
                    0.5 * square + 0.25 * beta * square * square
                })
                .sum::<f64>()
    },
    embedding = [DeltaPlus, Verlet],
)]
struct Polymer {
    beta: f64,
}

static POLYMER: Polymer = Polymer { beta: BETA };

const H: f64 = 0.05;
const BETA: f64 = 0.25;
static FPUT: Fput = Fput { beta: BETA };

fn first_mode(n: usize) -> Vec<f64> {
    (0..n).map(|i| (std::f64::consts::PI * (i + 1) as f64 / (n + 1) as f64).sin()).collect()
}

struct Springs;

fn pull(d: f64) -> f64 {
    d * (1.0 + BETA * d * d)
}

impl Forces for Springs {
    fn forces(&self, q: &[f64], force: &mut [f64]) {
        let n = q.len();
        force[0] = pull(q[1] - q[0]) - pull(q[0]);
        for (force, window) in force[1..n - 1].iter_mut().zip(q.windows(3)) {
            *force = pull(window[2] - window[1]) - pull(window[1] - window[0]);
        }
        force[n - 1] = pull(-q[n - 1]) - pull(q[n - 1] - q[n - 2]);
    }
}

/// Bonds between points in space.
struct Bonds;

impl Forces for Bonds {
    fn forces(&self, q: &[f64], force: &mut [f64]) {
        force.fill(0.0);
        let (points, _) = q.as_chunks::<3>();
        let (forces, _) = force.as_chunks_mut::<3>();
        for (bond, points) in points.windows(2).enumerate() {
            let d: [f64; 3] = std::array::from_fn(|k| points[1][k] - points[0][k]);
            let factor = 1.0 + BETA * (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
            for k in 0..3 {
                forces[bond][k] += factor * d[k];
                forces[bond + 1][k] -= factor * d[k];
            }
        }
    }
}

/// Steps of all numbers of points.
fn polymer(n: usize, steps: usize) -> [Case; 2] {
    let plus = Case {
        problem: "polymer",
        scheme: "DeltaPlus",
        n,
        steps,
        is_counted: n < 10_000,
        tolerance: 1e-12,
        generated: |n| generated::<_, DeltaPlus>(&POLYMER, H, first_mode(3 * n), vec![0.0; 3 * n]),
        by_hand: |n| Explicit::boxed(Bonds, H, first_mode(3 * n), vec![0.0; 3 * n]),
    };
    let verlet = Case {
        scheme: "Verlet",
        generated: |n| generated::<_, Verlet>(&POLYMER, H, first_mode(3 * n), vec![0.0; 3 * n]),
        by_hand: |n| KickDriftKick::boxed(Bonds, H, first_mode(3 * n), vec![0.0; 3 * n]),
        ..plus
    };
    [plus, verlet]
}

/// Steps on so many threads: explicit ones, and those of a fixed point.
pub(crate) fn on_threads(threads: usize, n: usize) -> [(&'static str, Box<dyn Runner>); 3] {
    let [q, p] = [first_mode(n), vec![0.0; n]];
    [
        ("DeltaPlus", generated_on::<_, DeltaPlus>(threads, &FPUT, H, q.clone(), p.clone())),
        ("Verlet", generated_on::<_, Verlet>(threads, &FPUT, H, q.clone(), p.clone())),
        ("Midpoint", generated_on::<_, Midpoint>(threads, &FPUT, H, q, p)),
    ]
}

pub(crate) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (n, steps) in [(32, 4_000), (1024, 100), (65_536, 4), (1_000_000, 1)] {
        let is_counted = n < 10_000;
        // Rounding of numbers of order one in each of 10 steps, and of momenta as differences over h.
        let tolerance = 1e-12;
        cases.push(Case {
            problem: "chain",
            scheme: "DeltaPlus",
            n,
            steps: 4 * steps,
            is_counted,
            tolerance,
            generated: |n| generated::<_, DeltaPlus>(&FPUT, H, first_mode(n), vec![0.0; n]),
            by_hand: |n| Explicit::boxed(Springs, H, first_mode(n), vec![0.0; n]),
        });
        cases.push(Case {
            problem: "chain",
            scheme: "Verlet",
            n,
            steps: 4 * steps,
            is_counted,
            tolerance,
            generated: |n| generated::<_, Verlet>(&FPUT, H, first_mode(n), vec![0.0; n]),
            by_hand: |n| KickDriftKick::boxed(Springs, H, first_mode(n), vec![0.0; n]),
        });
        cases.push(Case {
            problem: "chain",
            scheme: "Midpoint",
            n,
            steps,
            is_counted,
            tolerance,
            generated: |n| generated::<_, Midpoint>(&FPUT, H, first_mode(n), vec![0.0; n]),
            by_hand: |n| FixedPoint::boxed(Springs, H, first_mode(n), vec![0.0; n]),
        });
    }
    cases.extend([(1024, 100), (100_000, 1)].into_iter().flat_map(|(n, steps)| polymer(n, steps)));
    cases
}
