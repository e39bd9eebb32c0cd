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

use crate::diagnostics::{Diagnostics, messages};
use crate::input::{Declaration, Hamiltonian, PhaseSpace, Shape, System};
use crate::model::{Extent, Located, Model, Phase};
use crate::symbolic::{Expr, Graph, Symbol};

use interpreter::Interpreter;
use value::Value;

/// Lowers every closure. `None` only after an error was reported.
pub(crate) fn lower(
    system: System,
    declaration: Declaration,
    phase_space: &PhaseSpace,
    diagnostics: &mut Diagnostics,
) -> Option<Model> {
    let mut graph = Graph::new();
    let phase = symbols(&mut graph, phase_space);
    let mut interpreter = Interpreter::new(graph, &system, diagnostics);
    let mut lower_one =
        |hamiltonian| lower_closure(&mut interpreter, hamiltonian, &phase_space.shape, &phase);

    let drift = declaration.drift.as_ref().map(&mut lower_one);
    let noise: Vec<_> = declaration.noise.iter().map(&mut lower_one).collect();
    let invariants: Vec<_> = declaration.invariants.iter().map(&mut lower_one).collect();

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
    for (pattern, value) in closure.inputs.iter().zip([q, p, t]) {
        interpreter.bind(pattern, value);
    }
    let value = interpreter.evaluate(&closure.body);
    let value = interpreter.real(value, interpreter::result_of(&closure.body))?;
    Some(Located { value, extent: Extent::of(&closure.body) })
}

/// The symbols as a value of the given shape.
fn arrange<'s>(graph: &mut Graph, shape: &Shape, symbols: &mut impl Iterator<Item = &'s Symbol>) -> Value {
    match shape {
        Shape::Real => symbols.next().map_or(Value::Poison, |&symbol| Value::Real(graph.symbol(symbol))),
        Shape::Array(element, len) => {
            Value::list((0..*len).map(|_| arrange(graph, element, symbols)).collect())
        }
    }
}
