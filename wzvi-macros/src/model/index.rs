//! Integer expressions of loop variables and sizes, in a normal form: a constant plus integer multiples of
//! atoms. Two indices are equal wherever their forms are; `i + 1` and `1 + i` are one form.
//!
//! Differences of indices decide how systems are solved: the difference of two indices of one element is a
//! constant (a band), wraps around (a ring), or is known to the running program only (a table).

use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};

use super::Table;

/// A part of an index that is not a known integer.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(crate) enum Atom {
    /// The variable of a loop.
    Loop(u32),
    /// The outermost size of the phase space, where only the state knows it.
    Size,
    /// An integer that the struct or a constant holds: the entry of a list, if there are indices.
    Given(u32, Vec<Index>),
    Of(IndexOperation, Box<(Index, Index)>),
}

/// A binary operation on integers, with Rust's rounding.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(crate) enum IndexOperation {
    Product,
    /// Rounded towards zero.
    Quotient,
    Remainder,
    Minimum,
    Maximum,
}

impl IndexOperation {
    /// `None` on overflow, and for a division by zero.
    fn of(self, a: i128, b: i128) -> Option<i128> {
        match self {
            Self::Product => a.checked_mul(b),
            Self::Quotient => a.checked_div(b),
            Self::Remainder => a.checked_rem(b),
            Self::Minimum => Some(a.min(b)),
            Self::Maximum => Some(a.max(b)),
        }
    }
}

impl Atom {
    /// Whether a loop variable is inside of it.
    pub(crate) fn reads(&self, variable: u32) -> bool {
        *self == Self::Loop(variable) || self.indices().any(|index| index.loops().contains(&variable))
    }

    /// The indices inside.
    fn indices(&self) -> impl Iterator<Item = &Index> {
        let (entry, both) = match self {
            Self::Loop(_) | Self::Size => (&[][..], None),
            Self::Given(_, indices) => (indices.as_slice(), None),
            Self::Of(_, both) => (&[][..], Some([&both.0, &both.1])),
        };
        entry.iter().chain(both.into_iter().flatten())
    }
}

/// `constant + Σ coefficient · atom`, atoms in order, no coefficient zero.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default)]
pub(crate) struct Index {
    pub(crate) terms: Vec<(Atom, i128)>,
    pub(crate) constant: i128,
}

/// A loop over `start..end`.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(crate) struct Loop {
    pub(crate) variable: u32,
    pub(crate) start: Index,
    pub(crate) end: Index,
}

/// Nested substitutions that a proof may take, and substitutions in all: each may be tried for each atom.
const PROOF_DEPTH: u32 = 12;
const PROOF_STEPS: u32 = 4096;

impl Index {
    pub(crate) fn integer(constant: i128) -> Self {
        Self { terms: Vec::new(), constant }
    }

    pub(crate) fn atom(atom: Atom) -> Self {
        Self { terms: vec![(atom, 1)], constant: 0 }
    }

    pub(crate) fn as_integer(&self) -> Option<i128> {
        self.terms.is_empty().then_some(self.constant)
    }

    /// `self + factor · other`; `None` on overflow, like all arithmetic here.
    pub(crate) fn plus(&self, other: &Self, factor: i128) -> Option<Self> {
        let mut terms = self.terms.clone();
        for (atom, coefficient) in &other.terms {
            let added = coefficient.checked_mul(factor)?;
            match terms.binary_search_by(|(known, _)| known.cmp(atom)) {
                Ok(at) => terms[at].1 = terms[at].1.checked_add(added)?,
                Err(at) => terms.insert(at, (atom.clone(), added)),
            }
        }
        terms.retain(|(_, coefficient)| *coefficient != 0);
        let constant = self.constant.checked_add(other.constant.checked_mul(factor)?)?;
        Some(Self { terms, constant })
    }

    pub(crate) fn add(&self, other: &Self) -> Option<Self> {
        self.plus(other, 1)
    }

    pub(crate) fn subtract(&self, other: &Self) -> Option<Self> {
        self.plus(other, -1)
    }

    pub(crate) fn shifted(&self, by: i128) -> Option<Self> {
        Some(Self { terms: self.terms.clone(), constant: self.constant.checked_add(by)? })
    }

    /// An atom, whatever is known of both.
    pub(crate) fn of(operation: IndexOperation, a: Self, b: Self) -> Self {
        Self::atom(Atom::Of(operation, Box::new((a, b))))
    }

    /// The result of an operation in normal form; `None` on overflow, and for a division by zero.
    pub(crate) fn operate(&self, operation: IndexOperation, other: &Self) -> Option<Self> {
        let difference = || self.subtract(other).and_then(|difference| difference.as_integer());
        let first = match (operation, self.as_integer(), other.as_integer()) {
            (_, Some(a), Some(b)) => return operation.of(a, b).map(Self::integer),
            (IndexOperation::Product, _, Some(factor)) => return Self::default().plus(self, factor),
            (IndexOperation::Product, Some(factor), _) => return Self::default().plus(other, factor),
            (IndexOperation::Quotient | IndexOperation::Remainder, _, Some(0)) => return None,
            (IndexOperation::Quotient, _, Some(1)) => return Some(self.clone()),
            (IndexOperation::Minimum, ..) => difference().map(|difference| difference <= 0),
            (IndexOperation::Maximum, ..) => difference().map(|difference| difference >= 0),
            _ => None,
        };
        Some(match (operation, first) {
            (_, Some(true)) => self.clone(),
            (_, Some(false)) => other.clone(),
            (IndexOperation::Quotient | IndexOperation::Remainder, None) => {
                Self::of(operation, self.clone(), other.clone())
            }
            _ => Self::of(operation, self.clone().min(other.clone()), self.clone().max(other.clone())),
        })
    }

    pub(crate) fn multiply(&self, other: &Self) -> Option<Self> {
        self.operate(IndexOperation::Product, other)
    }

    /// `self / other` as Rust computes it; `None` for a division by zero.
    pub(crate) fn divide(&self, other: &Self) -> Option<Self> {
        self.operate(IndexOperation::Quotient, other)
    }

    /// `self % other` as Rust computes it; `None` for a division by zero.
    pub(crate) fn remainder(&self, other: &Self) -> Option<Self> {
        self.operate(IndexOperation::Remainder, other)
    }

    pub(crate) fn minimum(&self, other: &Self) -> Self {
        self.operate(IndexOperation::Minimum, other).unwrap_or_default()
    }

    pub(crate) fn maximum(&self, other: &Self) -> Self {
        self.operate(IndexOperation::Maximum, other).unwrap_or_default()
    }

    /// Calls `f` with every atom, those inside of others included.
    pub(crate) fn visit(&self, f: &mut dyn FnMut(&Atom)) {
        for (atom, _) in &self.terms {
            f(atom);
            atom.indices().for_each(|index| index.visit(f));
        }
    }

    /// The number of atoms, those inside of others included.
    pub(crate) fn atoms(&self) -> usize {
        let mut count = 0;
        self.visit(&mut |_| count += 1);
        count
    }

    /// Levels of atoms inside of others.
    pub(crate) fn depth(&self) -> u32 {
        let inner = self.terms.iter().flat_map(|(atom, _)| atom.indices());
        inner.map(|index| index.depth() + 1).max().unwrap_or(0)
    }

    fn any(&self, f: impl Fn(&Atom) -> bool) -> bool {
        let mut found = false;
        self.visit(&mut |atom| found |= f(atom));
        found
    }

    /// Whether it reads the size of the state.
    pub(crate) fn reads_size(&self) -> bool {
        self.any(|atom| *atom == Atom::Size)
    }

    /// Whether it is made of loop variables and integers alone.
    pub(crate) fn is_closed(&self) -> bool {
        !self.any(|atom| matches!(atom, Atom::Size | Atom::Given(..)))
    }

    /// Whether it is a sum of multiples of loop variables and sizes.
    pub(crate) fn is_affine(&self) -> bool {
        self.terms.iter().all(|(atom, _)| matches!(atom, Atom::Loop(_) | Atom::Size))
    }

    /// The value of the index, given the values of the atoms that are not operations.
    pub(crate) fn value(&self, of: &dyn Fn(&Atom) -> Option<i128>) -> Option<i128> {
        self.terms.iter().try_fold(self.constant, |sum, (atom, coefficient)| {
            let value = match atom {
                Atom::Of(operation, both) => operation.of(both.0.value(of)?, both.1.value(of)?),
                atom => of(atom),
            };
            sum.checked_add(value?.checked_mul(*coefficient)?)
        })
    }

    /// The loop variables that it reads.
    pub(crate) fn loops(&self) -> BTreeSet<u32> {
        let mut found = BTreeSet::new();
        self.visit(&mut |atom| {
            if let Atom::Loop(variable) = atom {
                found.insert(*variable);
            }
        });
        found
    }

    /// `self = divisor · a + b` with `0 <= b < divisor`, if every multiple in it is one of `divisor`.
    pub(crate) fn divided(&self, divisor: i128) -> Option<(Self, i128)> {
        let divides = |coefficient: &i128| coefficient.checked_rem(divisor) == Some(0);
        if !self.terms.iter().all(|(_, coefficient)| divides(coefficient)) {
            return None;
        }
        let terms = self.terms.iter().map(|(atom, c)| (atom.clone(), c / divisor)).collect();
        let constant = self.constant.checked_div_euclid(divisor)?;
        Some((Self { terms, constant }, self.constant.checked_rem_euclid(divisor)?))
    }

    /// The index with `by` for a loop variable; `None` on overflow.
    pub(crate) fn with(&self, variable: u32, by: &Self) -> Option<Self> {
        let mut sum = Self::integer(self.constant);
        for (atom, coefficient) in &self.terms {
            let part = match atom {
                Atom::Loop(own) if *own == variable => by.clone(),
                Atom::Loop(_) | Atom::Size => Self::atom(atom.clone()),
                Atom::Given(id, indices) => {
                    let indices = indices.iter().map(|index| index.with(variable, by));
                    Self::atom(Atom::Given(*id, indices.collect::<Option<_>>()?))
                }
                Atom::Of(operation, both) => {
                    both.0.with(variable, by)?.operate(*operation, &both.1.with(variable, by)?)?
                }
            };
            sum = sum.plus(&part, *coefficient)?;
        }
        Some(sum)
    }

    /// The index where loop variables have these values.
    pub(crate) fn at(&self, values: &BTreeMap<u32, i128>) -> Option<Self> {
        let mut values = values.iter();
        values
            .try_fold(self.clone(), |index, (&variable, &value)| index.with(variable, &Self::integer(value)))
    }

    /// The index where every size that is no literal exceeds the literals beside it: `-1 % n` is -1.
    fn for_large_sizes(&self) -> Option<Self> {
        let mut sum = Self::integer(self.constant);
        for (atom, coefficient) in &self.terms {
            let part = match atom {
                Atom::Of(operation, both) => {
                    let (a, b) = (both.0.for_large_sizes()?, both.1.for_large_sizes()?);
                    let below = b.subtract(&a).and_then(|rest| rest.as_integer());
                    match (operation, a.as_integer(), b.as_integer()) {
                        (IndexOperation::Remainder, Some(_), None) => a,
                        (IndexOperation::Quotient, Some(_), None) => Self::default(),
                        (IndexOperation::Remainder, None, None) if below.is_some_and(|below| below > 0) => a,
                        _ => a.operate(*operation, &b)?,
                    }
                }
                atom => Self::atom(atom.clone()),
            };
            sum = sum.plus(&part, *coefficient)?;
        }
        Some(sum)
    }

    /// The coefficient of a loop variable, if it occurs linearly and nowhere else; 0 if it does not occur.
    pub(crate) fn slope(&self, variable: u32) -> Option<i128> {
        let mut slope = 0;
        for (atom, coefficient) in &self.terms {
            match atom {
                Atom::Loop(own) if *own == variable => slope = *coefficient,
                atom if atom.reads(variable) => return None,
                _ => {}
            }
        }
        Some(slope)
    }

    /// The index with a loop variable, where it occurs linearly, replaced.
    fn replaced(&self, atom: &Atom, by: &Self) -> Option<Self> {
        let coefficient = self.terms.iter().find(|(known, _)| known == atom).map_or(0, |(_, c)| *c);
        self.plus(&Self::atom(atom.clone()), coefficient.checked_neg()?)?.plus(by, coefficient)
    }
}

/// The bounds of loop variables and integers that are known where an index is decided about.
pub(crate) struct Bounds<'a> {
    pub(crate) loops: &'a [Loop],
    pub(crate) tables: &'a [Table],
}

impl Bounds<'_> {
    /// Whether `0 <= index < length` wherever the loops go.
    pub(crate) fn is_below(&self, index: &Index, length: &Index) -> bool {
        let rest = length.subtract(index).and_then(|rest| rest.shifted(-1));
        self.is_nonnegative(index) && rest.is_some_and(|rest| self.is_nonnegative(&rest))
    }

    /// Whether `index >= 0` wherever the loops go; `false` if that cannot be shown.
    pub(crate) fn is_nonnegative(&self, index: &Index) -> bool {
        self.proves(index, PROOF_DEPTH, &Cell::new(PROOF_STEPS))
    }

    /// Bounds an atom that hides what is inside of it, innermost loops first.
    fn proves(&self, index: &Index, depth: u32, left: &Cell<u32>) -> bool {
        if index.terms.is_empty() {
            return index.constant >= 0;
        }
        if depth == 0 || left.replace(left.get().saturating_sub(1)) == 0 {
            return false;
        }
        let replaced = |atom: &Atom, by: &Index| index.replaced(atom, by);
        let proves = |image: Option<Index>| image.is_some_and(|image| self.proves(&image, depth - 1, left));
        // Loops are bounded by those around them: the innermost goes first.
        for known in self.loops.iter().rev() {
            let atom = Atom::Loop(known.variable);
            let Some((_, coefficient)) = index.terms.iter().find(|(own, _)| *own == atom) else { continue };
            if index.terms.iter().any(|(own, _)| *own != atom && own.reads(known.variable)) {
                continue;
            }
            let extreme = if *coefficient > 0 { Some(known.start.clone()) } else { known.end.shifted(-1) };
            return extreme.is_some_and(|extreme| proves(replaced(&atom, &extreme)));
        }
        index.terms.iter().any(|(atom, coefficient)| {
            let positive = *coefficient > 0;
            match atom {
                Atom::Loop(_) | Atom::Of(IndexOperation::Product, _) => false,
                Atom::Size | Atom::Given(..) if positive => {
                    self.lower_bounds(atom).iter().any(|bound| proves(replaced(atom, bound)))
                }
                Atom::Size | Atom::Given(..) => false,
                Atom::Of(IndexOperation::Quotient, both) => match both.1.as_integer() {
                    // For a nonnegative numerator `0 <= a / b <= a`.
                    Some(divisor) if divisor > 0 && self.proves(&both.0, depth - 1, left) => {
                        let bound = if positive { Index::default() } else { both.0.clone() };
                        proves(replaced(atom, &bound))
                    }
                    _ => false,
                },
                Atom::Of(IndexOperation::Remainder, both) => {
                    let bound = if positive { Some(Index::default()) } else { both.1.shifted(-1) };
                    // The remainder by a negative divisor is not below it.
                    [&both.0, &both.1].into_iter().all(|part| self.proves(part, depth - 1, left))
                        && bound.is_some_and(|bound| proves(replaced(atom, &bound)))
                }
                Atom::Of(extreme, both) => {
                    let mut images = [&both.0, &both.1].into_iter().map(|part| replaced(atom, part));
                    match positive == (*extreme == IndexOperation::Minimum) {
                        true => images.all(proves),
                        false => images.any(proves),
                    }
                }
            }
        })
    }

    /// Lower bounds of a size: a loop that runs has an end beyond its start.
    fn lower_bounds(&self, atom: &Atom) -> Vec<Index> {
        let bounds = self.loops.iter().filter_map(|known| {
            let rest = known.end.plus(&Index::atom(atom.clone()), -1)?;
            let is_alone = !rest.terms.iter().any(|(other, _)| other == atom);
            is_alone.then(|| known.start.shifted(1)?.subtract(&rest)).flatten()
        });
        let is_natural = match atom {
            Atom::Given(table, _) => self.tables.get(*table as usize).is_some_and(|table| table.is_unsigned),
            _ => true,
        };
        bounds.chain(is_natural.then(Index::default)).collect()
    }

    /// The place where `index` leaves `0..length`, at the first or last turns of the loops; `None` if no such
    /// place is certain to be reached. A size that is no literal is taken to exceed the literals beside it.
    pub(crate) fn outlier(&self, index: &Index, length: Option<&Index>) -> Option<Outlier> {
        self.outlier_at(0, index, length, &mut Vec::new(), &Cell::new(PROOF_STEPS))
    }

    /// [`Bounds::outlier`] with the first loops at `turns`.
    fn outlier_at(
        &self,
        depth: usize,
        index: &Index,
        length: Option<&Index>,
        turns: &mut Vec<(u32, Index)>,
        left: &Cell<u32>,
    ) -> Option<Outlier> {
        let at = |index: &Index, turns: &[(u32, Index)]| {
            let mut turns = turns.iter();
            let value = turns.try_fold(index.clone(), |index, (variable, turn)| index.with(*variable, turn));
            value?.for_large_sizes()
        };
        let Some(known) = self.loops.get(depth) else {
            let value = at(index, turns)?;
            if let Some(negative) = value.as_integer().filter(|value| *value < 0) {
                return Some(Outlier::Negative(negative));
            }
            let excess = value.subtract(&at(length?, turns)?)?.as_integer()?;
            return (excess >= 0).then_some(Outlier::Beyond(excess));
        };
        if left.replace(left.get().saturating_sub(1)) == 0 {
            return None;
        }
        let (start, end) = (at(&known.start, turns)?, at(&known.end, turns)?);
        if end.subtract(&start)?.as_integer().is_some_and(|turns| turns <= 0) {
            return None;
        }
        // Only bounds and indices that read the variable need its last turn.
        let mut readers = self.loops[depth..].iter().flat_map(|inner| [&inner.start, &inner.end]);
        let reads = |index: &Index| index.loops().contains(&known.variable);
        let last = (reads(index) || readers.any(reads)).then(|| end.shifted(-1)).flatten();
        [Some(start), last].into_iter().flatten().find_map(|turn| {
            turns.push((known.variable, turn));
            let found = self.outlier_at(depth + 1, index, length, turns, left);
            turns.pop();
            found
        })
    }
}

/// An index that leaves its list.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Outlier {
    /// The index has this negative value.
    Negative(i128),
    /// The index exceeds the length by this much.
    Beyond(i128),
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    fn i() -> Index {
        Index::atom(Atom::Loop(0))
    }

    fn n() -> Index {
        Index::atom(Atom::Given(0, Vec::new()))
    }

    fn natural() -> [Table; 1] {
        [Table { is_unsigned: true, ..Table::default() }]
    }

    #[test]
    fn forms_are_normal() {
        let (left, right) = (i().shifted(1).unwrap(), Index::integer(1).add(&i()).unwrap());
        assert_eq!(left, right);
        assert_eq!(left.subtract(&right).unwrap().as_integer(), Some(0));
        assert_eq!(i().multiply(&n()), n().multiply(&i()));
        let wrapped = left.remainder(&n()).unwrap();
        assert_eq!(wrapped.slope(0), None);
        assert_eq!(i().multiply(&Index::integer(3)).unwrap().slope(0), Some(3));
    }

    #[test]
    fn ranges_are_proven() {
        let loops = [
            Loop { variable: 0, start: Index::integer(1), end: n() },
            Loop { variable: 1, start: Index::default(), end: i() },
        ];
        let tables = natural();
        let bounds = Bounds { loops: &loops, tables: &tables };
        let j = Index::atom(Atom::Loop(1));
        // i - 1 >= 0, n - 1 - i >= 0, i - 1 - j >= 0; i - 2 and n - 2 - i may be negative.
        assert!(bounds.is_nonnegative(&i().shifted(-1).unwrap()));
        assert!(bounds.is_nonnegative(&n().subtract(&i()).unwrap().shifted(-1).unwrap()));
        assert!(bounds.is_nonnegative(&i().subtract(&j).unwrap().shifted(-1).unwrap()));
        assert!(!bounds.is_nonnegative(&i().shifted(-2).unwrap()));
        assert!(!bounds.is_nonnegative(&n().subtract(&i()).unwrap().shifted(-2).unwrap()));
        // (i + 1) % n is below n and not below 0.
        let wrapped = i().shifted(1).unwrap().remainder(&n()).unwrap();
        assert!(bounds.is_nonnegative(&wrapped));
        assert!(bounds.is_nonnegative(&n().subtract(&wrapped).unwrap().shifted(-1).unwrap()));
        // The largest i + 1 is n: one too many.
        assert_eq!(bounds.outlier(&i().shifted(1).unwrap(), Some(&n())), Some(Outlier::Beyond(0)));
        assert_eq!(bounds.outlier(&i(), Some(&n())), None);
    }

    #[test]
    fn outliers_are_certain() {
        let tables = natural();
        let outside = Loop { variable: 0, start: Index::default(), end: n() };
        let inside = Loop { variable: 1, start: Index::default(), end: i() };
        let before = i().shifted(-1).unwrap();
        let wrapped = before.remainder(&n()).unwrap();
        let round = before.add(&n()).unwrap().remainder(&n()).unwrap();
        let euclid = wrapped.add(&n()).unwrap().remainder(&n()).unwrap();
        let [one, two] = [vec![outside.clone()], vec![outside, inside]];
        let one = Bounds { loops: &one, tables: &tables };
        assert_eq!(one.outlier(&before, Some(&n())), Some(Outlier::Negative(-1)));
        assert_eq!(one.outlier(&wrapped, Some(&n())), Some(Outlier::Negative(-1)));
        assert_eq!(one.outlier(&round, Some(&n())), None);
        assert_eq!(one.outlier(&euclid, Some(&n())), None);
        // At i = 0 no j is below i.
        assert_eq!(Bounds { loops: &two, tables: &tables }.outlier(&before, Some(&n())), None);
    }

    #[test]
    fn remainders_are_below_natural_divisors_alone() {
        let loops = [Loop { variable: 0, start: Index::default(), end: Index::integer(3) }];
        let signed = [Table::default()];
        let below = |tables: &[Table]| {
            let rest = n().subtract(&i().remainder(&n()).unwrap()).unwrap().shifted(-1).unwrap();
            Bounds { loops: &loops, tables }.is_nonnegative(&rest)
        };
        assert!(below(&natural()));
        // 2 % -5 is 2.
        assert!(!below(&signed));
    }

    #[test]
    fn minima_and_maxima_bound_loops() {
        let end = n().minimum(&Index::integer(1));
        let loops = [Loop { variable: 0, start: Index::default(), end }];
        let tables = natural();
        let bounds = Bounds { loops: &loops, tables: &tables };
        assert!(bounds.is_nonnegative(&n().subtract(&i()).unwrap().shifted(-1).unwrap()));
        assert!(bounds.is_nonnegative(&Index::default().subtract(&i()).unwrap()));
    }
}
