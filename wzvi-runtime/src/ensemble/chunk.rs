//! A chunk of paths, the unit of work: what it finds out depends on nothing but the numbers of its paths.

use std::marker::PhantomData;
use std::ops::Range;

use super::group::Group;
use super::halt::Halt;
use super::job::Job;
use super::observation::Observation;
use super::starts::Systems;
use crate::algebra::lanes::instructions::{InstructionSet, Kernel};
use crate::path::steps::take_steps;
use crate::scheme::system::Discretized;
use crate::statistics::Statistics;

/// Paths in a chunk where paths go beside each other: two groups of the widest vector registers.
pub(super) const BESIDE: u64 = 64;
/// The same where they go one after the other.
pub(super) const ONE_BY_ONE: u64 = 4;

/// Whether a path has more than one degree of freedom, and so more beside it that is to stay in registers.
const fn is_wide<V>() -> bool {
    size_of::<V>() > size_of::<f64>()
}

/// One chunk, as many paths at a time as the instructions ask for (half as many if a path has more than one degree of freedom,
/// one where steps are in vector instructions by themselves), or `WIDTH` if that is not 0.
pub(super) struct Chunk<'j, 'a, H: Discretized<E>, E, P, const WIDTH: usize> {
    job: &'j Job<'a, H, E>,
    paths: Range<u64>,
    systems: PhantomData<P>,
}

impl<'j, 'a, H: Discretized<E>, E, P, const WIDTH: usize> Chunk<'j, 'a, H, E, P, WIDTH> {
    /// With this number.
    pub(super) fn new(job: &'j Job<'a, H, E>, number: u64) -> Self {
        let size = job.chunk();
        let paths = number * size..job.paths.min((number + 1) * size);
        Self { job, paths, systems: PhantomData }
    }

    /// The instructions that take no more paths beside each other than there are, if those asked for take more: lanes without a path cost as
    /// much as others.
    pub(super) fn instructions(&self, asked: InstructionSet) -> InstructionSet {
        if WIDTH == 0 && self.job.goes_path_by_path() {
            return asked;
        }
        let paths = self.paths.end.saturating_sub(self.paths.start);
        asked.for_numbers(if is_wide::<H::Vector>() { 2 * paths } else { paths })
    }
}

impl<H: Discretized<E>, E, P: Systems, const WIDTH: usize> Kernel for Chunk<'_, '_, H, E, P, WIDTH> {
    type Output = Result<Statistics, Halt>;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run<const L: usize, const HALF: usize>(self) -> Self::Output {
        if const { WIDTH != 0 } {
            self.of_width::<WIDTH>()
        } else if const { Job::<H, E>::MAY_GO_PATH_BY_PATH } && self.job.goes_path_by_path() {
            self.of_width::<1>()
        } else if const { is_wide::<H::Vector>() } {
            self.of_width::<HALF>()
        } else {
            self.of_width::<L>()
        }
    }
}

impl<H: Discretized<E>, E, P: Systems, const WIDTH: usize> Chunk<'_, '_, H, E, P, WIDTH> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of_width<const L: usize>(self) -> Result<Statistics, Halt> {
        let job = self.job;
        let (mut group, mut observation) = (Group::<H, E, P, L>::new(job), Observation::new(job));
        let Range { start: mut path, end } = self.paths;
        while path < end {
            group.begin(path, end)?;
            observation.begin(&mut group)?;
            take_steps(&mut group, 0..job.steps, &mut observation)?;
            observation.finish(&mut group);
            path += L as u64;
        }
        Ok(observation.statistics)
    }
}
