//! One fixed-point iteration `x ← φ(x)`; for large systems window by window, in the best vector instructions
//! of the machine.
//!
//! A window of the vectors stays in the first-level cache while its forces are computed, then the new
//! unknowns, the velocities that follow from them, and the coordinates for the forces of the next iteration:
//!
//! ```text
//! v' = v - (v + start Σ ∂V/∂q (Q)),   P' = p + v',   u' = Σ ∂T/∂p (P'),   Q' = q + c u'
//! ```
//!
//! Every loop runs over adjacent entries without branches, so that it is vectorised. Each number is computed
//! as in one pass over all placements ([`Step::residual`]), no operation is fused and no sum is split, so
//! that the bits depend neither on windows nor on instructions.

mod blocks;
mod diagonal;

use std::any::TypeId;
use std::ops::Range;

use blocks::{Compared, Follow, Guess, Kick, Store};

use super::LEAST_IN_WINDOWS;
use super::layout::{Recorder, Strip, Windows};
use super::portions::{Found, Part, Portion, on_threads};
use super::sums::{Stretch, Window};
use crate::algebra::lanes::instructions::{InstructionSet, Kernel};
use crate::algebra::scalar::{Number, Scalar};
use crate::algebra::solve::relative_to;
use crate::algebra::threads::Threads;
use crate::error::{StepFailure, StepPromise};
use crate::scheme::elements::change::{Change, Seen};
use crate::scheme::elements::memory::{Lists, Scratch};
use crate::scheme::elements::passes::{Largest, in_blocks, subtract};
use crate::scheme::elements::side_by_side::{hold, is_side_by_side};
use crate::scheme::elements::step::Step;
use crate::scheme::elements::sums::Given;
use crate::scheme::elements::{Elements, MomentumUpdate, Quadrature, Slopes, Unknowns};
use crate::scheme::system::Hamiltonian as _;

/// Number of places of a window. Ten stretches of this length are in use at a time.
const SIZE: usize = 256;

/// Least number of degrees of freedom for each thread in each pass: the three or more passes of a step of
/// this size take some 500 µs (`cargo bench --workspace --bench elements -- memory`).
const LEAST_OF_THREAD: usize = 1 << 16;

/// An applied correction.
pub(in crate::scheme::elements) struct Swept<S> {
    /// The largest correction relative to the largest unknown; NaN if any is not finite.
    pub(in crate::scheme::elements) relative: S,
    /// The change of the points at which the equations are evaluated, if it costs less than another
    /// iteration.
    pub(in crate::scheme::elements) change: Option<Change>,
}

/// The windows of a system, and the portions that threads take.
#[derive(Debug)]
pub(in crate::scheme::elements) struct Sweeps {
    windows: Windows,
    portions: Vec<Portion<Range<usize>>>,
    instructions: InstructionSet,
    /// Whether the last iteration used windows, so that the coordinates at its unknowns are stored for the
    /// next one.
    is_ready: bool,
    /// Whether the state after the step is known to be finite.
    is_finite: bool,
}

impl Sweeps {
    /// Records the places that the elements of a system add to.
    #[cold]
    #[inline(never)]
    fn new<H: Elements + Sync>(step: &Step<'_, H, f64>, threads: Threads) -> Self {
        let recorder = Recorder::default();
        for (state, wanted) in [(step.q, Slopes::BY_COORDINATES), (step.p, Slopes::BY_MOMENTA)] {
            step.slopes_of::<f64, _, _>(|_| 1.0, state, wanted, &mut &recorder);
        }
        let degrees = step.degrees();
        let windows = Windows::new(degrees, SIZE, recorder);
        let threads = threads.number(degrees / LEAST_OF_THREAD);
        let portions =
            windows.portions(threads).map(|own| Portion::new(&windows, &own, own.clone())).collect();
        Self { windows, portions, instructions: InstructionSet::best(), is_ready: false, is_finite: false }
    }
}

impl<H: Elements + Sync, S: Scalar> Step<'_, H, S> {
    /// The start extrapolated from `known` past steps, with its `u` and `P`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(in crate::scheme::elements) fn start(&self, scratch: &mut Scratch<'_, S>, known: u8) {
        if const { H::FACTS.has_windows && S::MAY_BE_PLAIN }
            && self.takes_vectors(scratch)
            && self.start_in_vectors(scratch, known)
        {
            return;
        }
        scratch.guess(known);
        self.refresh(&mut scratch.lists);
    }

    /// `x ← φ(x)`, but for the paths side by side that are `solved`; updates `u` and `P`, which must be those
    /// at `x`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(in crate::scheme::elements) fn sweep(
        &self,
        scratch: &mut Scratch<'_, S>,
        solved: S::Mask,
    ) -> Swept<S> {
        if const { H::FACTS.has_windows && S::MAY_BE_PLAIN }
            && self.takes_vectors(scratch)
            && let Some(swept) = self.sweep_in_vectors(scratch)
        {
            return swept;
        }
        let lists = &mut scratch.lists;
        self.residual_at(lists);
        if const { is_side_by_side::<S>() } {
            hold(lists.correction, solved);
        }
        let relative = subtract(self.scheme.unknowns, lists.x, lists.correction);
        if self.scheme.unknowns == Unknowns::Momenta {
            std::mem::swap(&mut lists.u, &mut lists.by_p);
        }
        self.refresh(lists);
        Swept { relative, change: None }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn takes_vectors(&self, scratch: &Scratch<'_, S>) -> bool {
        H::FACTS.has_windows
            && S::plain(&[]).is_some()
            && self.scheme.unknowns == Unknowns::Momenta
            && self.scheme.stages.len() == 1
            && self.degrees() >= LEAST_IN_WINDOWS
            && !scratch.is_exact
    }

    /// Whether an iteration may have failed because of arguments that vectorised functions do not cover.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(in crate::scheme::elements) fn may_have_been_unusual(&self, scratch: &Scratch<'_, S>) -> bool {
        TypeId::of::<H::Usual>() != TypeId::of::<H::Exact>() && self.takes_vectors(scratch)
    }

    /// The same step, if its numbers are `f64`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn plain(&self) -> Option<Step<'_, H, f64>> {
        let &Self { system, scheme, t, h, q, p, dw, increment, .. } = self;
        let ([t, h], parameters) = ([t, h].map(|constant| constant.lane(0)), &[][..]);
        let (q, p, dw, increment) = (S::plain(q)?, S::plain(p)?, S::plain(dw)?, increment.and_then(S::plain));
        Some(Step { system, scheme, t, h, parameters, q, p, dw, increment })
    }

    /// [`Step::start`] in vector instructions; returns whether that was possible.
    #[inline(never)]
    fn start_in_vectors(&self, scratch: &mut Scratch<'_, S>, known: u8) -> bool {
        let Some(step) = self.plain() else { return false };
        let threads = scratch.threads;
        let sweeps = scratch.solver.sweeps.get_or_insert_with(|| Box::new(Sweeps::new(&step, threads)));
        let [Some(a), Some(b), Some(c)] = scratch.solver.past.each_ref().map(|past| S::plain(past)) else {
            return false;
        };
        let Some(mut lists) = scratch.lists.plain() else { return false };
        let (Sweeps { windows, portions, instructions, .. }, past) = (&mut **sweeps, [a, b, c]);
        on_threads(portions, lists.parted().0, |portion, part| {
            instructions.run(Start { step, windows, portion, part, past, known });
            Found::NOTHING
        });
        (sweeps.is_ready, sweeps.is_finite) = (true, false);
        true
    }

    /// [`Step::sweep`] in vector instructions; `None` if that is not possible.
    #[inline(never)]
    fn sweep_in_vectors(&self, scratch: &mut Scratch<'_, S>) -> Option<Swept<S>> {
        let (step, sweeps) = (self.plain()?, scratch.solver.sweeps.as_deref_mut()?);
        if !std::mem::replace(&mut sweeps.is_ready, false) {
            return None;
        }
        let lists = &mut scratch.lists;
        lists.stages.turn();
        std::mem::swap(&mut lists.u, &mut lists.by_p);
        let mut lists = lists.plain()?;
        let Sweeps { windows, portions, instructions, .. } = &mut *sweeps;
        let (part, now, before) = lists.parted();
        let found = on_threads(portions, part, |portion, part| {
            instructions.run(Sweep { step, windows, portion, part, now, before })
        });
        (sweeps.is_ready, sweeps.is_finite) = (true, found.is_finite);
        let relative = match found.change {
            Change::Unknown => f64::NAN,
            _ => relative_to(found.corrected, found.size),
        };
        Some(Swept { relative: S::from_f64(relative), change: Some(found.change) })
    }
}

impl<H: Elements + Sync> Step<'_, H, f64> {
    /// The sums of slopes of a window, at coordinates or momenta.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn window<'w, T: Number<f64>, V: Given<f64> + ?Sized>(
        &self,
        strip: Strip<'w>,
        state: &V,
        wanted: Slopes,
        sums: &'w mut [f64],
    ) -> &'w [f64] {
        let mut window = Window::empty(strip, sums);
        self.slopes_of::<T, V, _>(|_| 1.0, state, wanted, &mut window);
        window.finish()
    }

    /// `c` in `Q = q + c u`, and the weight of forces.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn weights(&self) -> [f64; 2] {
        self.scheme.stages.first().map_or([0.0; 2], |stage| [stage.point, stage.start])
    }

    /// The ratio of the change of the momenta to `v`; zero if there is none, so that a finite `p + factor v`
    /// only says that `v` is.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn multiple(&self) -> f64 {
        match self.scheme.update {
            MomentumUpdate::Multiple(factor) => factor,
            MomentumUpdate::Slopes => 0.0,
        }
    }
}

impl Lists<'_, f64> {
    /// The lists that an iteration writes, the coordinates for its forces, and the previous `u`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn parted(&mut self) -> ([&mut [f64]; 5], &[f64], &[f64]) {
        let Self { x, correction, u, by_p: before, momentum, stages, .. } = self;
        let (now, next) = stages.at_mut(0);
        ([x, correction, momentum, u, next], now, before)
    }
}

impl<H: Elements + Sync, S: Scalar> Step<'_, H, S> {
    /// Whether the last iteration used windows and leads to a finite state. [`Scratch::store_windows`] then
    /// ends the step.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(in crate::scheme::elements) fn is_in_windows(&self, scratch: &mut Scratch<'_, S>) -> bool {
        let is_a_multiple = matches!(self.scheme.update, MomentumUpdate::Multiple(_));
        let is_known =
            |sweeps: &mut Box<Sweeps>| std::mem::replace(&mut sweeps.is_ready, false) && sweeps.is_finite;
        H::FACTS.has_windows
            && !H::KIND.is_conformal
            && is_a_multiple
            && scratch.solver.sweeps.as_mut().is_some_and(is_known)
    }
}

impl<S: Scalar> Scratch<'_, S> {
    /// Notes that the unknowns change outside of windows.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(in crate::scheme::elements) fn leave_windows(&mut self) {
        if let Some(sweeps) = self.solver.sweeps.as_deref_mut() {
            sweeps.is_ready = false;
        }
    }

    /// Adds the increments of a step to the state, and keeps its unknowns if later steps start from them
    /// (`remembers`).
    ///
    /// # Errors
    /// [`StepFailure::Internal`] if the step was not taken in windows.
    #[inline(never)]
    pub(in crate::scheme::elements) fn store_windows(
        &mut self,
        scheme: &Quadrature,
        remembers: bool,
        q: &mut [S],
        p: &mut [S],
    ) -> Result<(), StepFailure> {
        let missing = Err(StepFailure::Internal(StepPromise::Windows));
        let (Some(sweeps), MomentumUpdate::Multiple(factor)) =
            (self.solver.sweeps.as_deref_mut(), scheme.update)
        else {
            return missing;
        };
        let (Some(q), Some(p), Some(lists)) = (S::plain_mut(q), S::plain_mut(p), self.lists.plain()) else {
            return missing;
        };
        let past = if remembers {
            self.solver.past.rotate_right(1);
            S::plain_mut(&mut self.solver.past[0]).unwrap_or_default()
        } else {
            &mut []
        };
        let Sweeps { portions, instructions, .. } = sweeps;
        on_threads(portions, [q, p, lists.u, lists.x, past], |_, part| {
            let [q, p, u, x, past] = part.lists;
            instructions.run(Store { q, p, u, x, past, factor });
            Found::NOTHING
        });
        Ok(())
    }
}

/// [`Step::start`] of a portion.
struct Start<'a, 's, H> {
    step: Step<'s, H, f64>,
    windows: &'a Windows,
    portion: &'a mut Portion<Range<usize>>,
    part: Part<'a, 5>,
    past: [&'a [f64]; 3],
    known: u8,
}

impl<H: Elements + Sync> Kernel for Start<'_, '_, H> {
    type Output = ();

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run<const L: usize, const HALF: usize>(self) {
        let Self { step, windows, portion, part: Part { first, lists }, past, known } = self;
        let [all_x, _, momenta, all_u, all_next] = lists;
        let [point, _] = step.weights();
        for number in portion.work.clone() {
            let strip = windows.strip(number);
            let (places, own) = (strip.start..strip.end, strip.start - first..strip.end - first);
            let p = &step.p[places.clone()];
            let past = past.map(|past| past.get(places.clone()).unwrap_or(&[]));
            let (x, momentum) = (&mut all_x[own.clone()], &mut momenta[own.clone()]);
            in_blocks::<L>(p.len(), &mut Guess { past, known, p, x, momentum });
            let momenta = Stretch { numbers: momenta, first, degrees: step.degrees() };
            let velocities =
                step.window::<H::Usual, _>(strip, &momenta, Slopes::BY_MOMENTA, &mut portion.sums);
            let (u, next) = (&mut all_u[own.clone()], &mut all_next[own]);
            in_blocks::<L>(places.len(), &mut Follow::new(&step, &places, velocities, point, u, next));
        }
    }
}

/// [`Step::sweep`] of a portion.
struct Sweep<'a, 's, H> {
    step: Step<'s, H, f64>,
    windows: &'a Windows,
    portion: &'a mut Portion<Range<usize>>,
    part: Part<'a, 5>,
    /// Coordinates of all places for the forces.
    now: &'a [f64],
    /// `u` of the previous iteration.
    before: &'a [f64],
}

impl<H: Elements + Sync> Kernel for Sweep<'_, '_, H> {
    type Output = Found;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run<const L: usize, const HALF: usize>(self) -> Found {
        let Self { step, windows, portion, part: Part { first, lists }, now, before } = self;
        let [all_x, corrections, momenta, all_u, all_next] = lists;
        let ([point, weight], factor, mut zeros) = (step.weights(), step.multiple(), [0.0; HALF]);
        let (mut size, mut corrected, mut seen) =
            (Largest::<HALF>::default(), Largest::<HALF>::default(), Seen::<HALF>::new());
        for number in portion.work.clone() {
            let strip = windows.strip(number);
            let (places, own) = (strip.start..strip.end, strip.start - first..strip.end - first);
            let p = &step.p[places.clone()];
            let forces = step.window::<H::Usual, _>(strip, now, Slopes::BY_COORDINATES, &mut portion.sums);
            let (x, correction) = (&mut all_x[own.clone()], &mut corrections[own.clone()]);
            let momentum = &mut momenta[own.clone()];
            let mut kick = Kick { forces, weight, p, x, correction, momentum, size, corrected };
            in_blocks::<HALF>(places.len(), &mut kick);
            (size, corrected) = (kick.size, kick.corrected);
            let momenta = Stretch { numbers: momenta, first, degrees: step.degrees() };
            let velocities =
                step.window::<H::Usual, _>(strip, &momenta, Slopes::BY_MOMENTA, &mut portion.sums);
            let (u, next) = (&mut all_u[own.clone()], &mut all_next[own.clone()]);
            let follow = Follow::new(&step, &places, velocities, point, u, next);
            let (x, before) = (&all_x[own], &before[places.clone()]);
            let compared = &mut Compared { p, x, factor, zeros, follow, before, seen: &mut seen };
            in_blocks::<HALF>(places.len(), compared);
            zeros = compared.zeros;
        }
        let (size, corrected, change) = (size.get(), corrected.get(), seen.finish());
        Found { size, corrected, change, is_finite: zeros.iter().sum::<f64>() == 0.0 }
    }
}
