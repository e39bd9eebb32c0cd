//! Kicks and drifts of large systems of elements, window by window.

use super::flows::Act;
use super::stages::Stage;
use super::substeps::Half;
use crate::algebra::memory::Threads;
use crate::algebra::scalar::Number;
use crate::error::{StepFailure, StepPromise};
use crate::scheme::elements::{
    Elements, Flow, Given, Kick, LEAST_IN_WINDOWS, Move, Origin, Slopes, Sums, Taken, WindowPlan, Word,
    add_flow,
};
use crate::scheme::gauss::Field;
use crate::scheme::system::{Hamiltonian as _, check_lengths, fits};

/// Degrees of freedom from which paths of an ensemble are stepped one after the other, window by window. A step in windows has an overhead
/// of some 150 ns, and 16 paths in lanes exceed the first-level cache (each of some ten lists has 128 bytes for a degree of freedom).
/// Measured for chains of 96 to 16 384 sites, both take the same time at 128 (`Baoab`) and 256 (`Verlet`).
const LEAST_ALONE: usize = 256;

/// Degrees of freedom from which paths are stepped one after the other.
pub(crate) const fn least_alone<F: Field>() -> usize {
    if F::FACTS.has_windows { LEAST_ALONE } else { usize::MAX }
}

/// Whether steps of a system of this size go window by window.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn takes_windows<F: Field>(degrees: usize) -> bool {
    F::FACTS.has_windows && degrees >= LEAST_IN_WINDOWS
}

/// Windows, and the increments of each part of a step.
#[derive(Debug, Default)]
pub(crate) struct Memory {
    plan: WindowPlan,
    scaled: Vec<Scaled>,
}

/// Noise increments, times the share of a part.
#[derive(Debug)]
struct Scaled {
    share: f64,
    dw: Vec<f64>,
}

/// The input of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Givens<'a> {
    pub(crate) t: f64,
    pub(crate) h: f64,
    /// As of [`FlowsOf`](super::flows::FlowsOf).
    pub(crate) stretch: f64,
    pub(crate) q: &'a [f64],
    pub(crate) p: &'a [f64],
    pub(crate) dw: &'a [f64],
}

impl Memory {
    /// Goes window by window on this many threads: [`Request::Share`](crate::algebra::memory::Request::Share).
    pub(crate) fn share(&mut self, threads: Threads) {
        self.plan.share(threads);
    }

    /// A memory for the same threads, without windows yet.
    pub(crate) fn alike(&self) -> Self {
        Self { plan: self.plan.alike(), scaled: Vec::new() }
    }

    /// Takes all parts of a step, which `word` makes from the kicks and drifts and any moves between them. Allocates in the first step only.
    ///
    /// # Errors
    /// If sizes do not fit, or the new state is not finite.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn advance<'m, F: Field, W: Word, A>(
        &'m mut self,
        system: &F,
        stages: &'m [Stage<A>],
        givens: Givens<'_>,
        word: impl FnOnce(FlowList<'m, A>) -> W,
    ) -> Result<(Taken<'m>, W), StepFailure> {
        let Givens { t, h, stretch, q, p, dw } = givens;
        let degrees = q.len();
        if self.plan.degrees() != Some(degrees) || !fits(system, degrees) {
            system.check(degrees)?;
        }
        check_lengths(system, [degrees, p.len(), dw.len()])?;
        self.scale(stages, dw);
        let Self { plan, scaled } = self;
        let mut word = word(FlowList { t, h, stretch, stages, scaled, reads_time: F::FORCE_READS_TIME });
        let missing = Err(StepFailure::Internal(StepPromise::Windows));
        let taken = system.take_windows(&mut word, q, p, plan).unwrap_or(missing)?;
        Ok((taken, word))
    }

    fn scale<A>(&mut self, stages: &[Stage<A>], dw: &[f64]) {
        if dw.is_empty() {
            return;
        }
        for stage in stages {
            if !self.scaled.iter().any(|scaled| scaled.share == stage.share) {
                self.scaled.push(Scaled { share: stage.share, dw: Vec::new() });
            }
        }
        for Scaled { share, dw: scaled } in &mut self.scaled {
            scaled.clear();
            scaled.extend(dw.iter().map(|dw| dw * *share));
        }
    }
}

/// The parts of a step, kicks and drifts among them.
#[derive(Debug)]
pub(crate) struct FlowList<'a, A> {
    t: f64,
    h: f64,
    stretch: f64,
    stages: &'a [Stage<A>],
    scaled: &'a [Scaled],
    reads_time: bool,
}

impl<A> Clone for FlowList<'_, A> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<A> Copy for FlowList<'_, A> {}

impl<'a, A> FlowList<'a, A> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn stages(&self) -> &'a [Stage<A>] {
        self.stages
    }

    /// The time step of a part.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn time(&self, stage: &Stage<A>) -> f64 {
        self.stretch * stage.weight * self.h
    }

    /// The move of a kick or a drift.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn kind(&self, number: usize, half: Half) -> Move {
        match half {
            Half::First => Move::Drift,
            Half::Second if self.stages[number].is_end => Move::Kick(Kick::Plus),
            Half::Second => Move::Kick(Kick::Terms),
        }
    }

    /// The flow of a kick or a drift.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn flow(&self, number: usize) -> Flow<'a, f64> {
        let &Stage { share, node, .. } = &self.stages[number];
        let dw = self.scaled.iter().find(|scaled| scaled.share == share).map_or(&[][..], |scaled| &scaled.dw);
        Flow { t: self.t + node * self.h, h: self.stretch * share * self.h, parameters: &[], dw }
    }

    /// As [`Word::origin`].
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn origin(&self, number: usize) -> Option<Origin> {
        let Flow { t, h, dw, .. } = self.flow(number);
        let is_kept = self.stages[number].is_end && dw.is_empty();
        is_kept.then(|| Origin { t: self.reads_time.then_some(t), h })
    }
}

impl Word for FlowList<'_, Act> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn count(&self) -> usize {
        self.stages.len()
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn kind(&self, number: usize) -> Move {
        Self::kind(self, number, self.stages[number].act.0)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn origin(&self, number: usize) -> Option<Origin> {
        Self::origin(self, number)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add_slopes<H, T, V, A>(&self, system: &H, number: usize, state: &V, wanted: Slopes, into: &mut A)
    where
        H: Elements + Sync,
        T: Number<f64>,
        V: Given<f64> + ?Sized,
        A: Sums<f64>,
    {
        add_flow::<H, f64, T, V, A>(system, self.flow(number), state, wanted, into);
    }
}
