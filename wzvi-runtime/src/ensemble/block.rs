//! A block of paths, the unit of work: its statistics depend on nothing but its number.

use std::marker::PhantomData;

use super::dispatch::Kernel;
use super::group::Group;
use super::halt::Halt;
use super::job::Job;
use super::observation::Observation;
use super::starts::Systems;
use super::statistics::Statistics;
use crate::steps::take_steps;
use crate::system::Discretized;

/// Paths in a block.
pub(super) const PATHS: u64 = 512;

/// One block, as many paths at a time as the instructions ask for (half as many if a path has more than one degree of freedom), or `WIDTH` if
/// that is not 0.
pub(super) struct Block<'j, 'a, H: Discretized<E>, E, P, const WIDTH: usize> {
    job: &'j Job<'a, H, E>,
    number: u64,
    systems: PhantomData<P>,
}

impl<'j, 'a, H: Discretized<E>, E, P, const WIDTH: usize> Block<'j, 'a, H, E, P, WIDTH> {
    pub(super) fn new(job: &'j Job<'a, H, E>, number: u64) -> Self {
        Self { job, number, systems: PhantomData }
    }
}

impl<H: Discretized<E>, E, P: Systems, const WIDTH: usize> Kernel for Block<'_, '_, H, E, P, WIDTH> {
    type Output = Result<Statistics, Halt>;

    #[inline(always)]
    fn run<const L: usize, const HALF: usize>(self) -> Self::Output {
        if WIDTH != 0 {
            self.of_width::<WIDTH>()
        } else if const { size_of::<H::Vector>() > size_of::<f64>() } {
            self.of_width::<HALF>()
        } else {
            self.of_width::<L>()
        }
    }
}

impl<H: Discretized<E>, E, P: Systems, const WIDTH: usize> Block<'_, '_, H, E, P, WIDTH> {
    #[inline(always)]
    fn of_width<const L: usize>(self) -> Result<Statistics, Halt> {
        let job = self.job;
        let (mut group, mut observation) = (Group::<H, E, P, L>::new(job), Observation::new(job));
        let mut path = self.number * PATHS;
        let end = job.paths.min(path + PATHS);
        while path < end {
            group.begin(path, end)?;
            observation.begin(&mut group)?;
            take_steps(&mut group, 0..job.steps, &mut observation)?;
            observation.finish(&mut group);
            path += L as u64;
        }
        Ok(observation.into_statistics())
    }
}
