//! Vectorised placements that are not adjacent in the state: they read places from a table, or places far
//! apart. Inputs are gathered one by one, and results are added one by one, in order. The arithmetic in
//! between is done for a block of placements at once, in any number type.
//!
//! Tests: `tests/loops/tables.rs`.

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use super::access::{Access, InnerLoop};
use super::{Arithmetic, Chunk, rows};
use crate::emit::terms::kernel::{Target, is_total};
use crate::emit::terms::tiles::is_correctly_rounded;
use crate::indices::{Indices, OpenList};
use crate::model::{Atom, Element, Half, Index, Slot, Table};
use crate::symbolic::{Expr, Graph};

/// The parts of lists that the innermost loop of an element reads entry by entry.
pub(in crate::emit::terms) fn open_lists(element: &Element, tables: &[Table]) -> Vec<OpenList> {
    let mut open = Vec::new();
    let Some(inner) = element.loops.last() else { return open };
    for local in &element.locals {
        match &local.slot {
            Slot::State(_, index) | Slot::Number(index) => {
                open_lists_of(index, inner.variable, tables, &mut open);
            }
            Slot::Entry(table, indices) => open_list(*table, indices, inner.variable, tables, &mut open),
            Slot::Collective(_) => {}
        }
    }
    open
}

fn open_lists_of(index: &Index, inner: u32, tables: &[Table], open: &mut Vec<OpenList>) {
    for (atom, _) in &index.terms {
        match atom {
            Atom::Given(table, indices) => open_list(*table, indices, inner, tables, open),
            Atom::Loop(_) | Atom::Size => {}
            Atom::Of(_, both) => {
                for index in [&both.0, &both.1] {
                    open_lists_of(index, inner, tables, open);
                }
            }
        }
    }
}

/// Opens the list at the first index that changes with the loop.
fn open_list(table: u32, indices: &[Index], inner: u32, tables: &[Table], open: &mut Vec<OpenList>) {
    for index in indices {
        open_lists_of(index, inner, tables, open);
    }
    let Some(place) = indices.iter().position(|index| index.loops().contains(&inner)) else { return };
    let first = &indices[place];
    if first.slope(inner) != Some(1) {
        return;
    }
    let tokens = Indices::unchecked(tables).list(table, &indices[..place]);
    let is_same = |known: &OpenList| known.first == *first && known.tokens.to_string() == tokens.to_string();
    if !open.iter().any(is_same) {
        let name = format_ident!("__list{}", open.len());
        open.push(OpenList { tokens, first: first.clone(), name });
    }
}

/// The code of a block of placements.
pub(super) struct GatheredBlock {
    /// Before the loop over their chunks.
    pub(super) items: TokenStream,
    /// The names of their slopes.
    pub(super) values: Vec<TokenStream>,
    /// Opens lists for a chunk.
    pub(super) opening: TokenStream,
    /// The lists of `__few` placements.
    lists: TokenStream,
    /// The gathering of inputs, and the computation of all placements.
    read: TokenStream,
    compute: TokenStream,
    /// Binds the names to the slopes of one placement.
    open: TokenStream,
}

/// Whether the innermost loop of an element reads the state at places that are not adjacent, or adds to a
/// collective variable or reads one, and calls functions, so that gathering pays. Products and quotients
/// alone are cheaper than gathering their operands.
pub(in crate::emit::terms) fn gathers(
    graph: &Graph,
    element: &Element,
    outputs: &[(Expr, Target)],
    components: i128,
) -> bool {
    let Some(inner) = element.loops.last() else { return false };
    let inner_loop = InnerLoop { variable: inner.variable, components };
    let is_free = |slot: &Slot| {
        matches!(slot, Slot::State(Half::Coordinates | Half::Momenta, _))
            && matches!(inner_loop.slot_access(slot), Access::Gather)
    };
    let state = element.state();
    let is_long = |part: Expr| {
        let (mut reads_state, node) = (false, graph.node(part));
        node.for_each_operand(|operand| reads_state |= graph.depends_on(operand, &state));
        reads_state && !is_correctly_rounded(node)
    };
    let is_one_by_one = is_total(outputs) || element.is_collective();
    let values: Vec<Expr> = match is_total(outputs) {
        true => outputs.iter().map(|(value, _)| *value).collect(),
        false => vec![element.value],
    };
    (is_one_by_one || element.locals.iter().any(|local| is_free(&local.slot)))
        && graph.reachable(&values).into_iter().any(is_long)
}

impl Chunk<'_> {
    /// The block with its arithmetic, which reads these lists.
    pub(super) fn gather(&self, lists: &[OpenList]) -> GatheredBlock {
        let (Arithmetic { values, locals, .. }, weight) = (self.arithmetic, self.weight);
        let mut interaction = rows::Interaction::new(self);
        for (k, local) in self.read_locals() {
            let read = match self.access(&local.slot) {
                Access::Invariant => &mut interaction.own,
                Access::Unit | Access::Strided { .. } | Access::Gather => &mut interaction.entries,
            };
            read.push(locals[k].clone());
        }
        interaction.by_own.clone_from(values);
        let number = self.derivative.number();
        let (items, [of_own, _, of_entries, of_values]) = (interaction.emit(&number), interaction.sizes());
        let rows::Interaction { own, entries, .. } = interaction;
        let names: Vec<Ident> = (0..values.len()).map(|j| format_ident!("__slope{j}")).collect();
        let opened = lists.iter().map(|OpenList { tokens, first, name }| {
            let first = self.indices.position(first);
            quote! {
                let #name = #first;
                let #name = &#tokens[#name..#name + __len];
            }
        });
        let lists =
            lists.iter().map(|OpenList { name, .. }| quote!(let #name = &#name[__first..__first + __few];));
        GatheredBlock {
            opening: quote!(#(#opened)*),
            lists: quote!(#(#lists)*),
            items: quote! {
                #items
                let mut __block = __wzvi::elements::Placements::<
                    __S, #number, __S::OfElements<Self::CommonRange>, #of_entries, #of_values
                >::new();
            },
            values: names.iter().map(|name| quote!(#name)).collect(),
            read: quote!(#weight __block.read(__lane, [#(#entries),*]);),
            compute: quote! {
                __block.take::<__Interaction, #of_own>(__few, [#(#own),*]);
            },
            open: quote!(let [#(#names),*] = __block.gradient(__lane);),
        }
    }
}

impl GatheredBlock {
    /// The loop over the placements of a chunk; `place` binds the variable of the loop, if some code mentions
    /// it.
    pub(super) fn over_chunk(
        &self,
        place: &dyn Fn(&TokenStream) -> Option<TokenStream>,
        reads: &TokenStream,
        stores: &TokenStream,
    ) -> TokenStream {
        let Self { lists, read, compute, open, .. } = self;
        let (read, store) = (quote!(#reads #read), quote!(#open #stores));
        let [at_read, at_store] = [&read, &store].map(place);
        quote! {
            let mut __first = 0;
            while __first < __len {
                let __few = __block.few(__len - __first);
                #lists
                for __lane in 0..__few {
                    let __place = __first + __lane;
                    #at_read
                    #read
                }
                #compute
                for __lane in 0..__few {
                    let __place = __first + __lane;
                    #at_store
                    #store
                }
                __first += __few;
            }
        }
    }
}
