//! One element in its loops: what it computes and what of that is fixed in them. [`Chunk`] is the innermost one.

use std::collections::HashMap;

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use super::chunk::Chunk;
use super::indices::{Indices, variable};
use crate::emit::{Level, Lowering, Names, Op, Printer};
use crate::model::Parameter;
use crate::model::index::{Index, Loop};
use crate::model::{Element, Table};
use crate::symbolic::{Expr, Graph, Symbol};

/// Where a computed value goes.
#[derive(Clone)]
pub(super) enum Target {
    /// `total += value`
    Total,
    /// `vector[index] += value`
    Slope { vector: Ident, index: Index },
    /// `into.method(row, column, is_diagonal, value)`
    Curvature { method: Ident, row: Index, column: Index, is_diagonal: bool },
}

/// What the elements of one system share.
pub(super) struct Context<'a> {
    pub(super) graph: &'a mut Graph,
    pub(super) parameters: &'a [Parameter],
    pub(super) tables: &'a [Table],
    pub(super) t: Symbol,
    /// The symbol of the weight `c`, and what it is: a value of the scalar type, in scope of the loops.
    pub(super) weight: Option<(Symbol, &'a TokenStream)>,
    /// Components of a point.
    pub(super) components: i128,
    /// What other symbols of the outputs stand for.
    pub(super) definitions: HashMap<Symbol, Expr>,
}

/// What the code around an element names.
const LIVE: [&str; 20] = [
    "ahead", "at", "base", "by_p", "by_q", "c", "end", "into", "k", "len", "low", "nan", "p", "q", "size",
    "t", "term", "terms", "total", "value",
];

/// The loops of `element` around what computes `outputs`.
pub(super) fn emit(context: &mut Context<'_>, element: &Element, outputs: &[(Expr, Target)]) -> TokenStream {
    if outputs.is_empty() {
        return TokenStream::new();
    }
    let indices = Indices { tables: context.tables, checked: false };
    let (outer, inner) = match element.loops.split_last() {
        Some((inner, outer)) => (outer, Some(inner)),
        None => (&[][..], None),
    };
    let roots: Vec<Expr> = outputs.iter().map(|(root, _)| *root).collect();

    let mut lowering = Lowering::new(context.graph, std::mem::take(&mut context.definitions));
    let mut names: Vec<(Op, Ident)> = Vec::new();
    for (k, local) in element.locals.iter().enumerate() {
        lowering.program.declare(local.symbol, Level::State);
        names.push((lowering.program.input(local.symbol), format_ident!("__l{k}")));
    }
    if let Some((symbol, _)) = context.weight {
        lowering.program.declare(symbol, Level::State);
        names.push((lowering.program.input(symbol), format_ident!("__c")));
    }
    lowering.program.declare(context.t, Level::Time);
    names.push((lowering.program.input(context.t), format_ident!("__t")));
    for (k, parameter) in context.parameters.iter().enumerate() {
        lowering.program.declare(parameter.symbol, Level::Prepared);
        names.push((lowering.program.input(parameter.symbol), format_ident!("__a{k}")));
    }
    let ops: Vec<Op> = roots.iter().map(|&root| lowering.lower(root)).collect();
    let program = &lowering.program;
    let uses = program.uses(&ops);
    let hints = HashMap::new();
    let mut printer = Printer::new(program, quote!(__S), &hints, Names::beside(&LIVE));
    for (op, name) in names {
        printer.set(op, name);
    }
    // What the state does not enter is computed before the loops.
    let needed = program.needed(&ops, &|_| false);
    let is_fixed = |op: Op| program.level(op) < Level::Increments && !program.is_literal(op);
    let mut fixed: Vec<Op> = needed
        .iter()
        .filter(|&&op| program.level(op) >= Level::Increments)
        .flat_map(|&op| program.operation(op).operands())
        .chain(ops.iter().copied())
        .filter(|&op| is_fixed(op))
        .collect();
    fixed.sort_unstable();
    fixed.dedup();
    let before = printer.bind(&fixed, &uses, &|op| fixed.contains(&op));
    let inside = printer.bind(&ops, &uses, &|_| false);
    let values: Vec<TokenStream> = ops.iter().map(|&op| printer.scalar_value(op)).collect();

    // The increments of a family whose members are the innermost loop change with it.
    let (fixed_weight, own_weight) = match (context.weight, inner) {
        (None, _) => (quote!(), quote!()),
        (Some((_, weight)), Some(inner)) if mentions(weight, &variable(inner.variable)) => {
            (quote!(), quote!(let __c = #weight;))
        }
        (Some((_, weight)), _) => (quote!(let __c = #weight;), quote!()),
    };
    let chunk = Chunk { indices: &indices, element, inner, outputs, components: context.components };
    let body = chunk.emit(&quote!(#own_weight #inside), &values);
    let mut nest = quote! { #fixed_weight #body };
    for Loop { variable: id, start, end } in outer.iter().rev() {
        let (name, start, end) = (variable(*id), indices.value(start), indices.value(end));
        nest = quote! {
            for #name in (#start as __wzvi::isize)..#end {
                #nest
            }
        };
    }
    quote! {{ #before #nest }}
}

fn mentions(tokens: &TokenStream, name: &Ident) -> bool {
    tokens.clone().into_iter().any(|token| match token {
        proc_macro2::TokenTree::Ident(ident) => ident == *name,
        proc_macro2::TokenTree::Group(group) => mentions(&group.stream(), name),
        _ => false,
    })
}
