//! Terms with numbers of their own: the parts of `drift = [H_A, H_B]`, friction, temperature, first
//! integrals. Tests: `tests/forces`.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use super::weighted::ElementEmitter;
use super::{Derivative, arm};
use crate::discretise::{Facts, Kinetic, Part, Plans, Sum, Weighted, unweighted};
use crate::emit::count;
use crate::emit::overrides::{self, holds};
use crate::model::{Friction, System, Temperature, Term};

/// The numbers of the parts after those of the step Hamiltonian: parts of the drift, friction, temperature,
/// first integrals.
pub(super) struct PartNumbers {
    pub(super) parts: usize,
    pub(super) friction: usize,
    pub(super) temperature: usize,
    pub(super) integrals: usize,
}

impl PartNumbers {
    pub(super) fn of(model: &System) -> Self {
        let last = if model.force.is_some() { Part::Force } else { Part::CounterTerm };
        let parts = last as usize + 1;
        let friction = parts + model.summands.len();
        let temperature = friction + usize::from(model.friction.is_some());
        let integrals = temperature + usize::from(model.temperature.is_some());
        Self { parts, friction, temperature, integrals }
    }
}

/// The terms with numbers of their own, and the quantities computed of them.
fn numbered(model: &mut System) -> Vec<(usize, Derivative, Sum)> {
    let numbers = PartNumbers::of(model);
    let value = |number: usize, term: &Term| (number, Derivative::Value, unweighted(&term.values));
    let mut all = Vec::new();
    for (number, term) in (numbers.parts..).zip(&model.summands) {
        all.extend([value(number, term), (number, Derivative::Gradient, unweighted(&term.elements))]);
    }
    let mut by_degree = |term: &Term| {
        let mut elements = unweighted(&term.elements);
        for Weighted { element, .. } in &mut elements {
            // The entries without the momenta they act on.
            let one = model.graph.integer(1);
            let momenta = element.momenta().map(|(momentum, _)| (momentum, one)).collect();
            element.value = model.graph.substitute(&[element.value], &momenta)[0];
        }
        elements
    };
    match &model.friction {
        Some(Friction { term, is_matrix: true, .. }) => {
            all.push((numbers.friction, Derivative::Hessian, unweighted(&term.elements)));
        }
        Some(Friction { term, .. }) => all.push((numbers.friction, Derivative::Gradient, by_degree(term))),
        None => {}
    }
    match &model.temperature {
        Some(Temperature { term, is_list: true, .. }) => {
            all.push((numbers.temperature, Derivative::Gradient, by_degree(term)));
        }
        Some(Temperature { term, .. }) => all.push(value(numbers.temperature, term)),
        None => {}
    }
    all.extend((numbers.integrals..).zip(&model.invariants).map(|(number, term)| value(number, term)));
    all
}

/// The arms of the numbered terms, weighted by the step size except for first integrals.
pub(super) fn arms(model: &mut System, derivative: Derivative) -> TokenStream {
    let (weight, first_integral) = (derivative.step_size(None), PartNumbers::of(model).integrals);
    let terms = numbered(model).into_iter().filter(|(_, known, _)| *known == derivative);
    let mut nests = ElementEmitter { model, derivative };
    let arms = terms.map(|(number, _, sum)| {
        let weight = (number < first_integral).then_some(&weight);
        arm(number, None, &nests.group(&sum, weight))
    });
    arms.collect()
}

/// The number and the forms of the parts, if the drift is declared in two.
pub(super) fn forms(model: &System, plans: &Plans) -> Option<TokenStream> {
    let forms = plans.forms?.map(|form| {
        let form = format_ident!("{}", format!("{form:?}"));
        quote!(__wzvi::compose::Form::#form)
    });
    let first = count(PartNumbers::of(model).parts);
    Some(quote!(__wzvi::Some((#first, [#(#forms),*]))))
}

/// Friction and temperature as parts with numbers of their own, if there is friction for a thermostat.
pub(super) fn bath(model: &System, facts: &Facts) -> Option<TokenStream> {
    let (Some(friction), Some(Kinetic { is_diagonal })) = (&model.friction, facts.kinetic) else {
        return None;
    };
    let numbers = PartNumbers::of(model);
    let (number, bath) = (count(numbers.friction), quote!(__wzvi::bath::Friction));
    let temperature = match &model.temperature {
        Some(_) => {
            let number = count(numbers.temperature);
            quote!(__wzvi::Some(#number))
        }
        None => quote!(__wzvi::None),
    };
    let known = overrides::FrictionOverrides {
        is_matrix: holds(friction.is_matrix),
        is_per_state: holds(friction.is_per_place()),
        has_diagonal_masses: (!is_diagonal).then(|| quote!(false)),
        has_temperatures: holds(model.temperature.as_ref().is_some_and(|known| known.is_list)),
        is_timed: holds(model.temperature.as_ref().is_some_and(|known| known.reads_time)),
    };
    let bath = known.over(&bath, quote!(#bath::new(#number, #temperature)));
    Some(quote!(__wzvi::Some(#bath)))
}
