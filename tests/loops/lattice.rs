//! A lattice that several files step.

use wzvi::prelude::*;

/// A field on a torus of `rows` times `columns` sites with springs to the neighbours, in wells at the roots of `well`: φ⁴ where that is 1.
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
                            0.5 * bonds + 0.25 * (own * own - well) * (own * own - well)
                        })
                        .sum::<f64>()
                })
                .sum::<f64>()
    },
    embedding = [DeltaPlus, DeltaMinus, Verlet, Midpoint],
)]
pub(crate) struct Torus {
    pub(crate) rows: usize,
    pub(crate) columns: usize,
    pub(crate) well: f64,
}

impl Torus {
    pub(crate) fn square(side: usize, well: f64) -> Self {
        Self { rows: side, columns: side, well }
    }
}
