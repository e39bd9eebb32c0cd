//! Kicks, drifts and O parts of large systems of elements, tile by tile.

use std::ops::Range;

use super::stages::{Act, Stage};
use super::substeps::Half;
use crate::algebra::memory::Threads;
use crate::algebra::scalar::Number;
use crate::error::{StepFailure, StepPromise};
use crate::scheme::bath::OPartsByPlace;
use crate::scheme::elements::{
    ElementInput, Elements, Flow, ForceArguments, KickForm, MOST_IN_ONE_TILE, Move, NewState, Partials, Sums,
    TilePlan, Word, add_flow,
};
use crate::scheme::gauss::Field;
use crate::scheme::system::check_lengths;

/// Degrees of freedom from which paths of an ensemble are stepped one after the other: 16 paths in lanes
/// exceed the first-level cache (each of some ten lists has 128 bytes for a degree of freedom). Measured for
/// chains of 96 to 16 384 sites, both take the same time at 128 (`Baoab`) and 256 (`Verlet`).
const LEAST_SCALAR: usize = 256;

/// Degrees of freedom from which paths are stepped one after the other.
pub(crate) const fn least_scalar<F: Field>() -> usize {
    if F::FACTS.has_tiles { LEAST_SCALAR } else { usize::MAX }
}

/// Whether steps of a system of this size go tile by tile.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn takes_tiles<F: Field>(degrees: usize) -> bool {
    F::FACTS.has_tiles && degrees > MOST_IN_ONE_TILE
}

/// Tiles, and the increments of each part of a step.
#[derive(Debug, Default)]
pub(crate) struct TiledMemory {
    plan: TilePlan,
    scaled: Vec<ScaledIncrements>,
}

/// Noise increments, times the share of a part.
#[derive(Debug)]
struct ScaledIncrements {
    share: f64,
    dw: Vec<f64>,
}

/// The input of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TiledInput<'a> {
    pub(crate) t: f64,
    pub(crate) h: f64,
    /// As of [`KickDriftFlows`](super::flows::FlowsOf).
    pub(crate) stretch: f64,
    pub(crate) q: &'a [f64],
    pub(crate) p: &'a [f64],
    /// The rounding errors of both before the step; empty for plain sums.
    pub(crate) lost: [&'a [f64]; 2],
    pub(crate) dw: &'a [f64],
}

impl TiledMemory {
    /// Goes tile by tile on this many threads:
    /// [`MemoryRequest::Share`](crate::algebra::memory::MemoryRequest::Share).
    pub(crate) fn share(&mut self, threads: Threads) {
        self.plan.share(threads);
    }

    /// A memory for the same threads, without tiles yet.
    pub(crate) fn alike(&self) -> Self {
        Self { plan: self.plan.alike(), scaled: Vec::new() }
    }

    /// Takes all parts of a step; O parts, which `RELAXES` says are there, by `relaxing`. It is no closure,
    /// since what is not inlined does not get the instructions of the machine. Allocates in the first step
    /// only.
    ///
    /// # Errors
    /// If sizes do not fit, or the new state is not finite.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn take_parts_in_tiles<'m, F: Field, const RELAXES: bool, const CARRIES: bool>(
        &'m mut self,
        system: &F,
        stages: &[Stage<Act>],
        givens: TiledInput<'_>,
        relaxing: Option<OPartsByPlace<'_>>,
    ) -> Result<NewState<'m>, StepFailure> {
        let TiledInput { t, h, stretch, q, p, lost, dw } = givens;
        let degrees = q.len();
        debug_assert_eq!(relaxing.is_some(), RELAXES, "O parts have a bath");
        check_lengths(system, self.plan.degrees() == Some(degrees), [degrees, p.len(), dw.len()])?;
        self.scale(stages, dw);
        let Self { plan, scaled } = self;
        let reads_time = F::FORCE_READS_TIME;
        let mut word =
            TiledWord::<RELAXES, CARRIES> { t, h, stretch, stages, scaled, reads_time, lost, relaxing };
        let missing = Err(StepFailure::Internal(StepPromise::Tiles));
        system.take_tiles(&mut word, q, p, plan).unwrap_or(missing)
    }

    fn scale(&mut self, stages: &[Stage<Act>], dw: &[f64]) {
        if dw.is_empty() {
            return;
        }
        for stage in stages {
            if !self.scaled.iter().any(|scaled| scaled.share == stage.share) {
                self.scaled.push(ScaledIncrements { share: stage.share, dw: Vec::new() });
            }
        }
        for ScaledIncrements { share, dw: scaled } in &mut self.scaled {
            scaled.clear();
            scaled.extend(dw.iter().map(|dw| dw * *share));
        }
    }
}

/// The parts of a step: kicks, drifts and, if it `RELAXES`, O parts; with compensated sums if it `CARRIES`.
#[derive(Clone, Copy)]
struct TiledWord<'a, const RELAXES: bool, const CARRIES: bool> {
    t: f64,
    h: f64,
    stretch: f64,
    stages: &'a [Stage<Act>],
    scaled: &'a [ScaledIncrements],
    reads_time: bool,
    lost: [&'a [f64]; 2],
    relaxing: Option<OPartsByPlace<'a>>,
}

impl<const RELAXES: bool, const CARRIES: bool> TiledWord<'_, RELAXES, CARRIES> {
    /// The flow of a kick or a drift.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn flow(&self, number: usize) -> Flow<'_, f64> {
        let &Stage { share, node, .. } = &self.stages[number];
        let dw = self.scaled.iter().find(|scaled| scaled.share == share).map_or(&[][..], |scaled| &scaled.dw);
        Flow { t: self.t + node * self.h, h: self.stretch * share * self.h, parameters: &[], dw }
    }
}

impl<const RELAXES: bool, const CARRIES: bool> Word for TiledWord<'_, RELAXES, CARRIES> {
    const CHANGES: bool = RELAXES;
    const CARRIES: bool = CARRIES;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn count(&self) -> usize {
        self.stages.len()
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn kind(&self, number: usize) -> Move {
        let stage = &self.stages[number];
        match stage.act {
            Act::Flow(Half::First) => Move::Drift,
            Act::Relax(_) => Move::Momenta,
            Act::RelaxBetween(_) => Move::State,
            Act::Flow(Half::Second) | Act::Square(_) if stage.is_end => Move::Kick(KickForm::Plus),
            Act::Flow(Half::Second) | Act::Square(_) => Move::Kick(KickForm::Terms),
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn origin(&self, number: usize) -> Option<ForceArguments> {
        let Flow { t, h, dw, .. } = self.flow(number);
        let is_kept = self.stages[number].is_end && dw.is_empty();
        is_kept.then(|| ForceArguments { t: self.reads_time.then_some(t), h })
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add_gradient<H, T, V, A>(&self, system: &H, number: usize, state: &V, wanted: Partials, into: &mut A)
    where
        H: Elements + Sync,
        T: Number<f64>,
        V: ElementInput<f64> + ?Sized,
        A: Sums<f64>,
    {
        add_flow::<H, f64, T, V, A>(system, self.flow(number), state, wanted, into);
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lost(&self) -> [&[f64]; 2] {
        self.lost
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn change_momenta(&self, number: usize, places: Range<usize>, p: &mut [f64], lost: &mut [f64]) {
        if let (Act::Relax(part), Some(relaxing)) = (self.stages[number].act, &self.relaxing) {
            relaxing.apply::<CARRIES>(part, places, None, p, lost);
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn change_state(&self, number: usize, places: Range<usize>, q: &mut [f64], p: &mut [f64]) {
        let &Stage { act, weight, .. } = &self.stages[number];
        if let (Act::RelaxBetween(part), Some(relaxing)) = (act, &self.relaxing) {
            relaxing.apply::<false>(part, places, Some((self.stretch * weight * self.h, q)), p, &mut []);
        }
    }
}
