//! The Jacobian `I - φ'` of a step, entry by entry: for factors, for products with vectors, or as a sparsity
//! pattern.

use super::factor_cache::EXCESS_PRODUCTS;
use super::linear::{KrylovSolver, LinearSolver};
use super::low_rank::RankOneTerms;
use super::memory::{StepLists, StepScratch};
use super::passes::largest;
use super::step::LoopStep;
use super::{Elements, HessianBlock, Partials, Quadrature, Unknowns};
use crate::algebra::scalar::Scalar;
use crate::algebra::solve::{Banded, Krylov, Operator, Sparse, power_of_two};
use crate::error::StepFailure;

/// `y += A x` from the entries of `A`.
#[cfg_attr(not(debug_assertions), inline(always))]
fn product<S: Scalar>(x: &[S], y: &mut [S]) -> impl FnMut(usize, usize, S) {
    |row, column, value| y[row] = y[row] + value * x[column]
}

/// Takes entries of a Jacobian where that is rare. The second derivatives of a system are long, and compiled
/// for each type that takes them.
type RareEntry<'r, S> = &'r mut dyn FnMut(usize, usize, S);

/// The powers of two by which the two kinds of unknowns are multiplied, which is exact; `None` where there is
/// one kind.
type Units = Option<[f64; 2]>;

fn multiply<S: Scalar>(list: &mut [S], units: Units) {
    let Some([first, second]) = units else { return };
    let (first, second) = (S::from_f64(first), S::from_f64(second));
    for pair in list.as_chunks_mut().0 {
        let [u, v] = *pair;
        *pair = [u * first, v * second];
    }
}

/// Units of the unknowns where there are two kinds: about the largest of each kind, or its largest residual
/// where that is zero.
fn units<S: Scalar>(kind: Unknowns, x: &[S], residual: &[S]) -> Units {
    let (sizes, others) = (largest(kind, x), largest(kind, residual));
    let unit = |i: usize| match [sizes[i], others[i]].into_iter().find(|&size| size > 0.0) {
        Some(size) => power_of_two(size),
        None => 1.0,
    };
    (kind == Unknowns::Both).then(|| [unit(0), unit(1)])
}

fn inverse(units: Units) -> Units {
    units.map(|units| units.map(f64::recip))
}

impl<H: Elements, S: Scalar> LoopStep<'_, H, S> {
    /// `∂u/∂v` at the current stages, where it is diagonal.
    pub(super) fn differentiate_velocities(&self, lists: &StepLists<'_, S>, diagonal: &mut [S]) {
        if self.scheme.unknowns == Unknowns::Momenta {
            diagonal.fill(S::from_f64(0.0));
            let free = if self.increment.is_some() { &[] } else { self.scheme.stages };
            // It is diagonal where it is needed, by the choice of unknowns.
            let mut add = |by, [i, _]: [usize; 2], is_alone: bool, value| {
                if by == HessianBlock::PP && is_alone {
                    diagonal[i] = diagonal[i] + value;
                }
            };
            for stage in free {
                self.hessian(stage, self.q, lists.momentum, Partials::BY_MOMENTA, &mut add);
            }
        }
    }

    /// Factors the Jacobian at the current stages. The factors for Krylov's method are complete if `all` and
    /// cheap enough.
    ///
    /// # Errors
    /// [`StepFailure::Singular`] or [`StepFailure::NonFinite`] of a band.
    pub(super) fn factor(
        &self,
        lists: &StepLists<'_, S>,
        diagonal: &mut [S],
        linear: &mut LinearSolver<S>,
        all: bool,
    ) -> Result<(), StepFailure> {
        self.differentiate_velocities(lists, diagonal);
        match linear {
            LinearSolver::Band(band) => {
                band.reset();
                self.add_to(band, lists, diagonal);
                band.factor()
            }
            LinearSolver::Bordered(bordered) => {
                bordered.band.reset();
                self.add_to(&mut bordered.band, lists, diagonal);
                self.rank_one_terms(lists, diagonal, &mut bordered.terms);
                bordered.factor()
            }
            LinearSolver::Krylov(wide) => {
                wide.leaves_out = false;
                let factors = self.reset(wide, all);
                self.entries_rarely(lists, diagonal, &mut |i, j, value| factors.add(i, j, value));
                factors.factor();
                Ok(())
            }
        }
    }

    /// [`LoopStep::factor`] without entries that are not finite; returns their number.
    ///
    /// # Errors
    /// The errors of [`LoopStep::factor`].
    pub(super) fn factor_with_care(
        &self,
        lists: &StepLists<'_, S>,
        diagonal: &mut [S],
        linear: &mut LinearSolver<S>,
    ) -> Result<usize, StepFailure> {
        self.differentiate_velocities(lists, diagonal);
        let mut left_out = 0;
        let mut add = |into: RareEntry<'_, S>| {
            self.entries_rarely(lists, diagonal, &mut |i, j, value| match value.magnitude().is_finite() {
                true => into(i, j, value),
                false => left_out += 1,
            });
        };
        match linear {
            LinearSolver::Band(band) => {
                band.reset();
                add(&mut |i, j, value| band.add(i, j, value));
                band.factor()?;
            }
            LinearSolver::Bordered(bordered) => {
                bordered.band.reset();
                add(&mut |i, j, value| bordered.band.add(i, j, value));
                self.rank_one_terms(lists, diagonal, &mut bordered.terms);
                left_out += bordered.terms.leave_out();
                bordered.factor()?;
            }
            LinearSolver::Krylov(wide) => {
                let factors = self.reset(wide, true);
                add(&mut |i, j, value| factors.add(i, j, value));
                factors.factor();
                wide.leaves_out = left_out > 0;
            }
        }
        Ok(left_out)
    }

    /// The preconditioner, as that of the identity.
    fn reset<'w>(&self, wide: &'w mut KrylovSolver<S>, all: bool) -> &'w mut Sparse<S> {
        let (scheme, degrees) = (self.scheme, self.degrees());
        let pattern = |visit: VisitEntry<'_>| pattern(self.system, scheme, degrees, visit);
        let factors = wide.room(&pattern, scheme.unknowns.count(degrees), all);
        factors.reset();
        factors
    }

    /// Multiplies the correction by `J⁻¹`, up to `tolerance` with Krylov's method; returns the number of its
    /// Jacobian products. On `Err` the correction is unchanged.
    ///
    /// # Errors
    /// [`StepFailure::NotConverged`] or [`StepFailure::NonFinite`] of a Krylov iteration.
    pub(super) fn correct(
        &self,
        lists: &mut StepLists<'_, S>,
        diagonal: &[S],
        linear: &mut LinearSolver<S>,
        tolerance: f64,
    ) -> Result<Option<u32>, StepFailure> {
        match linear {
            LinearSolver::Band(band) => {
                band.solve(lists.correction);
                Ok(None)
            }
            LinearSolver::Bordered(bordered) => {
                bordered.solve(lists.correction);
                Ok(None)
            }
            LinearSolver::Krylov(wide) => {
                let KrylovSolver { krylov, terms, room, factors, leaves_out } = &mut **wide;
                let (factors, all) = factors.as_mut().ok_or(StepFailure::NonFinite)?;
                let correction = std::mem::take(&mut lists.correction);
                let units = units(self.scheme.unknowns, lists.x, correction);
                let inverse = inverse(units);
                multiply(correction, inverse);
                // Incomplete factors get fewer cycles before complete ones replace them.
                let most = Krylov::<S>::MOST_CYCLES;
                let most_cycles =
                    if *all { most } else { most.min(EXCESS_PRODUCTS / Krylov::<S>::BASIS as u32) };
                let stages = lists.lend();
                if const { !H::FACTS.collective_variables.is_empty() } {
                    self.rank_one_terms(&stages, diagonal, terms);
                    if *leaves_out {
                        terms.leave_out();
                    }
                }
                let operator = &mut Operator {
                    product: &mut |x: &[S], y: &mut [S]| {
                        self.product(&stages, diagonal, *leaves_out, terms, units, x, y, room);
                    },
                    precondition: &mut |x: &mut [S]| {
                        multiply(x, units);
                        factors.solve(x);
                        multiply(x, inverse);
                    },
                    most_cycles,
                };
                let solved = krylov.solve(correction, tolerance, operator);
                multiply(correction, units);
                lists.correction = correction;
                solved.map(Some)
            }
        }
    }

    /// `y = J x` at the current stages, with each kind of unknown in its own unit, so that one norm covers
    /// both; without the entries that are not finite where `leaves_out`.
    #[expect(
        clippy::too_many_arguments,
        reason = "an operator, its units, and the lists that it reads and writes"
    )]
    fn product(
        &self,
        lists: &StepLists<'_, S>,
        diagonal: &[S],
        leaves_out: bool,
        terms: &RankOneTerms<S>,
        units: Units,
        x: &[S],
        y: &mut [S],
        room: &mut Vec<S>,
    ) {
        if leaves_out {
            room.clear();
            room.extend_from_slice(x);
            multiply(room, units);
            y.copy_from_slice(room);
            self.entries_rarely(lists, diagonal, &mut |i, j, value| {
                if value.magnitude().is_finite() {
                    y[i] = y[i] + value * room[j];
                }
            });
            terms.multiply(room, y);
            return multiply(y, inverse(units));
        }
        if units.is_none() {
            y.copy_from_slice(x);
            self.entries(lists, diagonal, &mut product(x, y));
            return terms.multiply(x, y);
        }
        room.clear();
        room.extend_from_slice(x);
        multiply(room, units);
        y.copy_from_slice(room);
        self.entries(lists, diagonal, &mut product(room, y));
        terms.multiply(room, y);
        multiply(y, inverse(units));
    }

    /// A function of its own: only then is it known that the lists do not overlap.
    #[inline(never)]
    fn add_to(&self, band: &mut Banded<S>, lists: &StepLists<'_, S>, diagonal: &[S]) {
        self.entries(lists, diagonal, &mut |i, j, value| band.add(i, j, value));
    }

    fn entries_rarely(&self, lists: &StepLists<'_, S>, diagonal: &[S], mut into: RareEntry<'_, S>) {
        self.entries(lists, diagonal, &mut into);
    }

    /// `-φ'` at the current stages: the Jacobian of `(∂L_d/∂P, -D_1 L_d)`, unknowns
    /// `u_0, v_0, u_1, v_1, ...`; or `∂(-D_1 L_d)/∂v` with `∂u/∂v = D`, which is
    /// `I + Σ start (c F_qq D + F_qp)`.
    fn entries(&self, lists: &StepLists<'_, S>, diagonal: &[S], add: &mut impl FnMut(usize, usize, S)) {
        let StepLists { stages, momentum, .. } = lists;
        for (s, stage) in self.scheme.stages.iter().enumerate() {
            let (q, _) = stages.at(s);
            let (point, start, both) = (stage.point, stage.start, stage.start * stage.point);
            if self.scheme.unknowns == Unknowns::Both {
                let mut coupled = |by, [i, j]: [usize; 2], is_alone: bool, value: S| {
                    let (at, entry, mirrored, other) = match by {
                        HessianBlock::QQ => {
                            ([2 * i + 1, 2 * j], value * both, [2 * j + 1, 2 * i], value * both)
                        }
                        HessianBlock::QP => {
                            ([2 * i + 1, 2 * j + 1], value * start, [2 * j, 2 * i], -(value * point))
                        }
                        HessianBlock::PP => ([2 * i, 2 * j + 1], -value, [2 * j, 2 * i + 1], -value),
                    };
                    add(at[0], at[1], entry);
                    if !is_alone {
                        add(mirrored[0], mirrored[1], other);
                    }
                };
                self.hessian(stage, q, momentum, Partials::ALL, &mut coupled);
            } else {
                let mut reduced = |by, [i, j]: [usize; 2], is_alone: bool, value: S| match by {
                    HessianBlock::QQ => {
                        add(i, j, value * both * diagonal[j]);
                        if !is_alone {
                            add(j, i, value * both * diagonal[i]);
                        }
                    }
                    HessianBlock::QP => add(i, j, value * start),
                    HessianBlock::PP => {}
                };
                self.hessian(stage, q, momentum, Partials::BY_COORDINATES, &mut reduced);
            }
        }
    }
}

/// Takes positions of a Jacobian.
pub(super) type VisitEntry<'v> = &'v mut dyn FnMut(usize, usize);

/// Calls `visit` with every off-diagonal position where the Jacobian may have an entry, some more than once.
pub(super) fn pattern<H: Elements>(system: &H, scheme: &Quadrature, degrees: usize, visit: VisitEntry<'_>) {
    let (zeros, dw) = (vec![0.0; degrees], vec![0.0; system.noises()]);
    let (q, p, dw) = (&*zeros, &*zeros, &*dw);
    let step = LoopStep { system, scheme, t: 0.0, h: 1.0, parameters: &[], q, p, dw, increment: None };
    let (mut work, diagonal) =
        (StepScratch::new(scheme, degrees), vec![0.0; scheme.unknowns.diagonals(degrees)]);
    step.entries_rarely(&work.lists(scheme, degrees), &diagonal, &mut |row, column, _| {
        if row != column {
            visit(row, column);
        }
    });
}
