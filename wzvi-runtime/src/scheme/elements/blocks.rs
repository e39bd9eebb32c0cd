//! The blocks of equations that have no unknown in common, each of which has a solution of its own: of sites that nothing couples, one each.

use std::ops::Range;

use super::jacobian::pattern;
use super::{Elements, Quadrature, Unknowns};
use crate::algebra::solve::Apart;

/// The blocks of a system, and those that a careful step solves.
#[derive(Debug, Default)]
pub(super) struct Blocks {
    /// The block of each degree of freedom; none while they are not known.
    of: Vec<usize>,
    /// How many there are.
    count: usize,
    /// All, unless it says something else.
    wanted: Option<Range<usize>>,
}

impl Blocks {
    /// Of a system that is not known yet, with the same ones wanted.
    pub(super) fn alike(&self) -> Self {
        Self { wanted: self.wanted.clone(), ..Self::default() }
    }

    pub(super) fn count(&self) -> usize {
        self.count.max(1)
    }

    pub(super) fn restrict(&mut self, wanted: Range<usize>) {
        self.wanted = Some(wanted);
    }

    /// Finds them out, if they are not known.
    pub(super) fn find<H: Elements>(&mut self, system: &H, scheme: &Quadrature, degrees: usize) {
        if self.of.len() == degrees {
            return;
        }
        let per_degree = scheme.unknowns.count(1).max(1);
        let mut apart = Apart::new(degrees);
        if H::FACTS.has_pieces {
            // Degrees of freedom whose sides a condition compares are coupled where no derivative says so.
            (1..degrees).for_each(|degree| apart.join(degree - 1, degree));
        }
        pattern(system, scheme, degrees, |row, column| apart.join(row / per_degree, column / per_degree));
        (self.count, self.of) = apart.parts();
    }

    /// Whether a degree of freedom stays as it is.
    pub(super) fn holds(&self, degree: usize) -> bool {
        self.wanted.as_ref().is_some_and(|wanted| !wanted.contains(&self.of[degree]))
    }

    /// Whether the unknown with this number stays zero.
    pub(super) fn holds_unknown(&self, unknowns: Unknowns, number: usize) -> bool {
        self.wanted.is_some() && self.holds(number / unknowns.count(1).max(1))
    }

    /// Whether an odd number of unknowns of any block reverse the sign of its determinant.
    pub(super) fn is_any_reversed(&self, unknowns: Unknowns, reverses: impl Fn(usize) -> bool) -> bool {
        let (mut reversed, per_degree) = (vec![false; self.count], unknowns.count(1));
        for unknown in 0..self.of.len() * per_degree {
            reversed[self.of[unknown / per_degree]] ^= reverses(unknown);
        }
        reversed.contains(&true)
    }
}
