//! Rank 0 hands out batches of blocks, the others do them.

use std::collections::VecDeque;
use std::ops::{ControlFlow, Range};
use std::thread::{self, Scope};
use std::time::{Duration, Instant};

use mpi::traits::Communicator;

use super::orders::{Answer, Answers, Order, Orders};
use super::ranks::end_all;
use crate::ensemble::schedule::{PATIENCE, Queue, SharedQueue, StopOnPanic, WorkerSpeed, in_order};
use crate::ground::numbers::{Numbers as _, Tape};
use crate::statistics::Statistics;
use crate::trajectory::Error;
use crate::trajectory::error::ClusterError;

/// Batches that a rank has: one to work on, one to go on with.
const HELD: usize = 2;
/// How long to sleep where nothing is to be done.
const NAP: Duration = Duration::from_micros(200);

/// How rank 0 does its part.
pub(super) struct RankWork<'h, Work> {
    /// Number of threads of this rank.
    pub(super) threads: usize,
    /// Does a block.
    pub(super) work: Work,
    /// Whether the run is to end early.
    pub(super) stop: &'h (dyn Fn() -> bool + Sync),
}

/// The outcome of a run.
pub(super) struct ServerOutcome {
    pub(super) outcome: Result<(), Error>,
    /// Whether there are ranks that did not answer: they may send yet.
    pub(super) has_stragglers: bool,
}

/// Hands out the blocks of `queue` to the other ranks and to threads of this one, until all are taken, `take`
/// breaks, or the run is to end early: then it has nothing for `take`. Results have the shape of `empty`. It
/// does not wait for a rank that does not answer.
pub(super) fn serve<C: Communicator>(
    world: &C,
    queue: Queue<Option<Statistics>>,
    hands: RankWork<'_, impl Fn(u64) -> Option<Statistics> + Sync>,
    empty: impl Fn() -> Statistics,
    take: impl FnMut(Option<Statistics>) -> ControlFlow<()>,
) -> ServerOutcome {
    let RankWork { threads, work, stop } = hands;
    let shared = SharedQueue::new(queue);
    thread::scope(|scope| {
        let _stop = StopOnPanic(&shared);
        let started = (0..threads).take_while(|_| shared.start(scope, &work)).count();
        let ranks = (1..world.size()).map(|_| Rank::new(threads)).collect();
        let (orders, works_itself) = (Orders(world), started == 0);
        Server { orders, shared: &shared, ranks, empty, take, stop, works_itself }.run(&work)
    })
}

impl SharedQueue<Option<Statistics>> {
    /// A thread that works until all is done; false if the system has none.
    fn start<'s, 'e>(
        &'s self,
        scope: &'s Scope<'s, 'e>,
        work: &'s (impl Fn(u64) -> Option<Statistics> + Sync),
    ) -> bool {
        let run = || {
            let _stop = StopOnPanic(self);
            let mut pace = WorkerSpeed::new(1);
            while !self.queue().is_done() {
                if !self.work_once(&mut pace, work) {
                    self.nap(NAP);
                }
            }
        };
        thread::Builder::new().spawn_scoped(scope, run).is_ok()
    }

    /// Does one batch; false if there is none.
    fn work_once(&self, pace: &mut WorkerSpeed, work: &impl Fn(u64) -> Option<Statistics>) -> bool {
        let Some(batch) = self.queue().assign(pace) else { return false };
        let (first, began) = (batch.start, Instant::now());
        let results: Vec<Option<Statistics>> = batch.map(work).collect();
        let taken = began.elapsed();
        pace.saw(results.len(), taken, 0);
        self.queue().arrive(first, results, taken);
        self.notify();
        true
    }
}

/// Another rank.
struct Rank {
    pace: WorkerSpeed,
    /// The batches that it has, the oldest first.
    held: VecDeque<Range<u64>>,
    /// When it began the oldest one, as far as rank 0 knows.
    since: Instant,
    /// Words of results that it was asked to send.
    promised: Option<usize>,
    /// It has not answered for a long time, and others do its batches.
    is_stalled: bool,
}

impl Rank {
    fn new(threads: usize) -> Self {
        let held = VecDeque::with_capacity(HELD);
        Self {
            pace: WorkerSpeed::new(threads),
            held,
            since: Instant::now(),
            promised: None,
            is_stalled: false,
        }
    }
}

/// The main thread of rank 0, which alone talks to others.
struct Server<'s, C, Empty, Take> {
    orders: Orders<'s, C>,
    shared: &'s SharedQueue<Option<Statistics>>,
    /// From rank 1 on.
    ranks: Vec<Rank>,
    empty: Empty,
    take: Take,
    stop: &'s (dyn Fn() -> bool + Sync),
    /// There is no other thread.
    works_itself: bool,
}

impl<C, Empty, Take> Server<'_, C, Empty, Take>
where
    C: Communicator,
    Empty: Fn() -> Statistics,
    Take: FnMut(Option<Statistics>) -> ControlFlow<()>,
{
    fn run(mut self, work: &impl Fn(u64) -> Option<Statistics>) -> ServerOutcome {
        let mut pace = WorkerSpeed::new(1);
        let mut outcome = Ok(());
        let mut done_since = None;
        loop {
            // Each of these is done, whether or not another one is.
            let mut is_idle = !self.hand_out();
            match self.receive() {
                Ok(any) => is_idle &= !any,
                Err(error) => {
                    outcome = outcome.and(Err(error.into()));
                    self.shared.queue().stop();
                }
            }
            is_idle &= !self.merge();
            if self.shared.queue().is_done() {
                let since = *done_since.get_or_insert_with(Instant::now);
                if self.ranks.iter().all(|rank| rank.held.is_empty()) || since.elapsed() > PATIENCE {
                    break;
                }
            } else if (self.stop)() {
                // It may be that no thread has a block in which it would notice.
                let _ = (self.take)(None);
                self.shared.queue().stop();
            } else {
                self.repeat_what_does_not_come();
            }
            if is_idle && !(self.works_itself && self.shared.work_once(&mut pace, work)) {
                self.shared.nap(NAP);
            }
        }
        ServerOutcome { outcome, has_stragglers: self.leave_stragglers() }
    }

    /// Gives batches to those that have too few; whether there was any.
    fn hand_out(&mut self) -> bool {
        let mut is_any = false;
        for (number, rank) in (1..).zip(&mut self.ranks) {
            while rank.held.len() < HELD
                && let Some(batch) = self.shared.queue().assign(&rank.pace)
            {
                self.orders.batch(number, batch.start, batch.end);
                if rank.held.is_empty() {
                    rank.since = Instant::now();
                }
                rank.held.push_back(batch);
                is_any = true;
            }
        }
        is_any
    }

    /// Takes in what has arrived; whether there was anything.
    fn receive(&mut self) -> Result<bool, ClusterError> {
        let mut is_any = false;
        while let Some((number, answer)) = self.orders.answer()? {
            is_any = true;
            let wrong = || ClusterError::Message { rank: number };
            let index = usize::try_from(number - 1).map_err(|_| wrong())?;
            let rank = self.ranks.get_mut(index).ok_or_else(wrong)?;
            let words = match answer {
                Answer::Announced(words) => {
                    self.orders.send(number);
                    rank.promised = Some(words);
                    continue;
                }
                Answer::Results(words) => words,
            };
            rank.promised = None;
            // Messages between two ranks arrive in the order in which they were sent.
            let Range { start: first, end } = rank.held.pop_front().ok_or_else(wrong)?;
            (rank.since, rank.is_stalled) = (Instant::now(), false);
            let bytes = size_of_val(&words[..]);
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
            let taken = Duration::from_nanos(nanoseconds);
            rank.pace.saw(results.len(), taken, bytes);
            self.shared.queue().arrive(first, results, taken);
        }
        Ok(is_any)
    }

    /// Merges the next results; returns whether there were any.
    fn merge(&mut self) -> bool {
        let mut is_any = false;
        loop {
            // The lock is held by neither the merge nor a checkpoint.
            let Some((_, results)) = self.shared.queue().pop_batch() else { break };
            is_any = true;
            for block in results {
                if (self.take)(block).is_break() {
                    self.shared.queue().stop();
                    break;
                }
            }
        }
        if is_any {
            self.shared.notify();
        }
        is_any
    }

    /// Lets others do the batches of ranks that take far longer than anybody has taken.
    fn repeat_what_does_not_come(&mut self) {
        let world = self.orders.0;
        for (number, rank) in (1..).zip(&mut self.ranks) {
            let Some(oldest) = rank.held.front().filter(|_| !rank.is_stalled) else { continue };
            let mut queue = self.shared.queue();
            let waited = rank.since.elapsed();
            if queue.patience(oldest.end - oldest.start).is_none_or(|patience| waited < patience) {
                continue;
            }
            rank.is_stalled = true;
            rank.held.iter().for_each(|batch| queue.repeat(batch.clone()));
            eprintln!(
                "wzvi: rank {number} of {} has not answered for {:.1} s; others do its blocks, too",
                world.size(),
                waited.as_secs_f64()
            );
        }
    }

    /// Goes on without those that still have batches; whether there are any.
    fn leave_stragglers(&self) -> bool {
        let mut is_any = false;
        for (number, rank) in (1..).zip(&self.ranks) {
            if rank.held.is_empty() {
                continue;
            }
            is_any = true;
            if let Some(words) = rank.promised {
                self.orders.abandon(number, words);
            }
            eprintln!(
                "wzvi: rank {number} of {} does not answer; the run ends without it",
                self.orders.0.size()
            );
        }
        is_any
    }
}

/// Does batches for rank 0 until there are no more. Returns the reason if the run failed.
pub(super) fn work<C: Communicator>(
    world: &C,
    threads: usize,
    work: impl Fn(u64) -> Option<Statistics> + Sync,
) -> Option<String> {
    let answers = Answers(world);
    let mut batches = VecDeque::with_capacity(HELD);
    // Results that rank 0 knows of and has not asked for yet.
    let mut announced = None;
    let mut naps = 0;
    loop {
        while let Some(order) = answers.order() {
            naps = 0;
            match order {
                Order::Batch(first, end) => batches.push_back(first..end),
                Order::Send => announced.take().iter().for_each(|words: &Vec<u64>| answers.results(words)),
                Order::End(failure) => return failure,
            }
        }
        let batch = if announced.is_none() { batches.pop_front() } else { None };
        match batch {
            Some(batch) => {
                let words = results(batch, threads, &work);
                if i32::try_from(words.len()).is_err() {
                    end_all(world, "the results of a block do not fit into a message; record fewer times");
                }
                announced = answers.offer(words);
            }
            // MPI itself would keep a core busy until something is there.
            None if naps < 100 => thread::yield_now(),
            None => thread::sleep(NAP),
        }
        naps += 1;
    }
}

/// The number of the first block of a batch, the nanoseconds that it took, how many blocks were not stopped
/// on the way, and their results, as words.
fn results(
    batch: Range<u64>,
    threads: usize,
    work: &(impl Fn(u64) -> Option<Statistics> + Sync),
) -> Vec<u64> {
    let (mut first, mut results, began) = (batch.start, Vec::new(), Instant::now());
    in_order(batch, threads, work, |_, result| match result {
        Some(result) => {
            results.push(result);
            ControlFlow::Continue(())
        }
        None => ControlFlow::Break(()),
    });
    let mut nanoseconds = u64::try_from(began.elapsed().as_nanos()).unwrap_or(u64::MAX);
    Tape::write(|tape| {
        tape.words([&mut first, &mut nanoseconds, &mut (results.len() as u64)]);
        results.iter_mut().for_each(|result| result.pass(tape));
    })
}
