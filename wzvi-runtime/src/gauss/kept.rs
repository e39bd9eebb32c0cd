//! What a step leaves for the next one, and its scratch.

use super::newton::Newton;
use super::shape::Shape;
use super::stages::{Scratch, Stages};
use crate::memory::{Iteration, StepMemory};
use crate::numbers::{Numbers, Tape};
use crate::scalar::Scalar;

/// A list of numbers of all stages.
type OfStages<S, H, const N: usize> = <H as Shape>::Of<<S as Scalar>::Stages<N>>;

/// The slopes of the last step at its `N` stages, and the lists of a step.
#[derive(Debug)]
pub struct Memory<S: Scalar, H: Shape, const N: usize> {
    /// `b_i ∂F/∂p` and `-b_i ∂F/∂q` of the last step.
    pub(super) past: [OfStages<S, H, N>; 2],
    pub(super) is_known: bool,
    /// Whether sweeps did not contract in the last step.
    pub(super) prefers_newton: bool,
    pub(super) iteration: Iteration,
    pub(super) lists: Lists<S, H, N>,
    pub(super) scratch: Scratch<S, S::Stages<N>>,
    pub(super) newton: Newton<S>,
}

/// What a step computes.
#[derive(Debug)]
pub(super) struct Lists<S: Scalar, H: Shape, const N: usize> {
    /// Coordinates and momenta at the stages.
    pub(super) at: [OfStages<S, H, N>; 2],
    /// `b_i ∂F/∂p` and `-b_i ∂F/∂q`.
    pub(super) slopes: [OfStages<S, H, N>; 2],
    /// Slopes that nobody reads.
    pub(super) spare: OfStages<S, H, N>,
    /// The increments of the state, then the new state.
    pub(super) next: [H::Of<S>; 2],
    /// What rounding took from the new state.
    pub(super) lost: [H::Of<S>; 2],
}

impl<S: Scalar, H: Shape, const N: usize> Lists<S, H, N> {
    fn of_length(length: usize) -> Self {
        let zero = S::from_f64(0.0);
        let stages = || H::list(length, S::Stages::<N>::splat(zero));
        let ends = || H::list(length, zero);
        Self {
            at: [stages(), stages()],
            slopes: [stages(), stages()],
            spare: stages(),
            next: [ends(), ends()],
            lost: [ends(), ends()],
        }
    }

    /// The lists, for the duration of a step.
    #[inline(always)]
    pub(super) fn take(&mut self) -> Self {
        let zero = S::from_f64(0.0);
        let zeros = S::Stages::<N>::splat(zero);
        let Self { at: [q, p], slopes: [by_p, by_q], spare, next: [next_q, next_p], lost: [lost_q, lost_p] } =
            self;
        Self {
            at: [H::take(q, zeros), H::take(p, zeros)],
            slopes: [H::take(by_p, zeros), H::take(by_q, zeros)],
            spare: H::take(spare, zeros),
            next: [H::take(next_q, zero), H::take(next_p, zero)],
            lost: [H::take(lost_q, zero), H::take(lost_p, zero)],
        }
    }

    /// Takes them back.
    #[inline(always)]
    pub(super) fn give_back(&mut self, lists: Self) {
        let Self { at: [q, p], slopes: [by_p, by_q], spare, next: [next_q, next_p], lost: [lost_q, lost_p] } =
            lists;
        H::give_back(&mut self.at[0], q);
        H::give_back(&mut self.at[1], p);
        H::give_back(&mut self.slopes[0], by_p);
        H::give_back(&mut self.slopes[1], by_q);
        H::give_back(&mut self.spare, spare);
        H::give_back(&mut self.next[0], next_q);
        H::give_back(&mut self.next[1], next_p);
        H::give_back(&mut self.lost[0], lost_q);
        H::give_back(&mut self.lost[1], lost_p);
    }
}

impl<S: Scalar, H: Shape, const N: usize> Default for Memory<S, H, N> {
    fn default() -> Self {
        let past = || H::list(0, S::Stages::<N>::splat(S::from_f64(0.0)));
        Self {
            past: [past(), past()],
            is_known: false,
            prefers_newton: false,
            iteration: Iteration::Automatic,
            lists: Lists::of_length(0),
            scratch: Scratch::default(),
            newton: Newton::default(),
        }
    }
}

/// What the steps before left; scratch is allocated anew where the copy is used.
impl<S: Scalar, H: Shape, const N: usize> Clone for Memory<S, H, N> {
    fn clone(&self) -> Self {
        Self {
            past: self.past.clone(),
            is_known: self.is_known,
            prefers_newton: self.prefers_newton,
            iteration: self.iteration,
            ..Self::default()
        }
    }

    fn clone_from(&mut self, other: &Self) {
        self.past.clone_from(&other.past);
        (self.is_known, self.prefers_newton) = (other.is_known, other.prefers_newton);
        self.iteration = other.iteration;
    }
}

impl<S: Scalar, H: Shape, const N: usize> Numbers for Memory<S, H, N> {
    fn pass(&mut self, tape: &mut Tape) {
        tape.flag(&mut self.is_known);
        tape.flag(&mut self.prefers_newton);
        if self.is_known {
            let length = tape.length(self.past[0].as_ref().len());
            self.fit(length);
            for past in &mut self.past {
                past.as_mut().iter_mut().for_each(|number| number.pass(tape));
            }
        }
    }
}

impl<S: Scalar, H: Shape, const N: usize> Memory<S, H, N> {
    /// Makes room for so many degrees of freedom.
    pub(super) fn fit(&mut self, length: usize) {
        if self.lists.spare.as_ref().len() != length {
            self.lists = Lists::of_length(length);
        }
        if self.past[0].as_ref().len() != length {
            let past = || H::list(length, S::Stages::<N>::splat(S::from_f64(0.0)));
            self.past = [past(), past()];
            self.is_known = false;
        }
    }
}

impl<S: Scalar, H: Shape, const N: usize> StepMemory for Memory<S, H, N> {
    fn forget(&mut self) {
        (self.is_known, self.prefers_newton) = (false, false);
    }

    fn adopt(&mut self, left: Self) {
        self.past = left.past;
        (self.is_known, self.prefers_newton) = (left.is_known, left.prefers_newton);
    }

    fn pin(&mut self, iteration: Iteration) {
        self.iteration = iteration;
    }

    fn pinned(&self) -> Iteration {
        self.iteration
    }
}
