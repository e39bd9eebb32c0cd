//! What can be said about the continuous system: consistency, first integrals, commuting noises, the class of the noise.

use crate::model::{Located, Model, Phase};
use crate::symbolic::zero::{Witness, ZeroTest};
use crate::symbolic::{Expr, Graph, Rational, Symbol};

/// How the noise enters; see `wzvi::plan::NoiseClass`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum NoiseClass {
    None,
    Additive,
    Position,
    Momentum,
    Multiplicative,
}

/// What is known of a statement "this vanishes".
#[derive(Clone, Debug)]
pub(crate) enum Knowledge {
    Proven,
    Refuted(Witness),
    Unknown,
}

/// A declared first integral with its rate of change.
pub(crate) struct Invariant {
    pub(crate) declared: Located<Expr>,
    /// The first rate that is not proven zero: `{H_m, F}` (with `∂F/∂t` for the drift), and the term `m`.
    pub(crate) failure: Option<(usize, Expr, Knowledge)>,
    /// Quadratic in (q, p): kept exactly by `Midpoint`.
    pub(crate) quadratic: bool,
    /// `pᵀA q` plus linear terms: kept exactly by every embedding with one quadrature point.
    pub(crate) bilinear: bool,
}

/// Facts about one model, shared by all its schemes.
pub(crate) struct Facts {
    /// `Σ_k ∂H_k/∂q · ∂H_k/∂p`: the defect of a scheme is `D = (1/2 - l)` times it.
    pub(crate) half_defect_sum: Expr,
    /// Whether that sum is constant on phase space.
    pub(crate) defect_is_constant: Knowledge,
    /// Whether `∂H_j/∂q · ∂H_k/∂p + ∂H_k/∂q · ∂H_j/∂p` is for all noises: then the counter-term does nothing.
    pub(crate) counter_term_is_constant: Knowledge,
    pub(crate) noise: NoiseClass,
    /// `{H_k, H_0}` per noise.
    pub(crate) energy_rates: Vec<Expr>,
    pub(crate) conserves_energy: Knowledge,
    pub(crate) commuting: Knowledge,
    pub(crate) invariants: Vec<Invariant>,
}

impl Facts {
    pub(crate) fn new(model: &mut Model) -> Self {
        let drift = model.drift.value;
        let noise: Vec<Expr> = model.noise.iter().map(|noise| noise.value).collect();
        let phase = &model.phase;
        let graph = &mut model.graph;

        let products: Vec<Expr> = noise.iter().map(|&h| slope_product(graph, phase, h, h)).collect();
        let half_defect_sum = graph.sum(&products);
        let mut counter_terms = products;
        for (k, &first) in noise.iter().enumerate() {
            for &second in &noise[..k] {
                let (one, other) =
                    (slope_product(graph, phase, first, second), slope_product(graph, phase, second, first));
                counter_terms.push(graph.add(one, other));
            }
        }
        let energy_rates: Vec<Expr> =
            noise.iter().map(|&h| poisson_bracket(graph, phase, h, drift)).collect();
        let explicit_rate = graph.derivative(drift, phase.t);
        let mut rates = energy_rates.clone();
        rates.push(explicit_rate);
        let mut brackets = Vec::new();
        for (k, &first) in noise.iter().enumerate() {
            for &second in &noise[..k] {
                brackets.push(poisson_bracket(graph, phase, second, first));
            }
        }
        let bracket_slopes: Vec<Expr> = brackets.iter().flat_map(|&b| gradient(graph, phase, b)).collect();
        let defect_slopes = gradient(graph, phase, half_defect_sum);
        let counter_slopes: Vec<Expr> =
            counter_terms.iter().flat_map(|&term| gradient(graph, phase, term)).collect();
        Self {
            half_defect_sum,
            defect_is_constant: all_vanish(graph, &defect_slopes),
            counter_term_is_constant: all_vanish(graph, &counter_slopes),
            noise: noise_class(graph, phase, &noise),
            conserves_energy: all_vanish(graph, &rates),
            commuting: all_vanish(graph, &bracket_slopes),
            energy_rates,
            invariants: model.invariants.iter().map(|&f| invariant(graph, phase, drift, &noise, f)).collect(),
        }
    }

    /// Whether noises at quadrature point `l` give the Stratonovich limit: `D` is constant.
    pub(crate) fn is_consistent(&self, l: Rational) -> bool {
        l == Rational::HALF || matches!(self.defect_is_constant, Knowledge::Proven)
    }

    /// Whether the counter-term changes a scheme whose noises are at `l`. It may also where `D` is constant: its mixed
    /// products do not show in the limit, but without them commuting noises lose half an order.
    pub(crate) fn counter_term_acts(&self, l: Rational) -> bool {
        l != Rational::HALF && !matches!(self.counter_term_is_constant, Knowledge::Proven)
    }

    /// `D = (1/2 - l) Σ_k ∂H_k/∂q · ∂H_k/∂p`
    pub(crate) fn defect(&self, graph: &mut Graph, l: Rational) -> Expr {
        let weight = Rational::HALF.add(l.negate()).unwrap_or(Rational::ZERO);
        graph.scale(self.half_defect_sum, weight)
    }
}

/// `{f, g} = f_p · g_q - f_q · g_p`
pub(crate) fn poisson_bracket(graph: &mut Graph, phase: &Phase, f: Expr, g: Expr) -> Expr {
    let mut terms = Vec::new();
    for (&q, &p) in phase.q.iter().zip(&phase.p) {
        let (f_p, g_q) = (graph.derivative(f, p), graph.derivative(g, q));
        let (f_q, g_p) = (graph.derivative(f, q), graph.derivative(g, p));
        terms.push((graph.multiply(f_p, g_q), Rational::ONE));
        terms.push((graph.multiply(f_q, g_p), Rational::MINUS_ONE));
    }
    graph.linear_combination(&terms)
}

/// `∂f/∂q · ∂g/∂p`
fn slope_product(graph: &mut Graph, phase: &Phase, f: Expr, g: Expr) -> Expr {
    let mut terms = Vec::new();
    for (&q, &p) in phase.q.iter().zip(&phase.p) {
        let (f_q, g_p) = (graph.derivative(f, q), graph.derivative(g, p));
        terms.push(graph.multiply(f_q, g_p));
    }
    graph.sum(&terms)
}

fn gradient(graph: &mut Graph, phase: &Phase, f: Expr) -> Vec<Expr> {
    phase.q.iter().chain(&phase.p).map(|&symbol| graph.derivative(f, symbol)).collect()
}

fn all_vanish(graph: &Graph, expressions: &[Expr]) -> Knowledge {
    let mut known = Knowledge::Proven;
    for &expr in expressions {
        match graph.test_zero(expr) {
            ZeroTest::Zero => {}
            ZeroTest::Nonzero(witness) => return Knowledge::Refuted(witness),
            ZeroTest::Unknown => known = Knowledge::Unknown,
        }
    }
    known
}

fn noise_class(graph: &mut Graph, phase: &Phase, noise: &[Expr]) -> NoiseClass {
    let all: Vec<Symbol> = phase.q.iter().chain(&phase.p).copied().collect();
    let is_affine = |graph: &mut Graph, f: Expr| {
        gradient(graph, phase, f).iter().all(|&slope| !graph.depends_on(slope, &all))
    };
    if noise.is_empty() {
        NoiseClass::None
    } else if noise.iter().all(|&f| is_affine(graph, f)) {
        NoiseClass::Additive
    } else if noise.iter().all(|&f| !graph.depends_on(f, &phase.p)) {
        NoiseClass::Position
    } else if noise.iter().all(|&f| !graph.depends_on(f, &phase.q)) {
        NoiseClass::Momentum
    } else {
        NoiseClass::Multiplicative
    }
}

fn invariant(
    graph: &mut Graph,
    phase: &Phase,
    drift: Expr,
    noise: &[Expr],
    declared: Located<Expr>,
) -> Invariant {
    let f = declared.value;
    let mut failure = None;
    for (term, &hamiltonian) in [drift].iter().chain(noise).enumerate() {
        let mut rate = poisson_bracket(graph, phase, hamiltonian, f);
        if term == 0 {
            let explicit = graph.derivative(f, phase.t);
            rate = graph.add(rate, explicit);
        }
        match all_vanish(graph, &[rate]) {
            Knowledge::Proven => {}
            knowledge => {
                failure = Some((term, rate, knowledge));
                break;
            }
        }
    }
    let all: Vec<Symbol> = phase.q.iter().chain(&phase.p).copied().collect();
    let curvature = |graph: &mut Graph, first: &[Symbol], second: &[Symbol]| -> Vec<Expr> {
        let pairs = first.iter().flat_map(|&a| second.iter().map(move |&b| (a, b)));
        pairs
            .map(|(a, b)| {
                let slope = graph.derivative(f, a);
                graph.derivative(slope, b)
            })
            .collect()
    };
    let quadratic = curvature(graph, &all, &all).iter().all(|&c| !graph.depends_on(c, &all));
    let same_kind = [curvature(graph, &phase.q, &phase.q), curvature(graph, &phase.p, &phase.p)].concat();
    let bilinear = quadratic && same_kind.iter().all(|&c| graph.is_zero(c));
    Invariant { declared, failure, quadratic, bilinear }
}
