//! From the lowered model to code: find the facts, check, discretise, describe, emit.

use proc_macro2::TokenStream;

use crate::check::check;
use crate::diagnostics::Diagnostics;
use crate::discretise::describe::describe;
use crate::discretise::embedding::Embedding;
use crate::discretise::facts::{Facts, Hamiltonians};
use crate::discretise::{Scheme, discretise};
use crate::elements;
use crate::emit::emit;
use crate::model::{Model, System};

/// The struct with everything that the compiler gives it, as straight-line code; nothing if a check failed.
pub(crate) fn back_end(mut model: Model, diagnostics: &mut Diagnostics) -> TokenStream {
    let hamiltonians = Hamiltonians::of_model(&model);
    let facts = Facts::new(&mut model.graph, hamiltonians);
    let objections = check(&mut model.graph, &model.embeddings, &facts);
    if !objections.is_empty() {
        objections.into_iter().for_each(|objection| diagnostics.report(objection));
        return TokenStream::new();
    }
    let embeddings: Vec<Embedding> =
        model.embeddings.iter().map(|embedding| embedding.value.clone()).collect();
    let schemes: Vec<Scheme> = embeddings.iter().map(|e| discretise(&mut model, &facts, e)).collect();
    let equations: Vec<String> = schemes.iter().map(|scheme| describe(&mut model, &facts, scheme)).collect();
    emit(&mut model, &facts, &schemes, &equations)
}

/// [`back_end`] in loops; the system again, with what speaks against it, if a check failed.
pub(crate) fn elements_back_end(
    mut system: Box<System>,
) -> Result<TokenStream, (Box<System>, Vec<syn::Error>)> {
    let hamiltonians = Hamiltonians::of_system(&system);
    let facts = Facts::new(&mut system.graph, hamiltonians);
    let objections = check(&mut system.graph, &system.embeddings, &facts);
    if !objections.is_empty() {
        return Err((system, objections));
    }
    let embeddings: Vec<Embedding> =
        system.embeddings.iter().map(|embedding| embedding.value.clone()).collect();
    let equations: Vec<String> =
        embeddings.iter().map(|e| elements::describe::describe(&mut system, &facts, e)).collect();
    Ok(elements::emit::emit(&mut system, &facts, &equations))
}
