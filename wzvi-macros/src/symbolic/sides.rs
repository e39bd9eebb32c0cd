//! Values of an expression on both sides of a surface, close to it.
//!
//! Random lines that cross the surface `edge = 0` are halved until the crossing is known to rounding. There
//! the expression is evaluated at `s ± δ` for three `δ`, each 2⁸ times smaller than the one before, with
//! rounding bounds. A difference that stays the same while `δ` falls is a jump. Values that grow on both
//! sides belong to a pole.
//!
//! Tests: `discretise/branches.rs`.

use std::collections::HashSet;

use super::evaluate::{Bounded, power};
use super::residue::SplitMix;
use super::zero::coordinate;
use super::{Expr, Function, Graph, Junction, Node, Symbol, Witness};

/// The behaviour of a function on both sides of a surface.
#[derive(Clone, PartialEq, Debug)]
pub(crate) enum Sides {
    /// The values differ by this much at this point.
    Jump(Witness),
    /// The values grow without bound on both sides.
    Pole,
    /// Neither.
    Alike,
}

/// A function that changes its sign at a surface.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Edge {
    Zero(Expr),
    /// `cos(angle) = 0`, where `tan(angle)` is infinite.
    PoleOfTangent(Expr),
}

/// Distances from the surface, as shares of the line.
const DISTANCES: [f64; 3] = [1.0 / 65_536.0, 1.0 / 16_777_216.0, 1.0 / 4_294_967_296.0];
/// Halvings of a line: all that the numbers have.
const HALVINGS: usize = 52;
const LINES: usize = 40;
/// The most node evaluations, and the crossings after which no more lines are tried.
const WORK: usize = 400_000;
const FEWEST_LINES: usize = 6;
const ENOUGH: usize = 6;

/// The relative error of a value whose error has no bound.
const UNBOUNDED: f64 = 1e-8;

/// The value of a node in binary64; conditions are 1 or 0.
fn evaluate_plain(node: &Node, values: &dyn Fn(Symbol) -> f64, value: &dyn Fn(Expr) -> f64) -> f64 {
    let truth = |holds: bool| f64::from(u8::from(holds));
    match node {
        Node::Number(number) => number.to_f64(),
        Node::Float(bits) => f64::from_bits(*bits),
        Node::Symbol(symbol) => values(*symbol),
        Node::Sum { terms, constant } => {
            terms.iter().fold(constant.to_f64(), |sum, &(term, factor)| sum + factor.to_f64() * value(term))
        }
        Node::Product(factors) => {
            factors.iter().fold(1.0, |product, &(base, exponent)| product * power(value(base), exponent))
        }
        Node::Apply(function, arguments) => {
            let arguments: Vec<f64> = arguments.iter().map(|&argument| value(argument)).collect();
            function.evaluate(&arguments)
        }
        Node::Select { condition, then, otherwise } => {
            value(if value(*condition) == 0.0 { *otherwise } else { *then })
        }
        Node::Compare(relation, a, b) => truth(relation.holds(&value(*a), &value(*b))),
        Node::Not(a) => 1.0 - value(*a),
        Node::Join(Junction::And, a, b) => value(*a).min(value(*b)),
        Node::Join(Junction::Or, a, b) => value(*a).max(value(*b)),
    }
}

impl Graph {
    /// The behaviour of `value` on both sides of a surface that `moving` variables can cross; `None` if no
    /// line was found to cross it.
    pub(crate) fn sides(&self, value: Expr, edge: Edge, moving: &[Symbol]) -> Option<Sides> {
        let (Edge::Zero(of_edge) | Edge::PoleOfTangent(of_edge)) = edge;
        let parts = self.reachable(&[value, of_edge]);
        let lines = (WORK / (HALVINGS * parts.len())).clamp(FEWEST_LINES, LINES);
        let mut symbols: Vec<Symbol> = parts.into_iter().filter_map(|part| self.as_symbol(part)).collect();
        symbols.sort_unstable();
        let (mut random, mut found, mut crossings) = (SplitMix::new(0x51de), None, 0);
        for trial in 0..lines {
            let line: Vec<(Symbol, [f64; 2])> = symbols
                .iter()
                .enumerate()
                .map(|(i, &symbol)| {
                    let start = coordinate(trial, i, &mut random);
                    let end = if moving.contains(&symbol) { 6.0 * random.unit() - 3.0 } else { start };
                    (symbol, [start, end])
                })
                .collect();
            let Some(sides) = self.sides_on(value, edge, &line) else { continue };
            crossings += 1;
            match (sides, &found) {
                (Sides::Jump(witness), _) => return Some(Sides::Jump(witness)),
                (Sides::Pole, Some(_)) => {}
                (sides, _) => found = Some(sides),
            }
            if crossings == ENOUGH {
                break;
            }
        }
        found
    }

    /// The behaviour on one line; `None` if the line does not cross the surface, or `value` is undefined on
    /// one side.
    fn sides_on(&self, value: Expr, edge: Edge, line: &[(Symbol, [f64; 2])]) -> Option<Sides> {
        let at = |expr: Expr, share: f64| {
            let coordinate = |symbol: Symbol| {
                let known = line.binary_search_by_key(&symbol, |(known, _)| *known);
                known.map_or(f64::NAN, |i| line[i].1[0] + share * (line[i].1[1] - line[i].1[0]))
            };
            let found = self.evaluate_bounded(&[expr], &coordinate)[0];
            if found.is_defined() {
                return Some(found);
            }
            // If a part overflows there is no bound, and may be a value: exp(-1/q²), 1/(1 + exp(1/q)).
            let value =
                self.fold(&[expr], f64::NAN, |_, node, value| evaluate_plain(node, &coordinate, value))[0];
            (!value.is_nan()).then_some(Bounded { value, error: UNBOUNDED * value.abs() })
        };
        let is_above = |share: f64| match edge {
            Edge::Zero(edge) => at(edge, share).map(|found| found.value > 0.0),
            Edge::PoleOfTangent(angle) => at(angle, share).map(|found| found.value.cos() > 0.0),
        };
        let (mut low, mut high, is_first_above) = (0.0, 1.0, is_above(0.0)?);
        if is_above(1.0)? == is_first_above {
            return None;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if is_above(middle)? == is_first_above {
                low = middle;
            } else {
                high = middle;
            }
        }
        let mut pairs = [[0.0; 2]; DISTANCES.len()];
        let mut rounding = 0.0;
        for (pair, distance) in pairs.iter_mut().zip(DISTANCES) {
            let [before, after] = [at(value, low - distance)?, at(value, high + distance)?];
            *pair = [before.value, after.value];
            rounding = before.error + after.error;
        }
        let [wide, middle, close] = pairs.map(|[before, after]| after - before);
        let is_steady =
            (close - middle).abs() <= 0.01 * close.abs() && (middle - wide).abs() <= 0.05 * middle.abs();
        if is_steady && close.abs() > 4.0 * rounding {
            let point = line.iter().map(|&(symbol, [start, end])| (symbol, start + high * (end - start)));
            return Some(Sides::Jump(Witness { point: point.collect(), value: close }));
        }
        let grows = |side: usize| {
            let grows = |[near, far]: [f64; 2]| near.is_infinite() || near.abs() > 1.02 * far.abs();
            pairs.windows(2).all(|pairs| grows([pairs[1][side], pairs[0][side]]))
        };
        Some(if grows(0) && grows(1) { Sides::Pole } else { Sides::Alike })
    }

    /// The surfaces on which a nonnegative or changing `base` is zero, as functions that change their sign
    /// there. A sum of nonnegative terms is zero where all its terms are. Without a surface common to all
    /// terms, this set has fewer dimensions, and no motion crosses it.
    pub(crate) fn surfaces_of_zero(&self, base: Expr) -> Vec<Expr> {
        let all = |operands: &mut dyn Iterator<Item = Expr>| {
            let mut found: Vec<Expr> = operands.flat_map(|operand| self.surfaces_of_zero(operand)).collect();
            found.sort_unstable();
            found.dedup();
            found
        };
        let common = |operands: &mut dyn Iterator<Item = Expr>| {
            let lists = operands
                .filter(|&operand| !self.is_zero(operand))
                .map(|operand| self.surfaces_of_zero(operand));
            lists
                .reduce(|kept, other| kept.into_iter().filter(|known| other.contains(known)).collect())
                .unwrap_or_default()
        };
        match self.node(base) {
            Node::Number(_) | Node::Float(_) => Vec::new(),
            Node::Product(factors) => all(&mut factors
                .iter()
                .filter(|(_, exponent)| !exponent.is_negative())
                .map(|&(base, _)| base)),
            Node::Sum { terms, constant } if terms.len() == 1 && constant.is_zero() => {
                self.surfaces_of_zero(terms[0].0)
            }
            Node::Sum { terms, .. } if self.sign(base) == super::sign::Sign::Nonnegative => {
                common(&mut terms.iter().map(|&(term, _)| term))
            }
            Node::Apply(Function::Abs | Function::Sqrt | Function::Cbrt | Function::Powf, arguments) => {
                self.surfaces_of_zero(arguments[0])
            }
            Node::Apply(Function::Hypot, arguments) => common(&mut arguments.iter().copied()),
            _ => vec![base],
        }
    }

    /// Whether `value` is a rational function of `part`, which is built from analytic functions: then it has
    /// no finite jump where `part` has a pole.
    pub(crate) fn is_meromorphic_in(&self, value: Expr, part: Expr) -> bool {
        let is_analytic = |&inner: &Expr| match self.node(inner) {
            Node::Select { .. } | Node::Compare(..) | Node::Not(_) | Node::Join(..) => false,
            Node::Product(factors) => factors.iter().all(|(_, exponent)| exponent.is_integer()),
            Node::Apply(function, _) => !matches!(
                function,
                Function::Abs
                    | Function::Signum
                    | Function::Min
                    | Function::Max
                    | Function::Sqrt
                    | Function::Cbrt
                    | Function::Hypot
                    | Function::Powf
                    | Function::Atan2
            ),
            _ => true,
        };
        if !self.reachable(&[part]).iter().all(is_analytic) {
            return false;
        }
        let parts = self.reachable(&[value]);
        let mut inside = HashSet::from([part]);
        for outer in parts {
            let node = self.node(outer);
            let mut has_part = false;
            node.for_each_operand(|operand| has_part |= inside.contains(&operand));
            if outer == part || !has_part {
                continue;
            }
            let is_rational = match node {
                Node::Sum { .. } => true,
                Node::Product(factors) => {
                    factors.iter().all(|(base, exponent)| exponent.is_integer() || !inside.contains(base))
                }
                _ => false,
            };
            if !is_rational {
                return false;
            }
            inside.insert(outer);
        }
        true
    }
}
