//! From the analysed model to code: discretise, describe, emit.

use std::rc::Rc;

use proc_macro2::TokenStream;

use crate::discretise::describe::describe;
use crate::discretise::embedding::Embedding;
use crate::discretise::facts::Facts;
use crate::discretise::sites::Site;
use crate::discretise::{Scheme, discretise};
use crate::elements;
use crate::elements::plan::{Strategy, strategy};
use crate::emit::emit;
use crate::model::{Model, System};

/// The struct with everything that the compiler gives it, as straight-line code.
pub(crate) fn back_end(mut model: Model, facts: &Facts) -> TokenStream {
    let embeddings: Vec<Embedding> =
        model.embeddings.iter().map(|embedding| embedding.value.clone()).collect();
    let schemes: Vec<Scheme> = embeddings.iter().map(|e| discretise(&mut model, facts, e)).collect();
    let equations: Vec<String> = schemes.iter().map(|scheme| describe(&mut model, facts, scheme)).collect();
    emit(&mut model, facts, &schemes, &equations)
}

/// [`back_end`] in loops.
pub(crate) fn elements_back_end(mut system: Box<System>, facts: &Facts) -> TokenStream {
    let embeddings: Vec<Embedding> =
        system.embeddings.iter().map(|embedding| embedding.value.clone()).collect();
    let site = Site::of(&mut system).map(Rc::new);
    let schemes: Vec<(Embedding, Strategy)> = embeddings
        .into_iter()
        .map(|embedding| {
            let strategy = strategy(&mut system, site.as_ref(), facts, &embedding);
            (embedding, strategy)
        })
        .collect();
    let equations: Vec<String> =
        schemes.iter().map(|(e, s)| elements::describe::describe(&mut system, facts, e, s)).collect();
    elements::emit::emit(&mut system, facts, &schemes, &equations)
}
