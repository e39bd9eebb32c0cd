//! `impl Listed<E>`: what takes the steps of a scheme, and its equations.

use proc_macro2::TokenStream;
use quote::quote;
use syn::ItemStruct;

/// Of the struct `item`, for the type `listed`.
pub(crate) fn listed(
    item: &ItemStruct,
    listed: &TokenStream,
    scheme: &TokenStream,
    text: &str,
) -> TokenStream {
    let name = &item.ident;
    let (parameters, arguments, filter) = item.generics.split_for_impl();
    quote! {
        #[automatically_derived]
        impl #parameters __wzvi::Listed<#listed> for #name #arguments #filter {
            type Scheme = #scheme;
            const TEXT: &'static __wzvi::str = #text;
        }
    }
}
