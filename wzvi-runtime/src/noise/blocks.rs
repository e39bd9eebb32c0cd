//! Normals beside each other: the blocks of many paths, or of many processes and successive steps of one.
//!
//! Tested by `wzvi-runtime/tests/runtime/ensemble_law.rs`.

#![expect(clippy::needless_range_loop, reason = "plain loops over arrays are what becomes vector code")]

use super::random::{self, pair};
use super::step_normals::{STEPS, of_process};
use crate::algebra::lanes::Lanes;
use crate::algebra::lanes::instructions::{InstructionSet, Kernel};

/// A key, a path and a block of its steps.
pub(crate) type BlockKey = ([u32; 8], u64, u64);

/// The normals of an address for each lane, all at once: `[step][lane]`.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn draw_lanes<const L: usize>(address: impl Fn(u64) -> BlockKey, to: &mut [[f64; L]; STEPS]) {
    let mut words = [[0; L]; 16];
    for i in 0..L {
        let (key, path, block) = address(i as u64);
        let block = random::block(&key, path, block);
        for w in 0..16 {
            words[w][i] = block[w];
        }
    }
    for k in 0..STEPS / 2 {
        for i in 0..L {
            [to[2 * k][i], to[2 * k + 1][i]] =
                pair([words[3 * k][i], words[3 * k + 1][i], words[3 * k + 2][i]]);
        }
    }
}

/// Increments from standard normals: truncated, times `±√|h|`.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn increment<const L: usize>(normals: [f64; L], clip: f64, deviation: f64) -> Lanes<L> {
    let mut dw = normals;
    for dw in &mut dw {
        // As `clamp`, which takes more instructions because of NaN.
        let z = if *dw < clip { *dw } else { clip };
        let z = if z > -clip { z } else { -clip };
        *dw = z * deviation;
    }
    Lanes::new(dw)
}

/// Increments that are stored together: as many as the narrowest lanes have.
const TOGETHER: usize = 4;
/// Blocks that are drawn ahead, at most.
const MOST_BLOCKS: usize = 16;
/// Lanes that are drawn at once: as many as leave few of their last group empty, in the cache of one core.
const MOST_LANES: usize = 256;

/// The increments of one path: some of its blocks, of all processes.
#[derive(Clone, Debug, Default)]
pub(super) struct PathBlocks {
    /// The bits of the step size; no step has the size 0.
    h: u64,
    processes: usize,
    /// The first block, and their number.
    first: u64,
    blocks: usize,
    /// By step and process.
    increments: Vec<f64>,
}

/// The numbers of which the increments of a path are made.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathSource {
    /// The key of the first process.
    pub(super) key: [u32; 8],
    pub(super) stream: u64,
    /// The largest normal, in absolute value.
    pub(super) clip: f64,
    /// `±√|h|`
    pub(super) deviation: f64,
}

impl PathBlocks {
    /// Forgets what was drawn.
    pub(super) fn clear(&mut self) {
        self.blocks = 0;
    }

    /// Whether a block is there, for steps of size `h` and so many processes.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn has(&self, processes: usize, h: f64, block: u64) -> bool {
        self.is_for(processes, h) && block.wrapping_sub(self.first) < self.blocks as u64
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn is_for(&self, processes: usize, h: f64) -> bool {
        self.h == h.to_bits() && self.processes == processes
    }

    /// The increments of the step at a place of a block that is there, by process.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn row(&self, block: u64, place: usize) -> &[f64] {
        let first = (block.wrapping_sub(self.first) as usize * STEPS + place) * self.processes;
        let row = self.increments.get(first..first + self.processes);
        debug_assert!(row.is_some(), "the row of a step is there");
        row.unwrap_or_default()
    }

    /// Draws a block; of a path that goes from block to block, the following ones, too.
    #[inline(never)]
    pub(super) fn draw(&mut self, processes: usize, h: f64, block: u64, source: &PathSource) {
        let follows = self.is_for(processes, h)
            && self.blocks > 0
            && block.wrapping_sub(self.first) == self.blocks as u64;
        let blocks = if follows { (MOST_LANES / processes.max(1)).clamp(1, MOST_BLOCKS) } else { 1 };
        (self.h, self.processes, self.first, self.blocks) = (h.to_bits(), processes, block, blocks);
        self.increments.resize(STEPS * processes * blocks, 0.0);
        let increments = &mut self.increments;
        let set = InstructionSet::best().for_numbers((processes * blocks) as u64);
        set.run(BlocksInLanes { source, processes, first: block, blocks, increments });
    }
}

/// Draws the blocks of all processes.
struct BlocksInLanes<'a> {
    source: &'a PathSource,
    processes: usize,
    first: u64,
    blocks: usize,
    increments: &'a mut [f64],
}

impl Kernel for BlocksInLanes<'_> {
    type Output = ();

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run<const L: usize, const HALF: usize>(self) {
        // Twice 16 words do not fit into the registers of AVX-512.
        if L == 32 { self.fill::<HALF>() } else { self.fill::<L>() }
    }
}

impl BlocksInLanes<'_> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn fill<const L: usize>(self) {
        let Self { source: &PathSource { key, stream, clip, deviation }, processes, first, .. } = self;
        if processes == 0 {
            return;
        }
        let mut drawn = [[0.0; L]; STEPS];
        // The next lane.
        let (mut process, mut number) = (0, 0);
        while number < self.blocks {
            let (mut process_of, mut block_of, mut place_of, mut few) = ([0; L], [0; L], [0; L], 0);
            for i in 0..L {
                if number == self.blocks {
                    break;
                }
                process_of[i] = process as u64;
                block_of[i] = first.wrapping_add(number as u64);
                place_of[i] = number * STEPS * processes + process;
                few += 1;
                process += 1;
                if process == processes {
                    (process, number) = (0, number + 1);
                }
            }
            let address =
                |lane: u64| (of_process(&key, process_of[lane as usize]), stream, block_of[lane as usize]);
            draw_lanes(address, &mut drawn);
            // Lanes of one block have places beside each other, and are stored together.
            let is_one_block = |first: usize| {
                let last = first + TOGETHER - 1;
                last < few && place_of[last] == place_of[first] + TOGETHER - 1
            };
            let mut are_together = [false; L];
            for first in (0..L).step_by(TOGETHER) {
                are_together[first] = is_one_block(first);
            }
            for (step, drawn) in drawn.iter().enumerate() {
                let dw = increment(*drawn, clip, deviation).to_array();
                let of_step = self.increments.get_mut(step * processes..).unwrap_or_default();
                for first in (0..L).step_by(TOGETHER) {
                    if are_together[first] {
                        let place = place_of[first];
                        if let Some(to) = of_step.get_mut(place..place + TOGETHER) {
                            to.copy_from_slice(&dw[first..first + TOGETHER]);
                        }
                        continue;
                    }
                    for i in first..few.min(first + TOGETHER) {
                        if let Some(to) = of_step.get_mut(place_of[i]) {
                            *to = dw[i];
                        }
                    }
                }
            }
        }
    }
}
