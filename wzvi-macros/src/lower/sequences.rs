//! Lists, ranges and iterators: one kind of sequence. None is walked until something needs its items one by one: an item is
//! a function of its position, and a sum over a sequence becomes a loop.

use std::rc::Rc;

use quote::ToTokens;

use super::arrays::Array;
use super::interpreter::Interpreter;
use super::value::{Sequence, Value};
use crate::diagnostics::expressions;
use crate::model::index::Index;
use crate::symbolic::{Expr, Rational};

/// A list, a range, or what is left of an iterator.
pub(super) enum Stream {
    /// `start..end`; without an end it only bounds others.
    Range(Index, Option<Index>),
    /// What the state or the struct hold.
    Array(Rc<Array>),
    /// Values that were written one by one.
    Known(Sequence),
    Map(Rc<Stream>, Value),
    Zip(Rc<Stream>, Rc<Stream>),
    Enumerate(Rc<Stream>),
    Reversed(Rc<Stream>),
    Skip(Rc<Stream>, Index),
    Take(Rc<Stream>, Index),
    StepBy(Rc<Stream>, i128),
    Windows(Rc<Stream>, i128),
    Chunks(Rc<Stream>, i128),
    Chain(Rc<Stream>, Rc<Stream>),
    Filter(Rc<Stream>, Value),
    FlatMap(Rc<Stream>, Option<Value>),
}

impl Stream {
    /// Levels of sequences inside this one, itself included.
    pub(super) fn depth(&self) -> u32 {
        1 + match self {
            Self::Range(..) | Self::Array(_) => 0,
            Self::Known(sequence) => sequence.depth - 1,
            Self::Zip(a, b) | Self::Chain(a, b) => a.depth().max(b.depth()),
            Self::Map(inner, _)
            | Self::Enumerate(inner)
            | Self::Reversed(inner)
            | Self::Skip(inner, _)
            | Self::Take(inner, _)
            | Self::StepBy(inner, _)
            | Self::Windows(inner, _)
            | Self::Chunks(inner, _)
            | Self::Filter(inner, _)
            | Self::FlatMap(inner, _) => inner.depth(),
        }
    }

    pub(super) fn describe(&self) -> &'static str {
        match self {
            Self::Range(..) => "a range",
            Self::Array(_) | Self::Known(_) => "a list",
            _ => "an iterator",
        }
    }

    fn is_endless(&self) -> bool {
        match self {
            Self::Range(_, end) => end.is_none(),
            Self::Array(_) | Self::Known(_) | Self::Take(..) | Self::Reversed(_) => false,
            Self::Zip(a, b) => a.is_endless() && b.is_endless(),
            Self::Chain(a, b) => a.is_endless() || b.is_endless(),
            Self::Map(inner, _)
            | Self::Enumerate(inner)
            | Self::Skip(inner, _)
            | Self::StepBy(inner, _)
            | Self::Windows(inner, _)
            | Self::Chunks(inner, _)
            | Self::Filter(inner, _)
            | Self::FlatMap(inner, _) => inner.is_endless(),
        }
    }

    /// Whether its items can be named by their position.
    fn is_indexable(&self) -> bool {
        match self {
            Self::Range(..) | Self::Array(_) | Self::Known(_) => true,
            Self::Filter(..) | Self::FlatMap(..) => false,
            Self::Zip(a, b) | Self::Chain(a, b) => a.is_indexable() && b.is_indexable(),
            Self::Map(inner, _)
            | Self::Enumerate(inner)
            | Self::Reversed(inner)
            | Self::Skip(inner, _)
            | Self::Take(inner, _)
            | Self::StepBy(inner, _)
            | Self::Windows(inner, _)
            | Self::Chunks(inner, _) => inner.is_indexable(),
        }
    }
}

impl<'a> Interpreter<'a, '_> {
    /// `value` as a sequence.
    pub(super) fn as_stream(&mut self, value: &Value, at: &dyn ToTokens) -> Option<Rc<Stream>> {
        match value {
            Value::Stream(stream) => Some(stream.clone()),
            Value::Poison => None,
            other => {
                let found = other.describe();
                self.report(expressions::expected(at.to_token_stream(), "a list or a range", found));
                None
            }
        }
    }

    /// Number of items, none if it is negative; `None` for an endless range and for what has to be walked.
    pub(super) fn length_of(&self, stream: &Stream) -> Option<Index> {
        match stream {
            Stream::Range(start, end) => Some(end.as_ref()?.subtract(start)?.maximum_with_zero()),
            Stream::Array(array) => Some(array.length.clone()),
            Stream::Known(sequence) => Some(Index::integer(sequence.items.len() as i128)),
            Stream::Map(inner, _) | Stream::Enumerate(inner) | Stream::Reversed(inner) => {
                self.length_of(inner)
            }
            Stream::Zip(a, b) => match (self.length_of(a), self.length_of(b)) {
                (Some(a), Some(b)) => Some(a.minimum(&b)),
                (Some(length), None) if b.is_endless() => Some(length),
                (None, Some(length)) if a.is_endless() => Some(length),
                _ => None,
            },
            Stream::Skip(inner, number) => Some(self.length_of(inner)?.subtract(number)?.maximum_with_zero()),
            Stream::Take(inner, number) => match self.length_of(inner) {
                Some(length) => Some(length.minimum(number)),
                None => inner.is_endless().then(|| number.clone()),
            },
            Stream::StepBy(inner, step) => {
                self.length_of(inner)?.shifted(step - 1)?.divide(&Index::integer(*step))
            }
            Stream::Windows(inner, width) => {
                Some(self.length_of(inner)?.shifted(1 - width)?.maximum_with_zero())
            }
            Stream::Chunks(inner, width) => {
                self.length_of(inner)?.shifted(width - 1)?.divide(&Index::integer(*width))
            }
            Stream::Chain(a, b) => self.length_of(a)?.add(&self.length_of(b)?),
            Stream::Filter(..) | Stream::FlatMap(..) => None,
        }
    }

    /// Item `k`.
    pub(super) fn item(&mut self, stream: &Stream, k: &Index, at: &dyn ToTokens) -> Option<Value> {
        match stream {
            Stream::Range(start, _) => Some(Value::index(start.add(k)?)),
            Stream::Array(array) => self.array_element(array, k, at),
            Stream::Known(sequence) => {
                let k = self.known_integer(Value::index(k.clone()), at)?;
                match usize::try_from(k).ok().and_then(|k| sequence.items.get(k)) {
                    Some(item) => Some(item.clone()),
                    None => {
                        let length = sequence.items.len();
                        self.report(expressions::index_out_of_range(at.to_token_stream(), k, length));
                        None
                    }
                }
            }
            Stream::Map(inner, function) => {
                let item = self.item(inner, k, at)?;
                Some(self.apply(function, vec![item], at))
            }
            Stream::Zip(a, b) => {
                let (a, b) = (self.item(a, k, at)?, self.item(b, k, at)?);
                Some(Value::tuple(vec![a, b]))
            }
            Stream::Enumerate(inner) => {
                let item = self.item(inner, k, at)?;
                Some(Value::tuple(vec![Value::index(k.clone()), item]))
            }
            Stream::Reversed(inner) => {
                let Some(length) = self.length_of(inner) else { return self.item_of_many(stream, k, at) };
                self.item(inner, &length.shifted(-1)?.subtract(k)?, at)
            }
            Stream::Skip(inner, number) => self.item(inner, &k.add(number)?, at),
            Stream::Take(inner, _) => self.item(inner, k, at),
            Stream::StepBy(inner, step) => self.item(inner, &k.multiply(&Index::integer(*step))?, at),
            Stream::Windows(inner, width) => self.stretch(inner, k, &Index::integer(*width), at),
            Stream::Chunks(inner, width) => {
                let start = k.multiply(&Index::integer(*width))?;
                let rest = self.length_of(inner)?.subtract(&start)?;
                self.stretch(inner, &start, &rest.minimum(&Index::integer(*width)), at)
            }
            Stream::Chain(a, b) => {
                let Some(length) = self.length_of(a) else { return self.item_of_many(stream, k, at) };
                match self.is_less(&k.subtract(&length)?, false) {
                    Value::Known(true) => self.item(a, k, at),
                    Value::Known(false) => self.item(b, &k.subtract(&length)?, at),
                    _ => self.item_of_many(stream, k, at),
                }
            }
            Stream::Filter(..) | Stream::FlatMap(..) => self.item_of_many(stream, k, at),
        }
    }

    /// Item `k` of what has to be walked.
    fn item_of_many(&mut self, stream: &Stream, k: &Index, at: &dyn ToTokens) -> Option<Value> {
        let items = self.items(stream, None, at)?;
        self.item(&Stream::Known(Sequence::new(items)), k, at)
    }

    /// `length` items from `start` on, as a list.
    fn stretch(
        &mut self,
        stream: &Stream,
        start: &Index,
        length: &Index,
        at: &dyn ToTokens,
    ) -> Option<Value> {
        if let Stream::Array(array) = stream {
            return self.subarray(array, start, Some(&start.add(length)?), at);
        }
        let length = self.known_integer(Value::index(length.clone()), at)?;
        let mut items = Vec::new();
        for offset in 0..length {
            if !self.spend(1, at) {
                return None;
            }
            items.push(self.item(stream, &start.shifted(offset)?, at)?);
        }
        Some(Value::list(items))
    }

    /// The items one by one, at most `limit` of them.
    pub(super) fn items(
        &mut self,
        stream: &Stream,
        limit: Option<usize>,
        at: &dyn ToTokens,
    ) -> Option<Vec<Value>> {
        let most = limit.unwrap_or(usize::MAX);
        if let Stream::Known(sequence) = stream {
            let count = sequence.items.len().min(most);
            return self.spend(count, at).then(|| sequence.items[..count].to_vec());
        }
        if stream.is_endless() && limit.is_none() {
            self.report(expressions::endless_range(at.to_token_stream()));
            return None;
        }
        if stream.is_indexable() {
            let count = match self.length_of(stream) {
                Some(length) => self.known_length(&length, at)?,
                None => most,
            };
            let count = count.min(most);
            if !self.spend(count, at) {
                return None;
            }
            return (0..count).map(|k| self.item(stream, &Index::integer(k as i128), at)).collect();
        }
        self.walked(stream, limit, at).map(|mut items| {
            items.truncate(most);
            items
        })
    }

    /// The number of items that are taken one by one.
    fn known_length(&mut self, length: &Index, at: &dyn ToTokens) -> Option<usize> {
        if let Some(known) = length.as_integer() {
            return Some(usize::try_from(known).unwrap_or(0));
        }
        let depends = length.loops();
        if !self.request_turns(|variable| depends.contains(&variable)) {
            self.report(expressions::list_of_unknown_length(at.to_token_stream()));
        }
        None
    }

    /// The items of a sequence whose items have no positions.
    fn walked(&mut self, stream: &Stream, limit: Option<usize>, at: &dyn ToTokens) -> Option<Vec<Value>> {
        match stream {
            Stream::Filter(inner, predicate) => {
                let items = self.items(inner, None, at)?;
                let mut kept = Vec::new();
                for item in items {
                    if self.keeps(predicate, &item, at)? {
                        kept.push(item);
                    }
                }
                Some(kept)
            }
            Stream::FlatMap(inner, function) => {
                let mut all = Vec::new();
                for item in self.items(inner, None, at)? {
                    let list = self.mapped(function.as_ref(), item, at);
                    let list = self.as_stream(&list, at)?;
                    all.extend(self.items(&list, None, at)?);
                }
                Some(all)
            }
            Stream::Chain(a, b) => {
                let mut all = self.items(a, limit, at)?;
                all.extend(self.items(b, limit, at)?);
                Some(all)
            }
            // The shorter of two bounds an endless one.
            Stream::Zip(a, b) => {
                let (a, b) = match a.is_endless() {
                    true => {
                        let b = self.items(b, limit, at)?;
                        (self.items(a, Some(b.len()), at)?, b)
                    }
                    false => {
                        let a = self.items(a, limit, at)?;
                        let b = self.items(b, Some(a.len()), at)?;
                        (a, b)
                    }
                };
                Some(a.into_iter().zip(b).map(|(a, b)| Value::tuple(vec![a, b])).collect())
            }
            Stream::Map(inner, function) => {
                let items = self.items(inner, limit, at)?;
                Some(items.into_iter().map(|item| self.apply(function, vec![item], at)).collect())
            }
            Stream::Take(inner, number) => {
                let number = self.known_length(number, at)?.min(limit.unwrap_or(usize::MAX));
                self.items(inner, Some(number), at)
            }
            Stream::Enumerate(inner)
            | Stream::Reversed(inner)
            | Stream::Skip(inner, _)
            | Stream::StepBy(inner, _)
            | Stream::Windows(inner, _)
            | Stream::Chunks(inner, _) => {
                // With its items known, it has positions.
                let items = Rc::new(Stream::Known(Sequence::new(self.items(inner, None, at)?)));
                let stream = match stream {
                    Stream::Enumerate(_) => Stream::Enumerate(items),
                    Stream::Reversed(_) => Stream::Reversed(items),
                    Stream::Skip(_, number) => Stream::Skip(items, number.clone()),
                    Stream::StepBy(_, step) => Stream::StepBy(items, *step),
                    Stream::Windows(_, width) => Stream::Windows(items, *width),
                    Stream::Chunks(_, width) => Stream::Chunks(items, *width),
                    _ => return None,
                };
                self.items(&stream, limit, at)
            }
            Stream::Range(..) | Stream::Array(_) | Stream::Known(_) => self.items(stream, limit, at),
        }
    }

    fn mapped(&mut self, function: Option<&Value>, item: Value, at: &dyn ToTokens) -> Value {
        match function {
            Some(function) => self.apply(function, vec![item], at),
            None => item,
        }
    }

    /// Whether a filter keeps an item that stands by itself.
    fn keeps(&mut self, predicate: &Value, item: &Value, at: &dyn ToTokens) -> Option<bool> {
        match self.apply(predicate, vec![item.clone()], at) {
            Value::Known(keeps) => Some(keeps),
            Value::Poison => None,
            other => {
                let (found, expected) = (other.describe(), "a condition that is known at compile time");
                let written = match predicate {
                    Value::Closure(id) => {
                        self.closures.get(*id).map(|closure| closure.syntax.to_token_stream())
                    }
                    _ => None,
                };
                let at = written.unwrap_or_else(|| at.to_token_stream());
                self.report(expressions::expected(at, expected, found));
                None
            }
        }
    }

    /// `Σ f(item)`, with a symbol for every loop.
    pub(super) fn accumulate(
        &mut self,
        stream: &Stream,
        at: &dyn ToTokens,
        f: &mut dyn FnMut(&mut Self, Value) -> Option<Expr>,
    ) -> Option<Expr> {
        match stream {
            Stream::Map(inner, function) if !inner.is_indexable() => {
                self.accumulate(inner, at, &mut |this, item| {
                    let mapped = this.apply(function, vec![item], at);
                    f(this, mapped)
                })
            }
            Stream::Filter(inner, predicate) => self.accumulate(
                inner,
                at,
                &mut |this, item| match this.apply(predicate, vec![item.clone()], at) {
                    Value::Known(true) => f(this, item),
                    Value::Known(false) => Some(this.graph.integer(0)),
                    Value::Condition(condition) => {
                        let value = f(this, item)?;
                        let zero = this.graph.integer(0);
                        Some(this.graph.select(condition, value, zero))
                    }
                    Value::Poison => None,
                    other => {
                        let found = other.describe();
                        this.report(expressions::expected(at.to_token_stream(), "a condition", found));
                        None
                    }
                },
            ),
            Stream::Chain(a, b) => {
                let (a, b) = (self.accumulate(a, at, f)?, self.accumulate(b, at, f)?);
                Some(self.graph.add(a, b))
            }
            Stream::FlatMap(inner, function) => self.accumulate(inner, at, &mut |this, item| {
                let list = this.mapped(function.as_ref(), item, at);
                let list = this.as_stream(&list, at)?;
                this.accumulate(&list, at, f)
            }),
            base => {
                let length = match base {
                    // What was written one by one is added up one by one.
                    Stream::Known(_) => None,
                    base => self.length_of(base),
                };
                match length {
                    Some(length) => self.sum_loop(&length, at, &mut |this, k| {
                        let item = this.item(base, k, at)?;
                        f(this, item)
                    }),
                    None => self.add_up(base, at, f),
                }
            }
        }
    }

    /// `Σ f(item)`, term by term.
    fn add_up(
        &mut self,
        stream: &Stream,
        at: &dyn ToTokens,
        f: &mut dyn FnMut(&mut Self, Value) -> Option<Expr>,
    ) -> Option<Expr> {
        let mut terms = Vec::new();
        for item in self.items(stream, None, at)? {
            terms.push((f(self, item)?, Rational::ONE));
        }
        Some(self.graph.linear_combination(&terms))
    }
}

impl Index {
    /// A length: a known one is not negative, of another the loop sees to that.
    fn maximum_with_zero(self) -> Self {
        match self.as_integer() {
            Some(known) if known < 0 => Self::default(),
            _ => self,
        }
    }
}
