//! Steps of [`Rattle`](super::Rattle) for any Hamiltonian: masses that depend on the coordinates, kinetic
//! energies that are no squares, noise whose flow keeps the constraints.
//!
//! With the step Hamiltonian `F = h H_0 + Σ_k ΔW_k H_k`, the first half of the equations of [the
//! room](super) is solved for `v = P - p_i`, `u = q_{i+1} - q_i` and `ν = h λ / 2` by Newton's method,
//!
//! ```text
//! v + F_q(q_i, P) / 2 + G(q_i)ᵀ ν = 0,   u - (F_p(q_i, P) + F_p(q_{i+1}, P)) / 2 = 0,   g(q_{i+1}) = 0
//! ```
//!
//! and the second for `κ = h μ / 2`, `p_{i+1} = P - F_q(q_{i+1}, P) / 2 - G(q_{i+1})ᵀ κ`. Matrices are dense:
//! a step costs `(2d + m)³` operations.

use super::flows::largest_ratio;
use super::layout::{is_pivot, truth};
use super::manifold::NEAR;
use super::past::PastImpulses;
use super::{Constrained, ConstraintRows, MOST_ITERATIONS, ROUNDINGS};
use crate::algebra::memory::step_memory;
use crate::algebra::scalar::{ComputesWith, Constant, Mask, Scalar};
use crate::algebra::shape::{Dynamic, Shape as _};
use crate::algebra::solve::Effort;
use crate::algebra::state_sum::{self, StateSum};
use crate::error::{ConfigError, StepFailure};
use crate::scheme::elements::{
    Elements, EvaluationPoint, HessianBlock, PairColumns, Partials, Role, check_new, field,
};
use crate::scheme::plan::{KeptEnergy, NoiseClass, Plan, Solver};
use crate::scheme::system::{
    LiftParameter, Movable, Properties, Scheme, StepArguments, check_lengths, varied_without_lists,
};

/// A correction of this fraction of an unknown and its state leaves one that is below rounding: its square.
const LAST_CORRECTION: f64 = 1e-9;
/// The most unknowns of a step, whose matrices are dense.
const MOST_UNKNOWNS: usize = 600;

/// A dense matrix by rows, or its factors.
#[derive(Clone, Debug, Default)]
pub(super) struct DenseMatrix<S> {
    n: usize,
    entries: Vec<S>,
}

impl<S: Scalar> DenseMatrix<S> {
    /// Makes it `n` rows and columns of zeros.
    pub(super) fn reset(&mut self, n: usize) {
        self.n = n;
        self.entries.clear();
        self.entries.resize(n * n, S::from_f64(0.0));
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn at(&self, row: usize, column: usize) -> S {
        self.entries[row * self.n + column]
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn add(&mut self, row: usize, column: usize, value: S) {
        let entry = &mut self.entries[row * self.n + column];
        *entry = *entry + value;
    }

    /// Factors the matrix without exchanges; returns where every pivot is positive against its terms.
    pub(super) fn factor(&mut self) -> S::Mask {
        let (n, mut is_regular) = (self.n, truth::<S::Mask>());
        for k in 0..n {
            let mut terms = self.at(k, k).abs();
            for before in 0..k {
                terms = terms + (self.at(k, before) * self.at(before, k)).abs();
            }
            let pivot = self.at(k, k);
            is_regular = is_regular & is_pivot(pivot, terms);
            let inverse = pivot.recip();
            for row in k + 1..n {
                let factor = self.at(row, k) * inverse;
                self.entries[row * n + k] = factor;
                for column in k + 1..n {
                    let product = factor * self.at(k, column);
                    self.add(row, column, -product);
                }
            }
        }
        is_regular
    }

    /// `b` becomes `A⁻¹ b`, after [`DenseMatrix::factor`].
    pub(super) fn solve(&self, b: &mut [S]) {
        for row in 0..self.n {
            for before in 0..row {
                b[row] = b[row] - self.at(row, before) * b[before];
            }
        }
        for row in (0..self.n).rev() {
            for after in row + 1..self.n {
                b[row] = b[row] - self.at(row, after) * b[after];
            }
            b[row] = b[row] / self.at(row, row);
        }
    }
}

/// Constraints at a point, with the whole Jacobian.
#[derive(Clone, Debug, Default)]
pub(super) struct GeneralConstraints<S> {
    degrees: usize,
    pub(super) values: Vec<S>,
    pub(super) rates: Vec<S>,
    /// The Jacobian, by rows.
    jacobian: Vec<S>,
}

impl<S: Scalar> ConstraintRows<S> for GeneralConstraints<S> {
    fn value(&mut self, constraint: usize, value: S) {
        self.values[constraint] = self.values[constraint] + value;
    }

    fn slope(&mut self, constraint: usize, coordinate: usize, slope: S) {
        let entry = &mut self.jacobian[constraint * self.degrees + coordinate];
        *entry = *entry + slope;
    }

    fn rate(&mut self, constraint: usize, rate: S) {
        self.rates[constraint] = self.rates[constraint] + rate;
    }
}

impl<S: Scalar> GeneralConstraints<S> {
    /// The constraints at coordinates.
    pub(super) fn evaluate<F: Constrained>(&mut self, of: &GeneralField<'_, F, S>, q: &[S], t: S::Constant) {
        let (constraints, zero) = (Constrained::constraints(of.system), S::from_f64(0.0));
        self.degrees = q.len();
        for (list, length) in [
            (&mut self.values, constraints),
            (&mut self.rates, constraints),
            (&mut self.jacobian, constraints * q.len()),
        ] {
            list.clear();
            list.resize(length, zero);
        }
        of.system.constrain(&EvaluationPoint::new([q, &[][..]], t, of.parameters, &[]), self);
    }

    pub(super) fn rows(&self) -> impl Iterator<Item = &[S]> {
        self.jacobian.chunks_exact(self.degrees.max(1))
    }

    /// `G v`
    pub(super) fn product(&self, v: &[S], into: &mut [S]) {
        for (row, into) in self.rows().zip(into) {
            *into = row.iter().zip(v).fold(S::from_f64(0.0), |sum, (&g, &v)| sum + g * v);
        }
    }

    /// `|G| |v|`
    pub(super) fn absolute_product(&self, v: &[S], into: &mut [S]) {
        for (row, into) in self.rows().zip(into) {
            *into = row.iter().zip(v).fold(S::from_f64(0.0), |sum, (&g, &v)| sum + (g * v).abs());
        }
    }

    /// `x ← x - Gᵀ ν`
    pub(super) fn subtract_transposed(&self, nu: &[S], x: &mut [S]) {
        for (row, &nu) in self.rows().zip(nu) {
            for (x, &g) in x.iter_mut().zip(row) {
                *x = *x - g * nu;
            }
        }
    }
}

/// The gradient of the step Hamiltonian.
#[derive(Clone, Debug, Default)]
pub(super) struct FieldGradient<S> {
    pub(super) by_q: Vec<S>,
    pub(super) by_p: Vec<S>,
}

/// The derivatives of the step Hamiltonian and of the drift.
pub(super) struct GeneralField<'a, F, S: Scalar> {
    pub(super) system: &'a F,
    pub(super) parameters: &'a [S::Constant],
}

impl<F: Constrained, S: Scalar> GeneralField<'_, F, S> {
    /// `F_q` and `F_p`.
    pub(super) fn gradient(
        &self,
        at: &StepPoint<'_, S>,
        into: &mut FieldGradient<S>,
        columns: &mut PairColumns,
    ) {
        let FieldGradient { by_q, by_p } = into;
        by_q.resize(at.q.len(), S::from_f64(0.0));
        by_p.resize(at.q.len(), S::from_f64(0.0));
        let times = [S::of_constant(at.t), S::of_constant(at.h)];
        let into = [&mut by_q[..], &mut by_p[..]];
        let of = (self.system, self.parameters);
        field::<F, S, true, true>(of, (times, [at.q, at.p], at.dw), into, columns);
    }

    /// Gives the second derivatives of a term of `F` to `add`, entry by entry. Derivatives of a force `f` are
    /// those of `-f`, in the place of `F_q`.
    fn hessian(
        &self,
        role: Role,
        at: &StepPoint<'_, S>,
        add: &mut impl FnMut(HessianBlock, usize, usize, S),
    ) {
        let point = EvaluationPoint {
            h: at.h,
            acting: 0..at.dw.len(),
            ..EvaluationPoint::new([at.q, at.p], at.t, self.parameters, at.dw)
        };
        let mut entry = |by: HessianBlock, [i, j]: [usize; 2], is_alone: bool, value: S| {
            add(by, i, j, value);
            if !is_alone && by != HessianBlock::QP {
                add(by, j, i, value);
            }
        };
        self.system.hessian(role, 1.0, &point, Partials::ALL, &mut entry);
    }

    /// [`GeneralField::hessian`] of the drift and of the noises.
    fn hessian_of_energies(
        &self,
        at: &StepPoint<'_, S>,
        add: &mut impl FnMut(HessianBlock, usize, usize, S),
    ) {
        self.hessian(Role::Drift, at, add);
        if !at.dw.is_empty() {
            self.hessian(Role::Noise, at, add);
        }
    }

    /// Gives the entries of `∂²H_0/∂p²` to `add`.
    pub(super) fn masses(&self, at: &StepPoint<'_, S>, mut add: impl FnMut(usize, usize, S)) {
        self.hessian(Role::Drift, at, &mut |by, i, j, value| {
            if by == HessianBlock::PP {
                add(i, j, value);
            }
        });
    }

    /// `G H_pp Gᵀ` of the drift.
    pub(super) fn normal_matrix(
        &self,
        at: &StepPoint<'_, S>,
        constraints: &GeneralConstraints<S>,
        into: &mut DenseMatrix<S>,
    ) {
        into.reset(constraints.values.len());
        self.masses(at, |i, j, value| {
            for (k, row) in constraints.rows().enumerate() {
                for (l, column) in constraints.rows().enumerate() {
                    into.add(k, l, row[i] * value * column[j]);
                }
            }
        });
    }

    /// `G ∂H_0/∂p + ∂g/∂t`; leaves `∂H_0/∂p` in the gradient.
    pub(super) fn rates(
        &self,
        at: &StepPoint<'_, S>,
        constraints: &GeneralConstraints<S>,
        gradient: &mut FieldGradient<S>,
        columns: &mut PairColumns,
        into: &mut [S],
    ) {
        self.gradient(at, gradient, columns);
        constraints.product(&gradient.by_p, into);
        into.iter_mut().zip(&constraints.rates).for_each(|(rate, &of_t)| *rate = *rate + of_t);
    }

    /// Moves momenta along `Gᵀ` until `G ∂H_0/∂p + ∂g/∂t = 0`; returns where that succeeded.
    pub(super) fn make_tangent(
        &self,
        [q, p]: [&[S]; 2],
        t: S::Constant,
        room: &mut TangentRoom<S>,
        constraints: &GeneralConstraints<S>,
    ) -> S::Mask {
        let TangentRoom { matrix, gradient, columns, kappa, moved } = room;
        let (zero, one) = (S::from_f64(0.0), Scalar::from_f64(1.0));
        kappa.resize(constraints.values.len(), zero);
        moved.clear();
        moved.extend_from_slice(p);
        let (mut done, mut is_regular) = (S::Mask::from_bool(false), truth::<S::Mask>());
        for _ in 0..MOST_ITERATIONS {
            let at = StepPoint { q, p: &moved[..], t, h: one, dw: &[] };
            self.rates(&at, constraints, gradient, columns, kappa);
            self.normal_matrix(&at, constraints, matrix);
            is_regular = is_regular & (matrix.factor() | done);
            matrix.solve(kappa);
            // The gradient has served.
            let impulse = &mut gradient.by_p;
            impulse.fill(zero);
            constraints.subtract_transposed(kappa, impulse);
            let mut largest = zero;
            for (p, impulse) in moved.iter_mut().zip(&*impulse) {
                let end = *p + *impulse;
                largest = largest.larger(ratio(impulse.abs(), p.abs() + end.abs()));
                *p = S::select(done, *p, end);
            }
            // A kinetic energy of squares is solved by the first.
            done = done | largest.less_equal(S::from_f64(LAST_CORRECTION));
            if done.all() || !is_regular.any() {
                break;
            }
        }
        if const { S::DERIVATIVES > 0 } {
            let at = StepPoint { q, p: &moved[..], t, h: one, dw: &[] };
            self.rates(&at, constraints, gradient, columns, kappa);
            self.normal_matrix(&at, constraints, matrix);
            matrix.factor();
            kappa.iter_mut().for_each(|kappa| *kappa = kappa.infinitesimal());
            matrix.solve(kappa);
            kappa.iter_mut().for_each(|kappa| *kappa = kappa.infinitesimal());
            constraints.subtract_transposed(kappa, moved);
        }
        done & is_regular
    }
}

/// Scratch for a projection of momenta, and their end.
#[derive(Clone, Debug, Default)]
pub(super) struct TangentRoom<S> {
    pub(super) matrix: DenseMatrix<S>,
    pub(super) gradient: FieldGradient<S>,
    pub(super) columns: PairColumns,
    pub(super) kappa: Vec<S>,
    /// The projected momenta.
    pub(super) moved: Vec<S>,
}

/// `x / y`, and `x` where `y` is zero.
fn ratio<S: Scalar>(x: S, y: S) -> S {
    x / S::select(y.equal(S::from_f64(0.0)), S::from_f64(1.0), y)
}

/// A point of a step: a state, its time, and the increments.
pub(super) struct StepPoint<'a, S: Scalar> {
    pub(super) q: &'a [S],
    pub(super) p: &'a [S],
    pub(super) t: S::Constant,
    pub(super) h: S::Constant,
    pub(super) dw: &'a [S],
}

/// Single steps of [`Rattle`](super::Rattle) for any Hamiltonian.
#[derive(Clone, Copy, Debug)]
pub enum GeneralRattle {}

/// The constants of steps.
#[derive(Clone, Debug)]
pub struct GeneralRattleConstants<K> {
    parameters: Vec<K>,
    /// The factor of the momenta by friction in half of a step.
    decay: Option<K>,
}

/// The memory of steps for any Hamiltonian.
#[derive(Debug, Default)]
pub struct GeneralRattleMemory<S: Scalar> {
    past: PastImpulses<S, Dynamic>,
    room: GeneralRoom<S>,
}

step_memory! {
    impl[S: Scalar] StepMemory for GeneralRattleMemory<S> {
        kept: past; scratch: room
    }
}

/// The lists of a step.
#[derive(Clone, Debug, Default)]
struct GeneralRoom<S> {
    tangent: TangentRoom<S>,
    /// The constraints at the start and at the end.
    here: GeneralConstraints<S>,
    there: GeneralConstraints<S>,
    /// The gradient at the end.
    ahead: FieldGradient<S>,
    /// The momenta at the start, after friction.
    start: Vec<S>,
    /// `P` and `q_{i+1}`.
    momentum: Vec<S>,
    end: Vec<S>,
    /// `v`, `u` and `ν`, and their corrections.
    x: Vec<S>,
    correction: Vec<S>,
    /// Sizes of coordinates, and bounds of constraints.
    sizes: Vec<S>,
    bounds: Vec<S>,
    /// The increments of the coordinates and of the momenta; then the rounding errors of the end.
    by_q: Vec<S>,
    by_p: Vec<S>,
    next_q: Vec<S>,
    next_p: Vec<S>,
}

impl<F: Constrained> Scheme<F> for GeneralRattle {
    const PLAN: Plan = {
        let is_known = F::Shape::IS_FIXED && F::FACTS.degrees != usize::MAX;
        let unknowns = if is_known { 2 * F::FACTS.degrees + F::CONSTRAINTS } else { usize::MAX };
        F::FACTS.plan(Solver::Newton, unknowns, 2, true)
    };
    const PROPERTIES: Properties =
        Properties { kept_energy: KeptEnergy::Nearly, ..Properties::of(&<Self as Scheme<F>>::PLAN, 1) };
    type Prepared<K: Constant> = GeneralRattleConstants<K>;
    type Memory<S: Scalar> = GeneralRattleMemory<S>;
    type Unclocked = Self;
    type CompensatedSum<S: Scalar> = state_sum::CompensatedSum<S, F::Shape>;
    type Sum<S: Scalar> = state_sum::CompensatedSum<S, F::Shape>;

    fn prepare<K: Constant>(
        system: &F,
        lift: LiftParameter<'_, K>,
        h: K,
    ) -> Result<Self::Prepared<K>, ConfigError> {
        check_new(system)?;
        let parameters = varied_without_lists(system, lift)?;
        let rate = || Elements::friction_rate(system, &parameters);
        let decay = F::FACTS.kind.is_conformal.then(|| (-(rate() * h * 0.5)).exp());
        Ok(GeneralRattleConstants { parameters, decay })
    }

    fn advance<K: Constant, S: ComputesWith<K>, C: StateSum<S>, const CAREFUL: bool>(
        system: &F,
        GeneralRattleConstants { parameters, decay }: &Self::Prepared<K>,
        at: StepArguments<'_, S, K, impl Movable<S> + ?Sized>,
        memory: &mut Self::Memory<S>,
        carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        let StepArguments { t, h, q, p, dw } = at.lists().shared();
        check_lengths(system, false, [q.len(), p.len(), dw.len()])?;
        let unknowns = 2 * q.len() + Constrained::constraints(system);
        if unknowns > MOST_UNKNOWNS {
            return Err(StepFailure::TooManyUnknowns { unknowns, most: MOST_UNKNOWNS });
        }
        memory.past.fit(Constrained::constraints(system));
        let of = GeneralField { system, parameters: S::varied(parameters) };
        let step = GeneralStep { of, t, h, dw, q, p, decay: decay.map(S::constant) };
        let GeneralEnd { mut taken, iterations, residual } = step.solve(memory)?;
        let GeneralRoom { by_q, by_p, next_q, next_p, .. } = &mut memory.room;
        next_q.resize(q.len(), S::from_f64(0.0));
        next_p.resize(q.len(), S::from_f64(0.0));
        for i in 0..q.len() {
            (next_q[i], by_q[i]) = C::add(q[i], by_q[i], carry.of_coordinate(i));
            (next_p[i], by_p[i]) = C::add(p[i], by_p[i], carry.of_momentum(i));
            taken = taken & next_q[i].is_finite() & next_p[i].is_finite();
        }
        if taken.any() {
            for i in 0..q.len() {
                q[i] = S::select(taken, next_q[i], q[i]);
                p[i] = S::select(taken, next_p[i], p[i]);
                by_q[i] = S::select(taken, by_q[i], carry.of_coordinate(i));
                by_p[i] = S::select(taken, by_p[i], carry.of_momentum(i));
            }
            carry.keep(by_q, by_p);
        }
        if taken.all() {
            return Ok(Effort::fast(iterations));
        }
        if S::MAY_FAIL_BY_LANE {
            return Err(StepFailure::but_of::<S>(taken));
        }
        Err(StepFailure::NotConverged { iterations, correction: residual.magnitude() })
    }
}

/// A step to solve.
struct GeneralStep<'a, F, S: Scalar> {
    of: GeneralField<'a, F, S>,
    t: S::Constant,
    h: S::Constant,
    dw: &'a [S],
    q: &'a [S],
    p: &'a [S],
    /// The factor of the momenta by friction in half of the step.
    decay: Option<S>,
}

/// The end of a step, whose increments are in the room.
struct GeneralEnd<S: Scalar> {
    taken: S::Mask,
    iterations: u32,
    /// The last correction, relative to its unknown and the state.
    residual: S,
}

impl<F: Constrained, S: Scalar> GeneralStep<'_, F, S> {
    /// Solves the step.
    ///
    /// # Errors
    /// [`StepFailure::OffManifold`]
    fn solve(&self, memory: &mut GeneralRattleMemory<S>) -> Result<GeneralEnd<S>, StepFailure> {
        let GeneralRattleMemory { past, room } = memory;
        let (d, m, zero) = (self.q.len(), Constrained::constraints(self.of.system), S::from_f64(0.0));
        let uses_past = matches!(F::FACTS.noise, NoiseClass::None);
        self.begin(room)?;
        let nu = &mut room.x[2 * d..];
        if uses_past {
            past.guess(nu);
        } else {
            nu.fill(zero);
        }
        self.guess(room);
        let (mut is_small, mut done) = ([S::Mask::from_bool(false); 3], S::Mask::from_bool(false));
        let mut end = GeneralEnd { taken: S::Mask::from_bool(true), iterations: 0, residual: zero };
        loop {
            self.evaluate(room);
            let GeneralRoom { there, sizes, bounds, end: q, .. } = &mut *room;
            for ((size, &q), &start) in sizes.iter_mut().zip(&*q).zip(self.q) {
                *size = q.abs() + start.abs();
            }
            there.absolute_product(sizes, bounds);
            let distance = largest_ratio(&there.values, bounds);
            // Three corrections below rounding leave nothing but rounding, whatever its size.
            done = done | (is_small[0] & distance.less_equal(S::from_f64(ROUNDINGS))) | is_small[2];
            if (done | !end.taken).all() {
                break;
            }
            if end.iterations == MOST_ITERATIONS {
                end.taken = end.taken & done;
                break;
            }
            end.iterations += 1;
            let is_regular = self.correct(room);
            end.taken = end.taken & (done | is_regular);
            let largest = self.apply(room, done);
            end.residual = S::select(done, end.residual, largest);
            let now = largest.less_equal(S::from_f64(LAST_CORRECTION));
            is_small = [now, now & is_small[0], now & is_small[1]];
        }
        if const { S::DERIVATIVES > 0 } {
            self.correct(room);
            let GeneralRoom { x, correction, .. } = &mut *room;
            for (x, correction) in x.iter_mut().zip(&*correction) {
                *x = *x - correction.infinitesimal();
            }
            self.evaluate(room);
        }
        if uses_past {
            past.record(end.taken, &room.x[2 * d..2 * d + m]);
        }
        end.taken = end.taken & self.finish(room);
        Ok(end)
    }

    /// The lists of the step, and the constraints at its start.
    fn begin(&self, room: &mut GeneralRoom<S>) -> Result<(), StepFailure> {
        let (d, m, zero) = (self.q.len(), Constrained::constraints(self.of.system), S::from_f64(0.0));
        let lists = [&mut room.start, &mut room.momentum, &mut room.end, &mut room.sizes];
        lists.into_iter().chain([&mut room.by_q, &mut room.by_p]).for_each(|list| list.resize(d, zero));
        room.bounds.resize(m, zero);
        room.x.resize(2 * d + m, zero);
        room.correction.resize(2 * d + m, zero);
        for (start, &p) in room.start.iter_mut().zip(self.p) {
            *start = self.decay.map_or(p, |decay| p * decay);
        }
        room.here.evaluate(&self.of, self.q, self.t);
        room.here.absolute_product(self.q, &mut room.bounds);
        let distance = largest_ratio(&room.here.values, &room.bounds);
        match distance.less_equal(S::from_f64(NEAR)).all() {
            true => Ok(()),
            false => Err(StepFailure::OffManifold { coordinates: distance.magnitude(), momenta: 0.0 }),
        }
    }

    /// `v` and `u` by the derivatives at the start.
    fn guess(&self, room: &mut GeneralRoom<S>) {
        let d = self.q.len();
        let GeneralRoom { tangent: TangentRoom { gradient, columns, .. }, here, start, x, .. } = room;
        let at = StepPoint { q: self.q, p: &start[..], t: self.t, h: self.h, dw: self.dw };
        self.of.gradient(&at, gradient, columns);
        let (v, rest) = x.split_at_mut(d);
        let (u, nu) = rest.split_at_mut(d);
        for (((v, u), &by_q), &by_p) in v.iter_mut().zip(u).zip(&gradient.by_q).zip(&gradient.by_p) {
            (*v, *u) = (by_q * -0.5, by_p);
        }
        here.subtract_transposed(nu, v);
    }

    /// `P`, `q_{i+1}`, and the gradients and constraints there.
    fn evaluate(&self, room: &mut GeneralRoom<S>) {
        let d = self.q.len();
        let GeneralRoom { tangent, there, ahead, start, momentum, end, x, .. } = room;
        for i in 0..d {
            (momentum[i], end[i]) = (start[i] + x[i], self.q[i] + x[d + i]);
        }
        let TangentRoom { gradient, columns, .. } = tangent;
        let at = StepPoint { q: self.q, p: &momentum[..], t: self.t, h: self.h, dw: self.dw };
        self.of.gradient(&at, gradient, columns);
        let at = StepPoint { q: &end[..], t: self.t + self.h, ..at };
        self.of.gradient(&at, ahead, columns);
        there.evaluate(&self.of, end, self.t + self.h);
    }

    /// The residuals of the equations and Newton's corrections; returns where the matrix is regular.
    fn correct(&self, room: &mut GeneralRoom<S>) -> S::Mask {
        let d = self.q.len();
        let GeneralRoom { tangent, here, there, ahead, momentum, end, x, correction, .. } = room;
        let TangentRoom { gradient, matrix, .. } = tangent;
        matrix.reset(x.len());
        // So signed, the constraints have positive pivots, those of `|h| G H_pp Gᵀ`.
        let sign = if self.h.lane(0) < 0.0 { 1.0 } else { -1.0 };
        for i in 0..d {
            correction[i] = x[i] + gradient.by_q[i] * 0.5;
            correction[d + i] = x[d + i] - (gradient.by_p[i] + ahead.by_p[i]) * 0.5;
            matrix.add(i, i, S::from_f64(1.0));
            matrix.add(d + i, d + i, S::from_f64(1.0));
        }
        for (k, (row, later)) in here.rows().zip(there.rows()).enumerate() {
            let nu = x[2 * d + k];
            correction[2 * d + k] = there.values[k] * sign;
            for i in 0..d {
                correction[i] = correction[i] + row[i] * nu;
                matrix.add(i, 2 * d + k, row[i]);
                matrix.add(2 * d + k, d + i, later[i] * sign);
            }
        }
        let start = StepPoint { q: self.q, p: &momentum[..], t: self.t, h: self.h, dw: self.dw };
        let after = StepPoint { q: &end[..], t: self.t + self.h, ..start };
        self.of.hessian_of_energies(&start, &mut |by, i, j, value| match by {
            HessianBlock::QQ => {}
            HessianBlock::QP => matrix.add(i, j, value * 0.5),
            HessianBlock::PP => matrix.add(d + i, j, value * -0.5),
        });
        self.of.hessian_of_energies(&after, &mut |by, i, j, value| match by {
            HessianBlock::QQ => {}
            HessianBlock::QP => matrix.add(d + j, d + i, value * -0.5),
            HessianBlock::PP => matrix.add(d + i, j, value * -0.5),
        });
        if F::FACTS.kind.is_forced {
            self.of.hessian(Role::Force, &start, &mut |by, i, j, value| {
                if by == HessianBlock::QP {
                    matrix.add(i, j, value * 0.5);
                }
            });
        }
        let is_regular = matrix.factor();
        matrix.solve(correction);
        is_regular
    }

    /// Corrects the unknowns of paths that are not `done`; returns the largest correction of an increment,
    /// relative to the increment and the state that it moves.
    fn apply(&self, room: &mut GeneralRoom<S>, done: S::Mask) -> S {
        let d = self.q.len();
        let GeneralRoom { start, x, correction, .. } = room;
        let mut largest = S::from_f64(0.0);
        for (i, (x, &correction)) in x.iter_mut().zip(&*correction).enumerate() {
            *x = S::select(done, *x, *x - correction);
            if i < 2 * d {
                let state = if i < d { start[i] } else { self.q[i - d] };
                largest = largest.larger(ratio(correction.abs(), state.abs() + x.abs()));
            }
        }
        largest
    }

    /// The increments of the whole step, with momenta that are tangent at its end; returns where that
    /// succeeded.
    fn finish(&self, room: &mut GeneralRoom<S>) -> S::Mask {
        let d = self.q.len();
        let t = self.t + self.h;
        let GeneralRoom { tangent, there, ahead, momentum, end, x, by_q, by_p, .. } = room;
        for (momentum, &by_q) in momentum.iter_mut().zip(&ahead.by_q) {
            *momentum = *momentum - by_q * 0.5;
        }
        let mut is_tangent = self.of.make_tangent([end, momentum], t, tangent, there);
        if let Some(decay) = self.decay {
            momentum.iter_mut().zip(&tangent.moved).for_each(|(p, &moved)| *p = moved * decay);
            is_tangent = is_tangent & self.of.make_tangent([end, momentum], t, tangent, there);
        }
        by_q.copy_from_slice(&x[d..2 * d]);
        for ((by_p, &moved), &p) in by_p.iter_mut().zip(&tangent.moved).zip(self.p) {
            *by_p = moved - p;
        }
        is_tangent
    }
}
