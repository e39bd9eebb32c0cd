//! From the analysed model to code: discretise, describe, emit.

use std::collections::HashMap;
use std::rc::Rc;

use proc_macro2::TokenStream;

use crate::describe::{Split, Texts, derived, stepped};
use crate::diagnostics::Located;
use crate::discretise::describe::{describe, hamiltonians, properties};
use crate::discretise::facts::Facts;
use crate::discretise::facts::flows::Flows;
use crate::discretise::facts::kinetic::Kinetic;
use crate::discretise::facts::split;
use crate::discretise::gauss::{self, StepSlopes};
use crate::discretise::sites::Site;
use crate::discretise::{Scheme, discretise};
use crate::elements;
use crate::elements::plan::{Strategy, strategy};
use crate::embedding::Embedding;
use crate::emit::{Beside, emit};
use crate::model::{Model, System};

/// The struct with everything that the compiler gives it: the Hamiltonians, and the steps that cost less that way, as
/// straight-line code.
pub(crate) fn straight_line(mut model: Model, system: &mut System, facts: &Facts) -> TokenStream {
    let listed = values(&model.embeddings);
    let (flows, parts) =
        model.lend(system, |system| (Flows::of(system, facts, &listed), split::forms(system)));
    let is_stepped = |embedding: &Embedding| stepped(&listed, flows).contains(embedding);
    let mut steps = Vec::new();
    for embedding in derived(&listed) {
        let scheme = discretise(&mut model, facts, &embedding);
        let is_swept = system.emission.is_none() && scheme.is_cheaper_swept(facts.noise);
        steps.push(match is_swept {
            false => Step::Inline(Box::new(scheme)),
            true => {
                let strategy = model.lend(system, |system| strategy(system, None, facts, &embedding));
                Step::Swept(embedding, strategy)
            }
        });
    }
    let text = |step: &Step| match step {
        Step::Inline(scheme) => describe(&mut model, facts, scheme),
        Step::Swept(embedding, strategy) => {
            model.lend(system, |system| elements::describe::describe(system, facts, embedding, strategy))
        }
    };
    let of_parts: Vec<String> = steps.iter().map(text).collect();
    let staged: HashMap<u32, String> = stages(&listed)
        .map(|stages| {
            let slopes = StepSlopes::new(&mut model);
            (stages, gauss::describe(&mut model, &slopes, stages))
        })
        .collect();
    let mut declared = String::new();
    hamiltonians(&model, &mut declared);
    let texts = Texts::new(
        &listed,
        Split { flows, parts, has_force: model.has_forces() },
        of_parts,
        |embedding| staged.get(&embedding.stages().unwrap_or(1)).unwrap_or(&declared).clone(),
        |embedding, text| properties(&mut model.graph, facts, embedding, text),
    );
    let swept = steps.iter().zip(&texts.of_parts).filter_map(|(step, text)| match step {
        Step::Inline(_) => None,
        Step::Swept(embedding, strategy) => {
            is_stepped(embedding).then_some((embedding, strategy, text.as_str()))
        }
    });
    let swept: Vec<_> = swept.collect();
    let beside = model.lend(system, |system| {
        let kinetic = if system.friction.is_some() { Kinetic::of(system) } else { None };
        match swept.is_empty() {
            true => Beside { kinetic, ..Beside::default() },
            false => Beside {
                kinetic,
                generated: elements::emit::steps(system, facts, &swept),
                user_tokens: elements::emit::user_tokens(system),
            },
        }
    });
    let inline = steps.iter().zip(&texts.of_parts).filter_map(|(step, text)| match step {
        Step::Inline(scheme) => is_stepped(&scheme.embedding).then_some((&**scheme, text.as_str())),
        Step::Swept(..) => None,
    });
    emit(&mut model, facts, &inline.collect::<Vec<_>>(), beside, &texts)
}

/// How a scheme of a system that is written out is emitted.
enum Step {
    Inline(Box<Scheme>),
    Swept(Embedding, Strategy),
}

/// [`straight_line`], with all of it in loops.
pub(crate) fn in_loops(system: &mut System, facts: &Facts) -> TokenStream {
    let listed = values(&system.embeddings);
    let (flows, parts) = (Flows::of(system, facts, &listed), split::forms(system));
    let site = Site::of(system).map(Rc::new);
    let schemes: Vec<(Embedding, Strategy)> = derived(&listed)
        .into_iter()
        .map(|embedding| {
            let strategy = strategy(system, site.as_ref(), facts, &embedding);
            (embedding, strategy)
        })
        .collect();
    let of_parts = schemes.iter().map(|(e, s)| elements::describe::describe(system, facts, e, s)).collect();
    let staged: HashMap<u32, String> =
        stages(&listed).map(|stages| (stages, elements::staged::describe(system, stages))).collect();
    let declared = format!("\n{}", elements::describe::hamiltonians(system));
    let texts = Texts::new(
        &listed,
        Split { flows, parts, has_force: system.has_forces() },
        of_parts,
        |embedding| staged.get(&embedding.stages().unwrap_or(1)).unwrap_or(&declared).clone(),
        |embedding, text| properties(&mut system.graph, facts, embedding, text),
    );
    let stepped = stepped(&listed, flows);
    let steps = schemes.iter().zip(&texts.of_parts).map(|((e, s), text)| (e, s, text.as_str()));
    let steps = steps.filter(|(embedding, ..)| stepped.contains(embedding));
    elements::emit::emit(system, facts, &steps.collect::<Vec<_>>(), &texts)
}

/// The schemes, and those inside of thermostats.
fn values(embeddings: &[Located<Embedding>]) -> Vec<Embedding> {
    let mut values = Vec::new();
    for Located { value, .. } in embeddings {
        if let Embedding::Thermostat(inner) = value {
            values.push(Embedding::Isolated(inner.clone()));
        }
        values.push(value.clone());
    }
    values
}

/// The numbers of stages of the schemes that have several.
fn stages(listed: &[Embedding]) -> impl Iterator<Item = u32> + '_ {
    listed.iter().filter_map(Embedding::stages)
}
