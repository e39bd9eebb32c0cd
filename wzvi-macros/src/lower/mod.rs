//! From closures to expressions: an abstract interpreter of `syn::Expr`. Loops are unrolled, local closures inlined,
//! and what depends on the state or on parameters becomes symbolic. Only this module reads Rust expressions.

mod calls;
mod control;
mod dereference;
mod floats;
mod indices;
mod interpreter;
mod iterators;
mod names;
mod operators;
mod patterns;
mod scope;
mod sized;
mod streams;
#[cfg(test)]
mod tests;
mod type_checks;
mod value;

use syn::ReturnType;

use crate::diagnostics::{Diagnostics, expressions, messages};
use crate::elements::collect::Parts;
use crate::input::{Container, Declaration, Hamiltonian, Length, PhaseSpace, Shape, peeled};
use crate::model::index::{Atom, Index, Loop};
use crate::model::{Extent, Family, Located, Model, Noise, Phase, System, Term};
use crate::symbolic::{Expr, Graph, Symbol};

use interpreter::Interpreter;
use sized::Loops;
use streams::{Array, Source};
use value::Value;

pub(crate) use floats::is_real_method;
pub(crate) use names::{is_self, real_function};
pub(crate) use sized::Sum;

/// Lowers every closure. `None` only after an error was reported.
pub(crate) fn lower(
    system: Container,
    declaration: Declaration,
    phase_space: &PhaseSpace,
    diagnostics: &mut Diagnostics,
) -> Option<Model> {
    let mut graph = Graph::new();
    let phase = symbols(&mut graph, phase_space);
    let mut interpreter = Interpreter::new(graph, &system, diagnostics);
    interpreter.root = Some(&declaration.library);
    let mut wrong_count = None;
    let shape = &phase_space.shape;
    let mut lower_one = |hamiltonian, k| lower_closure(&mut interpreter, hamiltonian, shape, &phase, k);

    let drift = declaration.drift.as_ref().map(|drift| lower_one(drift, None));
    let mut noise = Vec::new();
    for closure in &declaration.noise {
        match &closure.family {
            None => noise.push(lower_one(closure, None)),
            Some(count) => match family_members(count) {
                Some(members) => noise.extend((0..members).map(|k| lower_one(closure, Some(k)))),
                None => wrong_count = Some(count),
            },
        }
    }
    let invariants: Vec<_> =
        declaration.invariants.iter().map(|invariant| lower_one(invariant, None)).collect();
    if let Some(count) = wrong_count {
        interpreter.report(messages::family_count(count));
        return None;
    }

    let (graph, parameters) = interpreter.into_parts();
    let type_checks = type_checks::type_checks(&system, &declaration, &phase_space.shape);
    Some(Model {
        graph,
        phase,
        parameters,
        drift: drift.flatten()?,
        noise: noise.into_iter().collect::<Option<_>>()?,
        invariants: invariants.into_iter().collect::<Option<_>>()?,
        embeddings: declaration.embeddings,
        item: system.item,
        crate_path: declaration.crate_path,
        type_checks,
    })
}

/// The number of noises that a family stands for.
fn family_members(count: &syn::Expr) -> Option<i128> {
    let syn::Expr::Lit(literal) = peeled(count) else { return None };
    let syn::Lit::Int(count) = &literal.lit else { return None };
    count.base10_parse::<u16>().ok().map(i128::from)
}

fn symbols(graph: &mut Graph, phase_space: &PhaseSpace) -> Phase {
    let q = phase_space.q.iter().map(|name| graph.new_symbol(name)).collect();
    let p = phase_space.p.iter().map(|name| graph.new_symbol(name)).collect();
    Phase { q, p, t: graph.new_symbol(&phase_space.t) }
}

/// The value of one closure at the symbols of phase space.
fn lower_closure<'a>(
    interpreter: &mut Interpreter<'a, '_>,
    hamiltonian: &'a Hamiltonian,
    shape: &Shape,
    phase: &Phase,
    member: Option<i128>,
) -> Option<Located<Expr>> {
    let closure = &hamiltonian.closure;
    if let ReturnType::Type(_, ty) = &closure.output
        && !names::is_real_type(ty)
    {
        interpreter.report(messages::return_type(ty));
        return None;
    }
    let q = arrange(&mut interpreter.graph, shape, &mut phase.q.iter());
    let p = arrange(&mut interpreter.graph, shape, &mut phase.p.iter());
    let t = Value::Real(interpreter.graph.symbol(phase.t));
    interpreter.start();
    let mut values = vec![q, p, t];
    if let Some(k) = member {
        values.truncate(closure.inputs.len().saturating_sub(1));
        values.push(Value::Integer(k));
    }
    for (pattern, value) in closure.inputs.iter().zip(values) {
        interpreter.bind(pattern, value);
    }
    let value = interpreter.evaluate(&closure.body);
    let value = interpreter.energy(value, interpreter::result_of(&closure.body))?;
    Some(Located { value, extent: Extent::of(&closure.body) })
}

/// The symbols as a value of the given shape.
fn arrange<'s>(graph: &mut Graph, shape: &Shape, symbols: &mut impl Iterator<Item = &'s Symbol>) -> Value {
    match shape {
        Shape::Real => symbols.next().map_or(Value::Poison, |&symbol| Value::Real(graph.symbol(symbol))),
        Shape::Array(element, Length::Literal(len)) => {
            Value::list((0..*len).map(|_| arrange(graph, element, symbols)).collect())
        }
        Shape::Array(..) => Value::Poison,
    }
}

/// Lowers every closure of a system whose sums stay loops. `None` only after an error was reported.
pub(crate) fn lower_elements(
    system: &Container,
    declaration: &Declaration,
    phase_space: &PhaseSpace,
    diagnostics: &mut Diagnostics,
) -> Option<System> {
    let Shape::Array(point, length) = &phase_space.shape else { return None };
    let mut graph = Graph::new();
    let t = graph.new_symbol(&phase_space.t);
    let mut interpreter = Interpreter::new(graph, system, diagnostics);
    interpreter.root = Some(&declaration.library);
    interpreter.sized = Some(Loops::default());
    let name = |names: &[String], fallback: &str| {
        let first = names.first().map_or(fallback, |name| name.split('[').next().unwrap_or(fallback));
        first.to_owned()
    };
    interpreter.names = [name(&phase_space.q, "q"), name(&phase_space.p, "p")];
    let size = match length {
        Length::Literal(len) => Index::integer(*len as i128),
        Length::Named(expr) => interpreter.size(expr),
        Length::RunTime => Index::atom(Atom::Size),
    };
    let inner = inner_lengths(point);
    let space = SizedSpace { size: size.clone(), inner: inner.clone(), t };

    let drift = declaration.drift.as_ref().map(|drift| lower_sized(&mut interpreter, drift, &space, None));
    let noise: Vec<_> =
        declaration.noise.iter().map(|noise| lower_noise(&mut interpreter, noise, &space)).collect();
    let invariants: Vec<_> = declaration
        .invariants
        .iter()
        .map(|invariant| lower_sized(&mut interpreter, invariant, &space, None))
        .collect();
    let invariants = invariants.into_iter().collect::<Option<Vec<_>>>()?;
    let drift = drift??;
    let noise = noise.into_iter().collect::<Option<Vec<_>>>()?;
    let names = interpreter.names.clone();
    let loops = interpreter.sized.take()?;
    let (graph, parameters) = interpreter.into_parts();
    Some(System {
        graph,
        shape: phase_space.shape.clone(),
        size,
        components: inner.iter().product(),
        names,
        t,
        parameters,
        tables: loops.tables,
        drift,
        noise,
        invariants,
        embeddings: declaration.embeddings.clone(),
        item: system.item.clone(),
        crate_path: declaration.crate_path.clone(),
        type_checks: type_checks::type_checks(system, declaration, &phase_space.shape),
    })
}

/// The lengths of the arrays inside of a point.
fn inner_lengths(shape: &Shape) -> Vec<i128> {
    match shape {
        Shape::Array(element, Length::Literal(len)) => {
            let mut lengths = vec![*len as i128];
            lengths.extend(inner_lengths(element));
            lengths
        }
        _ => Vec::new(),
    }
}

struct SizedSpace {
    size: Index,
    inner: Vec<i128>,
    t: Symbol,
}

/// A noise, or a family of them.
fn lower_noise<'a>(
    interpreter: &mut Interpreter<'a, '_>,
    noise: &'a Hamiltonian,
    space: &SizedSpace,
) -> Option<Noise> {
    let Some(count) = &noise.family else {
        return Some(Noise { term: lower_sized(interpreter, noise, space, None)?, family: None });
    };
    let count = interpreter.family_count(count)?;
    let variable = interpreter.sized.as_mut()?.variable();
    let range = Loop { variable, start: Index::default(), end: count.clone() };
    let term = lower_sized(interpreter, noise, space, Some(range))?;
    Some(Noise { term, family: Some(Family { variable, count }) })
}

/// The elements of one closure; of a family, inside of the loop over its members.
fn lower_sized<'a>(
    interpreter: &mut Interpreter<'a, '_>,
    hamiltonian: &'a Hamiltonian,
    space: &SizedSpace,
    family: Option<Loop>,
) -> Option<Term> {
    let closure = &hamiltonian.closure;
    if let ReturnType::Type(_, ty) = &closure.output
        && !names::is_real_type(ty)
    {
        interpreter.report(messages::return_type(ty));
        return None;
    }
    let array = |source: Source| {
        let (start, length) = (Index::default(), space.size.clone());
        Value::Array(Array { source, indices: Vec::new(), start, length, inner: space.inner.clone() }.into())
    };
    let t = Value::Real(interpreter.graph.symbol(space.t));
    interpreter.start();
    let mut values = vec![array(Source::Coordinates), array(Source::Momenta), t];
    if let Some(range) = &family {
        values.truncate(closure.inputs.len().saturating_sub(1));
        values.push(Value::Index(Index::atom(Atom::Loop(range.variable)).into()));
    }
    for (pattern, value) in closure.inputs.iter().zip(values) {
        interpreter.bind(pattern, value);
    }
    let outer: Vec<Loop> = family.into_iter().collect();
    interpreter.sized.as_mut()?.active.clone_from(&outer);
    let value = interpreter.evaluate(&closure.body);
    let result = interpreter::result_of(&closure.body);
    let value = interpreter.energy(value, result)?;
    let loops = interpreter.sized.as_mut()?;
    loops.active.clear();
    let parts = Parts::new(std::mem::take(&mut loops.sums), loops.locals.clone());
    match parts.term(&mut interpreter.graph, value, &outer, Extent::of(&closure.body)) {
        Ok(term) => Some(term),
        Err(_) => {
            interpreter.report(expressions::nonlinear_sum(result));
            None
        }
    }
}
