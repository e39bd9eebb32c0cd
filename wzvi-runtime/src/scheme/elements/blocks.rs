//! Blocks of equations without common unknowns, which are solved independently. Uncoupled sites are one block each.

use std::ops::Range;

use super::jacobian::pattern;
use super::{Elements, Quadrature, Unknowns};
use crate::algebra::solve::Apart;

/// The blocks of a system, and those that a careful step solves.
#[derive(Debug, Default)]
pub(super) struct Blocks {
    /// The block of each degree of freedom; empty until the blocks are found.
    of: Vec<usize>,
    /// Number of blocks.
    count: usize,
    /// The blocks to solve; `None` for all.
    wanted: Option<Range<usize>>,
}

impl Blocks {
    /// Blocks that are still to be found, with the same selection.
    pub(super) fn alike(&self) -> Self {
        Self { wanted: self.wanted.clone(), ..Self::default() }
    }

    pub(super) fn count(&self) -> usize {
        self.count.max(1)
    }

    pub(super) fn restrict(&mut self, wanted: Range<usize>) {
        self.wanted = Some(wanted);
    }

    /// Finds the blocks, unless they are known.
    pub(super) fn find<H: Elements>(&mut self, system: &H, scheme: &Quadrature, degrees: usize) {
        if self.of.len() == degrees {
            return;
        }
        let per_degree = scheme.unknowns.count(1).max(1);
        let mut apart = Apart::new(degrees);
        if H::FACTS.has_pieces {
            // Conditions of piecewise functions couple degrees of freedom even where no derivative does.
            (1..degrees).for_each(|degree| apart.join(degree - 1, degree));
        }
        let join = &mut |row, column| apart.join(row / per_degree, column / per_degree);
        pattern(system, scheme, degrees, join);
        (self.count, self.of) = apart.parts();
    }

    /// Whether a degree of freedom is held fixed.
    pub(super) fn holds(&self, degree: usize) -> bool {
        self.wanted.as_ref().is_some_and(|wanted| !wanted.contains(&self.of[degree]))
    }

    /// Whether the unknown with this number stays zero.
    pub(super) fn holds_unknown(&self, unknowns: Unknowns, number: usize) -> bool {
        self.wanted.is_some() && self.holds(number / unknowns.count(1).max(1))
    }

    /// Whether any block has an odd number of unknowns that reverse the sign of its determinant.
    pub(super) fn is_any_reversed(&self, unknowns: Unknowns, reverses: impl Fn(usize) -> bool) -> bool {
        let (mut reversed, per_degree) = (vec![false; self.count], unknowns.count(1));
        for unknown in 0..self.of.len() * per_degree {
            reversed[self.of[unknown / per_degree]] ^= reverses(unknown);
        }
        reversed.contains(&true)
    }
}
