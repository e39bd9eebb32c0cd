//! Lowering against hand-built expressions and plain binary64 arithmetic.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod identities;
mod messages;
mod robustness;
mod values;

use std::collections::HashMap;

use proc_macro2::TokenStream;

use crate::diagnostics::Diagnostics;
use crate::input;
use crate::model::{Form, StraightLine};
use crate::passes::collect::collect;
use crate::passes::unroll::{unroll, written_out};
use crate::symbolic::Graph;

/// The fields of every test system, with their values.
const STRUCT: &str = "struct System<const N: usize> { a: f64, sigma: f64, n: i32, masses: [f64; 3], table: Vec<f64>, \
                      grid: [[f64; 2]; 2], name: String, single: f32 }";

/// A system that is written out, and its graph.
struct Model {
    graph: Graph,
    line: StraightLine,
}

impl std::ops::Deref for Model {
    type Target = StraightLine;

    fn deref(&self) -> &StraightLine {
        &self.line
    }
}

/// The model of `#[hamiltonian(attribute)] item`, or the messages.
fn model_of(attribute: &str, item: &str) -> Result<Model, String> {
    let attribute: TokenStream = attribute.parse().unwrap();
    let mut diagnostics = Diagnostics::new();
    let system = input::read_struct(item.parse().unwrap(), &mut diagnostics);
    let model = input::read_attribute(attribute, &mut diagnostics).and_then(|mut declaration| {
        let phase_space = input::read_phase_space(&mut declaration, &mut diagnostics)?;
        let mut system = super::lower(system?, declaration, &phase_space, &mut diagnostics)?;
        system.form = Form::StraightLines;
        unroll(&mut system);
        collect(&mut system, &mut diagnostics);
        let line = written_out(&mut system).unwrap_or_else(|| panic!("loops are left"));
        Some(Model { graph: system.graph, line })
    });
    match diagnostics.finish() {
        Ok(()) => Ok(model.expect("a model or an error")),
        Err(errors) => Err(errors.to_string()),
    }
}

fn drift(closure: &str) -> Model {
    model_of(&format!("drift = {closure}, embedding = Midpoint"), STRUCT)
        .unwrap_or_else(|e| panic!("{closure}: {e}"))
}

/// The drift's value with coordinates `q`, momenta `p`, t = 0.75 and the parameters given by their display
/// names.
fn value(closure: &str, q: &[f64], p: &[f64], parameters: &[(&str, f64)]) -> f64 {
    let model = drift(closure);
    let mut values = HashMap::new();
    values.extend(model.phase.q.iter().copied().zip(q.iter().copied()));
    values.extend(model.phase.p.iter().copied().zip(p.iter().copied()));
    values.insert(model.phase.t, 0.75);
    for parameter in &model.parameters {
        let name = model.graph.symbol_name(parameter.symbol);
        let known = parameters.iter().find(|(known, _)| *known == name);
        values.insert(parameter.symbol, known.unwrap_or_else(|| panic!("parameter {name}")).1);
    }
    model.graph.evaluate(&[model.drift], &|symbol| values[&symbol])[0]
}

/// Asserts that the closure, as the compiler reads it, is the same function as Rust compiles.
macro_rules! same_as_rust {
    ($closure:expr, [$($q:expr),*], [$($p:expr),*], { $($name:ident = $number:expr),* $(,)? }) => {{
        let ours = $crate::lower::tests::value(
            stringify!($closure), &[$($q),*], &[$($p),*], &[$((stringify!($name), f64::from($number))),*],
        );
        $( #[allow(unused)] let $name = $number; )*
        let theirs: f64 = $crate::lower::tests::call($closure);
        assert!((ours - theirs).abs() <= 1e-13 * theirs.abs().max(1.0), "{}: {ours} {theirs}", stringify!($closure));
    }};
}
use same_as_rust;

/// Calls a closure over one degree of freedom at the common test point.
fn call(closure: impl Fn(f64, f64) -> f64) -> f64 {
    closure(0.3, 1.7)
}
