//! Kicks and drifts of large systems of elements, window by window.

use super::flows::Flows;
use super::stages::Stage;
use super::substeps::Half;
use crate::algebra::memory::Threads;
use crate::error::{StepFailure, StepPromise};
use crate::scheme::elements::{Flow, LEAST_IN_WINDOWS, Letter, Origin, Taken, WindowPlan, Word};
use crate::scheme::system::{Hamiltonian as _, fits};

/// Degrees of freedom from which paths of an ensemble go one after the other, window by window. A step of a word in windows takes some 150 ns
/// besides what each site takes, and 16 paths beside each other leave the first cache (each of some ten lists has 128 bytes for a degree of
/// freedom): measured for chains of 96 to 16 384 sites, both take the same time at 128 (`Baoab`) and 256 (`Verlet`).
const LEAST_ALONE: usize = 256;

/// From how many degrees of freedom on paths go one after the other.
pub(crate) const fn least_alone<F: Flows>() -> usize {
    if F::FACTS.has_windows { LEAST_ALONE } else { usize::MAX }
}

/// Whether steps of so many degrees of freedom go window by window.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn takes_windows<F: Flows>(degrees: usize) -> bool {
    F::FACTS.has_windows && degrees >= LEAST_IN_WINDOWS
}

/// Windows, and the increments of each part of a step.
#[derive(Debug, Default)]
pub(crate) struct Memory {
    plan: WindowPlan,
    scaled: Vec<Scaled>,
}

/// Increments, times the share of a part.
#[derive(Debug)]
struct Scaled {
    share: f64,
    dw: Vec<f64>,
}

/// The givens of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Givens<'a> {
    pub(crate) t: f64,
    pub(crate) h: f64,
    pub(crate) q: &'a [f64],
    pub(crate) p: &'a [f64],
    pub(crate) dw: &'a [f64],
}

impl Memory {
    /// What [`StepMemory::share`](crate::algebra::memory::StepMemory::share) says.
    pub(crate) fn share(&mut self, threads: Threads) {
        self.plan.share(threads);
    }

    /// One for as many threads.
    pub(crate) fn alike(&self) -> Self {
        Self { plan: self.plan.alike(), scaled: Vec::new() }
    }

    /// All parts of a step; `word` makes them, with whatever is between, of the kicks and drifts. Allocates in the first step only.
    ///
    /// # Errors
    /// Where sizes do not fit, or the new state is not finite.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn advance<'m, F: Flows, W: Word>(
        &'m mut self,
        system: &F,
        stages: &'m [Stage],
        givens: Givens<'_>,
        word: impl FnOnce(KicksAndDrifts<'m>) -> W,
    ) -> Result<(Taken<'m>, W), StepFailure> {
        let Givens { t, h, q, p, dw } = givens;
        let degrees = q.len();
        if self.plan.degrees() != Some(degrees) || !fits(system, degrees) {
            system.check(degrees)?;
        }
        if p.len() != degrees {
            return Err(StepFailure::Dimension { expected: degrees, got: p.len() });
        }
        if dw.len() != system.noises() {
            return Err(StepFailure::Increments { expected: system.noises(), got: dw.len() });
        }
        self.scale(stages, dw);
        let Self { plan, scaled } = self;
        let mut word = word(KicksAndDrifts { t, h, stages, scaled, reads_time: F::FORCE_READS_TIME });
        let missing = Err(StepFailure::Internal(StepPromise::Windows));
        let taken = system.take_windows(&mut word, q, p, plan).unwrap_or(missing)?;
        Ok((taken, word))
    }

    fn scale(&mut self, stages: &[Stage], dw: &[f64]) {
        if dw.is_empty() {
            return;
        }
        for stage in stages {
            if !self.scaled.iter().any(|scaled| scaled.share == stage.share()) {
                self.scaled.push(Scaled { share: stage.share(), dw: Vec::new() });
            }
        }
        for Scaled { share, dw: scaled } in &mut self.scaled {
            scaled.clear();
            scaled.extend(dw.iter().map(|dw| dw * *share));
        }
    }
}

/// The kicks and drifts of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct KicksAndDrifts<'a> {
    t: f64,
    h: f64,
    stages: &'a [Stage],
    scaled: &'a [Scaled],
    reads_time: bool,
}

impl KicksAndDrifts<'_> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn step_size(&self) -> f64 {
        self.h
    }
}

impl Word for KicksAndDrifts<'_> {
    type Share<'s>
        = Self
    where
        Self: 's;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn share(&mut self) -> Self {
        *self
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn divide(self, _: usize) -> [Self; 2] {
        [self; 2]
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn count(&self) -> usize {
        self.stages.len()
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn letter(&self, number: usize) -> Letter<'_> {
        let stage = &self.stages[number];
        let share = stage.share();
        let dw = self.scaled.iter().find(|scaled| scaled.share == share).map_or(&[][..], |scaled| &scaled.dw);
        let h = share * self.h;
        match stage.half {
            Half::First => Letter::Drift(Flow { t: self.t, h, dw }),
            Half::Second => {
                let t = self.t + stage.node * self.h;
                let origin = Origin { t: self.reads_time.then_some(t), h };
                let flow = Flow { t, h, dw };
                match number == 0 || number + 1 == self.stages.len() {
                    true => Letter::KickAtEnd(flow, dw.is_empty().then_some(origin)),
                    false => Letter::Kick(flow),
                }
            }
        }
    }
}
