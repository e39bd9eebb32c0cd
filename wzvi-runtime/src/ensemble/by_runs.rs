//! Paths as runs of their own, one after the other: those by a clock, which have no common nodes, and those
//! with events.

use std::ops::Range;

use super::chunk::ChunkResults;
use super::job::EnsembleJob;
use crate::algebra::state::Vector;
use crate::scheme::system::Discretized;
use crate::statistics::{Seen, Statistics};
use crate::trajectory::Error;
use crate::trajectory::recorded::Trajectory;
use crate::trajectory::section::Crossing;
use crate::trajectory::simulate::{Partial, Simulation};
use crate::trajectory::span::NodeGrid;

impl<H: Discretized<E>, E> EnsembleJob<'_, H, E> {
    /// A path as a run of its own, recorded at these times between its ends, and `every` so many steps (0 for
    /// never).
    ///
    /// # Errors
    /// The errors that end the ensemble; an error that ends the path alone is in the result.
    pub(super) fn run_of(
        &self,
        path: u64,
        every: u64,
        times: impl IntoIterator<Item = f64>,
    ) -> Result<Partial<H::Vector, E>, Error> {
        let (start, system) = (self.start_of(path)?, self.systems.of(path));
        let NodeGrid { h, steps, end, is_clocked, .. } = self.grid;
        let size = if is_clocked { h.abs() } else { h };
        let mut noise = self.source.path(path);
        let run = Simulation::<H, E>::new(system, size).noise(&mut *noise).plain_sums();
        let run = run.start(start).record_every(every).record_at(times).threads(1).quiet();
        let run = if let Some(end) = end { run.until(end) } else { run.steps(steps) };
        let run = if self.is_watched { run } else { run.unwatched() };
        let run = run.acting(&self.acting).crossing(&self.crossed.sections);
        let (path, _) = run.run_until(Some(self.stop))?;
        match path {
            (_, Some(error)) if !matches!(error, Error::Step(_)) => Err(error),
            path => Ok(path),
        }
    }

    /// The statistics of chunks of paths.
    pub(super) fn chunks_by_runs(&self, chunks: Range<u64>) -> ChunkResults {
        let mut found = ChunkResults::new();
        for chunk in chunks {
            let paths = chunk * self.chunk..self.paths.min((chunk + 1) * self.chunk);
            found.push(self.statistics_by_runs(paths));
            if found.last().is_some_and(Result::is_err) {
                break;
            }
        }
        found
    }

    fn statistics_by_runs(&self, paths: Range<u64>) -> Result<Statistics, Error> {
        let mut statistics = self.observed.empty.clone();
        for path in paths {
            self.see_run(path, &mut statistics)?;
        }
        Ok(statistics)
    }

    /// Adds one path to the statistics.
    fn see_run(&self, path: u64, statistics: &mut Statistics) -> Result<(), Error> {
        let recorded = &self.observed.recorded;
        let between = recorded.get(1..recorded.len().saturating_sub(1)).unwrap_or_default();
        let (run, error) = self.run_of(path, 0, between.iter().map(|recorded| recorded.t))?;
        let mut values = vec![0.0; self.observed.observables.len()];
        let (sign, end) = (self.grid.h.signum(), run.last().t);
        for (node, recorded) in recorded.iter().enumerate() {
            let is_past = sign * (recorded.t - end) > 0.0;
            if is_past && error.is_some() {
                statistics.see(path, &Seen::Lost { node });
                continue;
            }
            // A path that an event has ended stays where it is.
            let state = run.states().get(node).filter(|_| !is_past).unwrap_or(run.last());
            if let Some(see) = &self.observed.inspector {
                see(path, state);
            }
            self.observe(path, state, &mut values);
            statistics.see(path, &Seen::Values { node, values: &values });
        }
        self.see_crossings(path, &run, statistics);
        if let Some(Error::Step(error)) = error {
            statistics.see(path, &Seen::Failure(error));
        }
        Ok(())
    }

    fn see_crossings(&self, path: u64, run: &Trajectory<H::Vector, E>, statistics: &mut Statistics) {
        let mut counts = vec![0; self.crossed.sections.len()];
        for Crossing { section, direction, state } in run.crossings() {
            let (before, direction, t) = (counts[*section], *direction, state.t);
            let (q, p) = (state.q.components(), state.p.components());
            statistics.see(path, &Seen::Crossing { section: *section, before, direction, t, q, p });
            counts[*section] += 1;
        }
        for (section, count) in counts.into_iter().enumerate() {
            statistics.see(path, &Seen::Crossings { section, count });
        }
    }
}
