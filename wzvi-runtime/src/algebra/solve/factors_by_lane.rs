//! Factored matrices beside each other, one for each lane.

use std::array::from_fn;

use super::dense::{Factor, substitute};
use crate::algebra::lanes::{LaneMask, Lanes};
use crate::algebra::scalar::{Constants, Mask, Reals, Scalar};
use crate::error::StepFailure;

/// [`Factor`] by lane. Each has the order of rows that its own pivots ask for.
#[derive(Clone, Debug)]
pub struct FactorsByLane<const L: usize, const N: usize> {
    lu: [[Lanes<L>; N]; N],
    /// The order of the rows in all lanes, or in the first.
    order: [usize; N],
    /// By place and row, the lanes that have this row there; only where the orders differ.
    chosen: Option<Box<[[LaneMask<L>; N]; N]>>,
}

impl<const L: usize, const N: usize> FactorsByLane<L, N> {
    /// `A⁻¹ b`, with the bits that each lane has alone.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn apply(&self, b: [Lanes<L>; N]) -> [Lanes<L>; N] {
        let mut ordered = b;
        for place in 0..N {
            ordered[place] = b[self.order[place]];
        }
        if let Some(chosen) = &self.chosen {
            for place in 0..N {
                for row in 0..N {
                    ordered[place] = Lanes::select(chosen[place][row], b[row], ordered[place]);
                }
            }
        }
        substitute(&self.lu, ordered)
    }

    /// Factors a matrix for each lane.
    ///
    /// # Errors
    /// The first of those of [`Factor::new`].
    pub fn new(matrix: [[Lanes<L>; N]; N]) -> Result<Self, StepFailure> {
        let of_lane = |lane: usize| Factor::new(matrix.map(|row| row.map(|entry| entry[lane])));
        let factors: Vec<Factor<f64, N>> = (0..L).map(of_lane).collect::<Result<_, _>>()?;
        Ok(Self::gather(from_fn(|lane| &factors[lane])))
    }

    /// The factors of all lanes.
    pub fn gather(lanes: [&Factor<f64, N>; L]) -> Self {
        let parts = lanes.map(Factor::parts);
        let order = parts.first().map_or([0; N], |(_, order)| **order);
        let is_same = parts.iter().all(|(_, other)| **other == order);
        let chosen = (!is_same).then(|| {
            let chosen = |k: usize, row: usize| LaneMask::of_lanes(|lane| parts[lane].1[k] == row);
            Box::new(from_fn(|k| from_fn(|row| chosen(k, row))))
        });
        let lu = from_fn(|row| Reals::gather(parts.map(|(lu, _)| &lu[row])));
        Self { lu, order, chosen }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Matrices whose pivots are in different rows, solved beside each other with the bits that each has
    /// alone.
    #[test]
    fn every_lane_has_its_own_order() {
        let matrices = [
            [[4.0, 1.0, 0.5], [1.0, 3.0, 0.25], [0.5, 0.3, 2.0]],
            [[0.1, 7.0, 0.5], [1.0, 0.3, 0.25], [0.5, 0.3, 2.0]],
            [[0.1, 0.7, 5.0], [0.2, 3.0, 0.25], [5.0, 0.3, 2.0]],
            [[1.0, 0.7, 5.0], [0.2, 0.1, 2.5], [0.5, 3.0, 2.0]],
        ];
        let factors = matrices.map(|matrix| Factor::<f64, 3>::new(matrix).unwrap());
        let orders = factors.iter().map(|factor| *factor.parts().1).collect::<std::collections::HashSet<_>>();
        assert!(orders.len() > 2, "{orders:?}");
        let b = [1.0, -0.0, 0.3];
        let lanes: [&Factor<f64, 3>; 4] = std::array::from_fn(|lane| &factors[lane]);
        let solved = FactorsByLane::gather(lanes).apply(b.map(Lanes::<4>::from_f64));
        for (lane, factor) in factors.iter().enumerate() {
            let alone = factor.apply(b);
            assert_eq!(solved.map(|x| x[lane].to_bits()), alone.map(f64::to_bits), "lane {lane}");
        }
        let of_lanes = std::array::from_fn(|row| {
            std::array::from_fn(|column| Lanes::new(matrices.map(|matrix| matrix[row][column])))
        });
        let same_bits = FactorsByLane::<4, 3>::new(of_lanes).unwrap().apply(b.map(Lanes::from_f64));
        assert_eq!(same_bits, solved);
        let same = FactorsByLane::gather([&factors[1]; 4]);
        assert!(same.chosen.is_none());
        assert_eq!(same.apply(b.map(Lanes::from_f64)).map(|x| x[3]), factors[1].apply(b));
    }
}
