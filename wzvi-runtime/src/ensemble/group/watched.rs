//! The energy of paths beside each other: each is watched as if it were alone.

use super::{Group, Systems};
use crate::algebra::state::{State, copy_state};
use crate::error::StepError;
use crate::scheme::system::Discretized;
use crate::trajectory::watch::{EnergyMonitor, MotionSize, keeps_energy, next_look};

/// The size of the motion of each path, from the steps that a single path looks at: so both divide a step
/// alike.
pub(super) struct Motions<V> {
    /// The next of these steps; the largest number if no step is divided.
    pub(super) next: u64,
    /// By lane, where that step began.
    before: Vec<State<V>>,
    so_far: Vec<MotionSize>,
}

impl<V> Motions<V> {
    /// Its mean along the path of a lane.
    pub(super) fn of(&self, lane: usize) -> Option<f64> {
        self.so_far.get(lane)?.mean()
    }
}

impl<V> Default for Motions<V> {
    fn default() -> Self {
        Self { next: u64::MAX, before: Vec::new(), so_far: Vec::new() }
    }
}

impl<H: Discretized<E>, E, P: Systems, const L: usize> Group<'_, '_, H, E, P, L> {
    /// Monitors the energy of all paths from their starts.
    pub(super) fn watch_from_start(&mut self) {
        if !const { keeps_energy::<H, E>() } {
            return;
        }
        if self.job.retry.most() > 0 {
            self.motions.next = 0;
            self.motions.so_far.clear();
            self.motions.so_far.resize(L, MotionSize::default());
        }
        if !self.job.is_watched {
            return;
        }
        self.watches.resize_with(L, EnergyMonitor::default);
        let steps = self.job.grid.whole();
        self.watches.iter_mut().for_each(|watch| watch.restart::<H, E>(steps));
        self.find_next_look();
    }

    /// Before a step whose motion counts.
    #[cold]
    #[inline(never)]
    pub(super) fn begin_motion(&mut self) {
        let mut before = std::mem::take(&mut self.motions.before);
        if before.is_empty() {
            before.resize(L, self.job.start.clone());
        }
        for (lane, before) in before.iter_mut().enumerate() {
            copy_state(before, self.observed_state(lane));
        }
        self.motions.before = before;
    }

    /// After it.
    #[cold]
    #[inline(never)]
    pub(super) fn end_motion(&mut self, step: u64) {
        let (h, mut motions) = (self.job.h, std::mem::take(&mut self.motions));
        for (lane, (motion, before)) in motions.so_far.iter_mut().zip(&motions.before).enumerate() {
            motion.add(h, [before, self.observed_state(lane)]);
        }
        motions.next = next_look(step);
        self.motions = motions;
    }

    /// Before a step that is looked at.
    #[cold]
    #[inline(never)]
    pub(super) fn begin_look(&mut self, step: u64) {
        for lane in 0..L {
            if self.is_over(lane) || !self.watches[lane].looks_at(step) {
                continue;
            }
            let mut watch = std::mem::take(&mut self.watches[lane]);
            let (job, path) = (self.job, self.source_of(lane));
            let room = watch.begin::<H, E>(job.system_of(path), job.h, self.state_at(lane, step));
            self.looked.push((lane, room));
            self.watches[lane] = watch;
        }
        if self.looked.is_empty() {
            // The test was due in a lane whose path has failed since.
            self.find_next_look();
        }
    }

    /// After it: a path whose energy has changed for good ends.
    #[cold]
    #[inline(never)]
    pub(super) fn end_look(&mut self, step: u64) {
        let mut looked = std::mem::take(&mut self.looked);
        for (lane, room) in looked.drain(..) {
            let (job, path) = (self.job, self.source_of(lane));
            let mut state = self.state_at(lane, step + 1).clone();
            let outcome = self.watches[lane].end::<H, E>(room, job.system_of(path), job.h, &mut state, step);
            match outcome {
                Err(error) if !self.failed[lane] => self.fail(lane, error),
                _ => {}
            }
        }
        self.looked = looked;
        self.find_next_look();
    }

    /// At the end of the paths, after this step: their energy is a number.
    #[cold]
    #[inline(never)]
    pub(super) fn arrive(&mut self, step: u64) {
        for lane in 0..L.min(self.watches.len()) {
            if self.is_over(lane) {
                continue;
            }
            let (watch, job, path) =
                (std::mem::take(&mut self.watches[lane]), self.job, self.source_of(lane));
            let arrived = watch.arrive::<H, E>(job.system_of(path), self.state_at(lane, step + 1));
            self.watches[lane] = watch;
            if let Err(cause) = arrived {
                self.fail(lane, StepError { step, t: self.time(step), h: self.size, cause });
            }
        }
    }

    fn is_over(&self, lane: usize) -> bool {
        !self.counts[lane] || self.failed[lane]
    }

    fn find_next_look(&mut self) {
        let lanes = self.watches.iter().enumerate().filter(|(lane, _)| !self.is_over(*lane));
        self.next_look = lanes.map(|(_, watch)| watch.next_tested()).min().unwrap_or(u64::MAX);
    }
}
