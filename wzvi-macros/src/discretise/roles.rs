//! The roles of terms, and the terms of the step Hamiltonian by their roles: sums of elements, each with the
//! increments that weigh it.
//!
//! `ℓ_e = -w c_e H_e(P, Q_l)` is an element of the discrete Lagrangian, and its slopes and curvatures are
//! those of `D_1 L_d`, `D_2 L_d` and `∂L_d/∂P`.

use std::collections::HashMap;

use crate::discretise::{Facts, Quadrature, Sum, Weighted, summed};
use crate::model::{Element, System};
use crate::symbolic::{Graph, SymbolKind};

/// The role of terms in a system, as `Role` of the run time. Terms with one role are evaluated together.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Role {
    /// `h H_0`
    Drift,
    /// `Σ_k ΔW_k H_k`
    Noise,
    /// `Σ_jk ΔW_j ΔW_k ∂H_j/∂q · ∂H_k/∂p`
    CounterTerm,
    /// `h f`, in place of `-∂F/∂q`
    Force,
    /// A part of the drift, by its number in `drift = [H_A, H_B]`. No quadrature evaluates it, nor the roles
    /// below.
    Summand(usize),
    /// The friction of a bath.
    Friction,
    /// The temperature of a bath.
    Temperature,
    /// A first integral, by its number.
    Integral(usize),
    /// An observable, by its number.
    Observable(usize),
    /// `Q`, the clock.
    Clock,
    /// `-d ln Q/dt`
    ClockRate,
}

/// The elements with one role.
#[derive(Clone)]
pub(crate) struct RoleElements {
    pub(crate) role: Role,
    /// As written by the user: for values, to keep their accuracy.
    pub(crate) values: Sum,
    /// Elements in coordinates only, momenta only, or inseparable in both: for derivatives.
    pub(crate) elements: Sum,
    /// Whether some scheme has a weight other than 1 for it.
    pub(crate) is_weighted: bool,
}

/// The elements of the step Hamiltonian that the schemes of `system` use, by their roles.
pub(crate) fn elements_by_role(system: &System, facts: &Facts) -> Vec<RoleElements> {
    let [drift, noise, force] = summed(system, |term| &term.values);
    let [parted_drift, parted_noise, parted_force] = summed(system, |term| &term.elements);
    let counter_term = facts.counter_term.sum.clone().unwrap_or_default();
    let schemes = system.embeddings.iter().map(|known| Quadrature::new(facts, &known.value));
    let schemes: Vec<Quadrature> = schemes.collect();
    let sums = [
        (Role::Drift, drift, parted_drift),
        (Role::Noise, noise, parted_noise),
        (Role::CounterTerm, counter_term.clone(), counter_term),
        (Role::Force, force, parted_force),
    ];
    let used = sums.into_iter().filter_map(|(role, values, elements)| {
        let weights: Vec<_> = schemes.iter().flat_map(|scheme| scheme.weights_of(role)).collect();
        let is_weighted = weights.iter().any(|weight| !weight.is_one());
        (!weights.is_empty()).then_some(RoleElements { role, values, elements, is_weighted })
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
pub(crate) fn scale_momenta(system: &mut System, roles: &mut [RoleElements]) {
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
        roles.iter_mut().flat_map(|known| known.values.iter_mut().chain(&mut known.elements))
    {
        let value = scaled(graph, element);
        element.value = graph.multiply(scale, value);
    }
    for element in system.collectives.elements_mut() {
        element.value = scaled(graph, element);
    }
}
