//! Iterators over lists that are known: every adapter makes the next list.

use quote::ToTokens;
use syn::{ExprMethodCall, GenericArgument, Type};

use super::interpreter::Interpreter;
use super::streams::is_short;
use super::value::Value;
use crate::diagnostics::expressions;
use crate::input::{Kind, is_integer_type};
use crate::model::index::Index;

const METHODS: [&str; 26] = [
    "iter",
    "into_iter",
    "map",
    "sum",
    "product",
    "zip",
    "enumerate",
    "rev",
    "skip",
    "take",
    "step_by",
    "windows",
    "chunks",
    "chain",
    "filter",
    "flat_map",
    "flatten",
    "fold",
    "copied",
    "cloned",
    "len",
    "count",
    "collect",
    "to_vec",
    "clone",
    "as_slice",
];

impl<'a> Interpreter<'a, '_> {
    /// A method of a list, a range or an iterator.
    pub(super) fn sequence_method(
        &mut self,
        receiver: Value,
        arguments: Vec<Value>,
        syntax: &'a ExprMethodCall,
    ) -> Value {
        if let Some(value) = self.stream_method(&receiver, &arguments, syntax) {
            return value;
        }
        let name = syntax.method.to_string();
        if !METHODS.contains(&name.as_str()) {
            return self.report(expressions::unknown_method(&syntax.method, "lists and iterators", &METHODS));
        }
        let expected = match name.as_str() {
            "map" | "zip" | "skip" | "take" | "step_by" | "windows" | "chunks" | "chain" | "filter"
            | "flat_map" => 1,
            "fold" => 2,
            _ => 0,
        };
        if arguments.len() != expected {
            return self.report(expressions::argument_count(&syntax.method, expected, arguments.len()));
        }
        if let ("len", Value::Place(place)) = (name.as_str(), &receiver)
            && let Kind::List(_, None) = place.kind
        {
            return self.length(place);
        }
        let value = match name.as_str() {
            "skip" | "take" | "step_by" | "windows" | "chunks" => {
                self.cut(&name, receiver, &arguments[0], syntax)
            }
            "zip" | "chain" => self.join(&name, &receiver, &arguments[0], syntax),
            _ => self.consume(&name, &receiver, &arguments, syntax),
        };
        self.bounded(value, syntax)
    }

    /// The length of a list that only the running program knows.
    fn length(&mut self, place: &super::value::Place) -> Value {
        let tokens = &place.tokens;
        let tokens = if place.is_checked {
            quote::quote! { (|| ::core::option::Option::Some(#tokens.len()))().unwrap_or(0) }
        } else {
            quote::quote! { #tokens.len() }
        };
        let length = super::value::Place::new(format!("{}.len()", place.name), tokens, Kind::Integer);
        Value::Place(length.into())
    }

    /// The elements of a list, a range or an iterator, at most `limit` of them.
    pub(super) fn items(
        &mut self,
        value: &Value,
        limit: Option<usize>,
        at: &dyn ToTokens,
    ) -> Option<Vec<Value>> {
        let limit = limit.unwrap_or(usize::MAX);
        match value {
            Value::Poison => None,
            Value::List(sequence) | Value::Iterator(sequence) => {
                let count = sequence.items.len().min(limit);
                self.spend(count, at).then(|| sequence.items[..count].to_vec())
            }
            Value::Range(start, end) => {
                let count = match end {
                    Some(end) => {
                        usize::try_from(end.saturating_sub(*start).max(0)).unwrap_or(usize::MAX).min(limit)
                    }
                    None if limit < usize::MAX => limit,
                    None => {
                        self.report(expressions::endless_range(at.to_token_stream()));
                        return None;
                    }
                };
                let step = |i: usize| Value::Integer(start.saturating_add(i as i128));
                self.spend(count, at).then(|| (0..count).map(step).collect())
            }
            Value::Array(array) => match array.length.as_integer() {
                Some(length) if is_short(&array.length) => {
                    let count = usize::try_from(length).unwrap_or(0).min(limit);
                    let elements =
                        (0..count).map(|i| self.array_element(array, &Index::integer(i as i128), at));
                    elements.collect()
                }
                _ => {
                    self.report(expressions::stream_not_indexable(at.to_token_stream()));
                    None
                }
            },
            Value::Stream(_) => {
                self.report(expressions::stream_not_indexable(at.to_token_stream()));
                None
            }
            Value::Place(place) => match place.kind {
                Kind::List(_, Some(len)) => {
                    let count = len.min(limit);
                    if !self.spend(count, at) {
                        return None;
                    }
                    Some((0..count).map(|i| self.element(place, i as i128, at)).collect())
                }
                _ => {
                    self.report(expressions::list_of_unknown_length(at.to_token_stream()));
                    None
                }
            },
            other => {
                self.report(expressions::expected(
                    at.to_token_stream(),
                    "a list or a range",
                    other.describe(),
                ));
                None
            }
        }
    }

    /// `zip` and `chain`; the shorter of two zipped lists may bound an endless range.
    fn join(&mut self, name: &str, receiver: &Value, other: &Value, syntax: &'a ExprMethodCall) -> Value {
        let at = &syntax.args;
        let endless = |value: &Value| matches!(value, Value::Range(_, None));
        let limit = |items: &Option<Vec<Value>>| items.as_ref().map(Vec::len);
        let (left, right) = if name == "zip" && endless(receiver) {
            let right = self.items(other, None, at);
            (self.items(receiver, limit(&right).or(Some(0)), &syntax.receiver), right)
        } else {
            let left = self.items(receiver, None, &syntax.receiver);
            let bound = if name == "zip" { limit(&left).or(Some(0)) } else { None };
            (left, self.items(other, bound, at))
        };
        let (Some(mut left), Some(right)) = (left, right) else { return Value::Poison };
        if name == "chain" {
            left.extend(right);
            return Value::iterator(left);
        }
        Value::iterator(left.into_iter().zip(right).map(|(a, b)| Value::tuple(vec![a, b])).collect())
    }

    /// Adapters with a known number.
    fn cut(&mut self, name: &str, receiver: Value, argument: &Value, syntax: &'a ExprMethodCall) -> Value {
        let Some(number) = self.known_integer(argument.clone(), &syntax.args) else { return Value::Poison };
        let Ok(number) = usize::try_from(number) else {
            return self.report(expressions::integer_arithmetic(&syntax.args));
        };
        if number == 0 && matches!(name, "windows" | "chunks" | "step_by") {
            return self.report(expressions::integer_arithmetic(&syntax.args));
        }
        if let (Value::Range(start, None), "skip") = (&receiver, name) {
            return Value::Range(start.saturating_add(number as i128), None);
        }
        let limit = if name == "take" { Some(number) } else { None };
        let Some(items) = self.items(&receiver, limit, &syntax.receiver) else { return Value::Poison };
        let lists = match name {
            "skip" => return Value::iterator(items.into_iter().skip(number).collect()),
            "take" => return Value::iterator(items),
            "step_by" => return Value::iterator(items.into_iter().step_by(number).collect()),
            "chunks" => items.chunks(number).map(|chunk| Value::list(chunk.to_vec())).collect(),
            _ => {
                let copies = items.len().saturating_sub(number).saturating_add(1).saturating_mul(number);
                if number <= items.len() && !self.spend(copies, &syntax.method) {
                    return Value::Poison;
                }
                items.windows(number).map(|window| Value::list(window.to_vec())).collect()
            }
        };
        Value::iterator(lists)
    }

    /// Everything that reads the whole list.
    fn consume(
        &mut self,
        name: &str,
        receiver: &Value,
        arguments: &[Value],
        syntax: &'a ExprMethodCall,
    ) -> Value {
        let Some(items) = self.items(receiver, None, &syntax.receiver) else { return Value::Poison };
        match (name, arguments) {
            ("map", [function]) => {
                let mapped: Vec<_> =
                    items.into_iter().map(|item| self.apply(function, vec![item], &syntax.args)).collect();
                match receiver {
                    Value::List(_) | Value::Place(_) => Value::list(mapped),
                    _ => Value::iterator(mapped),
                }
            }
            ("flat_map", [function]) => {
                let lists =
                    items.into_iter().map(|item| self.apply(function, vec![item], &syntax.args)).collect();
                self.flatten(lists, syntax)
            }
            ("flatten", _) => self.flatten(items, syntax),
            ("filter", [predicate]) => self.filter(items, predicate, syntax),
            ("fold", [start, function]) => {
                let mut total = start.clone();
                for item in items {
                    if !self.charge_fold(&total, syntax) {
                        return Value::Poison;
                    }
                    total = self.apply(function, vec![total, item], &syntax.args);
                }
                total
            }
            ("sum" | "product", _) => self.total(name == "product", items, syntax),
            ("enumerate", _) => {
                let pair = |(i, item)| Value::tuple(vec![Value::Integer(i as i128), item]);
                Value::iterator(items.into_iter().enumerate().map(pair).collect())
            }
            ("rev", _) => Value::iterator(items.into_iter().rev().collect()),
            ("len" | "count", _) => Value::Integer(items.len() as i128),
            ("collect" | "to_vec" | "as_slice", _) => Value::list(items),
            ("clone", _) => receiver.clone(),
            _ => Value::iterator(items),
        }
    }

    /// Accumulating n terms one by one copies n² of them.
    fn charge_fold(&mut self, total: &Value, syntax: &ExprMethodCall) -> bool {
        match total {
            Value::Real(total) => {
                let size = self.graph.node(*total).operands().len();
                self.spend(size / 16, &syntax.method)
            }
            _ => true,
        }
    }

    fn flatten(&mut self, lists: Vec<Value>, syntax: &'a ExprMethodCall) -> Value {
        let mut all = Vec::new();
        for list in lists {
            match self.items(&list, None, syntax) {
                Some(items) => all.extend(items),
                None => return Value::Poison,
            }
        }
        Value::iterator(all)
    }

    fn filter(&mut self, items: Vec<Value>, predicate: &Value, syntax: &'a ExprMethodCall) -> Value {
        let mut kept = Vec::new();
        for item in items {
            match self.apply(predicate, vec![item.clone()], &syntax.args) {
                Value::Known(true) => kept.push(item),
                Value::Known(false) => {}
                Value::Poison => return Value::Poison,
                other => {
                    let found = other.describe();
                    let expected = "a condition that is known at compile time";
                    let error = expressions::expected(&syntax.args, expected, found);
                    return self.report(error);
                }
            }
        }
        Value::iterator(kept)
    }

    /// `sum` and `product`, of real numbers or of known integers.
    fn total(&mut self, product: bool, items: Vec<Value>, syntax: &'a ExprMethodCall) -> Value {
        let integers: Option<Vec<i128>> = items
            .iter()
            .map(|item| match item {
                Value::Integer(value) => Some(*value),
                _ => None,
            })
            .collect();
        if let Some(integers) = integers.filter(|integers| !integers.is_empty() || asks_for_integers(syntax))
        {
            let total = match product {
                true => integers.iter().try_fold(1i128, |total, value| total.checked_mul(*value)),
                false => integers.iter().try_fold(0i128, |total, value| total.checked_add(*value)),
            };
            return match total {
                Some(total) => Value::Integer(total),
                None => self.report(expressions::integer_arithmetic(&syntax.method)),
            };
        }
        let reals: Vec<_> = items.into_iter().map(|item| self.real(item, &syntax.receiver)).collect();
        let Some(reals) = reals.into_iter().collect::<Option<Vec<_>>>() else { return Value::Poison };
        Value::Real(if product { self.graph.product(&reals) } else { self.graph.sum(&reals) })
    }
}

/// `sum::<usize>()`
fn asks_for_integers(syntax: &ExprMethodCall) -> bool {
    let argument = syntax.turbofish.as_ref().and_then(|turbofish| turbofish.args.first());
    match argument {
        Some(GenericArgument::Type(Type::Path(path))) => {
            path.path.segments.last().is_some_and(|last| is_integer_type(&last.ident.to_string()))
        }
        _ => false,
    }
}
