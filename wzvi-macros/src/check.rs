//! Refuses what the mathematics contradicts: inconsistent bare schemes, declared first integrals that are not
//! conserved, drifts and words without flows.
//!
//! Every refusal of the compiler is in `diagnostics`, nearly all as rows of tables: `messages` about
//! declarations, which `input`, `lower` and `functions` report; `expressions` about Rust that `lower` and
//! `collect` cannot make terms of; `ito` about the conversion; and `facts` about the mathematics. The last
//! are reported here, but for those of friction and temperature, which `passes/friction.rs` checks before
//! friction becomes a force. Syntax that is no Rust is refused by syn.

use crate::diagnostics::{Diagnostics, Located, facts as messages};
use crate::discretise::split::SummandForm;
use crate::discretise::{
    ConstraintMistake, Facts, Failure, Invariant, KnownSum, NoiseOfClock, NoiseOffManifold, unweighted,
};
use crate::embedding::{ClockedEmbedding, Correction, Embedding};
use crate::model::{Element, System};
use crate::symbolic::sign::Sign;
use crate::symbolic::{Expr, Function, Graph, Node, Rational, SymbolKind};

/// Every check, in order; all of them report.
pub(crate) fn check(system: &mut System, facts: &Facts, diagnostics: &mut Diagnostics) {
    let System { graph, embeddings, .. } = system;
    check_consistency(graph, embeddings, facts, diagnostics);
    check_invariants(graph, facts, diagnostics);
    check_parts(system, facts, diagnostics);
    check_flows(system, facts, diagnostics);
    check_constraints(system, facts, diagnostics);
    check_clock(system, facts, diagnostics);
    check_clocked(system, facts, diagnostics);
}

/// A bare scheme must converge to the Stratonovich system, for which `D = (1/2 - l) Σ_k ∂H_k/∂q · ∂H_k/∂p`
/// must be constant; a corrected one needs its counter-term.
fn check_consistency(
    graph: &mut Graph,
    embeddings: &[Located<Embedding>],
    facts: &Facts,
    diagnostics: &mut Diagnostics,
) {
    for Located { value: scheme, extent } in embeddings {
        let [_, noise_l] = scheme.means();
        let error = match scheme.correction() {
            Correction::Bare if !facts.is_consistent(noise_l) => {
                let defect = facts.defect(graph, &facts.noise_contraction, noise_l);
                if facts.force_defect_acts(noise_l) {
                    let force = facts.defect(graph, &facts.force_contraction, noise_l);
                    let hamiltonian = match defect.as_str() {
                        "0" => String::new(),
                        defect => format!(", and drift Hamiltonian H0 - D, D = {defect}"),
                    };
                    messages::inconsistent_forces(*extent, scheme, &hamiltonian, &force)
                } else {
                    messages::inconsistent(*extent, scheme, &defect, &facts.noise_contraction.known)
                }
            }
            Correction::Corrected if facts.force_defect_acts(noise_l) => {
                messages::correction_of_forces(*extent, scheme)
            }
            Correction::Corrected if facts.counter_term_acts(noise_l) && facts.counter_term.sum.is_none() => {
                messages::counter_term_of_elements(*extent, scheme)
            }
            _ => continue,
        };
        diagnostics.report(error);
    }
}

/// `{H_m, F}` must vanish for every term; for the drift, `∂F/∂t` and the rates by forces are added.
fn check_invariants(graph: &mut Graph, facts: &Facts, diagnostics: &mut Diagnostics) {
    for Invariant { extent, failure, .. } in &facts.invariants {
        if let Some(Failure { along, found: KnownSum { sum, known } }) = failure {
            let rate = sum.as_ref().map(|rate| facts.space.display(graph, rate, Rational::ONE));
            diagnostics.report(messages::no_invariant(*extent, along, rate.as_deref(), known, graph));
        }
    }
}

/// Each part of `drift = [H_A, H_B]` has a known flow, and forces and friction belong to one of them.
fn check_parts(system: &System, facts: &Facts, diagnostics: &mut Diagnostics) {
    for (part, form) in system.summands.iter().zip(&facts.summands.forms) {
        if let Err(reason) = form {
            diagnostics.report(messages::part_without_flow(part.extent, reason));
        }
    }
    if let Err((extent, reason)) = facts.summands.assignment {
        diagnostics.report(messages::acts_in_no_part(extent, reason, &system.converted_force()));
    }
}

/// `Baoab` and the like are made of the flows of `T(p)` and `V(q, t)`.
fn check_flows(system: &System, facts: &Facts, diagnostics: &mut Diagnostics) {
    if facts.flows.is_none() {
        let words = system.embeddings.iter().filter(|known| known.value.is_word());
        for Located { value, extent } in words {
            diagnostics.report(messages::word_without_flows(*extent, value, &system.converted_force()));
        }
    }
}

/// Constraints are functions of the coordinates with a manifold of their own, and only some schemes keep
/// them.
fn check_constraints(system: &mut System, facts: &Facts, diagnostics: &mut Diagnostics) {
    for Located { value, extent } in &system.embeddings {
        match (value.keeps_constraints(), facts.constraints.is_empty()) {
            (false, false) => diagnostics.report(messages::leaves_constraints(*extent, value)),
            (true, true) => diagnostics.report(messages::keeps_no_constraints(*extent, value)),
            _ => {}
        }
    }
    if facts.constraints.is_empty() {
        return;
    }
    let baths = system.embeddings.iter().filter(|known| known.value == Embedding::GBaoab);
    for Located { extent, .. } in baths.filter(|_| !facts.has_squares) {
        diagnostics.report(messages::bath_without_masses(*extent, &system.converted_force()));
    }
    for constraint in &facts.constraints {
        let extent = constraint.extent;
        match constraint.mistake {
            Some(ConstraintMistake::NoCoordinates) => {
                diagnostics.report(messages::constraint_of_nothing(extent));
            }
            Some(ConstraintMistake::NoPoint) => {
                diagnostics.report(messages::constraint_without_points(extent));
            }
            Some(ConstraintMistake::Affine) => diagnostics.report(messages::affine_constraint(extent)),
            Some(ConstraintMistake::Multiple(other)) => {
                let other = &facts.constraints[other];
                diagnostics.report(messages::constraint_again(extent, &other.number));
                diagnostics.report(messages::constraint_before(other.extent, &constraint.number));
            }
            None => {}
        }
        if let Some(NoiseOffManifold { number, bracket }) = &constraint.noise {
            let bracket =
                bracket.sum.as_ref().map(|sum| facts.space.display(&mut system.graph, sum, Rational::ONE));
            let bracket = bracket.unwrap_or_default();
            diagnostics.report(messages::noise_off_manifold(extent, &constraint.number, number, &bracket));
        }
    }
}

/// No noise changes the clock, whose density would need its noise.
fn check_clock(system: &mut System, facts: &Facts, diagnostics: &mut Diagnostics) {
    if let (Some(clock), Some(NoiseOfClock { along, rate })) = (&system.clock, &facts.clock.noise) {
        let KnownSum { sum, known } = rate;
        let rate = sum.as_ref().map(|sum| facts.space.display(&mut system.graph, sum, Rational::ONE));
        let rate = rate.unwrap_or_default();
        diagnostics.report(messages::noise_of_clock(clock.term.extent, along, &rate, known));
    }
}

/// Schemes with steps of other lengths have what their lengths follow from.
fn check_clocked(system: &mut System, facts: &Facts, diagnostics: &mut Diagnostics) {
    for Located { value: scheme, extent } in &system.clocked.clone() {
        let (name, inner) = (scheme.to_string(), scheme.base());
        if system.clock.is_none() && !matches!(scheme, ClockedEmbedding::Logarithmic(..)) {
            diagnostics.report(messages::no_clock(*extent, &name));
            continue;
        }
        match scheme {
            ClockedEmbedding::Clocked(_) => {}
            ClockedEmbedding::Extended(_) => {
                let reason = beside_drift(system);
                if let Some(reason) = reason {
                    diagnostics.report(messages::not_extended(*extent, &name, &inner.to_string(), reason));
                } else if inner == Embedding::Verlet
                    && let Some(reason) = not_explicit(system, facts)
                {
                    diagnostics.report(messages::extended_verlet(*extent, reason));
                }
            }
            ClockedEmbedding::Logarithmic(..) => {
                let reason = beside_drift(system).or_else(|| not_separate(system, facts));
                if let Some(reason) = reason {
                    diagnostics.report(messages::logarithmic_of_other(*extent, &name, reason));
                } else if let Some(term) = not_negative(system, facts) {
                    diagnostics.report(messages::potential_not_negative(*extent, &name, &term));
                }
            }
        }
    }
}

/// A sentence on noise, friction or forces, if there are any: no Hamiltonian of the drift contains them.
fn beside_drift(system: &System) -> Option<&'static str> {
    if system.noise.iter().any(|noise| !noise.is_force) || system.temperature.is_some() {
        Some("noise is no part of it")
    } else if system.friction.is_some() {
        Some("friction is no part of it")
    } else if system.has_forces() {
        Some("forces are no part of it")
    } else {
        None
    }
}

/// Why `Extended<Verlet>` is not explicit.
fn not_explicit(system: &System, facts: &Facts) -> Option<&'static str> {
    let reads_momenta =
        system.clock.iter().flat_map(|clock| &clock.term.values).any(|element| element.reads().p);
    if reads_momenta {
        Some("this clock reads momenta")
    } else if !facts.is_nystrom || facts.flows.is_none() {
        Some("the drift has another form")
    } else {
        None
    }
}

/// Why a drift is not `T(p) + V(q)`.
fn not_separate(system: &System, facts: &Facts) -> Option<&'static str> {
    let is_known = match &system.summands[..] {
        [] => facts.flows.is_some() && !system.drift.values.iter().any(Element::is_collective),
        _ => facts.summands.known() == Some([SummandForm::Momenta, SummandForm::Coordinates]),
    };
    if !facts.energy.is_conservative {
        Some("the drift depends on the time, or does not conserve the energy")
    } else if !is_known {
        Some("the drift is no such sum of a function of the momenta and, after it, one of the coordinates")
    } else {
        None
    }
}

/// The first term of the potential that is not negative where all parameters are positive, as text.
fn not_negative(system: &mut System, facts: &Facts) -> Option<String> {
    let System { graph, drift, .. } = system;
    let potential = drift.elements.iter().filter(|element| !element.reads().p);
    let potential: Vec<Element> = potential.cloned().collect();
    let mut has_terms = false;
    for element in potential {
        let terms = match graph.node(element.value).clone() {
            Node::Sum { terms, constant } => {
                let one = graph.integer(1);
                terms.iter().copied().chain([(one, constant)]).filter(|(_, c)| !c.is_zero()).collect()
            }
            _ => vec![(element.value, Rational::ONE)],
        };
        for (term, coefficient) in terms {
            has_terms = true;
            if coefficient.is_negative() && is_positive(graph, term) {
                continue;
            }
            let value = graph.scale(term, coefficient);
            let term = Element { value, ..element.clone() };
            return Some(facts.space.display(graph, &unweighted(&[term]), Rational::ONE));
        }
    }
    if has_terms { None } else { Some("0".to_owned()) }
}

/// Whether an expression is positive wherever it is defined and parameters are positive.
fn is_positive(graph: &Graph, expr: Expr) -> bool {
    if graph.sign(expr) == Sign::Positive {
        return true;
    }
    match graph.node(expr) {
        Node::Symbol(symbol) => graph.kind_of(*symbol) == SymbolKind::Parameter,
        Node::Sum { terms, constant } => {
            !constant.is_negative()
                && terms.iter().all(|&(term, c)| !c.is_negative() && is_positive(graph, term))
        }
        Node::Product(factors) => factors.iter().all(|&(base, exponent)| {
            is_positive(graph, base) || exponent.is_negative() && graph.sign(base) >= Sign::Nonnegative
        }),
        // A root of a square that is divided by is among products.
        Node::Apply(Function::Sqrt | Function::Exp, arguments) => is_positive(graph, arguments[0]),
        _ => false,
    }
}
