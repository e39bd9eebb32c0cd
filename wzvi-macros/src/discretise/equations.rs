//! The discrete Euler-Lagrange equations of one step as a fixed point `x = φ(x)` of the unknown increments
//! `u = q_{i+1} - q_i` and `v = P - p_i`:
//!
//! ```text
//! ∂L_d/∂P = 0        :  u = φ_u = u - ∂L_d/∂P
//! p_i = -D_1 L_d     :  v = φ_v = P + D_1 L_d
//! p_{i+1} = D_2 L_d  :  p_{i+1} - p_i = v + (D_2 L_d - P)
//! ```
//!
//! Tests: `tests/steps/reference.rs`.

use crate::diagnostics::promised;
use crate::discretise::{ByUnknown, DiscreteLagrangian};
use crate::symbolic::{Expr, Graph, Rational};

/// How `p_{i+1} - p_i` follows from the solved unknowns.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum MomentumUpdate {
    /// `factor · v`: where `D_2 L_d - P` is a multiple of `φ_v`, the forces need not be evaluated again.
    Multiple(Rational),
    /// `v + (D_2 L_d - P)`; the expression is the bracket.
    Sum(Expr),
}

impl MomentumUpdate {
    /// `p_{i+1} - p_i`
    pub(crate) fn change(self, graph: &mut Graph, v: Expr) -> Expr {
        match self {
            Self::Multiple(factor) => graph.scale(v, factor),
            Self::Sum(rest) => graph.add(v, rest),
        }
    }
}

/// `φ` of every unknown, and the momentum update per degree of freedom.
#[derive(Clone)]
pub(crate) struct Equations {
    /// `φ_u` and `φ_v`.
    pub(crate) phi: ByUnknown<Expr>,
    pub(crate) update: Vec<MomentumUpdate>,
}

impl Equations {
    pub(crate) fn new(graph: &mut Graph, lagrangian: &DiscreteLagrangian) -> Self {
        let symbols = &lagrangian.symbols;
        let (mut phi_u, mut phi_v, mut update) = (Vec::new(), Vec::new(), Vec::new());
        for i in 0..symbols.degrees() {
            let (u, momentum) = (graph.symbol(symbols.unknowns.q[i]), graph.symbol(symbols.momentum[i]));
            phi_u.push(graph.subtract(u, lagrangian.by_momentum[i]));
            phi_v.push(graph.add(momentum, lagrangian.by_start[i]));
            let rest = graph.subtract(lagrangian.by_end[i], momentum);
            update.push(momentum_update(graph, lagrangian, phi_v[i], rest));
        }
        Self { phi: ByUnknown { q: phi_u, p: phi_v }, update }
    }
}

/// With one quadrature point `l < 1`, `φ_v = -(1-l) F_q` and `D_2 L_d - P = -l F_q`, so the update is
/// `v / (1-l)`. With several, the same may still hold for one degree of freedom: every `l` is tried on the
/// expressions themselves.
fn momentum_update(
    graph: &mut Graph,
    lagrangian: &DiscreteLagrangian,
    phi_v: Expr,
    rest: Expr,
) -> MomentumUpdate {
    if graph.is_zero(rest) {
        return MomentumUpdate::Multiple(Rational::ONE);
    }
    for stage in &lagrangian.symbols.stages {
        let Some(inverse) = stage.at.start().recip() else { continue };
        let ratio = promised(stage.at.end().multiply(inverse), "quadrature points are fractions of 32 bits");
        let difference = graph.linear_combination(&[(rest, Rational::ONE), (phi_v, ratio.negate())]);
        if graph.is_zero(difference) {
            return MomentumUpdate::Multiple(inverse);
        }
    }
    MomentumUpdate::Sum(rest)
}
