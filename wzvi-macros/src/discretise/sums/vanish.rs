//! Whether a sum is zero, or constant on the phase space.
//!
//! 1. Where the terms in the same loops vanish identically, the sum is zero at any size.
//! 2. Otherwise the sum is written out at a few sizes: a point where it does not vanish is a counterexample
//!    for all of them.
//! 3. If the sum is local ([`super::locality`]), a few sizes are a proof.
//!
//! A sum `R` is constant if and only if `R(z) - R(z')` vanishes for any two states.
//!
//! Tests: `discretise/sums/tests.rs`.

use std::collections::HashMap;

use super::instance::{Instance, NotWritten, NumberValues};
use super::{Calculus, Increments, KnownSum, Sum, Weighted};
use crate::model::{Element, Half, Index, Local, Slot};
use crate::symbolic::{Expr, Knowledge, Symbol, Witness, ZeroTest};

/// The sizes searched for a witness: the first few that the indices allow.
const WITNESS_SIZES: [i128; 6] = [3, 4, 5, 8, 16, 32];
const MOST_CANCELLING_SIZES: usize = 3;
/// The largest size at which a function of sums over sites is written out.
const LARGEST_WITH_COLLECTIVES: i128 = 32;

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Statement {
    Zero,
    Constant,
}

impl Calculus<'_> {
    /// Whether the sum is zero for all values of the increments.
    pub(crate) fn vanishes(&mut self, sum: Option<Sum>, increments: Increments) -> KnownSum {
        self.known_sum(sum, increments, Statement::Zero)
    }

    /// Whether the sum is independent of the state for all values of the increments.
    pub(crate) fn is_constant(&mut self, sum: Option<Sum>, increments: Increments) -> KnownSum {
        self.known_sum(sum, increments, Statement::Constant)
    }

    fn known_sum(&mut self, sum: Option<Sum>, increments: Increments, statement: Statement) -> KnownSum {
        let known = match &sum {
            Some(sum) => Prover { sums: self, increments, statement }.decide(sum),
            None => Knowledge::Unknown("its indices exceed 128 bits".to_owned()),
        };
        KnownSum { sum, known }
    }
}

/// One question about sums of one space.
struct Prover<'j, 'c> {
    sums: &'j mut Calculus<'c>,
    increments: Increments,
    statement: Statement,
}

impl Prover<'_, '_> {
    fn decide(&mut self, sum: &Sum) -> Knowledge {
        match sum.iter().any(|weighted| weighted.element.collectives().next().is_some()) {
            true => self.decide_with_collectives(sum),
            false => self.decide_of_sites(sum),
        }
    }

    /// Decides for functions of collective variables. If the sum vanishes for all values of these, it does
    /// for those that they have. What does not is written out.
    fn decide_with_collectives(&mut self, sum: &Sum) -> Knowledge {
        let collapsed = self.sums.collapsed(sum);
        let is_plain = collapsed.iter().all(|weighted| weighted.element.collectives().next().is_none());
        if is_plain {
            return self.decide_of_sites(&collapsed);
        }
        if self.vanishes_freely(&collapsed) {
            return Knowledge::Proven;
        }
        let sizes = match self.sums.space.size.as_integer() {
            Some(size) => vec![size],
            None => WITNESS_SIZES[..MOST_CANCELLING_SIZES].to_vec(),
        };
        for size in sizes.into_iter().filter(|size| *size <= LARGEST_WITH_COLLECTIVES) {
            if let Ok(verdict @ ZeroTest::Nonzero(_)) = self.instance_of_size(sum, size) {
                return verdict.known();
            }
        }
        Knowledge::Unknown("it is a function of sums over sites, and no proof covers it".to_owned())
    }

    /// Whether a sum vanishes for all values of collective variables, at all sizes.
    fn vanishes_freely(&mut self, sum: &Sum) -> bool {
        let mut left = Sum::new();
        for weighted in sum {
            if self.test_element(&weighted.element) != ZeroTest::Zero {
                left.push(weighted.clone());
            }
        }
        // Some sums may be written out, and others not: at a known size all are.
        if let Some(size) = self.sums.space.size.as_integer()
            && matches!(self.instance(&left, size, NumberValues::Free), Ok(ZeroTest::Zero))
        {
            return true;
        }
        if left.iter().any(|weighted| weighted.element.loops.is_empty()) {
            return false;
        }
        left.is_empty() || self.vanishes_by_few(&left)
    }

    /// Whether a sum vanishes at the sizes that decide all others.
    fn vanishes_by_few(&mut self, sum: &Sum) -> bool {
        match self.sums.space.size.as_integer() {
            Some(size) => self.holds_in_general(sum, size) == Some(true),
            None => matches!(self.decide_by_few(sum), Some(Knowledge::Proven)),
        }
    }

    fn decide_of_sites(&mut self, sum: &Sum) -> Knowledge {
        let (mut left, mut verdicts) = (Sum::new(), Vec::new());
        for weighted in sum {
            let verdict = self.test_element(&weighted.element);
            if verdict != ZeroTest::Zero {
                left.push(weighted.clone());
                verdicts.push(verdict);
            }
        }
        if left.is_empty() {
            return Knowledge::Proven;
        }
        // Without loops there is one element per product of increments.
        if left.iter().all(|weighted| weighted.element.loops.is_empty()) {
            let refuted = verdicts.into_iter().find(|verdict| matches!(verdict, ZeroTest::Nonzero(_)));
            return refuted.unwrap_or(ZeroTest::Unknown).known();
        }
        match self.sums.space.size.as_integer() {
            Some(size) => self.decide_at(&left, size),
            None => self.decide_for_all(&left),
        }
    }

    /// Decides for one size.
    fn decide_at(&mut self, sum: &Sum, size: i128) -> Knowledge {
        match self.instance(sum, size, NumberValues::Known) {
            Ok(verdict) => return verdict.known(),
            Err(NotWritten::OutOfRange) => return Knowledge::Unknown("an index is out of range".to_owned()),
            Err(NotWritten::TooLarge) => {}
        }
        if let Some(witness) = self.nonzero_derivative(sum, size, 2) {
            return Knowledge::Refuted(witness);
        }
        match self.holds_in_general(sum, size) {
            Some(true) => Knowledge::Proven,
            _ => Knowledge::Unknown(format!("it is too long to be written out for {size} points")),
        }
    }

    /// Whether the statement holds for this size because it holds for all sizes from a smaller one on.
    fn holds_in_general(&mut self, sum: &Sum, size: i128) -> Option<bool> {
        let (mut space, general) = self.sums.space.generalised(sum, size)?;
        let first = space.deciding_size(&general).filter(|&first| first < size)?;
        let mut sums = Calculus { space: &mut space, graph: self.sums.graph };
        let mut judge = Prover { sums: &mut sums, increments: self.increments, statement: self.statement };
        let mut holds =
            |size| matches!(judge.instance(&general, size, NumberValues::Free), Ok(ZeroTest::Zero));
        Some(holds(first) && holds(first + 1))
    }

    /// Decides for all sizes.
    fn decide_for_all(&mut self, sum: &Sum) -> Knowledge {
        let mut tried: Vec<String> = Vec::new();
        for size in WITNESS_SIZES {
            match self.instance(sum, size, NumberValues::Known) {
                Ok(ZeroTest::Zero) => tried.push(size.to_string()),
                Ok(verdict) => return verdict.known(),
                Err(NotWritten::OutOfRange) => {}
                Err(NotWritten::TooLarge) => break,
            }
            if tried.len() == MOST_CANCELLING_SIZES {
                break;
            }
        }
        if !tried.is_empty() && sum.iter().all(is_size_independent) {
            return Knowledge::Proven;
        }
        self.decide_by_few(sum).unwrap_or_else(|| {
            Knowledge::Unknown(match tried.is_empty() {
                true => "its indices could not be resolved".to_owned(),
                false => format!("it cancels at {} points, but no proof covers every size", tried.join(", ")),
            })
        })
    }

    /// Decides for all sizes by the few that decide the others ([`super::locality`]).
    fn decide_by_few(&mut self, sum: &Sum) -> Option<Knowledge> {
        let first = self.sums.space.deciding_size(sum)?;
        for size in 1..=first + 1 {
            match self.instance(sum, size, NumberValues::Free) {
                Ok(ZeroTest::Zero) => {}
                Err(NotWritten::OutOfRange) if size < first => {}
                // A ring of few points overlaps itself: a counterexample with free numbers counts only if
                // known numbers confirm it.
                Ok(ZeroTest::Nonzero(_)) => {
                    let verdict = self.instance(sum, size, NumberValues::Known).ok()?;
                    return matches!(verdict, ZeroTest::Nonzero(_)).then(|| verdict.known());
                }
                _ => return None,
            }
        }
        Some(Knowledge::Proven)
    }

    /// A slope of the sum, after `depth` derivatives, that is not zero.
    fn nonzero_derivative(&mut self, sum: &Sum, size: i128, depth: usize) -> Option<Witness> {
        let statement = std::mem::replace(&mut self.statement, Statement::Zero);
        let components = self.sums.space.components;
        let places = [0, 1, size / 2, size - 1].into_iter().flat_map(|point| {
            let component = (0..components.min(3)).map(move |component| point * components + component);
            component.flat_map(|place| [Half::Coordinates, Half::Momenta].map(|half| (half, place)))
        });
        let mut found = None;
        for (half, place) in places {
            let Some(slope) = self.slope(sum, half, Index::integer(place)) else { break };
            found = match self.instance(&slope, size, NumberValues::Known) {
                Ok(ZeroTest::Nonzero(witness)) => Some(witness),
                Err(NotWritten::TooLarge) if depth > 1 => self.nonzero_derivative(&slope, size, depth - 1),
                _ => None,
            };
            if found.is_some() {
                break;
            }
        }
        self.statement = statement;
        found
    }

    /// The derivative by one component of the state.
    fn slope(&mut self, sum: &Sum, half: Half, index: Index) -> Option<Sum> {
        let slot = Slot::State(half, index);
        let symbol = self.sums.space.symbol(self.sums.graph, &slot);
        let value = self.sums.graph.symbol(symbol);
        let element = Element { loops: Vec::new(), value, locals: vec![Local { symbol, slot }] };
        let unit = vec![Weighted { element, increments: Vec::new() }];
        self.sums.contract((sum, half), (&unit, half), Increments::Each)
    }

    fn instance(&mut self, sum: &Sum, size: i128, numbers: NumberValues) -> Result<ZeroTest, NotWritten> {
        let value = self.instance_value(sum, size, numbers)?;
        Ok(self.sums.graph.test_zero(value))
    }

    /// The sum at a size that is also the value of its parameter.
    fn instance_of_size(&mut self, sum: &Sum, size: i128) -> Result<ZeroTest, NotWritten> {
        let value = self.instance_value(sum, size, NumberValues::Known)?;
        let Calculus { space, graph } = &mut *self.sums;
        let known = space.size_parameter.map(|parameter| (parameter, graph.whole(size))).into_iter();
        let value = graph.substitute(&[value], &known.collect())[0];
        Ok(graph.test_zero(value))
    }

    fn instance_value(&mut self, sum: &Sum, size: i128, numbers: NumberValues) -> Result<Expr, NotWritten> {
        let Calculus { space, graph } = &mut *self.sums;
        let mut instance = Instance::new(space, size, numbers, self.increments);
        let mut value = instance.value(graph, sum, false)?;
        if self.statement == Statement::Constant {
            let other = instance.value(graph, sum, true)?;
            value = graph.subtract(value, other);
        }
        Ok(value)
    }

    fn test_element(&mut self, element: &Element) -> ZeroTest {
        let (graph, mut value) = (&mut *self.sums.graph, element.value);
        if self.statement == Statement::Constant {
            let other = element.moving().into_iter().map(|symbol| {
                let name = format!("{}'", graph.symbol_name(symbol));
                let other = graph.new_symbol_like(symbol, name);
                (symbol, graph.symbol(other))
            });
            let other: HashMap<Symbol, Expr> = other.collect();
            let other = graph.substitute(&[value], &other)[0];
            value = graph.subtract(value, other);
        }
        graph.test_zero(value)
    }
}

/// Whether no index of an element reads a size or a table.
fn is_size_independent(weighted: &Weighted) -> bool {
    let Weighted { element, increments } = weighted;
    let of_loops = element.loops.iter().flat_map(|known| [&known.start, &known.end]);
    let of_slots = element.locals.iter().flat_map(|local| local.slot.indices());
    of_loops.chain(of_slots).chain(increments).all(Index::is_closed)
}
