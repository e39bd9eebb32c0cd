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
        Knowledge::Unknown => format!("whose defect D = {defect} could not be shown to be constant"),
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

/// A declared first integral that changes along the flow of term `term`, or may.
pub(crate) fn no_invariant(
    extent: Extent,
    term: usize,
    rate: &str,
    knowledge: &Knowledge,
    graph: &Graph,
) -> Error {
    let along = match term {
        0 => "the drift: {H0, F} + ∂F/∂t".to_owned(),
        k => format!("noise {k}: {{H{k}, F}}"),
    };
    let message = match knowledge {
        Knowledge::Refuted(witness) => {
            format!("this is not a first integral of {along} = {rate}{}", at_witness(witness, graph))
        }
        _ => format!(
            "this could not be proven to be a first integral of {along} = {rate} vanishes wherever it was evaluated, but \
             by no identity that the compiler knows; leave it out, or write both sides in the same functions"
        ),
    };
    Error::new_spanned(extent, message)
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

/// A first integral of a system whose sums stay loops that is no sum over all sites.
pub(crate) fn invariant_not_local(extent: Extent) -> Error {
    Error::new_spanned(
        extent,
        "where sums stay loops a first integral is proven if it is a sum over all sites of functions of one site, such as \
         `p.iter().sum::<f64>()`; leave this one out, and evaluate it with an observer",
    )
}

/// The same of one that reads the time.
pub(crate) fn invariant_reads_time(extent: Extent) -> Error {
    Error::new_spanned(
        extent,
        "where sums stay loops first integrals that read the time are not proven; leave it out, and evaluate it with an \
         observer",
    )
}

/// The same of one whose rate does not vanish element by element.
pub(crate) fn invariant_of_elements(
    extent: Extent,
    term: usize,
    rate: &str,
    knowledge: &Knowledge,
    graph: &Graph,
) -> Error {
    let along = match term {
        0 => "H0".to_owned(),
        k => format!("H{k}"),
    };
    let finding = match knowledge {
        Knowledge::Refuted(witness) => format!("is {rate}{}", at_witness(witness, graph)),
        _ => format!("is {rate}, which could not be shown to vanish"),
    };
    Error::new_spanned(
        extent,
        format!(
            "this could not be proven to be a first integral: the part of {{{along}, F}} that one placement of a sum gives \
             {finding}; if it is one because such parts cancel, leave it out, and evaluate it with an observer"
        ),
    )
}

/// A counter-term that would couple the elements of different noises.
pub(crate) fn counter_term_of_elements(embedding: &Located<Embedding>) -> Error {
    let scheme = &embedding.value;
    Error::new_spanned(
        embedding.extent,
        format!(
            "`{scheme}` needs noises that read the state at one site each where sums stay loops: this counter-term is no \
             sum over sites; use `Midpoint`, which is consistent with every noise"
        ),
    )
}
