//! The constraints at a state: values, derivatives by the time, and the Jacobian.

use super::{Constrained, ConstraintLayout};
use crate::algebra::scalar::Scalar;
use crate::algebra::shape::Shape;
use crate::scheme::elements::EvaluationPoint;

/// Takes the terms of constraints.
pub trait ConstraintRows<S> {
    /// Adds to the value of a constraint.
    fn value(&mut self, constraint: usize, value: S);
    /// Adds to the derivative of a constraint by a coordinate.
    fn slope(&mut self, constraint: usize, coordinate: usize, slope: S);
    /// Adds to the derivative of a constraint by the time.
    fn rate(&mut self, constraint: usize, rate: S);
}

/// The lists of one entry for each constraint.
pub(super) type Multipliers<S, L> = <<L as ConstraintLayout>::Multipliers as Shape>::List<S>;

/// The constraints at a state.
#[derive(Debug)]
pub(super) struct ConstraintsAt<S: Scalar, L: ConstraintLayout> {
    /// `g`
    pub(super) values: Multipliers<S, L>,
    /// `∂g/∂t`
    pub(super) rates: Multipliers<S, L>,
    /// `G = ∂g/∂q`
    pub(super) jacobian: L::Jacobian<S>,
}

impl<S: Scalar, L: ConstraintLayout> ConstraintsAt<S, L> {
    pub(super) fn new(pattern: &L::Pattern, constraints: usize) -> Self {
        let list = || L::Multipliers::list(constraints, S::from_f64(0.0));
        Self { values: list(), rates: list(), jacobian: L::jacobian(pattern) }
    }

    /// Evaluates the constraints.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn evaluate<F: Constrained<Layout = L>>(
        &mut self,
        system: &F,
        parameters: &[S::Constant],
        pattern: &L::Pattern,
        q: &[S],
        t: S::Constant,
    ) {
        let zero = S::from_f64(0.0);
        let Self { values, rates, jacobian } = self;
        let (values, rates) = (values.as_mut(), rates.as_mut());
        values.fill(zero);
        if F::READ_TIME {
            rates.fill(zero);
        }
        L::clear(jacobian);
        let at = EvaluationPoint::new([q, &[][..]], t, parameters, &[]);
        system.constrain(&at, &mut RowsOf::<S, L> { pattern, values, rates, jacobian, slopes: 0 });
    }
}

/// Stores the terms of constraints.
struct RowsOf<'a, S: Scalar, L: ConstraintLayout> {
    pattern: &'a L::Pattern,
    values: &'a mut [S],
    rates: &'a mut [S],
    jacobian: &'a mut L::Jacobian<S>,
    /// Slopes so far.
    slopes: usize,
}

impl<S: Scalar, L: ConstraintLayout> ConstraintRows<S> for RowsOf<'_, S, L> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn value(&mut self, constraint: usize, value: S) {
        self.values[constraint] = self.values[constraint] + value;
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn slope(&mut self, constraint: usize, coordinate: usize, slope: S) {
        L::add(self.pattern, self.jacobian, self.slopes, [constraint, coordinate], slope);
        self.slopes += 1;
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn rate(&mut self, constraint: usize, rate: S) {
        self.rates[constraint] = self.rates[constraint] + rate;
    }
}
