//! FPUT-beta.

use wzvi::prelude::*;

use crate::measure::{Case, Explicit, FixedPoint, Forces, KickDriftKick, generated};

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

pub(crate) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (n, steps) in [(32, 4_000), (1024, 100), (1_000_000, 1)] {
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
    cases
}
