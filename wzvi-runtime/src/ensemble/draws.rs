//! The normals of many paths beside each other ([`StepNormals`](crate::noise::StepNormals)): one for every
//! (seed, step size, process, path, step).

use std::ops::Range;

use crate::algebra::lanes::instructions::{InstructionSet, Kernel};
use crate::noise::blocks::{BlockKey, draw_lanes};
pub(crate) use crate::noise::step_normals::STEPS;
use crate::noise::step_normals::{key, of_process};

/// The standard normals of one process of an ensemble, before truncation, in blocks of ten steps: block `b`
/// is for the steps from `10 b` on. The number of a step is that of its time, `⌊t/h⌋`.
#[derive(Clone, Copy, Debug)]
pub struct Normals {
    key: [u32; 8],
}

impl Normals {
    /// The normals of process `process`, from 0, for this seed and steps of size `h`.
    pub fn new(seed: u64, process: u64, h: f64) -> Self {
        Self { key: key(seed, process, h, 0) }
    }

    /// One block of one path.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn of_path(&self, path: u64, block: u64) -> [f64; STEPS] {
        let mut drawn = [[0.0; 1]; STEPS];
        normals(&self.key, path, block, &mut drawn);
        drawn.map(|[normal]| normal)
    }

    /// Visits blocks of 16 paths beside each other, as `[step][path]`: of the first 16 `paths`, all `blocks`
    /// in order, then of the next 16. A last group that is not full has the paths that follow.
    pub fn visit(
        &self,
        paths: Range<u64>,
        blocks: Range<u64>,
        set: InstructionSet,
        visit: impl FnMut(&[[f64; 16]; STEPS]),
    ) {
        set.run(NormalsVisit { key: &self.key, paths, blocks, visit });
    }
}

struct NormalsVisit<'k, F> {
    key: &'k [u32; 8],
    paths: Range<u64>,
    blocks: Range<u64>,
    visit: F,
}

impl<F: FnMut(&[[f64; 16]; STEPS])> Kernel for NormalsVisit<'_, F> {
    type Output = ();

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run<const L: usize, const HALF: usize>(self) {
        let Self { key, paths, blocks, mut visit } = self;
        let mut drawn = [[0.0; 16]; STEPS];
        let mut path = paths.start;
        while path < paths.end {
            for block in blocks.clone() {
                normals(key, path, block, &mut drawn);
                visit(&drawn);
            }
            path += 16;
        }
    }
}

/// Normals of steps `STEPS * block ..` of paths `path ..`: `[step][path]`.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn normals<const L: usize>(key: &[u32; 8], path: u64, block: u64, to: &mut [[f64; L]; STEPS]) {
    normals_at(key, |lane| (path.wrapping_add(lane), block), to);
}

/// Normals of steps `STEPS * block ..` of one path and of processes `process ..`: `[step][process]`.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn normals_of_processes<const L: usize>(
    key: &[u32; 8],
    process: u64,
    (path, block): (u64, u64),
    to: &mut [[f64; L]; STEPS],
) {
    draw_lanes(|lane| (of_process(key, process + lane), path, block), to);
}

/// Normals of steps `STEPS * block ..` of a path for each lane, which `address` gives: `[step][lane]`.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn normals_at<const L: usize>(
    key: &[u32; 8],
    address: impl Fn(u64) -> (u64, u64),
    to: &mut [[f64; L]; STEPS],
) {
    if L != 32 {
        return draw_lanes(|lane| with_key(key, address(lane)), to);
    }
    // Twice 16 words do not fit into the registers of AVX-512.
    let mut part = [[0.0; 16]; STEPS];
    for half in 0..2 {
        draw_lanes(|lane| with_key(key, address(16 * half as u64 + lane)), &mut part);
        for (to, part) in to.iter_mut().zip(&part) {
            for i in 0..16 {
                to[16 * half + i] = part[i];
            }
        }
    }
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn with_key(key: &[u32; 8], (path, block): (u64, u64)) -> BlockKey {
    (*key, path, block)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::{Interval, Noise as _, StepNormals};

    /// A normal is a function of its address: no matter how many paths or processes are drawn at once, or
    /// whether one path asks alone.
    #[test]
    fn widths_agree_with_each_other_and_with_the_noise() {
        let h = 0.1;
        let key = key(11, 1, h, 0);
        let mut wide = [[0.0; 32]; STEPS];
        normals(&key, 96, 3, &mut wide);
        let mut processes = [[0.0; 16]; STEPS];
        normals_of_processes(&key, 0, (96, 3), &mut processes);
        assert_eq!(processes.map(|step| step[1]), wide.map(|step| step[0]));
        #[expect(clippy::needless_range_loop, reason = "`first` is the number of a path, too")]
        for first in 0..32 {
            let mut one = [[0.0; 1]; STEPS];
            normals(&key, 96 + first as u64, 3, &mut one);
            let mut noise = StepNormals::seed(11).path(96 + first as u64);
            for k in 0..STEPS {
                assert_eq!(one[k][0], wide[k][first]);
                let mut dw = [0.0; 2];
                noise.increments(&Interval { start: 0.0, h, step: 30 + k as u64 }, &mut dw).unwrap();
                assert_eq!(dw[1], wide[k][first] * h.sqrt());
            }
        }
    }

    /// A path that goes from step to step has blocks ahead, of all processes: the same normals, from any
    /// start, after jumps, with other numbers of processes, negated and truncated.
    #[test]
    fn a_path_has_the_normals_of_lanes() {
        let (h, seed, path) = (0.05, 5, 13);
        for (processes, is_antithetic) in
            [(1, false), (3, true), (8, false), (9, false), (40, true), (300, false)]
        {
            let noise = StepNormals::seed(seed).path(path).truncated(1.0);
            let mut noise = if is_antithetic { noise.antithetic() } else { noise };
            let (sign, stream) = if is_antithetic { (-1.0, path / 2) } else { (1.0, path) };
            let clip = crate::noise::clip_bound(h, 1.0);
            let drawn: Vec<Normals> = (0..processes).map(|process| Normals::new(seed, process, h)).collect();
            let mut dw = vec![0.0; processes as usize];
            for step in (0..230).chain([1000, 3, 7, 12]).chain(995..1025) {
                noise.increments(&Interval { start: 0.0, h, step }, &mut dw).unwrap();
                for (drawn, dw) in drawn.iter().zip(&dw) {
                    let normal = drawn.of_path(stream, step / 10)[step as usize % 10];
                    let expected = (sign * normal).clamp(-clip, clip) * h.sqrt();
                    assert_eq!(dw.to_bits(), expected.to_bits(), "{processes} processes, step {step}");
                }
                // Fewer processes in between.
                if step == 57 && processes > 1 {
                    let mut first = [0.0];
                    noise.increments(&Interval { start: 0.0, h, step }, &mut first).unwrap();
                    assert_eq!(first[0], dw[0]);
                }
            }
        }
    }
}
