//! One scheme lowered: its operations, block by block, before they become tokens.

use std::collections::HashMap;

use crate::discretise::{Block, Pivot, Scheme, Solution, StepSymbols, Unknown, increment};
use crate::emit::program::{Level, Lowering, Op, Program};
use crate::model::Parameter;
use crate::symbolic::{Expr, Graph, Rational, Relation, Symbol};

/// Pivots above this lose a digit of the points to which they contribute.
const STIFF: i32 = 2;

/// How a block is solved, in operations.
pub(crate) enum Solve {
    /// One linear unknown whose pivot never changes: its reciprocal is an input that `prepare` computes.
    Inverted {
        pivot: Op,
        inverse: Op,
    },
    /// One linear unknown whose pivot does not read the state: its reciprocal is computed once per step, off the path
    /// from one state to the next.
    Reciprocal {
        pivot: Op,
        inverse: Op,
        /// At least 1 wherever it is defined.
        is_safe: bool,
    },
    /// One linear unknown.
    Divided {
        pivot: Op,
        rhs: Op,
        unknown: Op,
    },
    /// A linear system whose matrix never changes: factored by `prepare`.
    Factored {
        matrix: Vec<Vec<Op>>,
        rhs: Vec<Op>,
        unknowns: Vec<Op>,
    },
    Linear {
        matrix: Vec<Vec<Op>>,
        rhs: Vec<Op>,
        unknowns: Vec<Op>,
    },
    Newton {
        residual: Vec<Op>,
        jacobian: Vec<Vec<Op>>,
        unknowns: Vec<Op>,
        symmetric: bool,
    },
}

/// The program of one step with the operations that have a role.
pub(crate) struct Flow {
    pub(crate) program: Program,
    pub(crate) hints: HashMap<Op, String>,
    pub(crate) parameters: Vec<Op>,
    pub(crate) h: Op,
    pub(crate) t: Op,
    pub(crate) q0: Vec<Op>,
    pub(crate) p0: Vec<Op>,
    pub(crate) dw: Vec<Op>,
    pub(crate) solves: Vec<Solve>,
    /// The reciprocals that isolated unknowns of Newton blocks are assigned with.
    pub(crate) isolated: Vec<Op>,
    pub(crate) dq: Vec<Op>,
    pub(crate) dp: Vec<Op>,
    /// Whether there is no noise.
    pub(crate) is_deterministic: bool,
}

impl Flow {
    pub(crate) fn new(
        graph: &mut Graph,
        parameters: &[Parameter],
        scheme: &Scheme,
        is_deterministic: bool,
    ) -> Self {
        let symbols = &scheme.lagrangian.symbols;
        let mut definitions = scheme.structure.definitions.clone();
        let inverses = invert_constant_pivots(graph, parameters, scheme, &mut definitions);
        let ends = ends(graph, scheme, &definitions);

        let points: Vec<Expr> =
            symbols.points().iter().filter_map(|point| definitions.get(point)).copied().collect();
        let mut lowering = Lowering::new(graph, definitions);
        for &sum in points.iter().chain(ends.iter().flatten()) {
            lowering.keep(sum);
        }
        for inverse in inverses.iter().flatten() {
            lowering.program.declare(inverse.symbol, inverse.level);
        }
        let mut inputs = |of: &[Symbol], level: Level| -> Vec<Op> {
            of.iter().map(|&symbol| lowering.input(symbol, level)).collect()
        };
        let (q0, p0) = (inputs(&symbols.q0, Level::State), inputs(&symbols.p0, Level::State));
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
        let [dq, dp] = ends.map(|ends| ends.into_iter().map(|end| lowering.lower(end)).collect());
        let hints = hints(&mut lowering, scheme, &solves);
        let program = lowering.program;
        Self { program, hints, parameters, h, t, q0, p0, dw, solves, isolated, dq, dp, is_deterministic }
    }

    /// Whether compensated sums, six additions per component, are less than 5 % of the step; a Newton step iterates
    /// about twice.
    pub(crate) fn affords_compensation(&self) -> bool {
        let price: usize =
            self.program.needed(&self.roots(), &|_| false).iter().map(|&op| self.program.price(op)).sum();
        let has_newton = self.solves.iter().any(|solve| matches!(solve, Solve::Newton { .. }));
        let step = if has_newton { 2 * price } else { price };
        step > 20 * 6 * 2 * self.q0.len()
    }

    /// Sizes of the Newton blocks.
    pub(crate) fn newton_sizes(&self) -> Vec<usize> {
        let sizes = self.solves.iter().filter_map(|solve| match solve {
            Solve::Newton { unknowns, .. } => Some(unknowns.len()),
            _ => None,
        });
        sizes.collect()
    }

    /// Everything that the step computes.
    pub(crate) fn roots(&self) -> Vec<Op> {
        let ends = self.dq.iter().chain(&self.dp);
        let mut roots: Vec<Op> = ends.chain(&self.isolated).copied().collect();
        for solve in &self.solves {
            match solve {
                Solve::Inverted { .. } => {}
                Solve::Reciprocal { pivot, .. } => roots.push(*pivot),
                Solve::Divided { pivot, rhs, .. } => roots.extend([*pivot, *rhs]),
                Solve::Factored { rhs, .. } => roots.extend(rhs),
                Solve::Linear { matrix, rhs, .. } => roots.extend(matrix.iter().flatten().chain(rhs)),
                Solve::Newton { residual, jacobian, .. } => {
                    roots.extend(residual.iter().chain(jacobian.iter().flatten()));
                }
            }
        }
        roots
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

    /// What `prepare` computes, with multiplicity.
    pub(crate) fn prepared_roots(&self, constants: &[Op]) -> Vec<Op> {
        let mut roots = constants.to_vec();
        for solve in &self.solves {
            match solve {
                Solve::Inverted { pivot, .. } => roots.push(*pivot),
                Solve::Factored { matrix, .. } => roots.extend(matrix.iter().flatten()),
                _ => {}
            }
        }
        roots
    }
}

/// The reciprocal of a pivot that does not read the state.
#[derive(Clone, Copy)]
struct Inverse {
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
    let mut inverses = Vec::new();
    for block in &scheme.structure.blocks {
        let inverse = match (&block.solution, block.iterates.as_slice()) {
            (Solution::Linear { matrix, rhs }, &[unknown]) if graph.reads_only(matrix[0][0], &given) => {
                let pivot = matrix[0][0];
                let symbol = graph.new_symbol("inverse");
                let factor = graph.symbol(symbol);
                let value = graph.multiply(factor, rhs[0]);
                definitions.insert(symbols.unknown(unknown), value);
                let is_prepared = graph.reads_only(pivot, &constant);
                if is_prepared {
                    solve_for_points(
                        graph,
                        symbols,
                        unknown,
                        &Quotient { rhs: rhs[0], pivot, inverse: factor },
                        definitions,
                    );
                }
                let level = if is_prepared { Level::Prepared } else { Level::Increments };
                Some(Inverse { symbol, level, is_safe: graph.exceeds_one(pivot) })
            }
            (&Solution::Isolated(Pivot { value, inverse }), _) => {
                let is_prepared = graph.reads_only(value, &constant);
                let level = if is_prepared { Level::Prepared } else { Level::Increments };
                Some(Inverse { symbol: inverse, level, is_safe: graph.exceeds_one(value) })
            }
            _ => None,
        };
        inverses.push(inverse);
    }
    inverses
}

/// `rhs / pivot`
struct Quotient {
    rhs: Expr,
    pivot: Expr,
    inverse: Expr,
}

/// Gives every point `base + w x` that reads the unknown `x = rhs / pivot` a second form, `(w rhs + pivot base) / pivot`,
/// for pivots above [`STIFF`]: a stiff force turns the state back within the step, `w x` is nearly `-base`, and their sum
/// would have no digits left. Only where the pivot cancels in the sum, so that it is made without rounding.
fn solve_for_points(
    graph: &mut Graph,
    symbols: &StepSymbols,
    unknown: Unknown,
    Quotient { rhs, pivot, inverse }: &Quotient,
    definitions: &mut HashMap<Symbol, Expr>,
) {
    let base = symbols.base(unknown);
    for (point, weight) in symbols.views(unknown) {
        let slope = graph.derivative(*rhs, base);
        let share = graph.linear_combination(&[(slope, weight), (*pivot, Rational::ONE)]);
        let Some(share) = graph.as_number(share) else { continue };
        let zero = graph.integer(0);
        let rest = graph.substitute(&[*rhs], &HashMap::from([(base, zero)]))[0];
        let start = graph.symbol(base);
        let sum = graph.linear_combination(&[(rest, weight), (start, share)]);
        let direct = graph.multiply(*inverse, sum);
        let limit = graph.integer(STIFF);
        let is_stiff = graph.compare(Relation::Less, limit, *pivot);
        if let Some(shifted) = definitions.get_mut(&point) {
            *shifted = graph.select(is_stiff, direct, *shifted);
        }
    }
}

/// `q_{i+1} - q_i = u` and `p_{i+1} - p_i`. The increments stay apart from the state: whoever adds them may keep
/// what rounding takes.
fn ends(graph: &mut Graph, scheme: &Scheme, definitions: &HashMap<Symbol, Expr>) -> [Vec<Expr>; 2] {
    let symbols = &scheme.lagrangian.symbols;
    let mut ends = [Vec::new(), Vec::new()];
    for i in 0..symbols.u.len() {
        ends[0].push(increment(graph, symbols.u[i], definitions));
        let v = increment(graph, symbols.v[i], definitions);
        ends[1].push(scheme.equations.update[i].change(graph, v));
    }
    ends
}

fn lower_block(
    lowering: &mut Lowering<'_>,
    scheme: &Scheme,
    block: &Block,
    inverse: Option<&Inverse>,
) -> Option<Solve> {
    let symbols = &scheme.lagrangian.symbols;
    let lower_rows = |lowering: &mut Lowering<'_>, rows: &[Vec<Expr>]| -> Vec<Vec<Op>> {
        rows.iter().map(|row| row.iter().map(|&entry| lowering.lower(entry)).collect()).collect()
    };
    match &block.solution {
        Solution::Assigned => None,
        Solution::Isolated(pivot) => inverse.map(|inverse| {
            let pivot = lowering.lower(pivot.value);
            reciprocal(lowering, pivot, inverse)
        }),
        Solution::Linear { matrix, rhs } => {
            let matrix = lower_rows(lowering, matrix);
            if let Some(inverse) = inverse {
                return Some(reciprocal(lowering, matrix[0][0], inverse));
            }
            let rhs: Vec<Op> = rhs.iter().map(|&value| lowering.lower(value)).collect();
            let unknowns: Vec<Op> =
                block.iterates.iter().map(|&x| lowering.program.input(symbols.unknown(x))).collect();
            let is_constant =
                matrix.iter().flatten().all(|&entry| lowering.program.level(entry) == Level::Prepared);
            Some(match (is_constant, unknowns.as_slice()) {
                (_, &[unknown]) => Solve::Divided { pivot: matrix[0][0], rhs: rhs[0], unknown },
                (true, _) => Solve::Factored { matrix, rhs, unknowns },
                (false, _) => Solve::Linear { matrix, rhs, unknowns },
            })
        }
        Solution::Newton { residual, jacobian, symmetric } => {
            let unknowns =
                block.iterates.iter().map(|&x| lowering.program.input(symbols.unknown(x))).collect();
            let residual = residual.iter().map(|&value| lowering.lower(value)).collect();
            let jacobian = lower_rows(lowering, jacobian);
            Some(Solve::Newton { residual, jacobian, unknowns, symmetric: *symmetric })
        }
    }
}

fn reciprocal(lowering: &mut Lowering<'_>, pivot: Op, inverse: &Inverse) -> Solve {
    let Inverse { symbol, level, is_safe } = *inverse;
    let inverse = lowering.program.input(symbol);
    match level {
        Level::Prepared => Solve::Inverted { pivot, inverse },
        _ => Solve::Reciprocal { pivot, inverse, is_safe },
    }
}

/// Names for what a reader knows from the formulas.
fn hints(lowering: &mut Lowering<'_>, scheme: &Scheme, solves: &[Solve]) -> HashMap<Op, String> {
    let symbols = &scheme.lagrangian.symbols;
    let mut named: Vec<(Symbol, String)> = Vec::new();
    for i in 0..symbols.u.len() {
        let [q, p] = [symbols.u[i], symbols.v[i]].map(|increment| {
            lowering.graph().symbol_name(increment).trim_start_matches(['Δ', 'δ']).to_owned()
        });
        named.push((symbols.momentum[i], format!("node_{p}")));
        named.push((symbols.u[i], format!("delta_{q}")));
        named.push((symbols.v[i], format!("delta_{p}")));
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
        if let Solve::Inverted { inverse, .. } | Solve::Reciprocal { inverse, .. } = solve {
            hints.entry(*inverse).or_insert_with(|| "inverse_pivot".to_owned());
        }
    }
    hints
}
