//! From the lowered model to code: discretise, check, emit.

use proc_macro2::TokenStream;
use quote::quote;

use crate::diagnostics::Diagnostics;
use crate::model::Model;

/// The struct with everything that the compiler gives it.
pub(crate) fn back_end(model: Model, _diagnostics: &mut Diagnostics) -> TokenStream {
    let Model { item, type_checks, .. } = model;
    quote! { #item #type_checks }
}
