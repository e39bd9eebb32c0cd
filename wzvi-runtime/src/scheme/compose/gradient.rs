//! Kicks by potentials with the square of the force, `b V - c |V'|²`, for quadratic kinetic energies.
//!
//! For the step Hamiltonian `F = T(p) + V(q, t)` with constant `T''`, the bracket `{V, {T, V}}` is, up to its
//! sign, the function `|V'|² = V' · T'' V'` of the coordinates. Its flow is a kick, too, and combines with
//! that of `V`:
//!
//! ```text
//! p ← p - b V' + 2 c V'' T'' V'
//! ```
//!
//! `T'' V'` and `V'' (T'' V')` are directional derivatives of the generated derivatives, computed with dual
//! numbers: two evaluations in addition to the force, for any number of degrees of freedom. All evaluations
//! are of the fraction `s = -b` of `F`, for which the last term is `2 c / s³` times `s³ V'' T'' V'`.

use super::flows::KickDriftFlows;
use crate::algebra::scalar::{ComputesWith, Constant, ConstantsIn, Dual, Scalar};
use crate::error::{StepFailure, StepPromise};
use crate::scheme::elements::PairColumns;
use crate::scheme::gauss::Field;
use crate::scheme::word::{Part, Substep};

impl<F: Field, const SQUARES: bool> KickDriftFlows<'_, F, f64, SQUARES> {
    /// `c |V'(q)|²` of a kick.
    pub(super) fn of_square(&self, substep: &Substep, q: &[f64], dw: &[f64]) -> f64 {
        let Part::GradientB(factor) = substep.part else { return 0.0 };
        let (mut directional, degrees) = (Directional::default(), q.len());
        directional.fit(degrees, dw.len());
        let dw: Vec<f64> = dw.iter().map(|dw| substep.share * dw).collect();
        let [mut force, mut change] = [vec![0.0; degrees], vec![0.0; degrees]];
        let square = KickInput { flows: self, substep, q, dw: &dw }.differentiate(
            &mut directional,
            &mut force,
            &mut change,
        );
        factor / Scalar::powi(substep.share, 3) * square.unwrap_or(f64::NAN)
    }
}

/// The input of a force, which is evaluated for the share of the step Hamiltonian that the kick has.
pub(super) struct KickInput<'a, 'f, F: Field, K: Constant, S, const SQUARES: bool> {
    pub(super) flows: &'a KickDriftFlows<'f, F, K, SQUARES>,
    pub(super) substep: &'a Substep,
    pub(super) q: &'a [S],
    pub(super) dw: &'a [S],
}

impl<F: Field, K: Constant, S: ComputesWith<K>, const SQUARES: bool> KickInput<'_, '_, F, K, S, SQUARES> {
    /// Writes `V'` into `force` and `V'' T'' V'` into `change`; returns `|V'|²`.
    ///
    /// # Errors
    /// [`StepPromise::PlainConstants`]
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn differentiate(
        &self,
        room: &mut Directional<S>,
        force: &mut [S],
        change: &mut [S],
    ) -> Result<S, StepFailure> {
        let &Self { flows: &KickDriftFlows { system, parameters, along, t, h, .. }, substep, q, dw } = self;
        let Some(along) = along else { return Err(StepFailure::Internal(StepPromise::PlainConstants)) };
        let (t, h) = (t + h * substep.node, h * substep.share);
        // `V'` and the constant `T''` do not depend on the momenta.
        let (at, into) = (([S::constant(t), S::constant(h)], [q, q], dw), [&mut *force, &mut []]);
        system.step_gradient::<K, S, true, false>(parameters, at, into, &mut room.columns);
        for (dual, &dw) in room.dw.iter_mut().zip(dw) {
            *dual = Dual::constant(dw);
        }
        for ((dual_q, dual_p), (&q, &force)) in room.q.iter_mut().zip(&mut room.p).zip(q.iter().zip(&*force))
        {
            *dual_q = Dual::constant(q);
            *dual_p = Dual { value: S::from_f64(0.0), derivative: [force] };
        }
        room.gradient::<F, K, false, true>(system, along, [t, h]);
        let mut square = S::from_f64(0.0);
        for ((dual_q, slope), &force) in room.q.iter_mut().zip(&room.slopes).zip(&*force) {
            dual_q.derivative = slope.derivative;
            square = square + force * slope.derivative[0];
        }
        room.gradient::<F, K, true, false>(system, along, [t, h]);
        for (change, slope) in change.iter_mut().zip(&room.slopes) {
            [*change] = slope.derivative;
        }
        Ok(square)
    }
}

/// Scratch for derivatives with their derivative in one direction.
#[derive(Debug, Default)]
pub(super) struct Directional<S> {
    q: Vec<Dual<1, S>>,
    p: Vec<Dual<1, S>>,
    slopes: Vec<Dual<1, S>>,
    dw: Vec<Dual<1, S>>,
    columns: PairColumns,
}

impl<S: Scalar> Directional<S> {
    /// Allocates for these numbers of degrees of freedom and noises, unless done before.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn fit(&mut self, degrees: usize, noises: usize) {
        if self.q.len() != degrees || self.dw.len() != noises {
            let zero = Dual::from_f64(0.0);
            for list in [&mut self.q, &mut self.p, &mut self.slopes] {
                list.resize(degrees, zero);
            }
            self.dw.resize(noises, zero);
        }
    }

    /// The derivatives by the coordinates or by the momenta.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn gradient<F: Field, K: Constant, const BY_Q: bool, const BY_P: bool>(
        &mut self,
        system: &F,
        parameters: &ConstantsIn<F::Parameters, K::Lifted>,
        constants: [K; 2],
    ) where
        S: ComputesWith<K>,
    {
        let [t, h] = constants.map(|constant| S::Along::constant(constant.lifted()));
        let Self { q, p, slopes, dw, columns } = self;
        let [q, p, slopes, dw] = S::along([q, p, slopes, dw]);
        let (by_q, by_p) = if BY_Q { (slopes, &mut [][..]) } else { (&mut [][..], slopes) };
        let (at, into) = (([t, h], [&*q, &*p], &*dw), [by_q, by_p]);
        system.step_gradient::<K::Lifted, S::Along, BY_Q, BY_P>(parameters, at, into, columns);
    }
}
