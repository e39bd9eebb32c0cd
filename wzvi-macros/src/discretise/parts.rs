//! The parts of the step Hamiltonian as sums of elements, each with the increments that weigh it:
//! `ℓ_e = -w c_e H_e(P, Q_l)` is an element of the discrete Lagrangian, and its slopes and curvatures are
//! those of `D_1 L_d`, `D_2 L_d` and `∂L_d/∂P`.

use std::collections::HashMap;

use crate::discretise::{Facts, Part, Quadrature, Sum, Weighted, summed};
use crate::model::{Element, System};
use crate::symbolic::{Graph, SymbolKind};

/// One part.
#[derive(Clone)]
pub(crate) struct PartElements {
    pub(crate) part: Part,
    /// As written by the user: for values, to keep their accuracy.
    pub(crate) values: Sum,
    /// Elements in coordinates only, momenta only, or inseparable in both: for derivatives.
    pub(crate) elements: Sum,
    /// Whether some scheme has a weight other than 1 for it.
    pub(crate) is_weighted: bool,
}

/// The parts used by the schemes of `system`.
pub(crate) fn parts_of(system: &System, facts: &Facts) -> Vec<PartElements> {
    let [drift, noise, force] = summed(system, |term| &term.values);
    let [parted_drift, parted_noise, parted_force] = summed(system, |term| &term.elements);
    let counter_term = facts.counter_term.sum.clone().unwrap_or_default();
    let schemes = system.embeddings.iter().map(|known| Quadrature::new(facts, &known.value));
    let schemes: Vec<Quadrature> = schemes.collect();
    let sums = [
        (Part::Drift, drift, parted_drift),
        (Part::Noise, noise, parted_noise),
        (Part::CounterTerm, counter_term.clone(), counter_term),
        (Part::Force, force, parted_force),
    ];
    let used = sums.into_iter().filter_map(|(part, values, elements)| {
        let weights: Vec<_> = schemes.iter().flat_map(|scheme| scheme.weights_of(part)).collect();
        let is_weighted = weights.iter().any(|weight| !weight.is_one());
        (!weights.is_empty()).then_some(PartElements { part, values, elements, is_weighted })
    });
    used.collect()
}

/// The loop variable that numbers the members of the family of noises of an element, each with its own
/// increment.
pub(crate) fn family_of(Weighted { element, increments }: &Weighted) -> Option<u32> {
    let [number] = increments.as_slice() else { return None };
    let outermost = element.loops.first()?.variable;
    number.loops().contains(&outermost).then_some(outermost)
}

/// The elements of `K = s H(q, p / s)` with `s = e^{γ (t - t_i)}` instead of those of `H`, and of
/// `s f(q, p / s)` instead of those of a force; collective variables are those of `p / s`.
pub(crate) fn scale_momenta(system: &mut System, parts: &mut [PartElements]) {
    let graph = &mut system.graph;
    let symbol = graph.new_symbol(SymbolKind::Auxiliary, "s");
    system.scale = Some(symbol);
    let scale = graph.symbol(symbol);
    let scaled = |graph: &mut Graph, element: &Element| {
        let mut images = HashMap::new();
        for (momentum, _) in element.momenta() {
            let own = graph.symbol(momentum);
            images.insert(momentum, graph.divide(own, scale));
        }
        graph.substitute(&[element.value], &images)[0]
    };
    for Weighted { element, .. } in
        parts.iter_mut().flat_map(|part| part.values.iter_mut().chain(&mut part.elements))
    {
        let value = scaled(graph, element);
        element.value = graph.multiply(scale, value);
    }
    for element in system.collectives.elements_mut() {
        element.value = scaled(graph, element);
    }
}
