//! The step that solves nothing, of a large system: window by window, in the best vector instructions of the machine.
//!
//! A window of the vectors stays in the first cache while its slopes are taken, added to the momenta, and the velocities that
//! follow to the coordinates:
//!
//! ```text
//! P[i] = p[i] - (Σ ∂V/∂q)[i],   q'[i] = q[i] + (Σ ∂T/∂p)(P)[i]
//! ```
//!
//! The new state goes beside the old one, which neighbours still read, and replaces it when all of it is known to be finite. Every
//! loop is over neighbours and without branches, so that it becomes vector code. Each sum gets its terms in the order of one pass
//! over all placements, no operation is fused and no sum is parted, so that bits depend neither on windows nor on
//! instructions.

use std::ops::Range;

use super::step::{Step, nothing};
use super::sums::{Points, Run, Sums};
use super::window::{Recorder, Strip, Values, Windows};
use super::{Elements, MomentumUpdate, Scheme, Slopes, Unknowns};
use crate::error::StepFailure;
use crate::lanes::instructions::{InstructionSet, Kernel};
use crate::scalar::Number;

/// Degrees of freedom from which windows are taken: those of smaller systems are one anyway.
pub const LEAST_IN_WINDOWS: usize = 96;

/// Places of a window. Five stretches of it are used at one time: forces, and both halves of the state before and after.
const SIZE: usize = 512;

/// Numbers in a line of the cache: sums start with one.
const LINE: usize = 8;

/// Whether steps of so many degrees of freedom go window by window.
///
/// Only for [`Elements::HAS_WINDOWS`], which is asked beforehand, so that nothing is compiled for the others.
#[inline(always)]
pub(super) fn takes_windows(scheme: &Scheme, degrees: usize) -> bool {
    let is_kick = scheme.unknowns == Unknowns::None && scheme.update == MomentumUpdate::Multiple(1.0);
    is_kick && degrees >= LEAST_IN_WINDOWS
}

/// Windows of a system, what is needed for one of them, and the new state.
#[derive(Debug)]
pub(super) struct Plan {
    windows: Windows,
    sums: Vec<f64>,
    instructions: InstructionSet,
    pub(super) next_q: Vec<f64>,
    pub(super) next_p: Vec<f64>,
}

impl Plan {
    /// Takes down where the elements of a system add what.
    #[cold]
    #[inline(never)]
    pub(super) fn new<H: Elements>(step: &Step<'_, H, f64>) -> Self {
        let recorder = Recorder::default();
        for wanted in [Slopes::BY_COORDINATES, Slopes::BY_MOMENTA] {
            step.slopes_in::<f64, _>(step.p, wanted, &mut &recorder);
        }
        let windows = Windows::new(step.degrees(), SIZE, recorder);
        let sums = vec![nothing(); windows.room() + LINE];
        let [next_q, next_p] = [vec![0.0; step.degrees()], vec![0.0; step.degrees()]];
        Self { windows, sums, instructions: InstructionSet::best(), next_q, next_p }
    }
}

/// Sums of a window in a list of their own, of which those before `filled` have terms: what comes to the others is their first.
pub(super) struct Window<'a> {
    strip: Strip<'a>,
    sums: &'a mut [f64],
    filled: usize,
}

impl<'a> Window<'a> {
    /// Without a term.
    #[inline(always)]
    pub(super) fn empty(strip: Strip<'a>, sums: &'a mut [f64]) -> Self {
        Self { strip, sums, filled: 0 }
    }

    /// Where the sums of `len` places from `first` on are, and whether they have no term yet.
    #[inline(always)]
    fn open(&mut self, first: usize, len: usize) -> (usize, bool) {
        let position = self.strip.position(first, len);
        let end = position + len;
        if end <= self.filled || position >= self.strip.unread() {
            return (position, false);
        }
        let is_fresh = position >= self.filled;
        self.sums[self.filled..if is_fresh { position } else { end }].fill(nothing());
        self.filled = end;
        (position, is_fresh)
    }

    /// The sums of the window.
    #[inline(always)]
    pub(super) fn finish(self) -> &'a [f64] {
        let Self { strip, sums, filled } = self;
        let own = strip.own();
        if filled < own.end {
            sums[filled..own.end].fill(nothing());
        }
        &sums[own]
    }
}

impl<'a> Sums<f64> for Window<'a> {
    type Outer = Values<'a>;
    type Run<'r>
        = Gathered<'r>
    where
        Self: 'r;
    type Points<'r, const D: usize>
        = Points<'r, f64, D>
    where
        Self: 'r;

    #[inline(always)]
    fn outer(&self, variable: usize, _values: Range<isize>) -> Values<'a> {
        self.strip.outer(variable)
    }
    #[inline(always)]
    fn clip<const N: usize>(&self, len: usize, first: [usize; N]) -> (usize, usize) {
        self.strip.clip(len, first)
    }
    #[inline(always)]
    fn run(&mut self, first: usize, len: usize) -> Gathered<'_> {
        let (position, is_fresh) = self.open(first, len);
        Gathered { sums: &mut self.sums[position..position + len], is_fresh }
    }
    #[inline(always)]
    fn points<const D: usize>(&mut self, first: usize, len: usize) -> Points<'_, f64, D> {
        let (position, is_fresh) = self.open(first, D * len);
        let points = self.sums.points(position, len);
        if is_fresh {
            points.0.fill([nothing(); D]);
        }
        points
    }
    #[inline(always)]
    fn add<T: Number<f64>>(&mut self, place: usize, value: T) {
        self.run(place, 1).add(0, value);
    }
}

/// A stretch of a window.
pub(super) struct Gathered<'r> {
    sums: &'r mut [f64],
    is_fresh: bool,
}

impl Run<f64> for Gathered<'_> {
    #[inline(always)]
    fn add<T: Number<f64>>(&mut self, place: usize, value: T) {
        let sum = if self.is_fresh { nothing() } else { self.sums[place] };
        self.sums[place] = (T::of(sum) + value).kept();
    }
    #[inline(always)]
    fn add_part<T: Number<f64>>(&mut self, place: usize, part: usize, value: T) {
        self.add(place + part, value);
    }
}

/// Sums of one term each and a number that is known before: `next[i] = base[i] + term`.
struct Moved<'a> {
    strip: Strip<'a>,
    base: &'a [f64],
    next: &'a mut [f64],
}

impl<'a> Sums<f64> for Moved<'a> {
    type Outer = Values<'a>;
    type Run<'r>
        = MovedRun<'r, 1>
    where
        Self: 'r;
    type Points<'r, const D: usize>
        = MovedRun<'r, D>
    where
        Self: 'r;

    #[inline(always)]
    fn outer(&self, variable: usize, _values: Range<isize>) -> Values<'a> {
        self.strip.outer(variable)
    }
    #[inline(always)]
    fn clip<const N: usize>(&self, len: usize, first: [usize; N]) -> (usize, usize) {
        self.strip.clip(len, first)
    }
    #[inline(always)]
    fn run(&mut self, first: usize, len: usize) -> MovedRun<'_, 1> {
        self.points::<1>(first, len)
    }
    #[inline(always)]
    fn points<const D: usize>(&mut self, first: usize, len: usize) -> MovedRun<'_, D> {
        let places = first..first + D * len;
        MovedRun {
            base: &self.base[places.clone()].as_chunks().0[..len],
            next: &mut self.next[places].as_chunks_mut().0[..len],
        }
    }
    #[inline(always)]
    fn add<T: Number<f64>>(&mut self, place: usize, value: T) {
        if (self.strip.start..self.strip.end).contains(&place) {
            self.run(place, 1).add(0, value);
        }
    }
}

/// A stretch of [`Moved`], in points.
struct MovedRun<'r, const D: usize> {
    base: &'r [[f64; D]],
    next: &'r mut [[f64; D]],
}

impl<const D: usize> Run<f64> for MovedRun<'_, D> {
    #[inline(always)]
    fn add<T: Number<f64>>(&mut self, place: usize, value: T) {
        self.add_part(place, 0, value);
    }
    #[inline(always)]
    fn add_part<T: Number<f64>>(&mut self, place: usize, part: usize, value: T) {
        self.next[place][part] = (T::of(self.base[place][part]) + value).kept();
    }
}

impl<H: Elements> Step<'_, H, f64> {
    /// Adds the slopes of the step Hamiltonian `T(p) + V(q)` to `into`: those by coordinates as they enter `D_1 L_d`, or those by
    /// momenta.
    #[inline(always)]
    fn slopes_in<T: Number<f64>, A: Sums<f64>>(&self, p: &[f64], wanted: Slopes, into: &mut A) {
        let none = &mut [][..];
        for stage in self.scheme.stages {
            if wanted.by_q && stage.start == 0.0 {
                continue;
            }
            let at = self.at(stage, self.q, p);
            for &(part, weight) in stage.parts {
                if wanted.by_q {
                    self.system.slopes::<f64, T, A, [f64]>(part, weight, &at, wanted, into, none);
                } else {
                    self.system.slopes::<f64, T, [f64], A>(part, weight, &at, wanted, none, into);
                }
            }
        }
    }

    /// The sums of a window.
    #[inline(always)]
    fn sums_of<'w, T: Number<f64>>(
        &self,
        strip: Strip<'w>,
        p: &[f64],
        wanted: Slopes,
        sums: &'w mut [f64],
    ) -> &'w [f64] {
        let mut window = Window::empty(strip, sums);
        self.slopes_in::<T, _>(p, wanted, &mut window);
        window.finish()
    }

    /// The new state into `plan`; whether it is finite.
    #[inline(always)]
    fn all_windows<T: Number<f64>>(&self, plan: &mut Plan) -> bool {
        let Plan { windows, sums, next_q, next_p, .. } = plan;
        let degrees = self.degrees();
        let (next_q, next_p) = (&mut next_q[..degrees], &mut next_p[..degrees]);
        let first = sums[windows.margin()..].as_ptr().align_offset(LINE * size_of::<f64>()).min(LINE);
        let sums = &mut sums[first..];
        let mut check = Check::default();
        for strip in windows.all() {
            let places = strip.start..strip.end;
            let forces = self.sums_of::<T>(strip, self.p, Slopes::BY_COORDINATES, sums);
            check.store(&mut next_p[places.clone()], &self.p[places.clone()], forces, |p, force| p - force);
            if H::HAS_ONE_VELOCITY && self.scheme.takes_parts_once() {
                let mut moved = Moved { strip, base: self.q, next: &mut *next_q };
                self.slopes_in::<T, _>(next_p, Slopes::BY_MOMENTA, &mut moved);
                check.look(&next_q[places]);
            } else {
                let velocities = self.sums_of::<T>(strip, next_p, Slopes::BY_MOMENTA, sums);
                check.store(&mut next_q[places.clone()], &self.q[places], velocities, |q, velocity| {
                    q + velocity
                });
            }
        }
        check.is_finite()
    }

    /// The new state into `plan`.
    ///
    /// # Errors
    /// [`StepFailure::NonFinite`] if it is not finite.
    #[inline(never)]
    pub(super) fn advance_windows(&self, plan: &mut Option<Box<Plan>>) -> Result<(), StepFailure> {
        let plan = plan.get_or_insert_with(|| Box::new(Plan::new(self)));
        let instructions = plan.instructions;
        if instructions.run(WindowedStep { step: self, plan }) || self.take_exactly(plan) {
            return Ok(());
        }
        Err(StepFailure::NonFinite)
    }

    /// The same where a function has an argument that is not usual, or to no avail.
    #[cold]
    #[inline(never)]
    fn take_exactly(&self, plan: &mut Plan) -> bool {
        self.all_windows::<H::Exact>(plan)
    }
}

/// One step, window by window. The output is whether all of it is finite.
struct WindowedStep<'a, 's, H> {
    step: &'a Step<'s, H, f64>,
    plan: &'a mut Plan,
}

impl<H: Elements> Kernel for WindowedStep<'_, '_, H> {
    type Output = bool;

    #[inline(always)]
    fn run<const L: usize, const HALF: usize>(self) -> bool {
        self.step.all_windows::<H::Usual>(self.plan)
    }
}

/// Numbers that are checked side by side.
const BESIDE: usize = 16;

/// Whether all numbers are finite: zero times any of them is zero.
#[derive(Default)]
struct Check([f64; BESIDE]);

impl Check {
    #[inline(always)]
    fn look(&mut self, numbers: &[f64]) {
        let (groups, rest) = numbers.as_chunks::<BESIDE>();
        for group in groups {
            for (zero, number) in self.0.iter_mut().zip(group) {
                *zero += number * 0.0;
            }
        }
        for (zero, number) in self.0.iter_mut().zip(rest) {
            *zero += number * 0.0;
        }
    }

    /// `into = sum(base, term)`, one by one.
    #[inline(always)]
    fn store(&mut self, into: &mut [f64], base: &[f64], terms: &[f64], sum: impl Fn(f64, f64) -> f64) {
        let (base, terms) = (&base[..into.len()], &terms[..into.len()]);
        let (into, into_rest) = into.as_chunks_mut::<BESIDE>();
        let ((base, base_rest), (terms, terms_rest)) =
            (base.as_chunks::<BESIDE>(), terms.as_chunks::<BESIDE>());
        for ((into, base), terms) in into.iter_mut().zip(base).zip(terms) {
            let new: [f64; BESIDE] = std::array::from_fn(|i| sum(base[i], terms[i]));
            *into = new;
            self.0.iter_mut().zip(new).for_each(|(zero, new)| *zero += new * 0.0);
        }
        for (into, (&base, &term)) in into_rest.iter_mut().zip(base_rest.iter().zip(terms_rest)) {
            *into = sum(base, term);
        }
        self.look(into_rest);
    }

    #[inline(always)]
    fn is_finite(&self) -> bool {
        self.0.iter().sum::<f64>() == 0.0
    }
}
