//! Code of the expressions of one function body.

use std::collections::HashMap;

use proc_macro2::{Ident, Literal, TokenStream};
use quote::quote;

use super::names::Namer;
use super::print::Printer;
use super::program::{Level, Lowering, Op};
use crate::model::{Parameter, Phase};
use crate::symbolic::{Expr, Graph, Symbol};

/// A function body that evaluates expressions in symbols already bound to names.
pub(crate) struct Body {
    /// Computes the shared values.
    pub(crate) statements: TokenStream,
    /// One expression per root.
    pub(crate) values: Vec<TokenStream>,
    /// The parameters that are used.
    pub(crate) reads: Vec<Read>,
}

/// A parameter that is read.
pub(crate) struct Read {
    /// The number of the parameter among all.
    pub(crate) number: usize,
    pub(crate) name: Ident,
    /// The expression that reads it from the struct.
    pub(crate) tokens: TokenStream,
}

/// The user's names of coordinates and momenta.
pub(crate) fn state_names(names: &mut Namer, graph: &Graph, phase: &Phase) -> [Vec<Ident>; 2] {
    [&phase.q, &phase.p]
        .map(|symbols| names.take_all(symbols.iter().map(|&symbol| graph.symbol_name(symbol))))
}

/// Names of parameters: fields keep theirs, constants become `constant_` and their name in lower case.
pub(crate) fn parameter_names(names: &mut Namer, graph: &Graph, parameters: &[Parameter]) -> Vec<Ident> {
    let wish = |Parameter { symbol, tokens, .. }: &Parameter| {
        let name = graph.symbol_name(*symbol);
        let is_field = tokens.to_string().contains("self");
        if is_field { name.to_owned() } else { format!("constant_{}", name.to_lowercase()) }
    };
    names.take_all(parameters.iter().map(wish))
}

/// The names and the types of numbers in a function body.
pub(crate) struct Environment<'t> {
    /// The names that are taken.
    pub(crate) names: Namer,
    /// The names of the parameters, in their order.
    pub(crate) parameters: Vec<Ident>,
    /// The symbols of the state, with the names that they are bound to.
    pub(crate) state: Vec<(Symbol, Ident)>,
    /// The type of values that read the state; `None` if every value is a constant.
    pub(crate) scalar: Option<&'t TokenStream>,
    /// The type of parameters.
    pub(crate) constant: &'t TokenStream,
}

/// The evaluation of functions of parameters in constants `__K`, with the parameters read first: with
/// derivatives from the list `__parameters`.
pub(crate) fn evaluation(graph: &mut Graph, parameters: &[Parameter], roots: &[Expr]) -> Body {
    let (mut names, constant) = (Namer::default(), quote!(__K));
    let own = parameter_names(&mut names, graph, parameters);
    let environment =
        Environment { names, parameters: own, state: Vec::new(), scalar: None, constant: &constant };
    let body = evaluation_over(graph, parameters, environment, roots);
    let reads = body.reads.iter().map(|Read { number, name, tokens }| {
        let number = count(*number);
        quote!(let #name = __K::parameter(__parameters, #number, #tokens);)
    });
    let statements = &body.statements;
    Body { statements: quote!(#(#reads)* #statements), ..body }
}

/// The evaluation of `roots` in an environment: in its scalar type, or in constants if it has none.
pub(crate) fn evaluation_over(
    graph: &mut Graph,
    parameters: &[Parameter],
    environment: Environment<'_>,
    roots: &[Expr],
) -> Body {
    let Environment { names, parameters: own, state, scalar, constant } = environment;
    let mut lowering = Lowering::new(graph, HashMap::new());
    let bound: Vec<(Op, Ident)> =
        state.into_iter().map(|(symbol, name)| (lowering.input(symbol, Level::State), name)).collect();
    let mut reads = Vec::new();
    for (number, (name, Parameter { symbol, tokens, .. })) in own.into_iter().zip(parameters).enumerate() {
        let op = lowering.input(*symbol, Level::Prepared);
        reads.push((op, Read { number, name, tokens: tokens.clone() }));
    }
    let roots: Vec<Op> = roots.iter().map(|&root| lowering.lower(root)).collect();
    let program = &lowering.program;
    let (uses, hints) = (program.uses(&roots), HashMap::new());
    let constants: Vec<Op> = reads.iter().map(|(op, ..)| *op).collect();
    let printer = Printer::new(program, scalar.unwrap_or(constant).clone(), &hints, names);
    let mut printer = printer.with_constants(&constants, constant.clone());
    reads.retain(|(op, ..)| uses[*op] > 0);
    let named = reads.iter().map(|(op, read)| (*op, read.name.clone()));
    bound.into_iter().chain(named).for_each(|(op, name)| printer.set(op, name));
    let statements = printer.bind(&roots, &uses, &|_| false);
    let value = if scalar.is_some() { Printer::scalar_value } else { Printer::constant_value };
    let values = roots.iter().map(|&root| value(&printer, root)).collect();
    Body { statements, values, reads: reads.into_iter().map(|(_, read)| read).collect() }
}

/// A number where a `usize` is expected.
pub(crate) fn count(number: usize) -> Literal {
    Literal::usize_unsuffixed(number)
}
