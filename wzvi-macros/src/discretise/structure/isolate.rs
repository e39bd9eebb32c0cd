//! Unknowns that can be isolated: `x = φ(x, others)` with `φ` affine in `x` and a slope independent of the
//! state is `x = φ(0, others) / (1 - slope)`. The unknown is then assigned, not iterated.
//!
//! So `H_1 = σ q p` with a nonlinear `V(q)` needs one unknown, not two: `P (1 + σΔW/2) = p - h/2 V'(Q)`.

use super::blocks::Dependencies;
use crate::discretise::{Equations, StepSymbols, Unknown};
use crate::symbolic::{Expr, Graph, Rational, Symbol, SymbolKind};

/// The largest component in which unknowns are isolated: every one of them is tried.
pub(crate) const MOST_ISOLATED: usize = 12;

/// `1 / pivot`, with its symbol in the equations.
#[derive(Clone, Copy)]
pub(crate) struct Pivot {
    pub(crate) value: Expr,
    pub(crate) inverse: Symbol,
}

/// The equations of `component` with every unknown isolated that saves an iterate.
pub(super) fn isolate(
    graph: &mut Graph,
    symbols: &StepSymbols,
    equations: &Equations,
    component: &[Unknown],
    iterates: &[Unknown],
) -> Option<(Equations, Dependencies, Vec<Pivot>)> {
    if component.len() > MOST_ISOLATED {
        return None;
    }
    let mut best: Option<(Equations, Dependencies, Vec<Pivot>)> = None;
    let mut fewest = iterates.len();
    let (coordinates, momenta): (Vec<_>, Vec<_>) = iterates.iter().partition(|x| matches!(x, Unknown::Q(_)));
    for &unknown in momenta.into_iter().chain(coordinates) {
        let current = best.as_ref().map_or(equations, |(equations, ..)| equations);
        let Some((phi, pivot)) = isolated(graph, symbols, current.phi[unknown], unknown) else { continue };
        let mut changed = current.clone();
        changed.phi[unknown] = phi;
        let dependencies = Dependencies::new(graph, symbols, &changed);
        let left = dependencies.split(component).0.len();
        if left < fewest {
            fewest = left;
            let mut pivots = best.map_or_else(Vec::new, |(.., pivots)| pivots);
            pivots.push(pivot);
            best = Some((changed, dependencies, pivots));
        }
    }
    best
}

/// `φ` solved for its own unknown, if it is affine in it.
fn isolated(graph: &mut Graph, symbols: &StepSymbols, phi: Expr, unknown: Unknown) -> Option<(Expr, Pivot)> {
    let of_state = symbols.of_state();
    let views: Vec<Symbol> = symbols.views(unknown).iter().map(|(view, _)| *view).collect();
    if graph.has_pieces(phi, &views) {
        return None;
    }
    let base = graph.symbol(symbols.nodes[unknown]);
    let mut slope = Vec::new();
    let mut at_base = std::collections::HashMap::new();
    for (view, weight) in symbols.views(unknown) {
        let by_view = graph.derivative(phi, view);
        if graph.depends_on(by_view, &of_state) {
            return None;
        }
        slope.push((by_view, weight.negate()));
        at_base.insert(view, base);
    }
    let one = graph.integer(1);
    slope.push((one, Rational::ONE));
    let value = graph.linear_combination(&slope);
    if graph.is_one(value) {
        return None;
    }
    let inverse = graph.new_symbol(SymbolKind::Auxiliary, "inverse");
    let factor = graph.symbol(inverse);
    let rest = graph.substitute(&[phi], &at_base)[0];
    Some((graph.multiply(factor, rest), Pivot { value, inverse }))
}

impl StepSymbols {
    /// All symbols that change from step to step, except the increments and the time of the node.
    fn of_state(&self) -> Vec<Symbol> {
        let stages = self.stages.iter().flat_map(|stage| stage.q.iter().chain([&stage.t]));
        let of_node = self.nodes.iter().chain(self.unknowns.iter()).chain(&self.momentum);
        of_node.chain(stages).copied().collect()
    }
}
