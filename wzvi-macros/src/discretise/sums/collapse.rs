//! Sums over sites as collective variables, where these are known by their definitions.
//!
//! ```text
//! Σ_i K r g_j(x_i) = K r S_j,   Σ_i K = n K,   S_j = Σ_i g_j(x_i)
//! ```
//!
//! for factors `K` that do not depend on `i`, and rational numbers `r`. The rate of a total momentum is then
//! a polynomial in collective variables, such as `C (-S) + S C` for `(C² + S²) / 2`, which vanishes or not at
//! any size. Slopes are replaced by their definitions where these have become free of loops; where a sum
//! over sites remains, `K λ` with `λ = Σ_i s_i` is `Σ_i K s_i`, so that a trap around the centre of mass
//! exerts no force on it.
//!
//! Tests: `discretise/sums/tests.rs`.

use std::collections::HashMap;

use super::{Calculus, Sum, Weighted};
use crate::model::{CollectiveSlot, Element, Index, Loop, Slot};
use crate::symbolic::{Expr, Node, Rational, Symbol};

/// The most terms of a sum that is collapsed.
const MOST_TERMS: usize = 2_000;

impl Calculus<'_> {
    /// The elements with the first derivatives of a sum, in which collective variables count as constants.
    pub(crate) fn opened(&mut self, sum: &Sum) -> Sum {
        if self.space.collectives.is_empty() {
            return sum.clone();
        }
        let mut opened = Sum::new();
        let mut all = std::mem::take(&mut self.space.collectives);
        for Weighted { element, increments } in sum {
            let elements =
                all.with_slopes(self.graph, self.space.t, std::slice::from_ref(element), self.space);
            opened.extend(
                elements.into_iter().map(|element| Weighted { element, increments: increments.clone() }),
            );
        }
        self.space.collectives = all;
        opened
    }

    /// The sum with collective variables for the sums over sites that define them, and with the terms of
    /// slopes that are left outside of loops.
    pub(super) fn collapsed(&mut self, sum: &Sum) -> Sum {
        let mut collapsed = self.collapsed_once(sum);
        // The terms of a slope read slopes by later variables only.
        for _ in 0..self.space.collectives.all().len() {
            let Some(opened) = self.with_terms_of_slopes(&collapsed) else { break };
            collapsed = self.collapsed_once(&opened);
        }
        collapsed
    }

    /// The sum with the terms of slopes for those in which elements without loops are linear; `None` if
    /// there are none.
    fn with_terms_of_slopes(&mut self, sum: &Sum) -> Option<Sum> {
        let mut opened = Sum::new();
        let mut is_opened = false;
        for Weighted { element, increments } in sum {
            let mut add = |element| opened.push(Weighted { element, increments: increments.clone() });
            let slopes: Vec<(Symbol, CollectiveSlot)> = match element.loops.is_empty() {
                true => element
                    .collectives()
                    .filter(|(_, slot)| !self.space.collectives.of(*slot).is_sum())
                    .collect(),
                false => Vec::new(),
            };
            let symbols: Vec<Symbol> = slopes.iter().map(|(symbol, _)| *symbol).collect();
            let factors: Vec<Expr> =
                symbols.iter().map(|symbol| self.graph.derivative(element.value, *symbol)).collect();
            if slopes.is_empty() || factors.iter().any(|factor| self.graph.depends_on(*factor, &symbols)) {
                add(element.clone());
                continue;
            }
            is_opened = true;
            let zero = self.graph.integer(0);
            let without = symbols.iter().map(|symbol| (*symbol, zero)).collect();
            let rest = self.graph.substitute(&[element.value], &without)[0];
            add(self.space.element_of(self.graph, rest));
            for ((_, slot), factor) in slopes.into_iter().zip(factors) {
                for term in self.space.collectives.of(slot).elements.clone() {
                    let value = self.graph.multiply(factor, term.value);
                    add(self.space.element(self.graph, term.loops, value));
                }
            }
        }
        is_opened.then_some(opened)
    }

    fn collapsed_once(&mut self, sum: &Sum) -> Sum {
        let mut collapsed = Sum::new();
        for Weighted { element, increments } in sum {
            for element in self.collapsed_element(element) {
                collapsed.push(Weighted { element, increments: increments.clone() });
            }
        }
        let mut values = HashMap::new();
        for Weighted { element, .. } in &mut collapsed {
            let value = self.without_slopes(element.value, &mut values);
            *element = self.space.element(self.graph, element.loops.clone(), value);
        }
        self.combine(&[(&collapsed, Rational::ONE)])
    }

    /// `expr` with the definitions of slopes that are free of loops.
    fn without_slopes(&mut self, expr: Expr, values: &mut HashMap<Symbol, Option<Expr>>) -> Expr {
        let read = self.space.element(self.graph, Vec::new(), expr);
        let mut images = HashMap::new();
        for (symbol, slot) in read.collectives().collect::<Vec<_>>() {
            if !values.contains_key(&symbol) {
                let value = self.definition(slot, values);
                values.insert(symbol, value);
            }
            if let Some(Some(value)) = values.get(&symbol) {
                images.insert(symbol, *value);
            }
        }
        if images.is_empty() { expr } else { self.graph.substitute(&[expr], &images)[0] }
    }

    /// The value of a slope in other collective variables, if it is free of loops.
    fn definition(
        &mut self,
        slot: CollectiveSlot,
        values: &mut HashMap<Symbol, Option<Expr>>,
    ) -> Option<Expr> {
        let known = self.space.collectives.of(slot);
        if known.is_sum() {
            return None;
        }
        let elements = known.elements.clone();
        let mut terms = Vec::new();
        for element in &elements {
            for part in self.collapsed_element(element) {
                if !part.loops.is_empty() {
                    return None;
                }
                terms.push(part.value);
            }
        }
        let value = self.graph.sum(&terms);
        Some(self.without_slopes(value, values))
    }

    /// One element, collapsed from its innermost loop outwards.
    fn collapsed_element(&mut self, element: &Element) -> Vec<Element> {
        let Some((inner, outer)) = element.loops.split_last() else { return vec![element.clone()] };
        let Some(groups) = self.by_factor(element, inner) else { return vec![element.clone()] };
        let (mut left, mut outside) = (Vec::new(), Vec::new());
        for (factor, body) in groups {
            match self.as_collective(inner, body) {
                Some(total) => outside.push(self.graph.multiply(factor, total)),
                None => left.push((self.graph.multiply(factor, body), Rational::ONE)),
            }
        }
        let mut all = Vec::new();
        if !left.is_empty() {
            let value = self.graph.linear_combination(&left);
            all.push(self.space.element(self.graph, element.loops.clone(), value));
        }
        if !outside.is_empty() {
            let value = self.graph.sum(&outside);
            let element = self.space.element(self.graph, outer.to_vec(), value);
            all.extend(self.collapsed_element(&element));
        }
        all
    }

    /// The terms of an element by their factors that do not change with its innermost loop; `None` if they
    /// are too many.
    fn by_factor(&mut self, element: &Element, inner: &Loop) -> Option<Vec<(Expr, Expr)>> {
        let moving: Vec<Symbol> = element
            .locals
            .iter()
            .filter(|local| local.slot.indices().iter().any(|index| index.loops().contains(&inner.variable)))
            .map(|local| local.symbol)
            .collect();
        let mut terms = Vec::new();
        self.expanded(element.value, Rational::ONE, &moving, &mut terms)?;
        let mut groups: Vec<(Expr, Vec<(Expr, Rational)>)> = Vec::new();
        for (term, weight) in terms {
            let factors = match self.graph.node(term).clone() {
                Node::Product(factors) => factors.to_vec(),
                _ => vec![(term, Rational::ONE)],
            };
            let (own, others): (Vec<_>, Vec<_>) =
                factors.into_iter().partition(|(base, _)| self.graph.depends_on(*base, &moving));
            let [own, factor] = [own, others].map(|factors| {
                let powers: Vec<Expr> =
                    factors.into_iter().map(|(base, exponent)| self.graph.power(base, exponent)).collect();
                self.graph.product(&powers)
            });
            match groups.iter_mut().find(|(known, _)| *known == factor) {
                Some((_, bodies)) => bodies.push((own, weight)),
                None => groups.push((factor, vec![(own, weight)])),
            }
        }
        let mut all = Vec::new();
        for (factor, bodies) in groups {
            all.push((factor, self.graph.linear_combination(&bodies)));
        }
        Some(all)
    }

    /// The terms of a sum, and of sums that are multiplied by others, where these read what moves.
    fn expanded(
        &mut self,
        expr: Expr,
        weight: Rational,
        moving: &[Symbol],
        into: &mut Vec<(Expr, Rational)>,
    ) -> Option<()> {
        if into.len() > MOST_TERMS {
            return None;
        }
        match self.graph.node(expr).clone() {
            Node::Sum { terms, constant } => {
                for (term, coefficient) in terms {
                    self.expanded(term, weight.multiply(coefficient)?, moving, into)?;
                }
                if !constant.is_zero() {
                    into.push((self.graph.integer(1), weight.multiply(constant)?));
                }
            }
            Node::Product(factors) => {
                let opens = |base: Expr, exponent: Rational| {
                    exponent.is_one()
                        && matches!(self.graph.node(base), Node::Sum { .. })
                        && self.graph.depends_on(base, moving)
                };
                let Some(at) = factors.iter().position(|&(base, exponent)| opens(base, exponent)) else {
                    into.push((expr, weight));
                    return Some(());
                };
                let rest = factors.iter().enumerate().filter(|(place, _)| *place != at);
                let rest: Vec<(Expr, Rational)> = rest.map(|(_, factor)| *factor).collect();
                let rest: Vec<Expr> =
                    rest.into_iter().map(|(base, exponent)| self.graph.power(base, exponent)).collect();
                let rest = self.graph.product(&rest);
                let Node::Sum { terms, constant } = self.graph.node(factors[at].0).clone() else {
                    return None;
                };
                for (term, coefficient) in terms {
                    let product = self.graph.multiply(rest, term);
                    self.expanded(product, weight.multiply(coefficient)?, moving, into)?;
                }
                if !constant.is_zero() {
                    self.expanded(rest, weight.multiply(constant)?, moving, into)?;
                }
            }
            _ => into.push((expr, weight)),
        }
        Some(())
    }

    /// `Σ_(inner) body` as a number of turns, or as a multiple of a collective variable.
    fn as_collective(&mut self, inner: &Loop, body: Expr) -> Option<Expr> {
        let read = self.space.element(self.graph, vec![inner.clone()], body);
        let reads_loop =
            |slot: &Slot| slot.indices().iter().any(|index| index.loops().contains(&inner.variable));
        if !read.locals.iter().any(|local| reads_loop(&local.slot)) {
            let turns = inner.end.subtract(&inner.start)?;
            let is_all = inner.start == Index::default() && inner.end == self.space.size;
            let turns = match turns.as_integer() {
                Some(turns) => self.graph.number(Rational::new(turns.max(0), 1)?),
                None if is_all => {
                    let known = self.space.size_parameter;
                    let turns = known.unwrap_or_else(|| self.space.symbol(self.graph, &Slot::Number(turns)));
                    self.graph.symbol(turns)
                }
                None => return None,
            };
            return Some(self.graph.multiply(body, turns));
        }
        for number in 0..self.space.collectives.all().len() {
            let known = &self.space.collectives.all()[number];
            let [only] = known.elements.as_slice() else { continue };
            let [range] = only.loops.as_slice() else { continue };
            if !known.is_sum() || [&range.start, &range.end] != [&inner.start, &inner.end] {
                continue;
            }
            let (symbol, value, own) = (known.symbol, only.value, super::variable(range.variable));
            let mut images = HashMap::new();
            for local in &read.locals {
                let slot = local.slot.map(|index| index.with(inner.variable, &own))?;
                let image = self.space.symbol(self.graph, &slot);
                images.insert(local.symbol, self.graph.symbol(image));
            }
            let moved = self.graph.substitute(&[body], &images)[0];
            if let Some(factor) = self.multiple(moved, value) {
                let symbol = self.graph.symbol(symbol);
                return Some(self.graph.scale(symbol, factor));
            }
        }
        None
    }

    /// The rational number `r` with `one = r other`.
    fn multiple(&mut self, one: Expr, other: Expr) -> Option<Rational> {
        let first = |expr: Expr| match self.graph.node(expr) {
            Node::Sum { terms, .. } => terms.first().copied(),
            _ => Some((expr, Rational::ONE)),
        };
        let ((term, of_one), (like, of_other)) = (first(one)?, first(other)?);
        let of_one = match self.graph.node(one) {
            Node::Sum { terms, .. } => terms.iter().find(|(known, _)| *known == like).map(|(_, c)| *c)?,
            _ => Some(of_one).filter(|_| term == like)?,
        };
        let factor = of_one.multiply(of_other.recip()?)?;
        let difference = self.graph.linear_combination(&[(one, Rational::ONE), (other, factor.negate())]);
        self.graph.is_zero(difference).then_some(factor)
    }
}
