//! The energy of each path of a group is monitored as if it were alone ([`EnergyMonitor`]).

use super::halving::Halving;
use super::paths::LanePaths;
use super::steps::{DrivenPaths, StepPaths};
use crate::ensemble::job::EnsembleJob;
use crate::error::StepError;
use crate::scheme::system::Discretized;
use crate::trajectory::Error;
use crate::trajectory::watch::{EnergyMonitor, MonitorScratch, keeps_energy};

/// `L` paths that end where their energy has changed for good.
pub(super) struct Watched<'j, 'a, H: Discretized<E>, E, T, const L: usize> {
    job: &'j EnsembleJob<'a, H, E>,
    pub(super) halving: Halving<'j, 'a, H, E, T, L>,
    /// By lane; none where nothing is monitored.
    monitors: Vec<EnergyMonitor<H::Vector>>,
    /// The next step at which one of them tests.
    next: u64,
    /// The scratch of the lanes whose energy is tested in this step.
    tested: Vec<(usize, Box<MonitorScratch<H::Vector>>)>,
}

impl<'j, 'a, H, E, T, const L: usize> Watched<'j, 'a, H, E, T, L>
where
    H: Discretized<E>,
    T: StepPaths<'j, H, E, L>,
{
    pub(super) fn new(job: &'j EnsembleJob<'a, H, E>, paths: T) -> Self {
        let halving = Halving::new(job, paths);
        Self { job, halving, monitors: Vec::new(), next: u64::MAX, tested: Vec::new() }
    }

    /// The next paths begin.
    pub(super) fn begin(&mut self, lanes: &LanePaths<L>) {
        self.halving.begin();
        if const { keeps_energy::<H, E>() } && self.job.is_watched {
            self.monitors.resize_with(L, EnergyMonitor::default);
            let steps = self.job.grid.whole();
            self.monitors.iter_mut().for_each(|monitor| monitor.restart::<H, E>(steps));
            self.find_next(lanes);
        }
    }

    /// [`StepPaths::restart`]
    pub(super) fn restart(&mut self, step: u64, size: f64, lanes: &LanePaths<L>) -> Result<(), Error> {
        // A last step that is shorter is none of the steps that are compared.
        self.next = u64::MAX;
        self.halving.restart(step, size, lanes)
    }

    /// Takes a step; paths end that cannot take it, or whose energy has changed for good.
    ///
    /// # Errors
    /// If the run cannot go on.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn step(&mut self, number: u64, paths: &mut DrivenPaths<'j, L>) -> Result<(), Error> {
        if const { keeps_energy::<H, E>() } && number == self.next {
            self.begin_test(number, &paths.lanes);
        }
        self.halving.step(number, paths)?;
        if const { keeps_energy::<H, E>() } && !self.tested.is_empty() {
            self.end_test(number, &mut paths.lanes);
        }
        if const { keeps_energy::<H, E>() } && number + 1 == self.job.grid.steps {
            self.arrive(number, &mut paths.lanes);
        }
        Ok(())
    }

    /// Before a step that is tested.
    #[cold]
    #[inline(never)]
    fn begin_test(&mut self, number: u64, lanes: &LanePaths<L>) {
        let Self { job, halving, monitors, tested, .. } = self;
        for (lane, monitor) in monitors.iter_mut().enumerate() {
            if lanes.goes_on(lane) && monitor.looks_at(number) {
                let system = job.systems.of(lanes.number(lane));
                let state = halving.inner.state_at(lane, job.grid.time(number));
                tested.push((lane, monitor.begin::<H, E>(system, job.grid.h, state)));
            }
        }
        if self.tested.is_empty() {
            // The test was due in a lane whose path has failed since.
            self.find_next(lanes);
        }
    }

    /// After it: a path whose energy has changed for good ends.
    #[cold]
    #[inline(never)]
    fn end_test(&mut self, number: u64, lanes: &mut LanePaths<L>) {
        let end = self.job.grid.time(number + 1);
        let mut tested = std::mem::take(&mut self.tested);
        for (lane, room) in tested.drain(..) {
            let Self { job, halving, monitors, .. } = self;
            let system = job.systems.of(lanes.number(lane));
            let state = halving.inner.state_at(lane, end);
            let kept = monitors[lane].end::<H, E>(room, system, job.grid.h, state, number);
            if let Err(error) = kept
                && !lanes.has_failed(lane)
            {
                self.halving.fail(lane, error, lanes);
            }
        }
        self.tested = tested;
        self.find_next(lanes);
    }

    /// At the end of the paths, after this step: their energy is a number.
    #[cold]
    #[inline(never)]
    fn arrive(&mut self, number: u64, lanes: &mut LanePaths<L>) {
        let end = self.job.grid.time(number + 1);
        for lane in 0..self.monitors.len() {
            if !lanes.goes_on(lane) {
                continue;
            }
            let Self { job, halving, monitors, .. } = self;
            let system = job.systems.of(lanes.number(lane));
            let arrived = monitors[lane].arrive::<H, E>(system, halving.inner.state_at(lane, end));
            if let Err(cause) = arrived {
                let error =
                    StepError { step: number, t: self.job.grid.time(number), h: self.halving.size(), cause };
                self.halving.fail(lane, error, lanes);
            }
        }
    }

    fn find_next(&mut self, lanes: &LanePaths<L>) {
        self.next = u64::MAX;
        for (lane, monitor) in self.monitors.iter().enumerate() {
            if lanes.goes_on(lane) {
                self.next = self.next.min(monitor.next_tested());
            }
        }
    }
}
