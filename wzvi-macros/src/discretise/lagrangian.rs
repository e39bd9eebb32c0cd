//! The discrete Lagrangian of a small system, the source of its generated step, with the stages of
//! [`quadrature`](super::quadrature):
//!
//! ```text
//! L_d = P · u - F,   F = Σ_m c_m H_m(P, Q_l, T_l),   c_0 = h,  c_k = ΔW_k,
//! u = q_{i+1} - q_i,   Q_l = q_i + l u,   T_l = t_i + l h,   l = l_m
//! ```
//!
//! Forces do the virtual work `Σ_s f(P, Q_s, T_s) · δQ_s`, so that `(1 - l) f` and `l f` are added to
//! `D_1 L_d` and `D_2 L_d`. Friction of one rate `γ` is absorbed by the momentum `π = e^{γ (t - t_i)} p`, for
//! which `K = e^{γ τ} H(q, e^{-γ τ} π)` is a Hamiltonian: with `L_d` of `K`, `p_i = -D_1 L_d` and
//! `p_{i+1} = e^{-γ h} D_2 L_d`, and the step multiplies the symplectic form by `e^{-γ h}`.
//!
//! Tests: `tests/steps/reference.rs`.

use std::collections::HashMap;

use super::quadrature::{Quadrature, Stage};
use super::roles::Role;
use super::unknown::ByUnknown;
use crate::model::{Phase, StraightLine};
use crate::symbolic::{Expr, Function, Graph, Rational, Symbol, SymbolKind};

/// One stage with the symbols of `Q_l` and `T_l`.
pub(crate) struct StageSymbols {
    pub(crate) at: Stage,
    pub(crate) q: Vec<Symbol>,
    pub(crate) t: Symbol,
}

/// The symbols of one step.
pub(crate) struct StepSymbols {
    /// `q_i` and `p_i`: the node that the step starts from, to which the unknowns are added.
    pub(crate) nodes: ByUnknown<Symbol>,
    /// `u = q_{i+1} - q_i` and `v = P - p_i`.
    pub(crate) unknowns: ByUnknown<Symbol>,
    /// `P`, the momentum of the step.
    pub(crate) momentum: Vec<Symbol>,
    pub(crate) t: Symbol,
    pub(crate) h: Symbol,
    pub(crate) dw: Vec<Symbol>,
    pub(crate) stages: Vec<StageSymbols>,
}

/// `L_d` and its partial derivatives, in the symbols `u`, `P`, `Q_l`, `T_l`, `h`, `ΔW` and the parameters.
pub(crate) struct DiscreteLagrangian {
    pub(crate) symbols: StepSymbols,
    pub(crate) value: Expr,
    /// `∂L_d/∂P`
    pub(crate) by_momentum: Vec<Expr>,
    /// `D_1 L_d = ∂L_d/∂q_i`, and the share of forces there: `-p_i`.
    pub(crate) by_start: Vec<Expr>,
    /// `D_2 L_d = ∂L_d/∂q_{i+1}`, with the share of forces, damped by friction: `p_{i+1}`.
    pub(crate) by_end: Vec<Expr>,
}

impl DiscreteLagrangian {
    pub(crate) fn new(graph: &mut Graph, line: &StraightLine, quadrature: &Quadrature) -> Self {
        let symbols = StepSymbols::new(graph, &line.phase, line.noises(), quadrature);
        let step = PlacedLine { line, symbols: &symbols };
        let forces: Vec<Vec<Expr>> = symbols.stages.iter().map(|stage| step.forces(graph, stage)).collect();
        // `e^{-γ h} - 1`
        let decay = step.exponential(graph, Rational::MINUS_ONE, Function::ExpM1);
        let step_hamiltonian = step.hamiltonian(graph);
        let mut terms = vec![(step_hamiltonian, Rational::MINUS_ONE)];
        for (&momentum, &u) in symbols.momentum.iter().zip(&symbols.unknowns.q) {
            let (momentum, u) = (graph.symbol(momentum), graph.symbol(u));
            terms.push((graph.multiply(momentum, u), Rational::ONE));
        }
        let value = graph.linear_combination(&terms);
        let by_momentum = symbols.momentum.iter().map(|&p| graph.derivative(value, p)).collect();
        let mut by_node = |weights: NodeWeights| -> Vec<Expr> {
            (0..symbols.degrees()).map(|i| symbols.by_node(graph, value, &forces, i, weights)).collect()
        };
        let by_start = by_node(NodeWeights { increment: Rational::MINUS_ONE, stage: Stage::start });
        let mut by_end = by_node(NodeWeights { increment: Rational::ONE, stage: Stage::end });
        if let Some(decay) = decay {
            // `e^{-γ h} - 1` is small, and so is the added term.
            by_end.iter_mut().for_each(|end| {
                let taken = graph.multiply(decay, *end);
                *end = graph.add(*end, taken);
            });
        }
        Self { symbols, value, by_momentum, by_start, by_end }
    }
}

/// The derivative by a node of a step: the weights of `∂/∂u`, and of `∂/∂Q_l` for each stage.
#[derive(Clone, Copy)]
struct NodeWeights {
    increment: Rational,
    stage: fn(&Stage) -> Rational,
}

impl StepSymbols {
    /// Names as in the paper: nodes `q_i`, increments `Δq`, quadrature points `q_{i+1/2}`, the momentum `P`.
    fn new(graph: &mut Graph, phase: &Phase, noises: usize, quadrature: &Quadrature) -> Self {
        let copies = |graph: &mut Graph, of: &[Symbol], name: &dyn Fn(&str) -> String| -> Vec<Symbol> {
            let copy = |&symbol: &Symbol| {
                let name = name(graph.symbol_name(symbol));
                graph.new_symbol_like(symbol, name)
            };
            of.iter().map(copy).collect()
        };
        let is_single = phase.q.len() == 1;
        let q0 = copies(graph, &phase.q, &|name| format!("{name}_i"));
        let p0 = copies(graph, &phase.p, &|name| format!("{name}_i"));
        let mut displacements = |of: &[Symbol], sign: char| -> Vec<Symbol> {
            let names: Vec<String> =
                of.iter().map(|&symbol| format!("{sign}{}", graph.symbol_name(symbol))).collect();
            names.into_iter().map(|name| graph.new_symbol(SymbolKind::Displacement, name)).collect()
        };
        let (u, v) = (displacements(&phase.q, 'Δ'), displacements(&phase.p, 'δ'));
        let momentum =
            copies(graph, &phase.p, &|name| if is_single { "P".to_owned() } else { format!("P_{{{name}}}") });
        let stages = quadrature.stages.iter().map(|stage| StageSymbols {
            q: copies(graph, &phase.q, &|name| format!("{name}_{}", node_index(stage.l))),
            t: graph.new_symbol(SymbolKind::Time, format!("t_{}", node_index(stage.l))),
            at: stage.clone(),
        });
        let stages = stages.collect();
        let h = graph.new_symbol(SymbolKind::StepSize, "h");
        let t = graph.new_symbol(SymbolKind::Time, "t_i");
        let increment = |k: usize| if noises == 1 { "ΔW".to_owned() } else { format!("ΔW{k}") };
        let dw = (1..=noises).map(|k| graph.new_symbol(SymbolKind::Increment, increment(k))).collect();
        let (nodes, unknowns) = (ByUnknown { q: q0, p: p0 }, ByUnknown { q: u, p: v });
        Self { nodes, unknowns, momentum, t, h, dw, stages }
    }

    pub(crate) fn degrees(&self) -> usize {
        self.momentum.len()
    }

    /// `∂/∂q_i = -∂/∂u + Σ_l (1 - l) ∂/∂Q_l` and `∂/∂q_{i+1} = ∂/∂u + Σ_l l ∂/∂Q_l`, with the virtual work of
    /// the forces at the stages.
    fn by_node(
        &self,
        graph: &mut Graph,
        value: Expr,
        forces: &[Vec<Expr>],
        i: usize,
        weights: NodeWeights,
    ) -> Expr {
        let mut terms = vec![(graph.derivative(value, self.unknowns.q[i]), weights.increment)];
        for (stage, forces) in self.stages.iter().zip(forces) {
            let weight = (weights.stage)(&stage.at);
            terms.push((graph.derivative(value, stage.q[i]), weight));
            terms.extend(forces.get(i).map(|&force| (force, weight)));
        }
        graph.linear_combination(&terms)
    }
}

/// `i`, `{i+1}`, `{i+1/2}`
fn node_index(l: Rational) -> String {
    if l.is_zero() { "i".to_owned() } else { format!("{{i+{l}}}") }
}

/// A straight line with the symbols of its step.
struct PlacedLine<'a> {
    line: &'a StraightLine,
    symbols: &'a StepSymbols,
}

impl PlacedLine<'_> {
    /// A function of `γ l h`, if friction is part of the steps.
    fn exponential(&self, graph: &mut Graph, l: Rational, function: Function) -> Option<Expr> {
        let rate = self.line.conformal?;
        let h = graph.symbol(self.symbols.h);
        let product = graph.multiply(rate, h);
        let exponent = graph.scale(product, l);
        Some(graph.apply(function, &[exponent]))
    }

    /// The images of phase-space symbols at a stage, with momenta divided by the scale `e^{γ l h}`, and that
    /// scale.
    fn at(&self, graph: &mut Graph, stage: &StageSymbols) -> (HashMap<Symbol, Expr>, Option<Expr>) {
        let is_there = !stage.at.l.is_zero();
        let scale = is_there.then(|| self.exponential(graph, stage.at.l, Function::Exp)).flatten();
        let Phase { q, p, t, .. } = &self.line.phase;
        let from = q.iter().chain(p).chain([t]);
        let to = stage.q.iter().chain(&self.symbols.momentum).chain([&stage.t]);
        let images = from.zip(to).map(|(&from, &to)| (from, graph.symbol(to)));
        let mut images: HashMap<Symbol, Expr> = images.collect();
        if let Some(scale) = scale {
            for p in p {
                images.entry(*p).and_modify(|momentum| *momentum = graph.divide(*momentum, scale));
            }
        }
        (images, scale)
    }

    /// The forces at a stage, `h f + Σ_k ΔW_k f_k`; empty for a system without forces.
    fn forces(&self, graph: &mut Graph, stage: &StageSymbols) -> Vec<Expr> {
        let (images, scale) = self.at(graph, stage);
        let StraightLine { phase, noise, force, noise_forces, .. } = self.line;
        let StepSymbols { h, dw, .. } = self.symbols;
        let mut terms: Vec<Vec<Expr>> = Vec::new();
        for &(role, share) in &stage.at.roles {
            let driven: Vec<(&Symbol, &Vec<Expr>)> = match role {
                Role::Force => force.iter().map(|force| (h, force)).collect(),
                Role::Noise => dw[noise.len()..].iter().zip(noise_forces).collect(),
                _ => Vec::new(),
            };
            for (increment, force) in driven {
                let increment = graph.symbol(*increment);
                let factors: Vec<Expr> = scale.into_iter().chain([increment]).collect();
                let product = graph.product(&factors);
                let weight = graph.scale(product, share);
                let placed = graph.substitute(force, &images);
                terms.push(placed.into_iter().map(|component| graph.multiply(weight, component)).collect());
            }
        }
        let degrees = if terms.is_empty() { 0 } else { phase.q.len() };
        (0..degrees).map(|i| graph.sum(&terms.iter().map(|term| term[i]).collect::<Vec<_>>())).collect()
    }

    /// `F = Σ_s Σ_m w_m F_m(P, Q_s, T_s)`
    fn hamiltonian(&self, graph: &mut Graph) -> Expr {
        let (line, symbols) = (self.line, self.symbols);
        let mut terms = Vec::new();
        for stage in &symbols.stages {
            let (images, scale) = self.at(graph, stage);
            for &(role, weight) in &stage.at.roles {
                let (hamiltonians, increments) = match role {
                    Role::Drift => (std::slice::from_ref(&line.drift), std::slice::from_ref(&symbols.h)),
                    Role::Noise | Role::CounterTerm => (line.noise.as_slice(), symbols.dw.as_slice()),
                    _ => continue,
                };
                let placed = graph.substitute(hamiltonians, &images).into_iter();
                let scaled = placed.map(|value| scale.map_or(value, |scale| graph.multiply(scale, value)));
                let scaled: Vec<Expr> = scaled.collect();
                if role == Role::CounterTerm {
                    terms.push((counter_term(graph, symbols, stage, &scaled), weight));
                    continue;
                }
                for (hamiltonian, &increment) in scaled.into_iter().zip(increments) {
                    let increment = graph.symbol(increment);
                    terms.push((graph.multiply(increment, hamiltonian), weight));
                }
            }
        }
        graph.linear_combination(&terms)
    }
}

/// `(Σ_j ΔW_j ∂H_j/∂q) · (Σ_k ΔW_k ∂H_k/∂p)`, which is already symmetric in the noises.
fn counter_term(graph: &mut Graph, symbols: &StepSymbols, stage: &StageSymbols, noise: &[Expr]) -> Expr {
    let mut terms = Vec::new();
    for (&q, &p) in stage.q.iter().zip(&symbols.momentum) {
        let mut weighted_slope = |symbol: Symbol| {
            let slopes = noise.iter().zip(&symbols.dw).map(|(&hamiltonian, &dw)| {
                let slope = graph.derivative(hamiltonian, symbol);
                let dw = graph.symbol(dw);
                graph.multiply(dw, slope)
            });
            let slopes: Vec<Expr> = slopes.collect();
            graph.sum(&slopes)
        };
        let (force, velocity) = (weighted_slope(q), weighted_slope(p));
        terms.push(graph.multiply(force, velocity));
    }
    graph.sum(&terms)
}
