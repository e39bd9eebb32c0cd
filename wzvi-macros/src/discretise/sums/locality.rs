//! Sums for which a few sizes decide all sizes.
//!
//! Let every placement of a sum read points `v + c` near the variable `v` of one loop, points `c` near the
//! first or `n + c` near the last, all `|c| <= w`, counted around the ring where an index wraps; and let the
//! loops go from `c` or `n + c` to `n + c`. Write the sum `R_n` as the sum of its parts `R_(n,S)` that depend
//! on exactly the variables at the points `S` and vanish where one of them is zero (the analysis of variance
//! with base point 0). `R_n` vanishes if and only if all parts do.
//!
//! 1. A part with points beyond `w` of both ends comes from placements within `2 w` of these. If
//!    `n > 10 w + 3`, there is a point that neither these nor the placements at the ends read. Without it the
//!    points are those of `n - 1`, and the same placements give the same part. So these parts vanish for
//!    every such `n` if they do for one.
//! 2. A part with points at the ends only, or with none, is `a n + b` for `n >= 10 w + 4`: one placement more
//!    for each point more. So it vanishes for every such `n` if it does for two.
//!
//! With `n = 1 .. 10 w + 5` all sizes are decided.
//!
//! Tests: `discretise/sums/tests.rs`.

use std::collections::HashMap;

use super::{Space, Sum, Weighted};
use crate::model::{Atom, Index, IndexOperation, Loop, Slot};

/// Loops up to this length, if it is a literal, count as so many placements.
const LONGEST_LITERAL_LOOP: i128 = 8;

impl Space {
    /// The first of two sizes that decide all larger ones; `None` if the sum is not of that kind.
    pub(super) fn deciding_size(&self, sum: &Sum) -> Option<i128> {
        let mut width = 1;
        for Weighted { element, increments } in sum {
            let form = Locality { space: self, loops: &element.loops };
            let is_long = |known: &&Loop| form.length(known).is_none() && !is_condition(known);
            if element.loops.iter().filter(is_long).count() > 1 {
                return None;
            }
            for known in element.loops.iter().filter(|known| form.length(known).is_none()) {
                width = width.max(form.anchor(&known.start)?).max(form.anchor(&known.end)?);
            }
            for local in &element.locals {
                let stride = if let Slot::State(..) = local.slot { self.components } else { 1 };
                for index in local.slot.indices() {
                    width = width.max(form.distance(index, stride)?);
                }
            }
            for index in increments {
                form.distance(index, 1)?;
            }
        }
        width.checked_mul(10)?.checked_add(4)
    }

    /// The sum of a system of literal size `n` as a member of a family for all sizes: integers nearer to `n`
    /// than to 0 are counted from `n`.
    pub(super) fn generalised(&self, sum: &Sum, n: i128) -> Option<(Self, Sum)> {
        let lift_one = |weighted: &Weighted| {
            weighted.mapped(&|index| lifted(index, n, 1), &|index| lifted(index, n, self.components))
        };
        let sum = sum.iter().map(lift_one).collect::<Option<Sum>>()?;
        let size = Index::atom(Atom::Size);
        let space = Self { size, symbols: HashMap::new(), slots: HashMap::new(), ..self.clone() };
        Some((space, sum))
    }
}

/// The index with `stride (n + c)` for integers nearer to `stride n` than to 0.
fn lifted(index: &Index, n: i128, stride: i128) -> Option<Index> {
    let mut sum = Index::default();
    for (atom, coefficient) in &index.terms {
        let atom = match atom {
            Atom::Of(
                operation @ (IndexOperation::Remainder | IndexOperation::Minimum | IndexOperation::Maximum),
                both,
            ) => Index::of(*operation, lifted(&both.0, n, 1)?, lifted(&both.1, n, 1)?),
            other => Index::atom(other.clone()),
        };
        sum = sum.plus(&atom, *coefficient)?;
    }
    let whole = n.checked_mul(stride)?;
    let times =
        index.constant.checked_mul(2)?.checked_add(whole)?.checked_div_euclid(whole.checked_mul(2)?)?;
    let size = Index::atom(Atom::Size).multiply(&Index::integer(stride))?;
    let rest = index.constant.checked_sub(times.checked_mul(whole)?)?;
    sum.plus(&size, times)?.shifted(rest)
}

/// Whether a loop runs at most once, as a condition.
pub(super) fn is_condition(known: &Loop) -> bool {
    let is_bounded_by_one = |end: &Index| match end.terms.as_slice() {
        [(Atom::Of(IndexOperation::Minimum, both), 1)] if end.constant == 0 => has_one(&both.0, &both.1),
        _ => false,
    };
    known.start == Index::default() && is_bounded_by_one(&known.end)
}

/// Whether one of two indices is 1, or a minimum with 1.
fn has_one(a: &Index, b: &Index) -> bool {
    [a, b].into_iter().any(|part| match part.terms.as_slice() {
        [] => part.constant == 1,
        [(Atom::Of(IndexOperation::Minimum, inner), 1)] if part.constant == 0 => has_one(&inner.0, &inner.1),
        _ => false,
    })
}

struct Locality<'s> {
    space: &'s Space,
    loops: &'s [Loop],
}

impl Locality<'_> {
    /// The length of a loop that is a literal and short.
    fn length(&self, known: &Loop) -> Option<i128> {
        let (start, end) = (known.start.as_integer()?, known.end.as_integer()?);
        let is_short = start >= 0 && end <= LONGEST_LITERAL_LOOP;
        is_short.then_some(end)
    }

    /// `c` of the index `c` or `n + c`, as a number of points.
    fn anchor(&self, index: &Index) -> Option<i128> {
        let own = self.space.size.terms.first().map(|(atom, _)| atom);
        match index.terms.as_slice() {
            [] => Some(index.constant.abs()),
            [(atom, 1 | -1)] if Some(atom) == own => Some(index.constant.abs()),
            // The remainder of an integer modulo a larger size.
            [(Atom::Of(IndexOperation::Remainder, both), 1 | -1)] if both.1 == self.space.size => {
                both.0.as_integer()?.checked_abs()?.checked_add(index.constant.abs())
            }
            [(Atom::Of(IndexOperation::Minimum | IndexOperation::Maximum, both), 1)] => {
                let inside = self.anchor(&both.0)?.max(self.anchor(&both.1)?);
                inside.checked_add(index.constant.abs())
            }
            _ => None,
        }
    }

    /// How far a slot is from the variable of the loop or from an end.
    fn distance(&self, index: &Index, stride: i128) -> Option<i128> {
        let own = self.space.size.terms.first().map(|(atom, _)| atom);
        let mut inside = index.constant.abs();
        let mut anchors = 0;
        for (atom, coefficient) in &index.terms {
            let short = match atom {
                Atom::Loop(variable) => {
                    let known = self.loops.iter().find(|known| known.variable == *variable)?;
                    self.length(known)
                }
                _ => None,
            };
            match (atom, short) {
                (_, Some(length)) => inside = inside.checked_add(length.checked_mul(coefficient.abs())?)?,
                (Atom::Loop(_), None) if *coefficient == stride => anchors += 1,
                (Atom::Of(IndexOperation::Remainder, both), None)
                    if *coefficient == stride && both.1 == self.space.size =>
                {
                    // Multiples of the size do not count.
                    let mut wrapped = both.0.clone();
                    wrapped.terms.retain(|(atom, _)| Some(atom) != own);
                    inside = inside.checked_add(self.distance(&wrapped, 1)?.checked_mul(stride)?)?;
                    anchors += 1;
                }
                (atom, None) if Some(atom) == own && *coefficient == stride => anchors += 1,
                _ => return None,
            }
        }
        (anchors <= 1).then(|| inside.div_euclid(stride) + 1)
    }
}
