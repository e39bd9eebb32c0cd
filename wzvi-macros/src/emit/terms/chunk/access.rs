//! The access of an index in the innermost loop: which places successive placements read or write. Tests:
//! `tests/loops/one_by_one.rs`.

use crate::model::{Atom, Index, IndexOperation, Slot};

/// The access of an index in the innermost loop: which places successive placements read or write.
pub(super) enum Access {
    Invariant,
    /// The next place, perhaps wrapping around.
    Unit,
    /// The next point: component `part` of points from the index `base` on.
    Strided {
        base: Index,
        part: usize,
    },
    Gather,
}

/// The innermost loop as indices see it.
#[derive(Clone, Copy)]
pub(in crate::emit::terms) struct InnerLoop {
    pub(in crate::emit::terms) variable: u32,
    /// Components of a point.
    pub(in crate::emit::terms) components: i128,
}

impl InnerLoop {
    /// Stride and first index of the places that successive placements of the loop read or write: the stride
    /// is one place or one point. Components of one point have the same first index.
    pub(in crate::emit::terms) fn range(self, index: &Index) -> Option<(i128, Index)> {
        match self.access(index) {
            Access::Unit => Some((1, index.clone())),
            Access::Strided { base, .. } => Some((self.components, base)),
            Access::Invariant | Access::Gather => None,
        }
    }

    /// The access of the value of a local variable.
    pub(super) fn slot_access(self, slot: &Slot) -> Access {
        let is_fixed = !slot.indices().iter().any(|index| index.loops().contains(&self.variable));
        match slot {
            Slot::State(_, index) => self.access(index),
            _ if is_fixed => Access::Invariant,
            Slot::Entry(_, indices) if matches!(indices.as_slice(), [index] if self.is_unit(index)) => {
                Access::Unit
            }
            Slot::Entry(..) | Slot::Number(_) | Slot::Collective(_) => Access::Gather,
        }
    }

    pub(super) fn access(self, index: &Index) -> Access {
        let Self { variable, components } = self;
        if !index.loops().contains(&variable) {
            return Access::Invariant;
        }
        if self.is_unit(index) {
            return Access::Unit;
        }
        // Complete points from the first to the last are in the vector if the index is.
        let moves_on = index.slope(variable) == Some(components) || self.wrap(index, components).is_some();
        let is_point = components > 1
            && moves_on
            && index.terms.iter().all(|(_, coefficient)| coefficient % components == 0);
        let part = if is_point { index.constant.rem_euclid(components) } else { 0 };
        match (is_point, index.shifted(-part), usize::try_from(part)) {
            (true, Some(base), Ok(part)) => Access::Strided { base, part },
            _ => Access::Gather,
        }
    }

    /// Whether the index goes up by one with the loop, perhaps wrapping around.
    pub(super) fn is_unit(self, index: &Index) -> bool {
        index.slope(self.variable) == Some(1) || self.wrap(index, 1).is_some()
    }

    /// `k + r` and `n` of an index that wraps around by a place or by a point.
    pub(super) fn wraps(self, index: &Index) -> Option<&(Index, Index)> {
        self.wrap(index, 1).or_else(|| self.wrap(index, self.components))
    }

    /// `k + r` and `n` of an index `... + stride ((k + r) % n)` with everything else fixed in the loop over
    /// `k`.
    pub(super) fn wrap(self, index: &Index, stride: i128) -> Option<&(Index, Index)> {
        let inner = self.variable;
        let mut moving = index.terms.iter().filter(|(atom, _)| atom.reads(inner));
        match (moving.next(), moving.next()) {
            (Some((Atom::Of(IndexOperation::Remainder, both), coefficient)), None)
                if *coefficient == stride =>
            {
                let is_run = both.0.slope(inner) == Some(1) && !both.1.loops().contains(&inner);
                is_run.then_some(&**both)
            }
            _ => None,
        }
    }

    /// The index without wrapping around, and the length after which it wraps.
    pub(super) fn unwrapped(self, index: &Index) -> Option<(Index, Index)> {
        match self.wrap(index, 1) {
            None => Some((index.clone(), Index::default())),
            Some(both) => {
                let rest =
                    index.subtract(&Index::of(IndexOperation::Remainder, both.0.clone(), both.1.clone()))?;
                Some((rest.add(&both.0)?, both.1.clone()))
            }
        }
    }

    /// Whether `ahead` is `own + 1` up to wrapping around, which the loop itself checks.
    pub(super) fn follows(self, ahead: &Index, own: &Index) -> bool {
        let distance = || -> Option<[Index; 3]> {
            let ((ahead, size), (own, other)) = (self.unwrapped(ahead)?, self.unwrapped(own)?);
            let plain = ahead.subtract(&own)?;
            Some([plain.add(&other)?, plain.subtract(&size)?, plain])
        };
        let one = Index::integer(1);
        self.is_unit(ahead)
            && self.is_unit(own)
            && distance().is_some_and(|distances| distances.contains(&one))
    }
}
