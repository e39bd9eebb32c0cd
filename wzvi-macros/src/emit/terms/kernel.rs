//! One element in its loops: what it computes and what of that is fixed in them. [`Chunk`] is the innermost one.

use std::collections::HashMap;

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use super::Wanted;
use super::chunk::{Beside, Chunk, Emitted, gathers, lists, partners};
use super::indices::{Indices, variable};
use crate::diagnostics::internal::Promised;
use crate::discretise::sums::Weighted;
use crate::elements::parts::family_of;
use crate::emit::{Level, Lowering, Names, Op, Printer, count, parameter_names};
use crate::model::Parameter;
use crate::model::Table;
use crate::model::index::{Atom, Index, Loop};
use crate::symbolic::{Expr, Graph, Symbol};

/// Where a computed value goes.
#[derive(Clone)]
pub(super) enum Target {
    /// The value itself, times a factor.
    Value { factor: Option<TokenStream> },
    /// `total += value`
    Total,
    /// `vector[index] += value`
    Slope { vector: Ident, index: Index },
    /// `into.method(row, column, is_diagonal, value)`, where a pair of variables may be one twice
    Curvature { method: Ident, row: Index, column: Index, is_diagonal: Option<bool> },
}

/// What the elements of one system share.
pub(super) struct Context<'a> {
    pub(super) graph: &'a mut Graph,
    pub(super) parameters: &'a [Parameter],
    pub(super) tables: &'a [Table],
    pub(super) t: Symbol,
    /// What momenta are larger by, where friction is taken in.
    pub(super) scale: Option<Symbol>,
    /// The symbol of the weight `c`, and what it is: a value of the scalar type, in scope of the loops.
    pub(super) weight: Option<(Symbol, &'a TokenStream)>,
    /// What is computed; for all but second derivatives only the noises that act count.
    pub(super) wanted: Wanted,
    /// Components of a point.
    pub(super) components: i128,
    /// Whether sums are of windows, or of columns, in which a place may not be.
    pub(super) has_windows: bool,
    /// What other symbols of the outputs stand for.
    pub(super) definitions: HashMap<Symbol, Expr>,
}

/// What parameters are called.
pub(super) fn parameters(graph: &Graph, parameters: &[Parameter]) -> Vec<Ident> {
    parameter_names(&mut Names::default(), graph, parameters)
}

/// The loops of an element around what computes `outputs`.
pub(super) fn emit(
    context: &mut Context<'_>,
    weighted: &Weighted,
    outputs: &[(Expr, Target)],
) -> TokenStream {
    let Weighted { element, increments } = weighted;
    if outputs.is_empty() {
        return TokenStream::new();
    }
    let indices = Indices::unchecked(context.tables);
    let (outer, inner) = match element.loops.split_last() {
        Some((inner, outer)) => (outer, Some(inner)),
        None => (&[][..], None),
    };
    let roots: Vec<Expr> = outputs.iter().map(|(root, _)| *root).collect();

    let parameters = parameters(context.graph, context.parameters);
    let mut taken = Names::default();
    parameters.iter().for_each(|name| taken.avoid(name));
    let slots = element.locals.iter().map(|local| context.graph.symbol_name(local.symbol));
    let locals = taken.take_all(slots);

    let mut lowering = Lowering::new(context.graph, std::mem::take(&mut context.definitions));
    let mut inputs: Vec<(Op, Ident)> = Vec::new();
    for (local, name) in element.locals.iter().zip(&locals) {
        lowering.program.declare(local.symbol, Level::State);
        inputs.push((lowering.program.input(local.symbol), name.clone()));
    }
    if let Some((symbol, _)) = context.weight {
        lowering.program.declare(symbol, Level::State);
        inputs.push((lowering.program.input(symbol), format_ident!("__factor")));
    }
    lowering.program.declare(context.t, Level::Time);
    inputs.push((lowering.program.input(context.t), format_ident!("__t")));
    if let Some(scale) = context.scale {
        lowering.program.declare(scale, Level::Time);
        inputs.push((lowering.program.input(scale), format_ident!("__scale")));
    }
    let constants = [format_ident!("__t"), format_ident!("__scale")].into_iter().chain(parameters.clone());
    let constants: Vec<Ident> = constants.collect();
    for (parameter, name) in context.parameters.iter().zip(parameters) {
        lowering.program.declare(parameter.symbol, Level::Prepared);
        inputs.push((lowering.program.input(parameter.symbol), name));
    }
    let ops: Vec<Op> = roots.iter().map(|&root| lowering.lower(root)).collect();
    let program = &lowering.program;
    let uses = program.uses(&ops);
    let hints = HashMap::new();
    let mut printer = Printer::new(program, context.wanted.number(), &hints, taken);
    for (op, name) in inputs {
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
    let mut constants = constants;
    constants.extend(fixed.iter().filter_map(|&op| printer.bound(op).cloned()));
    constants.sort_unstable();
    constants.dedup();
    let inside = printer.bind(&ops, &uses, &|_| false);
    let value = |(&op, (_, target)): (&Op, &(Expr, Target))| match target {
        Target::Value { factor: Some(_) } => printer.scalar_factor(op),
        _ => printer.scalar_value(op),
    };
    let values: Vec<TokenStream> = ops.iter().zip(outputs).map(value).collect();

    // The increments of a family whose members are the innermost loop change with it.
    let (fixed_weight, own_weight) = match (context.weight, inner) {
        (None, _) => (quote!(), quote!()),
        (Some((_, weight)), Some(inner))
            if increments.iter().any(|number| number.loops().contains(&inner.variable)) =>
        {
            (quote!(), quote!(let __factor = #weight;))
        }
        (Some((_, weight)), _) => (quote!(let __factor = #weight;), quote!()),
    };
    let acting = if context.wanted == Wanted::Curvature { None } else { family_of(weighted) };
    let range_of = |known: &Loop| match acting {
        Some(family) if family == known.variable => {
            let range = [indices.value(&known.start), indices.value(&known.end)];
            acting_members(&indices, weighted, family, range)
        }
        _ => [indices.sum(&known.start), indices.sum(&known.end)],
    };
    let start = inner.filter(|known| acting != Some(known.variable)).map(|known| known.start.clone());
    let inner = inner.map(|known| (known.variable, range_of(known)));
    let pairs = match context.wanted {
        Wanted::Slopes => partners(weighted, &indices, context.components),
        Wanted::Value | Wanted::Curvature => None,
    };
    let is_gathered = context.wanted == Wanted::Slopes
        && pairs.is_none()
        && gathers(context.graph, element, context.components);
    let lists = if is_gathered { lists(element, context.tables) } else { Vec::new() };
    let beside = is_gathered.then_some(Beside { constants: &constants, weight: &own_weight, lists: &lists });
    let mut chunk = Chunk {
        indices,
        element,
        inner,
        start,
        outputs,
        locals: &locals,
        components: context.components,
        has_windows: context.has_windows,
        wanted: context.wanted,
        beside,
    };
    let Emitted { buffers, body, after } = match pairs {
        Some(first) => chunk.row(&first, &constants, &inside, &values),
        None if is_gathered => {
            let beside = chunk.emit(&inside, &values);
            chunk.beside = None;
            let one_by_one = chunk.emit(&quote!(#own_weight #inside), &values);
            either(&chunk, &written(outputs), beside, &one_by_one.body)
        }
        None => chunk.emit(&quote!(#own_weight #inside), &values),
    };
    let mut nest = quote! { #fixed_weight #body };
    for (depth, known) in outer.iter().enumerate().rev() {
        let (name, [start, end]) = (variable(known.variable), range_of(known));
        // Literals alone have no type.
        let is_typed = !known.start.terms.is_empty() || acting == Some(known.variable);
        let start = if is_typed { start } else { quote!(#start as __wzvi::isize) };
        let range = match (depth, context.wanted) {
            (0, Wanted::Slopes) => {
                let (number, sums) = (count(known.variable as usize), written(outputs));
                quote!(#sums.outer(#number, #start..#end))
            }
            _ => quote!(#start..#end),
        };
        nest = quote! {
            for #name in #range {
                #nest
            }
        };
    }
    quote!(#before #buffers #nest #after)
}

/// A loop whose placements are taken beside each other if the sums say so, else one by one.
fn either(chunk: &Chunk<'_>, sums: &TokenStream, beside: Emitted, one_by_one: &TokenStream) -> Emitted {
    let (_, [start, end]) = chunk.inner.clone().promised("what is gathered has a loop");
    let Emitted { buffers, body, after } = beside;
    let body = quote! {
        if #sums.gathers(#start, #end) {
            #body
        } else {
            #one_by_one
        }
    };
    Emitted { buffers, body, after }
}

/// The vector of slopes that an element adds to; where it adds to both, either.
pub(super) fn written(outputs: &[(Expr, Target)]) -> TokenStream {
    let vector = outputs.iter().find_map(|(_, target)| match target {
        Target::Slope { vector, .. } => Some(quote!(#vector)),
        Target::Value { .. } | Target::Total | Target::Curvature { .. } => None,
    });
    vector.unwrap_or_default()
}

/// The members of a family that act.
fn acting_members(
    indices: &Indices<'_>,
    weighted: &Weighted,
    family: u32,
    [start, end]: [TokenStream; 2],
) -> [TokenStream; 2] {
    let number = weighted.increments.first().cloned().unwrap_or_default();
    let before = number.subtract(&Index::atom(Atom::Loop(family)));
    let before = before.promised("the number of a member is an offset and its own number");
    let own = |number: TokenStream| {
        let number = quote!(#number as __wzvi::isize);
        if before == Index::default() {
            return number;
        }
        let before = indices.value(&before);
        quote!(#number - #before)
    };
    let (first, last) = (own(quote!(__at.acting.start)), own(quote!(__at.acting.end)));
    [quote!(__wzvi::Ord::max(#start, #first)), quote!(__wzvi::Ord::min(#end, #last))]
}
