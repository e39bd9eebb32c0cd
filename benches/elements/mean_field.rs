//! Rotors that feel their magnetisation: sums over all sites in a nonlinear function, beside two loops by hand, which
//! keep the sine and the cosine of each angle from the first to the second.

use wzvi::prelude::*;

use crate::measure::{Case, Forces, KickDriftKick, generated};

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let n = q.len() as f64;
        let c = q.iter().map(|q| q.cos()).sum::<f64>();
        let s = q.iter().map(|q| q.sin()).sum::<f64>();
        p.iter().map(|p| 0.5 * p * p).sum::<f64>() - 0.5 * coupling / n * (c * c + s * s)
    },
    embedding = Verlet,
)]
struct Rotors {
    coupling: f64,
}

const H: f64 = 0.05;
static ROTORS: Rotors = Rotors { coupling: 1.0 };

fn angles(n: usize) -> Vec<f64> {
    (0..n).map(|i| (1.7 * i as f64).sin()).collect()
}

/// Room for the sines and cosines of all angles.
struct MeanField(std::cell::RefCell<Vec<(f64, f64)>>);

impl Forces for MeanField {
    fn forces(&self, q: &[f64], force: &mut [f64]) {
        let mut functions = self.0.borrow_mut();
        functions.clear();
        functions.extend(q.iter().map(|q| q.sin_cos()));
        let (mut c, mut s) = (0.0, 0.0);
        for &(sin, cos) in &*functions {
            (c, s) = (c + cos, s + sin);
        }
        let scale = ROTORS.coupling / q.len() as f64;
        let (c, s) = (scale * c, scale * s);
        for (force, &(sin, cos)) in force.iter_mut().zip(&*functions) {
            *force = s * cos - c * sin;
        }
    }
}

pub(crate) fn cases() -> Vec<Case> {
    let case = |(n, steps)| Case {
        problem: "mean field",
        scheme: "Verlet",
        n,
        steps,
        is_counted: true,
        // Rounding of sums of all angles in each of 10 steps.
        tolerance: 1e-11,
        generated: |n| generated::<_, Verlet>(&ROTORS, H, angles(n), vec![0.0; n]),
        by_hand: |n| KickDriftKick::boxed(MeanField(Default::default()), H, angles(n), vec![0.0; n]),
    };
    [(32, 4_000), (1000, 200), (16_000, 10)].map(case).into()
}
