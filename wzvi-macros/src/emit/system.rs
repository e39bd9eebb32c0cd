//! Expressions of one function body, as code.

use std::collections::HashMap;

use proc_macro2::{Ident, Literal, TokenStream};
use quote::quote;

use super::names::Names;
use super::print::{Printer, f64_type};
use super::program::{Level, Lowering, Op};
use crate::model::{Parameter, StraightLine};
use crate::symbolic::{Expr, Graph, Symbol};

/// A function body that evaluates expressions of symbols which are bound to names before it.
pub(crate) struct Body {
    /// Reads the parameters that are used, then computes what is shared.
    pub(crate) statements: TokenStream,
    /// One expression per root.
    pub(crate) values: Vec<TokenStream>,
}

/// Where the symbols of a [`Body`] come from.
#[derive(Default)]
pub(crate) struct Inputs {
    pub(crate) names: Vec<(Symbol, Ident, Level)>,
    pub(crate) definitions: HashMap<Symbol, Expr>,
}

/// What the numbers that a step is made of are called in a body.
pub(crate) struct Letters {
    pub(crate) q: Vec<Ident>,
    pub(crate) p: Vec<Ident>,
    pub(crate) parameters: Vec<Ident>,
    /// All that is taken.
    pub(crate) names: Names,
}

impl Letters {
    /// The user's names, beside `names`.
    pub(crate) fn of(graph: &Graph, line: &StraightLine, names: Names) -> Self {
        let mut letters = Self::of_state(graph, line, names);
        letters.parameters = parameter_names(&mut letters.names, graph, &line.parameters);
        letters
    }

    /// The same without parameters.
    pub(crate) fn of_state(graph: &Graph, line: &StraightLine, mut names: Names) -> Self {
        let of_symbols = |names: &mut Names, symbols: &[Symbol]| {
            names.take_all(symbols.iter().map(|&symbol| graph.symbol_name(symbol)))
        };
        let (q, p) = (of_symbols(&mut names, &line.phase.q), of_symbols(&mut names, &line.phase.p));
        Self { q, p, parameters: Vec::new(), names }
    }
}

/// Names of parameters: those of the fields, and those of constants in the letters of variables.
pub(crate) fn parameter_names(names: &mut Names, graph: &Graph, parameters: &[Parameter]) -> Vec<Ident> {
    let wish = |Parameter { symbol, tokens }: &Parameter| {
        let name = graph.symbol_name(*symbol);
        let is_field = tokens.to_string().contains("self");
        if is_field { name.to_owned() } else { format!("constant_{}", name.to_lowercase()) }
    };
    names.take_all(parameters.iter().map(wish))
}

/// Emits the evaluation of `roots` in the scalar type `scalar`.
pub(crate) fn evaluation(
    model: (&mut Graph, &[Parameter]),
    letters: &Letters,
    inputs: &Inputs,
    scalar: &TokenStream,
    roots: &[Expr],
) -> Body {
    let (body, reads) = evaluation_over(model, letters, inputs, (scalar, None), roots);
    let f64 = f64_type();
    let reads = reads.iter().map(|Read { name, tokens, .. }| quote!(let #name: #f64 = #tokens;));
    let statements = body.statements;
    Body { statements: quote!(#(#reads)* #statements), ..body }
}

/// A parameter that is read.
pub(crate) struct Read {
    /// Its number among all.
    pub(crate) number: usize,
    pub(crate) name: Ident,
    /// What it is in the system.
    pub(crate) tokens: TokenStream,
}

/// The same without its beginning, where parameters of the system are bound to names. They are numbers of a type of their own, if there is one.
pub(crate) fn evaluation_over(
    (graph, parameters): (&mut Graph, &[Parameter]),
    letters: &Letters,
    inputs: &Inputs,
    (scalar, constant): (&TokenStream, Option<TokenStream>),
    roots: &[Expr],
) -> (Body, Vec<Read>) {
    let mut lowering = Lowering::new(graph, inputs.definitions.clone());
    let mut bound: Vec<(Op, Ident)> = Vec::new();
    for (symbol, name, level) in &inputs.names {
        bound.push((lowering.input(*symbol, *level), name.clone()));
    }
    let mut reads = Vec::new();
    for (number, (name, parameter)) in letters.parameters.iter().zip(parameters).enumerate() {
        let op = lowering.input(parameter.symbol, Level::Prepared);
        reads.push((op, Read { number, name: name.clone(), tokens: parameter.tokens.clone() }));
    }
    let roots: Vec<Op> = roots.iter().map(|&root| lowering.lower(root)).collect();
    let program = &lowering.program;
    let uses = program.uses(&roots);
    let hints = HashMap::new();
    let mut printer = Printer::new(program, scalar.clone(), &hints, letters.names.clone());
    if let Some(constant) = constant {
        let constants: Vec<Op> = reads.iter().map(|(op, ..)| *op).collect();
        printer = printer.with_constants(&constants, constant);
    }
    for (op, name) in bound {
        printer.set(op, name);
    }
    reads.retain(|(op, ..)| uses[*op] > 0);
    for (op, Read { name, .. }) in &reads {
        printer.set(*op, name.clone());
    }
    let statements = printer.bind(&roots, &uses, &|_| false);
    let values = roots.iter().map(|&root| printer.scalar_value(root)).collect();
    (Body { statements, values }, reads.into_iter().map(|(_, read)| read).collect())
}

/// A number where a `usize` is expected.
pub(crate) fn count(number: usize) -> Literal {
    Literal::usize_unsuffixed(number)
}
