//! Derivatives at the stages of a step, and scratch for them.

use super::Field;
use super::equations::StepEquations;
use crate::algebra::scalar::{ComputesWith, Constant, Parameters, Scalar};
use crate::algebra::shape::Shape;
pub use crate::algebra::stages::Stages;
use crate::scheme::elements::{FieldAt, PairColumns};

/// The unit of arithmetic for numbers `S`: all stages of one path in the lanes of a register, or one stage.
pub(super) type StagePack<S, const N: usize> = <<S as Scalar>::Stages<N> as Stages<S, N>>::Part;

/// Scratch for one stage of a path whose stages are evaluated one by one, and for derivatives.
#[derive(Clone, Debug, Default)]
pub struct OneStage<S> {
    lists: [Vec<S>; 4],
    dw: Vec<S>,
    columns: PairColumns,
}

/// All stages, where they are one part.
#[cfg_attr(not(debug_assertions), inline(always))]
fn all_of<S: Scalar, const N: usize>(part: &StagePack<S, N>) -> S::Stages<N> {
    let mut all = S::Stages::<N>::splat(S::from_f64(0.0));
    all.set_part(0, *part);
    all
}

/// Stage `i` of them.
#[cfg_attr(not(debug_assertions), inline(always))]
fn stage<S: Scalar, const N: usize>(part: &StagePack<S, N>, i: usize) -> S {
    all_of::<S, N>(part).get(i)
}

/// Sets stage `i`.
#[cfg_attr(not(debug_assertions), inline(always))]
fn set_stage<S: Scalar, const N: usize>(part: &mut StagePack<S, N>, i: usize, number: S) {
    let mut all = all_of::<S, N>(part);
    all.set(i, number);
    *part = all.part(0);
}

impl<F: Field, K: Constant, S: ComputesWith<K>, const N: usize> StepEquations<'_, F, K, S, N> {
    /// The derivatives of the step Hamiltonian at the stages of a part.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn gradient<const BY_Q: bool, const BY_P: bool>(
        &self,
        ([t, h], [q, p], dw): FieldAt<'_, StagePack<S, N>>,
        [by_q, by_p]: [&mut [StagePack<S, N>]; 2],
        one: &mut OneStage<S>,
    ) {
        let (system, parameters) = (self.system, self.parameters);
        // A part is one stage, of any numbers.
        if let Some(&[t, h]) = S::Stages::<N>::numbers(&[t, h])
            && let (Some(q), Some(p), Some(dw)) =
                (S::Stages::<N>::numbers(q), S::Stages::<N>::numbers(p), S::Stages::<N>::numbers(dw))
            && let (Some(by_q), Some(by_p)) =
                (S::Stages::<N>::numbers_mut(by_q), S::Stages::<N>::numbers_mut(by_p))
        {
            let columns = &mut one.columns;
            let (at, into) = (([t, h], [q, p], dw), [by_q, by_p]);
            return system.step_gradient::<K, S, BY_Q, BY_P>(parameters, at, into, columns);
        }
        // It is all stages of one path.
        if F::IN_LANES {
            let parameters = &F::Parameters::lane(parameters, 0);
            let columns = &mut one.columns;
            let (at, into) = (([t, h], [q, p], dw), [by_q, by_p]);
            return system.step_gradient::<f64, StagePack<S, N>, BY_Q, BY_P>(parameters, at, into, columns);
        }
        let OneStage { lists: [own_q, own_p, own_by_q, own_by_p], dw: own_dw, columns } = one;
        for own in [&mut *own_q, own_p, own_by_q, own_by_p] {
            own.resize(q.len(), S::from_f64(0.0));
        }
        own_dw.resize(dw.len(), S::from_f64(0.0));
        for i in 0..N {
            for (own, all) in own_q.iter_mut().chain(&mut *own_p).zip(q.iter().chain(p)) {
                *own = stage::<S, N>(all, i);
            }
            own_dw.iter_mut().zip(dw).for_each(|(own, all)| *own = stage::<S, N>(all, i));
            let [t, h] = [stage::<S, N>(&t, i), stage::<S, N>(&h, i)];
            let (at, into) = (([t, h], [&own_q[..], own_p], &own_dw[..]), [&mut own_by_q[..], own_by_p]);
            system.step_gradient::<K, S, BY_Q, BY_P>(parameters, at, into, columns);
            if BY_Q {
                by_q.iter_mut().zip(&*own_by_q).for_each(|(all, own)| set_stage::<S, N>(all, i, *own));
            }
            if BY_P {
                by_p.iter_mut().zip(&*own_by_p).for_each(|(all, own)| set_stage::<S, N>(all, i, *own));
            }
        }
    }
}

/// The scratch of a sweep.
#[derive(Debug)]
pub(super) struct SweepScratch<S: Scalar, H: Shape, W: Shape, const N: usize> {
    pub(super) parts: PackedStages<S, H, W, N>,
    pub(super) one: OneStage<S>,
}

/// Scratch for a part of the stages of each degree of freedom and noise.
#[derive(Debug)]
#[repr(align(64))]
pub(super) struct PackedStages<S: Scalar, H: Shape, W: Shape, const N: usize> {
    pub(super) q: H::List<StagePack<S, N>>,
    pub(super) p: H::List<StagePack<S, N>>,
    pub(super) by_q: H::List<StagePack<S, N>>,
    pub(super) by_p: H::List<StagePack<S, N>>,
    pub(super) dw: W::List<StagePack<S, N>>,
}

impl<S: Scalar, H: Shape, W: Shape, const N: usize> SweepScratch<S, H, W, N> {
    /// Scratch for so many degrees of freedom and noises. If a part is all stages of one path, it is
    /// empty: the lists themselves are used.
    pub(super) fn of_length(degrees: usize, noises: usize) -> Self {
        let is_needed = S::Stages::<N>::numbers(&[]).is_some();
        let (degrees, noises) = if is_needed { (degrees, noises) } else { (0, 0) };
        Self { parts: PackedStages::of_length(degrees, noises), one: OneStage::default() }
    }

    /// Allocates for steps whose stages are evaluated one by one.
    pub(super) fn reserve(&mut self, degrees: usize, noises: usize) {
        self.one.lists.iter_mut().for_each(|list| list.reserve(degrees));
        self.one.dw.reserve(noises);
    }
}

impl<S: Scalar, H: Shape, W: Shape, const N: usize> PackedStages<S, H, W, N> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn of_length(degrees: usize, noises: usize) -> Self {
        let zero = StagePack::<S, N>::from_f64(0.0);
        let list = || H::list(degrees, zero);
        Self { q: list(), p: list(), by_q: list(), by_p: list(), dw: W::list(noises, zero) }
    }
}
