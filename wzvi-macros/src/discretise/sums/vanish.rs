//! Whether a sum is zero, or constant on the phase space.
//!
//! 1. Where what stands in the same loops vanishes identically, the sum is zero at any size.
//! 2. Else the sum is written out at a few sizes: a point where it does not vanish is a witness against all of them.
//! 3. If the sum is local ([`super::locality`]), a few sizes are a proof.
//!
//! A sum `R` is constant if and only if `R(z) - R(z')` vanishes for any two states.

use std::collections::HashMap;

use super::instance::{NotWritten, Numbers, Site};
use super::{Increments, Space, Sum, Weighted};
use crate::model::index::Index;
use crate::model::{Element, Half, Local, Slot};
use crate::symbolic::zero::Knowledge;
use crate::symbolic::zero::{Witness, ZeroTest};
use crate::symbolic::{Expr, Graph, Symbol};

/// The sizes at which a witness is looked for, the first few that the indices allow.
const TRIED: [i128; 6] = [3, 4, 5, 8, 16, 32];
const ENOUGH: usize = 3;

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Question {
    Zero,
    Constant,
}

impl Space {
    /// Whether the sum is zero, for any values of the increments.
    pub(crate) fn vanishes(&mut self, graph: &mut Graph, sum: &Sum, increments: Increments) -> Knowledge {
        self.decide(graph, sum, increments, Question::Zero)
    }

    /// Whether the sum does not depend on the state, for any values of the increments.
    pub(crate) fn is_constant(&mut self, graph: &mut Graph, sum: &Sum, increments: Increments) -> Knowledge {
        self.decide(graph, sum, increments, Question::Constant)
    }

    fn decide(
        &mut self,
        graph: &mut Graph,
        sum: &Sum,
        increments: Increments,
        question: Question,
    ) -> Knowledge {
        let mut left = Sum::new();
        let mut verdicts = Vec::new();
        for weighted in sum {
            match test_element(graph, &weighted.element, question) {
                ZeroTest::Zero => {}
                verdict => {
                    left.push(weighted.clone());
                    verdicts.push(verdict);
                }
            }
        }
        if left.is_empty() {
            return Knowledge::Proven;
        }
        // Without loops there is one element for each product of increments.
        if left.iter().all(|weighted| weighted.element.loops.is_empty()) {
            let refuted = verdicts.into_iter().find_map(|verdict| match verdict {
                ZeroTest::Nonzero(witness) => Some(witness),
                _ => None,
            });
            return refuted.map_or_else(no_identity, Knowledge::Refuted);
        }
        match self.size.as_integer() {
            Some(size) => self.decide_at(graph, &left, size, increments, question),
            None => self.decide_for_all(graph, &left, increments, question),
        }
    }

    /// For one size.
    fn decide_at(
        &mut self,
        graph: &mut Graph,
        sum: &Sum,
        size: i128,
        increments: Increments,
        question: Question,
    ) -> Knowledge {
        match self.instance(graph, sum, (size, Numbers::Known), increments, question) {
            Ok(ZeroTest::Zero) => return Knowledge::Proven,
            Ok(ZeroTest::Nonzero(witness)) => return Knowledge::Refuted(witness),
            Ok(ZeroTest::Unknown) => return no_identity(),
            Err(NotWritten::OutOfRange) => return Knowledge::Unknown("an index is out of range".to_owned()),
            Err(NotWritten::TooLarge) => {}
        }
        if let Some(witness) = self.slope_that_does_not_vanish(graph, sum, size, increments, 2) {
            return Knowledge::Refuted(witness);
        }
        let unknown = || Knowledge::Unknown(format!("it is too long to be written out for {size} points"));
        let Some((mut space, general)) = self.generalised(sum, size) else { return unknown() };
        let Some(first) = space.deciding_size(&general).filter(|&first| first < size) else {
            return unknown();
        };
        for size in [first, first + 1] {
            match space.instance(graph, &general, (size, Numbers::Free), increments, question) {
                Ok(ZeroTest::Zero) => {}
                _ => return unknown(),
            }
        }
        Knowledge::Proven
    }

    /// For all sizes.
    fn decide_for_all(
        &mut self,
        graph: &mut Graph,
        sum: &Sum,
        increments: Increments,
        question: Question,
    ) -> Knowledge {
        let mut tried = Vec::new();
        for size in TRIED {
            match self.instance(graph, sum, (size, Numbers::Known), increments, question) {
                Ok(ZeroTest::Nonzero(witness)) => return Knowledge::Refuted(witness),
                Ok(ZeroTest::Unknown) => return no_identity(),
                Ok(ZeroTest::Zero) => tried.push(size),
                Err(NotWritten::OutOfRange) => {}
                Err(NotWritten::TooLarge) => break,
            }
            if tried.len() == ENOUGH {
                break;
            }
        }
        let unknown = || {
            let tried: Vec<String> = tried.iter().map(i128::to_string).collect();
            Knowledge::Unknown(match tried.is_empty() {
                true => "its indices could not be resolved".to_owned(),
                false => format!("it cancels at {} points, but no proof covers every size", tried.join(", ")),
            })
        };
        if !tried.is_empty() && sum.iter().all(is_the_same_at_all_sizes) {
            return Knowledge::Proven;
        }
        let Some(first) = self.deciding_size(sum) else { return unknown() };
        for size in 1..=first + 1 {
            match self.instance(graph, sum, (size, Numbers::Free), increments, question) {
                Ok(ZeroTest::Zero) => {}
                Err(NotWritten::OutOfRange) if size < first => {}
                // Few points are a ring that meets itself: a witness, if it is none of free numbers.
                Ok(ZeroTest::Nonzero(_)) => {
                    return match self.instance(graph, sum, (size, Numbers::Known), increments, question) {
                        Ok(ZeroTest::Nonzero(witness)) => Knowledge::Refuted(witness),
                        _ => unknown(),
                    };
                }
                _ => return unknown(),
            }
        }
        Knowledge::Proven
    }

    /// A slope of the sum, after `depth` derivatives, that is not zero.
    fn slope_that_does_not_vanish(
        &mut self,
        graph: &mut Graph,
        sum: &Sum,
        size: i128,
        increments: Increments,
        depth: usize,
    ) -> Option<Witness> {
        let points = [0, 1, size / 2, size - 1];
        for point in points {
            for component in 0..self.components.min(3) {
                for half in [Half::Coordinates, Half::Momenta] {
                    let index = Index::integer(point * self.components + component);
                    let slope = self.slope(graph, sum, half, index)?;
                    match self.instance(graph, &slope, (size, Numbers::Known), increments, Question::Zero) {
                        Ok(ZeroTest::Nonzero(witness)) => return Some(witness),
                        Err(NotWritten::TooLarge) if depth > 1 => {
                            let deeper =
                                self.slope_that_does_not_vanish(graph, &slope, size, increments, depth - 1);
                            if deeper.is_some() {
                                return deeper;
                            }
                        }
                        _ => {}
                    }
                }
            }
        }
        None
    }

    /// The derivative by one component of the state.
    fn slope(&mut self, graph: &mut Graph, sum: &Sum, half: Half, index: Index) -> Option<Sum> {
        let slot = Slot::State(half, index);
        let symbol = self.symbol(graph, &slot);
        let value = graph.symbol(symbol);
        let element = Element { loops: Vec::new(), value, locals: vec![Local { symbol, slot }] };
        let unit = vec![Weighted { element, increments: Vec::new() }];
        self.contract(graph, (sum, half), (&unit, half), Increments::Each)
    }

    fn instance(
        &mut self,
        graph: &mut Graph,
        sum: &Sum,
        (size, numbers): (i128, Numbers),
        increments: Increments,
        question: Question,
    ) -> Result<ZeroTest, NotWritten> {
        let mut site = Site::new(self, size, numbers, increments);
        let value = site.value(graph, sum, false)?;
        let value = match question {
            Question::Zero => value,
            Question::Constant => {
                let other = site.value(graph, sum, true)?;
                graph.subtract(value, other)
            }
        };
        Ok(graph.test_zero(value))
    }
}

/// Whether no index of it reads a size or a table.
fn is_the_same_at_all_sizes(weighted: &Weighted) -> bool {
    let Weighted { element, increments } = weighted;
    let of_loops = element.loops.iter().flat_map(|known| [&known.start, &known.end]);
    let of_slots = element.locals.iter().flat_map(|local| local.slot.indices());
    of_loops.chain(of_slots).chain(increments).all(Index::is_closed)
}

fn test_element(graph: &mut Graph, element: &Element, question: Question) -> ZeroTest {
    let value = match question {
        Question::Zero => element.value,
        Question::Constant => {
            let state: Vec<Symbol> =
                element.coordinates().chain(element.momenta()).map(|(symbol, _)| symbol).collect();
            let other: HashMap<Symbol, Expr> = state
                .iter()
                .map(|&symbol| {
                    let other = graph.new_symbol(format!("{}'", graph.symbol_name(symbol)));
                    (symbol, graph.symbol(other))
                })
                .collect();
            let other = graph.substitute(&[element.value], &other)[0];
            graph.subtract(element.value, other)
        }
    };
    graph.test_zero(value)
}

fn no_identity() -> Knowledge {
    Knowledge::Unknown(
        "it vanishes wherever it was evaluated, but by no identity that the compiler knows".to_owned(),
    )
}
