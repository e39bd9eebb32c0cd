//! `impl Listed<E>`: what takes the steps of a scheme, and its equations.

use proc_macro2::TokenStream;
use quote::{ToTokens, quote};
use syn::{Generics, ItemStruct};

/// Of the struct `item`, for the type `listed` with the parameters `generics`.
pub(crate) fn listed(
    item: &ItemStruct,
    generics: &Generics,
    listed: &TokenStream,
    scheme: &TokenStream,
    text: &impl ToTokens,
) -> TokenStream {
    let name = &item.ident;
    let (_, arguments, _) = item.generics.split_for_impl();
    let (parameters, _, filter) = generics.split_for_impl();
    quote! {
        #[automatically_derived]
        impl #parameters __wzvi::Listed<#listed> for #name #arguments #filter {
            type Scheme = #scheme;
            const TEXT: &'static __wzvi::str = #text;
        }
    }
}
