//! The manifold of a system with any Hamiltonian, by dense matrices: as [`Manifold`](super::Manifold).

use super::flows::largest_ratio;
use super::general::{DenseMatrix, GeneralConstraints, GeneralField, StepPoint, TangentRoom};
use super::manifold::{DEPENDENT, Distance, MOST_CORRECTIONS, ManifoldPoint, NEAR};
use super::{Constrained, ROUNDINGS};
use crate::algebra::scalar::Dual;
use crate::error::StepFailure;

/// A state, the constraints there, and the matrix `G H_pp Gᵀ`.
pub(super) struct GeneralPoint<'a, F> {
    of: GeneralField<'a, F, f64>,
    q: Vec<f64>,
    p: Vec<f64>,
    t: f64,
    constraints: GeneralConstraints<f64>,
    /// Its factors.
    matrix: DenseMatrix<f64>,
    /// The share of the square of each gradient that is left when those before it are taken out.
    independent_shares: Vec<f64>,
}

impl<'a, F: Constrained> GeneralPoint<'a, F> {
    pub(super) fn new(system: &'a F, ManifoldPoint { q, p, t }: ManifoldPoint<'_>) -> Self {
        let of = GeneralField { system, parameters: &[] };
        let (q, p, constraints) = (q.to_vec(), p.to_vec(), GeneralConstraints::default());
        let mut point =
            Self { of, q, p, t, constraints, matrix: DenseMatrix::default(), independent_shares: Vec::new() };
        point.evaluate();
        point
    }

    fn at(&self) -> StepPoint<'_, f64> {
        StepPoint { q: &self.q, p: &self.p, t: self.t, h: 1.0, dw: &[] }
    }

    fn evaluate(&mut self) {
        let mut constraints = std::mem::take(&mut self.constraints);
        constraints.evaluate(&self.of, &self.q, self.t);
        let mut matrix = std::mem::take(&mut self.matrix);
        self.of.normal_matrix(&self.at(), &constraints, &mut matrix);
        let number = constraints.values.len();
        let diagonal: Vec<f64> = (0..number).map(|k| matrix.at(k, k)).collect();
        matrix.factor();
        // Masses are positive.
        let shares = diagonal.iter().enumerate().map(|(k, diagonal)| matrix.at(k, k) / diagonal.max(0.0));
        self.independent_shares = shares.collect();
        (self.constraints, self.matrix) = (constraints, matrix);
    }

    pub(super) fn independent_shares(&self) -> &[f64] {
        &self.independent_shares
    }

    /// The first constraint that follows from others.
    fn dependent(&self) -> Option<usize> {
        self.independent_shares.iter().position(|&share| {
            let is_pivot = share > DEPENDENT;
            !is_pivot
        })
    }

    fn distance_of_coordinates(&self) -> f64 {
        let mut bounds = vec![0.0; self.constraints.values.len()];
        self.constraints.absolute_product(&self.q, &mut bounds);
        largest_ratio(&self.constraints.values, &bounds)
    }

    /// Projects the state, as [`Manifold::project`](super::Manifold::project).
    ///
    /// # Errors
    /// [`StepFailure::Dependent`], [`StepFailure::NoProjection`], as there.
    pub(super) fn project(&mut self) -> Result<Distance, StepFailure> {
        let mut distance = Distance { coordinates: self.distance_of_coordinates(), momenta: 0.0 };
        let (mut residual, mut before, mut iterations) = (distance.coordinates, f64::INFINITY, 0);
        while !(residual <= ROUNDINGS || (residual <= NEAR * NEAR && residual >= 0.5 * before)) {
            if iterations == MOST_CORRECTIONS || !residual.is_finite() {
                return Err(StepFailure::NoProjection { iterations, residual });
            }
            if let Some(constraint) = self.dependent() {
                return Err(StepFailure::Dependent { constraint });
            }
            let mut impulses = self.constraints.values.clone();
            self.matrix.solve(&mut impulses);
            let mut along = vec![0.0; self.q.len()];
            self.constraints.subtract_transposed(&impulses, &mut along);
            let mut way = vec![0.0; self.q.len()];
            self.of.masses(&self.at(), |i, j, w| way[i] += w * along[j]);
            let number = impulses.len();
            let (mut turned, mut straight, mut bounds) =
                (vec![0.0; number], vec![0.0; number], vec![0.0; number]);
            self.constraints.product(&way, &mut straight);
            self.constraints.absolute_product(&way, &mut bounds);
            self.q.iter_mut().zip(&way).for_each(|(q, way)| *q += way);
            self.evaluate();
            if iterations == 0 {
                self.constraints.product(&way, &mut turned);
                turned.iter_mut().zip(&straight).for_each(|(turned, straight)| *turned -= straight);
                distance.coordinates = distance.coordinates.max(largest_ratio(&turned, &bounds));
            }
            (before, residual) = (residual, self.distance_of_coordinates());
            iterations += 1;
        }
        if let Some(constraint) = self.dependent() {
            return Err(StepFailure::Dependent { constraint });
        }
        let mut room = TangentRoom::default();
        let number = self.constraints.values.len();
        let (mut rates, mut bounds) = (vec![0.0; number], vec![0.0; number]);
        let TangentRoom { gradient, columns, .. } = &mut room;
        self.of.rates(&self.at(), &self.constraints, gradient, columns, &mut rates);
        self.constraints.absolute_product(&gradient.by_p, &mut bounds);
        bounds.iter_mut().zip(&self.constraints.rates).for_each(|(bound, rate)| *bound += rate.abs());
        distance.momenta = largest_ratio(&rates, &bounds);
        // A state on the manifold keeps its bits.
        let is_tangent = distance.momenta <= ROUNDINGS;
        if !is_tangent {
            let is_projected = self.of.make_tangent([&self.q, &self.p], self.t, &mut room, &self.constraints);
            if !is_projected {
                return Err(StepFailure::NoProjection { iterations, residual: distance.momenta });
            }
            self.p = room.moved;
        }
        Ok(distance)
    }

    /// The coordinates and the momenta.
    pub(super) fn state(&self) -> [&[f64]; 2] {
        [&self.q, &self.p]
    }

    /// The diagonal of `∂²H_0/∂p²`.
    pub(super) fn inverse_masses(&self) -> Vec<f64> {
        let mut diagonal = vec![0.0; self.q.len()];
        self.of.masses(&self.at(), |i, j, value| {
            if i == j {
                diagonal[i] += value;
            }
        });
        diagonal
    }

    /// The rates of the motion of `H_0` without constraints: `∂H_0/∂p`, and `-∂H_0/∂q + f`.
    pub(super) fn free_rates(&self) -> [Vec<f64>; 2] {
        let mut room = TangentRoom::default();
        self.of.gradient(&self.at(), &mut room.gradient, &mut room.columns);
        [room.gradient.by_p, room.gradient.by_q.iter().map(|slope| -slope).collect()]
    }

    /// `λ` of motion with these rates; `None` where constraints depend on each other.
    pub(super) fn multipliers(&self, of_q: &[f64], of_p: &[f64], of_t: f64) -> Option<Vec<f64>> {
        if self.dependent().is_some() {
            return None;
        }
        let moved = |x: &[f64], rates: &[f64]| -> Vec<Dual<1>> {
            x.iter().zip(rates).map(|(&value, &rate)| Dual { value, derivative: [rate] }).collect()
        };
        let (q, p) = (moved(&self.q, of_q), moved(&self.p, of_p));
        let t = Dual { value: self.t, derivative: [of_t] };
        let of = GeneralField::<F, Dual<1>> { system: self.of.system, parameters: &[] };
        let mut constraints = GeneralConstraints::default();
        constraints.evaluate(&of, &q, t);
        let mut rates = vec![Dual::<1>::default(); constraints.values.len()];
        let at = StepPoint { q: &q, p: &p, t, h: Dual { value: 1.0, derivative: [0.0] }, dw: &[] };
        let TangentRoom { mut gradient, mut columns, .. } = TangentRoom::default();
        of.rates(&at, &constraints, &mut gradient, &mut columns, &mut rates);
        let mut lambda: Vec<f64> = rates.iter().map(|rate| rate.derivative[0]).collect();
        self.matrix.solve(&mut lambda);
        Some(lambda)
    }

    /// Takes `Gᵀ λ` out of rates of the momenta; they are NaN where there is no `λ`.
    pub(super) fn constrain(&self, of_q: &[f64], of_p: &mut [f64], of_t: f64) {
        match self.multipliers(of_q, of_p, of_t) {
            Some(lambda) => self.constraints.subtract_transposed(&lambda, of_p),
            None => of_p.fill(f64::NAN),
        }
    }

    /// Projects a deviation on the tangent space.
    pub(super) fn make_tangent(&self, of_q: &mut [f64], of_p: &mut [f64]) {
        let mut normal = vec![0.0; self.constraints.values.len()];
        self.constraints.product(of_q, &mut normal);
        self.matrix.solve(&mut normal);
        let mut along = vec![0.0; of_q.len()];
        self.constraints.subtract_transposed(&normal, &mut along);
        self.of.masses(&self.at(), |i, j, w| of_q[i] += w * along[j]);
        self.constrain(of_q, of_p, 0.0);
    }
}
