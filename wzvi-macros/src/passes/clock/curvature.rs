//! The clock from the second derivatives of the drift,
//!
//! ```text
//! Q = (tr((H_pp H_qq)²) + w0⁴)^(-1/4)
//! ```
//!
//! For `H = p · M⁻¹ p/2 + V(q)` the trace is the square of the Frobenius norm of `M^(-1/2) V'' M^(-1/2)`: `Q`
//! is the inverse of a frequency, it follows scalings of all units, and does not depend on the choice of
//! linear coordinates. It is infinite where `V'' = 0`, unless a frequency `w0` is added.
//!
//! Distances `r = √s` are variables of their own, with `∂r/∂x = (∂s/∂x)/(2 r)`: so equal powers of a distance
//! are one term. A potential `U(r)` with one mass has, in `d` dimensions, `tr = ((d - 1) (U'/r)² + U''²)/m²`.

use std::collections::HashMap;

use super::distances::{DistanceVariable, Distances};
use super::{Derived, lines, powers, root};
use crate::diagnostics::{Extent, facts as messages};
use crate::model::{StraightLine, System, Term, Variables as _};
use crate::passes::unroll::placed;
use crate::symbolic::{Expr, Graph, Node, Rational, Symbol, ZeroTest};

/// The most degrees of freedom. The trace has a term for each pair of them, and the rate has one for each
/// triple. For eight bodies in space an expansion takes 3 s and 6 s more of an optimised build.
const MOST_DEGREES: usize = 24;

/// The clock with the frequency that is the value of `term`, if it has one.
pub(super) fn derive(system: &mut System, term: &Term) -> syn::Result<Derived> {
    let extent = term.extent;
    let frequency = match term.values.as_slice() {
        [] => None,
        [only] if only.loops.is_empty() => Some(only.value),
        _ => return Err(messages::frequency_in_loops(extent)),
    };
    let degrees = system.symbols.phase()[0].len();
    let line = if (1..=MOST_DEGREES).contains(&degrees) { placed(system) } else { None };
    let Some(line) = line else { return Err(messages::curvature_of_many(extent, MOST_DEGREES)) };
    let moving: Vec<Symbol> = line.phase.q.iter().chain(&line.phase.p).copied().collect();
    let distances = Distances::of(system, &[line.drift], &moving);
    let graph = &mut system.graph;
    let energy = distances.within(graph, line.drift);
    let mut motion = Motion { graph, distances, energy };
    let trace = motion.trace(&line);
    let zero = motion.distances.written(motion.graph, trace);
    if motion.graph.test_zero(zero) == ZeroTest::Zero {
        return Err(messages::curvature_of_linear(extent));
    }
    let trace = match frequency {
        None => {
            motion.refuse_zeros(extent, &line)?;
            trace
        }
        Some(frequency) => {
            let fourth = motion.graph.power(frequency, Rational::integer(4));
            motion.graph.add(trace, fourth)
        }
    };
    let quarter = Rational::QUARTER.negate();
    let q = root(motion.graph, trace, quarter);
    let rate = motion.log_rate(q, &line);
    let mut text = lines(&motion.graph.display(q), &motion.graph.display(rate));
    text.push_str(&motion.distances.lines(motion.graph));
    let [q, rate] = [q, rate].map(|expr| motion.distances.written(motion.graph, expr));
    let element = |value: Expr| system.symbols.element_in(&system.graph, Vec::new(), value);
    let (values, rate) = (vec![element(q)], vec![element(rate)]);
    let elements = if system.is_extended() { values.clone() } else { Vec::new() };
    let rate = rate.into_iter().filter(|element| !system.graph.is_zero(element.value)).collect();
    Ok(Derived { values, elements, rate, text: Some(text) })
}

/// The drift in distances.
struct Motion<'g> {
    graph: &'g mut Graph,
    distances: Distances,
    energy: Expr,
}

impl Motion<'_> {
    /// `∂r/∂x`
    fn slope_of_distance(&mut self, distance: DistanceVariable, x: Symbol) -> Expr {
        let slope = self.graph.derivative(distance.square, x);
        let half = halved(self.graph, slope);
        let r = self.graph.symbol(distance.symbol);
        self.graph.divide(half, r)
    }

    /// `∂f/∂x` with that of the distances.
    fn slope(&mut self, of: Expr, x: Symbol) -> Expr {
        let mut terms = vec![self.graph.derivative(of, x)];
        for distance in self.distances.all.clone() {
            let by_distance = self.graph.derivative(of, distance.symbol);
            let inner = self.slope_of_distance(distance, x);
            terms.push(self.graph.multiply(by_distance, inner));
        }
        self.graph.sum(&terms)
    }

    /// The second derivatives of the drift by two variables each.
    fn second(&mut self, of: &[Symbol]) -> Vec<Vec<Expr>> {
        let slopes: Vec<Expr> = of.iter().map(|&x| self.slope(self.energy, x)).collect();
        let mut entries = vec![vec![self.graph.integer(0); of.len()]; of.len()];
        for i in 0..of.len() {
            for j in i..of.len() {
                let entry = self.slope(slopes[i], of[j]);
                (entries[i][j], entries[j][i]) = (entry, entry);
            }
        }
        entries
    }

    /// `tr((H_pp H_qq)²)`
    fn trace(&mut self, line: &StraightLine) -> Expr {
        let masses = self.second(&line.phase.p);
        if let Some(trace) = self.radial_trace(line, &masses) {
            return trace;
        }
        let curvatures = self.second(&line.phase.q);
        let degrees = curvatures.len();
        let is_diagonal =
            (0..degrees).all(|i| (0..degrees).all(|j| i == j || self.graph.is_zero(masses[i][j])));
        let two = Rational::integer(2);
        let mut terms: Vec<(Expr, Rational)> = Vec::new();
        if is_diagonal {
            for i in 0..degrees {
                for j in i..degrees {
                    let square = self.graph.power(curvatures[i][j], two);
                    let term = self.graph.product(&[masses[i][i], masses[j][j], square]);
                    terms.push((term, if i == j { Rational::ONE } else { two }));
                }
            }
            return self.graph.linear_combination(&terms);
        }
        let mut product = vec![vec![self.graph.integer(0); degrees]; degrees];
        for (i, row) in product.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                let factors = (0..degrees).map(|k| (masses[i][k], curvatures[k][j]));
                let factors: Vec<Expr> = factors.map(|(a, b)| self.graph.multiply(a, b)).collect();
                *entry = self.graph.sum(&factors);
            }
        }
        for (i, row) in product.iter().enumerate() {
            for (j, column) in product.iter().enumerate() {
                terms.push((self.graph.multiply(row[j], column[i]), Rational::ONE));
            }
        }
        self.graph.linear_combination(&terms)
    }

    /// The trace for a potential of one distance with one mass, if the drift is such.
    fn radial_trace(&mut self, line: &StraightLine, masses: &[Vec<Expr>]) -> Option<Expr> {
        let &[distance] = self.distances.all.as_slice() else { return None };
        let q = &line.phase.q;
        for (i, &x) in q.iter().enumerate() {
            let slope = self.graph.derivative(self.energy, x);
            let mut others = q[i..].iter().chain([&distance.symbol]);
            if others.any(|&y| {
                let mixed = self.graph.derivative(slope, y);
                !self.graph.is_zero(mixed)
            }) {
                return None;
            }
        }
        let two = Rational::integer(2);
        let mut own: Vec<usize> = Vec::new();
        let mut squares: Vec<(Expr, Rational)> = vec![(distance.square, Rational::ONE)];
        for (i, &x) in q.iter().enumerate() {
            let slope = self.graph.derivative(distance.square, x);
            if self.graph.is_zero(slope) {
                continue;
            }
            for (j, &y) in q.iter().enumerate() {
                let entry = self.graph.derivative(slope, y);
                let expected = if i == j { two } else { Rational::ZERO };
                if self.graph.as_number(entry) != Some(expected) {
                    return None;
                }
            }
            let half = self.graph.scale(slope, Rational::HALF);
            squares.push((self.graph.power(half, two), Rational::MINUS_ONE));
            own.push(i);
        }
        let mass = masses[*own.first()?][own[0]];
        let is_one_mass = own.iter().all(|&i| {
            own.iter().all(|&j| match i == j {
                true => masses[i][j] == mass,
                false => self.graph.is_zero(masses[i][j]),
            })
        });
        if !is_one_mass {
            return None;
        }
        let r = self.graph.symbol(distance.symbol);
        let first = self.graph.derivative(self.energy, distance.symbol);
        let second = self.graph.derivative(first, distance.symbol);
        let across = self.graph.divide(first, r);
        let dimensions = Rational::integer(i32::try_from(own.len()).ok()?);
        let square = |graph: &mut Graph, x: Expr| graph.power(x, two);
        // `r² = x · x + softening`, of which `x · x` is the share `along`.
        let softening = self.graph.linear_combination(&squares);
        let trace = if self.graph.is_zero(softening) {
            let [across, second] = [across, second].map(|x| square(self.graph, x));
            let others = dimensions.add(Rational::MINUS_ONE)?;
            self.graph.linear_combination(&[(across, others), (second, Rational::ONE)])
        } else {
            let r_squared = square(self.graph, r);
            let share = self.graph.divide(softening, r_squared);
            let one = self.graph.integer(1);
            let along = self.graph.subtract(one, share);
            let difference = self.graph.subtract(second, across);
            let difference = self.graph.multiply(difference, along);
            let mixed = self.graph.multiply(across, difference);
            let [across, difference] = [across, difference].map(|x| square(self.graph, x));
            self.graph.linear_combination(&[(across, dimensions), (mixed, two), (difference, Rational::ONE)])
        };
        let mass = square(self.graph, mass);
        Some(self.graph.multiply(mass, trace))
    }

    /// `-d ln Q/dt`
    fn log_rate(&mut self, q: Expr, line: &StraightLine) -> Expr {
        let velocities = self.velocities(line);
        let mut terms: Vec<(Expr, Rational)> = Vec::new();
        for (base, exponent) in powers(self.graph, q) {
            let rate = self.graph.rate(base, &velocities);
            let term = self.graph.divide(rate, base);
            terms.push((term, exponent.negate()));
        }
        self.graph.linear_combination(&terms)
    }

    /// The velocities of the state, the time and the distances.
    fn velocities(&mut self, line: &StraightLine) -> HashMap<Symbol, Expr> {
        let phase = &line.phase;
        let mut velocities = HashMap::new();
        for (i, (&q, &p)) in phase.q.iter().zip(&phase.p).enumerate() {
            velocities.insert(q, self.slope(self.energy, p));
            let slope = self.slope(self.energy, q);
            let mut terms = vec![(slope, Rational::MINUS_ONE)];
            terms.extend(line.force.iter().map(|force| (force[i], Rational::ONE)));
            if let Some(rate) = line.conformal {
                let momentum = self.graph.symbol(p);
                terms.push((self.graph.multiply(rate, momentum), Rational::MINUS_ONE));
            }
            velocities.insert(p, self.graph.linear_combination(&terms));
        }
        velocities.insert(phase.t, self.graph.integer(1));
        let of_state = velocities.clone();
        for distance in self.distances.all.clone() {
            let rate = self.graph.rate(distance.square, &of_state);
            let half = halved(self.graph, rate);
            let r = self.graph.symbol(distance.symbol);
            velocities.insert(distance.symbol, self.graph.divide(half, r));
        }
        velocities
    }
}

/// Half of a sum, term by term.
fn halved(graph: &mut Graph, sum: Expr) -> Expr {
    let terms = match graph.node(sum).clone() {
        Node::Sum { terms, constant } => {
            let one = graph.integer(1);
            terms.iter().copied().chain([(one, constant)]).collect()
        }
        _ => vec![(sum, Rational::ONE)],
    };
    let halves: Option<Vec<(Expr, Rational)>> =
        terms.into_iter().map(|(term, factor)| Some((term, factor.multiply(Rational::HALF)?))).collect();
    match halves {
        Some(halves) => graph.linear_combination(&halves),
        None => graph.scale(sum, Rational::HALF),
    }
}

/// The coordinates that are tried: zero among them, and steps in which functions of unit scale change sign.
const TRIALS: std::ops::RangeInclusive<i32> = -12..=12;
const TRIAL_STEP: f64 = 0.25;

impl Motion<'_> {
    /// Refuses a drift whose second derivatives by the coordinates all vanish at a point: at the origin, or,
    /// where no coordinates are coupled, at zeros of each of them.
    fn refuse_zeros(&mut self, extent: Extent, line: &StraightLine) -> syn::Result<()> {
        let q = &line.phase.q;
        let second = self.second(q);
        let mut entries: Vec<(usize, usize, Expr)> = Vec::new();
        for (i, row) in second.iter().enumerate() {
            for (j, &entry) in row.iter().enumerate().skip(i) {
                let entry = self.distances.written(self.graph, entry);
                if !self.graph.is_zero(entry) {
                    entries.push((i, j, entry));
                }
            }
        }
        // Coincidences of parameters are no zeros.
        let point = self.zero(&entries, q, &|_| 1.0).filter(|_| {
            let generic = |symbol: Symbol| 0.8 + 0.1 * (symbol.index() * 5 % 17) as f64;
            self.zero(&entries, q, &generic).is_some()
        });
        match point {
            None => Ok(()),
            Some(point) => {
                let at: Vec<String> = point
                    .into_iter()
                    .map(|(i, value)| format!("{} = {value:.3}", self.graph.symbol_name(q[i])))
                    .collect();
                let is_other = |symbol: Symbol| !q.contains(&symbol);
                let reads_others =
                    entries.iter().any(|&(.., entry)| self.graph.symbols_in(entry).into_iter().any(is_other));
                let others = if reads_others { " if all else is 1" } else { "" };
                Err(messages::curvature_vanishes(extent, &format!("{}{others}", at.join(", "))))
            }
        }
    }

    /// A point where all entries vanish, at these values of all that is no coordinate.
    fn zero(
        &self,
        entries: &[(usize, usize, Expr)],
        q: &[Symbol],
        others: &dyn Fn(Symbol) -> f64,
    ) -> Option<Vec<(usize, f64)>> {
        let origin = |symbol: Symbol| if q.contains(&symbol) { 0.0 } else { others(symbol) };
        if entries.iter().all(|&(.., entry)| self.value(entry, &origin) == Some(0.0)) {
            return Some((0..q.len()).map(|i| (i, 0.0)).collect());
        }
        let alone = entries.iter().map(|&(i, j, entry)| {
            let value = |x: f64| self.value(entry, &|symbol| if symbol == q[i] { x } else { others(symbol) });
            if i == j { zero_of(&value).map(|zero| (i, zero)) } else { None }
        });
        alone.collect()
    }

    /// The value of an entry; `None` where it is not defined.
    fn value(&self, entry: Expr, at: &dyn Fn(Symbol) -> f64) -> Option<f64> {
        let bounded = self.graph.evaluate_bounded(&[entry], at)[0];
        let is_zero = bounded.value.abs() <= bounded.error;
        bounded.is_defined().then_some(if is_zero { 0.0 } else { bounded.value })
    }
}

/// A zero of a function of one variable, among the points that are tried or where it changes its sign.
fn zero_of(value: &dyn Fn(f64) -> Option<f64>) -> Option<f64> {
    let mut before: Option<(f64, f64)> = None;
    for trial in TRIALS {
        let x = f64::from(trial) * TRIAL_STEP;
        let Some(own) = value(x) else {
            before = None;
            continue;
        };
        if own == 0.0 {
            return Some(x);
        }
        if let Some((mut left, of_left)) = before
            && of_left.signum() != own.signum()
        {
            let (mut right, scale) = (x, of_left.abs().max(own.abs()));
            let mut last = f64::INFINITY;
            for _ in 0..50 {
                let middle = 0.5 * (left + right);
                let Some(of_middle) = value(middle) else { break };
                last = of_middle.abs();
                if of_middle == 0.0 {
                    break;
                }
                if of_middle.signum() == of_left.signum() { left = middle } else { right = middle }
            }
            // At a pole values grow.
            if last < 1e-6 * scale {
                return Some(0.5 * (left + right));
            }
        }
        before = Some((x, own));
    }
    None
}
