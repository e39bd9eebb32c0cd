//! Lists and iterators whose length only the running program knows. An iterator is not walked: its item is evaluated
//! once, at the variable of a loop, and a sum over it becomes a symbol for the sum.

use std::rc::Rc;

use quote::ToTokens;
use syn::ExprMethodCall;

use super::interpreter::Interpreter;
use super::value::{Sequence, Value};
use crate::diagnostics::expressions;
use crate::input::Kind;
use crate::model::index::Index;
use crate::symbolic::{Expr, Rational};

/// Lists of literal length up to this one are taken apart.
pub(super) const LONGEST_UNROLLED: i128 = 16;

/// Where the numbers of an [`Array`] are.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) enum Source {
    Coordinates,
    Momenta,
    /// A list of the struct, by its number among the tables, with what its elements are.
    Table(u32, Rc<Kind>),
}

/// A list, or a part of one.
#[derive(Clone, Debug)]
pub(super) struct Array {
    pub(super) source: Source,
    /// Indices so far. For the phase space one: the position in the state vector.
    pub(super) indices: Vec<Index>,
    /// Index of the first element.
    pub(super) start: Index,
    pub(super) length: Index,
    /// For the phase space: the lengths of the lists inside.
    pub(super) inner: Vec<i128>,
}

/// An iterator.
pub(super) enum Stream {
    /// `start..end`; without an end it only bounds others.
    Range(Index, Option<Index>),
    Array(Rc<Array>),
    /// A list of known values.
    Known(Sequence),
    Map(Rc<Stream>, Value),
    Zip(Rc<Stream>, Rc<Stream>),
    Enumerate(Rc<Stream>),
    Reversed(Rc<Stream>),
    Skip(Rc<Stream>, Index),
    Take(Rc<Stream>, Index),
    StepBy(Rc<Stream>, i128),
    Windows(Rc<Array>, i128),
    Chain(Rc<Stream>, Rc<Stream>),
    Filter(Rc<Stream>, Value),
    FlatMap(Rc<Stream>, Option<Value>),
}

const METHODS: [&str; 18] = [
    "iter",
    "into_iter",
    "map",
    "sum",
    "zip",
    "enumerate",
    "rev",
    "skip",
    "take",
    "step_by",
    "windows",
    "chain",
    "filter",
    "flat_map",
    "flatten",
    "fold",
    "collect",
    "len",
];

impl<'a> Interpreter<'a, '_> {
    /// `value` as a stream, if it is a list or an iterator that is not taken apart.
    pub(super) fn as_stream(&mut self, value: &Value) -> Option<Rc<Stream>> {
        match value {
            Value::Stream(stream) => Some(stream.clone()),
            Value::Array(array) if !is_short(&array.length) => Some(Stream::Array(array.clone()).into()),
            Value::Place(place) if self.sized.is_some() => match place.kind {
                Kind::List(_, len) if len.is_none_or(|len| len as i128 > LONGEST_UNROLLED) => {
                    let array = self.table(place)?;
                    Some(Stream::Array(array.into()).into())
                }
                _ => None,
            },
            _ => None,
        }
    }

    /// Any list or iterator as a stream: what is zipped or chained to one.
    fn partner(&mut self, value: &Value, at: &dyn ToTokens) -> Option<Rc<Stream>> {
        if let Some(stream) = self.as_stream(value) {
            return Some(stream);
        }
        match value {
            Value::Range(start, end) => {
                let (start, end) = (Index::integer(*start), end.map(Index::integer));
                Some(Stream::Range(start, end).into())
            }
            Value::Array(array) => Some(Stream::Array(array.clone()).into()),
            other => {
                let items = self.items(other, None, at)?;
                Some(Stream::Known(Sequence::new(items)).into())
            }
        }
    }

    /// A method of a list or iterator that is not taken apart; `None` if neither receiver nor argument is one.
    pub(super) fn stream_method(
        &mut self,
        receiver: &Value,
        arguments: &[Value],
        syntax: &'a ExprMethodCall,
    ) -> Option<Value> {
        self.sized.as_ref()?;
        let name = syntax.method.to_string();
        let joins = matches!(name.as_str(), "zip" | "chain");
        let stream = match self.as_stream(receiver) {
            Some(stream) => stream,
            None if joins && arguments.first().is_some_and(|other| self.as_stream(other).is_some()) => {
                self.partner(receiver, &syntax.receiver)?
            }
            None if name == "len" => {
                let Value::Array(array) = receiver else { return None };
                return Some(index_value(array.length.clone()));
            }
            None => return None,
        };
        Some(self.stream_value(&name, stream, receiver, arguments, syntax).unwrap_or(Value::Poison))
    }

    fn stream_value(
        &mut self,
        name: &str,
        stream: Rc<Stream>,
        receiver: &Value,
        arguments: &[Value],
        syntax: &'a ExprMethodCall,
    ) -> Option<Value> {
        let made = |stream: Stream| Some(Value::Stream(stream.into()));
        match (name, arguments) {
            (
                "iter" | "into_iter" | "copied" | "cloned" | "collect" | "to_vec" | "as_slice" | "clone",
                [],
            ) => Some(Value::Stream(stream)),
            ("len" | "count", []) => match self.length_of(&stream) {
                Some(length) => Some(index_value(length)),
                None => {
                    self.report(expressions::endless_range(&syntax.receiver));
                    None
                }
            },
            ("sum", []) => {
                let method = &syntax.method;
                let receiver = &*syntax.receiver;
                self.accumulate(&stream, method, &mut |this, item| this.real(item, receiver)).map(Value::Real)
            }
            ("fold", [start, function]) => self.fold_stream(&stream, start, function, syntax),
            ("map", [function]) => made(Stream::Map(stream, function.clone())),
            ("filter", [function]) => made(Stream::Filter(stream, function.clone())),
            ("flat_map", [function]) => made(Stream::FlatMap(stream, Some(function.clone()))),
            ("flatten", []) => made(Stream::FlatMap(stream, None)),
            ("enumerate", []) => made(Stream::Enumerate(stream)),
            ("rev", []) => made(Stream::Reversed(stream)),
            ("zip", [other]) => {
                let other = self.partner(other, &syntax.args)?;
                made(Stream::Zip(stream, other))
            }
            ("chain", [other]) => {
                let other = self.partner(other, &syntax.args)?;
                made(Stream::Chain(stream, other))
            }
            ("skip" | "take", [number]) => {
                let number = self.as_index(number, &syntax.args)?;
                made(if name == "skip" { Stream::Skip(stream, number) } else { Stream::Take(stream, number) })
            }
            ("step_by" | "windows", [number]) => {
                let number = self.known_integer(number.clone(), &syntax.args)?;
                if number < 1 || (name == "windows" && number > LONGEST_UNROLLED) {
                    self.report(expressions::integer_arithmetic(&syntax.args));
                    return None;
                }
                match (name, &*stream) {
                    ("windows", Stream::Array(array)) => made(Stream::Windows(array.clone(), number)),
                    ("windows", _) => {
                        let found = receiver.describe();
                        self.report(expressions::expected(&syntax.receiver, "a list", found));
                        None
                    }
                    _ => made(Stream::StepBy(stream, number)),
                }
            }
            (name, arguments) if METHODS.contains(&name) => {
                let expected = match name {
                    "map" | "zip" | "skip" | "take" | "step_by" | "windows" | "chain" | "filter"
                    | "flat_map" => 1,
                    "fold" => 2,
                    _ => 0,
                };
                self.report(expressions::argument_count(&syntax.method, expected, arguments.len()));
                None
            }
            _ => {
                self.report(expressions::unknown_method(
                    &syntax.method,
                    "lists and iterators whose length is known at run time",
                    &METHODS,
                ));
                None
            }
        }
    }

    /// Number of items, none if it is negative; `None` for an endless range and for what has to be walked.
    fn length_of(&self, stream: &Stream) -> Option<Index> {
        match stream {
            Stream::Range(start, end) => end.as_ref()?.subtract(start),
            Stream::Array(array) => Some(array.length.clone()),
            Stream::Known(sequence) => Some(Index::integer(sequence.items.len() as i128)),
            Stream::Map(inner, _) | Stream::Enumerate(inner) | Stream::Reversed(inner) => {
                self.length_of(inner)
            }
            Stream::Zip(a, b) => match (self.length_of(a), self.length_of(b)) {
                (Some(a), Some(b)) => Some(a.minimum(&b)),
                (one, other) => one.or(other),
            },
            Stream::Skip(inner, number) => self.length_of(inner)?.subtract(number),
            Stream::Take(inner, number) => match self.length_of(inner) {
                Some(length) => Some(length.minimum(number)),
                None => Some(number.clone()),
            },
            Stream::StepBy(inner, step) => {
                self.length_of(inner)?.shifted(step - 1)?.divide(&Index::integer(*step))
            }
            Stream::Windows(array, width) => array.length.shifted(1 - width),
            Stream::Chain(..) | Stream::Filter(..) | Stream::FlatMap(..) => None,
        }
    }

    /// Item `k` of a stream that can be indexed.
    pub(super) fn item(&mut self, stream: &Stream, k: &Index, at: &dyn ToTokens) -> Option<Value> {
        match stream {
            Stream::Range(start, _) => Some(index_value(start.add(k)?)),
            Stream::Array(array) => self.array_element(array, k, at),
            Stream::Known(sequence) => match k.as_integer().and_then(|k| usize::try_from(k).ok()) {
                Some(k) => sequence.items.get(k).cloned(),
                None => self.not_indexable(at),
            },
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
                Some(Value::tuple(vec![index_value(k.clone()), item]))
            }
            Stream::Reversed(inner) => {
                let Some(length) = self.length_of(inner) else { return self.not_indexable(at) };
                self.item(inner, &length.shifted(-1)?.subtract(k)?, at)
            }
            Stream::Skip(inner, number) => self.item(inner, &k.add(number)?, at),
            Stream::Take(inner, _) => self.item(inner, k, at),
            Stream::StepBy(inner, step) => self.item(inner, &k.multiply(&Index::integer(*step))?, at),
            Stream::Windows(array, width) => {
                let mut items = Vec::new();
                for offset in 0..*width {
                    items.push(self.array_element(array, &k.shifted(offset)?, at)?);
                }
                Some(Value::list(items))
            }
            Stream::Chain(..) | Stream::Filter(..) | Stream::FlatMap(..) => self.not_indexable(at),
        }
    }

    fn not_indexable<T>(&mut self, at: &dyn ToTokens) -> Option<T> {
        self.report(expressions::stream_not_indexable(at.to_token_stream()));
        None
    }

    /// `Σ f(item)` over the items, with a symbol for every loop.
    pub(super) fn accumulate(
        &mut self,
        stream: &Stream,
        at: &dyn ToTokens,
        f: &mut dyn FnMut(&mut Self, Value) -> Option<Expr>,
    ) -> Option<Expr> {
        match stream {
            Stream::Map(inner, function) if !is_indexable(inner) => {
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
                let list = match function {
                    Some(function) => this.apply(function, vec![item], at),
                    None => item,
                };
                this.accumulate_list(&list, at, f)
            }),
            // Known values are written out.
            Stream::Known(sequence) => {
                let mut terms = Vec::new();
                for item in sequence.items.iter() {
                    terms.push((f(self, item.clone())?, Rational::ONE));
                }
                Some(self.graph.linear_combination(&terms))
            }
            base => {
                let Some(length) = self.length_of(base) else { return self.not_indexable(at) };
                self.sum_loop(&length, &mut |this, k| {
                    let item = this.item(base, k, at)?;
                    f(this, item)
                })
            }
        }
    }

    /// `Σ f(item)` over any list.
    fn accumulate_list(
        &mut self,
        list: &Value,
        at: &dyn ToTokens,
        f: &mut dyn FnMut(&mut Self, Value) -> Option<Expr>,
    ) -> Option<Expr> {
        if let Some(stream) = self.as_stream(list) {
            return self.accumulate(&stream, at, f);
        }
        let mut terms = Vec::new();
        for item in self.items(list, None, at)? {
            terms.push((f(self, item)?, Rational::ONE));
        }
        Some(self.graph.linear_combination(&terms))
    }

    /// `fold(start, |total, x| total + ...)`: a sum written by hand.
    fn fold_stream(
        &mut self,
        stream: &Stream,
        start: &Value,
        function: &Value,
        syntax: &'a ExprMethodCall,
    ) -> Option<Value> {
        let start = self.real(start.clone(), &syntax.args)?;
        let placeholder = self.graph.new_symbol("");
        let total = self.graph.symbol(placeholder);
        let method = &syntax.method;
        let added = self.accumulate(stream, method, &mut |this, item| {
            let next = this.apply(function, vec![Value::Real(total), item], method);
            let next = this.real(next, method)?;
            let added = this.graph.subtract(next, total);
            if this.graph.depends_on(added, &[placeholder]) {
                this.report(expressions::no_sum(method));
                return None;
            }
            Some(added)
        })?;
        Some(Value::Real(self.graph.add(start, added)))
    }
}

/// Whether items can be named by their position.
fn is_indexable(stream: &Stream) -> bool {
    match stream {
        Stream::Range(..) | Stream::Array(_) | Stream::Windows(..) => true,
        Stream::Known(_) | Stream::Chain(..) | Stream::Filter(..) | Stream::FlatMap(..) => false,
        Stream::Map(inner, _)
        | Stream::Enumerate(inner)
        | Stream::Reversed(inner)
        | Stream::Skip(inner, _)
        | Stream::Take(inner, _)
        | Stream::StepBy(inner, _) => is_indexable(inner),
        Stream::Zip(a, b) => is_indexable(a) && is_indexable(b),
    }
}

pub(super) fn is_short(length: &Index) -> bool {
    length.as_integer().is_some_and(|length| length <= LONGEST_UNROLLED)
}

/// An integer value, known or not.
pub(super) fn index_value(index: Index) -> Value {
    match index.as_integer() {
        Some(known) => Value::Integer(known),
        None => Value::Index(index.into()),
    }
}
