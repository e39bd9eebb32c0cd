//! The increments of paths beside each other.

use super::draws::{STEPS, normals, normals_at, normals_of_processes};
use super::group::LanePaths;
use super::source::NoiseSource;
use crate::algebra::lanes::Lanes;
use crate::algebra::scalar::Scalar;
use crate::error::InternalError;
use crate::increments::{Interval, NoiseError};
use crate::noise::blocks::increment;
use crate::noise::step_normals::{place, place_of};
use crate::noise::{Paths, StepNormals};

/// Processes whose normals are drawn beside each other for a path that goes alone.
const PROCESSES_AT_ONCE: usize = 16;

/// The place of the normals of a run among those of all times.
#[derive(Clone, Copy, Debug)]
struct NormalBlocks {
    /// The block of the first step, and the place of that step there.
    first: u64,
    place: u64,
}

impl NormalBlocks {
    /// From the number of the first step on.
    fn from(first: i64) -> Self {
        let (first, place) = place(first);
        Self { first, place: place as u64 }
    }

    /// The place of a step of the run in its block.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn slot(self, step: u64) -> usize {
        ((self.place + step) % STEPS as u64) as usize
    }

    /// The block of a step of the run.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of(self, step: u64) -> u64 {
        self.first.wrapping_add((self.place + step) / STEPS as u64)
    }

    /// Whether no step of the run before this one is in one of the `number` blocks that are drawn with its
    /// own.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn begins(self, step: u64, number: u64) -> bool {
        step == 0 || (self.place + step).is_multiple_of(number * STEPS as u64)
    }
}

/// The source of the increments of `L` paths.
enum IncrementSource<'j, const L: usize> {
    /// Normals with these keys, by process; those that more is made of than increments are kept, by process
    /// and step.
    Normals(Vec<[u32; 8]>, Vec<[[f64; L]; STEPS]>),
    /// The key of the first process, and increments of one path, which goes alone, in the order of `values`.
    OnePath([u32; 8], Vec<f64>),
    /// For paths `2k` and `2k + 1` the normals of path `k`, as they are and negated.
    Pairs(Vec<[u32; 8]>, Vec<[[f64; L]; STEPS]>),
    /// A noise for each path, and the increments of one of them.
    Each(Vec<Box<dyn Paths + 'j>>, Vec<f64>),
}

/// The increments of `L` paths.
pub(super) struct LaneIncrements<'j, const L: usize> {
    origin: IncrementSource<'j, L>,
    /// Number of the first path.
    path: u64,
    processes: usize,
    blocks: NormalBlocks,
    /// `√|h|`
    deviation: f64,
    /// The largest normal, in absolute value.
    clip: f64,
    /// The increments of `STEPS` steps, step after step.
    values: Vec<Lanes<L>>,
}

impl<'j, const L: usize> LaneIncrements<'j, L> {
    /// Increments of so many processes in steps of size `h`.
    pub(super) fn new(source: &'j NoiseSource<'_>, processes: usize, h: f64) -> Self {
        let keys = source
            .normals
            .as_ref()
            .map(|normals| (0..processes).map(|k| normals.key(k as u64, h)).collect::<Vec<_>>());
        let origin = match keys {
            Some(keys) if source.is_antithetic() => {
                IncrementSource::Pairs(keys, vec![[[0.0; L]; STEPS]; processes])
            }
            Some(keys) => IncrementSource::Normals(keys, Vec::new()),
            None => IncrementSource::Each((0..L).map(|_| source.path(0)).collect(), vec![0.0; processes]),
        };
        let values = vec![Lanes::from_f64(0.0); STEPS * processes];
        // Rows of other noises are numbered from the first step on.
        let blocks = NormalBlocks::from(source.normals.as_ref().map_or(0, StepNormals::first));
        Self { origin, path: 0, processes, blocks, deviation: h.abs().sqrt(), clip: source.clip(h), values }
    }

    /// Draws many processes of one path at once, in place of one process of many paths.
    pub(super) fn draw_one_path(&mut self) {
        if let IncrementSource::Normals(keys, _) = &self.origin
            && let Some(&key) = keys.first()
        {
            self.origin = IncrementSource::OnePath(key, vec![0.0; STEPS * self.processes]);
            self.values = Vec::new();
        }
    }

    /// Also keeps the normals, from which multilevel runs make the increments of coarser paths.
    pub(super) fn keep_normals(&mut self) {
        if let IncrementSource::Normals(keys, kept) = &mut self.origin {
            kept.resize(keys.len(), [[0.0; L]; STEPS]);
        }
    }

    /// Goes to paths `path ..`.
    pub(super) fn begin(&mut self, path: u64) {
        self.path = path;
        if let IncrementSource::Each(noises, _) = &mut self.origin {
            noises.iter_mut().zip(path..).for_each(|(noise, path)| noise.set_path(path));
        }
    }

    /// Draws the increments of a step, of those lanes whose paths go on; steps are drawn in order.
    ///
    /// # Errors
    /// The error of a noise that has none.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn draw(&mut self, interval: &Interval, lanes: &LanePaths<L>) -> Result<(), NoiseError> {
        let (step, processes, blocks) = (interval.step, self.processes, self.blocks);
        match &mut self.origin {
            IncrementSource::Normals(keys, kept) => {
                if !blocks.begins(step, 1) {
                    return Ok(());
                }
                let mut drawn = [[0.0; L]; STEPS];
                for (process, key) in keys.iter().enumerate() {
                    normals(key, self.path, blocks.of(step), &mut drawn);
                    for (step, drawn) in drawn.iter().enumerate() {
                        self.values[step * processes + process] =
                            increment(*drawn, self.clip, self.deviation);
                    }
                    if let Some(kept) = kept.get_mut(process) {
                        *kept = drawn;
                    }
                }
            }
            IncrementSource::OnePath(..) => {
                if blocks.begins(step, 1) {
                    self.draw_processes(blocks.of(step));
                }
            }
            IncrementSource::Pairs(..) => self.draw_pairs(step),
            IncrementSource::Each(..) => self.ask(interval, lanes)?,
        }
        Ok(())
    }

    /// Draws the increments of a last step that is shorter, of size `h` from the start of `interval` on, of
    /// those lanes whose paths go on.
    ///
    /// # Errors
    /// The error of a noise that has none.
    pub(super) fn draw_last(
        &mut self,
        source: &NoiseSource<'_>,
        interval: &Interval,
        h: f64,
        lanes: &LanePaths<L>,
    ) -> Result<(), NoiseError> {
        let (path, step, processes) = (self.path, interval.step, self.processes);
        if processes == 0 {
            return Ok(());
        }
        if let (IncrementSource::Normals(..), Some(noise)) = (&self.origin, &source.normals) {
            let ((block, place), mut drawn) = (place_of(interval.begin(), h)?, [[0.0; L]; STEPS]);
            let (clip, deviation) = (source.clip(h), h.abs().sqrt());
            for (process, to) in (0..).zip(self.of_mut(step)) {
                normals(&noise.key(process, h), path, block, &mut drawn);
                *to = increment(drawn[place], clip, deviation);
            }
            return Ok(());
        }
        let mut alone = vec![0.0; processes];
        for lane in 0..L {
            if !lanes.goes_on(lane) {
                continue;
            }
            match &mut self.origin {
                IncrementSource::Each(noises, _) => {
                    noises[lane].increments_of_part(interval, h, &mut alone)?
                }
                _ => source.path(path + lane as u64).increments_of_part(interval, h, &mut alone)?,
            }
            check_finite(step, &alone)?;
            self.set(lane, step, &alone);
        }
        Ok(())
    }

    /// Draws many processes of one path at once.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn draw_processes(&mut self, block: u64) {
        let IncrementSource::OnePath(key, values) = &mut self.origin else { return };
        let mut drawn = [[0.0; PROCESSES_AT_ONCE]; STEPS];
        for first in (0..self.processes).step_by(PROCESSES_AT_ONCE) {
            let end = self.processes.min(first + PROCESSES_AT_ONCE);
            normals_of_processes(key, first as u64, (self.path, block), &mut drawn);
            for (row, drawn) in values.chunks_exact_mut(self.processes).zip(&drawn) {
                let drawn = increment(*drawn, self.clip, self.deviation).to_array();
                row[first..end].copy_from_slice(&drawn[..end - first]);
            }
        }
    }

    /// Half of the lanes that are drawn at once are for the steps after the next [`STEPS`].
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn draw_pairs(&mut self, step: u64) {
        let (blocks, IncrementSource::Pairs(keys, drawn)) = (self.blocks, &mut self.origin) else { return };
        if blocks.begins(step, 2) {
            let (first, block, half) = (self.path / 2, blocks.of(step), L as u64 / 2);
            for (key, to) in keys.iter().zip(drawn.iter_mut()) {
                let address = |lane| (first.wrapping_add(lane % half), block.wrapping_add(lane / half));
                normals_at(key, address, to);
            }
        }
        let half = (blocks.of(step).wrapping_sub(blocks.first) % 2) as usize;
        let within = blocks.slot(step);
        for process in 0..self.processes {
            let IncrementSource::Pairs(_, drawn) = &self.origin else { return };
            let drawn = &drawn[process][within];
            let signed = |lane: usize| {
                let normal = drawn[half * (L / 2) + lane / 2];
                if lane.is_multiple_of(2) { normal } else { -normal }
            };
            self.drive(process, step, Lanes::new(std::array::from_fn(signed)));
        }
    }

    /// Asks the noise of each path.
    #[inline(never)]
    fn ask(&mut self, interval: &Interval, lanes: &LanePaths<L>) -> Result<(), NoiseError> {
        let IncrementSource::Each(noises, alone) = &mut self.origin else { return Ok(()) };
        let (_, to) = self.values.split_at_mut(self.blocks.slot(interval.step) * self.processes);
        for (lane, noise) in noises.iter_mut().enumerate() {
            if !lanes.goes_on(lane) {
                continue;
            }
            noise.increments(interval, alone)?;
            check_finite(interval.step, alone)?;
            for (to, from) in to.iter_mut().zip(&*alone) {
                to.set(lane, *from);
            }
        }
        Ok(())
    }

    /// The normals of a step that has been drawn, before truncation.
    ///
    /// # Errors
    /// [`InternalError`] where they are not kept.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn normals(&self, process: usize, step: u64) -> Result<Lanes<L>, InternalError> {
        let kept =
            if let IncrementSource::Normals(_, kept) = &self.origin { kept.get(process) } else { None };
        let missing = || InternalError::new("normals are kept where they are asked for", process);
        kept.map(|kept| Lanes::new(kept[self.blocks.slot(step)])).ok_or_else(missing)
    }

    /// Sets the increments of a step from normals.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn drive(&mut self, process: usize, step: u64, normals: Lanes<L>) {
        let place = self.blocks.slot(step) * self.processes + process;
        self.values[place] = increment(normals.to_array(), self.clip, self.deviation);
    }

    /// The increments of a step that has been drawn, by process.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn of(&self, step: u64) -> &[Lanes<L>] {
        let first = self.blocks.slot(step) * self.processes;
        let row = self.values.get(first..first + self.processes);
        debug_assert!(row.is_some(), "the row of a step is there");
        // Too few increments are an error of the step.
        row.unwrap_or_default()
    }

    /// The increments of a lane in a step that has been drawn, by process: where they are, or in `room`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn of_lane<'s>(&'s self, lane: usize, step: u64, room: &'s mut Vec<f64>) -> &'s [f64] {
        if let IncrementSource::OnePath(_, values) = &self.origin {
            let row = values.get(self.blocks.slot(step) * self.processes..);
            // Too few increments are an error of the step.
            return row.and_then(|row| row.get(..self.processes)).unwrap_or_default();
        }
        room.clear();
        room.extend(self.of(step).iter().map(|dw| dw[lane]));
        room
    }

    /// Replaces the increments of a lane.
    pub(super) fn set(&mut self, lane: usize, step: u64, dw: &[f64]) {
        if let IncrementSource::OnePath(_, values) = &mut self.origin {
            let row = values.chunks_exact_mut(self.processes.max(1)).nth(self.blocks.slot(step));
            row.into_iter().for_each(|row| row.copy_from_slice(dw));
        } else {
            self.of_mut(step).iter_mut().zip(dw).for_each(|(to, from)| to.set(lane, *from));
        }
    }

    /// The increments of [`LaneIncrements::of`], to be changed.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn of_mut(&mut self, step: u64) -> &mut [Lanes<L>] {
        let first = self.blocks.slot(step) * self.processes;
        self.values.get_mut(first..first + self.processes).unwrap_or_default()
    }
}

/// Whether the increments of a step are numbers.
fn check_finite(step: u64, dw: &[f64]) -> Result<(), NoiseError> {
    match dw.iter().position(|dw| !dw.is_finite()) {
        Some(process) => Err(NoiseError::NonFinite { step, process, value: dw[process] }),
        None => Ok(()),
    }
}
