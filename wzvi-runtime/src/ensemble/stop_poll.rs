//! How often a run asks whether it was stopped.

use std::time::{Duration, Instant};

use super::job::Stop;
use crate::ground::clock;

/// Approximate time between two checks for a stop: a tenth of a delay that a person notices.
const WANTED: Duration = Duration::from_millis(10);
/// Pieces of work between two questions, at most: one question a step would cost as much as a short step.
const MOST: u32 = 1024;

/// Asks now and then, more often where a piece of work (a step of some paths, the observables of one) takes
/// longer.
pub(super) struct StopPoll<'s> {
    stop: Stop<'s>,
    left: u32,
    between: u32,
    asked: Option<Instant>,
}

impl<'s> StopPoll<'s> {
    pub(super) fn new(stop: Stop<'s>) -> Self {
        Self { stop, left: 1, between: 1, asked: None }
    }

    /// Pieces of work before the next question, at least 1.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn left(&self) -> u64 {
        u64::from(self.left)
    }

    /// Counts `pieces` units of work, [`StopPoll::left`] at most, and asks whether to stop when it is time to
    /// ask.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn ends_after(&mut self, pieces: u64) -> bool {
        debug_assert!(
            pieces <= self.left(),
            "{pieces} pieces where the question was due after {}",
            self.left
        );
        self.left = self.left.saturating_sub(pieces as u32);
        self.left == 0 && self.ask()
    }

    #[cold]
    #[inline(never)]
    fn ask(&mut self) -> bool {
        let now = clock::now();
        if let (Some(now), Some(asked)) = (now, self.asked) {
            let ratio = WANTED.as_secs_f64() / now.duration_since(asked).as_secs_f64().max(1e-9);
            // At most twice as many at once: what comes may be slower.
            self.between = ((f64::from(self.between) * ratio.min(2.0)) as u32).clamp(1, MOST);
        }
        self.asked = now;
        self.left = self.between;
        (self.stop)()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU32, Ordering};
    use std::thread::sleep;

    use super::*;

    #[test]
    fn slow_work_asks_often_and_fast_work_seldom() {
        let asked = AtomicU32::new(0);
        let stop = || {
            asked.fetch_add(1, Ordering::Relaxed);
            false
        };
        let mut pace = StopPoll::new(&stop);
        for _ in 0..1_000_000 {
            assert!(!pace.ends_after(1));
        }
        let fast = asked.swap(0, Ordering::Relaxed);
        assert!(fast < 50_000, "{fast}");
        let mut pace = StopPoll::new(&stop);
        for _ in 0..10 {
            sleep(Duration::from_millis(12));
            assert!(!pace.ends_after(1));
        }
        // The second question may come after two pieces of work, the others after each.
        assert!(asked.into_inner() >= 9);
    }
}
