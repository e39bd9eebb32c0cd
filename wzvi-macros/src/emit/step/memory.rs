//! The memory of the Newton blocks of a step: one extrapolation each.

use proc_macro2::TokenStream;
use quote::quote;

use crate::emit::system::count;

/// The largest tuples with trait implementations in the standard library.
const PARTS: usize = 12;

/// The type for numbers `__S`.
pub(super) fn memory_type(sizes: &[usize]) -> TokenStream {
    let extrapolation = |&size: &usize| {
        let size = count(size);
        quote!(__wzvi::Extrapolation<__S, #size>)
    };
    match sizes {
        // The parameter of the alias must be used.
        [] => quote!(__wzvi::PhantomData<__S>),
        [size] => extrapolation(size),
        sizes => tuple(sizes.iter().map(extrapolation).collect()),
    }
}

/// The part of block `index` of `count` blocks.
pub(super) fn memory_of(index: usize, blocks: usize) -> TokenStream {
    let place = if blocks == 1 { TokenStream::new() } else { place_in_tuple(index, blocks) };
    quote!(__memory #place)
}

/// A tuple of any number of types, values or patterns, in tuples of tuples.
pub(super) fn tuple(types: Vec<TokenStream>) -> TokenStream {
    if types.len() <= PARTS {
        return quote!((#(#types,)*));
    }
    tuple(types.chunks(PARTS).map(|part| tuple(part.to_vec())).collect())
}

/// `.0.3`: part `index` of a [`tuple`] of `parts` types.
fn place_in_tuple(index: usize, parts: usize) -> TokenStream {
    let digit = count(index % PARTS);
    let outer = match parts <= PARTS {
        true => TokenStream::new(),
        false => place_in_tuple(index / PARTS, parts.div_ceil(PARTS)),
    };
    quote!(#outer . #digit)
}
