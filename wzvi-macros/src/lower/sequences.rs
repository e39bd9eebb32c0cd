//! Lists, ranges and iterators: a length, and a closure for the item at a position. A sequence is enumerated
//! only if its items are needed one by one; a sum over one becomes a loop. Tests: `tests/steps/values.rs`,
//! `tests/loops/ranges.rs`.

use std::rc::Rc;

use quote::ToTokens;

use super::arrays::Array;
use super::interpreter::Interpreter;
use super::value::{Items, Value};
use crate::diagnostics::expressions;
use crate::model::Index;
use crate::symbolic::{Expr, Rational};

/// The item at a position.
type ItemAt = Box<dyn for<'a, 'd> Fn(&mut Interpreter<'a, 'd>, &Index, &dyn ToTokens) -> Option<Value>>;

/// The term of an item.
type ItemTerm<'f, I> = &'f mut dyn FnMut(&mut I, Value) -> Option<Expr>;

/// A list, a range, or an iterator.
pub(super) struct Sequence {
    pub(super) source: Source,
    /// The number of items; `None` if they have no end, or no positions.
    pub(super) length: Option<Index>,
    /// `None` if the position of an item depends on those before it.
    item: Option<ItemAt>,
    /// Levels of sequences inside this one, itself included.
    pub(super) depth: u32,
}

/// The origin of the items.
pub(super) enum Source {
    /// `start..end`; without an end it only bounds others.
    Range(Index, Option<Index>),
    /// A list in the state or the struct.
    Array(Rc<Array>),
    /// Values listed individually.
    Known(Items),
    /// Items of other sequences, by position.
    Positions,
    Chain(Rc<Sequence>, Rc<Sequence>),
    Filter(Rc<Sequence>, Value),
    /// The concatenated results of a function of each item, or the concatenated items.
    Flat(Rc<Sequence>, Option<Value>),
    /// A function of items that have no positions.
    Map(Rc<Sequence>, Value),
}

impl Sequence {
    fn new(
        source: Source,
        depth: u32,
        length: Option<Index>,
        item: impl for<'a, 'd> Fn(&mut Interpreter<'a, 'd>, &Index, &dyn ToTokens) -> Option<Value> + 'static,
    ) -> Self {
        // A known length is clamped to zero; otherwise the loop ensures that.
        let is_negative = length.as_ref().and_then(Index::as_integer).is_some_and(|length| length < 0);
        let length = if is_negative { Some(Index::default()) } else { length };
        Self { source, length, item: Some(Box::new(item)), depth }
    }

    /// `None` if its length overflows.
    pub(super) fn range(start: Index, end: Option<Index>, is_unsigned: bool) -> Option<Self> {
        let length = if let Some(end) = &end { Some(end.subtract(&start)?) } else { None };
        let source = Source::Range(start.clone(), end);
        let item = move |k: &Index| Some(Value::index(start.add(k)?).unsigned(is_unsigned));
        Some(Self::new(source, 1, length, move |_, k, _| item(k)))
    }

    pub(super) fn array(array: Array) -> Self {
        let (length, array) = (Some(array.length.clone()), Rc::new(array));
        let source = Source::Array(array.clone());
        Self::new(source, 1, length, move |this, k, at| this.array_element(&array, k, at))
    }

    pub(super) fn known(items: Vec<Value>) -> Self {
        let (count, items) = (items.len(), Items::new(items));
        let (source, depth) = (Source::Known(items.clone()), items.depth);
        Self::new(source, depth, Some(Index::integer(count as i128)), move |this, k, at| {
            let k = this.known_integer(Value::index(k.clone()), at)?;
            let item = usize::try_from(k).ok().and_then(|k| items.items.get(k));
            if item.is_none() {
                this.report(expressions::index_out_of_range(at, k, count));
            }
            item.cloned()
        })
    }

    /// A sequence that has to be enumerated.
    fn enumerated(source: Source, depth: u32) -> Self {
        Self { source, length: None, item: None, depth }
    }

    /// The items of `inner` at other positions.
    fn moved(
        inner: Rc<Self>,
        length: Option<Index>,
        position: impl Fn(&Index) -> Option<Index> + 'static,
    ) -> Self {
        let depth = inner.depth + 1;
        Self::new(Source::Positions, depth, length, move |this, k, at| this.item(&inner, &position(k)?, at))
    }

    /// Lists of adjacent items, by start and length.
    fn slices(
        inner: Rc<Self>,
        length: Option<Index>,
        stretch: impl Fn(&Index) -> Option<(Index, Index)> + 'static,
    ) -> Self {
        let depth = inner.depth + 1;
        Self::new(Source::Positions, depth, length, move |this, k, at| {
            let (start, length) = stretch(k)?;
            this.slice(&inner, &start, &length, at)
        })
    }

    /// The results of a function of each item.
    fn mapped(inner: Rc<Self>, function: Value) -> Self {
        let depth = inner.depth + 1;
        if inner.item.is_none() {
            return Self::enumerated(Source::Map(inner, function), depth);
        }
        Self::new(Source::Positions, depth, inner.length.clone(), move |this, k, at| {
            let item = this.item(&inner, k, at)?;
            Some(this.apply(&function, vec![item], at).unwrap_or_default())
        })
    }

    fn zipped(a: Rc<Self>, b: Rc<Self>) -> Self {
        let length = match (&a.length, &b.length) {
            (Some(a), Some(b)) => Some(a.minimum(b)),
            (a, b) => a.clone().or(b.clone()),
        };
        let depth = a.depth.max(b.depth) + 1;
        Self::new(Source::Positions, depth, length, move |this, k, at| {
            Some(Value::tuple(vec![this.item(&a, k, at)?, this.item(&b, k, at)?]))
        })
    }

    /// Concatenation: two sums, and, if both have positions, one list.
    fn chained(this: &Interpreter<'_, '_>, a: Rc<Self>, b: Rc<Self>) -> Self {
        let (source, depth) = (Source::Chain(a.clone(), b.clone()), a.depth.max(b.depth) + 1);
        let (Some(_), Some(_), Some(first)) = (&a.item, &b.item, this.length(&a)) else {
            return Self::enumerated(source, depth);
        };
        let length = this.length(&b).and_then(|second| first.add(&second));
        Self::new(source, depth, length, move |this, k, at| {
            let rest = k.subtract(&first)?;
            match this.is_less(&rest, false) {
                Value::Known(true) => this.item(&a, k, at),
                Value::Known(false) => this.item(&b, &rest, at),
                _ => {
                    let items = [this.items(&a, at)?, this.items(&b, at)?].concat();
                    this.item(&Self::known(items), k, at)
                }
            }
        })
    }

    pub(super) fn is_list(&self) -> bool {
        matches!(self.source, Source::Array(_) | Source::Known(_))
    }

    pub(super) fn describe(&self) -> &'static str {
        match self.source {
            Source::Range(..) => "a range",
            _ if self.is_list() => "a list",
            _ => "an iterator",
        }
    }
}

impl<'a> Interpreter<'a, '_> {
    /// `value` as a sequence.
    pub(super) fn as_sequence(&mut self, value: &Value, at: &dyn ToTokens) -> Option<Rc<Sequence>> {
        match value {
            Value::Sequence(sequence) => Some(sequence.clone()),
            Value::Poison => None,
            other => self.mismatch(at, "a list or a range", other),
        }
    }

    /// The number of items as a value, which is not negative. (A loop over a negative number of items ends at
    /// once.)
    pub(super) fn length(&self, sequence: &Sequence) -> Option<Index> {
        let length = sequence.length.as_ref()?;
        let is_natural = sequence.is_list() || self.is_nonnegative(length);
        Some(if is_natural { length.clone() } else { length.maximum(&Index::default()) })
    }

    /// The sequence made by a method with an optional argument, at `at`; `from` is the place of the original
    /// sequence.
    pub(super) fn adapted(
        &mut self,
        name: &str,
        inner: Rc<Sequence>,
        argument: &Value,
        from: &dyn ToTokens,
        at: &dyn ToTokens,
    ) -> Option<Sequence> {
        let depth = inner.depth + 1;
        match name {
            "map" => return Some(Sequence::mapped(inner, argument.clone())),
            "filter" => return Some(Sequence::enumerated(Source::Filter(inner, argument.clone()), depth)),
            "flat_map" => {
                return Some(Sequence::enumerated(Source::Flat(inner, Some(argument.clone())), depth));
            }
            "flatten" => return Some(Sequence::enumerated(Source::Flat(inner, None), depth)),
            "chain" => return self.as_sequence(argument, at).map(|b| Sequence::chained(self, inner, b)),
            _ => {}
        }
        let inner = self.positioned(inner, from)?;
        let length = inner.length.clone();
        let number = match name {
            "enumerate" => {
                return Some(Sequence::zipped(Sequence::range(Index::default(), None, true)?.into(), inner));
            }
            "zip" => {
                let other = self.as_sequence(argument, at)?;
                return Some(Sequence::zipped(inner, self.positioned(other, at)?));
            }
            "rev" => {
                let Some(end) = &length else { return self.endless(from) };
                let last = end.shifted(-1)?;
                return Some(Sequence::moved(inner, length, move |k| last.subtract(k)));
            }
            "skip" | "take" => self.checked_index(argument, at)?,
            _ => Index::integer(self.known_integer(argument.clone(), at)?),
        };
        let least = i128::from(!matches!(name, "skip" | "take"));
        if number.as_integer().is_some_and(|number| number < least) {
            return self.refuse(expressions::integer_arithmetic(at));
        }
        let last = number.shifted(-1)?;
        // The last part may be shorter.
        let parts = length.as_ref().and_then(|length| length.add(&last)?.divide(&number));
        Some(match name {
            "skip" => {
                let length = length.and_then(|length| length.subtract(&number));
                Sequence::moved(inner, length, move |k| k.add(&number))
            }
            "take" => {
                let length = length.map_or(number.clone(), |length| length.minimum(&number));
                Sequence::moved(inner, Some(length), |k| Some(k.clone()))
            }
            "step_by" => Sequence::moved(inner, parts, move |k| k.multiply(&number)),
            "windows" => {
                let length = length.and_then(|length| length.subtract(&last));
                Sequence::slices(inner, length, move |k| Some((k.clone(), number.clone())))
            }
            _ => Sequence::slices(inner, parts, move |k| {
                let start = k.multiply(&number)?;
                let rest = length.as_ref()?.subtract(&start)?;
                Some((start, rest.minimum(&number)))
            }),
        })
    }

    /// The sequence with positions: enumerated, if it has none.
    fn positioned(&mut self, sequence: Rc<Sequence>, at: &dyn ToTokens) -> Option<Rc<Sequence>> {
        match sequence.item {
            Some(_) => Some(sequence),
            None => Some(Sequence::known(self.items(&sequence, at)?).into()),
        }
    }

    /// Item `k`.
    pub(super) fn item(&mut self, sequence: &Sequence, k: &Index, at: &dyn ToTokens) -> Option<Value> {
        match &sequence.item {
            Some(item) => item(self, k, at),
            None => {
                let items = self.items(sequence, at)?;
                self.item(&Sequence::known(items), k, at)
            }
        }
    }

    /// `length` items from `start` on, as a list.
    fn slice(
        &mut self,
        sequence: &Sequence,
        start: &Index,
        length: &Index,
        at: &dyn ToTokens,
    ) -> Option<Value> {
        if let Source::Array(array) = &sequence.source {
            return self.subarray(array, start, Some(&start.add(length)?), at);
        }
        let length = self.known_integer(Value::index(length.clone()), at)?;
        let mut items = Vec::new();
        for offset in 0..length {
            if !self.spend(1, at) {
                return None;
            }
            items.push(self.item(sequence, &start.shifted(offset)?, at)?);
        }
        Some(Value::list(items))
    }

    /// The items one by one.
    pub(super) fn items(&mut self, sequence: &Sequence, at: &dyn ToTokens) -> Option<Vec<Value>> {
        if let Source::Known(Items { items, .. }) = &sequence.source {
            return self.spend(items.len(), at).then(|| items.to_vec());
        }
        if sequence.item.is_none() {
            let mut all = Vec::new();
            self.sum_over(sequence, true, at, &mut |this, item| {
                all.push(item);
                Some(this.graph.integer(0))
            })?;
            return Some(all);
        }
        let Some(length) = &sequence.length else { return self.endless(at) };
        let count = self.known_length(length, at)?;
        if !self.spend(count, at) {
            return None;
        }
        (0..count).map(|k| self.item(sequence, &Index::integer(k as i128), at)).collect()
    }

    fn endless<T>(&mut self, at: &dyn ToTokens) -> Option<T> {
        self.refuse(expressions::endless_range(at))
    }

    /// The number of items that are taken one by one.
    fn known_length(&mut self, length: &Index, at: &dyn ToTokens) -> Option<usize> {
        if let Some(known) = length.as_integer() {
            return Some(usize::try_from(known).unwrap_or(0));
        }
        if !self.request_unrolling_of(length) {
            self.report(expressions::list_of_unknown_length(at));
        }
        None
    }

    /// `Σ f(item)`, with a symbol for every loop; with `one_by_one` there is no loop, and filter conditions
    /// must be known.
    pub(super) fn sum_over(
        &mut self,
        sequence: &Sequence,
        one_by_one: bool,
        at: &dyn ToTokens,
        f: ItemTerm<'_, Self>,
    ) -> Option<Expr> {
        match &sequence.source {
            Source::Map(inner, function) => self.sum_over(inner, one_by_one, at, &mut |this, item| {
                let mapped = this.apply(function, vec![item], at).unwrap_or_default();
                f(this, mapped)
            }),
            Source::Filter(inner, predicate) => self.sum_over(inner, one_by_one, at, &mut |this, item| {
                let zero = this.graph.integer(0);
                match this.apply(predicate, vec![item.clone()], at)? {
                    Value::Known(true) => f(this, item),
                    Value::Known(false) => Some(zero),
                    Value::Condition(condition) if !one_by_one => {
                        this.now.branch += 1;
                        let value = f(this, item);
                        this.now.branch -= 1;
                        Some(this.graph.select(condition, value?, zero))
                    }
                    other => this.no_condition(predicate, &other, one_by_one, at),
                }
            }),
            Source::Flat(inner, function) => self.sum_over(inner, one_by_one, at, &mut |this, item| {
                let list = match function {
                    Some(function) => this.apply(function, vec![item], at)?,
                    None => item,
                };
                let list = this.as_sequence(&list, at)?;
                this.sum_over(&list, one_by_one, at, f)
            }),
            Source::Chain(a, b) => {
                let (a, b) = (self.sum_over(a, one_by_one, at, f)?, self.sum_over(b, one_by_one, at, f)?);
                Some(self.graph.add(a, b))
            }
            Source::Range(..) | Source::Array(_) | Source::Positions => match &sequence.length {
                Some(length) if !one_by_one => self.sum_loop(length, at, &mut |this, k| {
                    let item = this.item(sequence, k, at)?;
                    f(this, item)
                }),
                Some(_) | None => self.sum_of_items(sequence, at, f),
            },
            Source::Known(_) => self.sum_of_items(sequence, at, f),
        }
    }

    /// `Σ f(item)` over items known one by one.
    fn sum_of_items(
        &mut self,
        sequence: &Sequence,
        at: &dyn ToTokens,
        f: ItemTerm<'_, Self>,
    ) -> Option<Expr> {
        let mut terms = Vec::new();
        for item in self.items(sequence, at)? {
            terms.push((f(self, item)?, Rational::ONE));
        }
        Some(self.graph.linear_combination(&terms))
    }

    /// Reports a filter whose result is not a condition, or not a known one.
    fn no_condition<T>(
        &mut self,
        predicate: &Value,
        found: &Value,
        is_known: bool,
        at: &dyn ToTokens,
    ) -> Option<T> {
        let written = match predicate {
            Value::Closure(id) if is_known => {
                self.now.closures.get(*id).map(|closure| closure.syntax.to_token_stream())
            }
            _ => None,
        };
        let at = written.unwrap_or_else(|| at.to_token_stream());
        let expected = if is_known { "a condition that is known at compile time" } else { "a condition" };
        self.mismatch(&at, expected, found)
    }
}
