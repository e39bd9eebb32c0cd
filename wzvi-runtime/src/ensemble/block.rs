//! A block of paths, the unit of work: its statistics depend on nothing but its number.

use super::dispatch::Kernel;
use super::group::Group;
use super::job::Job;
use super::pace::Pace;
use super::statistics::Statistics;
use crate::system::Discretized;

/// Paths in a block.
pub(super) const PATHS: u64 = 512;

/// One block, as many paths at a time as the instructions ask for, or `WIDTH` if that is not 0.
pub(super) struct Block<'j, 'a, H: Discretized<E>, E, const WIDTH: usize> {
    pub(super) job: &'j Job<'a, H, E>,
    pub(super) number: u64,
}

impl<H: Discretized<E>, E, const WIDTH: usize> Kernel for Block<'_, '_, H, E, WIDTH> {
    /// `None` if the run was stopped on the way.
    type Output = Option<Statistics>;

    #[inline(always)]
    fn run<const L: usize>(self) -> Option<Statistics> {
        if WIDTH == 0 { self.of_width::<L>() } else { self.of_width::<WIDTH>() }
    }
}

impl<H: Discretized<E>, E, const WIDTH: usize> Block<'_, '_, H, E, WIDTH> {
    #[inline(always)]
    fn of_width<const L: usize>(self) -> Option<Statistics> {
        let job = self.job;
        let mut statistics = Statistics::new(&job.wanted);
        let first = self.number * PATHS;
        let end = job.paths.min(first + PATHS);
        let mut group = Group::<H, E, L>::new(job);
        let mut pace = Pace::new(job.stop);
        let mut path = first;
        while path < end {
            group.begin(path, end);
            group.watch_from(&mut statistics);
            group.record(0, &mut statistics, &mut pace)?;
            let mut node = 1;
            for step in 0..job.steps {
                if pace.is_stopped() {
                    return None;
                }
                group.draw(step);
                group.advance(step);
                if !job.events.is_empty() {
                    group.watch(step);
                }
                if job.recorded.get(node) == Some(&(step + 1)) {
                    group.record(node, &mut statistics, &mut pace)?;
                    node += 1;
                }
            }
            group.finish(&mut statistics);
            path += L as u64;
            if job.has_failed() {
                return None;
            }
        }
        Some(statistics)
    }
}
