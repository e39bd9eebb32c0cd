//! The gradient of the step Hamiltonian `F`, which is all that steps with several stages need of their
//! discrete Lagrangian:
//!
//! ```text
//! L_d = ext Σ_j b_j [P_j · V_j - F(P_j, Q_j, T_j)],   F = h H_0 + Σ_k ΔW_k H_k,   Q_j = q_i + Σ_k a_jk V_k
//! V_j = ∂F/∂P_j,   P_j = p_i - Σ_k a_jk ∂F/∂Q_k
//! ```
//!
//! (Hairer, Lubich, Wanner, *Geometric Numerical Integration*, theorem VI.6.4.)
//!
//! Tests: `tests/steps/gauss.rs`.

use std::rc::Rc;

use crate::model::StraightLine;
use crate::symbolic::{Expr, Graph, Node, Rational, Symbol, SymbolKind};

/// The slopes of the step Hamiltonian in the symbols of the phase space, `h` and `ΔW`.
pub(crate) struct StepGradient {
    pub(crate) line: Rc<StraightLine>,
    pub(crate) h: Symbol,
    pub(crate) dw: Vec<Symbol>,
    pub(crate) by_q: Vec<Expr>,
    pub(crate) by_p: Vec<Expr>,
    /// Entries of the matrix `K` where `V = q · K q / 2 + U(q, t)` with constant `K`, in Nyström form: row,
    /// column, value.
    pub(crate) stiffness: Vec<(usize, usize, Expr)>,
}

impl StepGradient {
    /// `is_nystrom`: whether `F` is a constant quadratic form of the momenta plus a function of coordinates
    /// and time, and forces read no momenta.
    pub(crate) fn new(graph: &mut Graph, line: Rc<StraightLine>, is_nystrom: bool) -> Self {
        let noises = line.noises();
        let h = graph.new_symbol(SymbolKind::StepSize, "h");
        let name = |k: usize| if noises == 1 { "ΔW".to_owned() } else { format!("ΔW{k}") };
        let dw: Vec<Symbol> =
            (1..=noises).map(|k| graph.new_symbol(SymbolKind::Increment, name(k))).collect();
        let weights: Vec<Expr> = [h].iter().chain(&dw).map(|&symbol| graph.symbol(symbol)).collect();
        let terms: Vec<Expr> = [line.drift].iter().chain(&line.noise).copied().collect();
        let forces: Vec<(&Vec<Expr>, Expr)> = line.force.iter().map(|force| (force, weights[0])).collect();
        let driven = line.noise_forces.iter().zip(weights[terms.len()..].iter().copied());
        let forces: Vec<(&Vec<Expr>, Expr)> = forces.into_iter().chain(driven).collect();
        // `∂F/∂x`, minus the force in its direction if `x` is a coordinate.
        let mut slope = |symbol: Symbol, direction: Option<usize>| {
            let slopes = terms.iter().zip(&weights).map(|(&term, &weight)| {
                let slope = graph.derivative(term, symbol);
                (graph.multiply(weight, slope), Rational::ONE)
            });
            let mut slopes: Vec<(Expr, Rational)> = slopes.collect();
            for &(force, weight) in &forces {
                let component = direction.and_then(|direction| force.get(direction));
                slopes.extend(
                    component.map(|&component| (graph.multiply(weight, component), Rational::MINUS_ONE)),
                );
            }
            graph.linear_combination(&slopes)
        };
        let by_q: Vec<Expr> = line.phase.q.iter().enumerate().map(|(i, &q)| slope(q, Some(i))).collect();
        let by_p: Vec<Expr> = line.phase.p.iter().map(|&p| slope(p, None)).collect();
        let stiffness = if is_nystrom { stiffness(graph, &line) } else { Vec::new() };
        Self { line, h, dw, by_q, by_p, stiffness }
    }
}

/// The constant terms of the second derivatives of the drift by the coordinates. Any matrix may be split off;
/// with this one the remainder has no quadratic terms.
fn stiffness(graph: &mut Graph, line: &StraightLine) -> Vec<(usize, usize, Expr)> {
    let StraightLine { phase, drift, .. } = line;
    let moving: Vec<Symbol> = phase.q.iter().chain(&phase.p).chain([&phase.t]).copied().collect();
    let mut entries = Vec::new();
    for (row, &a) in phase.q.iter().enumerate() {
        let slope = graph.derivative(*drift, a);
        for (column, &b) in phase.q.iter().enumerate() {
            let curvature = graph.derivative(slope, b);
            let constant = constant_part(graph, curvature, &moving);
            if !graph.is_zero(constant) {
                entries.push((row, column, constant));
            }
        }
    }
    entries
}

/// The sum of the terms without these symbols.
fn constant_part(graph: &mut Graph, expr: Expr, moving: &[Symbol]) -> Expr {
    if !graph.depends_on(expr, moving) {
        return expr;
    }
    let Node::Sum { terms, constant } = graph.node(expr).clone() else { return graph.number(Rational::ZERO) };
    let one = graph.number(Rational::ONE);
    let still = terms.iter().copied().filter(|&(term, _)| !graph.depends_on(term, moving));
    let parts: Vec<(Expr, Rational)> = [(one, constant)].into_iter().chain(still).collect();
    graph.linear_combination(&parts)
}
