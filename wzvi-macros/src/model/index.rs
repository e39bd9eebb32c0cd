//! Integer expressions of loop variables and sizes, in a normal form: a constant plus integer multiples of atoms.
//! Two indices are equal wherever their forms are; `i + 1` and `1 + i` are one form.
//!
//! What the compiler can decide about them decides how systems are solved: the difference of two indices of one element
//! is a constant (a band), wraps around (a ring), or is known to the running program only (a table).

use std::collections::BTreeSet;

/// What an index is made of besides integers.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(crate) enum Atom {
    /// The variable of a loop.
    Loop(u32),
    /// The outermost size of the phase space, where only the state knows it.
    Size,
    /// An integer that the struct or a constant holds: the entry of a list, if there are indices.
    Given(u32, Vec<Index>),
    Product(Box<(Index, Index)>),
    /// `a / b`, rounded towards zero.
    Quotient(Box<(Index, Index)>),
    /// `a % b`
    Remainder(Box<(Index, Index)>),
    Minimum(Box<(Index, Index)>),
    Maximum(Box<(Index, Index)>),
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

/// Nested substitutions that a proof may take.
const PROOF_DEPTH: u32 = 12;

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

    pub(crate) fn multiply(&self, other: &Self) -> Option<Self> {
        match (self.as_integer(), other.as_integer()) {
            (_, Some(factor)) => Self::default().plus(self, factor),
            (Some(factor), _) => Self::default().plus(other, factor),
            _ => {
                let (a, b) = (self.clone().min(other.clone()), self.clone().max(other.clone()));
                Some(Self::atom(Atom::Product(Box::new((a, b)))))
            }
        }
    }

    /// `self / other` as Rust computes it; `None` for a division by zero.
    pub(crate) fn divide(&self, other: &Self) -> Option<Self> {
        match (self.as_integer(), other.as_integer()) {
            (Some(a), Some(b)) => a.checked_div(b).map(Self::integer),
            (_, Some(0)) => None,
            (_, Some(1)) => Some(self.clone()),
            _ => Some(Self::atom(Atom::Quotient(Box::new((self.clone(), other.clone()))))),
        }
    }

    /// `self % other` as Rust computes it; `None` for a division by zero.
    pub(crate) fn remainder(&self, other: &Self) -> Option<Self> {
        match (self.as_integer(), other.as_integer()) {
            (Some(a), Some(b)) => a.checked_rem(b).map(Self::integer),
            (_, Some(0)) => None,
            _ => Some(Self::atom(Atom::Remainder(Box::new((self.clone(), other.clone()))))),
        }
    }

    pub(crate) fn minimum(&self, other: &Self) -> Self {
        match self.subtract(other).and_then(|difference| difference.as_integer()) {
            Some(difference) if difference <= 0 => self.clone(),
            Some(_) => other.clone(),
            None => {
                let (a, b) = (self.clone().min(other.clone()), self.clone().max(other.clone()));
                Self::atom(Atom::Minimum(Box::new((a, b))))
            }
        }
    }

    pub(crate) fn maximum(&self, other: &Self) -> Self {
        match self.subtract(other).and_then(|difference| difference.as_integer()) {
            Some(difference) if difference >= 0 => self.clone(),
            Some(_) => other.clone(),
            None => {
                let (a, b) = (self.clone().min(other.clone()), self.clone().max(other.clone()));
                Self::atom(Atom::Maximum(Box::new((a, b))))
            }
        }
    }

    /// The loop variables that it reads.
    pub(crate) fn loops(&self) -> BTreeSet<u32> {
        let mut found = BTreeSet::new();
        self.collect_loops(&mut found);
        found
    }

    fn collect_loops(&self, into: &mut BTreeSet<u32>) {
        for (atom, _) in &self.terms {
            match atom {
                Atom::Loop(variable) => {
                    into.insert(*variable);
                }
                Atom::Size => {}
                Atom::Given(_, indices) => indices.iter().for_each(|index| index.collect_loops(into)),
                Atom::Product(both)
                | Atom::Quotient(both)
                | Atom::Remainder(both)
                | Atom::Minimum(both)
                | Atom::Maximum(both) => {
                    both.0.collect_loops(into);
                    both.1.collect_loops(into);
                }
            }
        }
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
                    let indices =
                        indices.iter().map(|index| index.with(variable, by)).collect::<Option<_>>()?;
                    Self::atom(Atom::Given(*id, indices))
                }
                Atom::Product(both) => both.0.with(variable, by)?.multiply(&both.1.with(variable, by)?)?,
                Atom::Quotient(both) => both.0.with(variable, by)?.divide(&both.1.with(variable, by)?)?,
                Atom::Remainder(both) => both.0.with(variable, by)?.remainder(&both.1.with(variable, by)?)?,
                Atom::Minimum(both) => both.0.with(variable, by)?.minimum(&both.1.with(variable, by)?),
                Atom::Maximum(both) => both.0.with(variable, by)?.maximum(&both.1.with(variable, by)?),
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
                atom if Self::atom(atom.clone()).loops().contains(&variable) => return None,
                _ => {}
            }
        }
        Some(slope)
    }

    /// The index with a loop variable, where it occurs linearly, replaced.
    fn replaced(&self, atom: &Atom, by: &Self) -> Option<Self> {
        let coefficient = self.terms.iter().find(|(known, _)| known == atom).map_or(0, |(_, c)| *c);
        self.plus(&Self::atom(atom.clone()), -coefficient)?.plus(by, coefficient)
    }
}

/// What the compiler knows of loop variables and integers while it decides about indices.
pub(crate) struct Bounds<'a> {
    pub(crate) loops: &'a [Loop],
    /// Whether an integer of the struct is of unsigned type.
    pub(crate) is_unsigned: &'a dyn Fn(u32) -> bool,
}

impl Bounds<'_> {
    /// Whether `index >= 0` wherever the loops go; `false` if that cannot be shown.
    pub(crate) fn is_nonnegative(&self, index: &Index) -> bool {
        self.proves(index, PROOF_DEPTH)
    }

    /// Bounds an atom that hides what is inside of it, innermost loops first.
    fn proves(&self, index: &Index, depth: u32) -> bool {
        if index.terms.is_empty() {
            return index.constant >= 0;
        }
        if depth == 0 {
            return false;
        }
        let replaced = |atom: &Atom, by: &Index| index.replaced(atom, by);
        let proves = |image: Option<Index>| image.is_some_and(|image| self.proves(&image, depth - 1));
        // Loops are bounded by those around them: the innermost goes first.
        for known in self.loops.iter().rev() {
            let atom = Atom::Loop(known.variable);
            let Some((_, coefficient)) = index.terms.iter().find(|(own, _)| *own == atom) else { continue };
            let hidden = index
                .terms
                .iter()
                .any(|(own, _)| *own != atom && Index::atom(own.clone()).loops().contains(&known.variable));
            if hidden {
                continue;
            }
            let extreme = if *coefficient > 0 { Some(known.start.clone()) } else { known.end.shifted(-1) };
            return extreme.is_some_and(|extreme| proves(replaced(&atom, &extreme)));
        }
        index.terms.iter().any(|(atom, coefficient)| {
            let positive = *coefficient > 0;
            match atom {
                Atom::Loop(_) | Atom::Product(_) => false,
                Atom::Size | Atom::Given(..) if positive => {
                    self.lower_bounds(atom).iter().any(|bound| proves(replaced(atom, bound)))
                }
                Atom::Size | Atom::Given(..) => false,
                Atom::Quotient(both) => match both.1.as_integer() {
                    // For a nonnegative numerator `0 <= a / b <= a`.
                    Some(divisor) if divisor > 0 && self.proves(&both.0, depth - 1) => {
                        let bound = if positive { Index::default() } else { both.0.clone() };
                        proves(replaced(atom, &bound))
                    }
                    _ => false,
                },
                Atom::Remainder(both) if self.proves(&both.0, depth - 1) => {
                    let bound = if positive { Some(Index::default()) } else { both.1.shifted(-1) };
                    bound.is_some_and(|bound| proves(replaced(atom, &bound)))
                }
                Atom::Remainder(_) => false,
                Atom::Minimum(both) if positive => {
                    proves(replaced(atom, &both.0)) && proves(replaced(atom, &both.1))
                }
                Atom::Minimum(both) => proves(replaced(atom, &both.0)) || proves(replaced(atom, &both.1)),
                Atom::Maximum(both) if positive => {
                    proves(replaced(atom, &both.0)) || proves(replaced(atom, &both.1))
                }
                Atom::Maximum(both) => proves(replaced(atom, &both.0)) && proves(replaced(atom, &both.1)),
            }
        })
    }

    /// What a size is at least: a loop that runs has an end beyond its start.
    fn lower_bounds(&self, atom: &Atom) -> Vec<Index> {
        let mut bounds: Vec<Index> = self
            .loops
            .iter()
            .filter_map(|known| {
                let rest = known.end.plus(&Index::atom(atom.clone()), -1)?;
                let is_alone = !rest.terms.iter().any(|(other, _)| other == atom);
                is_alone.then(|| known.start.shifted(1)?.subtract(&rest)).flatten()
            })
            .collect();
        let is_natural = match atom {
            Atom::Given(table, _) => (self.is_unsigned)(*table),
            _ => true,
        };
        bounds.extend(is_natural.then(Index::default));
        bounds
    }

    /// The largest value that `index` takes, if it is linear in its loops.
    pub(crate) fn largest(&self, index: &Index) -> Option<Index> {
        let mut largest = index.clone();
        for known in self.loops.iter().rev() {
            let extreme = match largest.slope(known.variable)? {
                0 => continue,
                slope if slope > 0 => known.end.shifted(-1)?,
                _ => known.start.clone(),
            };
            largest = largest.replaced(&Atom::Loop(known.variable), &extreme)?;
        }
        Some(largest)
    }
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
        let bounds = Bounds { loops: &loops, is_unsigned: &|_| true };
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
        let largest = bounds.largest(&i().shifted(1).unwrap()).unwrap();
        assert_eq!(largest.subtract(&n()).unwrap().as_integer(), Some(0));
    }

    #[test]
    fn minima_and_maxima_bound_loops() {
        let end = n().minimum(&Index::integer(1));
        let loops = [Loop { variable: 0, start: Index::default(), end }];
        let bounds = Bounds { loops: &loops, is_unsigned: &|_| true };
        assert!(bounds.is_nonnegative(&n().subtract(&i()).unwrap().shifted(-1).unwrap()));
        assert!(bounds.is_nonnegative(&Index::default().subtract(&i()).unwrap()));
    }
}
