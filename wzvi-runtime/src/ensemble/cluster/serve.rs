//! Rank 0 hands out batches of blocks, the others do them.

use std::ops::ControlFlow;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, Scope};
use std::time::{Duration, Instant};

use mpi::point_to_point::{Message, Status};
use mpi::traits::{Communicator, Destination, MatchedReceiveVec, Source};

use super::desk::{Desk, Pace};
use super::error::ClusterError;
use super::ranks::end_all;
use crate::checkpoint::Tape;
use crate::ensemble::schedule::in_order;
use crate::ensemble::statistics::Statistics;
use crate::error::Error;

/// The first and the last number of a batch, or nothing at the end.
const BATCH: i32 = 1;
/// The number of its first block, the nanoseconds that it took, how many blocks were not stopped on the way, and the words of
/// their results.
const RESULTS: i32 = 2;
/// Batches that a rank has: one to work on, one to go on with.
const HELD: usize = 2;
/// How long to sleep where nothing is to be done.
const NAP: Duration = Duration::from_micros(200);

/// Hands out the blocks of `desk` to the other ranks and to so many threads of this one, until all are taken or `take`
/// breaks. Results have the shape of `empty`.
pub(super) fn serve<C: Communicator>(
    world: &C,
    desk: Desk<Option<Statistics>>,
    threads: usize,
    work: impl Fn(u64) -> Option<Statistics> + Sync,
    empty: impl Fn() -> Statistics,
    take: impl FnMut(Option<Statistics>) -> ControlFlow<()>,
) -> Result<(), Error> {
    let shared = Shared { desk: Mutex::new(desk), changed: Condvar::new() };
    thread::scope(|scope| {
        let end = StopOnPanic(&shared);
        let started = (0..threads).take_while(|_| shared.start(scope, &work)).count();
        let ranks = (1..world.size()).map(|_| Rank { pace: Pace::new(threads), held: Vec::new() }).collect();
        let outcome =
            Server { world, shared: &shared, ranks, empty, take, works_itself: started == 0 }.run(&work);
        drop(end);
        outcome
    })
}

/// What the threads of rank 0 share.
struct Shared {
    desk: Mutex<Desk<Option<Statistics>>>,
    /// Something was taken, has arrived, or is stopped.
    changed: Condvar,
}

impl Shared {
    fn desk(&self) -> MutexGuard<'_, Desk<Option<Statistics>>> {
        self.desk.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for a change, but not for long.
    fn nap(&self) {
        let nap = self.changed.wait_timeout(self.desk(), NAP);
        drop(nap.unwrap_or_else(PoisonError::into_inner));
    }

    /// A thread that works until all is done; false if the system has none.
    fn start<'s, 'e>(
        &'s self,
        scope: &'s Scope<'s, 'e>,
        work: &'s (impl Fn(u64) -> Option<Statistics> + Sync),
    ) -> bool {
        let run = || {
            let end = StopOnPanic(self);
            let mut pace = Pace::new(1);
            while !self.desk().is_done() {
                if !self.work_once(&mut pace, work) {
                    self.nap();
                }
            }
            std::mem::forget(end);
        };
        thread::Builder::new().spawn_scoped(scope, run).is_ok()
    }

    /// Does one batch; false if there is none.
    fn work_once(&self, pace: &mut Pace, work: &impl Fn(u64) -> Option<Statistics>) -> bool {
        let Some(batch) = self.desk().assign(pace) else { return false };
        let (first, began) = (batch.start, Instant::now());
        let results: Vec<Option<Statistics>> = batch.map(work).collect();
        pace.saw(results.len(), began.elapsed(), 0);
        self.desk().arrive(first, results);
        self.changed.notify_all();
        true
    }
}

/// Lets no thread wait for one that has panicked.
struct StopOnPanic<'s>(&'s Shared);

impl Drop for StopOnPanic<'_> {
    fn drop(&mut self) {
        self.0.desk().stop();
        self.0.changed.notify_all();
    }
}

/// Another rank.
struct Rank {
    pace: Pace,
    /// Blocks of the batches that it has, the oldest first.
    held: Vec<(u64, u64)>,
}

/// The main thread of rank 0, which alone talks to others.
struct Server<'s, C, Empty, Take> {
    world: &'s C,
    shared: &'s Shared,
    /// From rank 1 on.
    ranks: Vec<Rank>,
    empty: Empty,
    take: Take,
    /// There is no other thread.
    works_itself: bool,
}

impl<C, Empty, Take> Server<'_, C, Empty, Take>
where
    C: Communicator,
    Empty: Fn() -> Statistics,
    Take: FnMut(Option<Statistics>) -> ControlFlow<()>,
{
    fn run(mut self, work: &impl Fn(u64) -> Option<Statistics>) -> Result<(), Error> {
        let mut pace = Pace::new(1);
        let mut outcome = Ok(());
        loop {
            // Each of these is done, whether or not another one is.
            let mut is_idle = !self.hand_out();
            match self.receive() {
                Ok(any) => is_idle &= !any,
                Err(error) => {
                    outcome = outcome.and(Err(error.into()));
                    self.shared.desk().stop();
                }
            }
            is_idle &= !self.merge();
            let is_done = self.shared.desk().is_done();
            if is_done && self.ranks.iter().all(|rank| rank.held.is_empty()) {
                break;
            }
            if is_idle && !(self.works_itself && self.shared.work_once(&mut pace, work)) {
                self.shared.nap();
            }
        }
        for rank in 1..self.world.size() {
            let nothing: &[u64] = &[];
            self.world.process_at_rank(rank).send_with_tag(nothing, BATCH);
        }
        outcome
    }

    /// Gives batches to those that have too few; whether there was any.
    fn hand_out(&mut self) -> bool {
        let mut is_any = false;
        for (number, rank) in (1..).zip(&mut self.ranks) {
            while rank.held.len() < HELD
                && let Some(batch) = self.shared.desk().assign(&rank.pace)
            {
                // So short that it is sent at once, whatever the other is doing.
                self.world.process_at_rank(number).send_with_tag(&[batch.start, batch.end][..], BATCH);
                rank.held.push((batch.start, batch.end));
                is_any = true;
            }
        }
        is_any
    }

    /// Takes in the results that have arrived; whether there were any.
    fn receive(&mut self) -> Result<bool, ClusterError> {
        let mut is_any = false;
        while let Some(found) = self.world.any_process().immediate_matched_probe_with_tag(RESULTS) {
            is_any = true;
            let number = found.1.source_rank();
            let wrong = || ClusterError::Message { rank: number };
            let words = received(found);
            let bytes = size_of_val(&words[..]);
            let index = usize::try_from(number - 1).map_err(|_| wrong())?;
            let rank = self.ranks.get_mut(index).filter(|rank| !rank.held.is_empty()).ok_or_else(wrong)?;
            // Messages between two ranks arrive in the order in which they were sent.
            let (first, end) = rank.held.remove(0);
            let (mut said, mut nanoseconds, mut done) = (first, 0, 0);
            let mut results = Vec::new();
            let read = Tape::read(words, |tape| {
                tape.words([&mut said, &mut nanoseconds, &mut done]);
                results.extend((first..end).zip(0..done).map(|_| (self.empty)()));
                results.iter_mut().for_each(|result| result.pass(tape));
            });
            read.filter(|()| said == first).ok_or_else(wrong)?;
            let mut results: Vec<Option<Statistics>> = results.into_iter().map(Some).collect();
            results.resize_with((end - first) as usize, || None);
            rank.pace.saw(results.len(), Duration::from_nanos(nanoseconds), bytes);
            self.shared.desk().arrive(first, results);
        }
        Ok(is_any)
    }

    /// Merges what is next; whether there was any.
    fn merge(&mut self) -> bool {
        let mut is_any = false;
        loop {
            // The lock is held by neither the merge nor a checkpoint.
            let Some(results) = self.shared.desk().take() else { break };
            is_any = true;
            for block in results {
                if (self.take)(block).is_break() {
                    self.shared.desk().stop();
                    break;
                }
            }
        }
        if is_any {
            self.shared.changed.notify_all();
        }
        is_any
    }
}

/// Does batches for rank 0 until it says that there are no more.
pub(super) fn work<C: Communicator>(
    world: &C,
    threads: usize,
    work: impl Fn(u64) -> Option<Statistics> + Sync,
) {
    let server = world.process_at_rank(0);
    loop {
        let batch = received(wait_for(&server));
        let [first, end] = batch[..] else { return };
        let (mut results, began) = (Vec::new(), Instant::now());
        in_order(first..end, threads, &work, |_, result| match result {
            Some(result) => {
                results.push(result);
                ControlFlow::Continue(())
            }
            None => ControlFlow::Break(()),
        });
        let mut nanoseconds = u64::try_from(began.elapsed().as_nanos()).unwrap_or(u64::MAX);
        let words = Tape::write(|tape| {
            tape.words([&mut first.clone(), &mut nanoseconds, &mut (results.len() as u64)]);
            results.iter_mut().for_each(|result| result.pass(tape));
        });
        if i32::try_from(words.len()).is_err() {
            end_all(world, "the results of a block do not fit into a message; record fewer times");
        }
        server.send_with_tag(&words[..], RESULTS);
    }
}

/// The next batch. MPI itself would keep a core busy until it is there.
fn wait_for(server: &impl Source) -> (Message, Status) {
    let mut naps = 0;
    loop {
        if let Some(found) = server.immediate_matched_probe_with_tag(BATCH) {
            return found;
        }
        match naps {
            0..100 => thread::yield_now(),
            _ => thread::sleep(NAP),
        }
        naps += 1;
    }
}

fn received(found: (Message, Status)) -> Vec<u64> {
    found.matched_receive_vec().0
}
