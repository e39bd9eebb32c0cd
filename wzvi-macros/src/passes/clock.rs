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
mod distances;
mod pairs;
#[cfg(test)]
mod tests;

use std::collections::HashMap;

use self::distances::Distances;
use crate::diagnostics::{Diagnostics, Extent, facts as messages};
use crate::discretise::{Calculus, DriftFlow, Space, Sum, Weighted, unweighted};
use crate::model::{
    Clock, ClockKind, Collective, CollectiveRole, CollectiveSlot, Element, Reads, System, Term,
};
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
    let Some(Derived { values, elements, rate, text }) = diagnostics.accept(derived) else { return };
    let reads = values.iter().map(Element::reads).fold(Reads { q: false, p: false }, Reads::or);
    if reads.p && system.has_thermostat() {
        diagnostics.report(messages::clock_of_bath(clock.term.extent));
    }
    let collectives: Vec<u32> = (known..system.collectives.all().len()).map(|number| number as u32).collect();
    let text = text.unwrap_or_else(|| text_of(system, clock.kind, &values, &rate, &collectives));
    let term = Term { values, elements, ..clock.term };
    system.clock = Some(Clock { term, rate, text, collectives, ..clock });
}

/// `Q` and `G`, and the collective variables with these numbers that they are made of: sums, and slopes by
/// these that `G` reads. Pairs are written in distances.
fn text_of(
    system: &mut System,
    kind: ClockKind,
    values: &[Element],
    rate: &[Element],
    numbers: &[u32],
) -> String {
    let read: Vec<Symbol> = rate.iter().flat_map(Element::collectives).map(|(symbol, _)| symbol).collect();
    let variables = numbers.iter().map(|&number| system.collectives.numbered(number).clone());
    let variables: Vec<Collective> =
        variables.filter(|known| known.is_sum() || read.contains(&known.symbol)).collect();
    let distances = match kind {
        ClockKind::Pairs => {
            let of_variables = variables.iter().flat_map(|known| &known.elements);
            let all: Vec<&Element> = values.iter().chain(rate).chain(of_variables).collect();
            let roots: Vec<Expr> = all.iter().map(|element| element.value).collect();
            let moving: Vec<Symbol> = all.iter().flat_map(|element| element.state()).collect();
            Distances::of(system, &roots, &moving).in_text(&mut system.graph)
        }
        ClockKind::Function | ClockKind::Curvature => Distances::default(),
    };
    let (space, graph) = (Space::of(system), &mut system.graph);
    let display = |graph: &mut Graph, elements: &[Element]| {
        let mut sum = unweighted(elements);
        for Weighted { element, .. } in &mut sum {
            element.value = distances.within(graph, element.value);
        }
        space.display(graph, &sum, Rational::ONE)
    };
    let [q, g] = [values, rate].map(|elements| display(graph, elements));
    let mut text = lines(&q, &g);
    for known in &variables {
        let value = display(graph, &known.elements);
        text.push_str(&format!("  {} = {value}\n", graph.symbol_name(known.symbol)));
    }
    text.push_str(&distances.lines(graph));
    text
}

/// `Q` and `G`.
struct Derived {
    values: Vec<Element>,
    /// For derivatives of `Q`, where a scheme takes these.
    elements: Vec<Element>,
    rate: Vec<Element>,
    /// Where the text is not that of these elements.
    text: Option<String>,
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
    system.collectives = space.collectives().clone();
    let plain = |sum: Sum| sum.into_iter().map(|weighted| weighted.element).collect();
    Ok(Derived { values: plain(own), elements: plain(elements), rate: plain(rate), text: None })
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
        let value = factored(sums.graph, element.value);
        let value = sums.graph.multiply(factor, value);
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

/// A sum with the factors that all of its terms share in front of it.
fn factored(graph: &mut Graph, sum: Expr) -> Expr {
    let Node::Sum { terms, constant } = graph.node(sum).clone() else { return sum };
    let factors = |term: Expr| match graph.node(term) {
        Node::Product(factors) => factors.to_vec(),
        _ => vec![(term, Rational::ONE)],
    };
    let all: Vec<Vec<(Expr, Rational)>> = terms.iter().map(|&(term, _)| factors(term)).collect();
    let Some((first, others)) = all.split_first().filter(|_| constant.is_zero() && terms.len() > 1) else {
        return sum;
    };
    let shared: Vec<(Expr, Rational)> =
        first.iter().copied().filter(|factor| others.iter().all(|other| other.contains(factor))).collect();
    let size = |value: Rational| if value.is_negative() { value.negate() } else { value };
    let largest = size(terms[0].1);
    let is_common = terms.iter().all(|&(_, coefficient)| size(coefficient) == largest);
    let common = if is_common { terms[0].1 } else { Rational::ONE };
    let product = |graph: &mut Graph, factors: &[(Expr, Rational)]| {
        let powers: Vec<Expr> = factors.iter().map(|&(base, exponent)| graph.power(base, exponent)).collect();
        graph.product(&powers)
    };
    let rests = all.iter().zip(terms.iter()).map(|(factors, &(_, coefficient))| {
        let rest: Vec<(Expr, Rational)> =
            factors.iter().copied().filter(|factor| !shared.contains(factor)).collect();
        let rest = product(graph, &rest);
        let sign = if coefficient == common { Rational::ONE } else { Rational::MINUS_ONE };
        (rest, if is_common { sign } else { coefficient })
    });
    let rests: Vec<(Expr, Rational)> = rests.collect();
    let rest = graph.linear_combination(&rests);
    let shared = product(graph, &shared);
    let whole = graph.multiply(shared, rest);
    graph.scale(whole, common)
}
