//! Crossings of one path of an ensemble: of the sections of the run, each of which counts, and of its events,
//! whose first one is a passage.
//!
//! Sections are looked for inside steps. So are the events of paths without noise, which are smooth there.
//! With noise, a path inside a step is not what dense output says, and events are looked for at the nodes
//! alone.
//!
//! Tested by `tests/paths/between/ensembles.rs` and `tests/ensembles/statistics.rs`.

use super::job::EnsembleJob;
use crate::algebra::state::{State, Vector};
use crate::scheme::constraints::put_on;
use crate::scheme::dense::DenseOutput;
use crate::scheme::system::Discretized;
use crate::statistics::{Passage, Seen, Statistics};
use crate::trajectory::section::{Crossing, SectionWatch};

/// Follows one path past the zeros of the functions of a run, sections first, then events.
pub(super) struct PathCrossings<V> {
    watch: SectionWatch<V>,
    /// Crossings so far, by section.
    counts: Vec<u64>,
    /// The time of the first crossing, by event; NaN before.
    passed: Vec<f64>,
}

impl<V: Vector> PathCrossings<V> {
    pub(super) fn new<H: Discretized<E, Vector = V>, E>(job: &EnsembleJob<'_, H, E>) -> Self {
        Self {
            watch: SectionWatch::new(job.crossed.functions(), &job.starts.first),
            counts: vec![0; job.crossed.sections.len()],
            passed: vec![f64::NAN; job.crossed.events.len()],
        }
    }

    /// Begins another path.
    pub(super) fn begin<H: Discretized<E, Vector = V>, E>(
        &mut self,
        job: &EnsembleJob<'_, H, E>,
        start: &State<V>,
    ) {
        self.watch.begin(job.crossed.functions(), start);
        self.counts.fill(0);
        self.passed.fill(f64::NAN);
    }

    /// The number of functions that are still looked for inside steps, the first ones of all.
    pub(super) fn looked_for_inside<H: Discretized<E, Vector = V>, E>(
        &self,
        job: &EnsembleJob<'_, H, E>,
    ) -> usize {
        let waits = !job.has_passages_at_nodes() && self.passed.iter().any(|passed| passed.is_nan());
        job.crossed.sections.len() + if waits { job.crossed.events.len() } else { 0 }
    }

    /// Looks into a step, or a part of it, for the first `number` functions.
    pub(super) fn look_inside<H: Discretized<E, Vector = V>, E>(
        &mut self,
        job: &EnsembleJob<'_, H, E>,
        number: usize,
        dense: &DenseOutput<V>,
        path: u64,
        statistics: &mut Statistics,
    ) {
        let Self { watch, counts, passed } = self;
        watch.follow(job.crossed.functions().take(number), dense, &mut |mut crossing, _| {
            if let Some(event) = crossing.section.checked_sub(counts.len()) {
                if passed[event].is_nan() {
                    passed[event] = crossing.state.t;
                }
            } else if job.crossed.sections.want(&crossing) {
                put_on(job.systems.of(path).manifold(), &mut crossing.state);
                let Crossing { section, direction, state } = crossing;
                let (before, t) = (counts[section], state.t);
                let (q, p) = (state.q.components(), state.p.components());
                statistics.see(path, &Seen::Crossing { section, before, direction, t, q, p });
                counts[section] += 1;
            }
        });
    }

    /// Looks for the events of the step between these times that ended in this state, at its nodes alone.
    pub(super) fn look_at_node<H: Discretized<E, Vector = V>, E>(
        &mut self,
        job: &EnsembleJob<'_, H, E>,
        times: [f64; 2],
        state: &State<V>,
    ) {
        let Self { watch, counts, passed } = self;
        for ((event, function), passed) in job.crossed.events.iter().enumerate().zip(passed) {
            if passed.is_nan() {
                *passed = watch.arrive(counts.len() + event, function, times, state).unwrap_or(f64::NAN);
            }
        }
    }

    /// When an event happened, of a path that has ended, where it failed after a last node at a time.
    pub(super) fn passage(&self, event: usize, failed: Option<f64>) -> Passage {
        match (self.passed[event], failed) {
            (time, _) if !time.is_nan() => Passage::At(time),
            (_, Some(time)) => Passage::Lost(time),
            (_, None) => Passage::Censored,
        }
    }

    /// How often the path crossed a section.
    pub(super) fn count(&self, section: usize) -> u64 {
        self.counts[section]
    }
}
