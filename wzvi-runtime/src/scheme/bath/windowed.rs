//! Kicks, drifts and O parts of large systems of elements, window by window.

use std::ops::Range;

use super::part::ByPlace;
use super::word::Act;
use crate::algebra::scalar::Number;
use crate::scheme::compose::windowed::FlowList;
use crate::scheme::elements::{Elements, Given, Move, Origin, Slopes, Sums, Word, add_flow};

/// A word of kicks, drifts and O parts.
#[derive(Clone, Copy, Debug)]
pub(super) struct WithBath<'m> {
    pub(super) flows: FlowList<'m, Act>,
    pub(super) relaxing: ByPlace<'m>,
}

impl Word for WithBath<'_> {
    const CHANGES: bool = true;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn count(&self) -> usize {
        self.flows.stages().len()
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn kind(&self, number: usize) -> Move {
        match self.flows.stages()[number].act {
            Act::Flow(half) => self.flows.kind(number, half),
            Act::Relax(_) => Move::Momenta,
            Act::RelaxBetween(_) => Move::State,
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn origin(&self, number: usize) -> Option<Origin> {
        self.flows.origin(number)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add_slopes<H, T, V, A>(&self, system: &H, number: usize, state: &V, wanted: Slopes, into: &mut A)
    where
        H: Elements + Sync,
        T: Number<f64>,
        V: Given<f64> + ?Sized,
        A: Sums<f64>,
    {
        add_flow::<H, f64, T, V, A>(system, self.flows.flow(number), state, wanted, into);
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn change_momenta(&self, number: usize, places: Range<usize>, p: &mut [f64]) {
        if let Act::Relax(part) = self.flows.stages()[number].act {
            self.relaxing.apply(part, places, None, p);
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn change_state(&self, number: usize, places: Range<usize>, q: &mut [f64], p: &mut [f64]) {
        let stage = &self.flows.stages()[number];
        if let Act::RelaxBetween(part) = stage.act {
            self.relaxing.apply(part, places, Some((self.flows.time(stage), q)), p);
        }
    }
}
