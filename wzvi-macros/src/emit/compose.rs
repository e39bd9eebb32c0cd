//! `impl Discretized<E>` of schemes that are steps of others, or flows, one after the other.

use proc_macro2::TokenStream;
use quote::quote;
use syn::ItemStruct;

use super::plan::Plan;
use super::system::count;
use crate::describe::Texts;
use crate::discretise::facts::Facts;
use crate::discretise::facts::flows::Flows;
use crate::embedding::Embedding;

/// The plan of a step that is made of flows.
pub(crate) fn explicit_plan(facts: &Facts) -> TokenStream {
    Plan {
        solver: quote!(Explicit),
        unknowns: quote!(0),
        order: 2,
        noise: facts.noise,
        consistent: true,
        conserves_energy: &facts.conserves_energy,
        commuting: &facts.commuting,
    }
    .emit()
}

/// What the run time reads of the flows that `Verlet` is made of.
pub(crate) fn flows(item: &ItemStruct, flows: Flows, facts: &Facts, in_place: &TokenStream) -> TokenStream {
    let plan = explicit_plan(facts);
    let name = &item.ident;
    let (generics, arguments, filter) = item.generics.split_for_impl();
    let (reads_time, is_in_place) = (flows.force_reads_time, !in_place.is_empty());
    quote! {
        #[automatically_derived]
        impl #generics __wzvi::compose::Flows for #name #arguments #filter {
            const PLAN: __wzvi::Plan = #plan;
            const FORCE_READS_TIME: __wzvi::bool = #reads_time;
            const IN_PLACE: __wzvi::bool = #is_in_place;
            #in_place
        }
    }
}

/// Everything that is composed of the schemes that were listed.
pub(super) fn emit(item: &ItemStruct, texts: &Texts) -> TokenStream {
    let mut generated = TokenStream::new();
    for (embedding, text) in &texts.listed {
        let scheme = embedding.path(&quote!(__wzvi));
        if embedding.is_thermostat() {
            generated.extend(thermostat(embedding, text).emit(item, &item.generics, &scheme));
            continue;
        }
        // Inside of a thermostat, what the step is made of has the name that it has outside.
        let own = if let Embedding::Isolated(inner) = embedding { inner } else { embedding };
        let flows = texts.flows.filter(|_| *own == Embedding::Verlet);
        let structure = match flows {
            None => quote!(__wzvi::compose::General),
            Some(Flows { is_nystrom: false, .. }) => quote!(__wzvi::compose::Separable),
            Some(Flows { is_nystrom: true, .. }) => quote!(__wzvi::compose::Nystrom),
        };
        let parted = texts.parts.filter(|_| *embedding == Embedding::Verlet);
        // `Gauss<1>` is a step of `Midpoint`.
        let whole = match embedding.parts().as_slice() {
            [] => None,
            [whole] => (whole != embedding).then(|| whole.path(&quote!(__wzvi))),
            _ => Some(own.path(&quote!(__wzvi))),
        };
        if let Some(whole) = whole {
            let composition = Composition {
                sequence: sequence_of(&whole, &structure),
                order: quote!(2),
                text: quote!(#text),
                substeps: quote!(__wzvi::compose::of_one::<#whole, #structure>()),
            };
            generated.extend(composition.emit(item, &item.generics, &scheme));
        }
        if embedding.is_symmetric() {
            let composed = match (parted, flows) {
                (Some(_), _) => Composed::ByTable(quote!(__wzvi::compose::Parted<#structure>)),
                (None, Some(Flows { is_nystrom: true, .. })) => Composed::ByTable(structure),
                _ => Composed::ByStructure(structure),
            };
            generated.extend(composed_of(item, &scheme, &composed, text));
        }
    }
    generated
}

/// What says how the parts of a composition are taken, with the structure of the system.
enum Composed {
    ByStructure(TokenStream),
    /// The parts of the drift may take turns, or steps of the sum; kicks may be by the square of the force, too.
    ByTable(TokenStream),
}

/// `impl<W> Discretized<Composed<E, W>>`
fn composed_of(item: &ItemStruct, base: &TokenStream, composed: &Composed, text: &str) -> TokenStream {
    let mut generics = item.generics.clone();
    let (Composed::ByStructure(structure) | Composed::ByTable(structure)) = composed;
    let weights = quote!(__wzvi::compose::Composes<#base, #structure>);
    let sequence;
    if let Composed::ByTable(_) = composed {
        sequence = quote!(<__W as #weights>::Sequence);
        let filter = generics.make_where_clause();
        filter.predicates.push(syn::parse_quote!(#sequence: __wzvi::compose::Sequence<Self>));
    } else {
        sequence = sequence_of(base, structure);
    }
    generics.params.push(syn::parse_quote!(__W: #weights));
    let length = count(text.len());
    let composition = Composition {
        sequence,
        order: quote!(<__W as #weights>::ORDER),
        text: quote!(
            __wzvi::compose::Equations::<Self, #base, #structure, __W, { #length + __wzvi::compose::ROOM }>::ALL
        ),
        substeps: quote!(<__W as #weights>::substeps()),
    };
    composition.emit(item, &generics, &quote!(__wzvi::embedding::Composed<#base, __W>))
}

/// A step with parts in which friction and noise of a bath act.
fn thermostat(embedding: &Embedding, text: &str) -> Composition {
    let sequence = match embedding {
        Embedding::Thermostat(inner) => {
            let inner = inner.path(&quote!(__wzvi));
            quote!(__wzvi::bath::Around<__wzvi::bath::Isolated<#inner>>)
        }
        word => {
            let word = word.path(&quote!(__wzvi));
            quote!(__wzvi::bath::Splitting<#word>)
        }
    };
    let order = proc_macro2::Literal::u32_unsuffixed(embedding.order());
    Composition { sequence, order: quote!(#order), text: quote!(#text), substeps: quote!([]) }
}

/// What steps of a scheme are made of for a structure.
fn sequence_of(scheme: &TokenStream, structure: &TokenStream) -> TokenStream {
    quote!(<#structure as __wzvi::compose::Structure<#scheme>>::Sequence)
}

/// A scheme whose steps are a sequence of parts.
struct Composition {
    sequence: TokenStream,
    order: TokenStream,
    text: TokenStream,
    substeps: TokenStream,
}

impl Composition {
    /// The implementation of `scheme`, whose parameters are `generics`.
    fn emit(&self, item: &ItemStruct, generics: &syn::Generics, scheme: &TokenStream) -> TokenStream {
        let Self { sequence, order, text, substeps } = self;
        let name = &item.ident;
        let (_, arguments, _) = item.generics.split_for_impl();
        let (parameters, _, filter) = generics.split_for_impl();
        quote! {
            __wzvi::composition! {
                [impl #parameters __wzvi::Discretized<#scheme> for #name #arguments #filter]
                #scheme, #sequence, #order, #text, #substeps
            }
        }
    }
}
