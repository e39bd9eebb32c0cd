//! Kicks, drifts and O parts of large systems of elements, window by window.

use std::ops::Range;

use super::part::ByPlace;
use super::splitting::Letters;
use crate::scheme::compose::stages::Stage;
use crate::scheme::compose::windowed::KicksAndDrifts;
use crate::scheme::elements::{Letter, Word};

/// What a part of a step is.
#[derive(Clone, Copy, Debug)]
pub(super) enum Part {
    /// A kick or a drift, by its number.
    Flow(usize),
    /// An O part, by its number.
    Relax(usize),
    /// An O part between two drifts, each over a fraction of the step.
    RelaxBetween(usize, f64),
}

/// All parts of a step of a word; where `joins`, with an O part between two drifts as one.
pub(super) fn parts<W: Letters>(stages: &[Stage], joins: bool) -> Vec<Part> {
    let relaxes_before = |flow: usize| W::SPELLING.relaxes_before().iter().position(|&before| before == flow);
    let (mut parts, mut flow) = (Vec::new(), 0);
    while let Some(stage) = stages.get(flow) {
        parts.extend(relaxes_before(flow).map(Part::Relax));
        // Lists of masses say what a drift is, unless a noise drifts too.
        match relaxes_before(flow + 1) {
            Some(part) if joins && W::SPELLING.drifts_around == Some(flow) => {
                parts.push(Part::RelaxBetween(part, stage.weight));
                flow += 2;
            }
            _ => {
                parts.push(Part::Flow(flow));
                flow += 1;
            }
        }
    }
    parts.extend(relaxes_before(flow).map(Part::Relax));
    parts
}

/// A word of kicks, drifts and O parts.
#[derive(Debug)]
pub(super) struct WithBath<'m> {
    pub(super) flows: KicksAndDrifts<'m>,
    pub(super) relaxing: ByPlace<'m>,
    pub(super) parts: &'m [Part],
}

impl WithBath<'_> {
    /// The heat of the step.
    pub(super) fn heat(&self) -> f64 {
        self.relaxing.heat()
    }
}

impl Word for WithBath<'_> {
    type Share<'s>
        = WithBath<'s>
    where
        Self: 's;
    const CHANGES: bool = true;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn share(&mut self) -> WithBath<'_> {
        WithBath { relaxing: self.relaxing.lend(), ..*self }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn divide(self, place: usize) -> [Self; 2] {
        let Self { flows, relaxing, parts } = self;
        relaxing.divide(place).map(|relaxing| Self { flows, relaxing, parts })
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn count(&self) -> usize {
        self.parts.len()
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn letter(&self, number: usize) -> Letter<'_> {
        match self.parts[number] {
            Part::Flow(flow) => self.flows.letter(flow),
            Part::Relax(_) => Letter::Momenta,
            Part::RelaxBetween(..) => Letter::State,
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn change_momenta(&mut self, number: usize, places: Range<usize>, p: &mut [f64]) {
        if let Part::Relax(part) = self.parts[number] {
            self.relaxing.apply(part, places, None, p);
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn change_state(&mut self, number: usize, places: Range<usize>, q: &mut [f64], p: &mut [f64]) {
        if let Part::RelaxBetween(part, weight) = self.parts[number] {
            self.relaxing.apply(part, places, Some((weight * self.flows.step_size(), q)), p);
        }
    }
}
