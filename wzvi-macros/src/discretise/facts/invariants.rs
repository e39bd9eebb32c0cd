//! First integrals: the rates of a function along the drift, the noises and the forces.

use super::forces::{self, Forces};
use super::{Form, boundaries_of, kept_across, known};
use crate::diagnostics::Extent;
use crate::discretise::{Increments, Space, Sum};
use crate::symbolic::{Graph, Knowledge, Rational, Symbol};

/// A declared first integral with its rate of change.
pub(crate) struct Invariant {
    pub(crate) extent: Extent,
    /// Empty if it has none.
    pub(crate) name: String,
    pub(crate) value: Sum,
    /// The first rate that is not proven zero.
    pub(crate) failure: Option<Failure>,
    pub(crate) form: Form,
}

/// A term that prevents a function from being a first integral.
pub(crate) struct Failure {
    /// The flow along which it changes, with the formula of the rate; or the place
    /// where it jumps.
    pub(crate) along: String,
    /// The rate; `None` for a jump.
    pub(crate) rate: Option<Sum>,
    pub(crate) knowledge: Knowledge,
}

pub(super) fn invariant(
    graph: &mut Graph,
    space: &mut Space,
    (drift, noise, forces, t): (&Sum, &[(String, &Sum)], &Forces, Symbol),
    (extent, name, value): (Extent, String, Sum),
) -> Invariant {
    let mut failure = None;
    let mut check = |graph: &mut Graph, space: &mut Space, along: String, rate: Option<Sum>| {
        if failure.is_some() {
            return;
        }
        match known(&rate, |sum| space.vanishes(graph, sum, Increments::Each)) {
            Knowledge::Proven => {}
            knowledge => failure = Some(Failure { along, rate, knowledge }),
        }
    };
    let (rate, along) = rate_of_drift(graph, space, (drift, forces, t), &value);
    check(graph, space, along, rate);
    for (number, hamiltonian) in noise {
        let rate = space.bracket(graph, hamiltonian, &value);
        let name = number.trim_start_matches('_');
        check(graph, space, format!("noise {name}: {{H{number}, F}}"), rate);
    }
    for (number, force) in forces.numbers.iter().zip(&forces.noise) {
        let rate = forces::along(graph, space, force, &value);
        let name = number.trim_start_matches('_');
        check(graph, space, format!("noise force {name}: F{number} · ∂F/∂p"), rate);
    }
    if forces.is_warm && value.iter().any(|weighted| weighted.element.momenta().next().is_some()) {
        let knowledge =
            Knowledge::Unknown("a bath with a temperature acts on every momentum with friction".to_owned());
        failure = failure.or(Some(Failure { along: "the bath".to_owned(), rate: None, knowledge }));
    }
    // Its derivatives are those of the pieces.
    for boundary in boundaries_of(graph, &value, t) {
        if let knowledge @ (Knowledge::Refuted(_) | Knowledge::Unknown(_)) = kept_across("it", &boundary) {
            let along = format!("motions across {}", boundary.place);
            failure = failure.or(Some(Failure { along, rate: None, knowledge }));
        }
    }
    Invariant { extent, name, form: Form::of(graph, &value), value, failure }
}

/// The rate of a function along the drift with its forces, and its formula.
fn rate_of_drift(
    graph: &mut Graph,
    space: &mut Space,
    (drift, forces, t): (&Sum, &Forces, Symbol),
    value: &Sum,
) -> (Option<Sum>, String) {
    let mut along = "the drift: {H0, F} + ∂F/∂t".to_owned();
    let mut rates = vec![
        (space.bracket(graph, drift, value), Rational::ONE),
        (Some(space.partial(graph, value, t)), Rational::ONE),
    ];
    if !forces.force.is_empty() {
        along.push_str(" + F0 · ∂F/∂p");
        rates.push((forces::along(graph, space, &forces.force, value), Rational::ONE));
    }
    if !forces.friction.is_empty() {
        along.push_str(" less that of the friction");
        rates.push((forces::along(graph, space, &forces.friction, value), Rational::MINUS_ONE));
    }
    let sums = rates.iter().map(|(rate, factor)| Some((rate.as_ref()?, *factor)));
    let sums: Option<Vec<(&Sum, Rational)>> = sums.collect();
    (sums.map(|sums| space.combine(graph, &sums)), along)
}
