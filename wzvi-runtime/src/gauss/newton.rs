//! Newton's method on all stages, for steps on which sweeps do not contract.
//!
//! `Y - φ(Y) = 0` has the Jacobian `1 - A ⊗ J F''` with the second derivatives of `F` at every stage, which are those of its slopes
//! on dual numbers. It is factored densely: sweeps that do not contract are for stiff forces of few degrees of freedom.

use super::Field;
use super::advance::Step;
use super::kept::{Lists, Memory};
use super::stages::Stages;
use super::sweep::Solved;
use crate::carry::Carry;
use crate::error::StepFailure;
use crate::scalar::{Dual, Scalar};
use crate::solve::{Banded, Effort};

/// Unknowns of a matrix that is factored: 50 MB of `f64`.
const MOST_UNKNOWNS: usize = 1500;
/// Iterations that are tried.
const MOST_ITERATIONS: u32 = 40;
/// Old factors are kept while corrections shrink to this fraction.
const CONTRACTS: f64 = 0.2;
/// Corrections below this fraction of an unknown change nothing.
const ROUNDING: f64 = f64::EPSILON;

/// The matrix and its right-hand side, allocated where they are needed first.
#[derive(Debug)]
pub(super) struct Newton<S> {
    matrix: Option<Banded<S>>,
    right: Vec<S>,
    /// Second derivatives of `F` at one stage, by rows: `(q, p)` by `(q, p)`.
    hessian: Vec<f64>,
    /// `h M⁻¹` by rows, in Nyström form.
    inverse_mass: Vec<f64>,
    lists: [Vec<Dual<1>>; 4],
    dw: Vec<Dual<1>>,
}

impl<S> Default for Newton<S> {
    fn default() -> Self {
        let lists = std::array::from_fn(|_| Vec::new());
        Self {
            matrix: None,
            right: Vec::new(),
            hessian: Vec::new(),
            inverse_mass: Vec::new(),
            lists,
            dw: Vec::new(),
        }
    }
}

impl<F: Field, S: Scalar, const N: usize> Step<'_, F, S, N> {
    /// Unknowns per degree of freedom and stage: in Nyström form the coordinates alone.
    const KINDS: usize = if F::IS_NYSTROM { 1 } else { 2 };

    /// Newton's method from the stages that are there.
    pub(super) fn newton<C: Carry<S>, const CAREFUL: bool>(
        &self,
        lists: &mut Lists<S, F::Shape, N>,
        memory: &mut Memory<S, F::Shape, N>,
        carry: &C,
    ) -> Result<Solved, StepFailure> {
        let unknowns = N * Self::KINDS * self.q.len();
        let mut newton = std::mem::take(&mut memory.newton);
        let solved = if unknowns <= MOST_UNKNOWNS {
            self.iterate::<C, CAREFUL>(&mut newton, lists, memory, carry)
        } else {
            Err(StepFailure::NotConverged { iterations: 0, correction: f64::INFINITY })
        };
        memory.newton = newton;
        solved
    }

    fn iterate<C: Carry<S>, const CAREFUL: bool>(
        &self,
        newton: &mut Newton<S>,
        lists: &mut Lists<S, F::Shape, N>,
        memory: &mut Memory<S, F::Shape, N>,
        carry: &C,
    ) -> Result<Solved, StepFailure> {
        let (mut last, mut is_doubtful, mut is_stale) = (f64::INFINITY, false, true);
        let mut more = 0;
        for iterations in 1..=MOST_ITERATIONS {
            if is_stale {
                self.factor(newton, lists)?;
            }
            let change = self.correct(newton, lists, memory, carry)?;
            if !change.is_finite() {
                return Err(StepFailure::NonFinite);
            }
            // Nothing is known of the contraction before the second one.
            let ratio = if last < f64::INFINITY { change / last } else { 1.0 };
            let is_small = change <= ROUNDING || (ratio < 0.5 && change * ratio <= 0.5 * ROUNDING);
            if more > 0 || is_small || (ratio > 0.5 && iterations > 2 && self.is_rounding(lists, carry)) {
                // Derivatives that a number carries take the factors at the solution, twice.
                more += 1;
                is_stale = more == 1;
                if size_of::<S>() == size_of::<f64>() || more == 4 {
                    // In doubt only a solution that is followed along the step is taken.
                    let effort = Effort {
                        doubtful: is_doubtful,
                        is_reversed: is_doubtful,
                        ..Effort::fast(iterations)
                    };
                    return Ok(Solved { effort, prefers_newton: true });
                }
                continue;
            }
            let is_slow = ratio > 0.5 && last < f64::INFINITY;
            if is_slow && is_stale {
                if !CAREFUL {
                    return Err(StepFailure::NotConverged { iterations, correction: change });
                }
                is_doubtful = true;
            }
            is_stale = last < f64::INFINITY && ratio > CONTRACTS;
            last = change;
        }
        Err(StepFailure::NotConverged { iterations: MOST_ITERATIONS, correction: last })
    }

    /// Where unknown number `(stage, kind, d)` stands.
    fn place(&self, stage: usize, kind: usize, d: usize) -> usize {
        (stage * Self::KINDS + kind) * self.q.len() + d
    }

    /// The factors of `1 - φ'` at the stages that are there.
    fn factor(&self, newton: &mut Newton<S>, lists: &Lists<S, F::Shape, N>) -> Result<(), StepFailure> {
        let (degrees, kinds) = (self.q.len(), Self::KINDS);
        let unknowns = N * kinds * degrees;
        let mut matrix = match newton.matrix.take() {
            Some(matrix) => matrix,
            None => Banded::new(unknowns, unknowns.saturating_sub(1), Vec::new(), usize::MAX)
                .ok_or(StepFailure::NonFinite)?,
        };
        matrix.reset();
        if F::IS_NYSTROM {
            self.invert_mass(newton);
        }
        for j in 0..N {
            self.second_derivatives(newton, lists, j);
            let second = |row: usize, column: usize| newton.hessian[row * 2 * degrees + column];
            for i in 0..N {
                for a in 0..degrees {
                    for b in 0..degrees {
                        let mut add = |row: usize, column: usize, value: f64| {
                            matrix.add(self.place(i, row, a), self.place(j, column, b), S::from_f64(value));
                        };
                        if F::IS_NYSTROM {
                            let terms =
                                (0..degrees).map(|k| newton.inverse_mass[a * degrees + k] * second(k, b));
                            let force: f64 = terms.sum();
                            add(0, 0, self.table.eta[j][i] * self.table.b[j] * force);
                        } else {
                            let weight = self.table.mu[j][i] * self.table.b[j];
                            for column in 0..2 {
                                add(0, column, -weight * second(degrees + a, column * degrees + b));
                                add(1, column, weight * second(a, column * degrees + b));
                            }
                        }
                    }
                }
            }
        }
        let factored = matrix.factor();
        newton.matrix = Some(matrix);
        factored
    }

    /// `h M⁻¹`: the slopes of a quadratic form at the unit momenta.
    fn invert_mass(&self, newton: &mut Newton<S>) {
        let degrees = self.q.len();
        newton.inverse_mass.resize(degrees * degrees, 0.0);
        for column in 0..degrees {
            self.vary(newton, self.at.t, &|d| self.q[d].lane(0), &|_| 0.0, degrees + column);
            for row in 0..degrees {
                newton.inverse_mass[row * degrees + column] = newton.lists[3][row].derivative[0];
            }
        }
    }

    /// The second derivatives of `F` at one stage.
    fn second_derivatives(&self, newton: &mut Newton<S>, lists: &Lists<S, F::Shape, N>, stage: usize) {
        let degrees = self.q.len();
        newton.hessian.resize(4 * degrees * degrees, 0.0);
        let [q, p] = &lists.at;
        let coordinate = |d: usize| q.as_ref()[d].get(stage).lane(0);
        let momentum = |d: usize| p.as_ref()[d].get(stage).lane(0);
        let t = self.at.t + self.at.c[stage] * self.at.h;
        for column in 0..Self::KINDS * degrees {
            self.vary(newton, t, &coordinate, &momentum, column);
            let Newton { hessian, lists: [_, _, by_q, by_p], .. } = &mut *newton;
            for (row, slope) in by_q.iter().chain(&*by_p).enumerate() {
                hessian[row * 2 * degrees + column] = slope.derivative[0];
            }
        }
    }

    /// The slopes of `F` and their derivatives along one of its arguments.
    fn vary(
        &self,
        newton: &mut Newton<S>,
        t: f64,
        coordinate: &dyn Fn(usize) -> f64,
        momentum: &dyn Fn(usize) -> f64,
        along: usize,
    ) {
        let degrees = self.q.len();
        let Newton { lists: [q, p, by_q, by_p], dw, .. } = newton;
        for list in [&mut *q, p, by_q, by_p] {
            list.resize(degrees, Dual::from_f64(0.0));
        }
        dw.clear();
        dw.extend(self.at.dw.iter().map(|dw| Dual::from_f64(dw.lane(0))));
        for d in 0..degrees {
            q[d] = Dual { value: coordinate(d), derivative: [f64::from(along == d)] };
            p[d] = Dual { value: momentum(d), derivative: [f64::from(along == degrees + d)] };
        }
        self.system.slopes::<Dual<1>, true, true>(Dual::from_f64(t), self.at.h, q, p, dw, by_q, by_p);
    }

    /// One correction of the stages, and its size as that of [`Step::sweep`].
    fn correct<C: Carry<S>>(
        &self,
        newton: &mut Newton<S>,
        lists: &mut Lists<S, F::Shape, N>,
        memory: &mut Memory<S, F::Shape, N>,
        carry: &C,
    ) -> Result<f64, StepFailure> {
        let (degrees, kinds) = (self.q.len(), Self::KINDS);
        let right = &mut newton.right;
        right.resize(N * kinds * degrees, S::from_f64(0.0));
        let read = |lists: &Lists<S, F::Shape, N>, right: &mut Vec<S>, sign: f64| {
            for kind in 0..kinds {
                for (d, stage) in lists.at[kind].as_ref().iter().enumerate() {
                    for i in 0..N {
                        let at = self.place(i, kind, d);
                        right[at] = stage.get(i) - right[at] * sign;
                    }
                }
            }
        };
        // `Y`, and after a sweep `φ(Y) - Y`.
        read(lists, right, 0.0);
        self.sweep(lists, memory, carry);
        read(lists, right, 1.0);
        let Some(matrix) = &mut newton.matrix else { return Err(StepFailure::NonFinite) };
        // What `φ(Y)` is before it is corrected: `Y` itself is `φ(Y)` minus the residual.
        for kind in 0..kinds {
            for (d, stage) in lists.at[kind].as_mut().iter_mut().enumerate() {
                for i in 0..N {
                    stage.set(i, stage.get(i) - right[self.place(i, kind, d)]);
                }
            }
        }
        matrix.solve(right);
        let mut change = 0.0_f64;
        for kind in 0..kinds {
            let start = if kind == 0 { self.q } else { self.p };
            for (d, stage) in lists.at[kind].as_mut().iter_mut().enumerate() {
                let (mut most, mut size) = (0.0_f64, start[d].magnitude());
                for i in 0..N {
                    let correction = right[self.place(i, kind, d)];
                    let next = stage.get(i) + correction;
                    stage.set(i, next);
                    let moved = correction.magnitude();
                    most = if moved > most || moved.is_nan() { moved } else { most };
                    size = size.max(next.magnitude());
                }
                let relative = if most == 0.0 { 0.0 } else { most / size };
                change = if relative > change || relative.is_nan() { relative } else { change };
            }
        }
        Ok(change)
    }
}
