//! The memory between steps, and the scratch of a step.

use super::Field;
use super::choice::NewtonBackoff;
use super::newton::Newton;
use super::solve::ScalarPath;
use super::stages::{StagePack, Stages, SweepScratch};
use super::stiff::ModalStages;
use super::tangent::Linear;
use crate::algebra::memory::{Iteration, MemoryRequest, SolverReport, StepMemory};
use crate::algebra::scalar::{Rounded, Scalar};
use crate::algebra::shape::Shape;
use crate::algebra::stages::plus;
use crate::ground::numbers::{Numbers, Tape};
use crate::scheme::elements::Elements;

/// The data of a step of a system.
pub(super) type GaussInputOf<F, S, const N: usize> =
    GaussInput<S, <F as Elements>::Shape, <F as Field>::Noises, N>;

/// The history of the steps of a system.
pub(super) type GaussHistoryOf<F, S, const N: usize> =
    GaussHistory<S, <F as Elements>::Shape, <F as Field>::Noises, N>;

/// The memory of a system's steps.
pub(super) type GaussMemoryOf<F, S, const N: usize> =
    GaussMemory<S, <F as Elements>::Shape, <F as Field>::Noises, N>;

/// Scratch for the equations of a system in numbers that carry their rounding error.
pub(super) type RoundedScratchOf<F, const N: usize> =
    RoundedScratch<<F as Elements>::Shape, <F as Field>::Noises, N>;

/// A list of numbers of all stages.
pub(super) type OfStages<S, H, const N: usize> = <H as Shape>::List<<S as Scalar>::Stages<N>>;

/// The derivatives of the last step at its `N` stages, and the lists of a step.
#[derive(Debug)]
pub struct GaussMemory<S: Scalar, H: Shape, W: Shape, const N: usize> {
    pub(super) left: GaussHistory<S, H, W, N>,
    pub(super) given: GaussInput<S, H, W, N>,
    pub(super) lists: StageLists<S, H, N>,
}

/// The memory of a step for the next one, and scratch for its solution.
#[derive(Debug)]
#[repr(align(64))]
pub(super) struct GaussHistory<S: Scalar, H: Shape, W: Shape, const N: usize> {
    /// `b_i ∂F/∂p` and `b_i ∂F/∂q` of the last step; in Nyström form the first is `∂F/∂p`, for one path.
    pub(super) past: [OfStages<S, H, N>; 2],
    pub(super) is_known: bool,
    /// Whether they belong to a part of the same step.
    pub(super) is_held: bool,
    pub(super) waits: NewtonBackoff<S>,
    pub(super) iteration: Iteration,
    pub(super) scratch: SweepScratch<S, H, W, N>,
    pub(super) modal: ModalStages<S::Stages<N>>,
    pub(super) newton: Newton<S>,
    pub(super) exact: RoundedScratch<H, W, N>,
    /// The derivative of a step, which few runs ask for.
    pub(super) linear: Option<Box<Linear<N>>>,
    /// Scratch for a path that is solved alone.
    pub(super) scalar_path: Option<Box<ScalarPath<H, W, N>>>,
    /// The knowledge about the step of that path.
    pub(super) known: KnownDerivatives,
    /// The derivatives that are taken of it in all.
    pub(super) derivatives: usize,
}

/// The knowledge about a step in numbers with derivatives before it is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum KnownDerivatives {
    Nothing,
    /// The derivatives at the stages.
    Slopes,
    /// The derivatives at the stages, and the factors of the Jacobian there.
    Factors,
}

/// Gives the derivatives of the last step to one in other numbers.
pub(super) fn hand_values<S: Scalar, H: Shape, W: Shape, const N: usize>(
    from: &GaussMemory<f64, H, W, N>,
    to: &mut GaussMemory<S, H, W, N>,
) {
    to.left.scalar_path.get_or_insert_default().read_slopes(&from.left.past, from.left.waits);
    to.left.known = KnownDerivatives::Slopes;
}

/// Scratch for a part of the stages of a system.
pub(super) type SweepScratchOf<F, S, const N: usize> =
    SweepScratch<S, <F as Elements>::Shape, <F as Field>::Noises, N>;

/// Scratch for the equations in numbers that carry their rounding error. Few steps need it, so it is
/// allocated by the first that does, and kept.
#[derive(Debug)]
pub(super) struct RoundedScratch<H: Shape, W: Shape, const N: usize>(Option<Box<RoundedLists<H, W, N>>>);

/// The data of a step and its results.
#[derive(Debug)]
pub(super) struct RoundedLists<H: Shape, W: Shape, const N: usize> {
    pub(super) given: GaussInput<Rounded, H, W, N>,
    pub(super) lists: StageLists<Rounded, H, N>,
    pub(super) scratch: SweepScratch<Rounded, H, W, N>,
}

impl<H: Shape, W: Shape, const N: usize> RoundedScratch<H, W, N> {
    /// Scratch for so many degrees of freedom and noises.
    pub(super) fn lists(&mut self, degrees: usize, noises: usize) -> &mut RoundedLists<H, W, N> {
        let room = self.0.take().filter(|room| room.lists.fits(degrees) && room.given.fits(noises));
        self.0.insert(room.unwrap_or_else(|| {
            let scratch = SweepScratch::of_length(degrees, noises);
            let (given, lists) = (GaussInput::of_length(degrees, noises), StageLists::of_length(degrees));
            Box::new(RoundedLists { given, lists, scratch })
        }))
    }
}

/// The data of a step.
#[derive(Debug)]
#[repr(align(64))]
pub(super) struct GaussInput<S: Scalar, H: Shape, W: Shape, const N: usize> {
    /// `q` and `p` with their compensation.
    pub(super) start: [H::List<S>; 2],
    /// `b_i ΔW_k`
    pub(super) dw: OfStages<S, W, N>,
}

/// The results of a step.
#[derive(Debug)]
#[repr(align(64))]
pub(super) struct StageLists<S: Scalar, H: Shape, const N: usize> {
    /// Coordinates and momenta at the stages.
    pub(super) at: [OfStages<S, H, N>; 2],
    /// `b_i ∂F/∂p` and `b_i ∂F/∂q`; in Nyström form the first is `∂F/∂p`.
    pub(super) slopes: [OfStages<S, H, N>; 2],
    /// Derivatives that are not read.
    pub(super) spare: OfStages<S, H, N>,
    /// The largest relative changes of the last sweep.
    pub(super) changes: StagePack<S, N>,
    /// The increments of the state, then the new state.
    pub(super) next: [H::List<S>; 2],
    /// The rounding error of the new state.
    pub(super) lost: [H::List<S>; 2],
}

impl<S: Scalar, H: Shape, W: Shape, const N: usize> GaussInput<S, H, W, N> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn of_length(degrees: usize, noises: usize) -> Self {
        const { assert!(H::IS_FIXED == W::IS_FIXED, "both are arrays, or both vectors") }
        let zero = S::from_f64(0.0);
        Self {
            start: [H::list(degrees, zero), H::list(degrees, zero)],
            dw: W::list(noises, S::Stages::<N>::splat(zero)),
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn fits(&self, noises: usize) -> bool {
        self.dw.as_ref().len() == noises
    }
}

impl<S: Scalar, H: Shape, const N: usize> StageLists<S, H, N> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn of_length(length: usize) -> Self {
        let zero = S::from_f64(0.0);
        let stages = || H::list(length, S::Stages::<N>::splat(zero));
        let ends = || H::list(length, zero);
        Self {
            at: [stages(), stages()],
            slopes: [stages(), stages()],
            spare: stages(),
            changes: StagePack::<S, N>::from_f64(0.0),
            next: [ends(), ends()],
            lost: [ends(), ends()],
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn fits(&self, degrees: usize) -> bool {
        self.spare.as_ref().len() == degrees
    }

    /// The paths whose stages are all finite.
    #[cold]
    #[inline(never)]
    pub(super) fn are_finite(&self) -> S::Mask {
        let mut zeros = S::Stages::<N>::splat(S::from_f64(0.0));
        for list in &self.at {
            for stages in list.as_ref() {
                zeros = plus::<_, S, N>(zeros, stages.times(&[0.0; N]));
            }
        }
        zeros.total().is_finite()
    }
}

impl<S: Scalar, H: Shape, W: Shape, const N: usize> Default for GaussMemory<S, H, W, N> {
    fn default() -> Self {
        Self {
            left: GaussHistory::default(),
            given: GaussInput::of_length(0, 0),
            lists: StageLists::of_length(0),
        }
    }
}

impl<S: Scalar, H: Shape, W: Shape, const N: usize> Default for GaussHistory<S, H, W, N> {
    fn default() -> Self {
        let past = || H::list(0, S::Stages::<N>::splat(S::from_f64(0.0)));
        Self {
            past: [past(), past()],
            is_known: false,
            is_held: false,
            waits: NewtonBackoff::none(),
            iteration: Iteration::Automatic,
            scratch: SweepScratch::of_length(0, 0),
            modal: ModalStages::default(),
            newton: Newton::default(),
            exact: RoundedScratch(None),
            linear: None,
            scalar_path: None,
            known: KnownDerivatives::Nothing,
            derivatives: 0,
        }
    }
}

impl<S: Scalar, H: Shape, W: Shape, const N: usize> GaussHistory<S, H, W, N> {
    /// Whether there are derivatives of a step of so many degrees of freedom.
    pub(super) fn has_slopes(&self, degrees: usize) -> bool {
        self.past[1].as_ref().len() == degrees
    }
}

/// Copies the memory of the past steps; the copy allocates its own scratch.
impl<S: Scalar, H: Shape, W: Shape, const N: usize> Clone for GaussMemory<S, H, W, N> {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    fn clone_from(&mut self, other: &Self) {
        let (left, other) = (&mut self.left, &other.left);
        left.past.clone_from(&other.past);
        (left.is_known, left.is_held) = (other.is_known, other.is_held);
        left.waits = other.waits;
        left.iteration = other.iteration;
    }
}

impl<S: Scalar, H: Shape, W: Shape, const N: usize> Numbers for GaussMemory<S, H, W, N> {
    fn pass(&mut self, tape: &mut Tape) {
        let mut is_known = self.left.is_known;
        tape.flag(&mut is_known);
        self.left.waits.pass(tape);
        if is_known {
            let length = tape.length(self.left.past[0].as_ref().len());
            self.fit(length, self.given.dw.as_ref().len());
            for past in &mut self.left.past {
                past.as_mut().iter_mut().for_each(|number| number.pass(tape));
            }
        }
        // A memory that gets its size here knows no past step before these words.
        self.left.is_known = is_known;
        if const { S::IS_PLAIN_DUAL } {
            let mut is_there = self.left.scalar_path.is_some();
            tape.flag(&mut is_there);
            if is_there {
                self.left.scalar_path.get_or_insert_default().pass(tape);
            }
        }
    }
}

impl<S: Scalar, H: Shape, W: Shape, const N: usize> GaussMemory<S, H, W, N> {
    /// Whether the lists fit so many degrees of freedom and noises.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn fits(&self, degrees: usize, noises: usize) -> bool {
        self.lists.fits(degrees) && self.given.fits(noises)
    }

    /// Reads coordinates and momenta of the last step at stage `i`.
    pub(in crate::scheme) fn read_stage(&self, i: usize, into: [&mut Vec<S>; 2]) {
        for (into, stages) in into.into_iter().zip(&self.lists.at) {
            into.clear();
            into.extend(stages.as_ref().iter().map(|stages| stages.get(i)));
        }
    }

    /// Resizes the lists for so many degrees of freedom and noises.
    pub(super) fn fit(&mut self, degrees: usize, noises: usize) {
        if !self.fits(degrees, noises) {
            self.lists = StageLists::of_length(degrees);
            self.given = GaussInput::of_length(degrees, noises);
            self.left.scratch = SweepScratch::of_length(degrees, noises);
        }
        if self.left.past[0].as_ref().len() != degrees {
            let past = || H::list(degrees, S::Stages::<N>::splat(S::from_f64(0.0)));
            self.left.past = [past(), past()];
            (self.left.is_known, self.left.is_held) = (false, false);
            self.left.newton = Newton::default();
        }
    }
}

impl<S: Scalar, H: Shape, W: Shape, const N: usize> StepMemory for GaussMemory<S, H, W, N> {
    fn tell(&mut self, request: &MemoryRequest) {
        let left = &mut self.left;
        match request {
            MemoryRequest::Forget => {
                (left.is_known, left.is_held) = (false, false);
                left.waits = NewtonBackoff::none();
            }
            MemoryRequest::Hold => left.is_held = true,
            MemoryRequest::Pin(iteration) => left.iteration = *iteration,
            MemoryRequest::Derivatives(count) => left.derivatives = *count,
            MemoryRequest::Share(_) => {}
        }
    }

    fn adopt(&mut self, other: Self) {
        self.left.past = other.left.past;
        (self.left.is_known, self.left.waits) = (other.left.is_known, other.left.waits);
    }

    fn hand_values(&mut self, to: &mut Self, are_solved: bool) {
        std::mem::swap(&mut self.left.scalar_path, &mut to.left.scalar_path);
        self.left.newton.hand_factors(&mut to.left.newton);
        to.left.known = if are_solved && to.left.scalar_path.is_some() {
            KnownDerivatives::Factors
        } else {
            self.left.known
        };
        self.left.known = KnownDerivatives::Nothing;
    }

    fn report(&self) -> SolverReport {
        SolverReport { pinned: self.left.iteration, ..SolverReport::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::GaussMemory;
    use crate::algebra::shape::Dynamic;
    use crate::ground::numbers::{Numbers as _, Tape};

    /// A memory that has no size before it is read knows the step whose derivatives it reads.
    #[test]
    fn words_have_the_last_step() {
        let mut memory = GaussMemory::<f64, Dynamic, Dynamic, 3>::default();
        memory.fit(2, 0);
        memory.left.is_known = true;
        for (number, stages) in memory.left.past.iter_mut().flatten().enumerate() {
            (0..3).for_each(|stage| stages.set(stage, (number * 3 + stage) as f64));
        }
        let words = Tape::write(|tape| memory.pass(tape));
        let mut read = GaussMemory::<f64, Dynamic, Dynamic, 3>::default();
        Tape::read(words.clone(), |tape| read.pass(tape)).unwrap();
        assert!(read.left.is_known && read.left.has_slopes(2));
        assert_eq!(Tape::write(|tape| read.pass(tape)), words);
    }
}
