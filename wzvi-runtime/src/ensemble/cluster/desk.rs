//! Who does which blocks, and in which order the results are taken: the book-keeping of a run on many ranks.

use std::collections::BTreeMap;
use std::ops::Range;
use std::time::Duration;

/// Batches per hand that may be begun before the oldest one is taken: bounds the results that wait.
const LEAD: u64 = 4;
/// How long a batch should take: long against a message, short against a run.
const BATCH: Duration = Duration::from_millis(20);
/// Bytes of results that a batch should not exceed, unless one block does.
const MOST_BYTES: u64 = 1 << 20;
/// Blocks in a batch, at most.
const MOST_BLOCKS: u64 = 1 << 12;

/// Blocks that are not begun, and results that wait for others before them.
pub(super) struct Desk<T> {
    /// The next block to begin.
    next: u64,
    end: u64,
    /// All blocks before this one are taken.
    taken: u64,
    /// Those that work: threads of all ranks.
    hands: u64,
    /// Blocks in the largest batch so far.
    largest: u64,
    /// Results of batches, by their first block.
    waiting: BTreeMap<u64, Vec<T>>,
    is_stopped: bool,
}

/// How fast one of those that work is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    /// Blocks in a batch that takes as long as it should.
    blocks: u64,
    /// Threads that share a batch.
    hands: u64,
}

impl Pace {
    /// Not known yet, of so many threads that share a batch.
    pub(super) fn new(hands: usize) -> Self {
        Self { blocks: hands as u64, hands: hands as u64 }
    }

    /// A batch took so long, and its results have so many bytes.
    pub(super) fn saw(&mut self, blocks: usize, taken: Duration, bytes: usize) {
        let by_time = BATCH.as_secs_f64() * blocks as f64 / taken.as_secs_f64().max(1e-9);
        let by_size = MOST_BYTES.saturating_mul(blocks as u64) / (bytes as u64).max(1);
        self.blocks = (by_time as u64).clamp(self.hands, MOST_BLOCKS.max(self.hands)).min(by_size).max(1);
    }
}

impl<T> Desk<T> {
    pub(super) fn new(blocks: Range<u64>, hands: usize) -> Self {
        Self {
            next: blocks.start,
            end: blocks.end,
            taken: blocks.start,
            hands: hands as u64,
            largest: 1,
            waiting: BTreeMap::new(),
            is_stopped: false,
        }
    }

    /// The next batch; `None` if there is none, or if too many results wait already.
    pub(super) fn assign(&mut self, pace: &Pace) -> Option<Range<u64>> {
        let left = self.end.saturating_sub(self.next);
        if left == 0 || self.is_stopped {
            return None;
        }
        // A fair part of a fraction of what is left, so that all finish together.
        let share = left.div_ceil(4 * self.hands).saturating_mul(pace.hands);
        let batch = pace.blocks.min(share).min(left).max(1);
        let largest = self.largest.max(batch);
        if self.next - self.taken >= LEAD.saturating_mul(self.hands).saturating_mul(largest) {
            return None;
        }
        self.largest = largest;
        let first = self.next;
        self.next += batch;
        Some(first..self.next)
    }

    /// The results of a batch.
    pub(super) fn arrive(&mut self, first: u64, results: Vec<T>) {
        self.waiting.insert(first, results);
    }

    /// The results of the next batch in order, if they are there.
    pub(super) fn take(&mut self) -> Option<Vec<T>> {
        if self.is_stopped {
            return None;
        }
        let results = self.waiting.remove(&self.taken)?;
        self.taken += results.len() as u64;
        Some(results)
    }

    /// Nothing more is begun or taken.
    pub(super) fn stop(&mut self) {
        self.is_stopped = true;
        self.waiting.clear();
    }

    /// Whether all is taken, or stopped.
    pub(super) fn is_done(&self) -> bool {
        self.is_stopped || self.taken >= self.end
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hands of very different speed: every block is taken once, in order, and few wait.
    #[test]
    fn results_are_taken_in_order_and_few_wait() {
        let mut desk = Desk::new(5..20_000, 3);
        let mut paces = [1, 1, 1].map(Pace::new);
        let speeds = [20.0, 100.0, 3000.0].map(|micros: f64| micros * 1e-6);
        let mut busy: [Option<(f64, Range<u64>)>; 3] = Default::default();
        let (mut expected, mut time) = (5, 0.0);
        while !desk.is_done() {
            for hand in 0..3 {
                if busy[hand].is_none()
                    && let Some(batch) = desk.assign(&paces[hand])
                {
                    busy[hand] = Some((time + speeds[hand] * (batch.end - batch.start) as f64, batch));
                }
            }
            let hand = (0..3)
                .filter(|&hand| busy[hand].is_some())
                .min_by(|&a, &b| busy[a].as_ref().unwrap().0.total_cmp(&busy[b].as_ref().unwrap().0))
                .unwrap();
            let (end, batch) = busy[hand].take().unwrap();
            let blocks = (batch.end - batch.start) as usize;
            paces[hand].saw(blocks, Duration::from_secs_f64(speeds[hand] * blocks as f64), 100 * blocks);
            time = end;
            desk.arrive(batch.start, batch.collect());
            while let Some(results) = desk.take() {
                for number in results {
                    assert_eq!(number, expected);
                    expected += 1;
                }
            }
            let waiting: usize = desk.waiting.values().map(Vec::len).sum();
            assert!(waiting as u64 <= LEAD * 3 * desk.largest, "{waiting} wait");
        }
        assert_eq!(expected, 20_000);
        // Batches of 20 ms: 1000, 200 and 6 blocks; as long as nobody waits, 20 000 blocks take 20 000 / (1 / 20 µs + ...).
        assert!((900..=1000).contains(&desk.largest), "{}", desk.largest);
        let ideal = 19_995.0 / speeds.iter().map(|seconds| 1.0 / seconds).sum::<f64>();
        // At the end one may be left with a batch.
        assert!(time < ideal + 0.04, "{time} s, at best {ideal}");
    }

    #[test]
    fn large_results_come_one_by_one() {
        let mut pace = Pace::new(1);
        pace.saw(1, Duration::from_micros(10), 1 << 30);
        assert_eq!(pace.blocks, 1);
        pace.saw(8, Duration::from_micros(10), 8 << 18);
        assert_eq!(pace.blocks, 4);
        pace.saw(1, Duration::from_secs(100), 8);
        assert_eq!(pace.blocks, 1);
        assert_eq!(Pace::new(4).blocks, 4);
    }

    #[test]
    fn what_is_stopped_gives_nothing() {
        let mut desk = Desk::new(0..100, 1);
        let pace = Pace::new(1);
        let batch = desk.assign(&pace).unwrap();
        desk.stop();
        desk.arrive(batch.start, batch.collect());
        assert!(desk.is_done() && desk.take().is_none() && desk.assign(&pace).is_none());
    }

    /// Of blocks that take long, nobody gets ahead of the oldest one by more than it is allowed.
    #[test]
    fn nobody_runs_far_ahead() {
        let mut desk = Desk::new(0..u64::MAX, 2);
        let pace = Pace::new(1);
        let oldest = desk.assign(&pace).unwrap();
        let mut begun = 1;
        while let Some(batch) = desk.assign(&pace) {
            begun += batch.end - batch.start;
            desk.arrive(batch.start, batch.collect());
            assert!(desk.take().is_none());
        }
        assert_eq!(begun, LEAD * 2);
        desk.arrive(0, oldest.collect());
        assert_eq!(std::iter::from_fn(|| desk.take()).flatten().count() as u64, begun);
    }
}
