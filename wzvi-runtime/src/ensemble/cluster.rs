//! Ensembles on many machines: blocks of paths on the ranks of an MPI communicator (feature `mpi`).
//!
//! Rank 0 hands out blocks and merges their statistics in the order of their numbers, as one process does, so
//! that the result is the same, bit for bit, on any number of ranks. Statistics travel as their 64-bit words.
//! Rank 0 works as well: its main thread serves the others and sleeps in between.
//!
//! A rank gets batches of blocks that take about 20 ms, or one block if that takes longer, and has the next
//! one already when it finishes one. At most four batches for each thread of all ranks are begun before the
//! oldest one is merged, and a batch has at most 1 MiB of results or is a single block: this bounds the
//! memory of rank 0.
//!
//! The guide with a Slurm script is `docs/guide/cluster.md`.

mod orders;
mod ranks;
mod serve;

use std::sync::OnceLock;

use mpi::environment::{Threading, threading_support};
use mpi::traits::Communicator;

pub use crate::trajectory::error::ClusterError;
use orders::Orders;
use ranks::{AbortOnPanic, agree, same};
use serve::RankWork;

use super::Ensemble;
use super::account::ChunkLedger;
use super::chunk::Chunks;
use super::run_identity::described;
use super::starts::Systems;
use crate::ensemble::schedule::Queue;
use crate::error::{ConfigError, StoppedError};
use crate::increments::Noise;
use crate::scheme::system::Discretized;
use crate::statistics::Statistics;
use crate::trajectory::Error;

impl<H, E, N, P> Ensemble<'_, H, E, N, P>
where
    H: Discretized<E> + Sync,
    N: Noise,
    P: Systems,
{
    /// Runs all paths on all ranks of `world`, each of which calls this with the same settings;
    /// [`Ensemble::run`] gives the same statistics, bit for bit. Rank 0 gets them and the others get `None`,
    /// so that printing and writing files happens once. A checkpoint is read and written by rank 0 alone.
    ///
    /// A rank is one thread, unless [`Ensemble::threads`] says otherwise. MPI has to be initialised for
    /// threads, and this called on the thread that did it:
    ///
    /// ```ignore
    /// let (universe, _) = mpi::initialize_with_threading(Threading::Funneled).ok_or("no MPI")?;
    /// if let Some(statistics) = kubo.ensemble::<Midpoint>(0.02).start(start).paths(1_000_000).seed(7).steps(100)
    ///     .run_on(&universe.world())?
    /// {
    ///     println!("{}", statistics.mean("q"));
    /// }
    /// ```
    ///
    /// A run that is stopped ([`Ensemble::stop_when`]) on one rank is stopped on all. A rank that does not
    /// answer delays no other: they do its blocks, and the run ends without it; rank 0 reports that in a line
    /// on standard error.
    ///
    /// # Errors
    /// The errors of [`Ensemble::run`], and [`Error::Cluster`]: all ranks fail together. A panic on one rank
    /// ends the processes of all.
    pub fn run_on<C: Communicator + ?Sized>(mut self, world: &C) -> Result<Option<Statistics>, Error> {
        // Messages of this run are no others'.
        let world = world.duplicate();
        let guard = AbortOnPanic(&world);
        let execution = std::mem::take(&mut self.setup.execution);
        let (control, keeping) =
            (std::mem::take(&mut self.setup.more.control), std::mem::take(&mut self.setup.keeping));
        let (threads, instructions) = (execution.threads.unwrap_or(1), execution.instructions());
        let stop = || execution.is_stopped();
        let job = agree(&world, check_threads(threads).and_then(|()| self.job(&stop)))?;
        let described = agree(&world, described(&job, Vec::new()))?;
        same(&world, &described.lines(job.paths))?;
        let account = match world.rank() {
            0 => ChunkLedger::open(&job, &control, keeping, execution.progress("paths")).map(Some),
            _ => Ok(None),
        };
        let account = agree(&world, account)?;
        let failed = OnceLock::new();
        let work = |number| {
            match instructions.run(Chunks::<H, E, P, 0>::new(&job, None, number..number + 1)).pop()? {
                Ok(statistics) => return Some(statistics),
                Err(Error::Stopped(_)) => {}
                // One of the reasons is enough.
                Err(error) => drop(failed.set(error)),
            }
            None
        };
        // No longer all together: who has stalled is not waited for.
        let Some(mut account) = account else {
            let failure = serve::work(&world, threads, work);
            drop(guard);
            return match failure {
                Some(cause) => Err(ClusterError::Rank { rank: 0, cause }.into()),
                None => Ok(None),
            };
        };
        let all = threads.saturating_mul(world.size().unsigned_abs() as usize);
        let queue = Queue::new(account.chunks(), all);
        let hands = RankWork { threads, work, stop: &stop };
        let stopped = StoppedError { done: 0, all: job.grid.steps };
        let served = serve::serve(
            &world,
            queue,
            hands,
            || job.observed.empty.clone(),
            |chunk| account.add_chunk(chunk.ok_or(stopped.into())),
        );
        let statistics = served.outcome.and_then(|()| match failed.get() {
            Some(error) => Err(error.clone()),
            None => account.close(),
        });
        Orders(&world).end(statistics.as_ref().err().map(ToString::to_string).as_deref());
        drop(guard);
        if served.has_stragglers {
            // Messages that may come yet need it.
            std::mem::forget(world);
        }
        statistics.map(Some)
    }
}

/// Whether ranks may have threads, and so many.
fn check_threads(threads: usize) -> Result<(), Error> {
    if threads == 0 {
        return Err(ConfigError::Setting("0 threads: take at least 1".into()).into());
    }
    if threading_support() < Threading::Funneled {
        return Err(ClusterError::Threading.into());
    }
    Ok(())
}
