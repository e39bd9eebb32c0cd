//! The discrete Euler-Lagrange equations of one step, `D_1 L_d`, `D_2 L_d` and `∂L_d/∂P` at trial values of the unknowns.

use super::memory::{Staged, Work};
use super::{Curvature, Elements, MomentumUpdate, Point, Scheme, Slopes, Stage, Unknowns};
use crate::scalar::Scalar;

/// The givens of one step.
pub(super) struct Step<'a, H, S> {
    pub(super) system: &'a H,
    pub(super) scheme: &'a Scheme,
    pub(super) t: f64,
    pub(super) h: f64,
    pub(super) q: &'a [S],
    pub(super) p: &'a [S],
    pub(super) dw: &'a [S],
    /// `u`, if both nodes are known and `P` alone is not.
    pub(super) increment: Option<&'a [S]>,
}

impl<H: Elements, S: Scalar> Step<'_, H, S> {
    /// `u` and `P` at the solution.
    pub(super) fn refresh(&self, work: &mut Work<S>) {
        let Work { x, u, momentum, by_p, .. } = work;
        if self.scheme.unknowns == Unknowns::Both {
            let unknowns = x.as_chunks().0;
            let known = momentum.iter_mut().zip(u).zip(self.p.iter().zip(unknowns));
            for ((momentum, u), (&p, &[x_u, x_v])) in known {
                (*u, *momentum) = (x_u, p + x_v);
            }
        } else {
            for ((momentum, u), (&p, &x)) in momentum.iter_mut().zip(&mut *u).zip(self.p.iter().zip(&*x)) {
                (*u, *momentum) = (S::from_f64(0.0), p + x);
            }
            match self.increment {
                Some(known) => u.copy_from_slice(known),
                None => self.velocities(momentum, by_p, u),
            }
        }
    }

    /// `φ` at `x`, for the scheme's unknowns, as the correction `x - φ(x)`, which is `(∂L_d/∂P, -D_1 L_d - p_i)` or the
    /// second of them; leaves `u`, `P`, the stages and slopes.
    pub(super) fn residual(&self, work: &mut Work<S>) {
        self.refresh(work);
        let Work { x, correction, u, momentum, stages, by_p, .. } = work;
        let is_both = self.scheme.unknowns == Unknowns::Both;
        if is_both {
            by_p.fill(S::from_f64(0.0));
        }
        let wanted = if is_both { Slopes::ALL } else { Slopes::BY_COORDINATES };
        for (stage, Staged { q, by_q }) in self.scheme.stages.iter().zip(&mut *stages) {
            self.place(stage, q, by_q, u);
            self.slopes(stage, q, momentum, wanted, by_q, by_p);
        }
        for (s, (stage, Staged { by_q, .. })) in self.scheme.stages.iter().zip(&*stages).enumerate() {
            let weight = stage.start;
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

    /// `Q = q_i + c u`, and room for the slopes there.
    fn place(&self, stage: &Stage, q: &mut [S], by_q: &mut [S], u: &[S]) {
        for ((point, slope), (&q, &u)) in q.iter_mut().zip(by_q).zip(self.q.iter().zip(u)) {
            *point = q + u * stage.point;
            *slope = S::from_f64(0.0);
        }
    }

    /// Adds to `u` what follows from `P`, where that does not read `u` itself: elements that read coordinates and momenta
    /// are at the node `q_i` then, by the choice of unknowns. What else these add goes to `by_q`.
    fn velocities(&self, momentum: &[S], by_q: &mut [S], u: &mut [S]) {
        for stage in self.scheme.stages {
            self.slopes(stage, self.q, momentum, Slopes::BY_MOMENTA, by_q, u);
        }
    }

    /// Adds the slopes of the parts at a stage.
    fn slopes(&self, stage: &Stage, q: &[S], p: &[S], wanted: Slopes, by_q: &mut [S], by_p: &mut [S]) {
        let at = self.at(stage, q, p);
        for &(part, weight) in stage.parts {
            self.system.slopes(part, weight, &at, wanted, by_q, by_p);
        }
    }

    /// Adds the second derivatives of the parts at a stage.
    pub(super) fn curvature(
        &self,
        stage: &Stage,
        q: &[S],
        p: &[S],
        wanted: Slopes,
        into: &mut impl Curvature<S>,
    ) {
        let at = self.at(stage, q, p);
        for &(part, weight) in stage.parts {
            self.system.curvature(part, weight, &at, wanted, into);
        }
    }

    fn at<'b>(&'b self, stage: &Stage, q: &'b [S], p: &'b [S]) -> Point<'b, S> {
        let (t, acting) = (self.t + stage.point * self.h, 0..self.dw.len());
        Point { q, p, t, h: self.h, dw: self.dw, acting }
    }

    /// `P` from the slopes that `D_1 L_d` has, all of them at `q_i`, then `u`.
    pub(super) fn explicit(&self, work: &mut Work<S>) {
        let Work { u, momentum, stages, by_p, .. } = work;
        let Some(Staged { by_q, .. }) = stages.first_mut() else { return };
        let zero = S::from_f64(0.0);
        by_q.fill(zero);
        u.fill(zero);
        for stage in self.scheme.stages.iter().filter(|stage| stage.start != 0.0) {
            self.slopes(stage, self.q, self.p, Slopes::BY_COORDINATES, by_q, by_p);
        }
        for (momentum, (&p, &force)) in momentum.iter_mut().zip(self.p.iter().zip(&*by_q)) {
            *momentum = p - force;
        }
        self.velocities(momentum, by_p, u);
    }

    /// `p_{i+1} - p_i` into `by_p`.
    pub(super) fn finish(&self, work: &mut Work<S>) {
        let Work { x, u, momentum, stages, by_p: dp, correction, .. } = work;
        match self.scheme.unknowns {
            Unknowns::None => {
                let forces = stages.first().map_or(&[][..], |stage| &stage.by_q);
                dp.iter_mut().zip(forces).for_each(|(dp, &force)| *dp = -force);
            }
            Unknowns::Momenta => dp.copy_from_slice(x),
            Unknowns::Both => dp.iter_mut().zip(x.as_chunks().0).for_each(|(dp, &[_, v])| *dp = v),
        }
        match self.scheme.update {
            MomentumUpdate::Multiple(1.0) => {}
            MomentumUpdate::Multiple(factor) => dp.iter_mut().for_each(|dp| *dp = *dp * factor),
            MomentumUpdate::Slopes => {
                let ends = self.scheme.stages.iter().zip(stages).filter(|(stage, _)| stage.end != 0.0);
                for (stage, Staged { q, by_q }) in ends {
                    self.place(stage, q, by_q, u);
                    // Slopes with respect to momenta go where nobody looks.
                    self.slopes(stage, q, momentum, Slopes::BY_COORDINATES, by_q, correction);
                    dp.iter_mut().zip(&*by_q).for_each(|(dp, &force)| *dp = *dp - force * stage.end);
                }
            }
        }
    }
}
