//! The discrete Euler-Lagrange equations of one step, `D_1 L_d`, `D_2 L_d` and `∂L_d/∂P` at trial values of
//! the unknowns.
//!
//! This code is inlined into the step of one system by one scheme, where the table of the scheme and often
//! the number of degrees of freedom are constants: loops over stages or roles and checks of lengths
//! disappear. Where neither speed nor allocation matters, it is compiled once for all schemes.

use super::lanes::is_in_lanes;
use super::memory::StepLists;
use super::passes::{add, are_finite};
use super::{
    ElementInput, Elements, EvaluationPoint, HessianBlock, MomentumUpdate, PairColumns, Partials, Quadrature,
    QuadraturePoint, Sums, Unknowns, WeightedRole, slopes,
};
use crate::algebra::scalar::{Constant, Number, Scalar};
use crate::algebra::state_sum::StateSum;
use crate::error::StepFailure;
use crate::scheme::system::Hamiltonian;

/// The input of one step.
pub(super) struct LoopStep<'a, H, S: Scalar> {
    pub(super) system: &'a H,
    pub(super) scheme: &'a Quadrature,
    pub(super) t: S::Constant,
    pub(super) h: S::Constant,
    /// As in [`EvaluationPoint`].
    pub(super) parameters: &'a [S::Constant],
    pub(super) q: &'a [S],
    pub(super) p: &'a [S],
    pub(super) dw: &'a [S],
    /// `u`, if both nodes are known and `P` alone is not.
    pub(super) increment: Option<&'a [S]>,
}

/// `e^{-γ h} - 1`
pub(super) fn decay<H: Elements, K: Constant>(system: &H, parameters: &[K], h: K) -> K {
    (-Elements::friction_rate(system, parameters) * h).exp_m1()
}

/// The start of a sum, `-0.0`: compilers may omit an addition to it, but not to `0.0`.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn nothing<S: Scalar>() -> S {
    S::from_f64(-0.0)
}

impl<H, S: Scalar> Clone for LoopStep<'_, H, S> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn clone(&self) -> Self {
        *self
    }
}

impl<H, S: Scalar> Copy for LoopStep<'_, H, S> {}

impl<'a, H: Elements, S: Scalar> LoopStep<'a, H, S> {
    /// The degrees of freedom.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn degrees(&self) -> usize {
        self.q.len()
    }
}

impl<H: Elements, S: Scalar> LoopStep<'_, H, S> {
    /// `u` and `P` at `x`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn refresh(&self, lists: &mut StepLists<'_, S>) {
        let StepLists { x, u, momentum, stages, columns, .. } = lists;
        if self.scheme.unknowns == Unknowns::Both {
            let unknowns = x.as_chunks().0;
            let known = momentum.iter_mut().zip(&mut **u).zip(self.p.iter().zip(unknowns));
            for ((momentum, u), (&p, &[x_u, x_v])) in known {
                (*u, *momentum) = (x_u, p + x_v);
            }
        } else {
            for ((momentum, u), (&p, &x)) in momentum.iter_mut().zip(&mut **u).zip(self.p.iter().zip(&**x)) {
                (*u, *momentum) = (nothing(), p + x);
            }
            match self.increment {
                Some(known) => u.copy_from_slice(known),
                None => self.velocities(momentum, stages.at_mut(0).1, u, columns),
            }
        }
    }

    /// The correction `x - φ(x)` of the scheme's unknowns, which is `(∂L_d/∂P, -D_1 L_d - p_i)` or the second
    /// component alone; leaves `u`, `P`, the stages and derivatives.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn residual(&self, lists: &mut StepLists<'_, S>) {
        self.refresh(lists);
        self.residual_at(lists);
    }

    /// [`LoopStep::residual`] where `u` and `P` are those at `x`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn residual_at(&self, lists: &mut StepLists<'_, S>) {
        let StepLists { x, correction, u, momentum, by_p, stages, columns, .. } = lists;
        let is_both = self.scheme.unknowns == Unknowns::Both;
        if is_both {
            by_p.fill(nothing());
        }
        let wanted = if is_both { Partials::ALL } else { Partials::BY_COORDINATES };
        for (s, stage) in self.scheme.stages.iter().enumerate() {
            let (q, by_q) = stages.at_mut(s);
            self.place(stage, q, by_q, u);
            self.gradient(stage, [q, momentum], wanted, by_q, by_p, columns);
        }
        for (s, stage) in self.scheme.stages.iter().enumerate() {
            let (weight, (_, by_q)) = (stage.start, stages.at(s));
            match (is_both, s) {
                (true, 0) => {
                    let unknowns = correction.as_chunks_mut().0.iter_mut().zip(x.as_chunks().0);
                    for (([c_u, c_v], &[u, v]), (&by_p, &by_q)) in unknowns.zip(by_p.iter().zip(by_q)) {
                        (*c_u, *c_v) = (u - by_p, v + by_q * weight);
                    }
                }
                (true, _) => {
                    for ([_, c], &by_q) in correction.as_chunks_mut().0.iter_mut().zip(by_q) {
                        *c = *c + by_q * weight;
                    }
                }
                (false, 0) => {
                    for (c, (&x, &by_q)) in correction.iter_mut().zip(x.iter().zip(by_q)) {
                        *c = x + by_q * weight;
                    }
                }
                (false, _) => {
                    for (c, &by_q) in correction.iter_mut().zip(by_q) {
                        *c = *c + by_q * weight;
                    }
                }
            }
        }
    }

    /// `Q = q_i + c u`; clears the derivatives there.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn place(&self, stage: &QuadraturePoint, q: &mut [S], by_q: &mut [S], u: &[S]) {
        for ((point, slope), (&q, &u)) in q.iter_mut().zip(by_q).zip(self.q.iter().zip(u)) {
            *point = q + u * stage.point;
            *slope = nothing();
        }
    }

    /// Adds `Σ ∂F/∂p` at `P` to `u`, where the sum does not depend on `u`: elements that read coordinates and
    /// momenta are then at the node `q_i`, by the choice of unknowns. Their derivatives by coordinates go to
    /// `by_q`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn velocities(&self, momentum: &[S], by_q: &mut [S], u: &mut [S], columns: &mut PairColumns) {
        for stage in self.scheme.stages {
            self.gradient(stage, [self.q, momentum], Partials::BY_MOMENTA, by_q, u, columns);
        }
    }

    /// Adds the derivatives of the roles at a stage.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn gradient(
        &self,
        stage: &QuadraturePoint,
        [q, p]: [&[S]; 2],
        wanted: Partials,
        by_q: &mut [S],
        by_p: &mut [S],
        columns: &mut PairColumns,
    ) {
        let at = self.at(stage, q, p);
        // Paths that are solved side by side stay in the vector instructions of their caller.
        let is_here = const { is_in_lanes::<S>() } && self.scheme.unknowns != Unknowns::None;
        for &weighted in stage.roles {
            if is_here || size_of::<S>() == size_of::<f64>() {
                slopes(self.system, weighted, &at, wanted, by_q, by_p, columns);
            } else {
                gradient_outlined(self.system, weighted, &at, wanted, by_q, by_p, columns);
            }
        }
    }

    /// Adds the second derivatives of the roles at a stage.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn hessian(
        &self,
        stage: &QuadraturePoint,
        q: &[S],
        p: &[S],
        wanted: Partials,
        into: &mut impl FnMut(HessianBlock, [usize; 2], bool, S),
    ) {
        let at = self.at(stage, q, p);
        for &WeightedRole { role, weight } in stage.roles {
            self.system.hessian(role, weight, &at, wanted, into);
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn at<'b, V: ?Sized>(
        &'b self,
        stage: &QuadraturePoint,
        q: &'b V,
        p: &'b V,
    ) -> EvaluationPoint<'b, S, V> {
        let &Self { system, t, h, parameters, dw, .. } = self;
        let later = h * stage.point;
        let scale = match H::KIND.is_conformal {
            true => (Elements::friction_rate(system, parameters) * later).exp(),
            false => Scalar::from_f64(1.0),
        };
        EvaluationPoint { q, p, t: later + t, h, parameters, dw, acting: 0..dw.len(), scale }
    }

    /// `p_{i+1} - p_i` into `by_p`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn finish(&self, lists: &mut StepLists<'_, S>) {
        let StepLists { x, u, momentum, by_p: dp, stages, correction, columns, .. } = lists;
        match self.scheme.unknowns {
            Unknowns::None => {
                let (_, forces) = stages.at(0);
                negate(dp, forces);
            }
            Unknowns::Momenta => dp.copy_from_slice(x),
            Unknowns::Both => second_of_each(dp, x),
        }
        match self.scheme.update {
            MomentumUpdate::Multiple(1.0) => {}
            MomentumUpdate::Multiple(factor) => multiply(dp, factor),
            MomentumUpdate::Slopes => {
                for (s, stage) in self.scheme.stages.iter().enumerate() {
                    if stage.end == 0.0 {
                        continue;
                    }
                    let (q, by_q) = stages.at_mut(s);
                    self.place(stage, q, by_q, u);
                    // Derivatives by momenta go to `correction`, where they are not used.
                    self.gradient(stage, [q, momentum], Partials::BY_COORDINATES, by_q, correction, columns);
                    subtract_multiple(dp, by_q, stage.end);
                }
            }
        }
        if H::KIND.is_conformal {
            damp(dp, self.p, S::of_constant(decay(self.system, self.parameters, self.h)));
        }
    }
}

impl<H: Elements> LoopStep<'_, H, f64> {
    /// Adds the derivatives of the stages with a weight.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn gradient_of<T: Number<f64>, V: ElementInput<f64> + ?Sized, A: Sums<f64>>(
        &self,
        weight_of: impl Fn(&QuadraturePoint) -> f64,
        state: &V,
        wanted: Partials,
        into: &mut A,
    ) {
        let none = &mut [][..];
        for stage in self.scheme.stages {
            if weight_of(stage) == 0.0 {
                continue;
            }
            // Elements of one half of the phase space read nothing of the other.
            let at = self.at(stage, state, state);
            for &WeightedRole { role, weight } in stage.roles {
                if wanted.by_q {
                    self.system.gradient::<f64, T>(role, weight, &at, wanted, into, none);
                } else {
                    self.system.gradient::<f64, T>(role, weight, &at, wanted, none, into);
                }
            }
        }
    }
}

// Loops over numbers alone: closures in a function would be compiled again for every system.

#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn negate<S: Scalar>(dp: &mut [S], forces: &[S]) {
    dp.iter_mut().zip(forces).for_each(|(dp, &force)| *dp = -force);
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn second_of_each<S: Scalar>(dp: &mut [S], pairs: &[S]) {
    dp.iter_mut().zip(pairs.as_chunks().0).for_each(|(dp, &[_, v])| *dp = v);
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn multiply<S: Scalar>(dp: &mut [S], factor: f64) {
    dp.iter_mut().for_each(|dp| *dp = *dp * factor);
}

#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn subtract_multiple<S: Scalar>(dp: &mut [S], forces: &[S], weight: f64) {
    dp.iter_mut().zip(forces).for_each(|(dp, &force)| *dp = *dp - force * weight);
}

/// The part `decay` of the momentum at the end.
#[cfg_attr(not(debug_assertions), inline(always))]
fn damp<S: Scalar>(dp: &mut [S], p: &[S], decay: S) {
    dp.iter_mut().zip(p).for_each(|(dp, &p)| *dp = *dp + (p + *dp) * decay);
}

/// [`slopes`] as a separate function: inlining loses the information that its lists do not overlap, which
/// numbers of several parts need for speed.
#[inline(never)]
fn gradient_outlined<H: Elements, S: Scalar>(
    system: &H,
    weighted: WeightedRole,
    at: &EvaluationPoint<'_, S>,
    wanted: Partials,
    by_q: &mut [S],
    by_p: &mut [S],
    columns: &mut PairColumns,
) {
    slopes(system, weighted, at, wanted, by_q, by_p, columns);
}

impl<S: Scalar> StepLists<'_, S> {
    /// Adds the increments of a step, `u` and `by_p`, to the state. All sums are computed before any is
    /// stored.
    ///
    /// # Errors
    /// [`StepFailure::NonFinite`] if a sum is not finite.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn store<C: StateSum<S>>(
        &mut self,
        q: &mut [S],
        p: &mut [S],
        carry: &mut C,
    ) -> Result<(), StepFailure> {
        let StepLists { u, by_p: dp, stages, .. } = self;
        let degrees = u.len();
        let (q, p) = (&mut q[..degrees], &mut p[..degrees]);
        // The rounding errors of the sums overwrite the derivatives and coordinates of a stage.
        let (lost_q, lost_p) = stages.at_mut(0);
        let is_finite = if C::CARRIES {
            for (i, (u, (&q, lost))) in u.iter_mut().zip(q.iter().zip(&mut *lost_q)).enumerate() {
                (*u, *lost) = C::add(q, *u, carry.of_coordinate(i));
            }
            for (i, (dp, (&p, lost))) in dp.iter_mut().zip(p.iter().zip(&mut *lost_p)).enumerate() {
                (*dp, *lost) = C::add(p, *dp, carry.of_momentum(i));
            }
            are_finite(u) && are_finite(dp)
        } else {
            add(u, q) && add(dp, p)
        };
        if !is_finite {
            return Err(StepFailure::NonFinite);
        }
        q.copy_from_slice(u);
        p.copy_from_slice(dp);
        if C::CARRIES {
            carry.keep(lost_q, lost_p);
        }
        Ok(())
    }
}
