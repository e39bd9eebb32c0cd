//! The discrete Lagrangian with several stages:
//!
//! ```text
//! L_d = ext Σ_j b_j [P_j · V_j - F(P_j, Q_j, T_j)],   F = h H_0 + Σ_k ΔW_k H_k,   Q_j = q_i + Σ_k a_jk V_k
//! V_j = ∂F/∂P_j,   P_j = p_i - Σ_k a_jk ∂F/∂Q_k
//! ```
//!
//! The slopes of `F` are all that a step needs of the system (Hairer, Lubich, Wanner, *Geometric Numerical Integration*, theorem VI.6.4).

use std::collections::HashMap;
use std::fmt::Write;

use super::describe::hamiltonians;
use crate::model::StraightLine;
use crate::symbolic::{Expr, Graph, Node, Rational, Symbol};

/// The slopes of the step Hamiltonian in the symbols of the phase space, `h` and `ΔW`.
pub(crate) struct StepSlopes {
    pub(crate) h: Symbol,
    pub(crate) dw: Vec<Symbol>,
    pub(crate) by_q: Vec<Expr>,
    pub(crate) by_p: Vec<Expr>,
    /// Whether `F` is a constant quadratic form of the momenta plus a function of coordinates and time, and forces read no momenta.
    pub(crate) is_nystrom: bool,
    /// Entries of the matrix `K` where `V = q · K q / 2 + U(q, t)` with constant `K`, in Nyström form: row, column, value.
    pub(crate) stiffness: Vec<(usize, usize, Expr)>,
}

impl StepSlopes {
    pub(crate) fn new(graph: &mut Graph, line: &StraightLine, is_nystrom: bool) -> Self {
        let noises = line.noises();
        let h = graph.new_symbol("h");
        let name = |k: usize| if noises == 1 { "ΔW".to_owned() } else { format!("ΔW{k}") };
        let dw: Vec<Symbol> = (1..=noises).map(|k| graph.new_symbol(name(k))).collect();
        let weights: Vec<Expr> = [h].iter().chain(&dw).map(|&symbol| graph.symbol(symbol)).collect();
        let terms: Vec<Expr> = [line.drift].iter().chain(&line.noise).copied().collect();
        let forces: Vec<(&Vec<Expr>, Expr)> = line.force.iter().map(|force| (force, weights[0])).collect();
        let driven = line.noise_forces.iter().zip(weights[terms.len()..].iter().copied());
        let forces: Vec<(&Vec<Expr>, Expr)> = forces.into_iter().chain(driven).collect();
        // `∂F/∂x`, and for a coordinate the forces in its direction, which take their part of it.
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
        let stiffness = if is_nystrom { stiffness(graph, line) } else { Vec::new() };
        Self { h, dw, by_q, by_p, is_nystrom, stiffness }
    }
}

/// The constant terms of the second derivatives of the drift by the coordinates. Any matrix may be split off: the one that has all of them leaves
/// a rest without quadratic terms.
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

/// The text of `Gauss<stages>`, without its facts.
pub(crate) fn describe(graph: &mut Graph, line: &StraightLine, slopes: &StepSlopes, stages: u32) -> String {
    let mut text = format!("Gauss<{stages}>\n{}", hamiltonians(graph, line));
    let phase = &line.phase;
    let mut placement = HashMap::new();
    for &symbol in phase.q.iter().chain(&phase.p).chain([&phase.t]) {
        let at_stage = graph.new_symbol(format!("{}_j", graph.symbol_name(symbol)));
        placement.insert(symbol, graph.symbol(at_stage));
    }
    let terms = (1..=slopes.dw.len()).map(|k| format!(" + {} H{k}", graph.symbol_name(slopes.dw[k - 1])));
    let _ = writeln!(text, "\nDiscrete Lagrangian of the step from t_i to t_i + h, with {stages} stages");
    let _ = writeln!(text, "  L_d = ext Σ_j b_j [p_j · V_j - F(q_j, p_j, t_j)]");
    let _ = writeln!(text, "  F = h H0{}", terms.collect::<String>());
    let _ = writeln!(text, "  q_j = q_i + Σ_k a_jk V_k,  q_{{i+1}} = q_i + Σ_j b_j V_j,  t_j = t_i + c_j h");
    let _ = writeln!(text, "  c_j: the roots of the shifted Legendre polynomial P_{stages}(2c - 1)");
    let _ = writeln!(text, "\nDiscrete Euler-Lagrange equations");
    let equation = |graph: &mut Graph, symbol: Symbol, slope: Expr| {
        let slope = graph.substitute(&[slope], &placement)[0];
        (graph.symbol_name(symbol).to_owned(), graph.display(slope).to_string())
    };
    for (&q, &by_p) in phase.q.iter().zip(&slopes.by_p) {
        let (name, slope) = equation(graph, q, by_p);
        let _ = writeln!(
            text,
            "  ∂L_d/∂p_j = 0:  V_{name} = {slope},  {name}_j = {name}_i + Σ_k a_jk V_{name},k"
        );
    }
    for (&p, &by_q) in phase.p.iter().zip(&slopes.by_q) {
        let (name, slope) = equation(graph, p, by_q);
        let _ = writeln!(
            text,
            "  ∂L_d/∂V_j = 0:  {name}_j = {name}_i - Σ_k a_jk K_{name},k,  K_{name} = {slope}"
        );
    }
    for &p in &phase.p {
        let name = graph.symbol_name(p);
        let _ = writeln!(text, "  {name}_{{i+1}} = D2 L_d:  {name}_{{i+1}} = {name}_i - Σ_j b_j K_{name},j");
    }
    let _ = writeln!(text, "\nStep");
    let sweeps = if slopes.is_nystrom { "the coordinates of all stages" } else { "all stages" };
    let _ = writeln!(
        text,
        "  solve for {sweeps}: by sweeps while they contract, else Newton's method on all of them at once"
    );
    if !slopes.stiffness.is_empty() {
        let _ = writeln!(
            text,
            "  where h is large for the linear part K of the force, Q ← Q + (1 + h² A² M⁻¹K)⁻¹ (φ(Q) - Q), made once"
        );
        for &(row, column, value) in &slopes.stiffness {
            let [row, column] = [row, column].map(|d| graph.symbol_name(phase.q[d]).to_owned());
            let _ = writeln!(text, "    K_{row}{column} = {}", graph.display(value));
        }
    }
    text
}
