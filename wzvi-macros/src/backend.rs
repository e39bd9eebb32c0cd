//! From the lowered model to code: find the facts, check, discretise, describe, emit.

use std::rc::Rc;

use proc_macro2::TokenStream;

use crate::check::check;
use crate::diagnostics::Diagnostics;
use crate::discretise::describe::describe;
use crate::discretise::embedding::Embedding;
use crate::discretise::facts::{Facts, Hamiltonians};
use crate::discretise::sites::Site;
use crate::discretise::{Scheme, discretise};
use crate::elements;
use crate::elements::plan::{Strategy, strategy};
use crate::emit::emit;
use crate::model::{Model, System};

/// The struct with everything that the compiler gives it; nothing if a check failed.
pub(crate) fn back_end(mut model: Model, diagnostics: &mut Diagnostics) -> TokenStream {
    let hamiltonians = Hamiltonians::of_model(&model);
    let facts = Facts::new(&mut model.graph, hamiltonians);
    check(&mut model.graph, &model.embeddings, &facts, diagnostics);
    if diagnostics.has_errors() {
        return TokenStream::new();
    }
    let embeddings: Vec<Embedding> =
        model.embeddings.iter().map(|embedding| embedding.value.clone()).collect();
    let schemes: Vec<Scheme> = embeddings.iter().map(|e| discretise(&mut model, &facts, e)).collect();
    let equations: Vec<String> = schemes.iter().map(|scheme| describe(&mut model, &facts, scheme)).collect();
    emit(&mut model, &facts, &schemes, &equations)
}

/// [`back_end`] for a system whose sums stay loops.
pub(crate) fn elements_back_end(mut model: System, diagnostics: &mut Diagnostics) -> TokenStream {
    let hamiltonians = Hamiltonians::of_system(&model);
    let facts = Facts::new(&mut model.graph, hamiltonians);
    check(&mut model.graph, &model.embeddings, &facts, diagnostics);
    if diagnostics.has_errors() {
        return TokenStream::new();
    }
    let embeddings: Vec<Embedding> =
        model.embeddings.iter().map(|embedding| embedding.value.clone()).collect();
    let site = Site::of(&mut model).map(Rc::new);
    let schemes: Vec<(Embedding, Strategy)> = embeddings
        .into_iter()
        .map(|embedding| {
            let strategy = strategy(&mut model, site.as_ref(), &facts, &embedding);
            (embedding, strategy)
        })
        .collect();
    let equations: Vec<String> =
        schemes.iter().map(|(e, s)| elements::describe::describe(&mut model, &facts, e, s)).collect();
    elements::emit::emit(&mut model, &facts, &schemes, &equations)
}
