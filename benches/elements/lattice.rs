//! The field φ⁴ on a torus.

use wzvi::prelude::*;

use crate::measure::{Case, Explicit, FixedPoint, Forces, KickDriftKick, Runner, generated};

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
struct Torus {
    side: usize,
}

const H: f64 = 0.05;
static SMALL: Torus = Torus { side: 32 };
static LARGE: Torus = Torus { side: 256 };

fn torus(n: usize) -> &'static Torus {
    if n == 32 * 32 { &SMALL } else { &LARGE }
}

fn wave(n: usize) -> Vec<f64> {
    let side = torus(n).side;
    let turn = std::f64::consts::TAU / side as f64;
    (0..n)
        .map(|k| 1.0 + 0.3 * (turn * (k / side) as f64).sin() * (2.0 * turn * (k % side) as f64).cos())
        .collect()
}

/// Rows of `side` sites.
struct Sites {
    side: usize,
}

impl Forces for Sites {
    fn forces(&self, q: &[f64], force: &mut [f64]) {
        let side = self.side;
        let row = |i: usize| &q[i * side..(i + 1) * side];
        for (i, force) in force.chunks_exact_mut(side).enumerate() {
            let (up, own, down) = (row((i + side - 1) % side), row(i), row((i + 1) % side));
            let force_at = |own: f64, left: f64, right: f64, up: f64, down: f64| {
                (left - own) + (right - own) + (up - own) + (down - own) - own * (own * own - 1.0)
            };
            force[0] = force_at(own[0], own[side - 1], own[1], up[0], down[0]);
            let inner = force[1..side - 1].iter_mut().zip(own.windows(3)).zip(up[1..].iter().zip(&down[1..]));
            for ((force, own), (up, down)) in inner {
                *force = force_at(own[1], own[0], own[2], *up, *down);
            }
            let last = side - 1;
            force[last] = force_at(own[last], own[last - 1], own[0], up[last], down[last]);
        }
    }
}

fn by_hand<const IMPLICIT: bool>(n: usize) -> Box<dyn Runner> {
    let sites = Sites { side: torus(n).side };
    if IMPLICIT {
        FixedPoint::boxed(sites, H, wave(n), vec![0.0; n])
    } else {
        Explicit::boxed(sites, H, wave(n), vec![0.0; n])
    }
}

pub(crate) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (side, steps) in [(32, 50), (256, 1)] {
        let tolerance = 1e-12;
        let n = side * side;
        cases.push(Case {
            problem: "lattice",
            scheme: "DeltaPlus",
            n,
            steps: 4 * steps,
            is_counted: true,
            tolerance,
            generated: |n| generated::<_, DeltaPlus>(torus(n), H, wave(n), vec![0.0; n]),
            by_hand: by_hand::<false>,
        });
        cases.push(Case {
            problem: "lattice",
            scheme: "Verlet",
            n,
            steps: 4 * steps,
            is_counted: true,
            tolerance,
            generated: |n| generated::<_, Verlet>(torus(n), H, wave(n), vec![0.0; n]),
            by_hand: |n| KickDriftKick::boxed(Sites { side: torus(n).side }, H, wave(n), vec![0.0; n]),
        });
        cases.push(Case {
            problem: "lattice",
            scheme: "Midpoint",
            n,
            steps,
            is_counted: true,
            tolerance,
            generated: |n| generated::<_, Midpoint>(torus(n), H, wave(n), vec![0.0; n]),
            by_hand: by_hand::<true>,
        });
    }
    cases
}
