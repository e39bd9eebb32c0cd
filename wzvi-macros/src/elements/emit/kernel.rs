//! One element in its loops. The innermost loop runs in chunks: what it reads is sliced or gathered, the arithmetic
//! goes over slices of one length without conditions, so that it can be vectorised. What it computes is added to a slice of
//! each vector of the system at once, and to other places of the same vector afterwards.

use std::collections::HashMap;

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use super::indices::{Indices, variable};
use crate::elements::index::{Atom, Index, Loop};
use crate::elements::model::{Element, Local, Slot, Table};
use crate::emit::{Level, Lowering, Op, Printer};
use crate::model::Parameter;
use crate::symbolic::{Expr, Graph, Symbol};

/// Placements in one chunk.
const CHUNK: usize = 64;

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
    /// The symbol of the weight `c`, and what it is.
    pub(super) weight: Symbol,
}

/// How a local variable is read inside of the innermost loop.
enum Access {
    /// From a slice of the chunk.
    Slice(Ident),
    /// It does not change there.
    Invariant,
    /// By its own index.
    Indexed,
}

/// The loops of `element` around what computes `outputs`. `weight` is a value of the scalar type, in scope of the loops.
pub(super) fn emit(
    context: &mut Context<'_>,
    element: &Element,
    weight: &TokenStream,
    outputs: &[(Expr, Target)],
) -> TokenStream {
    if outputs.is_empty() {
        return TokenStream::new();
    }
    let indices = Indices { tables: context.tables, checked: false };
    let (outer, inner) = match element.loops.split_last() {
        Some((inner, outer)) => (outer, Some(inner)),
        None => (&[][..], None),
    };
    let roots: Vec<Expr> = outputs.iter().map(|(root, _)| *root).collect();

    let mut lowering = Lowering::new(context.graph, HashMap::new());
    let mut names: Vec<(Op, Ident)> = Vec::new();
    for (k, local) in element.locals.iter().enumerate() {
        lowering.program.declare(local.symbol, Level::State);
        names.push((lowering.program.input(local.symbol), format_ident!("__l{k}")));
    }
    lowering.program.declare(context.weight, Level::State);
    names.push((lowering.program.input(context.weight), format_ident!("__c")));
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
    let mut printer = Printer::new(program, quote!(__S), &hints);
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
    let moves = inner.is_some_and(|inner| mentions(weight, &variable(inner.variable)));
    let (fixed_weight, own_weight) = match moves {
        true => (quote!(), quote!(let __c = #weight;)),
        false => (quote!(let __c = #weight;), quote!()),
    };
    let chunk = Chunk { indices: &indices, element, inner, outputs };
    let body = chunk.emit(&quote!(#own_weight #inside), &values);
    let mut nest = quote! { #fixed_weight #body };
    for Loop { variable: id, start, end } in outer.iter().rev() {
        let (name, start, end) = (variable(*id), indices.value(start), indices.value(end));
        nest = quote! {
            for #name in (#start as __wzvi::core::primitive::isize)..#end {
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

/// The innermost loop.
struct Chunk<'a> {
    indices: &'a Indices<'a>,
    element: &'a Element,
    inner: Option<&'a Loop>,
    outputs: &'a [(Expr, Target)],
}

impl Chunk<'_> {
    fn emit(&self, inside: &TokenStream, values: &[TokenStream]) -> TokenStream {
        let Some(inner) = self.inner else { return self.single(inside, values) };
        let name = variable(inner.variable);
        let (start, end) = (self.indices.value(&inner.start), self.indices.value(&inner.end));
        let (isize, usize) = (quote!(__wzvi::core::primitive::isize), quote!(__wzvi::core::primitive::usize));
        let mut before = TokenStream::new();
        let mut opening = TokenStream::new();
        let mut reads = TokenStream::new();
        for (k, local) in self.element.locals.iter().enumerate() {
            let own = format_ident!("__l{k}");
            match self.access(local, k) {
                Access::Invariant => {
                    let value = self.read(&local.slot);
                    before.extend(quote!(let #own = #value;));
                }
                Access::Slice(slice) => {
                    let list = self.list(&local.slot);
                    let index = slot_index(&local.slot);
                    let base = self.indices.position(&index);
                    opening.extend(quote! {
                        let #slice = #base;
                        let #slice = &#list[#slice..#slice + __len];
                    });
                    let is_state = matches!(local.slot, Slot::Coordinate(_) | Slot::Momentum(_));
                    reads.extend(match is_state {
                        true => quote!(let #own = #slice[__k];),
                        false => quote!(let #own = <__S as __wzvi::Scalar>::from_f64(#slice[__k]);),
                    });
                }
                Access::Indexed => {
                    let value = self.read(&local.slot);
                    reads.extend(quote!(let #own = #value;));
                }
            }
        }
        let zero = quote!(<__S as __wzvi::Scalar>::from_f64(0.0));
        let limits = self.limits(&inner.variable);
        let mut stores = TokenStream::new();
        let mut scatters = TokenStream::new();
        let mut after = TokenStream::new();
        let mut direct: Vec<&Ident> = Vec::new();
        for (j, ((_, target), value)) in self.outputs.iter().zip(values).enumerate() {
            let buffer = format_ident!("__b{j}");
            match self.placed(target, inner.variable) {
                Placed::Fixed => {
                    before.extend(quote!(let mut #buffer = #zero;));
                    stores.extend(quote!(#buffer = #buffer + #value;));
                    after.extend(self.add(target, &quote!(#buffer)));
                }
                // One slice of each vector can be written to while the arithmetic runs.
                Placed::Run(index) if self.is_free(target, &direct) => {
                    let Target::Slope { vector, .. } = target else { continue };
                    direct.push(vector);
                    let base = self.indices.position(&index);
                    opening.extend(quote! {
                        let #buffer = #base;
                        let #buffer = &mut #vector[#buffer..#buffer + __len];
                    });
                    stores.extend(quote!(#buffer[__k] = #buffer[__k] + #value;));
                }
                Placed::Run(index) => {
                    let Target::Slope { vector, .. } = target else { continue };
                    let base = self.indices.position(&index);
                    before.extend(quote!(let mut #buffer = [#zero; #CHUNK];));
                    opening.extend(quote!(let #buffer = &mut #buffer[..__len];));
                    stores.extend(quote!(#buffer[__k] = #value;));
                    scatters.extend(quote! {
                        let __base = #base;
                        for (__sum, &__value) in #vector[__base..__base + __len].iter_mut().zip(&*#buffer) {
                            *__sum = *__sum + __value;
                        }
                    });
                }
                Placed::Each => {
                    before.extend(quote!(let mut #buffer = [#zero; #CHUNK];));
                    opening.extend(quote!(let #buffer = &mut #buffer[..__len];));
                    stores.extend(quote!(#buffer[__k] = #value;));
                    let add = self.add(target, &quote!(#buffer[__k]));
                    scatters.extend(quote! {
                        for __k in 0..__len {
                            let #name = __low + __k as #isize;
                            #add
                        }
                    });
                }
            }
        }
        quote! {
            #before
            let mut #name: #isize = #start;
            let __end: #isize = #end;
            while #name < __end {
                let __low = #name;
                let mut __len = __wzvi::core::cmp::Ord::min((__end - __low) as #usize, #CHUNK);
                #limits
                #opening
                for __k in 0..__len {
                    let #name = __low + __k as #isize;
                    #reads
                    #inside
                    #stores
                }
                #scatters
                #name += __len as #isize;
            }
            #after
        }
    }

    /// An element without loops.
    fn single(&self, inside: &TokenStream, values: &[TokenStream]) -> TokenStream {
        let mut statements = TokenStream::new();
        for (k, local) in self.element.locals.iter().enumerate() {
            let (own, value) = (format_ident!("__l{k}"), self.read(&local.slot));
            statements.extend(quote!(let #own = #value;));
        }
        statements.extend(inside.clone());
        for ((_, target), value) in self.outputs.iter().zip(values) {
            statements.extend(self.add(target, value));
        }
        quote!({ #statements })
    }

    /// A chunk ends where an index wraps around.
    fn limits(&self, inner: &u32) -> TokenStream {
        let mut seen: Vec<&Index> = Vec::new();
        let mut limits = TokenStream::new();
        for local in &self.element.locals {
            for (index, _) in wraps(&slot_index_ref(&local.slot), *inner) {
                if seen.contains(&index) {
                    continue;
                }
                seen.push(index);
                let Some((Atom::Remainder(both), _)) = index.terms.first() else { continue };
                let (at, size) = (self.indices.value(index), self.indices.value(&both.1));
                limits.extend(quote! {
                    __len = __wzvi::core::cmp::Ord::min(
                        __len,
                        (#size - #at) as __wzvi::core::primitive::usize,
                    );
                });
            }
        }
        limits
    }

    fn access(&self, local: &Local, k: usize) -> Access {
        let Some(inner) = self.inner else { return Access::Invariant };
        let reads_inner = match &local.slot {
            Slot::Coordinate(index) | Slot::Momentum(index) | Slot::Number(index) => {
                index.loops().contains(&inner.variable)
            }
            Slot::Entry(_, indices) => indices.iter().any(|index| index.loops().contains(&inner.variable)),
        };
        if !reads_inner {
            return Access::Invariant;
        }
        let is_run = match &local.slot {
            Slot::Coordinate(index) | Slot::Momentum(index) => runs(index, inner.variable),
            Slot::Entry(table, indices) => match indices.as_slice() {
                [index] => runs(index, inner.variable) && self.indices.is_plain(*table),
                _ => false,
            },
            Slot::Number(_) => false,
        };
        if is_run { Access::Slice(format_ident!("__s{k}")) } else { Access::Indexed }
    }

    fn list(&self, slot: &Slot) -> TokenStream {
        match slot {
            Slot::Coordinate(_) => quote!(__at.q),
            Slot::Momentum(_) => quote!(__at.p),
            Slot::Entry(table, _) => self.indices.entry(*table, &[]),
            Slot::Number(_) => TokenStream::new(),
        }
    }

    fn read(&self, slot: &Slot) -> TokenStream {
        match slot {
            Slot::Coordinate(index) => {
                let position = self.indices.position(index);
                quote!(__at.q[#position])
            }
            Slot::Momentum(index) => {
                let position = self.indices.position(index);
                quote!(__at.p[#position])
            }
            Slot::Entry(table, indices) => {
                let entry = self.indices.entry(*table, indices);
                quote!(<__S as __wzvi::Scalar>::from_f64(#entry))
            }
            Slot::Number(index) => {
                let value = self.indices.value(index);
                quote!(<__S as __wzvi::Scalar>::from_f64(
                    #value as __wzvi::core::primitive::isize as __wzvi::core::primitive::f64
                ))
            }
        }
    }

    fn placed(&self, target: &Target, inner: u32) -> Placed {
        match target {
            Target::Total => Placed::Fixed,
            Target::Slope { index, .. } if !index.loops().contains(&inner) => Placed::Fixed,
            Target::Slope { index, .. } if runs(index, inner) => Placed::Run(index.clone()),
            Target::Curvature { row, column, .. }
                if !row.loops().contains(&inner) && !column.loops().contains(&inner) =>
            {
                Placed::Fixed
            }
            _ => Placed::Each,
        }
    }

    fn is_free(&self, target: &Target, taken: &[&Ident]) -> bool {
        matches!(target, Target::Slope { vector, .. } if !taken.contains(&vector))
    }

    fn add(&self, target: &Target, value: &TokenStream) -> TokenStream {
        match target {
            Target::Total => quote!(__total = __total + #value;),
            Target::Slope { vector, index } => {
                let position = self.indices.position(index);
                quote! {
                    let __at_index = #position;
                    #vector[__at_index] = #vector[__at_index] + #value;
                }
            }
            Target::Curvature { method, row, column, is_diagonal } => {
                let (row, column) = (self.indices.position(row), self.indices.position(column));
                quote!(__into.#method(#row, #column, #is_diagonal, #value);)
            }
        }
    }
}

/// How a target moves with the innermost loop.
enum Placed {
    Fixed,
    /// One by one from this index on.
    Run(Index),
    Each,
}

fn slot_index(slot: &Slot) -> Index {
    slot_index_ref(slot).cloned().unwrap_or_default()
}

fn slot_index_ref(slot: &Slot) -> Option<&Index> {
    match slot {
        Slot::Coordinate(index) | Slot::Momentum(index) | Slot::Number(index) => Some(index),
        Slot::Entry(_, indices) => indices.first(),
    }
}

/// Whether the index goes up by one with the loop, perhaps wrapping around.
fn runs(index: &Index, inner: u32) -> bool {
    index.slope(inner) == Some(1) || is_wrap(index, inner)
}

/// `(k + r) % n` with `r` and `n` fixed in the loop.
fn is_wrap(index: &Index, inner: u32) -> bool {
    match index.terms.as_slice() {
        [(Atom::Remainder(both), 1)] if index.constant == 0 => {
            both.0.slope(inner) == Some(1) && !both.1.loops().contains(&inner)
        }
        _ => false,
    }
}

fn wraps<'a>(index: &Option<&'a Index>, inner: u32) -> impl Iterator<Item = (&'a Index, ())> {
    index.filter(|index| is_wrap(index, inner)).map(|index| (index, ())).into_iter()
}
