//! Indices that only the running program knows: loop variables, sizes, entries of tables. Arithmetic on them is exact,
//! a comparison that neither the loops nor what was assumed so far decides splits the loop in two.

use std::collections::HashMap;

use proc_macro2::TokenStream;
use quote::{ToTokens, quote};
use syn::BinOp;

use super::interpreter::Interpreter;
use super::streams::{Array, Source, index_value, is_short};
use super::value::{Place, Value};
use crate::diagnostics::expressions;
use crate::input::{Kind, source};
use crate::model::index::{Atom, Bounds, Index, Loop};
use crate::model::{Local, Slot, Table};
use crate::symbolic::{Expr, Rational, Relation, Symbol};

/// Names of loop variables, by nesting; deeper ones repeat the last.
const LETTERS: [&str; 6] = ["i", "j", "k", "l", "m", "n"];

/// Parts that one loop may be split into.
const MOST_CASES: usize = 64;

/// What a sum symbol stands for: `Σ_(loop) body`.
pub(crate) struct Sum {
    pub(crate) symbol: Symbol,
    pub(crate) range: Loop,
    pub(crate) body: Expr,
}

/// `d < 0` or `d <= 0` as it was assumed, or not, in one part of a loop.
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

/// What a system of elements has besides the graph.
#[derive(Default)]
pub(super) struct Loops {
    pub(super) tables: Vec<Table>,
    known_tables: HashMap<String, u32>,
    pub(super) locals: Vec<Local>,
    known_locals: HashMap<Slot, Symbol>,
    pub(super) sums: Vec<Sum>,
    next: u32,
    letters: HashMap<u32, &'static str>,
    /// The loops around the current expression, outermost first.
    pub(super) active: Vec<Loop>,
    cases: Vec<Case>,
}

impl Loops {
    /// A new loop variable.
    pub(super) fn variable(&mut self) -> u32 {
        let letter = LETTERS[self.active.len().min(LETTERS.len() - 1)];
        self.letters.insert(self.next, letter);
        self.next += 1;
        self.next - 1
    }

    fn table(&mut self, name: &str, tokens: &TokenStream, is_unsigned: bool) -> u32 {
        let tables = &mut self.tables;
        *self.known_tables.entry(tokens.to_string()).or_insert_with(|| {
            let (name, suffix) = (name.to_owned(), TokenStream::new());
            tables.push(Table { name, tokens: tokens.clone(), suffix, is_unsigned });
            (tables.len() - 1) as u32
        })
    }

    /// What `suffix` says of the entries of a list.
    fn table_of(&mut self, id: u32, suffix: TokenStream, is_unsigned: bool) -> u32 {
        let tables = &mut self.tables;
        let Some(Table { name, tokens, .. }) = tables.get(id as usize).cloned() else { return id };
        let name = format!("{name}{suffix}").replace(' ', "");
        *self.known_tables.entry(format!("{tokens} [..] {suffix}")).or_insert_with(|| {
            tables.push(Table { name, tokens, suffix, is_unsigned });
            (tables.len() - 1) as u32
        })
    }

    /// An index for a reader.
    pub(super) fn display(&self, index: &Index) -> String {
        let table = |id: u32| self.tables.get(id as usize).map_or("?", |table| table.name.as_str());
        let letter = |variable: u32| self.letters.get(&variable).copied().unwrap_or("i");
        crate::elements::describe::index(index, &table, &letter)
    }
}

impl<'a> Interpreter<'a, '_> {
    /// The outermost size of the phase space, as it was written.
    pub(super) fn size(&mut self, expr: &syn::Expr) -> Index {
        let name = source(expr).replace(" . ", ".");
        let name = name.strip_prefix("self.").unwrap_or(&name);
        let id = self.loops().table(name, &expr.to_token_stream(), true);
        Index::atom(Atom::Given(id, Vec::new()))
    }

    /// The number of noises of a family: an integer literal, a constant, a size, a field, or what is made of them.
    pub(super) fn family_count(&mut self, count: &'a syn::Expr) -> Option<Index> {
        let constant = match count {
            syn::Expr::Lit(literal) => match &literal.lit {
                syn::Lit::Int(count) => count.base10_parse::<u32>().ok().map(|n| Index::integer(n.into())),
                _ => None,
            },
            syn::Expr::Path(_) => Some(self.size(count)),
            syn::Expr::Field(field) if super::names::is_self(&field.base) => Some(self.size(count)),
            syn::Expr::MethodCall(_) | syn::Expr::Binary(_) | syn::Expr::Paren(_) => {
                self.start();
                let value = self.evaluate(count);
                return self.as_index(&value, count);
            }
            _ => None,
        };
        if constant.is_none() {
            self.report(expressions::family_count(count));
        }
        constant
    }

    fn loops(&mut self) -> &mut Loops {
        self.sized.get_or_insert_with(Loops::default)
    }

    pub(super) fn is_nonnegative(&self, index: &Index) -> bool {
        let Some(loops) = &self.sized else { return false };
        // What is assumed of this part of a loop bounds its variable, too.
        let restricted: Vec<Loop> = loops.active.iter().map(|known| self.restricted(known)).collect();
        let is_unsigned = |table: u32| loops.tables.get(table as usize).is_some_and(|t| t.is_unsigned);
        Bounds { loops: &restricted, is_unsigned: &is_unsigned }.is_nonnegative(index)
    }

    /// The part of the loop that is being evaluated.
    fn restricted(&self, known: &Loop) -> Loop {
        let case = self
            .sized
            .as_ref()
            .and_then(|loops| loops.cases.iter().rev().find(|case| case.variable == known.variable));
        match case {
            Some(case) => restrict(known, &case.assumed).unwrap_or_else(|| known.clone()),
            None => known.clone(),
        }
    }

    /// An integer as an index.
    pub(super) fn as_index(&mut self, value: &Value, at: &dyn ToTokens) -> Option<Index> {
        match value {
            Value::Integer(value) => Some(Index::integer(*value)),
            Value::Index(index) => Some((**index).clone()),
            Value::Place(place) if matches!(place.kind, Kind::Integer | Kind::Constant) => {
                Some(self.given(place))
            }
            Value::Poison => None,
            other => {
                self.report(expressions::expected(at.to_token_stream(), "an integer", other.describe()));
                None
            }
        }
    }

    /// An integer of the struct or a constant.
    fn given(&mut self, place: &Place) -> Index {
        let id = self.loops().table(&place.name, &place.tokens, false);
        Index::atom(Atom::Given(id, Vec::new()))
    }

    /// A list of the struct.
    pub(super) fn table(&mut self, place: &Place) -> Option<Array> {
        let Kind::List(element, len) = &place.kind else { return None };
        let tokens = &place.tokens;
        let length = match len {
            Some(len) => Index::integer(*len as i128),
            None => {
                let (name, tokens) = (format!("{}.len()", place.name), quote! { #tokens.len() });
                let id = self.loops().table(&name, &tokens, true);
                Index::atom(Atom::Given(id, Vec::new()))
            }
        };
        let id = self.loops().table(&place.name, tokens, false);
        Some(Array {
            source: Source::Table(id, element.clone()),
            indices: Vec::new(),
            start: Index::default(),
            length,
            inner: Vec::new(),
        })
    }

    /// Element `k` of a list.
    pub(super) fn array_element(&mut self, array: &Array, k: &Index, at: &dyn ToTokens) -> Option<Value> {
        self.check_range(array, k, at)?;
        let position = array.start.add(k)?;
        match &array.source {
            Source::Table(id, kind) => {
                let mut indices = array.indices.clone();
                indices.push(position);
                self.entry(*id, kind, indices, at)
            }
            source => {
                let stride = array.inner.iter().product::<i128>();
                let offset = array.indices.first().cloned().unwrap_or_default();
                let offset = offset.plus(&position, stride)?;
                let Some((&length, inner)) = array.inner.split_first() else {
                    let slot = match source {
                        Source::Coordinates => Slot::Coordinate(offset),
                        _ => Slot::Momentum(offset),
                    };
                    return Some(Value::Real(self.local(slot)));
                };
                Some(Value::Array(
                    Array {
                        source: source.clone(),
                        indices: vec![offset],
                        start: Index::default(),
                        length: Index::integer(length),
                        inner: inner.to_vec(),
                    }
                    .into(),
                ))
            }
        }
    }

    /// What a list of the struct holds at `indices`.
    fn entry(&mut self, id: u32, kind: &Kind, indices: Vec<Index>, at: &dyn ToTokens) -> Option<Value> {
        match kind {
            Kind::Real | Kind::Constant => Some(Value::Real(self.local(Slot::Entry(id, indices)))),
            Kind::Integer => Some(index_value(Index::atom(Atom::Given(id, indices)))),
            Kind::List(inner, Some(len)) => Some(Value::Array(
                Array {
                    source: Source::Table(id, inner.clone()),
                    indices,
                    start: Index::default(),
                    length: Index::integer(*len as i128),
                    inner: Vec::new(),
                }
                .into(),
            )),
            Kind::List(inner, None) => {
                let length = self.loops().table_of(id, quote!(.len()), true);
                Some(Value::Array(
                    Array {
                        source: Source::Table(id, inner.clone()),
                        length: Index::atom(Atom::Given(length, indices.clone())),
                        indices,
                        start: Index::default(),
                        inner: Vec::new(),
                    }
                    .into(),
                ))
            }
            Kind::Tuple(kinds, _) => {
                let mut parts = Vec::new();
                for (k, kind) in kinds.iter().enumerate() {
                    let k = proc_macro2::Literal::usize_unsuffixed(k);
                    let id = self.loops().table_of(id, quote!(.#k), false);
                    parts.push(self.entry(id, kind, indices.clone(), at)?);
                }
                Some(Value::tuple(parts))
            }
            Kind::Other(ty) => {
                let name = self.loops().tables.get(id as usize).map_or_else(String::new, |t| t.name.clone());
                self.report(expressions::field_type(at.to_token_stream(), &name, ty));
                None
            }
        }
    }

    /// An index that is certainly out of range is a mistake; whether another is, the making of a stepper finds out.
    fn check_range(&mut self, array: &Array, k: &Index, at: &dyn ToTokens) -> Option<()> {
        let largest = {
            let loops = self.sized.as_ref()?;
            let restricted: Vec<Loop> = loops.active.iter().map(|known| self.restricted(known)).collect();
            let bounds = Bounds { loops: &restricted, is_unsigned: &|_| false };
            let negated = Index::default().subtract(k)?;
            [bounds.largest(k), bounds.largest(&negated)]
        };
        let [largest, negated_smallest] = largest;
        let above = largest.and_then(|largest| largest.subtract(&array.length)?.as_integer());
        let below = negated_smallest.and_then(|negated| negated.as_integer());
        if let Some(excess) = above.filter(|&excess| excess >= 0) {
            let (index, length) = {
                let loops = self.loops();
                (loops.display(k), loops.display(&array.length))
            };
            self.report(expressions::index_beyond(at.to_token_stream(), &index, &length, excess));
            return None;
        }
        if below.is_some_and(|negated| negated > 0) {
            let index = self.loops().display(k);
            self.report(expressions::index_negative(at.to_token_stream(), &index));
            return None;
        }
        Some(())
    }

    /// `list[range]`
    pub(super) fn subarray(
        &mut self,
        array: &Array,
        start: &Index,
        end: Option<&Index>,
        at: &dyn ToTokens,
    ) -> Option<Value> {
        let end = end.unwrap_or(&array.length);
        let length = end.subtract(start)?;
        let last = Index::atom_free_difference(&array.length, end);
        if last.is_some_and(|rest| rest < 0) || start.as_integer().is_some_and(|start| start < 0) {
            let (index, length) = {
                let loops = self.loops();
                (loops.display(end), loops.display(&array.length))
            };
            self.report(expressions::index_beyond(at.to_token_stream(), &index, &length, 0));
            return None;
        }
        Some(Value::Array(Array { start: array.start.add(start)?, length, ..array.clone() }.into()))
    }

    /// The variable at `slot`, the same wherever it is named.
    pub(super) fn local(&mut self, slot: Slot) -> Expr {
        let known = self.loops().known_locals.get(&slot).copied();
        let symbol = known.unwrap_or_else(|| {
            let name = self.slot_name(&slot);
            let symbol = self.graph.new_symbol(name);
            let loops = self.loops();
            loops.known_locals.insert(slot.clone(), symbol);
            loops.locals.push(Local { symbol, slot });
            symbol
        });
        self.graph.symbol(symbol)
    }

    fn slot_name(&mut self, slot: &Slot) -> String {
        let [q, p] = self.names.clone();
        let loops = self.loops();
        match slot {
            Slot::Coordinate(index) => format!("{q}[{}]", loops.display(index)),
            Slot::Momentum(index) => format!("{p}[{}]", loops.display(index)),
            Slot::Number(index) if index.terms.len() == 1 && index.constant == 0 => loops.display(index),
            Slot::Number(index) => format!("({})", loops.display(index)),
            Slot::Entry(table, indices) => {
                let name = loops.tables.get(*table as usize).map_or("", |table| table.name.as_str());
                let indices: Vec<String> =
                    indices.iter().map(|index| format!("[{}]", loops.display(index))).collect();
                format!("{name}{}", indices.concat())
            }
        }
    }

    /// `a op b` for integers of which at least one is not known; `None` where that is not such an operation.
    pub(super) fn index_operation(
        &mut self,
        a: &Value,
        operator: &BinOp,
        b: &Value,
        at: &dyn ToTokens,
    ) -> Option<Value> {
        self.sized.as_ref()?;
        let (a, b) = (self.as_index(a, at)?, self.as_index(b, at)?);
        let result = match operator {
            BinOp::Add(_) => a.add(&b),
            BinOp::Sub(_) => a.subtract(&b),
            BinOp::Mul(_) => a.multiply(&b),
            BinOp::Div(_) => a.divide(&b),
            BinOp::Rem(_) => {
                // What is known to be below the modulus wraps nowhere.
                let is_small = || {
                    let rest = b.subtract(&a)?.shifted(-1)?;
                    Some(self.is_nonnegative(&a) && self.is_nonnegative(&rest))
                };
                if is_small() == Some(true) { Some(a.clone()) } else { a.remainder(&b) }
            }
            _ => None,
        };
        Some(match result {
            Some(index) => index_value(index),
            None => self.report(expressions::integer_arithmetic(at.to_token_stream())),
        })
    }

    /// An integer as a real number.
    pub(super) fn index_as_real(&mut self, index: &Index) -> Expr {
        self.local(Slot::Number(index.clone()))
    }

    /// `a relation b` for integers that are not both known.
    pub(super) fn compare_indices(&mut self, operator: &BinOp, a: &Index, b: &Index) -> Option<Value> {
        let difference = a.subtract(b)?;
        let opposite = b.subtract(a)?;
        Some(match operator {
            BinOp::Lt(_) => self.is_less(&difference, false),
            BinOp::Le(_) => self.is_less(&difference, true),
            BinOp::Gt(_) => self.is_less(&opposite, false),
            BinOp::Ge(_) => self.is_less(&opposite, true),
            BinOp::Eq(_) => self.is_equal(&difference),
            BinOp::Ne(_) => match self.is_equal(&difference) {
                Value::Known(known) => Value::Known(!known),
                Value::Condition(condition) => Value::Condition(self.graph.not(condition)),
                other => other,
            },
            _ => return None,
        })
    }

    fn is_equal(&mut self, difference: &Index) -> Value {
        match self.is_less(difference, false) {
            Value::Known(true) => Value::Known(false),
            Value::Known(false) => self.is_less(difference, true),
            _ => {
                let (value, zero) = (self.index_as_real(difference), self.graph.integer(0));
                Value::Condition(self.graph.compare(Relation::Equal, value, zero))
            }
        }
    }

    /// `difference < 0`, or `<= 0` with `or_equal`: decided, or assumed in this part of the loop, or left to the
    /// running program.
    fn is_less(&mut self, difference: &Index, or_equal: bool) -> Value {
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
        let splits = |case: &Case| matches!(difference.slope(case.variable), Some(1 | -1));
        if let Some(case) = self.loops().cases.iter_mut().rev().find(|case| splits(case)) {
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
        let (value, zero) = (self.index_as_real(difference), self.graph.integer(0));
        let relation = if or_equal { Relation::LessEqual } else { Relation::Less };
        Value::Condition(self.graph.compare(relation, value, zero))
    }

    /// `Σ body(k)` for `k` in `0..length`, as one symbol for every part that its conditions split the loop into.
    pub(super) fn sum_loop(
        &mut self,
        length: &Index,
        body: &mut dyn FnMut(&mut Self, &Index) -> Option<Expr>,
    ) -> Option<Expr> {
        if is_short(length)
            && let Some(length) = length.as_integer()
        {
            let mut terms = Vec::new();
            for k in 0..length {
                terms.push((body(self, &Index::integer(k))?, Rational::ONE));
            }
            return Some(self.graph.linear_combination(&terms));
        }
        // The parts share a variable: they are loops beside each other.
        let variable = self.loops().variable();
        let whole = Loop { variable, start: Index::default(), end: length.clone() };
        let mut pending = vec![Vec::new()];
        let mut terms = Vec::new();
        while let Some(assumed) = pending.pop() {
            let loops = self.loops();
            loops.active.push(whole.clone());
            loops.cases.push(Case { variable, assumed, others: Vec::new() });
            let value = body(self, &Index::atom(Atom::Loop(variable)));
            let loops = self.loops();
            loops.active.pop();
            let case = loops.cases.pop()?;
            pending.extend(case.others);
            let value = value?;
            if pending.len() > MOST_CASES {
                return None;
            }
            let range = restrict(&whole, &case.assumed)?;
            let is_empty =
                range.end.subtract(&range.start).and_then(|d| d.as_integer()).is_some_and(|d| d <= 0);
            if self.graph.is_zero(value) || is_empty {
                continue;
            }
            let symbol = self.graph.new_symbol("Σ");
            self.loops().sums.push(Sum { symbol, range, body: value });
            terms.push((self.graph.symbol(symbol), Rational::ONE));
        }
        Some(self.graph.linear_combination(&terms))
    }
}

impl Index {
    /// `a - b` if it is a known integer.
    fn atom_free_difference(a: &Self, b: &Self) -> Option<i128> {
        a.subtract(b)?.as_integer()
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
