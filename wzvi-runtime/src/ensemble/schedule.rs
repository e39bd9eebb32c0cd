//! Numbered blocks of work on several threads, and on several ranks, with results that arrive in the order of
//! the numbers.

mod queue;

use std::ops::{ControlFlow, Range};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use crate::algebra::threads::with_threads;

#[cfg(feature = "mpi")]
pub(crate) use queue::PATIENCE;
pub(crate) use queue::{Queue, WorkerSpeed};

/// A queue of blocks that several threads work on.
pub(crate) struct SharedQueue<T> {
    queue: Mutex<Queue<T>>,
    /// Something was taken, has arrived, or is stopped.
    changed: Condvar,
}

impl<T> SharedQueue<T> {
    pub(crate) fn new(queue: Queue<T>) -> Self {
        Self { queue: Mutex::new(queue), changed: Condvar::new() }
    }

    pub(crate) fn queue(&self) -> MutexGuard<'_, Queue<T>> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Wakes all who wait.
    pub(crate) fn notify(&self) {
        self.changed.notify_all();
    }

    /// Nothing more is begun or taken.
    pub(crate) fn stop(&self) {
        self.queue().stop();
        self.notify();
    }

    /// The next block, as soon as it may be begun; `None` if there is none.
    fn next_block(&self) -> Option<u64> {
        let mut queue = self.queue();
        loop {
            match queue.assign(&WorkerSpeed::SINGLE) {
                Some(block) => return Some(block.start),
                None if queue.has_begun_all() => return None,
                None => queue = self.changed.wait(queue).unwrap_or_else(PoisonError::into_inner),
            }
        }
    }

    /// Waits for a change, but not for long.
    #[cfg(feature = "mpi")]
    pub(crate) fn nap(&self, longest: Duration) {
        let nap = self.changed.wait_timeout(self.queue(), longest);
        drop(nap.unwrap_or_else(PoisonError::into_inner));
    }
}

/// Lets no thread wait for one that has panicked.
pub(crate) struct StopOnPanic<'s, T>(pub(crate) &'s SharedQueue<T>);

impl<T> Drop for StopOnPanic<'_, T> {
    fn drop(&mut self) {
        if thread::panicking() {
            self.0.stop();
        }
    }
}

/// Does `work` for every number of `blocks` on so many threads, the caller's among them, and gives the
/// results to `take` in the order of the numbers, one at a time. `take` ends early with
/// [`ControlFlow::Break`]; work in progress is then dropped. A panic in `work` or `take` ends it, too, and
/// continues in the caller.
pub(crate) fn in_order<T: Send>(
    blocks: Range<u64>,
    threads: usize,
    work: impl Fn(u64) -> T + Sync,
    take: impl FnMut(u64, T) -> ControlFlow<()> + Send,
) {
    let others = (threads as u64).min(blocks.end.saturating_sub(blocks.start)).saturating_sub(1);
    let (shared, take) = (SharedQueue::new(Queue::new(blocks, threads)), Mutex::new(take));
    let run = || {
        let _stop = StopOnPanic(&shared);
        while let Some(number) = shared.next_block() {
            let result = work(number);
            shared.queue().arrive(number, vec![result], Duration::ZERO);
            take_what_is_next(&shared, &take);
        }
    };
    with_threads(others as usize, &run);
}

/// Gives to `take` what has arrived in order. While one thread is at it, others wait: none runs ahead of
/// `take`.
fn take_what_is_next<T>(shared: &SharedQueue<T>, take: &Mutex<impl FnMut(u64, T) -> ControlFlow<()>>) {
    let mut take = take.lock().unwrap_or_else(PoisonError::into_inner);
    loop {
        let Some((first, results)) = shared.queue().pop_batch() else { break };
        for (number, result) in (first..).zip(results) {
            if take(number, result).is_break() {
                shared.queue().stop();
                break;
            }
        }
    }
    shared.notify();
}

#[cfg(test)]
mod tests {
    use std::panic::{AssertUnwindSafe, catch_unwind};
    use std::sync::atomic::{AtomicU64, Ordering};
    use std::time::Duration;

    use super::*;

    #[test]
    fn results_arrive_in_order_and_none_runs_far_ahead() {
        for threads in [1, 2, 5] {
            let (mut seen, begun) = (Vec::new(), AtomicU64::new(0));
            let farthest = AtomicU64::new(0);
            let taken = AtomicU64::new(3);
            let work = |number: u64| {
                begun.fetch_add(1, Ordering::SeqCst);
                farthest.fetch_max(number - taken.load(Ordering::SeqCst), Ordering::SeqCst);
                if number == 3 {
                    thread::sleep(Duration::from_millis(30));
                }
                number * number
            };
            in_order(3..200, threads, work, |number, square| {
                taken.store(number + 1, Ordering::SeqCst);
                seen.push((number, square));
                ControlFlow::Continue(())
            });
            assert_eq!(seen, (3..200).map(|n| (n, n * n)).collect::<Vec<_>>());
            assert_eq!(begun.into_inner(), 197);
            assert!(farthest.into_inner() <= queue::LEAD * threads as u64);
        }
    }

    #[test]
    fn taking_can_end_it() {
        for threads in [1, 4] {
            let mut seen = 0;
            in_order(
                0..u64::MAX,
                threads,
                |number| number,
                |_, _| {
                    seen += 1;
                    if seen == 10 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
                },
            );
            assert_eq!(seen, 10);
        }
    }

    #[test]
    fn a_panic_goes_on_in_the_caller() {
        for threads in [1, 3] {
            let run = || {
                in_order(
                    0..1000,
                    threads,
                    |number| assert!(number != 17, "seventeen"),
                    |_, ()| ControlFlow::Continue(()),
                );
            };
            let panic = catch_unwind(AssertUnwindSafe(run)).unwrap_err();
            assert_eq!(panic.downcast_ref::<&str>(), Some(&"seventeen"));
        }
    }
}
