//! The energy of paths beside each other: each is watched as if it were alone.

use super::{Group, Systems};
use crate::path::watch::{Watch, keeps_energy};
use crate::scheme::system::Discretized;

impl<H: Discretized<E>, E, P: Systems, const L: usize> Group<'_, '_, H, E, P, L> {
    /// Of all paths, from their starts.
    pub(super) fn watch_from_start(&mut self) {
        if !const { keeps_energy::<H, E>() } || !self.job.is_watched {
            return;
        }
        self.watches.resize_with(L, Watch::default);
        let steps = self.job.grid.whole();
        self.watches.iter_mut().for_each(|watch| watch.restart::<H, E>(steps));
        self.find_next_look();
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
            // That of a lane whose path has failed since.
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

    fn is_over(&self, lane: usize) -> bool {
        !self.counts[lane] || self.failed[lane]
    }

    fn find_next_look(&mut self) {
        let lanes = self.watches.iter().enumerate().filter(|(lane, _)| !self.is_over(*lane));
        self.next_look = lanes.map(|(_, watch)| watch.next()).min().unwrap_or(u64::MAX);
    }
}
