//! What is implemented for the struct.

use proc_macro2::TokenStream;
use quote::quote;
use syn::ItemStruct;

/// `impl Trait for` the struct.
pub(crate) fn implementation(item: &ItemStruct, of: &TokenStream, body: &TokenStream) -> TokenStream {
    let name = &item.ident;
    let (parameters, arguments, filter) = item.generics.split_for_impl();
    quote! {
        #[automatically_derived]
        impl #parameters #of for #name #arguments #filter {
            #body
        }
    }
}

/// `impl Listed<E>`: what takes the steps of a scheme, and its equations.
pub(crate) fn listed(
    item: &ItemStruct,
    listed: &TokenStream,
    scheme: &TokenStream,
    text: &str,
) -> TokenStream {
    let body = quote! {
        type Scheme = #scheme;
        const TEXT: &'static __wzvi::str = #text;
    };
    implementation(item, &quote!(__wzvi::Listed<#listed>), &body)
}
