//! The text of steps on the manifold of constraints.

use super::{DEGREES, for_each, noise_terms};
use crate::discretise::Facts;
use crate::embedding::Embedding;
use crate::model::System;
use crate::symbolic::Symbol;

/// The text of `Rattle` or `GBaoab`, with a line for each entry of the Jacobian if the system is unrolled.
pub(crate) fn derivation(system: &mut System, facts: &Facts, embedding: &Embedding) -> String {
    let mut text = match embedding {
        Embedding::GBaoab => BATH.to_owned(),
        _ => lagrangian(system, facts),
    };
    slopes(system, &mut text);
    solvers(system, facts, &mut text);
    text
}

/// How a step with a bath is taken.
const BATH: &str = "
Step on the manifold, with G = ∂g/∂q, W = M⁻¹ and the projection Π = 1 - Gᵀ (G W Gᵀ)⁻¹ G W
  kick of h/2:   p <- Π (p - h/2 ∂V/∂q)
  drift of h/2:  q <- q + h/2 W P with P = p - Gᵀ ν and g(q) = 0, then p <- Π P
  friction and noise of h:  p <- Π (c p + R ξ), c = e^{-γ h}, R Rᵀ = kT (1 - c²) M
  drift of h/2, kick of h/2
  driven by the increments of the noises, then √h times the normals ξ
";

/// The discrete Lagrangian of `Rattle` and its equations.
fn lagrangian(system: &System, facts: &Facts) -> String {
    let noise = noise_terms(system, false);
    let timed = facts.constraints.iter().any(|constraint| {
        constraint.value.iter().any(|weighted| weighted.element.reads_time(&system.graph, system.t))
    });
    let rate = if timed { " + ∂g/∂t(q_{i+1}, t_{i+1})" } else { "" };
    let friction = match system.conformal {
        Some(_) => "\n  before and after: p <- e^{-γ h/2} p",
        None => "",
    };
    let velocity = match facts.has_squares {
        true => "h ∂H0/∂p(P)",
        false => "1/2 ∂F/∂p(q_i, P, t_i) + 1/2 ∂F/∂p(q_{i+1}, P, t_{i+1})",
    };
    let forces = noise_terms(system, true).replace(" + ", " - ");
    let slope = match (facts.has_force, forces.as_str()) {
        (false, "") => "∂F/∂q".to_owned(),
        (true, forces) => format!("(∂F/∂q - h F0{forces})"),
        (false, forces) => format!("(∂F/∂q{forces})"),
    };
    format!(
        "
Discrete Lagrangian of the step from t_i to t_i + h, with F = h H0{noise}
  L_d = P · (q_{{i+1}} - q_i) - F(q_i, P, t_i)/2 - F(q_{{i+1}}, P, t_{{i+1}})/2
        - h/2 λ · g(q_i, t_i) - h/2 μ · g(q_{{i+1}}, t_{{i+1}})

Discrete Euler-Lagrange equations, with G = ∂g/∂q
  p_i = -D1 L_d:      P = p_i - 1/2 {slope}(q_i, t_i) - h/2 G(q_i, t_i)ᵀ λ
  ∂L_d/∂P = 0:        q_{{i+1}} = q_i + {velocity}
  ∂L_d/∂λ of the next step = 0:  g(q_{{i+1}}, t_{{i+1}}) = 0
  p_{{i+1}} = D2 L_d:   p_{{i+1}} = P - 1/2 {slope}(q_{{i+1}}, t_{{i+1}}) - h/2 G(q_{{i+1}}, t_{{i+1}})ᵀ μ
  0 = dg/dt:          0 = G(q_{{i+1}}, t_{{i+1}}) ∂H0/∂p(p_{{i+1}}){rate}{friction}
"
    )
}

/// The equations that a step solves, and their matrices.
fn solvers(system: &System, facts: &Facts, text: &mut String) {
    let constraints = system.constraint_offsets().last().and_then(|all| all.as_integer());
    let left = system.degrees_in_straight_lines().zip(constraints).map(|(degrees, constraints)| {
        let left = degrees as i128 - constraints;
        format!("; degrees of freedom left: {left} of {degrees}, if no constraint follows from others")
    });
    let left = left.unwrap_or_else(|| {
        "; degrees of freedom left: all but one for each constraint that does not follow from others"
            .to_owned()
    });
    if !facts.has_squares {
        say!(
            text,
            "\nStep\n  solve for P, q_{{i+1}} and λ: Newton, one dense matrix\n  \
             solve for μ: Newton, matrix h/2 G ∂²H0/∂p² Gᵀ at q_{{i+1}}{left}"
        );
        return;
    }
    let solver = match system.line {
        Some(_) => "",
        None => ", sparse: one unknown for each constraint, coupled where they share a coordinate",
    };
    say!(
        text,
        "\nStep\n  solve for λ: Newton, matrix h²/2 G(q_{{i+1}}) W G(q_i)ᵀ with W = ∂²H0/∂p²{solver}\n  \
         solve for μ: linear, matrix h/2 G W Gᵀ at q_{{i+1}}{left}"
    );
}

/// The rows of the Jacobian of a system in straight lines.
fn slopes(system: &mut System, text: &mut String) {
    if system.line.is_none() {
        return;
    }
    let numbers = system.constraint_numbers();
    let System { graph, constraints, .. } = system;
    for_each(constraints.len(), DEGREES, text, |k, text| {
        for element in &constraints[k].term.values {
            let coordinates: Vec<Symbol> = element.coordinates().map(|(symbol, _)| symbol).collect();
            for q in coordinates {
                let slope = graph.derivative(element.value, q);
                say!(
                    text,
                    "  G{}, {} = {}",
                    numbers[k],
                    graph.symbol_name(q).to_owned(),
                    graph.display(slope)
                );
            }
        }
    });
}
