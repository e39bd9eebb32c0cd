//! One lowered scheme: its operations, block by block. Tests: `tests/steps/reference.rs`,
//! `tests/steps/accuracy.rs`.

use std::collections::HashMap;

use crate::discretise::{Block, ByUnknown, Pivot, Scheme, Solution, StepSymbols, Unknown, increment};
use crate::emit::program::{Level, Lowering, Op, Program};
use crate::model::Parameter;
use crate::symbolic::{Expr, Graph, Rational, Relation, Symbol, SymbolKind};

/// Larger pivots cost a digit of the points to which they contribute.
const STIFF: i32 = 2;

/// The solution method of a block.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Method {
    /// One linear unknown whose pivot never changes: its reciprocal is an input that `prepare` computes.
    Inverted,
    /// One linear unknown whose pivot does not read the state: its reciprocal is computed once per step, off
    /// the critical path from state to state.
    Reciprocal {
        /// Whether the pivot is at least 1 wherever it is defined.
        is_safe: bool,
    },
    /// One linear unknown.
    Divided,
    /// A linear system whose matrix never changes: factored by `prepare`.
    Factored,
    Linear,
    Newton {
        symmetric: bool,
    },
}

/// A block in operations: `matrix · x = rhs`, or `rhs(x) = 0` with the Jacobian `matrix`.
pub(crate) struct Solve {
    pub(crate) method: Method,
    pub(crate) matrix: Vec<Vec<Op>>,
    /// Empty if only the reciprocal of a pivot is needed, for assigned unknowns.
    pub(crate) rhs: Vec<Op>,
    /// `x`, or the reciprocal.
    pub(crate) unknowns: Vec<Op>,
}

impl Solve {
    /// Whether the matrix is used by `prepare` only.
    pub(crate) fn is_prepared(&self) -> bool {
        matches!(self.method, Method::Inverted | Method::Factored)
    }

    pub(crate) fn entries(&self) -> Vec<Op> {
        self.matrix.concat()
    }

    /// The operations read by the step: the matrix by rows, and the right side.
    pub(crate) fn read(&self) -> Vec<Op> {
        let entries = if self.is_prepared() { Vec::new() } else { self.entries() };
        [entries.as_slice(), &self.rhs].concat()
    }
}

/// The program of one step, with the operations by role.
pub(crate) struct StepProgram {
    pub(crate) program: Program,
    pub(crate) hints: HashMap<Op, String>,
    pub(crate) parameters: Vec<Op>,
    pub(crate) h: Op,
    pub(crate) t: Op,
    /// `q_i` and `p_i`.
    pub(crate) nodes: [Vec<Op>; 2],
    pub(crate) dw: Vec<Op>,
    pub(crate) solves: Vec<Solve>,
    /// The reciprocals for isolated unknowns of Newton blocks.
    pub(crate) isolated: Vec<Op>,
    /// `q_{i+1} - q_i` and `p_{i+1} - p_i`.
    pub(crate) changes: [Vec<Op>; 2],
    /// Whether there is no noise.
    pub(crate) is_deterministic: bool,
}

impl StepProgram {
    pub(crate) fn new(
        graph: &mut Graph,
        parameters: &[Parameter],
        scheme: &Scheme,
        is_deterministic: bool,
    ) -> Self {
        let symbols = &scheme.lagrangian.symbols;
        let mut definitions = scheme.structure.definitions.clone();
        let inverses = invert_constant_pivots(graph, parameters, scheme, &mut definitions);
        let changes = changes(graph, scheme, &definitions);

        let points: Vec<Expr> =
            symbols.points().iter().filter_map(|point| definitions.get(point)).copied().collect();
        let mut lowering = Lowering::new(graph, definitions);
        for &sum in points.iter().chain(changes.iter().flatten()) {
            lowering.keep(sum);
        }
        for inverse in inverses.iter().flatten() {
            lowering.program.declare(inverse.symbol, inverse.level);
        }
        let mut inputs = |of: &[Symbol], level: Level| -> Vec<Op> {
            of.iter().map(|&symbol| lowering.input(symbol, level)).collect()
        };
        let nodes = [&symbols.nodes.q, &symbols.nodes.p].map(|nodes| inputs(nodes, Level::State));
        let dw = inputs(&symbols.dw, Level::Increments);
        let of_system: Vec<Symbol> = parameters.iter().map(|parameter| parameter.symbol).collect();
        let parameters = inputs(&of_system, Level::Prepared);
        let h = lowering.input(symbols.h, Level::Prepared);
        let t = lowering.input(symbols.t, Level::Time);

        let mut solves = Vec::new();
        for (block, inverse) in scheme.structure.blocks.iter().zip(&inverses) {
            solves.extend(lower_block(&mut lowering, scheme, block, inverse.as_ref()));
        }
        let isolated = scheme.structure.blocks.iter().filter_map(|block| match block.solution {
            Solution::Isolated(pivot) => Some(lowering.program.input(pivot.inverse)),
            _ => None,
        });
        let isolated = isolated.collect();
        let changes =
            changes.map(|changes| changes.into_iter().map(|change| lowering.lower(change)).collect());
        let hints = hints(&mut lowering, scheme, &solves);
        let program = lowering.program;
        Self { program, hints, parameters, h, t, nodes, dw, solves, isolated, changes, is_deterministic }
    }

    /// Whether compensated sums, six additions per component, cost less than 5 % of the step, with about two
    /// Newton iterations.
    pub(crate) fn affords_compensation(&self) -> bool {
        let price: usize =
            self.program.needed(&self.roots(), &|_| false).iter().map(|&op| self.program.price(op)).sum();
        let step = if self.newton_sizes().is_empty() { price } else { 2 * price };
        step > 20 * 6 * self.nodes.iter().map(Vec::len).sum::<usize>()
    }

    /// The sizes of the Newton blocks.
    pub(crate) fn newton_sizes(&self) -> Vec<usize> {
        let is_newton = |solve: &&Solve| matches!(solve.method, Method::Newton { .. });
        self.solves.iter().filter(is_newton).map(|solve| solve.unknowns.len()).collect()
    }

    /// Everything that the step computes.
    pub(crate) fn roots(&self) -> Vec<Op> {
        let ends = self.changes.iter().flatten().chain(&self.isolated).copied();
        ends.chain(self.solves.iter().flat_map(Solve::read)).collect()
    }

    /// The values of level `Prepared` that the step reads, apart from literals and the step size.
    pub(crate) fn constants(&self) -> Vec<Op> {
        let program = &self.program;
        let roots = self.roots();
        let is_constant = |op: Op| program.level(op) == Level::Prepared;
        let mut constants = program.frontier(&roots, &is_constant);
        constants.retain(|&op| op != self.h && !program.is_literal(op));
        constants
    }

    /// The values computed by `prepare`, with multiplicity.
    pub(crate) fn prepared_roots(&self, constants: &[Op]) -> Vec<Op> {
        let prepared = self.solves.iter().filter(|solve| solve.is_prepared());
        constants.iter().copied().chain(prepared.flat_map(Solve::entries)).collect()
    }
}

/// The reciprocal of a pivot that does not read the state.
#[derive(Clone, Copy)]
struct Inverse {
    pivot: Expr,
    symbol: Symbol,
    /// `Prepared`, or `Increments` for a pivot that reads the time or the increments.
    level: Level,
    /// Whether the pivot is at least 1.
    is_safe: bool,
}

/// A linear block of one unknown whose pivot does not read the state: the unknown becomes an assigned one,
/// `inverse · rhs`, and its constants merge with the others. Returns the inverses, by block.
fn invert_constant_pivots(
    graph: &mut Graph,
    parameters: &[Parameter],
    scheme: &Scheme,
    definitions: &mut HashMap<Symbol, Expr>,
) -> Vec<Option<Inverse>> {
    let symbols = &scheme.lagrangian.symbols;
    let constant: Vec<Symbol> =
        parameters.iter().map(|parameter| parameter.symbol).chain([symbols.h]).collect();
    let given: Vec<Symbol> = constant.iter().chain([&symbols.t]).chain(&symbols.dw).copied().collect();
    let of_pivot = |graph: &Graph, symbol: Symbol, pivot: Expr| {
        let is_prepared = graph.reads_only(pivot, &constant);
        let level = if is_prepared { Level::Prepared } else { Level::Increments };
        Inverse { pivot, symbol, level, is_safe: graph.exceeds_one(pivot) }
    };
    let mut inverses = Vec::new();
    for block in &scheme.structure.blocks {
        inverses.push(match (&block.solution, block.iterates.as_slice()) {
            (Solution::Linear { matrix, rhs }, &[unknown]) if graph.reads_only(matrix[0][0], &given) => {
                let pivot = matrix[0][0];
                let symbol = graph.new_symbol(SymbolKind::Auxiliary, "inverse");
                let inverse = graph.symbol(symbol);
                let value = graph.multiply(inverse, rhs[0]);
                definitions.insert(symbols.unknowns[unknown], value);
                let made = of_pivot(graph, symbol, pivot);
                if made.level == Level::Prepared {
                    solve_for_points(graph, symbols, unknown, [rhs[0], pivot, inverse], definitions);
                }
                Some(made)
            }
            (&Solution::Isolated(Pivot { value, inverse }), _) => Some(of_pivot(graph, inverse, value)),
            (Solution::Assigned | Solution::Linear { .. } | Solution::Newton { .. }, _) => None,
        });
    }
    inverses
}

/// Gives every point `base + w x` that reads the unknown `x = rhs / pivot` a second form,
/// `(w rhs + pivot base) / pivot`, for pivots above [`STIFF`]: a stiff force reverses the state within the
/// step, `w x` is nearly `-base`, and their sum would lose all digits. Only if the pivot cancels in the sum,
/// so that the sum is formed without rounding.
fn solve_for_points(
    graph: &mut Graph,
    symbols: &StepSymbols,
    unknown: Unknown,
    [rhs, pivot, inverse]: [Expr; 3],
    definitions: &mut HashMap<Symbol, Expr>,
) {
    let base = symbols.nodes[unknown];
    for (point, weight) in symbols.views(unknown) {
        let slope = graph.derivative(rhs, base);
        let share = graph.linear_combination(&[(slope, weight), (pivot, Rational::ONE)]);
        let Some(share) = graph.as_number(share) else { continue };
        let zero = graph.integer(0);
        let rest = graph.substitute(&[rhs], &HashMap::from([(base, zero)]))[0];
        let start = graph.symbol(base);
        let sum = graph.linear_combination(&[(rest, weight), (start, share)]);
        let direct = graph.multiply(inverse, sum);
        let limit = graph.integer(STIFF);
        let is_stiff = graph.compare(Relation::Less, limit, pivot);
        if let Some(shifted) = definitions.get_mut(&point) {
            *shifted = graph.select(is_stiff, direct, *shifted);
        }
    }
}

/// `q_{i+1} - q_i = u` and `p_{i+1} - p_i`. The increments stay separate from the state, for compensated
/// summation.
fn changes(graph: &mut Graph, scheme: &Scheme, definitions: &HashMap<Symbol, Expr>) -> [Vec<Expr>; 2] {
    let ByUnknown { q: u, p: v } = &scheme.lagrangian.symbols.unknowns;
    let [u, mut v] =
        [u, v].map(|of| of.iter().map(|&unknown| increment(graph, unknown, definitions)).collect::<Vec<_>>());
    v.iter_mut().zip(&scheme.equations.update).for_each(|(v, update)| *v = update.change(graph, *v));
    [u, v]
}

fn lower_block(
    lowering: &mut Lowering<'_>,
    scheme: &Scheme,
    block: &Block,
    inverse: Option<&Inverse>,
) -> Option<Solve> {
    let all = |lowering: &mut Lowering<'_>, of: &[Expr]| -> Vec<Op> {
        of.iter().map(|&value| lowering.lower(value)).collect()
    };
    let by_rows = |lowering: &mut Lowering<'_>, rows: &[Vec<Expr>]| -> Vec<Vec<Op>> {
        rows.iter().map(|row| all(lowering, row)).collect()
    };
    let inputs = |lowering: &mut Lowering<'_>| -> Vec<Op> {
        let symbols = block.iterates.iter().map(|&x| scheme.lagrangian.symbols.unknowns[x]);
        symbols.map(|symbol| lowering.program.input(symbol)).collect()
    };
    match (&block.solution, inverse) {
        (_, Some(inverse)) => Some(reciprocal(lowering, inverse)),
        (Solution::Assigned | Solution::Isolated(_), None) => None,
        (Solution::Linear { matrix, rhs }, None) => {
            let (matrix, rhs) = (by_rows(lowering, matrix), all(lowering, rhs));
            let is_prepared = |&entry: &Op| lowering.program.level(entry) == Level::Prepared;
            let method = match matrix.iter().flatten().all(is_prepared) {
                _ if rhs.len() == 1 => Method::Divided,
                true => Method::Factored,
                false => Method::Linear,
            };
            Some(Solve { method, matrix, rhs, unknowns: inputs(lowering) })
        }
        (Solution::Newton { residual, jacobian, symmetric }, None) => {
            let (method, unknowns) = (Method::Newton { symmetric: *symmetric }, inputs(lowering));
            let (rhs, matrix) = (all(lowering, residual), by_rows(lowering, jacobian));
            Some(Solve { method, matrix, rhs, unknowns })
        }
    }
}

fn reciprocal(lowering: &mut Lowering<'_>, inverse: &Inverse) -> Solve {
    let Inverse { pivot, symbol, level, is_safe } = *inverse;
    let method = if level == Level::Prepared { Method::Inverted } else { Method::Reciprocal { is_safe } };
    let matrix = vec![vec![lowering.lower(pivot)]];
    Solve { method, matrix, rhs: Vec::new(), unknowns: vec![lowering.program.input(symbol)] }
}

/// Names from the formulas.
fn hints(lowering: &mut Lowering<'_>, scheme: &Scheme, solves: &[Solve]) -> HashMap<Op, String> {
    let symbols = &scheme.lagrangian.symbols;
    let mut named: Vec<(Symbol, String)> = Vec::new();
    let ByUnknown { q: u, p: v } = &symbols.unknowns;
    for i in 0..symbols.degrees() {
        let [q, p] = [u[i], v[i]].map(|increment| {
            lowering.graph().symbol_name(increment).trim_start_matches(['Δ', 'δ']).to_owned()
        });
        named.push((symbols.momentum[i], format!("node_{p}")));
        named.push((u[i], format!("delta_{q}")));
        named.push((v[i], format!("delta_{p}")));
        for (stage, point) in symbols.stages.iter().enumerate() {
            named.push((point.q[i], if stage == 0 { format!("stage_{q}") } else { format!("noise_{q}") }));
        }
    }
    let mut hints = HashMap::new();
    for (symbol, name) in named {
        let expr = lowering.graph().symbol(symbol);
        let op = lowering.lower(expr);
        if !hints.values().any(|known| *known == name) {
            hints.entry(op).or_insert(name);
        }
    }
    for solve in solves {
        if matches!(solve.method, Method::Inverted | Method::Reciprocal { .. }) {
            hints.entry(solve.unknowns[0]).or_insert_with(|| "inverse_pivot".to_owned());
        }
    }
    hints
}
