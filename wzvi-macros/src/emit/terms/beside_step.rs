//! Terms beside the step Hamiltonian: the parts of `drift = [H_A, H_B]`, friction, temperature, first
//! integrals, observables. Tests: `tests/forces`.

use proc_macro2::TokenStream;
use quote::quote;

use super::weighted::ElementEmitter;
use super::{Derivative, arm};
use crate::discretise::split::SummandForm;
use crate::discretise::{Facts, Kinetic, Plans, Role, Sum, Weighted, unweighted};
use crate::emit::count;
use crate::emit::overrides::{self, holds};
use crate::model::{Element, Friction, System, Temperature, Term};
use crate::passes::collect::parted;

/// The terms by their roles, and the quantities computed of them.
fn terms(model: &mut System) -> Vec<(Role, Derivative, Sum)> {
    let value = |role: Role, term: &Term| (role, Derivative::Value, unweighted(&term.values));
    let mut all = Vec::new();
    if model.is_logarithmic() && model.summands.is_empty() {
        for (number, elements) in halves(model).into_iter().enumerate() {
            let (role, sum) = (Role::Summand(number), unweighted(&elements));
            all.extend([(role, Derivative::Value, sum.clone()), (role, Derivative::Gradient, sum)]);
        }
    }
    for (number, term) in model.summands.iter().enumerate() {
        let role = Role::Summand(number);
        all.extend([value(role, term), (role, Derivative::Gradient, unweighted(&term.elements))]);
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
            all.push((Role::Friction, Derivative::Hessian, unweighted(&term.elements)));
        }
        Some(Friction { term, .. }) => all.push((Role::Friction, Derivative::Gradient, by_degree(term))),
        None => {}
    }
    match &model.temperature {
        Some(Temperature { term, is_list: true, .. }) => {
            all.push((Role::Temperature, Derivative::Gradient, by_degree(term)));
        }
        Some(Temperature { term, .. }) => all.push(value(Role::Temperature, term)),
        None => {}
    }
    all.extend(model.invariants.iter().enumerate().map(|(number, term)| value(Role::Integral(number), term)));
    let observables = model.observables.iter().enumerate();
    all.extend(observables.map(|(number, term)| value(Role::Observable(number), term)));
    if let Some(clock) = &model.clock {
        all.push(value(Role::Clock, &clock.term));
        all.push((Role::ClockRate, Derivative::Value, unweighted(&clock.rate)));
        if !clock.term.elements.is_empty() {
            all.push((Role::Clock, Derivative::Gradient, unweighted(&clock.term.elements)));
        }
    }
    all
}

/// The kinetic energy and the potential of a drift that is written as a whole.
fn halves(model: &mut System) -> [Vec<Element>; 2] {
    let elements = parted(model, &model.drift.values.clone());
    let (kinetic, potential) = elements.into_iter().partition(|element| element.reads().p);
    [kinetic, potential]
}

/// The arms of these terms, weighted by the step size except for first integrals, observables and clocks.
pub(super) fn arms(model: &mut System, derivative: Derivative) -> TokenStream {
    let weight = derivative.step_size(None);
    let terms = terms(model).into_iter().filter(|(_, known, _)| *known == derivative);
    let mut nests = ElementEmitter { model, derivative };
    let arms = terms.map(|(role, _, sum)| {
        let is_unweighted =
            matches!(role, Role::Integral(_) | Role::Observable(_) | Role::Clock | Role::ClockRate);
        let weight = (!is_unweighted).then_some(&weight);
        arm(role, None, &nests.group(&sum, weight))
    });
    arms.collect()
}

/// The forms of the parts, if the drift is declared in two.
pub(super) fn forms(plans: &Plans) -> Option<TokenStream> {
    let forms = plans.forms?.map(|form| {
        let form = match form {
            SummandForm::Coordinates => quote!(Coordinates),
            SummandForm::Momenta => quote!(Momenta),
            SummandForm::Quadratic => quote!(Quadratic),
            SummandForm::Kepler(components) => {
                let components = count(components);
                quote!(Kepler { components: #components })
            }
        };
        quote!(__wzvi::compose::Form::#form)
    });
    Some(quote!(__wzvi::Some([#(#forms),*])))
}

/// Friction and temperature, if there is friction for a thermostat.
pub(super) fn bath(model: &System, facts: &Facts) -> Option<TokenStream> {
    let (Some(friction), Some(Kinetic { is_diagonal })) = (&model.friction, facts.kinetic) else {
        return None;
    };
    let bath = quote!(__wzvi::bath::Friction);
    let known = overrides::FrictionOverrides {
        is_heated: holds(model.temperature.is_some()),
        is_matrix: holds(friction.is_matrix),
        is_per_state: holds(friction.is_per_place()),
        has_diagonal_masses: (!is_diagonal).then(|| quote!(false)),
        has_temperatures: holds(model.temperature.as_ref().is_some_and(|known| known.is_list)),
        is_timed: holds(model.temperature.as_ref().is_some_and(|known| known.reads_time)),
    };
    let bath = known.over(&bath, quote!(#bath::ALONE));
    Some(quote!(__wzvi::Some(#bath)))
}
