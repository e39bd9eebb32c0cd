//! The clock: its wanted length of a step up to a factor, `Q`, and the rate `G = -d ln Q/dt` along the drift
//! with its forces and friction, by which a density follows it.
//!
//! | clock | `Q` |
//! |---|---|
//! | a closure | its value |
//! | `curvature(w0)` | `(tr((H_pp H_qq)²) + w0⁴)^(-1/4)`, see [`curvature`] |
//! | `pairs` | `(Σ ω²)^(-1/2)` over pairs, see [`pairs`] |
//!
//! With `Q = Π b^e` the rate is `G = -Σ e (db/dt)/b`: the rates of sums over sites are sums in the same
//! loops, and powers are not differentiated. `db/dt = {H0, b} + ∂b/∂t + F0 · ∂b/∂p`, less that of friction.

mod curvature;
mod pairs;
#[cfg(test)]
mod tests;

use std::collections::HashMap;

use crate::diagnostics::{Diagnostics, Extent, facts as messages};
use crate::discretise::{Calculus, DriftFlow, Space, Sum, Weighted, unweighted};
use crate::model::{Clock, ClockKind, CollectiveRole, CollectiveSlot, Element, Reads, System, Term};
use crate::symbolic::sign::Sign;
use crate::symbolic::{Expr, Function, Graph, Node, Rational, Symbol};

/// Derives the clock of a system that has one.
pub(crate) fn clock(system: &mut System, diagnostics: &mut Diagnostics) {
    let Some(clock) = system.clock.clone() else { return };
    if !system.constraints.is_empty() {
        diagnostics.report(messages::clock_on_manifold(clock.term.extent));
        return;
    }
    let known = system.collectives.all().len();
    let derived = match clock.kind {
        ClockKind::Function => function(system, &clock.term),
        ClockKind::Curvature => curvature::derive(system, &clock.term),
        ClockKind::Pairs => pairs::derive(system, &clock.term),
    };
    let Some(Derived { values, elements, rate, mut text }) = diagnostics.accept(derived) else { return };
    let reads = values.iter().map(Element::reads).fold(Reads { q: false, p: false }, Reads::or);
    if reads.p && system.has_thermostat() {
        diagnostics.report(messages::clock_of_bath(clock.term.extent));
    }
    let term = Term { values, elements, ..clock.term };
    let collectives: Vec<u32> = (known..system.collectives.all().len()).map(|number| number as u32).collect();
    text.push_str(&variables(system, &collectives, &rate));
    system.clock = Some(Clock { term, rate, text, collectives, ..clock });
}

/// The lines of the collective variables with these numbers that `Q` and `G` are made of: sums, and slopes by
/// these that `G` reads.
fn variables(system: &mut System, numbers: &[u32], rate: &[Element]) -> String {
    let (space, mut text) = (Space::of(system), String::new());
    let System { graph, collectives, .. } = system;
    for &number in numbers {
        let variable = collectives.numbered(number);
        let is_read = rate.iter().flat_map(Element::collectives).any(|(symbol, _)| symbol == variable.symbol);
        if variable.is_sum() || is_read {
            let value = space.display(graph, &unweighted(&variable.elements), Rational::ONE);
            text.push_str(&format!("  {} = {value}\n", graph.symbol_name(variable.symbol)));
        }
    }
    text
}

/// `Q` and `G`.
struct Derived {
    values: Vec<Element>,
    /// For derivatives of `Q`, where a scheme takes these.
    elements: Vec<Element>,
    rate: Vec<Element>,
    text: String,
}

/// The clock that is the user's function.
fn function(system: &mut System, term: &Term) -> syn::Result<Derived> {
    let value = match term.values.as_slice() {
        [] => return Err(messages::clock_is_zero(term.extent)),
        [only] if only.loops.is_empty() => only.value,
        sum => total(system, sum),
    };
    of_value(system, term.extent, value)
}

/// A sum over sites as one collective variable.
fn total(system: &mut System, sum: &[Element]) -> Expr {
    let System { graph, symbols, collectives, t, .. } = system;
    let variable = collectives.variable(graph, *t, CollectiveRole::Sum, sum.to_vec(), symbols);
    graph.symbol(variable)
}

/// The clock with this value, which may read collective variables.
fn of_value(system: &mut System, extent: Extent, value: Expr) -> syn::Result<Derived> {
    let (flow, mut space) = (DriftFlow::of(system), Space::of(system));
    let is_extended = system.is_extended();
    let sums = &mut Calculus { space: &mut space, graph: &mut system.graph };
    let own = unweighted(&[sums.space.element_of(sums.graph, value)]);
    let rate = log_rate(sums, &flow, value).ok_or_else(|| messages::clock_of_elements(extent))?;
    let elements = if is_extended { sums.opened(&own) } else { Sum::new() };
    let [q, g] = [&own, &rate].map(|sum| space.display(&mut system.graph, sum, Rational::ONE));
    system.collectives = space.collectives().clone();
    let plain = |sum: Sum| sum.into_iter().map(|weighted| weighted.element).collect();
    Ok(Derived { values: plain(own), elements: plain(elements), rate: plain(rate), text: lines(&q, &g) })
}

/// The text of a clock.
fn lines(q: &str, g: &str) -> String {
    format!("Clock\n  Q = {q}\n  G = -d ln Q/dt = {g}\n")
}

/// `-d ln Q/dt`; `None` if indices exceed their arithmetic.
fn log_rate(sums: &mut Calculus<'_>, flow: &DriftFlow, value: Expr) -> Option<Sum> {
    let mut rates: Vec<Sum> = Vec::new();
    for (base, exponent) in powers(sums.graph, value) {
        let (of, divisor) = match sums.graph.node(base) {
            Node::Apply(Function::Exp, arguments) => (arguments[0], None),
            _ => (base, Some(base)),
        };
        let rate = rate_of(sums, flow, of)?;
        let factor = sums.graph.number(exponent.negate());
        let factor = divisor.map_or(factor, |divisor| sums.graph.divide(factor, divisor));
        rates.push(times(sums, factor, rate));
    }
    Some(added(sums, &rates))
}

/// The rate of a function without loops. The rates of sums over sites in it are sums in the same loops, times
/// slopes by these sums.
fn rate_of(sums: &mut Calculus<'_>, flow: &DriftFlow, value: Expr) -> Option<Sum> {
    let element = sums.space.element_of(sums.graph, value);
    let collectives: Vec<(Symbol, CollectiveSlot)> = element.moving_collectives().collect();
    let is_nested = collectives
        .iter()
        .any(|(_, slot)| sums.space.collectives().of(*slot).elements.iter().any(Element::is_collective));
    if is_nested {
        return flow.rate(sums, &unweighted(&[element]));
    }
    let mut rates: Vec<Sum> = Vec::new();
    let (mut frozen, mut released) = (HashMap::new(), HashMap::new());
    for (symbol, slot) in collectives {
        let terms = unweighted(&sums.space.collectives().of(slot).elements.clone());
        let rate = flow.rate(sums, &terms)?;
        let slope = sums.graph.derivative(value, symbol);
        rates.push(times(sums, slope, rate));
        let constant = sums.graph.new_symbol_like(symbol, "S");
        frozen.insert(symbol, sums.graph.symbol(constant));
        released.insert(constant, sums.graph.symbol(symbol));
    }
    let of_state = sums.graph.substitute(&[value], &frozen)[0];
    let of_state = unweighted(&[sums.space.element_of(sums.graph, of_state)]);
    let mut rate = flow.rate(sums, &of_state)?;
    for Weighted { element, .. } in &mut rate {
        let value = sums.graph.substitute(&[element.value], &released)[0];
        *element = sums.space.element(sums.graph, element.loops.clone(), value);
    }
    rates.push(rate);
    Some(added(sums, &rates))
}

/// A sum times a function without loops.
fn times(sums: &mut Calculus<'_>, factor: Expr, mut sum: Sum) -> Sum {
    for Weighted { element, .. } in &mut sum {
        let value = sums.graph.multiply(factor, element.value);
        *element = sums.space.element(sums.graph, element.loops.clone(), value);
    }
    sum
}

fn added(sums: &mut Calculus<'_>, all: &[Sum]) -> Sum {
    let all: Vec<(&Sum, Rational)> = all.iter().map(|sum| (sum, Rational::ONE)).collect();
    sums.combine(&all)
}

/// An expression as a product of powers, up to its constant factor.
fn powers(graph: &Graph, value: Expr) -> Vec<(Expr, Rational)> {
    let (_, value) = graph.as_multiple(value);
    let factors = match graph.node(value) {
        Node::Product(factors) => factors.to_vec(),
        _ => vec![(value, Rational::ONE)],
    };
    let opened = |(base, exponent): (Expr, Rational)| match graph.node(base) {
        Node::Apply(Function::Sqrt, arguments) => {
            let half = exponent.multiply(Rational::HALF);
            half.map_or((base, exponent), |half| (arguments[0], half))
        }
        _ => (base, exponent),
    };
    factors.into_iter().map(opened).collect()
}

/// `x^exponent`, of a product factor by factor: even powers become powers of the absolute value.
fn root(graph: &mut Graph, x: Expr, exponent: Rational) -> Expr {
    let (coefficient, inner) = graph.as_multiple(x);
    let factors = match graph.node(inner) {
        Node::Product(factors) => factors.to_vec(),
        _ => vec![(inner, Rational::ONE)],
    };
    let is_open = |&(base, power): &(Expr, Rational)| {
        graph.sign(base) >= Sign::Nonnegative || power.is_integer() && power.numerator() % 2 == 0
    };
    if coefficient.is_negative() || !factors.iter().all(is_open) {
        return graph.power(x, exponent);
    }
    let number = graph.number(coefficient);
    let mut all = vec![graph.power(number, exponent)];
    for (base, power) in factors {
        let Some(power) = power.multiply(exponent) else { return graph.power(x, exponent) };
        let size = graph.apply(Function::Abs, &[base]);
        all.push(graph.power(size, power));
    }
    graph.product(&all)
}
