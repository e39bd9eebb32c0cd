//! Schemes that are steps of others, or flows, one after the other.

use proc_macro2::TokenStream;
use quote::quote;
use syn::ItemStruct;

use super::listed::listed;
use super::system::count;
use crate::describe::Texts;
use crate::discretise::facts::flows::Flows;
use crate::embedding::Embedding;

/// What the run time reads of the flows that `Verlet` is made of.
pub(crate) fn flows(item: &ItemStruct, flows: Flows, in_windows: &TokenStream) -> TokenStream {
    let name = &item.ident;
    let (generics, arguments, filter) = item.generics.split_for_impl();
    let reads_time = flows.force_reads_time;
    quote! {
        #[automatically_derived]
        impl #generics __wzvi::compose::Flows for #name #arguments #filter {
            const FORCE_READS_TIME: __wzvi::bool = #reads_time;
            #in_windows
        }
    }
}

/// Everything that is composed of the schemes that were listed.
pub(super) fn emit(item: &ItemStruct, texts: &Texts) -> TokenStream {
    let mut generated = TokenStream::new();
    for (embedding, text) in &texts.listed {
        let scheme = embedding.path(&quote!(__wzvi));
        if embedding.is_thermostat() {
            generated.extend(listed(item, &item.generics, &scheme, &thermostat(embedding), text));
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
        let generics = &item.generics;
        if let Some(whole) = whole {
            let steps = match embedding {
                Embedding::Gauss(_) => quote!(<Self as __wzvi::Listed<#whole>>::Scheme),
                _ => quote! {
                    <#structure as __wzvi::compose::Structure<#whole>>::Steps<
                        __wzvi::compose::One<#whole, #structure>
                    >
                },
            };
            generated.extend(listed(item, generics, &scheme, &steps, text));
        }
        if embedding.is_symmetric() {
            // The parts of the drift may take turns, or steps of the sum; kicks may be by the square of the force, too.
            let (structure, by_table) = match (parted, flows) {
                (Some(_), _) => (quote!(__wzvi::compose::Parted<#structure>), true),
                (None, flows) => (structure, flows.is_some_and(|flows| flows.is_nystrom)),
            };
            generated.extend(composed_of(item, &scheme, (&structure, by_table), text));
        }
    }
    generated
}

/// `impl<W> Listed<Composed<E, W>>`, for weights that compose `E` where a Hamiltonian has this structure; whether the weights say what takes the steps.
fn composed_of(
    item: &ItemStruct,
    base: &TokenStream,
    (structure, by_table): (&TokenStream, bool),
    text: &str,
) -> TokenStream {
    let mut generics = item.generics.clone();
    let weights = quote!(__wzvi::compose::Composes<#base, #structure>);
    let steps = match by_table {
        true => quote!(<__W as #weights>::Steps),
        false => quote! {
            <#structure as __wzvi::compose::Structure<#base>>::Steps<
                __wzvi::compose::Many<#base, #structure, __W>
            >
        },
    };
    if by_table {
        generics.make_where_clause().predicates.push(syn::parse_quote!(#steps: __wzvi::Scheme<Self>));
    }
    generics.params.push(syn::parse_quote!(__W: #weights));
    let length = count(text.len());
    let all = quote!(
        __wzvi::compose::Equations::<Self, #base, #structure, __W, { #length + __wzvi::compose::ROOM }>::ALL
    );
    listed(item, &generics, &quote!(__wzvi::embedding::Composed<#base, __W>), &steps, &all)
}

/// What takes steps with parts in which friction and noise of a bath act.
fn thermostat(embedding: &Embedding) -> TokenStream {
    match embedding {
        Embedding::Thermostat(inner) => {
            let inner = inner.path(&quote!(__wzvi));
            quote!(__wzvi::bath::Around<__wzvi::bath::Isolated<#inner>>)
        }
        Embedding::Splitting(word) => {
            let word = word.types(&quote!(__wzvi));
            quote!(__wzvi::bath::Splitting<#word>)
        }
        word => {
            let word = word.path(&quote!(__wzvi));
            quote!(__wzvi::bath::Splitting<#word>)
        }
    }
}
