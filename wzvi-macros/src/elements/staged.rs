//! Schemes with several stages, of systems of elements.

use std::fmt::Write;

use crate::elements::describe::hamiltonians;
use crate::model::System;

/// The text of `Gauss<stages>`, without its facts.
pub(crate) fn describe(model: &System, stages: u32) -> String {
    let mut text = format!("Gauss<{stages}>\n\n{}", hamiltonians(model));
    let numbers = model.noise_numbers();
    let terms = numbers.iter().map(|number| format!(" + ΔW{number} H{number}"));
    let _ = write!(
        text,
        "
Discrete Lagrangian of the step from t to t + h, from q, p to q', p', with {stages} stages
  L_d = ext Σ_j b_j [P_j · V_j - F(P_j, Q_j, t + c_j h)]
  F = h H0{}
  Q_j = q + Σ_k a_jk V_k,  q' = q + Σ_j b_j V_j
  c_j: the roots of the shifted Legendre polynomial P_{stages}(2c - 1)

Discrete Euler-Lagrange equations
  ∂L_d/∂P_j = 0:  V_j = ∂F/∂P (P_j, Q_j)
  ∂L_d/∂V_j = 0:  P_j = p - Σ_k a_jk ∂F/∂Q (P_k, Q_k)
  p' = D2 L_d:    p' = p - Σ_j b_j ∂F/∂Q (P_j, Q_j)

Step
  solve for all stages: by sweeps while they contract, else Newton's method on all of them at once
",
        terms.collect::<String>()
    );
    text
}
