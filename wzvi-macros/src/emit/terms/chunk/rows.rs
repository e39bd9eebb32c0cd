//! Pairs: an element whose innermost loop runs over the partners of a fixed body. The loop is in the run
//! time; only the arithmetic of one pair is emitted, for any number type. Tests: `tests/loops/pairs.rs`.

use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

use super::access::{Access, InnerLoop};
use super::{Arithmetic, Chunk, EmittedLoop, slot_index, variable};
use crate::diagnostics::promised;
use crate::discretise::Weighted;
use crate::emit::count;
use crate::emit::terms::kernel::Target;
use crate::indices::Indices;
use crate::model::{Half, Index, Reads, Slot};
use crate::tokens::mentions;

/// The fewest partners that pay: the run time computes this many at once.
const FEWEST_PARTNERS: i128 = 8;

/// The place of the first component of the first partner, if the innermost loop of an element runs over
/// partners: adjacent points, such that the element is a function of their coordinates and of those of a body
/// fixed in the loop.
pub(in crate::emit::terms) fn partners(
    weighted: &Weighted,
    indices: &Indices<'_>,
    components: i128,
) -> Option<Index> {
    let Weighted { element, increments } = weighted;
    let (inner, outer) = element.loops.split_last()?;
    let length = inner.end.subtract(&inner.start).and_then(|length| length.as_integer());
    let is_short = length.is_some_and(|length| length < FEWEST_PARTNERS);
    let changes = increments.iter().any(|number| number.loops().contains(&inner.variable));
    let reads_coordinates = element.reads() == Reads { q: true, p: false } && !element.is_covector();
    if outer.is_empty() || is_short || changes || !reads_coordinates {
        return None;
    }
    let inner_loop = InnerLoop { variable: inner.variable, components };
    let (mut has_body, mut first) = (false, None);
    for local in &element.locals {
        let moved = match (&local.slot, inner_loop.access_without_wrap(&local.slot)) {
            (slot, Access::Invariant) => {
                has_body |= matches!(slot, Slot::State(Half::Coordinates, _));
                continue;
            }
            (Slot::Entry(table, entry), Access::Unit) if entry.len() == 1 && indices.is_plain(*table) => {
                continue;
            }
            (Slot::State(Half::Coordinates, index), Access::Unit) if components == 1 => index.clone(),
            (Slot::State(Half::Coordinates, _), Access::Strided { base, .. }) => base,
            _ => return None,
        };
        if first.as_ref().is_some_and(|known| *known != moved) {
            return None;
        }
        first = Some(moved);
    }
    first.filter(|_| has_body)
}

impl InnerLoop {
    /// The access of the value of a local variable; a gather if it wraps around.
    fn access_without_wrap(self, slot: &Slot) -> Access {
        let wraps = slot.indices().iter().any(|index| self.wraps(index).is_some());
        if wraps { Access::Gather } else { self.slot_access(slot) }
    }
}

/// The arithmetic of one placement, of a pair or in a block.
pub(super) struct Interaction<'a> {
    pub(super) inside: &'a TokenStream,
    /// The names of values common to all placements.
    pub(super) own: Vec<Ident>,
    /// Patterns of the components of a partner.
    pub(super) partner: Vec<TokenStream>,
    /// The names of the other values of each placement.
    pub(super) entries: Vec<Ident>,
    /// The results.
    pub(super) by_own: Vec<TokenStream>,
    pub(super) by_partner: Vec<TokenStream>,
}

impl<'a> Interaction<'a> {
    /// The constants and the weight are common to all placements, unless each has a `weight` of its own.
    pub(super) fn new(Chunk { arithmetic, weight, .. }: &Chunk<'a>) -> Self {
        let Arithmetic { inside, values, constants, .. } = arithmetic;
        let code = quote!(#inside #(#values)*);
        let is_read = |name: &Ident| mentions(&code, &name.to_string());
        let mut entries: Vec<Ident> = Vec::new();
        let mut own: Vec<Ident> = constants.iter().filter(|name| is_read(name)).cloned().collect();
        let list = if weight.is_empty() { &mut own } else { &mut entries };
        list.extend(Some(format_ident!("__factor")).filter(is_read));
        let (partner, by_own, by_partner) = (Vec::new(), Vec::new(), Vec::new());
        Self { inside, own, partner, entries, by_own, by_partner }
    }

    pub(super) fn sizes(&self) -> [Literal; 4] {
        let Self { own, partner, entries, by_own, .. } = self;
        [own.len(), partner.len(), entries.len(), by_own.len()].map(count)
    }

    /// The type that implements it.
    pub(super) fn emit(&self, number: &TokenStream) -> TokenStream {
        let Self { own, partner, entries, inside, by_own, by_partner, .. } = self;
        let (elements, sizes) = (quote!(__wzvi::elements), self.sizes());
        let [of_own, of_partner, of_entries, of_places] = &sizes;
        quote! {
            struct __Interaction;
            impl #elements::Pair<#(#sizes),*> for __Interaction {
                #[cfg_attr(not(debug_assertions), inline(always))]
                fn gradient<#number: __wzvi::Scalar>(
                    [#(#own),*]: [#number; #of_own],
                    [#(#partner),*]: [#number; #of_partner],
                    [#(#entries),*]: [#number; #of_entries],
                ) -> ([#number; #of_places], [#number; #of_partner]) {
                    #inside
                    ([#(#by_own),*], [#(#by_partner),*])
                }
            }
        }
    }
}

impl Chunk<'_> {
    /// The innermost loop as a row of pairs.
    pub(in crate::emit::terms) fn row(&self, first: &Index) -> EmittedLoop {
        let [start, end] = promised(self.range.clone(), "pairs have an innermost loop");
        let mut interaction = Interaction::new(self);
        let (before, lists) = self.open_pair(&mut interaction);
        let places = self.slopes_of_pair(&mut interaction);
        let (items, sizes) = (interaction.emit(&self.derivative.number()), interaction.sizes());
        let (name, of_partner, first) =
            (variable(self.inner.variable), &sizes[1], self.indices.position(first));
        let (own, elements) = (&interaction.own, quote!(__wzvi::elements));
        let buffers = quote! {
            #items
            __by_q.begin_rows::<#of_partner>(&__at.q[0..__at.degrees()]);
        };
        let body = quote! {
            #before
            if let (#name, __len @ 1..) = #elements::stretch(#start, #end) {
                __by_q.row(__Interaction, __at.q, #elements::Row {
                    first: #first,
                    len: __len,
                    own: [#(#own),*],
                    entries: [#(#lists),*],
                    places: [#(#places),*],
                });
            }
        };
        EmittedLoop { buffers, body, after: quote!(__by_q.end_rows::<#of_partner>();) }
    }

    /// The inputs of a pair: values common to the row, read before it, and lists with an entry for each
    /// partner.
    fn open_pair(&self, pair: &mut Interaction<'_>) -> (TokenStream, Vec<TokenStream>) {
        let (mut before, mut lists) = (TokenStream::new(), Vec::new());
        pair.partner = vec![quote!(_); usize::try_from(self.inner.components).unwrap_or(1)];
        for (k, local) in self.read_locals() {
            let (slot, name) = (&local.slot, self.arithmetic.locals[k].clone());
            match (slot, self.inner.access_without_wrap(slot)) {
                (_, Access::Invariant) => {
                    let value = self.read(self.indices, slot);
                    before.extend(quote!(let #name = #value;));
                    pair.own.push(name);
                }
                (Slot::Entry(..), _) => {
                    let (list, at) = (self.list(slot), self.indices.position(&slot_index(slot)));
                    lists.push(quote!(&#list[#at..]));
                    pair.entries.push(name);
                }
                (_, Access::Strided { part, .. }) => pair.partner[part] = quote!(#name),
                (_, Access::Unit | Access::Gather) => pair.partner[0] = quote!(#name),
            }
        }
        (before, lists)
    }

    /// The results of a pair: the slopes by the body, with their places, and those by the partner.
    fn slopes_of_pair(&self, pair: &mut Interaction<'_>) -> Vec<TokenStream> {
        let mut places = Vec::new();
        pair.by_partner = vec![self.derivative.constant(&quote!(-0.0)); pair.partner.len()];
        for ((_, target), value) in self.outputs.iter().zip(&self.arithmetic.values) {
            let Target::Gradient { index, .. } = target else { continue };
            match self.inner.access(index) {
                Access::Invariant => {
                    places.push(self.indices.position(index));
                    pair.by_own.push(value.clone());
                }
                Access::Strided { part, .. } => pair.by_partner[part] = value.clone(),
                Access::Unit | Access::Gather => pair.by_partner[0] = value.clone(),
            }
        }
        places
    }
}
