//! The text of schemes with several stages.

use std::collections::HashMap;

use super::{DEGREES, for_each, noise_terms};
use crate::discretise::{Facts, Plans, StepGradient};
use crate::model::System;
use crate::symbolic::{Expr, Graph, Symbol};

/// The text of `Gauss<stages>`; with a line for each equation if the system is unrolled.
pub(crate) fn derivation(system: &mut System, facts: &Facts, plans: &Plans, stages: u32) -> String {
    let noise = noise_terms(system, false);
    let mut text = format!(
        "
Discrete Lagrangian of the step from t_i to t_i + h, with {stages} stages
  L_d = ext Σ_j b_j [p_j · V_j - F(q_j, p_j, t_j)]
  F = h H0{noise}
  q_j = q_i + Σ_k a_jk V_k,  q_{{i+1}} = q_i + Σ_j b_j V_j,  t_j = t_i + c_j h
  c_j: the roots of the shifted Legendre polynomial P_{stages}(2c - 1)

Discrete Euler-Lagrange equations
"
    );
    let graph = &mut system.graph;
    match &plans.gradient {
        Some(gradient) => equations(graph, gradient, &mut text),
        None => text.push_str(
            "  ∂L_d/∂p_j = 0:  V_j = ∂F/∂p (q_j, p_j, t_j)
  ∂L_d/∂V_j = 0:  p_j = p_i - Σ_k a_jk ∂F/∂q (q_k, p_k, t_k)
  p_{i+1} = D2 L_d:  p_{i+1} = p_i - Σ_j b_j ∂F/∂q (q_j, p_j, t_j)
",
        ),
    }
    let unknowns = if facts.is_nystrom { "the coordinates of all stages" } else { "all stages" };
    say!(
        text,
        "\nStep\n  solve for {unknowns}: by sweeps while they contract, else Newton's method on all of them at once"
    );
    if let Some(StepGradient { line, stiffness, .. }) = &plans.gradient
        && !stiffness.is_empty()
    {
        say!(
            text,
            "  where h is large for the linear part K of the force, Q ← Q + (1 + h² A² M⁻¹K)⁻¹ (φ(Q) - Q), made once"
        );
        for_each(stiffness.len(), "entries", &mut text, |entry, text| {
            let (row, column, value) = stiffness[entry];
            let [row, column] = [row, column].map(|d| graph.symbol_name(line.phase.q[d]).to_owned());
            say!(text, "    K_{row}{column} = {}", graph.display(value));
        });
    }
    text
}

/// `V` and `K`, the slopes of `F` at a stage, by component.
fn equations(graph: &mut Graph, gradient: &StepGradient, text: &mut String) {
    let StepGradient { line, by_q, by_p, .. } = gradient;
    let phase = &line.phase;
    let mut placement = HashMap::new();
    for &symbol in phase.q.iter().chain(&phase.p).chain([&phase.t]) {
        let name = format!("{}_j", graph.symbol_name(symbol));
        let at_stage = graph.new_symbol_like(symbol, name);
        placement.insert(symbol, graph.symbol(at_stage));
    }
    let mut equation = |symbol: Symbol, slope: Expr| {
        let slope = graph.substitute(&[slope], &placement)[0];
        (graph.symbol_name(symbol).to_owned(), graph.display(slope))
    };
    for_each(phase.q.len(), DEGREES, text, |i, text| {
        let (name, slope) = equation(phase.q[i], by_p[i]);
        say!(text, "  ∂L_d/∂p_j = 0:  V_{name} = {slope},  {name}_j = {name}_i + Σ_k a_jk V_{name},k");
    });
    for_each(phase.p.len(), DEGREES, text, |i, text| {
        let (name, slope) = equation(phase.p[i], by_q[i]);
        say!(text, "  ∂L_d/∂V_j = 0:  {name}_j = {name}_i - Σ_k a_jk K_{name},k,  K_{name} = {slope}");
    });
    for_each(phase.p.len(), DEGREES, text, |i, text| {
        let name = graph.symbol_name(phase.p[i]);
        say!(text, "  {name}_{{i+1}} = D2 L_d:  {name}_{{i+1}} = {name}_i - Σ_j b_j K_{name},j");
    });
}
