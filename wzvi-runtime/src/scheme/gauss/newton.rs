//! Newton's method on all stages, for steps on which it costs less than sweeps ([`choice`](super::choice)).
//!
//! `Y - φ(Y) = 0` has the Jacobian `1 - A ⊗ J F''` with the second derivatives of `F` at every stage, from
//! its derivatives by dual numbers. It is factored densely, as sweeps fail for stiff forces of few degrees of
//! freedom. The iteration is that of all hard steps ([`damped`]).

use super::Field;
use super::choice::{is_factored_once, newton_in_sweeps};
use super::equations::StepEquations;
use super::memory::{
    GaussHistoryOf, KnownDerivatives, RoundedScratchOf, StageLists, SweepScratchOf as Scratch,
};
use super::stages::Stages;
use super::sweep::StepOutcome;
use crate::algebra::scalar::{ComputesWith, Constant, Dual, Mask, Parameters, Scalar};
use crate::algebra::solve::{Banded, NewtonScratch, Problem, UNSEEN_IN_STAGES, damped};
use crate::error::StepFailure;
use crate::scheme::elements::PairColumns;

/// The matrix and its right-hand side, allocated on first use.
#[derive(Debug, Default)]
pub(super) struct Newton<S> {
    jacobian: Jacobian<S>,
    room: NewtonScratch<Vec<S>>,
    start: Vec<S>,
    /// The residual from which the derivatives of the stages follow.
    residual: Vec<S>,
}

/// `1 - A ⊗ J F''` and its ingredients.
#[derive(Debug, Default)]
struct Jacobian<S> {
    /// The stages at which it is evaluated.
    point: Vec<S>,
    /// Without the derivatives that the unknowns carry: corrections by it make those converge, too.
    matrix: Option<Banded<f64>>,
    /// Scratch for the solution of the linear equations.
    solved: Vec<S>,
    /// Second derivatives of `b_j F` at one stage, by rows: `(q, p)` by `(q, p)`.
    hessian: Vec<f64>,
    /// `h M⁻¹` by rows, in Nyström form.
    inverse_mass: Vec<f64>,
    lists: [Vec<Dual<1>>; 4],
    dw: Vec<Dual<1>>,
    columns: PairColumns,
    /// Marks of the equations that are solved to rounding.
    are_settled: Vec<bool>,
}

impl<S> Newton<S> {
    /// Exchanges the factors with those of another memory.
    pub(super) fn hand_factors(&mut self, to: &mut Self) {
        std::mem::swap(&mut self.jacobian.matrix, &mut to.jacobian.matrix);
    }
}

/// The equations of all stages. Unknown number `(stage, kind, d)` stands at [`StageEquations::place`].
struct StageEquations<'a, 's, F: Field, K: Constant, S: Scalar, const N: usize> {
    step: &'a StepEquations<'s, F, K, S, N>,
    lists: &'a mut StageLists<S, F::Shape, N>,
    scratch: &'a mut Scratch<F, S, N>,
    exact: &'a mut RoundedScratchOf<F, N>,
    jacobian: &'a mut Jacobian<S>,
}

impl<F: Field, K: Constant, S: ComputesWith<K>, const N: usize> StepEquations<'_, F, K, S, N> {
    /// The most unknowns for which the matrix is factored: 50 MB of `f64` at this size.
    pub(super) const MOST_UNKNOWNS: usize = 1500;

    /// The number of unknowns.
    pub(super) fn unknowns(&self) -> usize {
        N * StageEquations::<F, K, S, N>::KINDS * self.start[0].len()
    }

    /// The cost of a step of Newton's method, in sweeps; infinite where there are too many unknowns for it.
    #[cold]
    pub(super) fn newton_in_sweeps(&self) -> f64 {
        if self.unknowns() > Self::MOST_UNKNOWNS {
            return f64::INFINITY;
        }
        newton_in_sweeps(N, StageEquations::<F, K, S, N>::KINDS, self.start[0].len())
    }

    /// Whether the derivatives that numbers carry follow from one factorisation, rather than from sweeps in
    /// these numbers.
    pub(super) fn factors_once(&self, left: &GaussHistoryOf<F, S, N>) -> bool {
        if self.unknowns() > Self::MOST_UNKNOWNS {
            return false;
        }
        let is_stiff = left.scalar_path.as_ref().is_some_and(|own| own.prefers_newton());
        let size = [N, StageEquations::<F, K, S, N>::KINDS, self.start[0].len()];
        left.known == KnownDerivatives::Factors
            || is_stiff
            || is_factored_once(size, left.derivatives.max(S::DERIVATIVES), S::DERIVATIVES)
    }

    /// Newton's method from the current stages, with those of `left` as the waits of the next step.
    ///
    /// # Errors
    /// The errors of [`damped`]; unless `CAREFUL`, also if another solution may be nearer to the start.
    #[cold]
    #[inline(never)]
    pub(super) fn newton<const CAREFUL: bool>(
        &self,
        lists: &mut StageLists<S, F::Shape, N>,
        left: &mut GaussHistoryOf<F, S, N>,
    ) -> Result<StepOutcome<S>, StepFailure> {
        let GaussHistoryOf::<F, S, N> {
            newton: Newton { jacobian, room, start, .. }, scratch, exact, ..
        } = left;
        let mut equations = StageEquations { step: self, lists, scratch, exact, jacobian };
        let unknowns = equations.unknowns();
        if unknowns > Self::MOST_UNKNOWNS {
            return Err(StepFailure::TooManyUnknowns { unknowns, most: Self::MOST_UNKNOWNS });
        }
        start.resize(unknowns, S::from_f64(0.0));
        equations.read(start);
        let effort = damped(&mut equations, room, start)?;
        if (effort.is_doubtful() || effort.is_reversed) && !CAREFUL {
            let iterations = effort.iterations;
            return Err(StepFailure::NotConverged { iterations, correction: f64::INFINITY });
        }
        equations.write(room.solution());
        self.field(lists, scratch, S::Mask::from_bool(false));
        Ok(StepOutcome { effort, waits: left.waits.after_newton() })
    }

    /// The derivatives of the stages, whose values follow from the derivatives of the lists:
    /// `Y' = (1 - ∂φ/∂Y)⁻¹ φ'`, with `φ'` the derivatives of `φ` at stages without any. `are_factored`: the
    /// matrix has been factored there.
    ///
    /// # Errors
    /// [`StepFailure::NonFinite`] where second derivatives are not finite, [`StepFailure::Singular`].
    pub(super) fn differentiate_stages(
        &self,
        lists: &mut StageLists<S, F::Shape, N>,
        left: &mut GaussHistoryOf<F, S, N>,
        are_factored: bool,
    ) -> Result<(), StepFailure> {
        let GaussHistoryOf::<F, S, N> {
            newton: Newton { jacobian, start, residual, .. },
            scratch,
            exact,
            ..
        } = left;
        let mut equations = StageEquations { step: self, lists, scratch, exact, jacobian };
        let unknowns = equations.unknowns();
        for list in [&mut *start, residual] {
            list.resize(unknowns, S::from_f64(0.0));
        }
        self.follow(equations.lists, equations.scratch, None);
        equations.read(residual);
        for (x, residual) in start.iter_mut().zip(&*residual) {
            *x = S::from_f64(residual.lane(0));
        }
        // The derivatives have derivatives by constants of the step.
        if size_of::<K>() != size_of::<f64>() || !self.dw.is_empty() {
            equations.write(start);
            self.field(equations.lists, equations.scratch, S::Mask::from_bool(false));
            self.follow(equations.lists, equations.scratch, None);
            equations.read(residual);
        }
        residual.iter_mut().for_each(|next| *next = next.infinitesimal());
        if !are_factored {
            equations.jacobian.point.clone_from(start);
            if equations.factor()? > 0 {
                return Err(StepFailure::NonFinite);
            }
        }
        equations.correct(residual)?;
        start.iter_mut().zip(&*residual).for_each(|(x, change)| *x = *x + *change);
        equations.write(start);
        self.field(lists, scratch, S::Mask::from_bool(false));
        Ok(())
    }

    /// The derivatives of `F` and their derivatives along one of its arguments, with the weight of stage
    /// number `stage`, or without.
    fn vary<T: Scalar>(
        &self,
        jacobian: &mut Jacobian<T>,
        stage: Option<usize>,
        arguments: &dyn Fn(usize, usize) -> f64,
        along: usize,
    ) {
        let degrees = self.start[0].len();
        let Jacobian { lists: [q, p, by_q, by_p], dw, columns, .. } = jacobian;
        for list in [&mut *q, p, by_q, by_p] {
            list.resize(degrees, Dual::from_f64(0.0));
        }
        dw.clear();
        for stages in self.dw {
            dw.push(Dual::from_f64(stages.get(stage.unwrap_or(0)).lane(0)));
        }
        for d in 0..degrees {
            q[d] = Dual { value: arguments(0, d), derivative: [f64::from(along == d)] };
            p[d] = Dual { value: arguments(1, d), derivative: [f64::from(along == degrees + d)] };
            if F::FACTS.kind.is_conformal {
                let inverse = stage.map_or(1.0, |stage| self.friction.inverse[stage].lane(0));
                p[d] = p[d] * inverse;
            }
        }
        let table = self.common.table();
        let (c, b) = (table.c[stage.unwrap_or(0)], stage.map_or(1.0, |stage| table.b[stage]));
        let (t, h) = (self.t.lane(0), self.h.lane(0));
        let (t, h) = (Dual::from_f64(h * c + t), Dual::from_f64(h * b));
        let parameters = &F::Parameters::lane(self.parameters, 0);
        let (at, into) = (([t, h], [&q[..], p], &dw[..]), [&mut by_q[..], by_p]);
        self.system.step_gradient::<f64, Dual<1>, true, true>(parameters, at, into, columns);
        if F::FACTS.kind.is_conformal {
            let scale = stage.map_or(1.0, |stage| self.friction.scale[stage].lane(0));
            by_q.iter_mut().for_each(|slope| *slope = *slope * scale);
        }
    }
}

impl<F: Field, K: Constant, S: ComputesWith<K>, const N: usize> StageEquations<'_, '_, F, K, S, N> {
    /// Unknowns per degree of freedom and stage: in Nyström form the coordinates alone.
    const KINDS: usize = if F::IS_NYSTROM { 1 } else { 2 };

    fn degrees(&self) -> usize {
        self.step.start[0].len()
    }

    fn unknowns(&self) -> usize {
        self.step.unknowns()
    }

    fn place(degrees: usize, stage: usize, kind: usize, d: usize) -> usize {
        (stage * Self::KINDS + kind) * degrees + d
    }

    /// The stages as unknowns.
    fn read(&self, x: &mut [S]) {
        let degrees = self.degrees();
        for (kind, list) in self.lists.at.iter().take(Self::KINDS).enumerate() {
            for (d, stages) in list.as_ref().iter().enumerate() {
                (0..N).for_each(|i| x[Self::place(degrees, i, kind, d)] = stages.get(i));
            }
        }
    }

    /// The unknowns as stages.
    fn write(&mut self, x: &[S]) {
        let degrees = self.degrees();
        for (kind, list) in self.lists.at.iter_mut().take(Self::KINDS).enumerate() {
            for (d, stages) in list.as_mut().iter_mut().enumerate() {
                (0..N).for_each(|i| stages.set(i, x[Self::place(degrees, i, kind, d)]));
            }
        }
    }

    /// `h M⁻¹`: the derivatives of a quadratic form at the unit momenta.
    fn invert_mass(&mut self) {
        let degrees = self.degrees();
        self.jacobian.inverse_mass.resize(degrees * degrees, 0.0);
        for column in 0..degrees {
            let start = |kind: usize, d: usize| if kind == 0 { self.step.start[0][d].lane(0) } else { 0.0 };
            self.step.vary(self.jacobian, None, &start, degrees + column);
            for row in 0..degrees {
                self.jacobian.inverse_mass[row * degrees + column] =
                    self.jacobian.lists[3][row].derivative[0];
            }
        }
    }

    /// Adds the entries from the derivatives of degree of freedom `a` at stage `j`, by the unknowns of `b`
    /// there.
    fn add_entries(&self, matrix: &mut Banded<f64>, j: usize, [a, b]: [usize; 2]) {
        let (degrees, table) = (self.degrees(), self.step.common.table());
        let Jacobian { hessian, inverse_mass, .. } = &*self.jacobian;
        let second = |row: usize, column: usize| hessian[row * 2 * degrees + column];
        let force: f64 = match F::IS_NYSTROM {
            true => (0..degrees).map(|k| inverse_mass[a * degrees + k] * second(k, b)).sum(),
            false => 0.0,
        };
        for i in 0..N {
            let mut add = |row: usize, column: usize, value: f64| {
                let (row, column) = (Self::place(degrees, i, row, a), Self::place(degrees, j, column, b));
                matrix.add(row, column, value);
            };
            if F::IS_NYSTROM {
                add(0, 0, table.eta[j][i] * force);
            } else {
                let weight = table.mu[j][i];
                for column in 0..2 {
                    add(0, column, -weight * second(degrees + a, column * degrees + b));
                    add(1, column, weight * second(a, column * degrees + b));
                }
            }
        }
    }

    /// The second derivatives of `b_j F` at stage `j`.
    fn second_derivatives(&mut self, stage: usize) {
        let degrees = self.degrees();
        self.jacobian.hessian.resize(4 * degrees * degrees, 0.0);
        for column in 0..Self::KINDS * degrees {
            let point = std::mem::take(&mut self.jacobian.point);
            let at = |kind: usize, d: usize| match kind < Self::KINDS {
                true => point[Self::place(degrees, stage, kind, d)].lane(0),
                false => 0.0,
            };
            self.step.vary(self.jacobian, Some(stage), &at, column);
            self.jacobian.point = point;
            let Jacobian { hessian, lists: [_, _, by_q, by_p], .. } = &mut *self.jacobian;
            for (row, slope) in by_q.iter().chain(&*by_p).enumerate() {
                hessian[row * 2 * degrees + column] = slope.derivative[0];
            }
        }
    }
}

impl<F: Field, K: Constant, S: ComputesWith<K>, const N: usize> Problem
    for StageEquations<'_, '_, F, K, S, N>
{
    type Number = S;
    type Vector = Vec<S>;
    // The remaining error of the stages is not random as rounding is.
    const UNSEEN: f64 = UNSEEN_IN_STAGES;

    fn residual(&mut self, x: &Vec<S>, into: &mut Vec<S>) {
        self.jacobian.point.clone_from(x);
        self.write(x);
        self.step.field(self.lists, self.scratch, S::Mask::from_bool(false));
        self.step.follow(self.lists, self.scratch, None);
        self.read(into);
        into.iter_mut().zip(x).for_each(|(next, x)| *next = *x - *next);
    }

    fn factor(&mut self) -> Result<usize, StepFailure> {
        let (degrees, unknowns) = (self.degrees(), self.unknowns());
        let mut matrix = match self.jacobian.matrix.take() {
            Some(matrix) => matrix,
            None => Banded::new(unknowns, unknowns.saturating_sub(1), Vec::new(), usize::MAX)
                .ok_or(StepFailure::NonFinite)?
                .parted(true),
        };
        matrix.reset();
        if F::IS_NYSTROM {
            self.invert_mass();
        }
        let mut left_out = 0;
        for j in 0..N {
            self.second_derivatives(j);
            left_out += leave_out(&mut self.jacobian.hessian, 2 * degrees);
            for a in 0..degrees {
                for b in 0..degrees {
                    self.add_entries(&mut matrix, j, [a, b]);
                }
            }
        }
        let factored = matrix.factor();
        self.jacobian.matrix = Some(matrix);
        factored.map(|()| left_out)
    }

    fn correct(&mut self, r: &mut Vec<S>) -> Result<(), StepFailure> {
        let Jacobian { matrix, solved, .. } = &mut *self.jacobian;
        matrix.as_ref().ok_or(StepFailure::NonFinite)?.solve_in_room(r, solved);
        Ok(())
    }

    fn are_settled(&mut self, x: &Vec<S>) -> impl AsRef<[bool]> {
        self.write(x);
        let (degrees, unknowns) = (self.degrees(), self.unknowns());
        let are_settled = &mut self.jacobian.are_settled;
        are_settled.clear();
        are_settled.resize(unknowns, true);
        self.step.residuals(0, self.lists, self.exact, &mut |kind, d, i, residual| {
            are_settled[Self::place(degrees, i, kind, d)] = residual.is_below(1.0);
        });
        &*are_settled
    }

    fn is_reversed(&self) -> bool {
        self.jacobian.matrix.as_ref().is_some_and(Banded::is_reversed)
    }
}

/// Removes the rows and columns with entries that are not finite from a matrix of this size; returns the
/// number of these entries.
fn leave_out(matrix: &mut [f64], size: usize) -> usize {
    let left_out = matrix.iter().filter(|entry| !entry.is_finite()).count();
    if left_out > 0 {
        let is_finite = |row: &[f64]| row.iter().all(|entry| entry.is_finite());
        let finite: Vec<bool> = matrix.chunks_exact(size).map(is_finite).collect();
        for (i, row) in matrix.chunks_exact_mut(size).enumerate() {
            row.iter_mut()
                .zip(&finite)
                .filter(|(_, other)| !(finite[i] && **other))
                .for_each(|(entry, _)| *entry = 0.0);
        }
    }
    left_out
}
