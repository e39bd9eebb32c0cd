//! Lists: indices into them, and ranges.

use quote::{ToTokens, quote};
use syn::{ExprIndex, RangeLimits};

use super::interpreter::Interpreter;
use super::streams::{Stream, is_short};
use super::value::{Place, Value};
use crate::diagnostics::expressions;
use crate::input::Kind;
use crate::model::index::Index;

impl<'a> Interpreter<'a, '_> {
    pub(super) fn index(&mut self, syntax: &'a ExprIndex) -> Value {
        let base = self.evaluate(&syntax.expr);
        let index = self.evaluate(&syntax.index);
        let at = &*syntax.index;
        match (base, index) {
            (Value::Poison, _) | (_, Value::Poison) => Value::Poison,
            (base @ (Value::Array(_) | Value::Stream(_)), index) => self.index_sized(&base, index, at),
            (Value::Place(place), index) if self.sized.is_some() && matches!(place.kind, Kind::List(..)) => {
                match self.table(&place) {
                    Some(array) => self.index_sized(&Value::Array(array.into()), index, at),
                    None => Value::Poison,
                }
            }
            (Value::List(list), Value::Range(start, end)) => {
                let len = list.items.len();
                let end = end.unwrap_or(len as i128);
                match (usize::try_from(start), usize::try_from(end)) {
                    (Ok(start), Ok(end)) if start <= end && end <= len => {
                        Value::list(list.items[start..end].to_vec())
                    }
                    _ => self.report(expressions::index_out_of_range(at, end, len)),
                }
            }
            (Value::List(list), index) => match self.known_integer(index, at) {
                Some(i) => match usize::try_from(i).ok().and_then(|i| list.items.get(i)) {
                    Some(item) => item.clone(),
                    None => self.report(expressions::index_out_of_range(at, i, list.items.len())),
                },
                None => Value::Poison,
            },
            (Value::Place(place), index) => self.index_place(&place, index, syntax),
            (base, _) => self.report(expressions::expected(&syntax.expr, "a list", base.describe())),
        }
    }

    /// An element, or a range of them, of what is not taken apart.
    fn index_sized(&mut self, base: &Value, index: Value, at: &syn::Expr) -> Value {
        let found = match (base, &index) {
            (Value::Array(array), Value::Range(start, end)) => {
                let (start, end) = (Index::integer(*start), end.map(Index::integer));
                self.subarray(array, &start, end.as_ref(), at)
            }
            (Value::Array(array), Value::Stream(stream)) => match &**stream {
                Stream::Range(start, end) => self.subarray(array, start, end.as_ref(), at),
                _ => {
                    let found = index.describe();
                    return self.report(expressions::expected(at, "an integer or a range", found));
                }
            },
            (Value::Array(array), index) => match self.as_index(index, at) {
                Some(k) => self.array_element(array, &k, at),
                None => None,
            },
            (Value::Stream(stream), index) => match self.as_index(index, at) {
                Some(k) => self.item(&stream.clone(), &k, at),
                None => None,
            },
            _ => None,
        };
        found.unwrap_or(Value::Poison)
    }

    fn index_place(&mut self, place: &Place, index: Value, syntax: &ExprIndex) -> Value {
        if !matches!(place.kind, Kind::List(..) | Kind::Constant) {
            return self.report(expressions::expected(&syntax.expr, "a list", "an integer"));
        }
        match self.known_integer(index, &syntax.index) {
            Some(i) => self.element(place, i, &syntax.index),
            None => Value::Poison,
        }
    }

    /// Element `i` of a list that the struct or a constant holds.
    pub(super) fn element(&mut self, place: &Place, i: i128, at: &dyn ToTokens) -> Value {
        let (kind, len) = match &place.kind {
            Kind::List(element, len) => ((**element).clone(), *len),
            _ => (Kind::Constant, None),
        };
        let Ok(i) = usize::try_from(i) else {
            return self.report(expressions::index_out_of_range(at.to_token_stream(), i, len.unwrap_or(0)));
        };
        if let Some(len) = len.filter(|&len| i >= len) {
            return self.report(expressions::index_out_of_range(at.to_token_stream(), i as i128, len));
        }
        let tokens = &place.tokens;
        let literal = proc_macro2::Literal::usize_unsuffixed(i);
        // The length of a `Vec` is known at run time only: an element that is not there must not panic.
        let is_checked = place.is_checked || (len.is_none() && matches!(place.kind, Kind::List(..)));
        let tokens = if is_checked {
            quote! { #tokens.get(#literal)? }
        } else {
            quote! { #tokens[#literal] }
        };
        let element = Place { name: format!("{}[{i}]", place.name), tokens, kind, is_checked };
        self.place(element, at)
    }

    pub(super) fn range(&mut self, syntax: &'a syn::ExprRange) -> Value {
        if self.sized.is_some() {
            return self.sized_range(syntax).unwrap_or(Value::Poison);
        }
        let start = match &syntax.start {
            Some(start) => {
                let value = self.evaluate(start);
                self.known_integer(value, start)
            }
            None => Some(0),
        };
        let end = match &syntax.end {
            Some(end) => {
                let value = self.evaluate(end);
                let inclusive = i128::from(matches!(syntax.limits, RangeLimits::Closed(_)));
                self.known_integer(value, end).map(|end| Some(end.saturating_add(inclusive)))
            }
            None => Some(None),
        };
        match (start, end) {
            (Some(start), Some(end)) => Value::Range(start, end),
            _ => Value::Poison,
        }
    }

    /// A range that may be long, or as long as only the running program knows: it is not taken apart.
    fn sized_range(&mut self, syntax: &'a syn::ExprRange) -> Option<Value> {
        let start = match &syntax.start {
            Some(start) => {
                let value = self.evaluate(start);
                self.as_index(&value, start)
            }
            None => Some(Index::default()),
        };
        let end = match &syntax.end {
            Some(end) => {
                let value = self.evaluate(end);
                let inclusive = i128::from(matches!(syntax.limits, RangeLimits::Closed(_)));
                Some(self.as_index(&value, end)?.shifted(inclusive)?)
            }
            None => None,
        };
        let start = start?;
        let known = start.as_integer().zip(end.as_ref().map_or(Some(None), |end| end.as_integer().map(Some)));
        let length = end.as_ref().and_then(|end| end.subtract(&start));
        Some(match known {
            Some((start, end)) if length.is_none_or(|length| is_short(&length)) => Value::Range(start, end),
            _ => Value::Stream(Stream::Range(start, end).into()),
        })
    }
}
