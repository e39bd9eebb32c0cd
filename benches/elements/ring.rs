//! A ring of coupled pendulums: the sine-Gordon equation.

use wzvi::prelude::*;

use crate::measure::{Case, Explicit, Forces, KickDriftKick, Runner, generated, generated_with};

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let n = q.len();
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + (0..n).map(|i| 0.5 * (q[(i + 1) % n] - q[i]).powi(2) + k * (1.0 - q[i].cos())).sum::<f64>()
    },
    embedding = [DeltaPlus, Verlet],
)]
pub(crate) struct SineGordon {
    k: f64,
}

/// The same in a bath.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let n = q.len();
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + (0..n).map(|i| 0.5 * (q[(i + 1) % n] - q[i]).powi(2) + k * (1.0 - q[i].cos())).sum::<f64>()
    },
    friction = gamma,
    temperature = kt,
    embedding = Baoab,
)]
struct Bathed {
    k: f64,
    gamma: f64,
    kt: f64,
}

pub(crate) const H: f64 = 0.05;
static BATHED: Bathed = Bathed { k: 1.0, gamma: 1.0, kt: 0.5 };
pub(crate) static RING: SineGordon = SineGordon { k: 1.0 };

pub(crate) fn wave(n: usize) -> Vec<f64> {
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

/// `√h` times numbers in the place of normals: what draws them is timed elsewhere.
fn driving(n: usize) -> Vec<f64> {
    (0..n).map(|i| H.sqrt() * (1.7 * i as f64).sin()).collect()
}

/// Kick, drift, friction and noise, drift, kick.
struct InBath {
    steps: Explicit<Pendulums>,
    driving: Vec<f64>,
}

impl InBath {
    fn boxed(n: usize) -> Box<dyn Runner> {
        let (q, mut force) = (wave(n), vec![0.0; n]);
        Pendulums.forces(&q, &mut force);
        let steps = Explicit { forces: Pendulums, force, q, p: vec![0.0; n], h: H };
        Box::new(Self { steps, driving: driving(n) })
    }
}

impl Runner for InBath {
    fn run(&mut self, steps: usize) {
        let Explicit { forces, q, p, force, h } = &mut self.steps;
        let (half, decay) = (0.5 * *h, (-BATHED.gamma * *h).exp());
        let deviation = (BATHED.kt * (1.0 - decay * decay) / *h).sqrt();
        for _ in 0..steps {
            for ((q, p), (force, drawn)) in q.iter_mut().zip(&mut *p).zip(force.iter().zip(&self.driving)) {
                *p += half * force;
                *q += half * *p;
                *p = *p * decay + drawn * deviation;
                *q += half * *p;
            }
            forces.forces(q, force);
            for (p, force) in p.iter_mut().zip(&*force) {
                *p += half * force;
            }
        }
    }
    fn state(&self) -> (Vec<f64>, Vec<f64>) {
        self.steps.state()
    }
    fn iterations(&self) -> u64 {
        0
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
    let baoab = |case: Case| Case {
        scheme: "Baoab",
        generated: |n| generated_with::<_, Baoab>(&BATHED, H, wave(n), vec![0.0; n], driving(n)),
        by_hand: InBath::boxed,
        ..case
    };
    let cases = [(32, 4_000), (1024, 200), (65_536, 2)].map(case);
    cases.into_iter().flat_map(|case| [case, verlet(case), baoab(case)]).collect()
}
