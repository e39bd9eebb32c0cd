//! From the lowered model to code: find the facts, check, discretise, describe, emit.

use proc_macro2::TokenStream;

use crate::check::check;
use crate::diagnostics::Diagnostics;
use crate::discretise::describe::describe;
use crate::discretise::embedding::Embedding;
use crate::discretise::facts::Facts;
use crate::discretise::{Scheme, discretise};
use crate::elements;
use crate::emit::emit;
use crate::model::{Model, System};

/// The struct with everything that the compiler gives it; nothing if a check failed.
pub(crate) fn back_end(mut model: Model, diagnostics: &mut Diagnostics) -> TokenStream {
    let facts = Facts::new(&mut model);
    check(&mut model, &facts, diagnostics);
    if diagnostics.has_errors() {
        return TokenStream::new();
    }
    let embeddings: Vec<Embedding> =
        model.embeddings.iter().map(|embedding| embedding.value.clone()).collect();
    let schemes: Vec<Scheme> = embeddings.iter().map(|e| discretise(&mut model, &facts, e)).collect();
    let equations: Vec<String> = schemes.iter().map(|scheme| describe(&mut model, &facts, scheme)).collect();
    emit(&mut model, &facts, &schemes, &equations)
}

/// [`back_end`] for a system with loops; the system again, with what speaks against it, if a check failed.
pub(crate) fn elements_back_end(
    mut system: Box<System>,
) -> Result<TokenStream, (Box<System>, Vec<syn::Error>)> {
    let facts = elements::facts::Facts::new(&mut system);
    let objections = elements::facts::check(&mut system, &facts);
    if !objections.is_empty() {
        return Err((system, objections));
    }
    let equations: Vec<String> = system
        .embeddings
        .iter()
        .map(|embedding| elements::describe::describe(&system, &facts, &embedding.value))
        .collect();
    Ok(elements::emit::emit(&mut system, &facts, &equations))
}
