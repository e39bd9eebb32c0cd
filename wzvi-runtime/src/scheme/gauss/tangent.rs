//! The derivative of a step that was taken, from its derivatives.
//!
//! With the second derivatives `F''_j` of `b_j F` at stage `j`, deviations of the stages solve the linear
//! equations
//!
//! ```text
//! δQ_i - Σ_j μ_ij (F_pq δQ + F_pp δP)_j = δq,   δP_i + Σ_j μ_ij (F_qq δQ + F_qp δP)_j = δp
//! δq' = δq + Σ_j (F_pq δQ + F_pp δP)_j,         δp' = δp - Σ_j (F_qq δQ + F_qp δP)_j
//! ```
//!
//! and in Nyström form, with half as many unknowns and the velocity `v = h M⁻¹ δp`,
//!
//! ```text
//! δQ_i + Σ_j η_ij h M⁻¹ (F_qq δQ)_j = δq + c_i v,   δq' = δq + v - Σ_j (1 - c_j) h M⁻¹ (F_qq δQ)_j
//! ```
//!
//! One matrix serves all deviations. It is factored without exchanges of rows, so that nothing in it
//! branches: that is stable where its rows are dominated by their diagonals, as in steps that resolve their
//! motion. Other steps are differentiated by [`newton`](super::newton).
#![expect(clippy::needless_range_loop, reason = "plain loops over arrays are what becomes vector code")]

use super::Field;
use super::advance::GaussConstantsOf;
use super::equations::StepEquations;
use super::memory::{GaussMemory, GaussMemoryOf};
use super::stages::Stages;
use super::stiff::inverse_mass;
use crate::algebra::lanes::Lanes;
use crate::algebra::lanes::instructions::Kernel;
use crate::algebra::scalar::{Dual, Mask, Scalar};
use crate::algebra::state_sum::PlainSum;
use crate::scheme::elements::PairColumns;
use crate::scheme::system::{DEVIATIONS, TakenStep};

/// The most unknowns for which all columns together take the time of a few steps.
const MOST_UNKNOWNS: usize = 64;
/// The largest sum of the entries of a row, beside the identity: below that, elimination without exchanges
/// is stable (N. J. Higham, *Accuracy and Stability of Numerical Algorithms*, section 9.5).
const DOMINATED: f64 = 1.0;
/// Directions in which derivatives are differentiated at once.
const DIRECTIONS: usize = 2;

/// A component of each deviation.
type DeviationLanes = Lanes<DEVIATIONS>;

/// Coordinates, momenta, derivatives by both, and increments, with derivatives in some directions.
type VariedStep<T> = [Vec<Dual<DIRECTIONS, T>>; 5];

/// The linear equations of a step, and what they are made of.
#[derive(Debug, Default)]
pub(super) struct Linear<const N: usize> {
    /// Whether the matrix of the present step is factored.
    is_factored: bool,
    of_all_stages: VariedStep<Lanes<N>>,
    of_one_stage: VariedStep<f64>,
    columns: PairColumns,
    /// `M⁻¹` by rows, in Nyström form.
    inverse_mass: Vec<f64>,
    /// Second derivatives of `b_j F` at all stages, by rows: derivatives by `(q, p)`, then unknowns.
    hessian: Vec<Lanes<N>>,
    /// The coefficients of the deviations of the stages in the equations of each unknown: in Nyström form
    /// `h M⁻¹ F_qq`, else `-F_p` and `F_q`.
    products: Vec<Lanes<N>>,
    /// The matrix by rows, then its upper factor. Unknowns are stage after stage of each kind and degree of
    /// freedom.
    rows: Vec<Lanes<N>>,
    /// The lower factor by columns, below its diagonal.
    lower: Vec<f64>,
    /// The reciprocals of the pivots.
    inverses: Vec<f64>,
    /// The right-hand sides, then the deviations of the stages.
    sides: Vec<DeviationLanes>,
    /// `h M⁻¹ δp`
    velocities: Vec<DeviationLanes>,
}

/// Multiplies deviations by the derivative of a step.
struct Multiply<'a, F: Field, const N: usize> {
    system: &'a F,
    prepared: &'a GaussConstantsOf<F, f64, N>,
    taken: TakenStep<'a, GaussMemoryOf<F, f64, N>>,
    room: &'a mut GaussMemoryOf<F, f64, N>,
    linear: &'a mut Linear<N>,
    deviations: [&'a mut [Dual<DEVIATIONS>]; 2],
}

/// Multiplies deviations by the derivative of a step. False, with nothing done, for many unknowns and for a
/// matrix that is not dominated by its diagonal. `room` is scratch, and keeps the factors for further
/// deviations.
pub(super) fn multiply<F: Field, const N: usize>(
    system: &F,
    prepared: &GaussConstantsOf<F, f64, N>,
    taken: TakenStep<'_, GaussMemoryOf<F, f64, N>>,
    room: &mut GaussMemoryOf<F, f64, N>,
    deviations: [&mut [Dual<DEVIATIONS>]; 2],
) -> bool {
    let degrees = deviations[0].len();
    if degrees * N * kinds::<F>() > MOST_UNKNOWNS || !taken.memory.left.has_slopes(degrees) {
        return false;
    }
    let mut linear = room.left.linear.take().unwrap_or_default();
    let kernel = Multiply { system, prepared, taken, room: &mut *room, linear: &mut linear, deviations };
    let is_done = prepared.common.instructions().run(kernel);
    room.left.linear = Some(linear);
    is_done
}

/// Unknowns of a stage for each degree of freedom.
const fn kinds<F: Field>() -> usize {
    if F::IS_NYSTROM { 1 } else { 2 }
}

impl<F: Field, const N: usize> Kernel for Multiply<'_, F, N> {
    type Output = bool;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run<const L: usize, const HALF: usize>(self) -> bool {
        let Self { system, prepared, taken, room, linear, deviations } = self;
        let table = prepared.common.table();
        // A constant where it is known: loops have constant bounds then.
        let degrees = if F::FACTS.degrees == usize::MAX { deviations[0].len() } else { F::FACTS.degrees };
        let unknowns = kinds::<F>() * degrees;
        let coefficients = if F::IS_NYSTROM { &table.eta } else { &table.mu };
        linear.is_factored &= !taken.is_first;
        if !linear.is_factored {
            linearise(system, prepared, &taken, room, linear, degrees);
            if !linear.is_dominated(coefficients, unknowns) {
                return false;
            }
            linear.assemble(coefficients, unknowns);
            linear.factor(unknowns);
            linear.is_factored = true;
        }
        linear.follow::<F>(&table.c, taken.h, deviations, degrees, 1.0 + prepared.friction.decay);
        true
    }
}

/// The second derivatives at the stages of a step, and their products in its equations.
#[cfg_attr(not(debug_assertions), inline(always))]
fn linearise<F: Field, const N: usize>(
    system: &F,
    prepared: &GaussConstantsOf<F, f64, N>,
    taken: &TakenStep<'_, GaussMemoryOf<F, f64, N>>,
    room: &mut GaussMemoryOf<F, f64, N>,
    linear: &mut Linear<N>,
    degrees: usize,
) {
    room.fit(degrees, taken.dw.len());
    let GaussMemory { given, lists, left } = room;
    given.read(&prepared.common, taken.q, taken.p, taken.dw, &PlainSum);
    let step =
        given.step(system, (&prepared.parameters, &prepared.friction, &prepared.common), [taken.t, taken.h]);
    for (own, past) in lists.slopes.iter_mut().zip(&taken.memory.left.past) {
        own.as_mut().copy_from_slice(past.as_ref());
    }
    if F::FACTS.kind.is_conformal {
        // They are stored in the momentum of the next step.
        let back = [(1.0 + prepared.friction.decay).recip(); N];
        lists.slopes[1].as_mut().iter_mut().for_each(|slopes| *slopes = slopes.times(&back));
    }
    step.follow(lists, &mut left.scratch, None);
    let at = [lists.at[0].as_ref(), lists.at[1].as_ref()];
    let unknowns = kinds::<F>() * degrees;
    linear.hessian.resize(2 * degrees * unknowns, Lanes::default());
    linear.products.resize(unknowns * unknowns, Lanes::default());
    let mut first = 0;
    while first < unknowns {
        let Linear { of_all_stages, of_one_stage, columns, hessian, .. } = &mut *linear;
        if F::IN_LANES {
            step.differentiate_slopes(at, 0, first, of_all_stages, columns);
            keep_columns(hessian, of_all_stages, 0, first, degrees, unknowns);
        } else {
            for stage in 0..N {
                step.differentiate_slopes(at, stage, first, of_one_stage, columns);
                keep_columns(hessian, of_one_stage, stage, first, degrees, unknowns);
            }
        }
        first += DIRECTIONS;
    }
    if F::IS_NYSTROM && linear.inverse_mass.is_empty() {
        linear.inverse_mass =
            inverse_mass(system, &prepared.parameters, degrees).transpose().as_slice().to_vec();
    }
    linear.multiply_hessian(taken.h, degrees, F::IS_NYSTROM);
}

/// A number of the stages at which derivatives are differentiated at once: all in lanes, or a single one.
trait StageNumber<const N: usize>: Scalar {
    /// From the numbers of all stages; of a single one, that of this number.
    fn of_stage(all: Lanes<N>, stage: usize) -> Self;
    /// Writes it there.
    fn store(self, all: &mut Lanes<N>, stage: usize);
}

impl<const N: usize> StageNumber<N> for Lanes<N> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of_stage(all: Self, _stage: usize) -> Self {
        all
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn store(self, all: &mut Self, _stage: usize) {
        *all = self;
    }
}

impl<const N: usize> StageNumber<N> for f64 {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of_stage(all: Lanes<N>, stage: usize) -> Self {
        all[stage]
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn store(self, all: &mut Lanes<N>, stage: usize) {
        all.set(stage, self);
    }
}

impl<F: Field, const N: usize> StepEquations<'_, F, f64, f64, N> {
    /// The derivatives of `b_j F` at all stages or at one, differentiated by the unknown number `first` and
    /// those after it.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn differentiate_slopes<T: StageNumber<N>>(
        &self,
        at: [&[Lanes<N>]; 2],
        stage: usize,
        first: usize,
        varied: &mut VariedStep<T>,
        columns: &mut PairColumns,
    ) {
        let (table, degrees) = (self.common.table(), at[0].len());
        let [weights, c] = [table.b, table.c].map(|list| Lanes::new(list) * self.h);
        let [times, weights] = [c + self.t, weights].map(|all| Dual::constant(T::of_stage(all, stage)));
        let [q, p, by_q, by_p, dw] = varied;
        for list in [&mut *q, p, by_q, by_p] {
            list.resize(degrees, Dual::default());
        }
        dw.resize(self.dw.len(), Dual::default());
        for (own, all) in dw.iter_mut().zip(self.dw) {
            *own = Dual::constant(T::of_stage(*all, stage));
        }
        let (q, p) = (&mut q[..degrees], &mut p[..degrees]);
        let (by_q, by_p) = (&mut by_q[..degrees], &mut by_p[..degrees]);
        let friction = [self.friction.inverse, self.friction.scale];
        let [inverse, scale] = friction.map(|list| T::of_stage(Lanes::new(list), stage));
        for d in 0..degrees {
            q[d] = Dual::variable(T::of_stage(at[0][d], stage), d.wrapping_sub(first));
            p[d] = Dual::variable(T::of_stage(at[1][d], stage), (degrees + d).wrapping_sub(first));
            if F::FACTS.kind.is_conformal {
                p[d] = times_value(p[d], inverse);
            }
        }
        let (system, parameters) = (self.system, self.parameters);
        if F::IS_NYSTROM {
            let (given, into) = (([times, weights], [&q[..], &q[..]], &dw[..]), [&mut by_q[..], &mut []]);
            system.step_gradient::<f64, Dual<DIRECTIONS, T>, true, false>(parameters, given, into, columns);
        } else {
            let (given, into) =
                (([times, weights], [&q[..], &p[..]], &dw[..]), [&mut by_q[..], &mut by_p[..]]);
            system.step_gradient::<f64, Dual<DIRECTIONS, T>, true, true>(parameters, given, into, columns);
        }
        if F::FACTS.kind.is_conformal {
            for slope in by_q {
                *slope = times_value(*slope, scale);
            }
        }
    }
}

/// A number times one without derivatives.
#[cfg_attr(not(debug_assertions), inline(always))]
fn times_value<T: Scalar>(number: Dual<DIRECTIONS, T>, factor: T) -> Dual<DIRECTIONS, T> {
    let mut derivative = number.derivative;
    for own in &mut derivative {
        *own = *own * factor;
    }
    Dual { value: number.value * factor, derivative }
}

/// Keeps second derivatives at all stages or at one: columns `first` and those after it.
#[cfg_attr(not(debug_assertions), inline(always))]
fn keep_columns<T: StageNumber<N>, const N: usize>(
    hessian: &mut [Lanes<N>],
    varied: &VariedStep<T>,
    stage: usize,
    first: usize,
    degrees: usize,
    unknowns: usize,
) {
    let [_, _, by_q, by_p, _] = varied;
    let hessian = &mut hessian[..2 * degrees * unknowns];
    let halves = if unknowns == degrees { 1 } else { 2 };
    for half in 0..halves {
        let slopes = if half == 0 { &by_q[..degrees] } else { &by_p[..degrees] };
        for d in 0..degrees {
            let row = (half * degrees + d) * unknowns;
            for number in 0..DIRECTIONS.min(unknowns - first) {
                slopes[d].derivative[number].store(&mut hessian[row + first + number], stage);
            }
        }
    }
}

impl<const N: usize> Linear<N> {
    /// The products of second derivatives that multiply deviations in the equations.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn multiply_hessian(&mut self, h: f64, degrees: usize, is_nystrom: bool) {
        let unknowns = if is_nystrom { degrees } else { 2 * degrees };
        let products = &mut self.products[..unknowns * unknowns];
        let hessian = &self.hessian[..2 * degrees * unknowns];
        if is_nystrom {
            let inverse_mass = &self.inverse_mass[..degrees * degrees];
            for a in 0..degrees {
                for b in 0..degrees {
                    let mut sum = Lanes::default();
                    for k in 0..degrees {
                        let mobility = inverse_mass[a * degrees + k];
                        if mobility != 0.0 {
                            sum = sum + hessian[k * degrees + b] * (h * mobility);
                        }
                    }
                    products[a * degrees + b] = sum;
                }
            }
            return;
        }
        let half = 2 * degrees * degrees;
        for i in 0..half {
            products[i] = -hessian[half + i];
            products[half + i] = hessian[i];
        }
    }

    /// Whether each diagonal entry of the matrix, which is that of the identity plus another, is larger than
    /// all others of its row together.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn is_dominated(&self, coefficients: &[[f64; N]; N], unknowns: usize) -> bool {
        let mut largest = Lanes::<N>::default();
        for row in self.products.chunks_exact(unknowns) {
            let mut sum = Lanes::default();
            for product in row {
                sum = sum + product.abs();
            }
            largest = Scalar::select(sum.less(largest), largest, sum);
        }
        let mut sums = Lanes::<N>::default();
        for j in 0..N {
            sums = sums + Lanes::new(coefficients[j]).abs() * largest[j];
        }
        sums.less(Lanes::from_f64(DOMINATED)).all()
    }

    /// Writes the matrix.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn assemble(&mut self, coefficients: &[[f64; N]; N], unknowns: usize) {
        self.rows.resize(N * unknowns * unknowns, Lanes::default());
        let (rows, products) =
            (&mut self.rows[..N * unknowns * unknowns], &self.products[..unknowns * unknowns]);
        // The rows of stage `i`, by the stages.
        let mut by_rows = [Lanes::default(); N];
        for i in 0..N {
            let mut own = [0.0; N];
            for j in 0..N {
                own[j] = coefficients[j][i];
            }
            by_rows[i] = Lanes::new(own);
        }
        for a in 0..unknowns {
            for i in 0..N {
                let own = &mut rows[(a * N + i) * unknowns..][..unknowns];
                for b in 0..unknowns {
                    own[b] = products[a * unknowns + b] * by_rows[i];
                }
                let diagonal = own[a][i];
                own[a].set(i, diagonal + 1.0);
            }
        }
    }

    /// `L U`. Whole lists of stages are subtracted, of which those before the pivot are not read again.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn factor(&mut self, unknowns: usize) {
        let size = N * unknowns;
        self.inverses.resize(size, 0.0);
        self.lower.resize(size * size, 0.0);
        let rows = &mut self.rows[..size * unknowns];
        let (lower, inverses) = (&mut self.lower[..size * size], &mut self.inverses[..size]);
        for a in 0..unknowns {
            for i in 0..N {
                let k = a * N + i;
                let (above, below) = rows.split_at_mut((k + 1) * unknowns);
                let own = &above[k * unknowns..];
                let inverse = own[a][i].recip();
                inverses[k] = inverse;
                let factors = &mut lower[k * size + k + 1..(k + 1) * size];
                for row in 0..factors.len() {
                    let other = &mut below[row * unknowns..][..unknowns];
                    let factor = other[a][i] * inverse;
                    factors[row] = factor;
                    for b in a..unknowns {
                        other[b] = other[b] - own[b] * factor;
                    }
                }
            }
        }
    }

    /// The sides become the solution.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn solve(&mut self, unknowns: usize) {
        let size = N * unknowns;
        let (rows, lower) = (&self.rows[..size * unknowns], &self.lower[..size * size]);
        let (inverses, sides) = (&self.inverses[..size], &mut self.sides[..size]);
        for k in 0..size {
            let (own, factors) = (sides[k], &lower[k * size..(k + 1) * size]);
            for row in k + 1..size {
                sides[row] = sides[row] - own * factors[row];
            }
        }
        for a in (0..unknowns).rev() {
            for i in (0..N).rev() {
                let k = a * N + i;
                let own = &rows[k * unknowns..][..unknowns];
                // Two sums, so that fewer operations wait for each other.
                let mut sums = [sides[k], Lanes::default()];
                for j in i + 1..N {
                    sums[j % 2] = sums[j % 2] - sides[a * N + j] * own[a][j];
                }
                for b in a + 1..unknowns {
                    for j in 0..N {
                        sums[j % 2] = sums[j % 2] - sides[b * N + j] * own[b][j];
                    }
                }
                sides[k] = (sums[0] + sums[1]) * inverses[k];
            }
        }
    }

    /// Takes a step of deviations. `left`: what friction leaves of a momentum.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn follow<F: Field>(
        &mut self,
        c: &[f64; N],
        h: f64,
        [q, p]: [&mut [Dual<DEVIATIONS>]; 2],
        degrees: usize,
        left: f64,
    ) {
        let unknowns = kinds::<F>() * degrees;
        let (q, p) = (&mut q[..degrees], &mut p[..degrees]);
        self.sides.resize(N * unknowns, Lanes::default());
        self.velocities.resize(degrees, Lanes::default());
        if F::IS_NYSTROM {
            let inverse_mass = &self.inverse_mass[..degrees * degrees];
            for a in 0..degrees {
                let mut velocity = Lanes::default();
                for b in 0..degrees {
                    let mobility = inverse_mass[a * degrees + b];
                    if mobility != 0.0 {
                        velocity = velocity + Lanes::new(p[b].derivative) * (h * mobility);
                    }
                }
                self.velocities[a] = velocity;
            }
        }
        for a in 0..unknowns {
            let start = Lanes::new(if a < degrees { q[a].derivative } else { p[a - degrees].derivative });
            let sides = &mut self.sides[a * N..][..N];
            for i in 0..N {
                sides[i] = if F::IS_NYSTROM { start + self.velocities[a] * c[i] } else { start };
            }
        }
        self.solve(unknowns);
        let (products, hessian) =
            (&self.products[..unknowns * unknowns], &self.hessian[..unknowns * unknowns]);
        let (sides, velocities) = (&self.sides[..N * unknowns], &self.velocities[..degrees]);
        for a in 0..unknowns {
            if F::IS_NYSTROM {
                let (mut place, mut momentum) =
                    (Lanes::new(q[a].derivative) + velocities[a], Lanes::new(p[a].derivative));
                for b in 0..degrees {
                    let (force, product) = (hessian[a * degrees + b], products[a * degrees + b]);
                    for j in 0..N {
                        momentum = momentum - sides[b * N + j] * force[j];
                        place = place - sides[b * N + j] * ((1.0 - c[j]) * product[j]);
                    }
                }
                (q[a].derivative, p[a].derivative) = (place.to_array(), momentum.to_array());
                continue;
            }
            let own = if a < degrees { &mut q[a] } else { &mut p[a - degrees] };
            let mut sum = Lanes::new(own.derivative);
            for b in 0..unknowns {
                let product = products[a * unknowns + b];
                for j in 0..N {
                    sum = sum - sides[b * N + j] * product[j];
                }
            }
            if F::FACTS.kind.is_conformal && a >= degrees {
                sum = sum * left;
            }
            own.derivative = sum.to_array();
        }
    }
}
