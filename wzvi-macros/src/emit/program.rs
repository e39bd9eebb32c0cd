//! Straight-line programs: n-ary expressions become binary operations on two types of numbers.
//!
//! Values that depend on the system, the step size and the time only are `f64`; a value that depends on the
//! state or the increments has the scalar type of the step. Every operation knows the earliest *level* at
//! which it can be computed, and sums and products are split by level, so that constant factors and terms
//! move out of the step (and of the Newton iteration).
//!
//! Tests: `tests/steps/accuracy.rs`, and the golden expansions (`compile/golden_tests.rs`).

use std::collections::HashMap;

use crate::symbolic::{Function, Junction, Relation, Symbol};

mod lower;

pub(crate) use lower::Lowering;

/// Index of an operation: operands come first.
pub(crate) type Op = usize;

/// The level at which a value is known.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) enum Level {
    /// From the system and the step size: once per stepper.
    Prepared,
    /// From the time as well: once per step, the same for every trajectory.
    Time,
    /// From the increments as well: off the critical path from state to state.
    Increments,
    /// From the state.
    State,
}

/// One operation on earlier ones.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Operation {
    /// The bits of a constant.
    Constant(u64),
    Input(Symbol),
    Add(Op, Op),
    Subtract(Op, Op),
    Multiply(Op, Op),
    Divide(Op, Op),
    Negate(Op),
    Reciprocal(Op),
    /// A power too large to be expanded into products.
    Power(Op, i32),
    Call(Function, Vec<Op>),
    Select(Op, Op, Op),
    Compare(Relation, Op, Op),
    Not(Op),
    Join(Junction, Op, Op),
}

impl Operation {
    pub(crate) fn operands(&self) -> Vec<Op> {
        match self {
            Self::Constant(_) | Self::Input(_) => Vec::new(),
            Self::Negate(a) | Self::Reciprocal(a) | Self::Power(a, _) | Self::Not(a) => vec![*a],
            Self::Add(a, b)
            | Self::Subtract(a, b)
            | Self::Multiply(a, b)
            | Self::Divide(a, b)
            | Self::Compare(_, a, b)
            | Self::Join(_, a, b) => vec![*a, *b],
            Self::Select(a, b, c) => vec![*a, *b, *c],
            Self::Call(_, arguments) => arguments.clone(),
        }
    }

    /// Whether the value is a truth, not a number.
    pub(crate) fn is_truth(&self) -> bool {
        matches!(self, Self::Compare(..) | Self::Not(_) | Self::Join(..))
    }

    /// Whether the value needs no name.
    pub(crate) fn is_trivial(&self) -> bool {
        matches!(self, Self::Constant(_) | Self::Input(_))
    }
}

/// A hash-consed list of operations.
#[derive(Default)]
pub(crate) struct Program {
    operations: Vec<Operation>,
    levels: Vec<Level>,
    known: HashMap<Operation, Op>,
    inputs: HashMap<Symbol, Level>,
}

impl Program {
    /// Declares `symbol` as an input; undeclared symbols count as state.
    pub(crate) fn declare(&mut self, symbol: Symbol, level: Level) {
        self.inputs.insert(symbol, level);
    }

    pub(crate) fn operation(&self, op: Op) -> &Operation {
        &self.operations[op]
    }

    pub(crate) fn level(&self, op: Op) -> Level {
        self.levels[op]
    }

    pub(crate) fn input(&mut self, symbol: Symbol) -> Op {
        self.push(Operation::Input(symbol))
    }

    pub(crate) fn constant(&mut self, value: f64) -> Op {
        self.push(Operation::Constant(value.to_bits()))
    }

    /// The operation with this form, if there is one.
    pub(crate) fn find(&self, operation: &Operation) -> Option<Op> {
        self.known.get(operation).copied()
    }

    fn as_constant(&self, op: Op) -> Option<f64> {
        match self.operations[op] {
            Operation::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    /// The operation, simplified if that changes no bit of its value.
    pub(crate) fn push(&mut self, operation: Operation) -> Op {
        let operation = match self.simplified(operation) {
            Ok(known) => return known,
            Err(operation) => operation,
        };
        if let Some(&known) = self.known.get(&operation) {
            return known;
        }
        let level = match &operation {
            Operation::Input(symbol) => self.inputs.get(symbol).copied().unwrap_or(Level::State),
            other => other.operands().iter().map(|&op| self.levels[op]).max().unwrap_or(Level::Prepared),
        };
        self.operations.push(operation.clone());
        self.levels.push(level);
        let op = self.operations.len() - 1;
        self.known.insert(operation, op);
        op
    }

    fn simplified(&mut self, operation: Operation) -> Result<Op, Operation> {
        let negated = |program: &Self, op: Op| match program.operations[op] {
            Operation::Negate(inner) => Some(inner),
            _ => None,
        };
        match operation {
            Operation::Add(a, b) => match (negated(self, a), negated(self, b)) {
                (_, Some(b)) => Ok(self.push(Operation::Subtract(a, b))),
                (Some(a), None) => Ok(self.push(Operation::Subtract(b, a))),
                (None, None) => Err(Operation::Add(a.min(b), a.max(b))),
            },
            Operation::Subtract(a, b) => match negated(self, b) {
                Some(b) => Ok(self.push(Operation::Add(a, b))),
                None => Err(operation),
            },
            Operation::Negate(a) => negated(self, a).ok_or(operation),
            Operation::Multiply(a, b) => {
                match (self.as_constant(a), self.as_constant(b), negated(self, a), negated(self, b)) {
                    (Some(1.0), ..) => Ok(b),
                    (_, Some(1.0), ..) => Ok(a),
                    (Some(x), Some(y), ..) => Ok(self.constant(x * y)),
                    (_, _, None, None) => Err(Operation::Multiply(a.min(b), a.max(b))),
                    (_, _, x, y) => {
                        let product = self.push(Operation::Multiply(x.unwrap_or(a), y.unwrap_or(b)));
                        let is_negative = x.is_some() != y.is_some();
                        Ok(if is_negative { self.push(Operation::Negate(product)) } else { product })
                    }
                }
            }
            Operation::Divide(a, b) if self.as_constant(a) == Some(1.0) => {
                Ok(self.push(Operation::Reciprocal(b)))
            }
            other => Err(other),
        }
    }

    /// All operations needed for `roots`, operands first.
    pub(crate) fn needed(&self, roots: &[Op], stop: &dyn Fn(Op) -> bool) -> Vec<Op> {
        let mut marked = vec![false; self.operations.len()];
        let mut pending: Vec<Op> = roots.iter().copied().filter(|&op| !stop(op)).collect();
        while let Some(op) = pending.pop() {
            if !std::mem::replace(&mut marked[op], true) {
                pending.extend(self.operations[op].operands().into_iter().filter(|&op| !stop(op)));
            }
        }
        (0..marked.len()).filter(|&op| marked[op]).collect()
    }

    /// The operations with `stop` at which the traversal from `roots` ends, in order.
    pub(crate) fn frontier(&self, roots: &[Op], stop: &dyn Fn(Op) -> bool) -> Vec<Op> {
        let inside = self.needed(roots, stop).into_iter();
        let read = inside.flat_map(|op| self.operations[op].operands()).chain(roots.iter().copied());
        let mut found: Vec<Op> = read.filter(|&op| stop(op)).collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// The number of uses of each operation as a root or as an operand for `roots`.
    pub(crate) fn uses(&self, roots: &[Op]) -> Vec<u32> {
        let mut uses = vec![0; self.operations.len()];
        for &root in roots {
            uses[root] += 1;
        }
        for op in self.needed(roots, &|_| false) {
            for operand in self.operations[op].operands() {
                uses[operand] += 1;
            }
        }
        uses
    }

    /// Estimated cost of an operation, in additions.
    pub(crate) fn price(&self, op: Op) -> usize {
        match &self.operations[op] {
            Operation::Constant(_) | Operation::Input(_) => 0,
            Operation::Divide(..) | Operation::Reciprocal(_) | Operation::Call(Function::Sqrt, _) => 5,
            Operation::Call(..) | Operation::Power(..) => 30,
            _ => 1,
        }
    }

    /// For each operation, whether it depends on any of `inputs`; each of these does.
    pub(crate) fn readers_of(&self, inputs: &[Op]) -> Vec<bool> {
        let mut reads = vec![false; self.operations.len()];
        for op in 0..self.operations.len() {
            reads[op] =
                inputs.contains(&op) || self.operations[op].operands().iter().any(|&operand| reads[operand]);
        }
        reads
    }

    pub(crate) fn is_literal(&self, op: Op) -> bool {
        matches!(self.operations[op], Operation::Constant(_))
    }
}
