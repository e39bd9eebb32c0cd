//! Parameters that the Hamiltonian divides by are not zero: where they are, no state has an energy or a step.
//! So `m²/m` is `m`, and `k m/m` is `k`, in everything that is derived from the Hamiltonian.
//!
//! The drift divides by a parameter `m`, or by an expression `m + n` of parameters, if that is in the
//! denominator of a term, and does not cancel there. At `m = 0` the Hamiltonian is then not finite:
//!
//! | written | not zero |
//! |---|---|
//! | `p² / (2 m)` | `m` |
//! | `p² / (2 m)` inside of a loop | `m`, if nothing else divides by it: the loop may have no turn |
//! | `p_i² / (2 mass_i)` | every entry of the list, if nothing else divides by one |
//! | `if a > 0 { q²/a } else { 0 }` | nothing: that branch may not be taken |
//! | `exp(-q²/a)`, `1/(1 + 1/a)` | nothing: they are finite at `a = 0` |
//! | `m² q²/m` | nothing: without the division it would have a value at `m = 0` |
//! | a noise, a force, a temperature, an invariant | nothing |
//!
//! "Else" means other parts of the drift, such as branches, and all other terms. Then every later division by
//! `m` comes from the Hamiltonian, and is evaluated only where the Hamiltonian divides by `m`.
//!
//! Tests: `compile/divisor_tests.rs`, `tests/steps/divisors.rs`.

use std::collections::HashSet;

use super::unroll::unroller_and_terms;
use crate::model::symbols::IndexedSum;
use crate::model::{Slot, System, Term};
use crate::symbolic::{Expr, Node, SymbolKind};

/// The place of a division in a term.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
enum DivisionPlace {
    /// A term without it is a term of another Hamiltonian.
    Always,
    /// In a loop that may have no turn.
    InLoop,
    /// Where the value may be finite although the divisor is zero: in branches, in arguments of functions.
    Elsewhere,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Divisor {
    /// An expression of parameters.
    Expression(Expr),
    /// The entries of a list.
    List(u32),
}

/// Makes the divisors of the drift known to the graph, and cancels them in all terms.
pub(crate) fn divisors(system: &mut System) {
    let drift = divisions(system, &[&system.drift]);
    let others: Vec<&Term> = system.terms().skip(1).collect();
    let others = divisions(system, &others);
    let is_divided_elsewhere = |divisor: Divisor| {
        drift.contains(&(divisor, DivisionPlace::Elsewhere))
            || others.iter().any(|(other, _)| *other == divisor)
    };
    let is_nonzero = |&(divisor, place): &(Divisor, DivisionPlace)| match (divisor, place) {
        (_, DivisionPlace::Elsewhere) => false,
        (Divisor::Expression(_), DivisionPlace::Always) => true,
        (Divisor::Expression(_), DivisionPlace::InLoop) | (Divisor::List(_), _) => {
            !is_divided_elsewhere(divisor)
        }
    };
    let nonzero: Vec<(Divisor, DivisionPlace)> = drift.iter().copied().filter(is_nonzero).collect();
    if nonzero.is_empty() {
        return;
    }
    let System { graph, symbols, tables, .. } = &mut *system;
    for (divisor, _) in nonzero {
        match divisor {
            Divisor::Expression(expr) => graph.assume_nonzero(expr),
            Divisor::List(list) => {
                if let Some(table) = tables.get_mut(list as usize) {
                    table.is_nonzero = true;
                }
                symbols.assume_nonzero_entries(graph, list);
            }
        }
    }
    symbols.rebuild_sums(graph);
    let (writer, terms) = unroller_and_terms(system);
    for term in terms.all() {
        term.expression = writer.graph.rebuilt(term.expression);
    }
}

/// The divisions by parameters in these terms.
fn divisions(system: &System, terms: &[&Term]) -> HashSet<(Divisor, DivisionPlace)> {
    let mut found = HashSet::new();
    let mut met = HashSet::new();
    let mut pending: Vec<(Expr, DivisionPlace)> =
        terms.iter().map(|term| (term.expression, DivisionPlace::Always)).collect();
    while let Some((expr, place)) = pending.pop() {
        if !met.insert((expr, place)) {
            continue;
        }
        match system.graph.node(expr) {
            Node::Sum { terms, .. } => pending.extend(terms.iter().map(|&(term, _)| (term, place))),
            Node::Product(factors) => {
                for &(base, exponent) in factors {
                    let cancels = factors.iter().any(|&(other, e)| other == base && !e.is_negative());
                    match divisor(system, base) {
                        _ if !exponent.is_negative() => pending.push((base, place)),
                        Some(divisor) if cancels => _ = found.insert((divisor, DivisionPlace::Elsewhere)),
                        Some(divisor) => _ = found.insert((divisor, place)),
                        None => pending.push((base, DivisionPlace::Elsewhere)),
                    }
                }
            }
            &Node::Symbol(symbol) => {
                if let Some(IndexedSum { range, body, .. }) = system.symbols.sum_of(symbol) {
                    let has_turns = range.length().is_some_and(|length| length > 0);
                    pending.push((*body, if has_turns { place } else { place.max(DivisionPlace::InLoop) }));
                }
            }
            other => other.for_each_operand(|operand| pending.push((operand, DivisionPlace::Elsewhere))),
        }
    }
    found
}

/// The divisor in negative powers of `base`, if that reads parameters alone.
fn divisor(system: &System, base: Expr) -> Option<Divisor> {
    let System { graph, symbols, .. } = system;
    if let Some(local) = graph.as_symbol(base).and_then(|symbol| symbols.local_of(symbol)) {
        return match local.slot {
            Slot::Entry(list, _) => Some(Divisor::List(list)),
            Slot::State(..) | Slot::Number(_) | Slot::Collective(_) => None,
        };
    }
    let is_parameter =
        |symbol| graph.kind_of(symbol) == SymbolKind::Parameter && symbols.local_of(symbol).is_none();
    graph.symbols_in(base).into_iter().all(is_parameter).then_some(Divisor::Expression(base))
}
