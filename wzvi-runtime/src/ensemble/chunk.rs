//! A chunk of paths, the unit of work: its results depend only on the numbers of its paths.

use std::marker::PhantomData;
use std::ops::{ControlFlow, Range};

use super::group::{BySteppers, Coupled, InLanes, StepPaths};
use super::job::{EnsembleJob, NotInLanes};
use super::observation::Observation;
use super::starts::Systems;
use crate::algebra::lanes::instructions::{InstructionSet, Kernel};
use crate::ensemble::schedule::in_order;
use crate::scheme::system::Discretized;
use crate::statistics::Statistics;
use crate::trajectory::Error;
use crate::trajectory::steps::take_steps;

/// Paths in a chunk: two groups of the widest vector registers.
pub(super) const PATHS: u64 = 64;
/// Paths in a chunk of large systems, which go one after the other.
pub(super) const PATHS_OF_LARGE_SYSTEMS: u64 = 4;

/// Whether a path has more than one degree of freedom: then half as many paths go side by side, so that their
/// states stay in registers.
const fn is_wide<V>() -> bool {
    size_of::<V>() > size_of::<f64>()
}

/// Chunks that one thread does one after the other, at most: what a group of paths allocates once is made
/// once for all of them.
const MOST: u64 = 8;
/// Tasks for each thread, at least: they are not done at the same time.
const TASKS: u64 = 4;

/// Does the chunks of a job with these numbers, with the paths of a coarser job beside them, and gives the
/// statistics of each to `take` in the order of their numbers, until it breaks.
pub(super) fn in_chunks<H: Discretized<E> + Sync, E, P: Systems, const WIDTH: usize>(
    job: &EnsembleJob<'_, H, E>,
    coarse: Option<&EnsembleJob<'_, H, E>>,
    chunks: Range<u64>,
    (threads, instructions): (usize, InstructionSet),
    mut take: impl FnMut(Result<Statistics, Error>) -> ControlFlow<()> + Send,
) {
    let Range { start, end } = chunks;
    let number = end - start;
    let row = if threads == 1 { MOST } else { (number / (TASKS * threads as u64)).clamp(1, MOST) };
    // Behind pointers, so that the queue of threads is compiled once.
    let work: &(dyn Fn(u64) -> ChunkResults + Sync) = &|task| {
        let first = start + task * row;
        let chunks = Chunks::<H, E, P, WIDTH>::new(job, coarse, first..end.min(first + row));
        chunks.instructions(instructions).run(chunks)
    };
    let take: &mut (dyn FnMut(u64, ChunkResults) -> ControlFlow<()> + Send) =
        &mut |_, found| found.into_iter().try_for_each(&mut take);
    in_order(0..number.div_ceil(row), threads, work, take);
}

/// Chunks that follow each other, as many paths at a time as the instructions ask for (half as many if a path
/// has more than one degree of freedom, one where steps are in vector instructions by themselves), or `WIDTH`
/// if that is not 0.
pub(super) struct Chunks<'j, 'a, H: Discretized<E>, E, P, const WIDTH: usize> {
    job: &'j EnsembleJob<'a, H, E>,
    /// The job of the coarser paths beside these.
    coarse: Option<&'j EnsembleJob<'a, H, E>>,
    numbers: Range<u64>,
    systems: PhantomData<P>,
}

/// The results of chunks, in their order; a chunk without a result, because it failed or was stopped, is the
/// last one.
pub(super) type ChunkResults = Vec<Result<Statistics, Error>>;

impl<'j, 'a, H: Discretized<E>, E, P, const WIDTH: usize> Chunks<'j, 'a, H, E, P, WIDTH> {
    /// With these numbers.
    pub(super) fn new(
        job: &'j EnsembleJob<'a, H, E>,
        coarse: Option<&'j EnsembleJob<'a, H, E>>,
        numbers: Range<u64>,
    ) -> Self {
        Self { job, coarse, numbers, systems: PhantomData }
    }

    /// The paths of chunks.
    fn paths(&self, numbers: &Range<u64>) -> Range<u64> {
        let size = self.job.chunk;
        numbers.start * size..self.job.paths.min(numbers.end * size)
    }

    /// The instructions that take no more paths beside each other than there are, if those asked for take
    /// more: lanes without a path cost as much as others.
    pub(super) fn instructions(&self, asked: InstructionSet) -> InstructionSet {
        if WIDTH == 0 && self.job.not_in_lanes() == Some(NotInLanes::LargeSystem) {
            return asked;
        }
        let Range { start, end } = self.paths(&self.numbers);
        let paths = end.saturating_sub(start);
        asked.for_numbers(if is_wide::<H::Vector>() { 2 * paths } else { paths })
    }
}

impl<H: Discretized<E>, E, P: Systems, const WIDTH: usize> Kernel for Chunks<'_, '_, H, E, P, WIDTH> {
    type Output = ChunkResults;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run<const L: usize, const HALF: usize>(self) -> Self::Output {
        if const { P::ARE_RUNS || H::PROPERTIES.is_clocked } {
            return self.job.chunks_by_runs(self.numbers);
        }
        if const { WIDTH != 0 } {
            self.of_width::<WIDTH>()
        } else if const { EnsembleJob::<H, E>::MAY_BE_LARGE }
            && self.job.not_in_lanes() == Some(NotInLanes::LargeSystem)
        {
            self.of_width::<1>()
        } else if const { is_wide::<H::Vector>() } {
            self.of_width::<HALF>()
        } else {
            self.of_width::<L>()
        }
    }
}

impl<'j, 'a, H: Discretized<E>, E, P: Systems, const WIDTH: usize> Chunks<'j, 'a, H, E, P, WIDTH> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of_width<const L: usize>(self) -> ChunkResults {
        // The constants keep what a scheme never needs from being compiled.
        if const { !EnsembleJob::<H, E>::may_not_be_in_lanes::<P>() } {
            return self.by(InLanes::<H, E, P, L>::new);
        }
        if const { H::PROPERTIES.in_lanes } && self.job.not_in_lanes().is_none() {
            return self.by(InLanes::<H, E, P, L>::new);
        }
        self.by(BySteppers::<H, E, L>::new)
    }

    /// The chunks, whose steps are taken by what `make` makes.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn by<T: StepPaths<'j, H, E, L>, const L: usize>(
        self,
        make: fn(&'j EnsembleJob<'a, H, E>) -> T,
    ) -> ChunkResults {
        let (mut paths, mut found) = (Coupled::new(self.job, self.coarse, make), ChunkResults::new());
        for number in self.numbers.clone() {
            found.push(self.of_chunk(&mut paths, self.paths(&(number..number + 1))));
            if found.last().is_some_and(Result::is_err) {
                break;
            }
        }
        found
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of_chunk<T: StepPaths<'j, H, E, L>, const L: usize>(
        &self,
        paths: &mut Coupled<'j, 'a, H, E, P, T, L>,
        numbers: Range<u64>,
    ) -> Result<Statistics, Error> {
        let (job, Range { start: mut path, end }) = (self.job, numbers);
        let mut observation = Observation::new(job);
        while path < end {
            paths.begin(path, end)?;
            observation.begin(paths)?;
            take_steps(&mut (&mut *paths, &mut observation), 0..job.grid.steps)?;
            observation.finish(paths);
            path += L as u64;
        }
        Ok(observation.statistics)
    }
}
