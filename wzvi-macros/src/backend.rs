//! From the analysed model to code: discretise, describe, emit.

use std::collections::HashMap;
use std::rc::Rc;

use proc_macro2::TokenStream;

use crate::describe::{Texts, derived};
use crate::discretise::describe::{describe, properties};
use crate::discretise::embedding::Embedding;
use crate::discretise::facts::Facts;
use crate::discretise::gauss::{self, StepSlopes};
use crate::discretise::sites::Site;
use crate::discretise::{Scheme, discretise};
use crate::elements;
use crate::elements::plan::{Strategy, strategy};
use crate::emit::emit;
use crate::model::{Located, Model, System};

/// The struct with everything that the compiler gives it, as straight-line code.
pub(crate) fn back_end(mut model: Model, facts: &Facts) -> TokenStream {
    let listed = values(&model.embeddings);
    let schemes: Vec<Scheme> = derived(&listed).iter().map(|e| discretise(&mut model, facts, e)).collect();
    let of_parts = schemes.iter().map(|scheme| describe(&mut model, facts, scheme)).collect();
    let staged: HashMap<u32, String> = stages(&listed)
        .map(|stages| {
            let slopes = StepSlopes::new(&mut model);
            (stages, gauss::describe(&mut model, &slopes, stages))
        })
        .collect();
    let texts = Texts::new(
        &listed,
        of_parts,
        |embedding| staged.get(&embedding.stages().unwrap_or(1)).cloned().unwrap_or_default(),
        |embedding, text| properties(&mut model.graph, facts, embedding, text),
    );
    emit(&mut model, facts, &schemes, &texts)
}

/// [`back_end`] in loops.
pub(crate) fn elements_back_end(mut system: Box<System>, facts: &Facts) -> TokenStream {
    let listed = values(&system.embeddings);
    let site = Site::of(&mut system).map(Rc::new);
    let schemes: Vec<(Embedding, Strategy)> = derived(&listed)
        .into_iter()
        .map(|embedding| {
            let strategy = strategy(&mut system, site.as_ref(), facts, &embedding);
            (embedding, strategy)
        })
        .collect();
    let of_parts =
        schemes.iter().map(|(e, s)| elements::describe::describe(&mut system, facts, e, s)).collect();
    let staged: HashMap<u32, String> =
        stages(&listed).map(|stages| (stages, elements::staged::describe(&system, stages))).collect();
    let texts = Texts::new(
        &listed,
        of_parts,
        |embedding| staged.get(&embedding.stages().unwrap_or(1)).cloned().unwrap_or_default(),
        |embedding, text| properties(&mut system.graph, facts, embedding, text),
    );
    elements::emit::emit(&mut system, facts, &schemes, &texts)
}

fn values(embeddings: &[Located<Embedding>]) -> Vec<Embedding> {
    embeddings.iter().map(|embedding| embedding.value.clone()).collect()
}

/// The numbers of stages of the schemes that have several.
fn stages(listed: &[Embedding]) -> impl Iterator<Item = u32> + '_ {
    listed.iter().filter_map(Embedding::stages)
}
