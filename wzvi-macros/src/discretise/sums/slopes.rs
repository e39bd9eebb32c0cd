//! The slopes of a sum at one point of the phase space, for every point.
//!
//! With a sum `G = Σ_i δ_i p_i` of free numbers `δ`, the contraction `Σ_s ∂F/∂x_s ∂G/∂p_s` is `Σ_i δ_i ∂F/∂x_i`: the
//! coefficient of `δ_i` is the slope at `i`.

use std::collections::HashMap;

use super::{Increments, Space, Sum, Weighted, variable};
use crate::model::{Element, Half, Index, Local, Loop, Slot, Table};
use crate::symbolic::Graph;

/// A part of `∂F/∂x` at the point `at`, the variable of the outermost loop if possible.
pub(crate) struct Slope {
    pub(crate) part: Weighted,
    pub(crate) at: Index,
    /// Whether the outermost loop runs over the points: then the others are sums.
    pub(crate) is_by_point: bool,
}

impl Space {
    /// The same space with other names for coordinates and momenta.
    pub(crate) fn renamed(&self, names: [String; 2]) -> Self {
        Self { names, symbols: HashMap::new(), slots: HashMap::new(), ..self.clone() }
    }

    /// The parts of `∂F/∂x` for component `component` of every point; `None` if an index is beyond this arithmetic.
    pub(crate) fn slopes(
        &mut self,
        graph: &mut Graph,
        sum: &Sum,
        half: Half,
        component: i128,
    ) -> Option<Vec<Slope>> {
        let free = u32::try_from(self.tables.len()).ok()?;
        self.tables.push(Table { name: "δ".to_owned(), ..Table::default() });
        let own = self.variable(0);
        let place = variable(own).multiply(&Index::integer(self.components))?.shifted(component)?;
        let slots = [Slot::Entry(free, vec![variable(own)]), Slot::State(Half::Momenta, place)];
        let locals = slots.map(|slot| Local { symbol: self.symbol(graph, &slot), slot });
        let factors: Vec<_> = locals.iter().map(|local| graph.symbol(local.symbol)).collect();
        let range = Loop { variable: own, start: Index::default(), end: self.size.clone() };
        let element = Element { loops: vec![range], value: graph.product(&factors), locals: locals.into() };
        let probe = vec![Weighted { element, increments: Vec::new() }];
        let varied = self.contract(graph, (sum, half), (&probe, Half::Momenta), Increments::Each);
        let mut slopes = Vec::new();
        for Weighted { element, increments } in varied? {
            for local in &element.locals {
                let Slot::Entry(table, indices) = &local.slot else { continue };
                let ([at], true) = (indices.as_slice(), *table == free) else { continue };
                let value = graph.derivative(element.value, local.symbol);
                let part = Element { value, ..element.clone() };
                slopes.push(self.by_point(graph, part, increments.clone(), at)?);
            }
        }
        self.tables.pop();
        Some(slopes)
    }

    /// The slope with the variable of its outermost loop at `at`.
    fn by_point(
        &mut self,
        graph: &mut Graph,
        element: Element,
        increments: Vec<Index>,
        at: &Index,
    ) -> Option<Slope> {
        let outer = element.loops.first().map(|known| known.variable);
        let shift = outer.and_then(|own| at.subtract(&variable(own))?.as_integer());
        let (Some(own), Some(shift)) = (outer, shift) else {
            let element = self.element(graph, element.loops, element.value);
            return Some(Slope {
                part: Weighted { element, increments },
                at: at.clone(),
                is_by_point: false,
            });
        };
        let by = variable(own).shifted(-shift)?;
        let moved = |index: &Index| index.with(own, &by);
        let mut loops = Vec::new();
        for (depth, known) in element.loops.iter().enumerate() {
            // The range of the outermost loop moves with its variable.
            let end = |index: &Index| if depth == 0 { index.shifted(shift) } else { moved(index) };
            loops.push(Loop { start: end(&known.start)?, end: end(&known.end)?, ..known.clone() });
        }
        let mut images = HashMap::new();
        for local in &element.locals {
            let symbol = self.symbol(graph, &local.slot.map(moved)?);
            images.insert(local.symbol, graph.symbol(symbol));
        }
        let value = *graph.substitute(&[element.value], &images).first()?;
        let increments = increments.iter().map(moved).collect::<Option<_>>()?;
        let element = self.element(graph, loops, value);
        Some(Slope { part: Weighted { element, increments }, at: variable(own), is_by_point: true })
    }

    /// The slope and its range: `V'(q[i] - q[i - 1])   for i = 1..n - 1`.
    pub(crate) fn display_slope(&self, graph: &Graph, slope: &Slope) -> String {
        let Slope { part: Weighted { element, .. }, at, is_by_point } = slope;
        let loops = &element.loops;
        let (points, sums) = loops.split_at(usize::from(*is_by_point));
        let sums: String = sums.iter().map(|known| self.range(loops, known)).collect();
        let value = graph.display(element.value);
        let value = if sums.is_empty() { value } else { format!("{sums}[{value}]") };
        match points {
            [known] => {
                let last = known.end.shifted(-1).unwrap_or_default();
                format!("{value}   for i = {}..{}", self.index(loops, &known.start), self.index(loops, &last))
            }
            _ => format!("{value}   at point {}", self.index(loops, at)),
        }
    }
}
