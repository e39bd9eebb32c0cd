//! Numbered blocks of work on several threads, with results that arrive in the order of the numbers.

use std::collections::BTreeMap;
use std::ops::{ControlFlow, Range};
use std::panic::resume_unwind;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;

/// Blocks per thread that may be begun before the oldest one is done: bounds the results that wait.
const LEAD: u64 = 4;

/// Does `work` for every number of `blocks` on so many threads, the caller's among them, and gives the results to `take`
/// in the order of the numbers, one at a time. `take` ends it all early with [`ControlFlow::Break`]; what is being worked on
/// then is dropped. A panic in `work` or `take` ends it, too, and goes on in the caller.
pub(super) fn in_order<T: Send>(
    blocks: Range<u64>,
    threads: usize,
    work: impl Fn(u64) -> T + Sync,
    take: impl FnMut(u64, T) -> ControlFlow<()> + Send,
) {
    let lead = LEAD.saturating_mul(threads as u64);
    let line =
        Line { next: blocks.start, taken: blocks.start, waiting: BTreeMap::new(), take, is_ended: false };
    let (line, changed) = (Mutex::new(line), Condvar::new());
    let run = || {
        let end = EndOnPanic { line: &line, changed: &changed };
        while let Some(number) = begin(&line, &changed, blocks.end, lead) {
            let result = work(number);
            lock(&line).arrive(number, result);
            changed.notify_all();
        }
        std::mem::forget(end);
    };
    let others = (threads as u64).min(blocks.end.saturating_sub(blocks.start)).saturating_sub(1);
    thread::scope(|scope| {
        // A thread that the system does not give is one fewer.
        let spawned: Vec<_> =
            (0..others).map_while(|_| thread::Builder::new().spawn_scoped(scope, run).ok()).collect();
        run();
        for thread in spawned {
            if let Err(panic) = thread.join() {
                resume_unwind(panic);
            }
        }
    });
}

/// Who is next, and who waits for whom.
struct Line<T, F> {
    /// The next number to begin.
    next: u64,
    /// All before this number are taken.
    taken: u64,
    waiting: BTreeMap<u64, T>,
    take: F,
    is_ended: bool,
}

impl<T, F: FnMut(u64, T) -> ControlFlow<()>> Line<T, F> {
    fn arrive(&mut self, number: u64, result: T) {
        self.waiting.insert(number, result);
        while !self.is_ended
            && let Some(result) = self.waiting.remove(&self.taken)
        {
            self.is_ended = (self.take)(self.taken, result).is_break();
            self.taken += 1;
        }
    }
}

fn lock<L>(line: &Mutex<L>) -> MutexGuard<'_, L> {
    line.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The next number, as soon as it may be begun; `None` if there is none.
fn begin<T, F>(line: &Mutex<Line<T, F>>, changed: &Condvar, end: u64, lead: u64) -> Option<u64> {
    let must_wait = |line: &mut Line<T, F>| {
        !line.is_ended && line.next < end && line.next >= line.taken.saturating_add(lead)
    };
    let mut line = changed.wait_while(lock(line), must_wait).unwrap_or_else(PoisonError::into_inner);
    if line.is_ended || line.next >= end {
        return None;
    }
    line.next += 1;
    Some(line.next - 1)
}

/// Lets nobody wait for a block that will never be done.
struct EndOnPanic<'a, T, F> {
    line: &'a Mutex<Line<T, F>>,
    changed: &'a Condvar,
}

impl<T, F> Drop for EndOnPanic<'_, T, F> {
    fn drop(&mut self) {
        lock(self.line).is_ended = true;
        self.changed.notify_all();
    }
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
            assert!(farthest.into_inner() <= LEAD * threads as u64);
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
