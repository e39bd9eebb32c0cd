//! Quadrature of a term of the discrete Lagrangian: `h H` becomes `Σ_s w_s h H(P, Q_s)`,
//! `Q_s = (1 - l_s) q_i + l_s q_{i+1}`, with one `P`.
//!
//! Equations of the step with `F = Σ_m c_m H_m`, `u = q_{i+1} - q_i`, and the mean `m = Σ_s w_s l_s` of
//! points whose weights add up to 1:
//!
//! ```text
//! p_i = P + Σ w (1 - l) F_q(P, Q_s),   p_{i+1} = P - Σ w l F_q(P, Q_s),   u = Σ w F_p(P, Q_s)
//! ```
//!
//! To second order in the increments `P = p_i - (1 - m) F_q`, `Q_s = q_i + l_s F_p`, all of `F` at
//! `(q_i, p_i)`, and so
//!
//! ```text
//! u             =  F_p + m F_pq F_p - (1 - m) F_pp F_q + O(3)
//! p_{i+1} - p_i = -F_q - m F_qq F_p + (1 - m) F_qp F_q + O(3)
//! ```
//!
//! which depend on the points through `m` alone. The second-order terms of the flow are those with `m = 1/2`,
//! so the order is two there and one elsewhere. It is never three: with one `P` for all points
//! `(p_{i+1} - P)² + ...` has the second moment 1/4 where a third order needs 1/3. With noise, the products
//! `ΔW_j ΔW_k` of these terms have a mean, which adds `(1/2 - m) Σ_k ∂H_k/∂q · ∂H_k/∂p` to the limit, as one
//! point `m` does; terms of third order have mean zero, up to `O(h²)`. Consistency, the counter-term and the
//! strong order are those of one point `m`. Both hold in the same way for forces, whose virtual work has the
//! same shares.
//!
//! The second moment decides what a step conserves. Compared with one point `m`, the step Hamiltonian has the
//! additional term `c_0 Σ w (l - m)² H_qq(u, u)/2`, which conserves only the quadratic forms that
//! [`Embedding`](super::Embedding) lists for one point. Linear maps of the coordinates move every `Q_s` with
//! the nodes, so their momentum maps, `pᵀA q`, are conserved with any points.
//!
//! Tests: `input/points.rs`, `tests/steps/quadrature.rs`.

use crate::symbolic::Rational;
use crate::tokens::Written;

/// Points `l` from 0 to 1 with their weights, which add up to 1.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct Points {
    list: Vec<(Rational, Rational)>,
    mean: Rational,
    spread: Rational,
}

impl Points {
    /// A single point.
    pub(crate) fn one(l: Rational) -> Self {
        Self { list: vec![(l, Rational::ONE)], mean: l, spread: Rational::ZERO }
    }

    /// Points whose weights add up to 1. `None` if their moments are not exactly representable fractions.
    pub(crate) fn new(list: Vec<(Rational, Rational)>) -> Option<Self> {
        let moment = |of: &dyn Fn(Rational) -> Option<Rational>| {
            list.iter().try_fold(Rational::ZERO, |sum, &(l, weight)| sum.add(of(l)?.multiply(weight)?))
        };
        let mean = moment(&Some)?;
        let from_mean = |l: Rational| l.add(mean.negate());
        let spread = moment(&|l| from_mean(l)?.multiply(from_mean(l)?))?;
        let defect = Rational::HALF.add(mean.negate())?;
        list.iter().try_for_each(|(_, weight)| defect.multiply(*weight).map(|_| ()))?;
        Some(Self { list, mean, spread })
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = (Rational, Rational)> {
        self.list.iter().copied()
    }

    /// `Σ w l`
    pub(crate) fn mean(&self) -> Rational {
        self.mean
    }

    /// `Σ w (l - mean)²`
    pub(crate) fn spread(&self) -> Rational {
        self.spread
    }

    pub(crate) fn is_single(&self) -> bool {
        self.list.len() == 1
    }

    /// Whether the points are symmetric about the middle of the step.
    pub(crate) fn are_symmetric(&self) -> bool {
        self.list.iter().all(|&(l, weight)| {
            let mirrored = Rational::ONE.add(l.negate());
            self.list.iter().any(|&(other, of_other)| Some(other) == mirrored && of_other == weight)
        })
    }
}

/// Points that the user gave a type of the program.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct Declared {
    pub(crate) path: Written<syn::Path>,
    pub(crate) points: Points,
}

impl Declared {
    pub(crate) fn name(&self) -> String {
        self.path.0.segments.last().map_or_else(String::new, |last| last.ident.to_string())
    }
}
