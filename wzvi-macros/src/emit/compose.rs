//! `impl Discretized<E>` of schemes that are steps of others, one after the other.

use proc_macro2::TokenStream;
use quote::quote;
use syn::ItemStruct;

use super::embedding_type;
use crate::describe::Texts;
use crate::discretise::embedding::Embedding;

/// Everything that is composed of the schemes that were listed.
pub(super) fn emit(item: &ItemStruct, texts: &Texts) -> TokenStream {
    let mut generated = TokenStream::new();
    for (embedding, text) in &texts.listed {
        let parts = embedding.parts();
        let is_itself = parts.as_slice() == [embedding.clone()];
        if let (Some(first), Some(second), false) = (parts.first(), parts.last(), is_itself) {
            let scheme = embedding_type(embedding, &quote!(__wzvi));
            let composition = Composition {
                parts: [first, second],
                order: quote!(2),
                text: quote!(#text),
                substeps: quote!(__wzvi::compose::of_one::<#scheme>()),
            };
            generated.extend(composition.emit(item, &item.generics, &scheme));
        }
        if embedding.is_symmetric() {
            let base = embedding_type(embedding, &quote!(__wzvi));
            let whole = [embedding.clone()];
            let parts = if parts.is_empty() { &whole } else { parts.as_slice() };
            if let (Some(first), Some(second)) = (parts.first(), parts.last()) {
                generated.extend(composed_of(item, &base, [first, second]));
            }
        }
    }
    generated
}

/// `impl<W> Discretized<Composed<E, W>>`
fn composed_of(item: &ItemStruct, base: &TokenStream, parts: [&Embedding; 2]) -> TokenStream {
    let weights = quote!(__wzvi::compose::Composes<#base>);
    let mut generics = item.generics.clone();
    generics.params.push(syn::parse_quote!(__W: #weights));
    let composition = Composition {
        parts,
        order: quote!(<__W as #weights>::ORDER),
        text: quote!(<Self as __wzvi::Discretized<#base>>::EQUATIONS),
        substeps: quote!(<__W as #weights>::substeps()),
    };
    composition.emit(item, &generics, &quote!(__wzvi::embedding::Composed<#base, __W>))
}

/// A scheme of two kinds of parts, which may be one.
struct Composition<'e> {
    parts: [&'e Embedding; 2],
    order: TokenStream,
    text: TokenStream,
    substeps: TokenStream,
}

impl Composition<'_> {
    /// The implementation of `scheme`, whose parameters are `generics`.
    fn emit(&self, item: &ItemStruct, generics: &syn::Generics, scheme: &TokenStream) -> TokenStream {
        let Self { parts, order, text, substeps } = self;
        let [first, second] = parts.map(|part| embedding_type(part, &quote!(__wzvi)));
        let name = &item.ident;
        let (_, arguments, filter) = item.generics.split_for_impl();
        let (parameters, ..) = generics.split_for_impl();
        quote! {
            __wzvi::composition! {
                [impl #parameters __wzvi::Discretized<#scheme> for #name #arguments #filter]
                #scheme, [#first, #second], #order, #text, #substeps
            }
        }
    }
}
