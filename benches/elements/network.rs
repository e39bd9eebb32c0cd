//! Oscillators on a random graph, three bonds per site, which pull by the sine of their difference: the ends of bonds come from a table.

use std::sync::LazyLock;

use wzvi::prelude::*;

use crate::measure::{Case, Explicit, FixedPoint, Forces, KickDriftKick, generated};

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + bonds.iter().zip(strength).map(|(&[a, b], k)| k * (1.0 - (q[a] - q[b]).cos())).sum::<f64>()
    },
    embedding = [DeltaPlus, Verlet, Midpoint],
)]
struct Network {
    bonds: Vec<[usize; 2]>,
    strength: Vec<f64>,
}

const H: f64 = 0.05;
pub(crate) const N: usize = 4096;
/// Bonds of a site.
const DEGREE: usize = 3;

static NETWORK: LazyLock<Network> = LazyLock::new(|| {
    let bonds: Vec<[usize; 2]> =
        ends(DEGREE * N).map(|[a, b]| [a, if a == b { (a + 1) % N } else { b }]).collect();
    let strength = (0..bonds.len()).map(|b| 0.3 + 0.1 * (0.7 * b as f64).sin()).collect();
    Network { bonds, strength }
});

/// Pairs of sites from a linear congruential generator, the same as in C.
fn ends(count: usize) -> impl Iterator<Item = [usize; 2]> {
    let mut state = 1_u64;
    let mut draw = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % N
    };
    (0..count).map(move |_| [draw(), draw()])
}

fn angles(n: usize) -> Vec<f64> {
    (0..n).map(|i| 1.5 * (1.7 * i as f64).sin()).collect()
}

struct Bonds;

impl Forces for Bonds {
    fn forces(&self, q: &[f64], force: &mut [f64]) {
        force.fill(0.0);
        for (&[a, b], k) in NETWORK.bonds.iter().zip(&NETWORK.strength) {
            let pull = k * (q[a] - q[b]).sin();
            force[a] -= pull;
            force[b] += pull;
        }
    }
}

pub(crate) fn cases() -> Vec<Case> {
    let explicit = Case {
        problem: "network",
        scheme: "DeltaPlus",
        n: N,
        steps: 20,
        is_counted: true,
        // Rounding of numbers of order one in each of 10 steps.
        tolerance: 1e-12,
        generated: |n| generated::<_, DeltaPlus>(&*NETWORK, H, angles(n), vec![0.0; n]),
        by_hand: |n| Explicit::boxed(Bonds, H, angles(n), vec![0.0; n]),
    };
    let verlet = Case {
        scheme: "Verlet",
        generated: |n| generated::<_, Verlet>(&*NETWORK, H, angles(n), vec![0.0; n]),
        by_hand: |n| KickDriftKick::boxed(Bonds, H, angles(n), vec![0.0; n]),
        ..explicit
    };
    let midpoint = Case {
        scheme: "Midpoint",
        steps: 4,
        // The same, and what the iteration by hand leaves.
        tolerance: 1e-11,
        generated: |n| generated::<_, Midpoint>(&*NETWORK, H, angles(n), vec![0.0; n]),
        by_hand: |n| FixedPoint::boxed(Bonds, H, angles(n), vec![0.0; n]),
        ..explicit
    };
    vec![explicit, verlet, midpoint]
}
