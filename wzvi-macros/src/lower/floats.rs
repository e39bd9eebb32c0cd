//! The functions of `f64`, in method and in path form.

use proc_macro2::Span;
use quote::ToTokens;
use syn::Expr as Syntax;

use super::interpreter::Interpreter;
use super::value::Value;
use crate::diagnostics::expressions;
use crate::symbolic::{Expr, Function, Rational};

/// Functions that are made of others, and those with an integer argument.
const COMPOSED: [(&str, usize); 12] = [
    ("powi", 2),
    ("recip", 1),
    ("log", 2),
    ("sin_cos", 1),
    ("clamp", 3),
    ("mul_add", 3),
    ("to_radians", 1),
    ("to_degrees", 1),
    ("from", 1),
    ("clone", 1),
    ("to_owned", 1),
    ("add", 2),
];

/// Number of arguments, the receiver included.
fn arity(name: &str) -> Option<usize> {
    let elementary = Function::ALL.iter().find(|function| function.method() == name).map(|f| f.arity());
    elementary.or_else(|| COMPOSED.iter().find(|(known, _)| *known == name).map(|&(_, arity)| arity))
}

pub(crate) fn is_real_method(name: &str) -> bool {
    arity(name).is_some()
}

/// The method of `f64` that a name of a function means.
pub(super) fn meant_method(name: &str) -> Option<&str> {
    match name {
        "log" => Some("ln"),
        _ => expressions::synonym(name)
            .filter(|&meant| meant != "len")
            .or_else(|| is_real_method(name).then_some(name)),
    }
}

impl Interpreter<'_, '_> {
    /// `f64::name(arguments)`; `places` are the arguments' expressions, where there are any.
    pub(super) fn real_call(
        &mut self,
        name: &str,
        arguments: Vec<Value>,
        places: &[&Syntax],
        at: &dyn ToTokens,
    ) -> Value {
        let Some(arity) = arity(name) else {
            let names: Vec<&str> = Function::ALL.iter().map(|function| function.method()).collect();
            let names: Vec<&str> =
                names.into_iter().chain(COMPOSED[..8].iter().map(|&(name, _)| name)).collect();
            let method = syn::Ident::new(name, name_span(at));
            return self.report(expressions::unknown_method(&method, "`f64`", &names));
        };
        if arity != arguments.len() {
            let receiver = usize::from(places.len() == arguments.len() && is_method(at));
            let (arity, found) =
                (arity - receiver.min(arity), arguments.len() - receiver.min(arguments.len()));
            return self.report(expressions::argument_count(at.to_token_stream(), arity, found));
        }
        let place = |i: usize| -> &dyn ToTokens {
            match places.get(i) {
                Some(place) => place,
                None => at,
            }
        };
        match name {
            "from" => return self.number_as_real(&arguments[0], place(0)),
            "powi" => return self.integer_power(&arguments[0], &arguments[1], place(0), place(1)),
            _ => {}
        }
        let reals: Vec<_> =
            arguments.into_iter().enumerate().map(|(i, value)| self.real(value, place(i))).collect();
        match reals.into_iter().collect::<Option<Vec<Expr>>>() {
            Some(reals) => self.real_function(name, &reals),
            None => Value::Poison,
        }
    }

    fn real_function(&mut self, name: &str, arguments: &[Expr]) -> Value {
        if let Some(&function) = Function::ALL.iter().find(|function| function.method() == name) {
            return Value::Real(self.graph.apply(function, arguments));
        }
        let graph = &mut self.graph;
        Value::Real(match (name, arguments) {
            ("recip", &[x]) => graph.power(x, Rational::MINUS_ONE),
            ("log", &[x, base]) => {
                let (x, base) = (graph.apply(Function::Ln, &[x]), graph.apply(Function::Ln, &[base]));
                graph.divide(x, base)
            }
            ("sin_cos", &[x]) => {
                let (sine, cosine) = (graph.apply(Function::Sin, &[x]), graph.apply(Function::Cos, &[x]));
                return Value::tuple(vec![Value::Real(sine), Value::Real(cosine)]);
            }
            ("clamp", &[x, low, high]) => {
                let above = graph.apply(Function::Max, &[x, low]);
                graph.apply(Function::Min, &[above, high])
            }
            ("mul_add", &[x, a, b]) => {
                let product = graph.multiply(x, a);
                graph.add(product, b)
            }
            ("add", &[x, y]) => graph.add(x, y),
            ("to_radians", &[x]) => {
                let factor = graph.float(std::f64::consts::PI / 180.0);
                graph.multiply(x, factor)
            }
            ("to_degrees", &[x]) => {
                let factor = graph.float(180.0 / std::f64::consts::PI);
                graph.multiply(x, factor)
            }
            (_, arguments) => match arguments.first() {
                Some(&x) => x,
                None => return Value::Poison,
            },
        })
    }

    /// `f64::from(x)`
    fn number_as_real(&mut self, value: &Value, at: &dyn ToTokens) -> Value {
        match value {
            Value::Index(index) => Value::Real(self.index_as_real(index)),
            value => self.real(value.clone(), at).map_or(Value::Poison, Value::Real),
        }
    }

    /// `x.powi(n)`: exact for a known n, else a real power with the parameter n.
    fn integer_power(&mut self, x: &Value, n: &Value, x_at: &dyn ToTokens, n_at: &dyn ToTokens) -> Value {
        let x = self.real(x.clone(), x_at);
        let n = match n {
            Value::Constant(place) => {
                let n = self.parameter(&place.name, place.as_real());
                return x.map_or(Value::Poison, |x| Value::Real(self.graph.apply(Function::Powf, &[x, n])));
            }
            Value::Index(index) if index.as_integer().is_none() && index.loops().is_empty() => {
                let n = self.index_as_real(index);
                return x.map_or(Value::Poison, |x| Value::Real(self.graph.apply(Function::Powf, &[x, n])));
            }
            n => self.known_integer(n.clone(), n_at),
        };
        let (Some(x), Some(n)) = (x, n) else { return Value::Poison };
        match i32::try_from(n) {
            Ok(n) => Value::Real(self.graph.power(x, Rational::integer(n))),
            Err(_) => self.report(expressions::integer_arithmetic(n_at.to_token_stream())),
        }
    }
}

/// Whether `at` is the name of a method, and not a path to a function.
fn is_method(at: &dyn ToTokens) -> bool {
    syn::parse2::<syn::Ident>(at.to_token_stream()).is_ok()
}

/// The last token of a path names the function.
fn name_span(at: &dyn ToTokens) -> Span {
    at.to_token_stream().into_iter().last().map_or_else(Span::call_site, |token| token.span())
}
