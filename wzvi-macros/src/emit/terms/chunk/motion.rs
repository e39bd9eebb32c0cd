//! How an index moves with the innermost loop.

use crate::model::{Atom, Index, Operation, Slot};

/// How an index moves with the innermost loop.
pub(super) enum Motion {
    Fixed,
    /// By one, perhaps wrapping around.
    Run,
    /// By a point: component `part` of points from the index `base` on.
    Points {
        base: Index,
        part: usize,
    },
    Free,
}

/// Stride and first index of the places that successive placements of the loop read or write: the stride is one place or one point.
/// Components of one point have the same first index.
pub(in crate::emit::terms) fn stretch(index: &Index, inner: u32, components: i128) -> Option<(i128, Index)> {
    match motion(index, inner, components) {
        Motion::Run => Some((1, index.clone())),
        Motion::Points { base, .. } => Some((components, base)),
        Motion::Fixed | Motion::Free => None,
    }
}

/// How the value of a local variable moves with the loop.
pub(super) fn moves(slot: &Slot, inner: u32, components: i128) -> Motion {
    let is_fixed = !slot.indices().iter().any(|index| index.loops().contains(&inner));
    match slot {
        Slot::State(_, index) => motion(index, inner, components),
        _ if is_fixed => Motion::Fixed,
        Slot::Entry(_, indices) if matches!(indices.as_slice(), [index] if runs(index, inner)) => Motion::Run,
        Slot::Entry(..) | Slot::Number(_) => Motion::Free,
    }
}

pub(super) fn motion(index: &Index, inner: u32, components: i128) -> Motion {
    if !index.loops().contains(&inner) {
        return Motion::Fixed;
    }
    if runs(index, inner) {
        return Motion::Run;
    }
    // Complete points from the first to the last are in the vector if the index is.
    let moves_on = index.slope(inner) == Some(components) || wrap(index, inner, components).is_some();
    let is_point = components > 1
        && moves_on
        && index.terms.iter().all(|(_, coefficient)| coefficient % components == 0);
    let part = if is_point { index.constant.rem_euclid(components) } else { 0 };
    match (is_point, index.shifted(-part), usize::try_from(part)) {
        (true, Some(base), Ok(part)) => Motion::Points { base, part },
        _ => Motion::Free,
    }
}

/// Whether the index goes up by one with the loop, perhaps wrapping around.
pub(super) fn runs(index: &Index, inner: u32) -> bool {
    index.slope(inner) == Some(1) || wrap(index, inner, 1).is_some()
}

/// `k + r` and `n` of an index `... + stride ((k + r) % n)` with everything else fixed in the loop over `k`.
pub(super) fn wrap(index: &Index, inner: u32, stride: i128) -> Option<&(Index, Index)> {
    let mut moving =
        index.terms.iter().filter(|(atom, _)| Index::atom(atom.clone()).loops().contains(&inner));
    match (moving.next(), moving.next()) {
        (Some((Atom::Of(Operation::Remainder, both), coefficient)), None) if *coefficient == stride => {
            let is_run = both.0.slope(inner) == Some(1) && !both.1.loops().contains(&inner);
            is_run.then_some(&**both)
        }
        _ => None,
    }
}

/// The index without wrapping around, and the length after which it wraps.
pub(super) fn unwrapped(index: &Index, inner: u32) -> Option<(Index, Index)> {
    match wrap(index, inner, 1) {
        None => Some((index.clone(), Index::default())),
        Some(both) => {
            let rest = index.subtract(&Index::of(Operation::Remainder, both.0.clone(), both.1.clone()))?;
            Some((rest.add(&both.0)?, both.1.clone()))
        }
    }
}

/// Whether `ahead` is `own + 1` up to wrapping around, which the loop itself checks.
pub(super) fn follows(ahead: &Index, own: &Index, inner: u32) -> bool {
    let distance = || -> Option<[Index; 3]> {
        let ((ahead, size), (own, other)) = (unwrapped(ahead, inner)?, unwrapped(own, inner)?);
        let plain = ahead.subtract(&own)?;
        Some([plain.add(&other)?, plain.subtract(&size)?, plain])
    };
    let one = Index::integer(1);
    runs(ahead, inner) && runs(own, inner) && distance().is_some_and(|distances| distances.contains(&one))
}
