//! Linear equations with a diagonal Jacobian `J = I - φ'`: the first correction is the solution, and nothing
//! is compared.
//!
//! ```text
//! Q = q + c Σ ∂T/∂p (p),   v = -J⁻¹ start Σ ∂V/∂q (Q),   u = Σ ∂T/∂p (p + v)
//! ```
//!
//! The forces of a tile depend on its own coordinates only, so that a tile takes all of this at once.

use std::ops::Range;

use super::blocks::add_zeros;
use super::{OffsetSlice, ThreadLists, ThreadTiles, TileResult, TiledSweeps, Tiling, on_threads};
use crate::algebra::lanes::instructions::Kernel;
use crate::algebra::scalar::Scalar;
use crate::scheme::elements::linear::LinearSolver;
use crate::scheme::elements::memory::{IterationMemory, LoopScratch, StepLists};
use crate::scheme::elements::passes::{LoopBody, in_blocks, load, store, subtract};
use crate::scheme::elements::step::LoopStep;
use crate::scheme::elements::{Elements, Partials};

impl<H: Elements + Sync, S: Scalar> LoopStep<'_, H, S> {
    /// The solution of linear equations with a diagonal Jacobian, which is factored: one correction from
    /// zero, and `u`. Returns whether it is finite.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(in crate::scheme::elements) fn solve_diagonal(&self, scratch: &mut LoopScratch<'_, S>) -> bool {
        if const { H::FACTS.has_tiles && H::FACTS.has_constant_curvature && S::MAY_BE_F64 }
            && self.takes_vectors(scratch)
            && let Some(is_finite) = self.solve_diagonal_in_vectors(scratch)
        {
            return is_finite;
        }
        scratch.leave_tiles();
        scratch.guess(0);
        let LoopScratch { lists, solver: IterationMemory { linear, .. }, .. } = scratch;
        self.residual(lists);
        if let Some(LinearSolver::Band(band)) = linear {
            band.solve(lists.correction);
        }
        let relative = subtract(self.scheme.unknowns, lists.x, lists.correction);
        self.refresh(lists);
        !relative.magnitude().is_nan()
    }

    /// [`LoopStep::solve_diagonal`] in vector instructions; `None` if that is not possible.
    #[inline(never)]
    fn solve_diagonal_in_vectors(&self, scratch: &mut LoopScratch<'_, S>) -> Option<bool> {
        let step = self.plain()?;
        let LoopScratch { lists, solver: IterationMemory { linear, sweeps, .. }, threads, .. } = scratch;
        let inverses = match linear {
            Some(LinearSolver::Band(band)) => S::as_f64s(band.inverses()?)?,
            Some(LinearSolver::Bordered(_) | LinearSolver::Krylov(_)) | None => return None,
        };
        let sweeps = sweeps.get_or_insert_with(|| Box::new(TiledSweeps::new(&step, *threads)));
        if !sweeps.tiles.are_independent() {
            return None;
        }
        let StepLists { x, u, .. } = lists.plain()?;
        let TiledSweeps { tiles, by_thread, instructions, .. } = &mut **sweeps;
        let found = on_threads(by_thread, [x, u], |thread_tiles, part| {
            instructions.run(DiagonalSolve { step, tiles, thread_tiles, part, inverses })
        });
        (sweeps.is_ready, sweeps.is_finite) = (true, found.is_finite);
        Some(found.is_finite)
    }
}

/// [`LoopStep::solve_diagonal`] in the tiles of one thread.
struct DiagonalSolve<'a, 's, H> {
    step: LoopStep<'s, H, f64>,
    tiles: &'a Tiling,
    thread_tiles: &'a mut ThreadTiles<Range<usize>>,
    part: ThreadLists<'a, 2>,
    /// The inverse of the Jacobian, for all places.
    inverses: &'a [f64],
}

impl<H: Elements + Sync> Kernel for DiagonalSolve<'_, '_, H> {
    type Output = TileResult;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run<const L: usize, const HALF: usize>(self) -> TileResult {
        let Self { step, tiles, thread_tiles, part: ThreadLists { first, lists }, inverses } = self;
        let [all_x, all_u] = lists;
        let ([point, weight], factor, degrees) = (step.weights(), step.multiple(), step.degrees());
        let mut zeros = [0.0; L];
        for number in thread_tiles.work.clone() {
            let tile = tiles.tile(number);
            let (places, own) = (tile.start..tile.end, tile.start - first..tile.end - first);
            let [q, p, inverses] = [step.q, step.p, inverses].map(|list| &list[places.clone()]);
            let momenta = OffsetSlice { numbers: step.p, first: 0, degrees };
            let velocities = step.gradient_in_tile::<H::CommonRange, _>(
                tile,
                &momenta,
                Partials::BY_MOMENTA,
                &mut thread_tiles.sums,
            );
            // `u` comes last: until then its list has the coordinates, then the momenta.
            in_blocks::<L>(
                places.len(),
                &mut ForceCoordinates { velocities, q, point, next: &mut all_u[own.clone()] },
            );
            let coordinates = OffsetSlice { numbers: all_u, first, degrees };
            let forces = step.gradient_in_tile::<H::CommonRange, _>(
                tile,
                &coordinates,
                Partials::BY_COORDINATES,
                &mut thread_tiles.sums,
            );
            let (x, momentum) = (&mut all_x[own.clone()], &mut all_u[own.clone()]);
            in_blocks::<L>(
                places.len(),
                &mut DiagonalCorrection { forces, weight, inverses, p, x, momentum },
            );
            let momenta = OffsetSlice { numbers: all_u, first, degrees };
            let velocities = step.gradient_in_tile::<H::CommonRange, _>(
                tile,
                &momenta,
                Partials::BY_MOMENTA,
                &mut thread_tiles.sums,
            );
            let (u, x) = (&mut all_u[own.clone()], &all_x[own]);
            in_blocks::<L>(
                places.len(),
                &mut EndOfStep { velocities, q, p, x, factor, u, zeros: &mut zeros },
            );
        }
        // Opaque, since the compiler else cuts the lanes of the pass as the sum would have them.
        TileResult::finite(std::hint::black_box(zeros).iter().sum::<f64>() == 0.0)
    }
}

/// The coordinates for the forces, from the sums of velocities.
struct ForceCoordinates<'a> {
    velocities: &'a [f64],
    q: &'a [f64],
    point: f64,
    next: &'a mut [f64],
}

impl LoopBody for ForceCoordinates<'_> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn apply<const N: usize>(&mut self, first: usize) {
        let (u, mut next) = (load::<_, N>(self.velocities, first), load::<_, N>(self.q, first));
        for i in 0..N {
            next[i] += u[i] * self.point;
        }
        store(self.next, first, next);
    }
}

/// `v = -J⁻¹ start F` and `P`, with a diagonal `J`.
struct DiagonalCorrection<'a> {
    forces: &'a [f64],
    weight: f64,
    inverses: &'a [f64],
    p: &'a [f64],
    x: &'a mut [f64],
    momentum: &'a mut [f64],
}

impl LoopBody for DiagonalCorrection<'_> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn apply<const N: usize>(&mut self, first: usize) {
        let (mut x, inverses) = (load::<_, N>(self.forces, first), load::<_, N>(self.inverses, first));
        let mut momentum = load::<_, N>(self.p, first);
        for i in 0..N {
            x[i] = 0.0 - x[i] * self.weight * inverses[i];
        }
        for i in 0..N {
            momentum[i] += x[i];
        }
        store(self.x, first, x);
        store(self.momentum, first, momentum);
    }
}

/// `u` from the sums of velocities, and whether the state after the step is finite.
struct EndOfStep<'a, const L: usize> {
    velocities: &'a [f64],
    q: &'a [f64],
    p: &'a [f64],
    x: &'a [f64],
    factor: f64,
    u: &'a mut [f64],
    /// Zero while the state is finite.
    zeros: &'a mut [f64; L],
}

impl<const L: usize> LoopBody for EndOfStep<'_, L> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn apply<const N: usize>(&mut self, first: usize) {
        let (q, p) = (load::<_, N>(self.q, first), load::<_, N>(self.p, first));
        let (u, x) = (load::<_, N>(self.velocities, first), load::<_, N>(self.x, first));
        add_zeros(self.zeros, [q, p], &u, &x, self.factor);
        store(self.u, first, u);
    }
}
