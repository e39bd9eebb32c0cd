//! Loops: the body of one is evaluated once, at its variable, and its sum becomes a symbol.
//!
//! A comparison decided neither by the loops nor by earlier assumptions splits the loop in two. Where a
//! symbolic variable does not suffice (an exponent, a position in a heterogeneous list, an assignment to an
//! outer variable), the loop is unrolled: the evaluation is abandoned, and the body is evaluated again for
//! each value of the loop variable, if these are known.
//!
//! Tests: `lower/tests/messages.rs`, `tests/loops/ranges.rs`.

use quote::ToTokens;

use super::interpreter::Interpreter;
use super::value::Value;
use crate::diagnostics::expressions;
use crate::model::{Atom, Bounds, Index, Loop, Slot};
use crate::symbolic::{Expr, Rational, Relation};

/// The deepest nesting of loops and sums: a sum over that many indices would never end, even with a handful
/// of places each.
const MOST_NESTED: usize = 16;

/// The most parts into which one loop is split.
const MOST_CASES: usize = 64;

/// `d < 0` or `d <= 0`, assumed to hold or not in one part of a loop.
#[derive(Clone)]
struct Assumption {
    difference: Index,
    or_equal: bool,
    holds: bool,
}

/// One part of a loop while its body is evaluated.
struct Case {
    variable: u32,
    assumed: Vec<Assumption>,
    /// Parts that are still to be evaluated.
    others: Vec<Vec<Assumption>>,
}

/// The loops around the current expression.
#[derive(Default)]
pub(super) struct Loops {
    /// Outermost first.
    pub(super) active: Vec<Loop>,
    cases: Vec<Case>,
    /// The variable of the loop to be unrolled: the evaluation inside it is abandoned.
    unrolled: Option<u32>,
}

impl<'a> Interpreter<'a, '_> {
    /// Whether the evaluation returns to a loop that starts again. Intermediate results are then meaningless.
    pub(super) fn is_abandoned(&self) -> bool {
        self.now.loops.unrolled.is_some()
    }

    /// Number of loops around the current expression.
    pub(super) fn loop_depth(&self) -> usize {
        self.now.loops.active.len()
    }

    /// Whether the evaluation was abandoned to unroll the loop over `variable`; if so, ends the abandonment.
    pub(super) fn is_unrolled(&mut self, variable: u32) -> bool {
        let is_own = self.now.loops.unrolled == Some(variable);
        if is_own {
            self.now.loops.unrolled = None;
        }
        is_own
    }

    /// Abandons the evaluation to unroll the innermost loop whose variable is `wanted` and whose range is
    /// known; `false` if there is none.
    pub(super) fn request_unrolling(&mut self, wanted: impl Fn(u32) -> bool) -> bool {
        if self.is_abandoned() {
            return true;
        }
        let mut loops = self.now.loops.active.iter().rev().filter(|known| wanted(known.variable));
        let found = loops.find(|known| self.has_known_range(known)).map(|known| known.variable);
        self.now.loops.unrolled = found;
        found.is_some()
    }

    /// Abandons the evaluation to unroll a loop that an integer depends on; `false` if there is none.
    pub(super) fn request_unrolling_of(&mut self, index: &Index) -> bool {
        let depends = index.loops();
        self.request_unrolling(|variable| depends.contains(&variable))
    }

    /// Whether the range of a loop is known once the loops around it are unrolled.
    fn has_known_range(&self, known: &Loop) -> bool {
        let is_known = |bound: &Index| {
            bound.is_closed()
                && bound.loops().iter().all(|variable| {
                    let mut outer =
                        self.now.loops.active.iter().take_while(|outer| outer.variable != known.variable);
                    outer
                        .find(|outer| outer.variable == *variable)
                        .is_some_and(|outer| self.has_known_range(outer))
                })
        };
        is_known(&known.start) && is_known(&known.end)
    }

    pub(super) fn is_nonnegative(&self, index: &Index) -> bool {
        self.bounded(|bounds| bounds.is_nonnegative(index))
    }

    /// The known bounds of the loops. Assumptions about the part of a loop under evaluation bound its
    /// variable, too.
    pub(super) fn bounded<T>(&self, read: impl FnOnce(&Bounds<'_>) -> T) -> T {
        let restricted = |known: &Loop| {
            let case = self.now.loops.cases.iter().rev().find(|case| case.variable == known.variable);
            case.and_then(|case| restrict(known, &case.assumed)).unwrap_or_else(|| known.clone())
        };
        let loops: Vec<Loop> = self.now.loops.active.iter().map(restricted).collect();
        read(&Bounds { loops: &loops, tables: self.tables.as_list() })
    }

    /// `difference < 0`, or `<= 0` with `or_equal`: decided, or assumed in this part of the loop, or left to
    /// the running program.
    pub(super) fn is_less(&mut self, difference: &Index, or_equal: bool) -> Value {
        if let Some(known) = difference.as_integer() {
            return Value::Known(known < 0 || (or_equal && known == 0));
        }
        // d < 0 is -1 - d >= 0; d <= 0 is -d >= 0.
        let below = |bound: i128| Index::integer(bound).subtract(difference);
        if below(if or_equal { 0 } else { -1 }).is_some_and(|rest| self.is_nonnegative(&rest)) {
            return Value::Known(true);
        }
        if difference.shifted(if or_equal { -1 } else { 0 }).is_some_and(|rest| self.is_nonnegative(&rest)) {
            return Value::Known(false);
        }
        // The bounds of a loop read those around it alone: the innermost loop of the condition is the one to
        // split.
        let Loops { active, cases, .. } = &mut self.now.loops;
        let innermost = active.iter().rfind(|known| difference.loops().contains(&known.variable));
        let splits = |known: &&Loop| matches!(difference.slope(known.variable), Some(1 | -1));
        let variable = innermost.filter(splits).map(|known| known.variable);
        if let Some(case) = cases.iter_mut().find(|case| Some(case.variable) == variable) {
            let known = case.assumed.iter().find(|a| a.difference == *difference && a.or_equal == or_equal);
            if let Some(known) = known {
                return Value::Known(known.holds);
            }
            let mut assumption = Assumption { difference: difference.clone(), or_equal, holds: false };
            let mut other = case.assumed.clone();
            other.push(assumption.clone());
            case.others.push(other);
            assumption.holds = true;
            case.assumed.push(assumption);
            return Value::Known(true);
        }
        let relation = if or_equal { Relation::LessEqual } else { Relation::Less };
        Value::Condition(self.compare_with_zero(relation, difference))
    }

    /// `difference relation 0`, left to the running program. Between integers of the struct it is a
    /// comparison of parameters, `n < m + 1` with as many numbers on either side as were written: exact below
    /// 2^53.
    pub(super) fn compare_with_zero(&mut self, relation: Relation, difference: &Index) -> Expr {
        let (left, right) = match self.sides(difference) {
            Some(sides) => sides,
            None => (self.index_as_real(difference), self.graph.integer(0)),
        };
        self.graph.compare(relation, left, right)
    }

    /// `difference = left - right`, if it is linear in integers of the struct.
    fn sides(&mut self, difference: &Index) -> Option<(Expr, Expr)> {
        let (mut left, mut right) = (Vec::new(), Vec::new());
        for (atom, coefficient) in &difference.terms {
            let parameter = self.index_parameter(atom)?;
            let multiple = Rational::new(*coefficient, 1)?;
            match multiple.is_negative() {
                true => right.push((parameter, multiple.negate())),
                false => left.push((parameter, multiple)),
            }
        }
        let constant = Rational::new(difference.constant, 1)?;
        let one = self.graph.integer(1);
        match right.is_empty() || constant.is_negative() {
            true => right.push((one, constant.negate())),
            false => left.push((one, constant)),
        }
        Some((self.graph.linear_combination(&left), self.graph.linear_combination(&right)))
    }

    /// An integer of the struct, which is a parameter.
    fn index_parameter(&mut self, atom: &Atom) -> Option<Expr> {
        let Atom::Given(id, indices) = atom else { return None };
        let (name, tokens) = indices.is_empty().then(|| self.tables.integer(*id))??;
        Some(self.integer_parameter(&name, tokens))
    }

    /// An integer as a real number.
    pub(super) fn index_as_real(&mut self, index: &Index) -> Expr {
        if let Some(known) = index.as_integer() {
            return self.graph.whole(known);
        }
        if let ([(atom, 1)], 0) = (index.terms.as_slice(), index.constant)
            && let Some(parameter) = self.index_parameter(atom)
        {
            return parameter;
        }
        self.local(Slot::Number(index.clone()))
    }

    /// `Σ body(k)` for `k` in `0..length`.
    pub(super) fn sum_loop(
        &mut self,
        length: &Index,
        at: &dyn ToTokens,
        body: &mut dyn FnMut(&mut Self, &Index) -> Option<Expr>,
    ) -> Option<Expr> {
        if length.as_integer().is_some_and(|length| length <= 0) {
            return Some(self.graph.integer(0));
        }
        if self.now.loops.active.len() >= MOST_NESTED {
            return self.refuse(expressions::too_many_loops(at, MOST_NESTED));
        }
        // The body is evaluated once, for any number of iterations.
        let variable = self.symbols.variable(self.now.loops.active.len());
        let whole = Loop { variable, start: Index::default(), end: length.clone() };
        let outer = (self.now.loops.active.len(), self.now.loops.cases.len());
        let scope = self.now.scope.len();
        let sum = self.sum_by_parts(&whole, at, body);
        self.now.loops.active.truncate(outer.0);
        self.now.loops.cases.truncate(outer.1);
        self.now.scope.leave(scope);
        if !self.is_unrolled(variable) {
            return sum;
        }
        let length = self.known_integer(Value::index(length.clone()), at)?;
        let mut terms = Vec::new();
        for turn in 0..length {
            if !self.spend(1, at) {
                return None;
            }
            terms.push((body(self, &Index::integer(turn))?, Rational::ONE));
        }
        Some(self.graph.linear_combination(&terms))
    }

    /// The sum over a loop, with a symbol for each part into which the conditions in its body split it.
    fn sum_by_parts(
        &mut self,
        whole: &Loop,
        at: &dyn ToTokens,
        body: &mut dyn FnMut(&mut Self, &Index) -> Option<Expr>,
    ) -> Option<Expr> {
        let variable = whole.variable;
        // The parts share a variable: they are successive loops.
        let mut pending = vec![Vec::new()];
        let mut terms = Vec::new();
        while let Some(assumed) = pending.pop() {
            self.now.loops.active.push(whole.clone());
            self.now.loops.cases.push(Case { variable, assumed, others: Vec::new() });
            let value = body(self, &Index::atom(Atom::Loop(variable)));
            let case = self.now.loops.cases.pop()?;
            self.now.loops.active.pop();
            let value = value?;
            pending.extend(case.others);
            if pending.len() > MOST_CASES {
                self.now.loops.active.push(whole.clone());
                return self.refuse(expressions::too_many_cases(at, MOST_CASES));
            }
            let Some(range) = restrict(whole, &case.assumed) else {
                return self.refuse(expressions::integer_arithmetic(at));
            };
            let is_empty =
                range.end.subtract(&range.start).and_then(|d| d.as_integer()).is_some_and(|d| d <= 0);
            if self.graph.is_zero(value) || is_empty {
                continue;
            }
            if self.symbols.depth(&self.graph, value) >= MOST_NESTED {
                return self.refuse(expressions::too_many_loops(at, MOST_NESTED));
            }
            let symbol = self.symbols.sum(&mut self.graph, range, value);
            terms.push((self.graph.symbol(symbol), Rational::ONE));
        }
        Some(self.graph.linear_combination(&terms))
    }
}

/// The part of a loop where the assumptions hold.
fn restrict(whole: &Loop, assumed: &[Assumption]) -> Option<Loop> {
    let Loop { variable, mut start, mut end } = whole.clone();
    for Assumption { difference, or_equal, holds } in assumed {
        let slope = difference.slope(variable)?;
        // d = ± k + r, and d < s with s = 0 or 1 holds or does not.
        let rest = difference.plus(&Index::atom(Atom::Loop(variable)), -slope)?;
        let s = i128::from(*or_equal);
        if slope == 1 {
            let bound = Index::integer(s).subtract(&rest)?;
            if *holds { end = end.minimum(&bound) } else { start = start.maximum(&bound) }
        } else {
            // -k + r < s is k > r - s.
            let bound = rest.shifted(1 - s)?;
            if *holds { start = start.maximum(&bound) } else { end = end.minimum(&bound) }
        }
    }
    Some(Loop { variable, start, end })
}
