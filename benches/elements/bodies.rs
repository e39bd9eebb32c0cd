//! Gravity between all pairs.

use wzvi::prelude::*;

use crate::measure::{Case, Explicit, FixedPoint, Forces, Row, generated};

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
    embedding = [DeltaPlus, Midpoint],
)]
struct Gravity {
    g: f64,
    /// Square of a length.
    softening: f64,
}

const H: f64 = 0.01;
const G: f64 = 0.1;
const SOFTENING: f64 = 0.01;
static GRAVITY: Gravity = Gravity { g: G, softening: SOFTENING };

/// Points that fill a ball evenly: spirals of the golden angle on shells.
fn ball(bodies: usize) -> Vec<f64> {
    (0..bodies)
        .flat_map(|i| {
            let part = (i as f64 + 0.5) / bodies as f64;
            let (height, angle) = (1.0 - 2.0 * part, 2.399_963 * i as f64);
            let (radius, across) = (2.0 + (7.1 * i as f64).sin(), (1.0 - height * height).sqrt());
            [radius * across * angle.cos(), radius * across * angle.sin(), radius * height]
        })
        .collect()
}

struct Pairs;

impl Forces for Pairs {
    fn forces(&self, q: &[f64], force: &mut [f64]) {
        force.fill(0.0);
        let (points, _) = q.as_chunks::<3>();
        let (forces, _) = force.as_chunks_mut::<3>();
        for (i, &[x, y, z]) in points.iter().enumerate() {
            let (others, own) = forces.split_at_mut(i);
            let mut sum = [0.0; 3];
            for (&[a, b, c], other) in points.iter().zip(others) {
                let [dx, dy, dz] = [x - a, y - b, z - c];
                let square = dx * dx + dy * dy + dz * dz + SOFTENING;
                let pull = G / (square * square.sqrt());
                for (k, d) in [dx, dy, dz].into_iter().enumerate() {
                    sum[k] += pull * d;
                    other[k] += pull * d;
                }
            }
            for k in 0..3 {
                own[0][k] -= sum[k];
            }
        }
    }
}

pub(crate) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (n, steps) in [(8, 500), (64, 10), (512, 1)] {
        // 512 bodies sum 511 forces of order one each.
        let tolerance = 1e-11;
        cases.push(Case {
            problem: "bodies",
            scheme: "DeltaPlus",
            n,
            steps: 4 * steps,
            is_counted: true,
            tolerance,
            generated: |n| generated::<_, DeltaPlus>(&GRAVITY, H, ball(n), vec![0.0; 3 * n]),
            by_hand: |n| Explicit::boxed(Pairs, H, ball(n), vec![0.0; 3 * n]),
        });
        cases.push(Case {
            problem: "bodies",
            scheme: "Midpoint",
            n,
            steps,
            is_counted: true,
            tolerance,
            generated: |n| generated::<_, Midpoint>(&GRAVITY, H, ball(n), vec![0.0; 3 * n]),
            by_hand: |n| FixedPoint::boxed(Pairs, H, ball(n), vec![0.0; 3 * n]),
        });
    }
    cases
}

/// The time of an explicit step by the number of its pairs.
pub(crate) fn per_pair(rows: &[(&Case, Row)]) {
    for (case, row) in rows.iter().filter(|(case, _)| case.problem == "bodies" && case.scheme == "DeltaPlus")
    {
        let [generated, by_hand] = row.nanoseconds().map(|per_body| 2.0 * per_body / (case.n - 1) as f64);
        println!("bodies, {:>4}: {generated:.2} ns per pair and step, by hand {by_hand:.2}", case.n);
    }
}
