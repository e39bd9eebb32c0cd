//! The order in which the unknowns of a step are solved, and the solution of each block.
//!
//! `u_i` and `v_i` are the vertices of a graph with an edge from each unknown to those its `φ` reads.
//! Strongly connected components in topological order are the blocks. Within a block the iterates are a
//! smallest set of unknowns that breaks every cycle; the others are assigned from them. For `T(p) + V(q)`
//! these are `d` of `2d`.
//!
//! Tests: `tests/steps/plan.rs`.

use std::collections::HashMap;

use self::isolate::isolate;
use crate::discretise::{DiscreteLagrangian, Equations, StepSymbols, Unknown};
use crate::symbolic::{Expr, Graph, Node, Rational, Symbol};

mod blocks;
mod isolate;

pub(crate) use blocks::Dependencies;
pub(crate) use isolate::{MOST_ISOLATED, Pivot};

/// The solution of a block for its iterates `x`.
pub(crate) enum Solution {
    /// Nothing to solve: every unknown is assigned.
    Assigned,
    /// No unknowns: the reciprocal for an isolated unknown of the next block.
    Isolated(Pivot),
    /// `matrix · x = rhs`
    Linear { matrix: Vec<Vec<Expr>>, rhs: Vec<Expr> },
    /// `residual(x) = 0` with `jacobian = ∂residual/∂x`.
    Newton { residual: Vec<Expr>, jacobian: Vec<Vec<Expr>>, symmetric: bool },
}

/// Unknowns that are solved together.
pub(crate) struct Block {
    /// The unknowns to solve for.
    pub(crate) iterates: Vec<Unknown>,
    /// The unknowns assigned from the iterates, in order.
    pub(crate) assigned: Vec<Unknown>,
    pub(crate) solution: Solution,
}

impl Block {
    fn of(solution: Solution) -> Self {
        Self { iterates: Vec::new(), assigned: Vec::new(), solution }
    }
}

/// The blocks in solving order, and the definition of every symbol of the step.
pub(crate) struct Structure {
    pub(crate) blocks: Vec<Block>,
    /// `P`, `Q_l`, `T_l` and the assigned unknowns in terms of symbols that come before them.
    pub(crate) definitions: HashMap<Symbol, Expr>,
}

impl Structure {
    pub(crate) fn new(graph: &mut Graph, lagrangian: &DiscreteLagrangian, equations: &Equations) -> Self {
        let symbols = &lagrangian.symbols;
        let dependencies = Dependencies::new(graph, symbols, equations);
        let mut definitions = HashMap::new();
        let mut blocks = Vec::new();
        for component in dependencies.components() {
            let (iterates, assigned) = dependencies.split(&component);
            let mut block = BlockSolver::new(graph, symbols, equations).block(iterates, assigned);
            let mut solved = equations;
            let isolated = match block.solution {
                Solution::Newton { .. } => isolate(graph, symbols, equations, &component, &block.iterates),
                _ => None,
            };
            if let Some((equations, dependencies, pivots)) = &isolated {
                let (iterates, assigned) = dependencies.split(&component);
                block = BlockSolver::new(graph, symbols, equations).block(iterates, assigned);
                solved = equations;
                blocks.extend(pivots.iter().map(|&pivot| Block::of(Solution::Isolated(pivot))));
            }
            for &unknown in &block.assigned {
                definitions.insert(symbols.unknowns[unknown], solved.phi[unknown]);
            }
            blocks.push(block);
        }
        define_points(graph, symbols, &mut definitions);
        Self { blocks, definitions }
    }

    /// Size of the largest system that is solved.
    pub(crate) fn unknowns(&self) -> usize {
        self.blocks.iter().map(|block| block.iterates.len()).max().unwrap_or(0)
    }
}

impl StepSymbols {
    /// `P` and every `Q_l`: states shifted by increments.
    pub(crate) fn points(&self) -> Vec<Symbol> {
        self.stages.iter().flat_map(|stage| &stage.q).chain(&self.momentum).copied().collect()
    }

    /// The symbols through which an equation reads `unknown`, with `∂symbol/∂unknown`.
    pub(crate) fn views(&self, unknown: Unknown) -> Vec<(Symbol, Rational)> {
        match unknown {
            Unknown::P(i) => vec![(self.momentum[i], Rational::ONE)],
            Unknown::Q(i) => {
                let moving = self.stages.iter().filter(|stage| !stage.at.l.is_zero());
                moving.map(|stage| (stage.q[i], stage.at.l)).collect()
            }
        }
    }
}

/// `P = p_i + v`, `Q_l = q_i + l u`, `T_l = t + l h`.
fn define_points(graph: &mut Graph, symbols: &StepSymbols, definitions: &mut HashMap<Symbol, Expr>) {
    let StepSymbols { nodes, unknowns, .. } = symbols;
    for i in 0..symbols.degrees() {
        let v = graph.symbol(unknowns.p[i]);
        let momentum = graph.shifted(nodes.p[i], v, Rational::ONE);
        definitions.insert(symbols.momentum[i], momentum);
        let u = increment(graph, unknowns.q[i], definitions);
        for stage in &symbols.stages {
            let point = graph.shifted(nodes.q[i], u, stage.at.l);
            definitions.insert(stage.q[i], point);
        }
    }
    let h = graph.symbol(symbols.h);
    for stage in &symbols.stages {
        let time = graph.shifted(symbols.t, h, stage.at.l);
        definitions.insert(stage.t, time);
    }
}

/// The expression to scale and add to a state: the definition of an assigned increment if it is one product
/// (which absorbs the factor), else its symbol, so that the terms of an increment are summed before the state
/// is added.
pub(crate) fn increment(graph: &mut Graph, symbol: Symbol, definitions: &HashMap<Symbol, Expr>) -> Expr {
    let is_long = |node: &Node| match node {
        Node::Sum { terms, constant } => terms.len() > 1 || !constant.is_zero(),
        _ => false,
    };
    let short = definitions.get(&symbol).copied().filter(|&definition| !is_long(graph.node(definition)));
    short.unwrap_or_else(|| graph.symbol(symbol))
}

impl Graph {
    /// `base + l by`
    pub(crate) fn shifted(&mut self, base: Symbol, by: Expr, l: Rational) -> Expr {
        let base = self.symbol(base);
        self.linear_combination(&[(base, Rational::ONE), (by, l)])
    }

    /// Whether `expr` contains no symbols but `symbols`.
    pub(crate) fn reads_only(&self, expr: Expr, symbols: &[Symbol]) -> bool {
        self.reachable(&[expr]).iter().all(|&e| self.as_symbol(e).is_none_or(|s| symbols.contains(&s)))
    }
}

struct BlockSolver<'a> {
    graph: &'a mut Graph,
    symbols: &'a StepSymbols,
    equations: &'a Equations,
    /// `∂expr/∂symbol`, each computed once.
    slopes: HashMap<(Expr, Symbol), Expr>,
}

impl<'a> BlockSolver<'a> {
    fn new(graph: &'a mut Graph, symbols: &'a StepSymbols, equations: &'a Equations) -> Self {
        Self { graph, symbols, equations, slopes: HashMap::new() }
    }

    /// The unknowns of a component, split into iterates and assigned ones, with the solution method.
    fn block(&mut self, iterates: Vec<Unknown>, assigned: Vec<Unknown>) -> Block {
        let solution = self.solve(&iterates, &assigned);
        Block { iterates, assigned, solution }
    }

    fn solve(&mut self, iterates: &[Unknown], assigned: &[Unknown]) -> Solution {
        if iterates.is_empty() {
            return Solution::Assigned;
        }
        let columns: Vec<Vec<Expr>> = iterates.iter().map(|&x| self.column(iterates, assigned, x)).collect();
        let n = iterates.len();
        let rows = (0..n).map(|row| columns.iter().map(|column| column[row]).collect());
        let jacobian: Vec<Vec<Expr>> = rows.collect();
        let all: Vec<Unknown> = [iterates, assigned].concat();
        let members = all.iter().flat_map(|&x| self.symbols.views(x)).map(|(view, _)| view);
        let members: Vec<Symbol> = members.collect();
        if jacobian.iter().flatten().all(|&entry| !self.graph.depends_on(entry, &members))
            && all.iter().all(|&x| !self.graph.has_pieces(self.equations.phi[x], &members))
        {
            let rhs = self.at_zero(iterates, assigned);
            return Solution::Linear { matrix: jacobian, rhs };
        }
        let residual = iterates.iter().map(|&x| {
            let unknown = self.graph.symbol(self.symbols.unknowns[x]);
            self.graph.subtract(unknown, self.equations.phi[x])
        });
        let residual = residual.collect();
        let symmetric = n > 1 && (0..n).all(|i| (0..i).all(|j| jacobian[i][j] == jacobian[j][i]));
        Solution::Newton { residual, jacobian, symmetric }
    }

    /// `∂(x_a - φ_a)/∂x` for every iterate `x_a`, through the assigned unknowns.
    fn column(&mut self, iterates: &[Unknown], assigned: &[Unknown], x: Unknown) -> Vec<Expr> {
        let one = self.graph.integer(1);
        let mut speeds = vec![(x, one)];
        for &unknown in assigned {
            let speed = self.total_slope(self.equations.phi[unknown], &speeds);
            speeds.push((unknown, speed));
        }
        let entry = |&row: &Unknown| {
            let slope = self.total_slope(self.equations.phi[row], &speeds);
            let identity = if row == x { one } else { self.graph.integer(0) };
            self.graph.subtract(identity, slope)
        };
        iterates.iter().map(entry).collect()
    }

    /// `Σ_m ∂expr/∂x_m · speed_m`
    fn total_slope(&mut self, expr: Expr, speeds: &[(Unknown, Expr)]) -> Expr {
        let mut terms = Vec::new();
        for &(unknown, speed) in speeds {
            for (view, weight) in self.symbols.views(unknown) {
                let Self { graph, slopes, .. } = self;
                let slope = *slopes.entry((expr, view)).or_insert_with(|| graph.hessian_entry(expr, view));
                terms.push((self.graph.multiply(slope, speed), weight));
            }
        }
        self.graph.linear_combination(&terms)
    }

    /// `φ` of the iterates where every iterate is zero.
    fn at_zero(&mut self, iterates: &[Unknown], assigned: &[Unknown]) -> Vec<Expr> {
        let mut values: HashMap<Symbol, Expr> = HashMap::new();
        let zero = self.graph.integer(0);
        for &unknown in iterates {
            self.place(unknown, zero, &mut values);
        }
        for &unknown in assigned {
            let value = self.graph.substitute(&[self.equations.phi[unknown]], &values)[0];
            self.place(unknown, value, &mut values);
        }
        let phi: Vec<Expr> = iterates.iter().map(|&x| self.equations.phi[x]).collect();
        self.graph.substitute(&phi, &values)
    }

    fn place(&mut self, unknown: Unknown, value: Expr, values: &mut HashMap<Symbol, Expr>) {
        for (view, weight) in self.symbols.views(unknown) {
            values.insert(view, self.graph.shifted(self.symbols.nodes[unknown], value, weight));
        }
    }
}
