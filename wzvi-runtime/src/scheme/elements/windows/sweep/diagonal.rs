//! Linear equations with a diagonal Jacobian `J = I - φ'`: the first correction is the solution, and nothing
//! is compared.
//!
//! ```text
//! Q = q + c Σ ∂T/∂p (p),   v = -J⁻¹ start Σ ∂V/∂q (Q),   u = Σ ∂T/∂p (p + v)
//! ```
//!
//! The forces of a window depend on its own coordinates only, so that a window takes all of this at once.

use std::ops::Range;

use super::blocks::add_zeros;
use super::{Found, Part, Portion, Stretch, Sweeps, Windows, on_threads};
use crate::algebra::lanes::instructions::Kernel;
use crate::algebra::scalar::Scalar;
use crate::scheme::elements::linear::Linear;
use crate::scheme::elements::memory::{Lists, Scratch, Solver};
use crate::scheme::elements::passes::{Block, in_blocks, load, store, subtract};
use crate::scheme::elements::step::Step;
use crate::scheme::elements::{Elements, Slopes};

impl<H: Elements + Sync, S: Scalar> Step<'_, H, S> {
    /// The solution of linear equations with a diagonal Jacobian, which is factored: one correction from
    /// zero, and `u`. Returns whether it is finite.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(in crate::scheme::elements) fn solve_diagonal(&self, scratch: &mut Scratch<'_, S>) -> bool {
        if const { H::FACTS.has_windows && H::FACTS.has_constant_curvature && S::MAY_BE_PLAIN }
            && self.takes_vectors(scratch)
            && let Some(is_finite) = self.solve_diagonal_in_vectors(scratch)
        {
            return is_finite;
        }
        scratch.leave_windows();
        scratch.guess(0);
        let Scratch { lists, solver: Solver { linear, .. }, .. } = scratch;
        self.residual(lists);
        if let Some(Linear::Band(band)) = linear {
            band.solve(lists.correction);
        }
        let relative = subtract(self.scheme.unknowns, lists.x, lists.correction);
        self.refresh(lists);
        !relative.magnitude().is_nan()
    }

    /// [`Step::solve_diagonal`] in vector instructions; `None` if that is not possible.
    #[inline(never)]
    fn solve_diagonal_in_vectors(&self, scratch: &mut Scratch<'_, S>) -> Option<bool> {
        let step = self.plain()?;
        let Scratch { lists, solver: Solver { linear, sweeps, .. }, threads, .. } = scratch;
        let inverses = match linear {
            Some(Linear::Band(band)) => S::plain(band.inverses()?)?,
            Some(Linear::Krylov(_)) | None => return None,
        };
        let sweeps = sweeps.get_or_insert_with(|| Box::new(Sweeps::new(&step, *threads)));
        if !sweeps.windows.are_independent() {
            return None;
        }
        let Lists { x, u, .. } = lists.plain()?;
        let Sweeps { windows, portions, instructions, .. } = &mut **sweeps;
        let found = on_threads(portions, [x, u], |portion, part| {
            instructions.run(Diagonal { step, windows, portion, part, inverses })
        });
        (sweeps.is_ready, sweeps.is_finite) = (true, found.is_finite);
        Some(found.is_finite)
    }
}

/// [`Step::solve_diagonal`] of a portion.
struct Diagonal<'a, 's, H> {
    step: Step<'s, H, f64>,
    windows: &'a Windows,
    portion: &'a mut Portion<Range<usize>>,
    part: Part<'a, 2>,
    /// The inverse of the Jacobian, for all places.
    inverses: &'a [f64],
}

impl<H: Elements + Sync> Kernel for Diagonal<'_, '_, H> {
    type Output = Found;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run<const L: usize, const HALF: usize>(self) -> Found {
        let Self { step, windows, portion, part: Part { first, lists }, inverses } = self;
        let [all_x, all_u] = lists;
        let ([point, weight], factor, degrees) = (step.weights(), step.multiple(), step.degrees());
        let mut zeros = [0.0; L];
        for number in portion.work.clone() {
            let strip = windows.strip(number);
            let (places, own) = (strip.start..strip.end, strip.start - first..strip.end - first);
            let [q, p, inverses] = [step.q, step.p, inverses].map(|list| &list[places.clone()]);
            let momenta = Stretch { numbers: step.p, first: 0, degrees };
            let velocities =
                step.window::<H::Usual, _>(strip, &momenta, Slopes::BY_MOMENTA, &mut portion.sums);
            // `u` comes last: until then its list has the coordinates, then the momenta.
            in_blocks::<L>(places.len(), &mut Place { velocities, q, point, next: &mut all_u[own.clone()] });
            let coordinates = Stretch { numbers: all_u, first, degrees };
            let forces =
                step.window::<H::Usual, _>(strip, &coordinates, Slopes::BY_COORDINATES, &mut portion.sums);
            let (x, momentum) = (&mut all_x[own.clone()], &mut all_u[own.clone()]);
            in_blocks::<L>(places.len(), &mut Correct { forces, weight, inverses, p, x, momentum });
            let momenta = Stretch { numbers: all_u, first, degrees };
            let velocities =
                step.window::<H::Usual, _>(strip, &momenta, Slopes::BY_MOMENTA, &mut portion.sums);
            let (u, x) = (&mut all_u[own.clone()], &all_x[own]);
            in_blocks::<L>(places.len(), &mut End { velocities, q, p, x, factor, u, zeros: &mut zeros });
        }
        // Opaque, since the compiler else cuts the lanes of the pass as the sum would have them.
        Found::finite(std::hint::black_box(zeros).iter().sum::<f64>() == 0.0)
    }
}

/// The coordinates for the forces, from the sums of velocities.
struct Place<'a> {
    velocities: &'a [f64],
    q: &'a [f64],
    point: f64,
    next: &'a mut [f64],
}

impl Block for Place<'_> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn take<const N: usize>(&mut self, first: usize) {
        let (u, mut next) = (load::<_, N>(self.velocities, first), load::<_, N>(self.q, first));
        for i in 0..N {
            next[i] += u[i] * self.point;
        }
        store(self.next, first, next);
    }
}

/// `v = -J⁻¹ start F` and `P`, with a diagonal `J`.
struct Correct<'a> {
    forces: &'a [f64],
    weight: f64,
    inverses: &'a [f64],
    p: &'a [f64],
    x: &'a mut [f64],
    momentum: &'a mut [f64],
}

impl Block for Correct<'_> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn take<const N: usize>(&mut self, first: usize) {
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
struct End<'a, const L: usize> {
    velocities: &'a [f64],
    q: &'a [f64],
    p: &'a [f64],
    x: &'a [f64],
    factor: f64,
    u: &'a mut [f64],
    /// Zero while the state is finite.
    zeros: &'a mut [f64; L],
}

impl<const L: usize> Block for End<'_, L> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn take<const N: usize>(&mut self, first: usize) {
        let (q, p) = (load::<_, N>(self.q, first), load::<_, N>(self.p, first));
        let (u, x) = (load::<_, N>(self.velocities, first), load::<_, N>(self.x, first));
        add_zeros(self.zeros, [q, p], &u, &x, self.factor);
        store(self.u, first, u);
    }
}
