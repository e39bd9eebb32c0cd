//! Who does which blocks, and in which order the results are taken.

#![cfg_attr(not(feature = "mpi"), allow(dead_code, reason = "ranks need more of it than threads"))]

use std::collections::{BTreeMap, VecDeque};
use std::ops::Range;
use std::time::Duration;

/// Batches per hand that may be begun before the oldest one is taken: bounds the results that wait.
pub(crate) const LEAD: u64 = 4;
/// How long a batch should take: long against a message, short against a run.
const BATCH: Duration = Duration::from_millis(20);
/// Bytes of results that a batch should not exceed, unless one block does.
const MOST_BYTES: u64 = 1 << 20;
/// A batch that takes so many times as long as the slowest block so far would have it, and [`PATIENCE`] more,
/// is given to others, too.
const SLOWER: u32 = 10;
/// How long to wait for whoever does not answer: long against a message and a batch, short against a run.
pub(crate) const PATIENCE: Duration = Duration::from_secs(1);
/// Blocks in a batch, at most.
const MOST_BLOCKS: u64 = 1 << 12;

/// Blocks that are not begun, and results that wait for others before them.
pub(crate) struct Queue<T> {
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
    /// Batches that are begun once more: whoever has them does not answer.
    again: VecDeque<Range<u64>>,
    /// The time for a block of the slowest batch so far.
    slowest: Option<Duration>,
    is_stopped: bool,
}

/// How fast one of those that work is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WorkerSpeed {
    /// Blocks in a batch that takes as long as it should.
    blocks: u64,
    /// Threads that share a batch.
    hands: u64,
}

impl WorkerSpeed {
    /// Blocks come one by one.
    pub(crate) const SINGLE: Self = Self { blocks: 1, hands: 1 };

    /// Not known yet, of so many threads that share a batch.
    pub(crate) fn new(hands: usize) -> Self {
        Self { blocks: hands as u64, hands: hands as u64 }
    }

    /// A batch took so long, and its results have so many bytes.
    pub(crate) fn saw(&mut self, blocks: usize, taken: Duration, bytes: usize) {
        let by_time = BATCH.as_secs_f64() * blocks as f64 / taken.as_secs_f64().max(1e-9);
        let by_size = MOST_BYTES.saturating_mul(blocks as u64) / (bytes as u64).max(1);
        self.blocks = (by_time as u64).clamp(self.hands, MOST_BLOCKS.max(self.hands)).min(by_size).max(1);
    }
}

impl<T> Queue<T> {
    pub(crate) fn new(blocks: Range<u64>, hands: usize) -> Self {
        Self {
            next: blocks.start,
            end: blocks.end,
            taken: blocks.start,
            hands: hands as u64,
            largest: 1,
            waiting: BTreeMap::new(),
            again: VecDeque::new(),
            slowest: None,
            is_stopped: false,
        }
    }

    /// The next batch; `None` if there is none, or if too many results wait already.
    pub(crate) fn assign(&mut self, pace: &WorkerSpeed) -> Option<Range<u64>> {
        if self.is_stopped {
            return None;
        }
        while let Some(batch) = self.again.pop_front() {
            if self.misses(batch.start) {
                return Some(batch);
            }
        }
        let left = self.end.saturating_sub(self.next);
        if left == 0 {
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

    /// The results of a batch, which took so long. A batch that was done twice has the same results both
    /// times, and the first count.
    pub(crate) fn arrive(&mut self, first: u64, results: Vec<T>, taken: Duration) {
        if let Ok(blocks) = u32::try_from(results.len())
            && let Some(each) = taken.checked_div(blocks)
        {
            self.slowest = self.slowest.max(Some(each));
        }
        if self.misses(first) {
            self.waiting.insert(first, results);
        }
    }

    /// Whether the batch that begins with this block was begun and has not arrived.
    pub(crate) fn misses(&self, first: u64) -> bool {
        (self.taken..self.next).contains(&first) && !self.waiting.contains_key(&first)
    }

    /// Lets others do a batch that was begun.
    pub(crate) fn repeat(&mut self, batch: Range<u64>) {
        if self.misses(batch.start) {
            self.again.push_back(batch);
        }
    }

    /// How long a batch of so many blocks may take before others do it, too; not known before the first one
    /// is done.
    pub(crate) fn patience(&self, blocks: u64) -> Option<Duration> {
        let blocks = u32::try_from(blocks).unwrap_or(u32::MAX);
        self.slowest.map(|block| block.saturating_mul(blocks).saturating_mul(SLOWER).saturating_add(PATIENCE))
    }

    /// The first block and the results of the next batch in order, if they are there.
    pub(crate) fn pop_batch(&mut self) -> Option<(u64, Vec<T>)> {
        if self.is_stopped {
            return None;
        }
        let first = self.taken;
        let results = self.waiting.remove(&first)?;
        self.taken += results.len() as u64;
        Some((first, results))
    }

    /// Whether no block will be begun any more.
    pub(crate) fn has_begun_all(&self) -> bool {
        self.is_stopped || self.next >= self.end
    }

    /// Nothing more is begun or taken.
    pub(crate) fn stop(&mut self) {
        self.is_stopped = true;
        self.waiting.clear();
        self.again.clear();
    }

    /// Whether all is taken, or stopped.
    pub(crate) fn is_done(&self) -> bool {
        self.is_stopped || self.taken >= self.end
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hands of very different speed: every block is taken once, in order, and few wait.
    #[test]
    fn results_are_taken_in_order_and_few_wait() {
        let mut queue = Queue::new(5..20_000, 3);
        let mut paces = [1, 1, 1].map(WorkerSpeed::new);
        let speeds = [20.0, 100.0, 3000.0].map(|micros: f64| micros * 1e-6);
        let mut busy: [Option<(f64, Range<u64>)>; 3] = Default::default();
        let (mut expected, mut time) = (5, 0.0);
        while !queue.is_done() {
            for hand in 0..3 {
                if busy[hand].is_none()
                    && let Some(batch) = queue.assign(&paces[hand])
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
            queue.arrive(batch.start, batch.collect(), Duration::ZERO);
            while let Some((_, results)) = queue.pop_batch() {
                for number in results {
                    assert_eq!(number, expected);
                    expected += 1;
                }
            }
            let waiting: usize = queue.waiting.values().map(Vec::len).sum();
            assert!(waiting as u64 <= LEAD * 3 * queue.largest, "{waiting} wait");
        }
        assert_eq!(expected, 20_000);
        // Batches of 20 ms: 1000, 200 and 6 blocks; as long as nobody waits, 20 000 blocks take 20 000 / (1 /
        // 20 µs + ...).
        assert!((900..=1000).contains(&queue.largest), "{}", queue.largest);
        let ideal = 19_995.0 / speeds.iter().map(|seconds| 1.0 / seconds).sum::<f64>();
        // At the end one may be left with a batch.
        assert!(time < ideal + 0.04, "{time} s, at best {ideal}");
    }

    #[test]
    fn large_results_come_one_by_one() {
        let mut pace = WorkerSpeed::new(1);
        pace.saw(1, Duration::from_micros(10), 1 << 30);
        assert_eq!(pace.blocks, 1);
        pace.saw(8, Duration::from_micros(10), 8 << 18);
        assert_eq!(pace.blocks, 4);
        pace.saw(1, Duration::from_secs(100), 8);
        assert_eq!(pace.blocks, 1);
        assert_eq!(WorkerSpeed::new(4).blocks, 4);
    }

    #[test]
    fn what_is_stopped_gives_nothing() {
        let mut queue = Queue::new(0..100, 1);
        let pace = WorkerSpeed::new(1);
        let batch = queue.assign(&pace).unwrap();
        queue.stop();
        queue.arrive(batch.start, batch.collect(), Duration::ZERO);
        assert!(queue.is_done() && queue.pop_batch().is_none() && queue.assign(&pace).is_none());
    }

    /// A worker that does not answer delays nobody: others do its work, and late results are not taken twice.
    #[test]
    fn what_does_not_come_is_done_by_others() {
        let mut queue = Queue::new(0..100, 2);
        let pace = WorkerSpeed::new(1);
        let stalled = queue.assign(&pace).unwrap();
        assert_eq!(queue.patience(1), None);
        while let Some(batch) = queue.assign(&pace) {
            queue.arrive(batch.start, batch.collect(), Duration::from_millis(30));
        }
        assert!(queue.pop_batch().is_none());
        assert_eq!(queue.patience(2), Some(PATIENCE + Duration::from_millis(600)));
        queue.repeat(stalled.clone());
        assert_eq!(queue.assign(&pace), Some(stalled.clone()));
        queue.repeat(stalled.clone());
        queue.arrive(stalled.start, stalled.clone().collect(), Duration::ZERO);
        let mut done: Vec<u64> =
            std::iter::from_fn(|| queue.pop_batch()).flat_map(|(_, results)| results).collect();
        queue.arrive(stalled.start, stalled.clone().collect(), Duration::ZERO);
        assert!(!queue.misses(stalled.start));
        while let Some(batch) = queue.assign(&pace) {
            assert!(batch.start >= done.len() as u64, "{batch:?} is done");
            queue.arrive(batch.start, batch.collect(), Duration::ZERO);
            done.extend(std::iter::from_fn(|| queue.pop_batch()).flat_map(|(_, results)| results));
        }
        assert!(queue.is_done());
        assert_eq!(done, (0..100).collect::<Vec<_>>());
    }

    /// If blocks take long, no worker gets ahead of the oldest one by more than it is allowed.
    #[test]
    fn nobody_runs_far_ahead() {
        let mut queue = Queue::new(0..u64::MAX, 2);
        let pace = WorkerSpeed::new(1);
        let oldest = queue.assign(&pace).unwrap();
        let mut begun = 1;
        while let Some(batch) = queue.assign(&pace) {
            begun += batch.end - batch.start;
            queue.arrive(batch.start, batch.collect(), Duration::ZERO);
            assert!(queue.pop_batch().is_none());
        }
        assert_eq!(begun, LEAD * 2);
        queue.arrive(0, oldest.collect(), Duration::ZERO);
        assert_eq!(
            std::iter::from_fn(|| queue.pop_batch()).flat_map(|(_, results)| results).count() as u64,
            begun
        );
    }
}
