//! The unknowns of a step, and lists with an entry for each. Equations are matched to unknowns by these,
//! never by their position in a list.

use std::ops::{Index, IndexMut};

/// An unknown of a step. Their order is that of their kinds, then of their numbers.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) enum Unknown {
    /// `u_i`, of `u = q_{i+1} - q_i`.
    Q(usize),
    /// `v_i`, of `v = P - p_i`.
    P(usize),
}

impl Unknown {
    /// The unknown of the same degree of freedom in the other half of the phase space: slopes by a coordinate
    /// are in the equation of the momentum, and the other way round.
    pub(crate) fn conjugate(self) -> Self {
        match self {
            Self::Q(i) => Self::P(i),
            Self::P(i) => Self::Q(i),
        }
    }

    /// Its degree of freedom.
    pub(crate) fn degree(self) -> usize {
        match self {
            Self::Q(i) | Self::P(i) => i,
        }
    }
}

/// One entry for each unknown.
#[derive(Clone, Debug)]
pub(crate) struct ByUnknown<T> {
    pub(crate) q: Vec<T>,
    pub(crate) p: Vec<T>,
}

impl<T> ByUnknown<T> {
    /// The entries of all unknowns of so many degrees of freedom.
    pub(crate) fn of(degrees: usize, entry: impl FnMut(Unknown) -> T) -> Self {
        let mut entries = unknowns(degrees).map(entry);
        let q = entries.by_ref().take(degrees).collect();
        Self { q, p: entries.collect() }
    }

    /// All unknowns, in their order.
    pub(crate) fn unknowns(&self) -> impl DoubleEndedIterator<Item = Unknown> + use<T> {
        unknowns(self.q.len())
    }

    /// The entries in the order of their unknowns.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &T> {
        self.q.iter().chain(&self.p)
    }
}

fn unknowns(degrees: usize) -> impl DoubleEndedIterator<Item = Unknown> {
    (0..degrees).map(Unknown::Q).chain((0..degrees).map(Unknown::P))
}

impl<T> Index<Unknown> for ByUnknown<T> {
    type Output = T;

    fn index(&self, unknown: Unknown) -> &T {
        match unknown {
            Unknown::Q(i) => &self.q[i],
            Unknown::P(i) => &self.p[i],
        }
    }
}

impl<T> IndexMut<Unknown> for ByUnknown<T> {
    fn index_mut(&mut self, unknown: Unknown) -> &mut T {
        match unknown {
            Unknown::Q(i) => &mut self.q[i],
            Unknown::P(i) => &mut self.p[i],
        }
    }
}
