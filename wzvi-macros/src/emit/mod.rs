//! From equations to Rust: the struct as written, its traits, and nothing that the scene does not use.

mod compose;
mod gauss;
mod lagrangian;
pub(crate) mod plan;
mod print;
mod program;
pub(crate) mod step;
pub(crate) mod stubs;
mod system;

use proc_macro2::{Ident, Span, TokenStream};
use quote::{ToTokens, quote};

use crate::describe::Texts;
use crate::discretise::Scheme;
use crate::discretise::embedding::Embedding;
use crate::discretise::facts::Facts;
use crate::model::Model;

pub(crate) use print::{Printer, f64_type};
pub(crate) use program::{Level, Lowering, Op};
pub(crate) use system::parameter;

/// Everything that `#[hamiltonian]` stands for. `texts` has those of each scheme, in their order.
pub(crate) fn emit(model: &mut Model, facts: &Facts, schemes: &[Scheme], texts: &Texts) -> TokenStream {
    let mut generated = system::emit(model, facts);
    for (scheme, text) in schemes.iter().zip(&texts.of_parts) {
        generated.extend(step::emit(model, facts, scheme, text));
    }
    generated.extend(gauss::emit(model, facts, texts));
    let Model { item, crate_path, type_checks, .. } = model;
    wrapped(item, crate_path, generated, type_checks, texts)
}

/// The struct as it was written, documented, and `generated` in a scope of its own.
pub(crate) fn wrapped(
    item: &syn::ItemStruct,
    crate_path: &syn::Path,
    mut generated: TokenStream,
    type_checks: &TokenStream,
    texts: &Texts,
) -> TokenStream {
    generated.extend(compose::emit(item, texts));
    let doc = documentation(texts);
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
fn documentation(texts: &Texts) -> TokenStream {
    let blocks = texts.listed.iter().map(|(_, text)| format!("```text\n{text}\n```\n"));
    let text = format!("\n# Discrete equations\n\n{}", blocks.collect::<Vec<_>>().join("\n"));
    quote!(#[doc = #text])
}

/// The scheme as a type of the facade or of what stands for it, by its path.
pub(crate) fn embedding_type(embedding: &Embedding, wzvi: &impl ToTokens) -> TokenStream {
    let wrapped = |name: &str, inner: &Embedding| {
        let (name, inner) = (Ident::new(name, Span::call_site()), embedding_type(inner, wzvi));
        quote!(#wzvi::embedding::#name<#inner>)
    };
    match embedding {
        Embedding::DeltaPlus => quote!(#wzvi::embedding::DeltaPlus),
        Embedding::Midpoint => quote!(#wzvi::embedding::Midpoint),
        Embedding::DeltaMinus => quote!(#wzvi::embedding::DeltaMinus),
        Embedding::Verlet => quote!(#wzvi::embedding::Verlet),
        Embedding::Gauss(stages) => {
            let stages = proc_macro2::Literal::u32_unsuffixed(*stages);
            quote!(#wzvi::embedding::Gauss<#stages>)
        }
        Embedding::Lambda(n, d) => quote!(#wzvi::embedding::Lambda<#n, #d>),
        Embedding::Mixed(drift, noise) => {
            let (drift, noise) = (embedding_type(drift, wzvi), embedding_type(noise, wzvi));
            quote!(#wzvi::embedding::Mixed<#drift, #noise>)
        }
        Embedding::Corrected(inner) => wrapped("Corrected", inner),
        Embedding::Uncorrected(inner) => wrapped("Uncorrected", inner),
    }
}
