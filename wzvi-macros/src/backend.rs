//! From the analysed system to code: discretise, describe, emit.

use std::collections::HashMap;

use crate::describe::{Split, Texts, derived};
use crate::diagnostics::{Located, internal};
use crate::discretise::describe::{describe, hamiltonians, properties};
use crate::discretise::facts::Facts;
use crate::discretise::facts::flows::{Flows, is_nystrom};
use crate::discretise::facts::split;
use crate::discretise::gauss::{self, StepSlopes};
use crate::elements;
use crate::elements::plan::Step;
use crate::embedding::Embedding;
use crate::emit::{Expansion, emit};
use crate::model::{StraightLine, System};
use crate::passes::unroll::written_out;

/// The struct with everything that the compiler gives it: terms and steps as straight lines, or in loops.
pub(crate) fn generate(system: &mut System, facts: &Facts) -> Expansion {
    let line = written_out(system);
    let line = line.as_ref();
    let listed = values(&system.embeddings);
    let (flows, parts) = (Flows::of(system, facts, &listed), split::forms(system));
    let steps: Vec<Step> =
        derived(&listed).iter().map(|embedding| Step::of(system, line, facts, embedding)).collect();
    let of_parts = steps.iter().map(|step| text(system, line, facts, step)).collect();
    let stages = listed.iter().filter_map(Embedding::stages);
    let staged: HashMap<u32, String> =
        stages.map(|stages| (stages, staged(system, line, facts, stages))).collect();
    let declared = match line {
        Some(line) => hamiltonians(&system.graph, line),
        None => format!("\n{}", elements::describe::hamiltonians(system)),
    };
    let texts = Texts::new(
        &listed,
        Split { flows, parts, has_force: system.has_forces() },
        of_parts,
        |embedding| staged.get(&embedding.stages().unwrap_or(1)).unwrap_or(&declared).clone(),
        |embedding, text| properties(&mut system.graph, facts, embedding, text),
    );
    emit(system, line, facts, &steps, &texts)
}

/// What is said of a step.
fn text(system: &mut System, line: Option<&StraightLine>, facts: &Facts, step: &Step) -> String {
    match (step, line) {
        (Step::StraightLine(scheme), Some(line)) => describe(&mut system.graph, line, facts, scheme),
        (Step::InLoops(embedding, strategy), _) => {
            elements::describe::describe(system, facts, embedding, *strategy)
        }
        (Step::StraightLine(_), None) => {
            internal::broken("steps in straight lines are of systems that are");
            String::new()
        }
    }
}

/// What is said of a scheme with several stages.
fn staged(system: &mut System, line: Option<&StraightLine>, facts: &Facts, stages: u32) -> String {
    let is_nystrom = is_nystrom(system, facts);
    match line {
        Some(line) => {
            let slopes = StepSlopes::new(&mut system.graph, line, is_nystrom);
            gauss::describe(&mut system.graph, line, &slopes, stages)
        }
        None => elements::staged::describe(system, stages),
    }
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
