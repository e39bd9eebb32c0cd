//! Coincidence of two slots: the equation of their indices is solved for a loop variable, or shown never to
//! hold.
//!
//! | equation | is |
//! |---|---|
//! | `c = 0` | true or never |
//! | `Σ a_k x_k + c = 0`, no multiple of `gcd(a_k)` is `-c` | never |
//! | one side is larger wherever the loops go | never |
//! | `M x + r = 0` with `-M < r < M` | `x = 0` and `r = 0`: points and their components, digits of any kind |
//! | `v + x = 0` with a loop variable `v` | `v = -x`; the range of `v` is then a condition |
//! | `a mod n = b mod n` with `-n < a - b < n` | `a = b` |
//! | `(v + a) mod n = b` with `v` in `0..n` and `0 <= b < n` | `v = (b - a) mod n` |
//! | `(b + c) mod n = b` with `0 <= b < n` | true where `n` divides `c`, else never |
//!
//! A condition that is not known to hold restricts a loop. An undecided one (two entries of tables) becomes a
//! loop that runs once if it holds and not at all otherwise.
//!
//! Tests: `discretise/sums/tests.rs`.

use super::{Space, variable};
use crate::diagnostics::promised;
use crate::model::{Atom, Index, IndexOperation, Loop};
use crate::symbolic::rational::gcd;

/// The loops of two elements with coinciding slots.
pub(super) struct Coincidence {
    /// Outer ones first.
    pub(super) loops: Vec<Loop>,
    /// The loop variables solved for.
    solved: Vec<(u32, Index)>,
}

/// An expression that must vanish.
#[derive(Clone)]
pub(super) struct Equation {
    pub(super) difference: Index,
    /// Whether it is between slots of the state: these are in range.
    pub(super) is_of_slots: bool,
}

struct Solver<'s> {
    space: &'s Space,
    loops: Vec<Loop>,
    solved: Vec<(u32, Index)>,
    pending: Vec<Equation>,
    /// Expressions that must not be negative.
    conditions: Vec<Index>,
    /// The next free loop variable.
    next: u32,
}

impl Coincidence {
    /// An index of one of the elements at this placement.
    pub(super) fn image(&self, space: &Space, index: &Index) -> Option<Index> {
        let mut solved = self.solved.iter();
        let image = solved.try_fold(index.clone(), |index, (own, by)| index.with(*own, by))?;
        simplified(space, &image, &self.loops)
    }
}

/// The loops restricted to solutions of the equations, if there are any; `None` if an index exceeds this
/// arithmetic.
pub(super) fn solve(
    space: &Space,
    loops: Vec<Loop>,
    equations: Vec<Equation>,
    next: u32,
) -> Option<Option<Coincidence>> {
    let mut solver =
        Solver { space, loops, solved: Vec::new(), pending: equations, conditions: Vec::new(), next };
    while let Some(equation) = solver.pending.pop() {
        if !solver.can_hold(equation)? {
            return Some(None);
        }
    }
    solver.loops = in_order(std::mem::take(&mut solver.loops));
    let conditions = std::mem::take(&mut solver.conditions);
    for condition in conditions {
        if !solver.restrict(&condition)? {
            return Some(None);
        }
    }
    let Solver { loops, solved, .. } = solver;
    Some(Some(Coincidence { loops: in_order(loops), solved }))
}

impl Solver<'_> {
    fn is_nonnegative(&self, index: &Index) -> bool {
        self.space.is_nonnegative(index, &self.loops)
    }

    fn is_positive(&self, index: &Index) -> bool {
        index.shifted(-1).is_some_and(|index| self.is_nonnegative(&index))
    }

    /// Restricts the loops to where an equation holds; returns `false` if it holds nowhere.
    fn can_hold(&mut self, equation: Equation) -> Option<bool> {
        let difference = simplified(self.space, &equation.difference, &self.loops)?;
        if difference.terms.is_empty() {
            return Some(difference.constant == 0);
        }
        let divisor = difference.terms.iter().fold(0, |divisor, (_, c)| gcd(divisor, c.unsigned_abs()));
        let divisor = i128::try_from(divisor).unwrap_or(1);
        let Some((difference, 0)) = difference.divided(divisor) else { return Some(false) };
        let negated = Index::default().subtract(&difference)?;
        if self.is_positive(&difference) || self.is_positive(&negated) {
            return Some(false);
        }
        let equation = Equation { difference, ..equation };
        if !(self.split_digits(&equation)?
            || self.eliminate(&equation)?
            || self.unwrap_remainders(&equation)?)
        {
            self.guard(&equation.difference)?;
        }
        Some(true)
    }

    /// `M x + r = 0` with `-M < r < M` as `x = 0` and `r = 0`.
    fn split_digits(&mut self, equation: &Equation) -> Option<bool> {
        let Index { terms, constant } = &equation.difference;
        let mut moduli: Vec<i128> = terms.iter().map(|(_, c)| c.unsigned_abs().cast_signed()).collect();
        moduli.retain(|&modulus| modulus > 1);
        moduli.dedup();
        for modulus in moduli {
            let (multiples, rest): (Vec<_>, Vec<_>) =
                terms.iter().cloned().partition(|(_, coefficient)| coefficient % modulus == 0);
            if rest.is_empty() {
                continue;
            }
            let remainder = constant.rem_euclid(modulus);
            for low in [remainder, remainder - modulus] {
                let digit = Index { terms: rest.clone(), constant: low };
                let (below, above) =
                    (Index::integer(modulus - 1).subtract(&digit)?, digit.shifted(modulus - 1)?);
                if self.is_nonnegative(&below) && self.is_nonnegative(&above) {
                    let high = Index { terms: multiples, constant: constant - low };
                    let (high, _) = high.divided(modulus)?;
                    self.pending.push(Equation { difference: digit, is_of_slots: false });
                    self.pending.push(Equation { difference: high, is_of_slots: equation.is_of_slots });
                    return Some(true);
                }
            }
        }
        Some(false)
    }

    /// Solves for a loop variable, preferably for one that runs over all points: its range is then no
    /// condition.
    fn eliminate(&mut self, equation: &Equation) -> Option<bool> {
        let difference = &equation.difference;
        let is_read = |own: &Loop| self.loops.iter().any(|other| reads(other, own.variable));
        let candidates = self.loops.iter().enumerate().filter(|(_, own)| {
            matches!(difference.slope(own.variable), Some(1 | -1))
                && !self.is_around(own.variable, difference)
        });
        let best = candidates.max_by_key(|&(at, own)| (self.is_over_all(own), !is_read(own), at));
        let Some((at, own)) = best.map(|(at, own)| (at, own.clone())) else { return Some(false) };
        let slope = difference.slope(own.variable)?;
        let rest = difference.plus(&variable(own.variable), -slope)?;
        let solution = Index::default().plus(&rest, -slope)?;
        // A loop over all points reaches every slot.
        let is_in_range = equation.is_of_slots && self.is_over_all(&own);
        self.loops.remove(at);
        if !is_in_range {
            let (start, end) =
                (own.start.with(own.variable, &solution)?, own.end.with(own.variable, &solution)?);
            self.conditions.push(solution.subtract(&start)?);
            self.conditions.push(end.shifted(-1)?.subtract(&solution)?);
        }
        self.replace(own.variable, &solution)?;
        Some(true)
    }

    /// Whether the range of a loop variable that `index` reads depends on `own`, which then cannot be solved
    /// for.
    fn is_around(&self, own: u32, index: &Index) -> bool {
        let present = index.loops();
        let mut inside = vec![own];
        while let Some(outer) = inside.pop() {
            for other in self.loops.iter().filter(|other| reads(other, outer)) {
                if present.contains(&other.variable) {
                    return true;
                }
                inside.push(other.variable);
            }
        }
        false
    }

    fn is_over_all(&self, own: &Loop) -> bool {
        own.start == Index::default() && own.end == self.space.size
    }

    /// `by` for a loop variable, everywhere.
    fn replace(&mut self, own: u32, by: &Index) -> Option<()> {
        for known in &mut self.loops {
            known.start = known.start.with(own, by)?;
            known.end = known.end.with(own, by)?;
        }
        for equation in &mut self.pending {
            equation.difference = equation.difference.with(own, by)?;
        }
        for condition in &mut self.conditions {
            *condition = condition.with(own, by)?;
        }
        for (_, solution) in &mut self.solved {
            *solution = solution.with(own, by)?;
        }
        self.solved.push((own, by.clone()));
        Some(())
    }

    fn unwrap_remainders(&mut self, equation: &Equation) -> Option<bool> {
        let difference = &equation.difference;
        let wrapped = difference.terms.iter().filter_map(|(atom, coefficient)| match atom {
            Atom::Of(IndexOperation::Remainder, both) => Some((&**both, *coefficient)),
            _ => None,
        });
        let wrapped: Vec<(&(Index, Index), i128)> = wrapped.collect();
        match wrapped.as_slice() {
            // a mod n = b mod n
            [(a, 1), (b, -1)] | [(a, -1), (b, 1)]
                if a.1 == b.1 && difference.terms.len() == 2 && difference.constant == 0 =>
            {
                let inner = a.0.subtract(&b.0)?;
                let modulus = &a.1;
                let (below, above) = (modulus.subtract(&inner)?, modulus.add(&inner)?);
                let close = self.is_positive(&below) && self.is_positive(&above);
                let both_natural = self.is_nonnegative(&a.0) && self.is_nonnegative(&b.0);
                if close && both_natural {
                    self.pending.push(Equation { difference: inner, is_of_slots: false });
                }
                Some(close && both_natural)
            }
            // (v + r) mod n = s
            [(wrapped, coefficient @ (1 | -1))] => {
                let (inner, modulus) = (&wrapped.0, &wrapped.1);
                let atom = Index::of(IndexOperation::Remainder, inner.clone(), modulus.clone());
                let rest = difference.plus(&atom, -coefficient)?;
                let target = Index::default().plus(&rest, -coefficient)?;
                if let Some(distance) =
                    inner.subtract(&target)?.as_integer().filter(|distance| *distance != 0)
                {
                    return self.close_ring(distance, &target, inner, modulus);
                }
                let own = self.loops.iter().find(|own| {
                    inner.slope(own.variable) == Some(1)
                        && own.start == Index::default()
                        && own.end == *modulus
                        && target.slope(own.variable) == Some(0)
                        && !self.is_around(own.variable, difference)
                });
                let Some(own) = own.map(|own| own.variable) else { return Some(false) };
                let rest = inner.subtract(&variable(own))?;
                let in_range = self.is_nonnegative(&target) && self.is_positive(&modulus.subtract(&target)?);
                let solution = target.subtract(&rest)?;
                let lifted = if self.is_nonnegative(&solution) { solution } else { solution.add(modulus)? };
                if !in_range || !self.is_nonnegative(&lifted) || !self.is_nonnegative(inner) {
                    return Some(false);
                }
                let solution = lifted.remainder(modulus)?;
                self.loops.retain(|known| known.variable != own);
                let solution = simplified(self.space, &solution, &self.loops)?;
                self.replace(own, &solution)?;
                Some(true)
            }
            _ => Some(false),
        }
    }

    /// `(b + c) mod n = b` with `0 <= b < n`: only if `n` divides `c`, which depends on the size.
    fn close_ring(&mut self, distance: i128, target: &Index, inner: &Index, modulus: &Index) -> Option<bool> {
        let in_range = self.is_nonnegative(target) && self.is_positive(&modulus.subtract(target)?);
        if !in_range || !self.is_nonnegative(inner) {
            return Some(false);
        }
        let turns = Index::integer(distance.abs()).remainder(modulus)?;
        match simplified(self.space, &turns, &self.loops)?.as_integer() {
            Some(0) => {}
            Some(_) => self.push_guard(Index::default()),
            None => self.guard(&turns)?,
        }
        Some(true)
    }

    /// A loop that runs once if the index is 0, and otherwise not at all.
    fn guard(&mut self, index: &Index) -> Option<()> {
        let one = Index::integer(1);
        let end = one.minimum(&one.add(index)?).minimum(&one.subtract(index)?);
        self.push_guard(end);
        Some(())
    }

    fn push_guard(&mut self, end: Index) {
        self.loops.push(Loop { variable: self.next, start: Index::default(), end });
        self.next += 1;
    }

    /// Restricts the loops to `condition >= 0`; returns `false` if it holds nowhere.
    fn restrict(&mut self, condition: &Index) -> Option<bool> {
        let condition = simplified(self.space, condition, &self.loops)?;
        let is_given = self.is_nonnegative(&condition);
        if is_given || self.is_positive(&Index::default().subtract(&condition)?) {
            return Some(is_given);
        }
        let innermost = self.loops.iter().rposition(|known| condition.loops().contains(&known.variable));
        let slope = innermost.and_then(|at| condition.slope(self.loops[at].variable));
        match (innermost, slope) {
            (Some(at), Some(slope @ (1 | -1))) => {
                let own = self.loops[at].clone();
                let rest = condition.plus(&variable(own.variable), -slope)?;
                if slope == 1 {
                    let start = Index::default().subtract(&rest)?;
                    self.loops[at].start = self.extreme(IndexOperation::Maximum, &own.start, &start)?;
                } else {
                    let end = rest.shifted(1)?;
                    self.loops[at].end = self.extreme(IndexOperation::Minimum, &own.end, &end)?;
                }
            }
            _ => self.push_guard(Index::integer(1).minimum(&condition.shifted(1)?)),
        }
        Some(true)
    }

    /// The maximum or minimum of two, simplified if it is known which is larger.
    fn extreme(&self, operation: IndexOperation, a: &Index, b: &Index) -> Option<Index> {
        let difference = a.subtract(b)?;
        let is_first_larger = self.is_nonnegative(&difference);
        if !is_first_larger && !self.is_nonnegative(&Index::default().subtract(&difference)?) {
            return a.operate(operation, b);
        }
        Some(if is_first_larger == (operation == IndexOperation::Maximum) { a.clone() } else { b.clone() })
    }
}

/// Whether the range of a loop depends on another.
fn reads(known: &Loop, other: u32) -> bool {
    known.start.loops().contains(&other) || known.end.loops().contains(&other)
}

/// Sorts loops after those whose variables they read, otherwise unchanged.
fn in_order(mut loops: Vec<Loop>) -> Vec<Loop> {
    let mut ordered: Vec<Loop> = Vec::with_capacity(loops.len());
    while !loops.is_empty() {
        let is_free = |own: &Loop| {
            let mut read = own.start.loops();
            read.extend(own.end.loops());
            !loops.iter().any(|other| read.contains(&other.variable))
        };
        let at = loops.iter().position(is_free);
        let at = promised(
            at,
            "ranges of loops read outer ones only, and solutions never read what depends on them",
        );
        ordered.push(loops.remove(at));
    }
    ordered
}

/// The index without remainders of terms that are in range, and with nested remainders flattened.
pub(super) fn simplified(space: &Space, index: &Index, loops: &[Loop]) -> Option<Index> {
    let mut sum = Index::integer(index.constant);
    for (atom, coefficient) in &index.terms {
        let part = match atom {
            Atom::Of(IndexOperation::Remainder, both) => {
                let modulus = &both.1;
                let mut inner = simplified(space, &both.0, loops)?;
                let is_nonnegative = |index: &Index| space.is_nonnegative(index, loops);
                let nested = inner.terms.iter().find_map(|(atom, coefficient)| match atom {
                    Atom::Of(IndexOperation::Remainder, nested)
                        if nested.1 == *modulus && *coefficient == 1 =>
                    {
                        Some((atom.clone(), nested.0.clone()))
                    }
                    _ => None,
                });
                if let Some((atom, nested)) = nested {
                    let rest = inner.subtract(&Index::atom(atom))?;
                    if is_nonnegative(&rest) && is_nonnegative(&nested) {
                        inner = rest.add(&nested)?;
                    }
                }
                let below = modulus.subtract(&inner)?.shifted(-1)?;
                if is_nonnegative(&inner) && is_nonnegative(&below) {
                    inner
                } else {
                    inner.remainder(modulus)?
                }
            }
            other => Index::atom(other.clone()),
        };
        sum = sum.plus(&part, *coefficient)?;
    }
    Some(sum)
}
