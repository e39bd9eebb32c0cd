//! A part of a block, for runs of few blocks: what its paths showed, path by path.
//!
//! Sums over the paths of a block are added in the order of the paths. So that a block may be shared by threads, each notes what its paths
//! add, and whoever has all the parts adds it: the bits are those of a block that one thread works on.

use crate::statistics::Passage;
use crate::statistics::{PathTally, Statistics, Wanted};

/// A block that is shared is noted if that takes no more bytes.
const MOST_BYTES: u128 = 1 << 26;
/// Paths in a part, or a multiple, where they go beside each other: none of the vector registers is wider.
const LEAST_PATHS: u64 = 32;
/// Parts for each thread: they are not done at the same time.
const PARTS: u64 = 4;

/// How many paths each piece of a block of `block` paths has, on so many threads, if `blocks` of `paths` are to be done, which go one by one or not.
pub(super) fn size(
    wanted: &Wanted,
    block: u64,
    (blocks, paths): (u64, u64),
    one_by_one: bool,
    threads: usize,
) -> u64 {
    let least = if one_by_one { 1 } else { LEAST_PATHS };
    // A block that is not full has no more than this.
    let full = paths.clamp(least, block).next_power_of_two();
    let (wide, threads) = (wanted.times.len() as u128 * (wanted.names.len() as u128 + 1), threads as u64);
    let is_short = wide * u128::from(block) * size_of::<f64>() as u128 <= MOST_BYTES;
    let pieces = (PARTS * threads).div_ceil(blocks.max(1)).min(full / least);
    if threads < 2 || !is_short || pieces < 2 { block } else { full / pieces.next_power_of_two() }
}

/// What paths add to sums, in the order of their numbers.
#[derive(Debug)]
pub(super) struct Notes {
    /// By recorded node.
    nodes: Vec<NodeNotes>,
    /// By event and path.
    passages: Vec<Vec<Passage>>,
    /// By section and path, the number of crossings.
    crossings: Vec<Vec<u64>>,
}

/// The observables of each path that had any.
#[derive(Clone, Debug, Default)]
struct NodeNotes {
    is_there: Vec<bool>,
    values: Vec<f64>,
}

impl Notes {
    pub(super) fn new(wanted: &Wanted) -> Self {
        Self {
            nodes: vec![NodeNotes::default(); wanted.times.len()],
            passages: vec![Vec::new(); wanted.watches.len()],
            crossings: vec![Vec::new(); wanted.sections],
        }
    }

    /// Adds everything to the statistics of the block.
    fn add_to(&self, block: &mut Statistics, wanted: &Wanted) {
        let observables = wanted.names.len();
        let mut tally = PathTally::new(observables);
        for (node, NodeNotes { is_there, values }) in block.nodes.iter_mut().zip(&self.nodes) {
            let mut rows = values.chunks_exact(observables.max(1));
            for is_there in is_there {
                let row = if *is_there { rows.next() } else { None };
                node.tally(row, &mut tally, wanted);
            }
        }
        for ((passages, noted), watch) in block.passages.iter_mut().zip(&self.passages).zip(&wanted.watches) {
            noted.iter().for_each(|passage| passages.push(*passage, watch));
        }
        for (crossings, noted) in block.crossings.iter_mut().zip(&self.crossings) {
            noted.iter().for_each(|count| crossings.finish(*count));
        }
    }
}

/// What some paths of a run found out: sums at once, or noted.
#[derive(Debug)]
pub(super) struct Piece {
    pub(super) statistics: Statistics,
    notes: Option<Notes>,
    tally: PathTally,
}

impl Piece {
    /// Of a whole block, or of a part of one.
    pub(super) fn new(wanted: &Wanted, is_part: bool) -> Self {
        Self {
            statistics: Statistics::new(wanted),
            notes: is_part.then(|| Notes::new(wanted)),
            tally: PathTally::new(wanted.names.len()),
        }
    }

    /// The observables of the next path at a recorded node; none if it failed before.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn see(&mut self, node: usize, values: Option<&[f64]>, wanted: &Wanted) {
        match &mut self.notes {
            None => {
                if let Some(node) = self.statistics.nodes.get_mut(node) {
                    node.tally(values, &mut self.tally, wanted);
                }
            }
            Some(notes) => {
                if let Some(NodeNotes { is_there, values: noted }) = notes.nodes.get_mut(node) {
                    is_there.push(values.is_some());
                    noted.extend_from_slice(values.unwrap_or_default());
                }
            }
        }
    }

    /// When the next path passed an event.
    pub(super) fn pass(&mut self, event: usize, passage: Passage, wanted: &Wanted) {
        match &mut self.notes {
            None => self.statistics.passages[event].push(passage, &wanted.watches[event]),
            Some(notes) => notes.passages[event].push(passage),
        }
    }

    /// How often the next path crossed a section.
    pub(super) fn cross(&mut self, section: usize, count: u64) {
        match &mut self.notes {
            None => self.statistics.crossings[section].finish(count),
            Some(notes) => notes.crossings[section].push(count),
        }
    }

    /// Adds a piece to those of the same block before it.
    pub(super) fn add_to(self, block: Option<Statistics>, wanted: &Wanted) -> Statistics {
        let Some(notes) = self.notes else { return self.statistics };
        let mut block = block.unwrap_or_else(|| Statistics::new(wanted));
        notes.add_to(&mut block, wanted);
        block.merge(&self.statistics);
        block
    }
}
