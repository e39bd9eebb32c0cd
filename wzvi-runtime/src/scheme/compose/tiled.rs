//! Kicks, drifts and O parts of large systems of elements, tile by tile.

use std::ops::Range;

use crate::algebra::memory::Threads;
use crate::algebra::scalar::Number;
use crate::error::{StepFailure, StepPromise};
use crate::scheme::bath::OPartsByPlace;
use crate::scheme::elements::{
    ElementInput, Elements, Flow, ForceArguments, MOST_IN_ONE_TILE, NewState, Partials, Sums, TileParts,
    TilePlan, add_flow,
};
use crate::scheme::gauss::Field;
use crate::scheme::system::check_lengths;
use crate::scheme::word::{Part, Substep, Word};

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
        word: &Word,
        givens: TiledInput<'_>,
        relaxing: Option<OPartsByPlace<'_>>,
    ) -> Result<NewState<'m>, StepFailure> {
        let TiledInput { t, h, stretch, q, p, lost, dw } = givens;
        let degrees = q.len();
        debug_assert_eq!(relaxing.is_some(), RELAXES, "O parts have a bath");
        check_lengths(system, self.plan.degrees() == Some(degrees), [degrees, p.len(), dw.len()])?;
        self.scale(word, dw);
        let Self { plan, scaled } = self;
        let reads_time = F::FORCE_READS_TIME;
        let substeps = &word.substeps[..];
        let mut parts =
            FlowsInTiles::<RELAXES, CARRIES> { t, h, stretch, substeps, scaled, reads_time, lost, relaxing };
        let missing = Err(StepFailure::Internal(StepPromise::Tiles));
        system.take_tiles(&mut parts, q, p, plan).unwrap_or(missing)
    }

    fn scale(&mut self, word: &Word, dw: &[f64]) {
        if dw.is_empty() {
            return;
        }
        for &Substep { share, .. } in &word.substeps {
            if !self.scaled.iter().any(|scaled| scaled.share == share) {
                self.scaled.push(ScaledIncrements { share, dw: Vec::new() });
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
struct FlowsInTiles<'a, const RELAXES: bool, const CARRIES: bool> {
    t: f64,
    h: f64,
    stretch: f64,
    substeps: &'a [Substep],
    scaled: &'a [ScaledIncrements],
    reads_time: bool,
    lost: [&'a [f64]; 2],
    relaxing: Option<OPartsByPlace<'a>>,
}

impl<const RELAXES: bool, const CARRIES: bool> FlowsInTiles<'_, RELAXES, CARRIES> {
    /// The flow of a kick or a drift.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn flow(&self, &Substep { share, node, .. }: &Substep) -> Flow<'_, f64> {
        let dw = self.scaled.iter().find(|scaled| scaled.share == share).map_or(&[][..], |scaled| &scaled.dw);
        Flow { t: self.t + node * self.h, h: self.stretch * share * self.h, parameters: &[], dw }
    }
}

impl<const RELAXES: bool, const CARRIES: bool> TileParts for FlowsInTiles<'_, RELAXES, CARRIES> {
    const RELAXES: bool = RELAXES;
    const CARRIES: bool = CARRIES;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn substeps(&self) -> &[Substep] {
        self.substeps
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn origin(&self, kick: &Substep) -> Option<ForceArguments> {
        let Flow { t, h, dw, .. } = self.flow(kick);
        let is_kept = kick.force.is_at_end() && dw.is_empty();
        is_kept.then(|| ForceArguments { t: self.reads_time.then_some(t), h })
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add_gradient<H, T, V, A>(&self, system: &H, flow: &Substep, state: &V, wanted: Partials, into: &mut A)
    where
        H: Elements + Sync,
        T: Number<f64>,
        V: ElementInput<f64> + ?Sized,
        A: Sums<f64>,
    {
        add_flow::<H, f64, T, V, A>(system, self.flow(flow), state, wanted, into);
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lost(&self) -> [&[f64]; 2] {
        self.lost
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn relax(
        &self,
        &Substep { part, weight, number, .. }: &Substep,
        places: Range<usize>,
        q: &mut [f64],
        p: &mut [f64],
        lost: &mut [f64],
    ) {
        match (part, &self.relaxing) {
            (Part::O, Some(relaxing)) => relaxing.apply::<CARRIES>(number, places, None, p, lost),
            (Part::AOA, Some(relaxing)) => {
                relaxing.apply::<false>(
                    number,
                    places,
                    Some((self.stretch * weight * self.h, q)),
                    p,
                    &mut [],
                );
            }
            _ => {}
        }
    }
}
