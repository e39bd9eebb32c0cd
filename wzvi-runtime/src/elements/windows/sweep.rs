//! One iteration of the fixed point, `x ← φ(x)`: of a large system window by window, in the best vector instructions of the machine.
//!
//! A window of the vectors stays in the first cache while its forces are taken, the new unknowns, the velocities that follow from
//! them, and the coordinates at which the forces of the next iteration are taken:
//!
//! ```text
//! v' = v - (v + start Σ ∂V/∂q (Q)),   P' = p + v',   u' = Σ ∂T/∂p (P'),   Q' = q + c u'
//! ```
//!
//! Every loop is over neighbours and without branches, so that it becomes vector code. Each number is computed as in one pass over
//! all placements ([`Step::residual`]), no operation is fused and no sum is parted, so that bits depend neither on windows nor on
//! instructions.

mod blocks;

use std::any::TypeId;

use blocks::{Compared, Follow, Guess, Kick, Store};

use super::layout::{Recorder, Strip, Windows};
use super::sums::Window;
use super::{LEAST_IN_WINDOWS, LINE};
use crate::elements::change::{Change, Seen};
use crate::elements::memory::{Lists, Scratch};
use crate::elements::passes::{Largest, in_blocks, subtract};
use crate::elements::step::{Step, nothing};
use crate::elements::sums::Sums;
use crate::elements::{Elements, MomentumUpdate, Scheme, Slopes, Unknowns};
use crate::lanes::instructions::{InstructionSet, Kernel};
use crate::scalar::{Number, Scalar};

/// Places of a window. Ten stretches of it are used at one time.
const SIZE: usize = 256;

/// A correction that was taken.
pub(in crate::elements) struct Swept {
    /// The largest correction against the largest unknown; NaN if any is not finite.
    pub(in crate::elements) relative: f64,
    /// What it changed of what the equations are evaluated at, where that is known for less than another iteration costs.
    pub(in crate::elements) change: Option<Change>,
}

/// Windows of a system, and what is needed for one of them.
#[derive(Debug)]
pub(in crate::elements) struct Sweeps {
    windows: Windows,
    sums: Vec<f64>,
    instructions: InstructionSet,
    /// Whether the coordinates at the unknowns are where the next iteration takes them from.
    is_ready: bool,
    /// Whether the state after the step is known to be finite.
    is_finite: bool,
}

impl Sweeps {
    /// Takes down where the elements of a system add what.
    #[cold]
    #[inline(never)]
    fn new<H: Elements>(step: &Step<'_, H, f64>) -> Self {
        let recorder = Recorder::default();
        for wanted in [Slopes::BY_COORDINATES, Slopes::BY_MOMENTA] {
            step.add_slopes::<f64, _>(step.q, step.p, wanted, &mut &recorder);
        }
        let windows = Windows::new(step.degrees(), SIZE, recorder);
        let sums = vec![nothing(); windows.room() + LINE];
        Self { windows, sums, instructions: InstructionSet::best(), is_ready: false, is_finite: false }
    }
}

impl<H: Elements, S: Scalar> Step<'_, H, S> {
    /// The guess of so many steps before, with its `u` and `P`.
    #[inline(always)]
    pub(in crate::elements) fn start(&self, scratch: &mut Scratch<'_, S>, known: u8) {
        if self.takes_vectors(scratch) && self.start_in_vectors(scratch, known) {
            return;
        }
        scratch.guess(known);
        self.refresh(&mut scratch.lists);
    }

    /// `x ← φ(x)`, with the new `u` and `P` from those of before.
    #[inline(always)]
    pub(in crate::elements) fn sweep(&self, scratch: &mut Scratch<'_, S>) -> Swept {
        if self.takes_vectors(scratch)
            && let Some(swept) = self.sweep_in_vectors(scratch)
        {
            return swept;
        }
        let lists = &mut scratch.lists;
        self.residual_as::<S::OfElements<H::Exact>>(lists);
        let relative = subtract(lists.x, lists.correction);
        if self.scheme.unknowns == Unknowns::Momenta {
            std::mem::swap(&mut lists.u, &mut lists.by_p);
        }
        self.refresh(lists);
        Swept { relative, change: None }
    }

    #[inline(always)]
    fn takes_vectors(&self, scratch: &Scratch<'_, S>) -> bool {
        H::HAS_WINDOWS
            && S::plain(&[]).is_some()
            && self.scheme.unknowns == Unknowns::Momenta
            && self.scheme.stages.len() == 1
            && self.degrees() >= LEAST_IN_WINDOWS
            && !scratch.is_exact
    }

    /// Whether an iteration may have failed for arguments of functions that loops over neighbours do not know.
    #[inline(always)]
    pub(in crate::elements) fn may_have_been_unusual(&self, scratch: &Scratch<'_, S>) -> bool {
        TypeId::of::<H::Usual>() != TypeId::of::<H::Exact>() && self.takes_vectors(scratch)
    }

    /// The same step, if its numbers are `f64`.
    #[inline(always)]
    fn plain(&self) -> Option<Step<'_, H, f64>> {
        let &Self { system, scheme, t, h, q, p, dw, increment } = self;
        let (q, p, dw, increment) = (S::plain(q)?, S::plain(p)?, S::plain(dw)?, increment.and_then(S::plain));
        Some(Step { system, scheme, t, h, q, p, dw, increment })
    }

    /// [`Step::start`]; whether that was done.
    #[inline(never)]
    fn start_in_vectors(&self, scratch: &mut Scratch<'_, S>, known: u8) -> bool {
        let Some(step) = self.plain() else { return false };
        let sweeps = scratch.sweeps.get_or_insert_with(|| Box::new(Sweeps::new(&step)));
        let [Some(a), Some(b), Some(c)] = scratch.past.each_ref().map(|past| S::plain(past)) else {
            return false;
        };
        let Some(lists) = scratch.lists.plain() else { return false };
        let instructions = sweeps.instructions;
        instructions.run(Start { step, lists, sweeps, past: [a, b, c], known });
        true
    }

    /// [`Step::sweep`]; `None` if it is not for these.
    #[inline(never)]
    fn sweep_in_vectors(&self, scratch: &mut Scratch<'_, S>) -> Option<Swept> {
        let (step, sweeps) = (self.plain()?, scratch.sweeps.as_deref_mut()?);
        if !std::mem::replace(&mut sweeps.is_ready, false) {
            return None;
        }
        scratch.lists.stages.turn();
        std::mem::swap(&mut scratch.lists.u, &mut scratch.lists.by_p);
        let lists = scratch.lists.plain()?;
        let instructions = sweeps.instructions;
        Some(instructions.run(Sweep { step, lists, sweeps }))
    }
}

impl<H: Elements> Step<'_, H, f64> {
    /// Adds the slopes of the step Hamiltonian to `into`, by coordinates or by momenta.
    #[inline(always)]
    fn add_slopes<T: Number<f64>, A: Sums<f64>>(&self, q: &[f64], p: &[f64], wanted: Slopes, into: &mut A) {
        let none = &mut [][..];
        for stage in self.scheme.stages {
            let at = self.at(stage, q, p);
            for &(part, weight) in stage.parts {
                if wanted.by_q {
                    self.system.slopes::<f64, T, [f64], A, [f64]>(part, weight, &at, wanted, into, none);
                } else {
                    self.system.slopes::<f64, T, [f64], [f64], A>(part, weight, &at, wanted, none, into);
                }
            }
        }
    }

    /// The sums of a window.
    #[inline(always)]
    fn window<'w, T: Number<f64>>(
        &self,
        strip: Strip<'w>,
        [q, p]: [&[f64]; 2],
        wanted: Slopes,
        sums: &'w mut [f64],
    ) -> &'w [f64] {
        let mut window = Window::empty(strip, sums);
        self.add_slopes::<T, _>(q, p, wanted, &mut window);
        window.finish()
    }

    /// `c` in `Q = q + c u`, and the weight of forces.
    #[inline(always)]
    fn weights(&self) -> [f64; 2] {
        self.scheme.stages.first().map_or([0.0; 2], |stage| [stage.point, stage.start])
    }
}

impl<H: Elements, S: Scalar> Step<'_, H, S> {
    /// Whether the last iteration went in windows and leads to a state that is finite: then [`Scratch::store_windows`] ends the step.
    #[inline(always)]
    pub(in crate::elements) fn is_in_windows(&self, scratch: &mut Scratch<'_, S>) -> bool {
        let is_a_multiple = matches!(self.scheme.update, MomentumUpdate::Multiple(_));
        let is_known =
            |sweeps: &mut Box<Sweeps>| std::mem::replace(&mut sweeps.is_ready, false) && sweeps.is_finite;
        H::HAS_WINDOWS && !H::IS_CONFORMAL && is_a_multiple && scratch.sweeps.as_mut().is_some_and(is_known)
    }
}

impl<S: Scalar> Scratch<'_, S> {
    /// The unknowns change in another way than in windows.
    #[inline(always)]
    pub(in crate::elements) fn leave_windows(&mut self) {
        if let Some(sweeps) = self.sweeps.as_deref_mut() {
            sweeps.is_ready = false;
        }
    }

    /// Adds the increments of a step to the state, and keeps its unknowns for the next if that is to be.
    #[inline(never)]
    pub(in crate::elements) fn store_windows(&mut self, scheme: &Scheme, q: &mut [S], p: &mut [S]) {
        let (Some(sweeps), MomentumUpdate::Multiple(factor)) = (self.sweeps.as_deref(), scheme.update) else {
            return;
        };
        let (Some(q), Some(p), Some(lists)) = (S::plain_mut(q), S::plain_mut(p), self.lists.plain()) else {
            return;
        };
        self.past.rotate_right(usize::from(scheme.remembers));
        let past = S::plain_mut(&mut self.past[0]).unwrap_or_default();
        sweeps.instructions.run(Store { q, p, u: lists.u, x: lists.x, past, factor });
    }
}

/// [`Step::start`]
struct Start<'a, 's, H> {
    step: Step<'s, H, f64>,
    lists: Lists<'a, f64>,
    sweeps: &'a mut Sweeps,
    past: [&'a [f64]; 3],
    known: u8,
}

impl<H: Elements> Kernel for Start<'_, '_, H> {
    type Output = ();

    #[inline(always)]
    fn run<const L: usize, const HALF: usize>(self) {
        let Self { step, lists, sweeps, past, known } = self;
        let Lists { x, u, momentum, mut stages, .. } = lists;
        let (_, q) = stages.at_mut(0);
        let [point, _] = step.weights();
        for number in 0..sweeps.windows.neighbours().len() {
            let strip = sweeps.windows.strip(number);
            let places = strip.start..strip.end;
            let x = &mut x[places.clone()];
            let past = past.map(|past| past.get(places.clone()).unwrap_or(&[]));
            let momentum_of = &mut momentum[places.clone()];
            in_blocks::<L>(
                x.len(),
                &mut Guess { past, known, p: &step.p[places.clone()], x, momentum: momentum_of },
            );
            let u_of =
                step.window::<H::Usual>(strip, [step.q, momentum], Slopes::BY_MOMENTA, &mut sweeps.sums);
            let mut follow =
                Follow::new(&step, &places, u_of, point, &mut u[places.clone()], &mut q[places.clone()]);
            in_blocks::<L>(places.len(), &mut follow);
        }
        (sweeps.is_ready, sweeps.is_finite) = (true, false);
    }
}

/// [`Step::sweep`]
struct Sweep<'a, 's, H> {
    step: Step<'s, H, f64>,
    lists: Lists<'a, f64>,
    sweeps: &'a mut Sweeps,
}

impl<H: Elements> Kernel for Sweep<'_, '_, H> {
    type Output = Swept;

    #[inline(always)]
    fn run<const L: usize, const HALF: usize>(self) -> Swept {
        let Self { step, lists, sweeps } = self;
        let Lists { x, correction, u, by_p: before, momentum, mut stages, .. } = lists;
        let (now, next) = stages.at_mut(0);
        let ([point, weight], mut zeros) = (step.weights(), [0.0; HALF]);
        let factor = match step.scheme.update {
            MomentumUpdate::Multiple(factor) => factor,
            MomentumUpdate::Slopes => f64::NAN,
        };
        let (mut size, mut corrected, mut seen) =
            (Largest::<HALF>::default(), Largest::<HALF>::default(), Seen::<HALF>::new());
        for number in 0..sweeps.windows.neighbours().len() {
            let strip = sweeps.windows.strip(number);
            let places = strip.start..strip.end;
            let forces =
                step.window::<H::Usual>(strip, [now, step.p], Slopes::BY_COORDINATES, &mut sweeps.sums);
            let mut kick = Kick {
                forces,
                weight,
                p: &step.p[places.clone()],
                x: &mut x[places.clone()],
                correction: &mut correction[places.clone()],
                momentum: &mut momentum[places.clone()],
                size,
                corrected,
            };
            in_blocks::<HALF>(places.len(), &mut kick);
            (size, corrected) = (kick.size, kick.corrected);
            let velocities =
                step.window::<H::Usual>(strip, [step.q, momentum], Slopes::BY_MOMENTA, &mut sweeps.sums);
            let follow = Follow::new(
                &step,
                &places,
                velocities,
                point,
                &mut u[places.clone()],
                &mut next[places.clone()],
            );
            let compared = &mut Compared {
                p: &step.p[places.clone()],
                x: &x[places.clone()],
                factor,
                zeros,
                follow,
                before: &before[places.clone()],
                seen: &mut seen,
            };
            in_blocks::<HALF>(places.len(), compared);
            zeros = compared.zeros;
        }
        (sweeps.is_ready, sweeps.is_finite) = (true, zeros.iter().sum::<f64>() == 0.0);
        let change = seen.finish();
        let relative = match change {
            Change::Unknown => f64::NAN,
            _ => corrected.get().relative_to(size.get()),
        };
        Swept { relative, change: Some(change) }
    }
}
