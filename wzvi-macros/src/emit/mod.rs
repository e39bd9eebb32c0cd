//! From equations to Rust: the struct as written, its traits, and nothing that the scene does not use.

mod lagrangian;
mod print;
mod program;
mod step;
pub(crate) mod stubs;
mod system;

use proc_macro2::TokenStream;
use quote::quote;

use crate::discretise::Scheme;
use crate::discretise::embedding::Embedding;
use crate::discretise::facts::Facts;
use crate::model::Model;

/// Everything that `#[hamiltonian]` stands for. `equations` has the text of each scheme, in their order.
pub(crate) fn emit(
    model: &mut Model,
    facts: &Facts,
    schemes: &[Scheme],
    equations: &[String],
) -> TokenStream {
    let mut generated = system::emit(model, facts);
    for (scheme, text) in schemes.iter().zip(equations) {
        generated.extend(step::emit(model, facts, scheme, text));
    }
    let Model { item, crate_path, type_checks, .. } = model;
    let doc = documentation(equations);
    quote! {
        #doc
        #item
        #[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction, clippy::cargo)]
        const _: () = {
            use #crate_path::__private as __wzvi;
            #generated
        };
        #type_checks
    }
}

/// The equations as rustdoc of the struct.
fn documentation(equations: &[String]) -> TokenStream {
    let blocks = equations.iter().map(|text| format!("```text\n{text}\n```\n"));
    let text = format!("\n# Discrete equations\n\n{}", blocks.collect::<Vec<_>>().join("\n"));
    quote!(#[doc = #text])
}

/// The type of an embedding, by absolute path.
pub(crate) fn embedding_type(embedding: &Embedding) -> TokenStream {
    match embedding {
        Embedding::DeltaPlus => quote!(__wzvi::embedding::DeltaPlus),
        Embedding::Midpoint => quote!(__wzvi::embedding::Midpoint),
        Embedding::DeltaMinus => quote!(__wzvi::embedding::DeltaMinus),
        Embedding::Lambda(n, d) => quote!(__wzvi::embedding::Lambda<#n, #d>),
        Embedding::Mixed(drift, noise) => {
            let (drift, noise) = (embedding_type(drift), embedding_type(noise));
            quote!(__wzvi::embedding::Mixed<#drift, #noise>)
        }
        Embedding::Corrected(inner) => {
            let inner = embedding_type(inner);
            quote!(__wzvi::embedding::Corrected<#inner>)
        }
        Embedding::Uncorrected(inner) => {
            let inner = embedding_type(inner);
            quote!(__wzvi::embedding::Uncorrected<#inner>)
        }
    }
}
