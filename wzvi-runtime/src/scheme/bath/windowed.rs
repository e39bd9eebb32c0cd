//! Kicks, drifts and O parts of large systems of elements, window by window.

use std::ops::Range;

use super::part::ByPlace;
use super::splitting::Letters;
use crate::scheme::compose::stages::Stage;
use crate::scheme::compose::windowed::KicksAndDrifts;
use crate::scheme::elements::{Letter, Word};

/// Parts of a step of a word, at most: its flows, and O parts before, between and behind them.
const MOST: usize = 8;

/// What a part of a step is.
#[derive(Clone, Copy, Debug)]
enum Part {
    /// A kick or a drift, by its number.
    Flow(usize),
    /// An O part, by its number.
    Relax(usize),
    /// An O part between two drifts over a time.
    RelaxBetween(usize, f64),
}

/// A word of kicks, drifts and O parts.
#[derive(Debug)]
pub(super) struct WithBath<'m> {
    flows: KicksAndDrifts<'m>,
    relaxing: ByPlace<'m>,
    parts: [Part; MOST],
    count: usize,
}

impl<'m> WithBath<'m> {
    /// The word `W` in steps of size `h`, with these kicks and drifts.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn new<W: Letters>(
        flows: KicksAndDrifts<'m>,
        relaxing: ByPlace<'m>,
        stages: &[Stage],
        h: f64,
    ) -> Self {
        let mut word = Self { flows, relaxing, parts: [Part::Flow(0); MOST], count: 0 };
        let relaxes_before =
            |flow: usize| W::SPELLING.relaxes_before().iter().position(|&before| before == flow);
        let mut flow = 0;
        while flow < W::SPELLING.flows().len() {
            if let Some(part) = relaxes_before(flow) {
                word.push(Part::Relax(part));
            }
            // Lists of masses say what a drift is, unless a noise drifts too.
            match relaxes_before(flow + 1) {
                Some(part) if W::SPELLING.drifts_around == Some(flow) && !flows.have_noise() => {
                    word.push(Part::RelaxBetween(part, stages[flow].weight * h));
                    flow += 2;
                }
                _ => {
                    word.push(Part::Flow(flow));
                    flow += 1;
                }
            }
        }
        if let Some(part) = relaxes_before(flow) {
            word.push(Part::Relax(part));
        }
        word
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn push(&mut self, part: Part) {
        self.parts[self.count] = part;
        self.count += 1;
    }

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
        let Self { flows, relaxing, parts, count } = self;
        relaxing.divide(place).map(|relaxing| Self { flows, relaxing, parts, count })
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn count(&self) -> usize {
        self.count
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
        if let Part::RelaxBetween(part, time) = self.parts[number] {
            self.relaxing.apply(part, places, Some((time, q)), p);
        }
    }
}
