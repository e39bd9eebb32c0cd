//! A checked ensemble: everything that its blocks share.

use std::ops::{ControlFlow, Range};
use std::sync::OnceLock;

use super::block::{Block, PATHS};
use super::dispatch::InstructionSet;
use super::source::Source;
use super::statistics::{Statistics, Wanted};
use crate::increments::NoiseError;
use crate::lanes::Lanes;
use crate::retry::Retry;
use crate::schedule::in_order;
use crate::state::State;
use crate::system::Discretized;

/// A function of the state.
pub(super) type Observable<'a, V> = Box<dyn Fn(&State<V>) -> f64 + Send + Sync + 'a>;

/// A run of paths that are known by their numbers.
pub(super) struct Job<'a, H: Discretized<E>, E> {
    pub(super) system: &'a H,
    pub(super) prepared: H::Prepared,
    pub(super) h: f64,
    pub(super) start: State<H::Vector>,
    pub(super) paths: u64,
    pub(super) steps: u64,
    /// Steps before each recorded node: 0 first, all last.
    pub(super) recorded: Vec<u64>,
    pub(super) source: Source<'a>,
    /// The largest normal, in absolute value.
    pub(super) clip: f64,
    pub(super) retry: Retry,
    /// Why a noise that was given had no increments, which ends the run.
    pub(super) failed_noise: OnceLock<NoiseError>,
    pub(super) observables: Vec<Observable<'a, H::Vector>>,
    pub(super) events: Vec<Observable<'a, H::Vector>>,
    pub(super) wanted: Wanted,
    /// Level of a multilevel run: its paths have their own normals. 0 if there are no others.
    pub(super) level: u32,
    /// Whether path `2k + 1` has the normals of path `2k`, negated.
    pub(super) is_antithetic: bool,
    pub(super) stop: Stop<'a>,
}

/// Says when to stop.
pub(super) type Stop<'a> = &'a (dyn Fn() -> bool + Sync);

impl<H: Discretized<E>, E> Job<'_, H, E> {
    /// Ends the run: without increments there is nothing to say.
    pub(super) fn fail_noise(&self, error: NoiseError) {
        // One of the reasons is enough.
        let _ = self.failed_noise.set(error);
    }

    pub(super) fn has_failed(&self) -> bool {
        self.failed_noise.get().is_some()
    }

    /// Increments from standard normals: truncated, times `√|h|`.
    #[inline(always)]
    pub(super) fn increment<const L: usize>(&self, normals: Lanes<L>, deviation: f64) -> Lanes<L> {
        let mut dw = normals.to_array();
        for dw in &mut dw {
            // As `clamp`, which takes more instructions because of NaN.
            let z = if *dw < self.clip { *dw } else { self.clip };
            let z = if z > -self.clip { z } else { -self.clip };
            *dw = z * deviation;
        }
        Lanes::new(dw)
    }
}

impl<H, E> Job<'_, H, E>
where
    H: Discretized<E> + Sync,
    H::Vector: Send + Sync,
    H::Prepared: Send + Sync,
{
    /// The numbers of all blocks: block `n` has the paths from `n PATHS` on.
    pub(super) fn blocks(&self) -> Range<u64> {
        0..self.paths.div_ceil(PATHS)
    }

    /// Runs blocks on so many threads, `WIDTH` paths beside each other (with 0 as many as suit the instructions), and gives their
    /// statistics to `take` in the order of their numbers, until it breaks; `None` for one that was stopped on the way, which is
    /// the last.
    pub(super) fn run<const WIDTH: usize>(
        &self,
        blocks: Range<u64>,
        threads: usize,
        instructions: InstructionSet,
        mut take: impl FnMut(Option<Statistics>) -> ControlFlow<()> + Send,
    ) {
        let work = |number| instructions.run(Block::<H, E, WIDTH> { job: self, number });
        in_order(blocks, threads, work, |_, statistics| take(statistics));
    }
}
