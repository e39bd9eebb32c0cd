//! The manifold of the constraints for users: the distance of a state from it, projections, the multipliers
//! of the exact motion, and whether a step can end on it.

use std::collections::BTreeMap;

use super::evaluation::Multipliers;
use super::flows::{ConstrainedFlows, largest_ratio};
use super::general_manifold::GeneralPoint;
use super::memory::ConstraintScratch;
use super::{Constrained, ConstraintLayout, ConstraintRows, ROUNDINGS};
use crate::algebra::scalar::{Dual, Scalar};
use crate::algebra::state::{State, Vector};
use crate::algebra::state_sum::PlainSum;
use crate::error::StepFailure;
use crate::scheme::elements::{Elements, EvaluationPoint, PairColumns, field};

/// States farther away than this, relative to the terms of the constraints, are no mistake of rounding.
pub(crate) const NEAR: f64 = 1e-6;
/// A constraint whose gradient keeps less than this fraction of its square when those of the constraints
/// before it are taken out follows from these.
pub(super) const DEPENDENT: f64 = 1e-10;
/// The most corrections of a projection.
pub(super) const MOST_CORRECTIONS: u32 = 50;

/// The relative distance of a state from the manifold. It has no unit and does not depend on the units of the
/// system. The terms of a rod far from the origin are much larger than the rod. So the change of the
/// gradients by the first correction of Newton's method counts as a distance of the coordinates, too: it is
/// the correction relative to the radius of curvature.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Distance {
    /// The distance of the coordinates: the largest `|g_k| / Σ_i |∂g_k/∂q_i q_i|`.
    pub coordinates: f64,
    /// The distance of the momenta from the tangent space: the largest
    /// `|dg_k/dt| / (Σ_i |∂g_k/∂q_i dq_i/dt| + |∂g_k/∂t|)`.
    pub momenta: f64,
}

impl Distance {
    /// Whether the distance is more than the rounding of a start that somebody computed.
    pub(crate) fn is_large(self) -> bool {
        let is_small = |distance: f64| distance <= NEAR;
        !(is_small(self.coordinates) && is_small(self.momenta))
    }
}

/// A state as lists.
#[derive(Clone, Copy, Debug)]
pub struct ManifoldPoint<'a> {
    /// Coordinates.
    pub q: &'a [f64],
    /// Momenta.
    pub p: &'a [f64],
    /// Time.
    pub t: f64,
}

/// Projects a state that a polynomial gave; it is NaN where that fails.
pub(crate) fn put_on<V: Vector>(manifold: Option<&dyn Manifold>, state: &mut State<V>) {
    let Some(manifold) = manifold else { return };
    let State { q, p, t } = state;
    if manifold.project(q.components_mut(), p.components_mut(), *t).is_err() {
        q.components_mut().fill(f64::NAN);
        p.components_mut().fill(f64::NAN);
    }
}

/// The manifold of constraints of a system.
pub trait Manifold {
    /// The number of constraints.
    fn constraints(&self) -> usize;

    /// Projects a state: the coordinates along `W Gᵀ`, then the momenta along `Gᵀ`. Returns how far the state
    /// was from the manifold. The state is unchanged on `Err`.
    ///
    /// # Errors
    /// [`StepFailure::Dependent`] if a constraint follows from others there; [`StepFailure::NoProjection`] if
    /// no point of the manifold was found.
    fn project(&self, q: &mut [f64], p: &mut [f64], t: f64) -> Result<Distance, StepFailure>;

    /// The multipliers `λ` of the motion through a state on the manifold, one for each constraint:
    /// `dp/dt = -∂H/∂q + f - Gᵀ λ`, where `d²g/dt² = 0`. `None` where `G W Gᵀ` is singular.
    fn multipliers(&self, q: &[f64], p: &[f64], t: f64) -> Option<Vec<f64>>;

    /// Adds `-Gᵀ λ` to the rates of the momenta, so that motion with these rates of the coordinates, the
    /// momenta and the time stays on the manifold; NaN where `G W Gᵀ` is singular.
    fn constrain_rates(&self, state: ManifoldPoint<'_>, of_q: &[f64], of_p: &mut [f64], of_t: f64);

    /// Projects a deviation of coordinates and momenta, one after the other in a list, on the tangent space
    /// of the manifold at a state on it.
    fn make_tangent(&self, state: ManifoldPoint<'_>, deviation: &mut [f64]);

    /// Why no step of this size ends on the manifold, if that is why: the tangent leaves it farther than it
    /// curves, or the gradients of constraints may become dependent on the way.
    fn too_long(&self, q: &[f64], p: &[f64], t: f64, h: f64) -> Option<StepFailure>;
}

type ManifoldScratch<F, S = f64> = ConstraintScratch<S, <F as Constrained>::Layout, <F as Elements>::Shape>;

/// Scratch with a state, the constraints there, and `W`.
fn scratch_at<F: Constrained, S: Scalar>(
    system: &F,
    q: &[S],
    p: &[S],
    t: S::Constant,
) -> ManifoldScratch<F, S> {
    let mut scratch: ManifoldScratch<F, S> = ConstraintScratch::new(system, q.len(), 0);
    scratch.q.as_mut().copy_from_slice(q);
    scratch.p.as_mut().copy_from_slice(p);
    let flows = ConstrainedFlows { system, parameters: &[] };
    flows.weigh(&mut scratch);
    flows.evaluate_here(&mut scratch, t);
    scratch
}

/// `|(G W p + ∂g/∂t)_k| / Σ_i |G_ki W_i p_i|`, the largest.
fn distance_of_momenta<F: Constrained>(scratch: &mut ManifoldScratch<F>) -> f64 {
    let ConstraintScratch { pattern, here, p, w, velocity, impulses, bounds, .. } = scratch;
    let velocity = velocity.as_mut();
    for ((velocity, p), w) in velocity.iter_mut().zip(p.as_ref()).zip(w.as_ref()) {
        *velocity = w * p;
    }
    let (rates, bounds) = (impulses.as_mut(), bounds.as_mut());
    F::Layout::product(pattern, &here.jacobian, velocity, rates);
    F::Layout::absolute_product(pattern, &here.jacobian, velocity, bounds);
    if F::READ_TIME {
        for ((rate, bound), of_time) in rates.iter_mut().zip(&mut *bounds).zip(here.rates.as_ref()) {
            *rate += of_time;
            *bound += of_time.abs();
        }
    }
    largest_ratio(rates, bounds)
}

/// Evaluates the constraints after the correction `way`; returns how far it turns their gradients: the
/// largest `|Σ_i ΔG_ki way_i| / Σ_i |G_ki way_i|`.
fn turn_by_correction<F: Constrained>(
    flows: &ConstrainedFlows<'_, F, f64>,
    scratch: &mut ManifoldScratch<F>,
    t: f64,
) -> f64 {
    let ConstraintScratch { pattern, here, way, impulses, bounds, .. } = scratch;
    F::Layout::product(pattern, &here.jacobian, way.as_ref(), impulses.as_mut());
    F::Layout::absolute_product(pattern, &here.jacobian, way.as_ref(), bounds.as_mut());
    flows.evaluate_here(scratch, t);
    let ConstraintScratch { pattern, here, way, impulses, corrections, bounds, .. } = scratch;
    F::Layout::product(pattern, &here.jacobian, way.as_ref(), corrections.as_mut());
    for (turned, before) in corrections.as_mut().iter_mut().zip(impulses.as_ref()) {
        *turned -= before;
    }
    largest_ratio(corrections.as_ref(), bounds.as_ref())
}

/// The first constraint that follows from others at the state of the scratch, whose `G W Gᵀ` is factored.
fn dependent<F: Constrained>(scratch: &mut ManifoldScratch<F>) -> Option<usize> {
    let shares = independent_shares::<F>(scratch);
    shares.as_ref().iter().position(|&share| share.is_nan() || share <= DEPENDENT)
}

/// The constraint whose gradient is nearest to those of constraints before it in the elimination, and the
/// share of its square that is independent of them.
fn least_angle(independent_shares: &[f64]) -> Option<(usize, f64)> {
    independent_shares.iter().copied().enumerate().min_by(|(_, a), (_, b)| a.total_cmp(b))
}

/// The share of the square of each gradient that is left when those of constraints before it in the
/// elimination are taken out: pivots of `G W Gᵀ`, which is factored, over its diagonal.
fn independent_shares<F: Constrained>(scratch: &mut ManifoldScratch<F>) -> Multipliers<f64, F::Layout> {
    let ConstraintScratch { pattern, here, factors, w, bounds, corrections, .. } = scratch;
    F::Layout::factor(pattern, &here.jacobian, w.as_ref(), &here.jacobian, factors);
    F::Layout::diagonal(pattern, &here.jacobian, w.as_ref(), bounds.as_mut());
    F::Layout::pivots(pattern, factors, corrections.as_mut());
    let shares = corrections.as_mut().iter_mut().zip(bounds.as_ref());
    // Masses are positive.
    shares.for_each(|(pivot, diagonal)| *pivot /= diagonal.max(0.0));
    corrections.clone()
}

impl<F: Constrained> Manifold for F {
    fn constraints(&self) -> usize {
        Constrained::constraints(self)
    }

    fn project(&self, q: &mut [f64], p: &mut [f64], t: f64) -> Result<Distance, StepFailure> {
        if !F::HAS_SQUARES {
            let mut point = GeneralPoint::new(self, ManifoldPoint { q, p, t });
            let distance = point.project()?;
            let [on_q, on_p] = point.state();
            q.copy_from_slice(on_q);
            p.copy_from_slice(on_p);
            return Ok(distance);
        }
        let flows = ConstrainedFlows { system: self, parameters: &[] };
        let mut scratch = scratch_at(self, q, p, t);
        let mut distance = Distance { coordinates: flows.distance(&mut scratch), momenta: 0.0 };
        let (mut residual, mut before, mut iterations) = (distance.coordinates, f64::INFINITY, 0);
        // Where the constraints are roundings, no correction makes them smaller.
        while !(residual <= ROUNDINGS || (residual <= NEAR * NEAR && residual >= 0.5 * before)) {
            if iterations == MOST_CORRECTIONS || !residual.is_finite() {
                return Err(StepFailure::NoProjection { iterations, residual });
            }
            if let Some(constraint) = dependent::<F>(&mut scratch) {
                return Err(StepFailure::Dependent { constraint });
            }
            let ConstraintScratch { pattern, here, factors, q, way, w, force, corrections, .. } =
                &mut scratch;
            let corrections = corrections.as_mut();
            corrections.copy_from_slice(here.values.as_ref());
            F::Layout::solve(pattern, factors, corrections);
            F::Layout::transposed_product(pattern, &here.jacobian, corrections, force.as_mut());
            for (((q, way), force), w) in
                q.as_mut().iter_mut().zip(way.as_mut()).zip(force.as_ref()).zip(w.as_ref())
            {
                *way = -w * force;
                *q += *way;
            }
            if iterations == 0 {
                distance.coordinates = distance.coordinates.max(turn_by_correction(&flows, &mut scratch, t));
            } else {
                flows.evaluate_here(&mut scratch, t);
            }
            (before, residual) = (residual, flows.distance(&mut scratch));
            iterations += 1;
        }
        if let Some(constraint) = dependent::<F>(&mut scratch) {
            return Err(StepFailure::Dependent { constraint });
        }
        distance.momenta = distance_of_momenta::<F>(&mut scratch);
        // A state on the manifold keeps its bits.
        let is_tangent = distance.momenta <= ROUNDINGS;
        if !is_tangent {
            flows.project::<PlainSum>(&mut scratch);
        }
        if !scratch.p.as_ref().iter().all(|p| p.is_finite()) {
            return Err(StepFailure::NonFinite);
        }
        q.copy_from_slice(scratch.q.as_ref());
        p.copy_from_slice(scratch.p.as_ref());
        Ok(distance)
    }

    fn multipliers(&self, q: &[f64], p: &[f64], t: f64) -> Option<Vec<f64>> {
        if !F::HAS_SQUARES {
            let point = GeneralPoint::new(self, ManifoldPoint { q, p, t });
            let [of_q, mut of_p] = point.free_rates();
            of_p.iter_mut().zip(p).for_each(|(rate, p)| *rate -= friction_rate(self) * p);
            return point.multipliers(&of_q, &of_p, 1.0);
        }
        let mut scratch = scratch_at(self, q, p, t);
        if dependent::<F>(&mut scratch).is_some() {
            return None;
        }
        let mut of_p = vec![0.0; q.len()];
        let of_q: Vec<f64> = p.iter().zip(scratch.w.as_ref()).map(|(p, w)| w * p).collect();
        let at = ([t, 1.0], [q, p], &[][..]);
        field::<F, f64, true, false>((self, &[]), at, [&mut of_p, &mut []], &mut PairColumns::default());
        let rate: f64 = if F::FACTS.kind.is_conformal { Elements::friction_rate(self, &[]) } else { 0.0 };
        of_p.iter_mut().zip(p).for_each(|(slope, p)| *slope = -*slope - rate * p);
        Some(impulse_rates(self, &mut scratch, t, &of_q, &of_p, 1.0).as_ref().to_vec())
    }

    fn constrain_rates(&self, state: ManifoldPoint<'_>, of_q: &[f64], of_p: &mut [f64], of_t: f64) {
        if !F::HAS_SQUARES {
            return GeneralPoint::new(self, state).constrain(of_q, of_p, of_t);
        }
        let ManifoldPoint { q, p, t } = state;
        let mut scratch = scratch_at(self, q, p, t);
        if dependent::<F>(&mut scratch).is_some() {
            return of_p.fill(f64::NAN);
        }
        let lambda = impulse_rates(self, &mut scratch, t, of_q, of_p, of_t);
        let ConstraintScratch { pattern, here, force, .. } = &mut scratch;
        F::Layout::transposed_product(pattern, &here.jacobian, lambda.as_ref(), force.as_mut());
        of_p.iter_mut().zip(force.as_ref()).for_each(|(rate, force)| *rate -= force);
    }

    fn make_tangent(&self, state: ManifoldPoint<'_>, deviation: &mut [f64]) {
        let ManifoldPoint { q, p, t } = state;
        if !F::HAS_SQUARES {
            let (of_q, of_p) = deviation.split_at_mut(q.len());
            return GeneralPoint::new(self, state).make_tangent(of_q, of_p);
        }
        let mut scratch = scratch_at(self, q, p, t);
        let is_singular = dependent::<F>(&mut scratch).is_some();
        let (of_q, of_p) = deviation.split_at_mut(q.len());
        let ConstraintScratch { pattern, here, factors, w, force, corrections, .. } = &mut scratch;
        let normal = corrections.as_mut();
        F::Layout::product(pattern, &here.jacobian, of_q, normal);
        F::Layout::solve(pattern, factors, normal);
        F::Layout::transposed_product(pattern, &here.jacobian, normal, force.as_mut());
        for ((x, force), w) in of_q.iter_mut().zip(force.as_ref()).zip(w.as_ref()) {
            *x -= w * force;
        }
        // `G W p` stays zero along the deviation as it does along a motion with these rates.
        let normal = impulse_rates(self, &mut scratch, t, of_q, of_p, 0.0);
        let ConstraintScratch { pattern, here, force, .. } = &mut scratch;
        F::Layout::transposed_product(pattern, &here.jacobian, normal.as_ref(), force.as_mut());
        of_p.iter_mut().zip(force.as_ref()).for_each(|(x, force)| *x -= force);
        if is_singular {
            deviation.fill(f64::NAN);
        }
    }

    fn too_long(&self, q: &[f64], p: &[f64], t: f64, h: f64) -> Option<StepFailure> {
        let mut velocity = vec![0.0; q.len()];
        let at = ([t, 1.0], [q, p], &[][..]);
        let into = [&mut vec![0.0; q.len()][..], &mut velocity];
        field::<F, f64, true, true>((self, &[]), at, into, &mut PairColumns::default());
        let w = inverse_masses(self, q, p, t);
        let normals = ManifoldNormals::at(self, q, t);
        let end: Vec<f64> = q.iter().zip(&velocity).map(|(q, v)| q + h * v).collect();
        let there = ManifoldNormals::at(self, &end, t + h);
        let lengths = there.values.iter().enumerate().map(|(constraint, value)| {
            let (mut speed, mut energy, mut normal) = (0.0, 0.0, 0.0);
            for (coordinate, slope) in normals.of(constraint) {
                let (v, w) = (velocity[coordinate], w[coordinate]);
                (speed, energy, normal) = (speed + v * v, energy + v * v / w, normal + slope * slope * w);
            }
            // In the metric of the masses, coordinates may have different units.
            let (length, share) = (h.abs() * speed.sqrt(), h.abs() * (energy * normal).sqrt());
            [length, 0.5 * length * share / value.abs()]
        });
        let worst = lengths.enumerate().max_by(|(_, a), (_, b)| (a[0] / a[1]).total_cmp(&(b[0] / b[1])));
        let (constraint, [length, radius]) = worst?;
        if !(length.is_finite() && radius.is_finite()) {
            return None;
        }
        // Below half of the radius the tangent is no cause.
        if length > 0.5 * radius {
            return Some(StepFailure::BeyondCurvature { constraint, length, radius });
        }
        // The square of the sine of the least angle between a gradient and those before it. Both turn by at
        // most the angle `length / radius` within the step.
        let turn = 2.0 * length / radius;
        let nearest = match F::HAS_SQUARES {
            true => least_angle(independent_shares::<F>(&mut scratch_at(self, q, p, t)).as_ref()),
            false => least_angle(GeneralPoint::new(self, ManifoldPoint { q, p, t }).independent_shares()),
        };
        let (constraint, square) = nearest?;
        (square <= turn * turn).then_some(StepFailure::Dependent { constraint })
    }
}

/// The rate of friction that steps include.
fn friction_rate<F: Constrained>(system: &F) -> f64 {
    if F::FACTS.kind.is_conformal { Elements::friction_rate(system, &[]) } else { 0.0 }
}

/// `λ` at the state of the scratch, whose `G W Gᵀ` is factored, for motion with these rates without
/// constraints: the derivative of `G W p + ∂g/∂t` along it, by a dual number, is `G W Gᵀ λ`.
fn impulse_rates<F: Constrained>(
    system: &F,
    scratch: &mut ManifoldScratch<F>,
    t: f64,
    of_q: &[f64],
    of_p: &[f64],
    of_t: f64,
) -> Multipliers<f64, F::Layout> {
    let moved = |x: &[f64], rates: &[f64]| -> Vec<Dual<1>> {
        x.iter().zip(rates).map(|(&value, &rate)| Dual { value, derivative: [rate] }).collect()
    };
    let (q, p) = (moved(scratch.q.as_ref(), of_q), moved(scratch.p.as_ref(), of_p));
    let there: ManifoldScratch<F, Dual<1>> =
        scratch_at(system, &q, &p, Dual { value: t, derivative: [of_t] });
    let ConstraintScratch { pattern, here, w, .. } = &there;
    let velocity: Vec<Dual<1>> = p.iter().zip(w.as_ref()).map(|(&p, &w)| w * p).collect();
    let mut rates = vec![Dual::<1>::from_f64(0.0); Constrained::constraints(system)];
    F::Layout::product(pattern, &here.jacobian, &velocity, &mut rates);
    let ConstraintScratch { pattern, factors, corrections, .. } = scratch;
    let lambda = corrections.as_mut();
    for ((lambda, rate), of_time) in lambda.iter_mut().zip(&rates).zip(here.rates.as_ref()) {
        *lambda = rate.derivative[0] + if F::READ_TIME { of_time.derivative[0] } else { 0.0 };
    }
    F::Layout::solve(pattern, factors, lambda);
    corrections.clone()
}

/// The diagonal of `∂²H_0/∂p²`.
fn inverse_masses<F: Constrained>(system: &F, q: &[f64], p: &[f64], t: f64) -> Vec<f64> {
    match F::HAS_SQUARES {
        true => scratch_at(system, q, p, t).w.as_ref().to_vec(),
        false => GeneralPoint::new(system, ManifoldPoint { q, p, t }).inverse_masses(),
    }
}

/// The constraints at a point, and their slopes by the coordinates that they read.
struct ManifoldNormals {
    values: Vec<f64>,
    /// By constraint and coordinate.
    slopes: BTreeMap<[usize; 2], f64>,
}

impl ManifoldNormals {
    fn at<F: Constrained>(system: &F, q: &[f64], t: f64) -> Self {
        let values = vec![0.0; Constrained::constraints(system)];
        let mut normals = Self { values, slopes: BTreeMap::new() };
        system.constrain(&EvaluationPoint::new([q, &[][..]], t, &[], &[]), &mut normals);
        normals
    }

    /// The coordinates that a constraint reads, and its slopes.
    fn of(&self, constraint: usize) -> impl Iterator<Item = (usize, f64)> {
        let places = [constraint, 0]..[constraint + 1, 0];
        self.slopes.range(places).map(|(&[_, coordinate], &slope)| (coordinate, slope))
    }
}

impl ConstraintRows<f64> for ManifoldNormals {
    fn value(&mut self, constraint: usize, value: f64) {
        self.values[constraint] += value;
    }

    fn slope(&mut self, constraint: usize, coordinate: usize, slope: f64) {
        *self.slopes.entry([constraint, coordinate]).or_default() += slope;
    }

    fn rate(&mut self, _: usize, _: f64) {}
}
