//! The functions of `f64`, in method and in path form. Tests: `tests/steps/values.rs`.

use quote::ToTokens;
use syn::Expr as Syntax;

use super::interpreter::Interpreter;
use super::value::Value;
use crate::diagnostics::expressions;
use crate::symbolic::{Expr, Function, Graph, NAMES, Rational, Special};

/// The definition of a function in terms of others.
type Composed = fn(&mut Graph, &[Expr]) -> Expr;

/// The functions defined in terms of others, with their numbers of arguments. [`Interpreter::real_call`]
/// reads the functions with `None`.
const COMPOSED: [(&str, usize, Option<Composed>); 12] = [
    ("powi", 2, None),
    ("recip", 1, Some(|graph, x| graph.power(x[0], Rational::MINUS_ONE))),
    ("log", 2, Some(logarithm)),
    ("sin_cos", 1, None),
    ("clamp", 3, Some(clamped)),
    ("mul_add", 3, Some(fused)),
    ("to_radians", 1, Some(|graph, x| scaled(graph, x, std::f64::consts::PI / 180.0))),
    ("to_degrees", 1, Some(|graph, x| scaled(graph, x, 180.0 / std::f64::consts::PI))),
    ("from", 1, None),
    ("clone", 1, Some(|_, x| x[0])),
    ("to_owned", 1, Some(|_, x| x[0])),
    ("add", 2, Some(|graph, x| graph.add(x[0], x[1]))),
];

fn logarithm(graph: &mut Graph, x: &[Expr]) -> Expr {
    let [x, base] = [x[0], x[1]].map(|x| graph.apply(Function::Ln, &[x]));
    graph.divide(x, base)
}

fn clamped(graph: &mut Graph, x: &[Expr]) -> Expr {
    let above = graph.apply(Function::Max, &x[..2]);
    graph.apply(Function::Min, &[above, x[2]])
}

/// `x y + z`
fn fused(graph: &mut Graph, x: &[Expr]) -> Expr {
    let product = graph.multiply(x[0], x[1]);
    graph.add(product, x[2])
}

fn scaled(graph: &mut Graph, x: &[Expr], factor: f64) -> Expr {
    let factor = graph.float(factor);
    graph.multiply(x[0], factor)
}

/// Number of arguments, the receiver included.
fn arity(name: &str) -> Option<usize> {
    let elementary = Function::ALL.iter().find(|function| function.method() == name).map(|f| f.arity());
    let known = elementary.or_else(|| Special::named(name).map(|_| 1));
    known.or_else(|| COMPOSED.iter().find(|(known, ..)| *known == name).map(|(_, arity, _)| *arity))
}

/// Whether `f64` has a method of this name. It has no `erf`, which users import.
pub(crate) fn is_real_method(name: &str) -> bool {
    arity(name).is_some() && Special::named(name).is_none()
}

/// The method of `f64` with this name.
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
    ) -> Option<Value> {
        let Some(arity) = arity(name) else {
            let elementary = Function::ALL.iter().map(|function| function.method());
            let special = NAMES.iter().map(|&(name, ..)| name);
            let composed = COMPOSED[..8].iter().map(|&(name, ..)| name);
            let names: Vec<&str> = elementary.chain(special).chain(composed).collect();
            // The last token of a path names the function.
            let method = at.to_token_stream().into_iter().last();
            return self.refuse(expressions::unknown_method(method, name, "`f64`", &names));
        };
        if arity != arguments.len() {
            let receiver = usize::from(places.len() == arguments.len() && is_method(at));
            let (arity, found) =
                (arity - receiver.min(arity), arguments.len() - receiver.min(arguments.len()));
            return self.refuse(expressions::argument_count(at, arity, found));
        }
        let place = |i: usize| -> &dyn ToTokens { places.get(i).map_or(at, |place| place) };
        match (name, arguments.as_slice()) {
            ("from", [value]) => return self.cast_to_real(value.clone(), place(0)).map(Value::Real),
            ("powi", [x, n]) => return self.integer_power(x, n, place(0), place(1)),
            _ => {}
        }
        let reals: Vec<_> =
            arguments.into_iter().enumerate().map(|(i, value)| self.real(value, place(i))).collect();
        let reals = reals.into_iter().collect::<Option<Vec<Expr>>>()?;
        if let Some(&function) = Function::ALL.iter().find(|function| function.method() == name) {
            return Some(Value::Real(self.graph.apply(function, &reals)));
        }
        if let Some((power, function)) = Special::named(name) {
            let value = self.graph.apply(Function::Special(function), &reals);
            let power = self.graph.power(reals[0], Rational::integer(power));
            return Some(Value::Real(self.graph.multiply(power, value)));
        }
        let composed = COMPOSED.iter().find(|(known, ..)| *known == name);
        Some(match composed.and_then(|(.., composed)| *composed) {
            Some(composed) => Value::Real(composed(&mut self.graph, &reals)),
            None => Value::tuple(
                [Function::Sin, Function::Cos].map(|f| Value::Real(self.graph.apply(f, &reals))).into(),
            ),
        })
    }

    /// `x.powi(n)`: exact for a known n, else a real power with the parameter n.
    fn integer_power(
        &mut self,
        x: &Value,
        n: &Value,
        x_at: &dyn ToTokens,
        n_at: &dyn ToTokens,
    ) -> Option<Value> {
        let x = self.real(x.clone(), x_at);
        let parameter = match n {
            Value::Constant(place) => Some(self.integer_parameter(&place.name, place.as_real())),
            Value::Index(index, _) if index.as_integer().is_none() && index.loops().is_empty() => {
                Some(self.index_as_real(index))
            }
            _ => None,
        };
        if let Some(n) = parameter {
            return Some(Value::Real(self.graph.apply(Function::Powf, &[x?, n])));
        }
        let n = self.known_integer(n.clone(), n_at);
        let (x, n) = (x?, n?);
        match i32::try_from(n) {
            Ok(n) => Some(Value::Real(self.graph.power(x, Rational::integer(n)))),
            Err(_) => self.refuse(expressions::integer_arithmetic(n_at)),
        }
    }
}

/// Whether `at` is the name of a method, and not a path to a function.
fn is_method(at: &dyn ToTokens) -> bool {
    syn::parse2::<syn::Ident>(at.to_token_stream()).is_ok()
}
