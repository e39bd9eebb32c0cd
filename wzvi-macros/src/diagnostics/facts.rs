//! The messages about the mathematics: what was derived contradicts what was declared.

use syn::Error;

use crate::discretise::embedding::Embedding;
use crate::discretise::facts::Knowledge;
use crate::model::{Extent, Located};
use crate::symbolic::Graph;
use crate::symbolic::zero::Witness;

/// A bare scheme whose limit is not the Stratonovich system.
pub(crate) fn inconsistent(embedding: &Located<Embedding>, defect: &str, constant: &Knowledge) -> Error {
    let scheme = &embedding.value;
    let finding = match constant {
        Knowledge::Unknown(reason) => {
            format!("whose defect D = {defect} could not be shown to be constant: {reason}")
        }
        _ => format!("with drift Hamiltonian H0 - D, where D = {defect}"),
    };
    Error::new_spanned(
        embedding.extent,
        format!(
            "`{scheme}` does not converge to this Stratonovich system as h -> 0, but to the one {finding}; \
             write `Corrected<{scheme}>` to add the counter-term, or `Uncorrected<{scheme}>` to keep the scheme as it is \
             (`Midpoint` is consistent with every noise)"
        ),
    )
}

/// A declared first integral that changes along the flow of the drift or of a noise, or may.
pub(crate) fn no_invariant(
    extent: Extent,
    noise: &Option<String>,
    rate: &str,
    knowledge: &Knowledge,
    graph: &Graph,
) -> Error {
    let along = match noise {
        None => "the drift: {H0, F} + ∂F/∂t".to_owned(),
        Some(k) => format!("noise {}: {{H{k}, F}}", k.trim_start_matches('_')),
    };
    let message = match knowledge {
        Knowledge::Refuted(witness) => {
            format!("this is not a first integral of {along} = {rate}{}", at_witness(witness, graph))
        }
        Knowledge::Unknown(reason) => format!(
            "this could not be proven to be a first integral of {along} = {rate}: {reason}; leave it out and evaluate it \
             with an observer, or write both sides in the same functions"
        ),
        Knowledge::Proven => format!("this is a first integral of {along} = {rate}"),
    };
    Error::new_spanned(extent, message)
}

/// A part of a drift whose flow is not known.
pub(crate) fn part_without_flow(extent: Extent, reason: &str) -> Error {
    Error::new_spanned(
        extent,
        format!(
            "this part of the drift has no flow that is known: {reason}; flows are known of functions of the coordinates (and the \
             time), of functions of the momenta (and the time), and of polynomials of degree two in both with constant coefficients, for \
             which the size must be known; add the parts where no scheme is to part them"
        ),
    )
}

fn at_witness(witness: &Witness, graph: &Graph) -> String {
    let point: Vec<String> = witness
        .point
        .iter()
        .map(|&(symbol, value)| format!("{} = {value}", graph.symbol_name(symbol)))
        .collect();
    let value = witness.value;
    match point.is_empty() {
        true => format!(", which is {value}"),
        false => format!(", which is {value} at {}", point.join(", ")),
    }
}

/// A counter-term whose indices the compiler cannot write.
pub(crate) fn counter_term_of_elements(embedding: &Located<Embedding>) -> Error {
    let scheme = &embedding.value;
    Error::new_spanned(
        embedding.extent,
        format!(
            "the counter-term of `{scheme}` cannot be written: its indices exceed 128 bits; use `Midpoint`, which is \
             consistent with every noise"
        ),
    )
}
