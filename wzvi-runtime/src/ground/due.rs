//! When something is due in a run: a checkpoint, a look at how far it is.

use std::time::{Duration, Instant};

use crate::ground::clock;

/// Decides at which nodes. A node that it need not think about costs one comparison.
#[derive(Debug)]
pub(crate) struct Due {
    /// The node to think about next.
    next: u64,
    /// The last node of the run, at which it is always due.
    end: u64,
    every: Option<u64>,
    clock: Option<PollTimer>,
}

/// Looks at the time now and then: asking for it takes as long as a short step.
#[derive(Debug)]
struct PollTimer {
    interval: Duration,
    done: Instant,
    looked: Instant,
    /// Steps between looks.
    stride: u64,
}

impl Due {
    /// For the steps from node `first` to node `end`: at multiples of `every`, and whenever `interval` has
    /// gone by, where there is a clock.
    pub(crate) fn new(every: Option<u64>, interval: Option<Duration>, first: u64, end: u64) -> Self {
        let clock = interval.and_then(|interval| {
            let now = clock::now()?;
            Some(PollTimer { interval, done: now, looked: now, stride: 1 })
        });
        let mut due = Self { next: first, end, every, clock };
        due.plan(first);
        due
    }

    /// The next node to ask about.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn next_node(&self) -> u64 {
        self.next
    }

    /// Whether the work is due at `node`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn is_due(&mut self, node: u64) -> bool {
        node >= self.next && self.consider(node)
    }

    #[cold]
    #[inline(never)]
    fn consider(&mut self, node: u64) -> bool {
        let is_time = self.clock.as_mut().is_some_and(PollTimer::poll);
        let is_step = self.every.is_some_and(|every| node.is_multiple_of(every));
        self.plan(node);
        is_time || is_step || node == self.end
    }

    /// It was done.
    pub(crate) fn done(&mut self) {
        if let (Some(clock), Some(now)) = (&mut self.clock, clock::now()) {
            (clock.done, clock.looked) = (now, now);
        }
    }

    /// The next node to think about after `node`.
    fn plan(&mut self, node: u64) {
        let step = self.every.map(|every| node.saturating_add(every - node % every));
        let look = self.clock.as_ref().map(|clock| node.saturating_add(clock.stride));
        self.next = step.into_iter().chain(look).fold(self.end, u64::min);
    }
}

impl PollTimer {
    /// Whether it is time, and how many steps later to look again: about a hundred looks per interval, and
    /// ten per second.
    fn poll(&mut self) -> bool {
        let Some(now) = clock::now() else { return false };
        let wanted = (self.interval / 100).min(Duration::from_millis(100));
        let ratio = wanted.as_secs_f64() / now.duration_since(self.looked).as_secs_f64().max(1e-9);
        self.stride = ((self.stride as f64 * ratio.min(2.0)) as u64).max(1);
        let is_time = now.duration_since(self.done) >= self.interval;
        self.looked = now;
        is_time
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn nodes(every: Option<u64>, interval: Option<Duration>, first: u64, end: u64) -> Vec<u64> {
        let mut due = Due::new(every, interval, first, end);
        (first + 1..=end).filter(|&node| due.is_due(node)).collect()
    }

    fn due(every: Option<u64>, first: u64, end: u64) -> Vec<u64> {
        nodes(every, None, first, end)
    }

    #[test]
    fn multiples_and_the_end() {
        assert_eq!(due(Some(4), 0, 10), [4, 8, 10]);
        assert_eq!(due(Some(4), 7, 12), [8, 12]);
        assert_eq!(due(Some(4), 8, 9), [9]);
        assert_eq!(due(Some(u64::MAX), 0, 3), [3]);
        assert_eq!(due(Some(1), 0, 3), [1, 2, 3]);
    }

    #[test]
    fn a_minute_is_not_over_at_once() {
        assert_eq!(nodes(None, Some(Duration::from_secs(60)), 0, 1000), [1000]);
    }

    #[test]
    fn time_is_kept_with_few_looks() {
        let mut due = Due::new(None, Some(Duration::from_millis(20)), 0, u64::MAX);
        let start = std::time::Instant::now();
        let (mut node, mut times) = (0_u64, 0_u32);
        while start.elapsed() < Duration::from_millis(300) {
            node += 1;
            if due.is_due(node) {
                times += 1;
                due.done();
            }
        }
        // Fifteen intervals; a busy machine may lose some, none can be too many.
        assert!((1..=15).contains(&times), "{times}");
        let stride = due.clock.map_or(0, |clock| clock.stride);
        assert!(stride > 10, "{stride}");
    }
}
