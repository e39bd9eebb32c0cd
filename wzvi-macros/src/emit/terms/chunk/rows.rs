//! Pairs: an element whose innermost loop goes through partners of a body that is the same in it. The run time has the loop; what is
//! emitted is the arithmetic of one pair, whatever numbers it is done in.

use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

use super::motion::{Motion, motion, moves, wrap};
use super::{Chunk, Emitted, slot_index};
use crate::diagnostics::Promised;
use crate::discretise::Weighted;
use crate::emit::count;
use crate::emit::terms::indices::Indices;
use crate::emit::terms::kernel::Target;
use crate::model::{Half, Index, Reads, Slot};
use crate::tokens::mentions;

/// Rows with less partners gain nothing: the run time takes as many at once.
const SHORT: i128 = 8;

/// The place of the first component of the first partner, if the innermost loop of an element goes through partners: points next to each
/// other, of whose coordinates and of those of a body that the loop does not change the element is a function.
pub(in crate::emit::terms) fn partners(
    weighted: &Weighted,
    indices: &Indices<'_>,
    components: i128,
) -> Option<Index> {
    let Weighted { element, increments } = weighted;
    let (inner, outer) = element.loops.split_last()?;
    let length = inner.end.subtract(&inner.start).and_then(|length| length.as_integer());
    let is_short = length.is_some_and(|length| length < SHORT);
    let changes = increments.iter().any(|number| number.loops().contains(&inner.variable));
    let reads_coordinates = element.reads() == Reads::Coordinates && !element.is_covector();
    if outer.is_empty() || is_short || changes || !reads_coordinates {
        return None;
    }
    let (mut has_body, mut first) = (false, None);
    for local in &element.locals {
        let moved = match (&local.slot, moves_on(&local.slot, inner.variable, components)) {
            (slot, Motion::Fixed) => {
                has_body |= matches!(slot, Slot::State(Half::Coordinates, _));
                continue;
            }
            (Slot::Entry(table, entry), Motion::Run) if entry.len() == 1 && indices.is_plain(*table) => {
                continue;
            }
            (Slot::State(Half::Coordinates, index), Motion::Run) if components == 1 => index.clone(),
            (Slot::State(Half::Coordinates, _), Motion::Points { base, .. }) => base,
            _ => return None,
        };
        if first.as_ref().is_some_and(|known| *known != moved) {
            return None;
        }
        first = Some(moved);
    }
    first.filter(|_| has_body)
}

/// How what a local variable is moves with a loop; freely where it wraps around.
fn moves_on(slot: &Slot, inner: u32, components: i128) -> Motion {
    let wraps = |index: &Index| wrap(index, inner, 1).or_else(|| wrap(index, inner, components)).is_some();
    if slot.indices().iter().any(wraps) { Motion::Free } else { moves(slot, inner, components) }
}

/// The arithmetic of one placement: of a pair, or beside others.
pub(super) struct Interaction<'a> {
    /// The type that it is done in.
    pub(super) number: TokenStream,
    /// The names of what is the same for all.
    pub(super) own: &'a [Ident],
    pub(super) constants: &'a [&'a Ident],
    /// Patterns of the components of a partner.
    pub(super) partner: &'a [TokenStream],
    /// The names of what each placement has besides.
    pub(super) entries: &'a [Ident],
    pub(super) inside: &'a TokenStream,
    /// What it ends in.
    pub(super) by_own: &'a [TokenStream],
    pub(super) by_partner: &'a [TokenStream],
}

impl Interaction<'_> {
    pub(super) fn sizes(&self) -> [Literal; 5] {
        let Self { own, constants, partner, entries, by_own, .. } = self;
        [own.len(), constants.len(), partner.len(), entries.len(), by_own.len()].map(count)
    }

    /// What implements it.
    pub(super) fn emit(&self) -> TokenStream {
        let Self { number, own, constants, partner, entries, inside, by_own, by_partner } = self;
        let (elements, sizes, f64) = (quote!(__wzvi::elements), self.sizes(), quote!(__wzvi::f64));
        let [of_own, of_constants, of_partner, of_entries, of_places] = &sizes;
        quote! {
            struct __Interaction;
            impl #elements::Pair<#(#sizes),*> for __Interaction {
                #[cfg_attr(not(debug_assertions), inline(always))]
                fn slopes<#number: __wzvi::Scalar>(
                    [#(#own),*]: [#number; #of_own],
                    [#(#constants),*]: [#f64; #of_constants],
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
    /// The innermost loop as a row of pairs; `constants` are the names of numbers that no loop changes.
    pub(in crate::emit::terms) fn row(
        &self,
        first: &Index,
        constants: &[Ident],
        inside: &TokenStream,
        values: &[TokenStream],
    ) -> Emitted {
        let (inner, [start, end]) = self.inner.clone().promised("pairs have an innermost loop");
        let name = super::variable(inner);
        let code = quote!(#inside #(#values)*);
        let mut before = TokenStream::new();
        let (mut own, mut entries, mut lists): (Vec<Ident>, Vec<Ident>, Vec<TokenStream>) =
            Default::default();
        let mut partner = vec![quote!(_); usize::try_from(self.components).unwrap_or(1)];
        for (k, local) in self.read_locals(inside, values) {
            let local_name = self.locals[k].clone();
            match (&local.slot, moves_on(&local.slot, inner, self.components)) {
                (slot, Motion::Fixed) => {
                    let value = self.read(slot);
                    before.extend(quote!(let #local_name = #value;));
                    own.push(local_name);
                }
                (Slot::Entry(..), _) => {
                    let (list, at) =
                        (self.list(&local.slot), self.indices.position(&slot_index(&local.slot)));
                    lists.push(quote!(&#list[#at..]));
                    entries.push(local_name);
                }
                (_, motion) => {
                    let part = if let Motion::Points { part, .. } = motion { part } else { 0 };
                    partner[part] = quote!(#local_name);
                }
            }
        }
        let factor = format_ident!("__factor");
        own.extend(mentions(&code, "__factor").then_some(factor));
        let constants: Vec<&Ident> =
            constants.iter().filter(|name| mentions(&code, &name.to_string())).collect();
        let number = self.wanted.number();
        let (mut places, mut by_own, mut by_partner) =
            (Vec::new(), Vec::new(), vec![quote!(#number::from_f64(-0.0)); partner.len()]);
        for ((_, target), value) in self.outputs.iter().zip(values) {
            let Target::Slope { index, .. } = target else { continue };
            match motion(index, inner, self.components) {
                Motion::Fixed => {
                    places.push(self.indices.position(index));
                    by_own.push(value.clone());
                }
                Motion::Points { part, .. } => by_partner[part] = value.clone(),
                Motion::Run | Motion::Free => by_partner[0] = value.clone(),
            }
        }
        let elements = quote!(__wzvi::elements);
        let interaction = Interaction {
            number: number.clone(),
            own: &own,
            constants: &constants,
            partner: &partner,
            entries: &entries,
            inside,
            by_own: &by_own,
            by_partner: &by_partner,
        };
        let (items, sizes) = (interaction.emit(), interaction.sizes());
        let of_partner = &sizes[2];
        let first = self.indices.position(first);
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
                    constants: [#(#constants),*],
                    entries: [#(#lists),*],
                    places: [#(#places),*],
                });
            }
        };
        Emitted { buffers, body, after: quote!(__by_q.end_rows::<#of_partner>();) }
    }
}
