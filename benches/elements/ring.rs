//! A ring of coupled pendulums: the sine-Gordon equation.

use wzvi::prelude::*;

use crate::measure::{Case, Explicit, Forces, KickDriftKick, generated};

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let n = q.len();
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + (0..n).map(|i| 0.5 * (q[(i + 1) % n] - q[i]).powi(2) + k * (1.0 - q[i].cos())).sum::<f64>()
    },
    embedding = [DeltaPlus, Verlet],
)]
struct SineGordon {
    k: f64,
}

const H: f64 = 0.05;
static RING: SineGordon = SineGordon { k: 1.0 };

fn wave(n: usize) -> Vec<f64> {
    (0..n).map(|i| 1.0 + 0.3 * (std::f64::consts::TAU * i as f64 / n as f64).sin()).collect()
}

struct Pendulums;

impl Forces for Pendulums {
    fn forces(&self, q: &[f64], force: &mut [f64]) {
        let last = q.len() - 1;
        let force_at = |left: f64, own: f64, right: f64| (right - own) - (own - left) - own.sin();
        force[0] = force_at(q[last], q[0], q[1]);
        for (force, window) in force[1..last].iter_mut().zip(q.windows(3)) {
            *force = force_at(window[0], window[1], window[2]);
        }
        force[last] = force_at(q[last - 1], q[last], q[0]);
    }
}

pub(crate) fn cases() -> Vec<Case> {
    let case = |(n, steps)| Case {
        problem: "ring",
        scheme: "DeltaPlus",
        n,
        steps,
        is_counted: true,
        // Rounding of numbers of order one in each of 10 steps.
        tolerance: 1e-12,
        generated: |n| generated::<_, DeltaPlus>(&RING, H, wave(n), vec![0.0; n]),
        by_hand: |n| Explicit::boxed(Pendulums, H, wave(n), vec![0.0; n]),
    };
    let verlet = |case: Case| Case {
        scheme: "Verlet",
        generated: |n| generated::<_, Verlet>(&RING, H, wave(n), vec![0.0; n]),
        by_hand: |n| KickDriftKick::boxed(Pendulums, H, wave(n), vec![0.0; n]),
        ..case
    };
    [(32, 4_000), (1024, 200), (65_536, 2)]
        .map(case)
        .into_iter()
        .flat_map(|case| [case, verlet(case)])
        .collect()
}
