//! Values and derivatives of a system, its clock and the rate of the clock, at a state.

use super::Clock;
use crate::algebra::scalar::Constant;
use crate::error::StepFailure;
use crate::scheme::elements::{Elements, EvaluationPoint, PairColumns, Partials, Role, slopes};

/// A system and its parameters, which may have derivatives.
#[derive(Debug)]
pub(super) struct SystemIn<'a, H, N> {
    pub(super) system: &'a H,
    /// All parameters, where they have derivatives; else none.
    pub(super) parameters: &'a [N],
}

impl<H: Elements, N: Constant<Constant = N>> SystemIn<'_, H, N> {
    pub(super) fn value(&self, role: Role, t: N, [q, p]: [&[N]; 2]) -> N {
        self.system.value(role, 1.0, &EvaluationPoint::new([q, p], t, self.parameters, &[]))
    }

    /// The derivatives of a role by coordinates. Roles here read one half of the phase space each, or are a
    /// sum of such.
    pub(super) fn by_q(&self, role: Role, t: N, at: [&[N]; 2], into: &mut [N], columns: &mut PairColumns) {
        into.fill(N::from_f64(0.0));
        let at = EvaluationPoint::new(at, t, self.parameters, &[]);
        slopes(self.system, role.times(1.0), &at, Partials::BY_COORDINATES, into, &mut [], columns);
    }

    /// The derivatives of a role by momenta, likewise.
    pub(super) fn by_p(&self, role: Role, t: N, at: [&[N]; 2], into: &mut [N], columns: &mut PairColumns) {
        into.fill(N::from_f64(0.0));
        let at = EvaluationPoint::new(at, t, self.parameters, &[]);
        slopes(self.system, role.times(1.0), &at, Partials::BY_MOMENTA, &mut [], into, columns);
    }
}

impl<H: Clock, N: Constant<Constant = N>> SystemIn<'_, H, N> {
    /// `Q(q, p, t)`
    ///
    /// # Errors
    /// [`StepFailure::ClockNotPositive`]
    pub(super) fn period(&self, t: N, q: &[N], p: &[N]) -> Result<N, StepFailure> {
        let period = self.value(Role::Clock, t, [q, p]);
        let value = period.lane(0);
        if is_positive(value) { Ok(period) } else { Err(StepFailure::ClockNotPositive { value }) }
    }

    /// `G = -d ln Q/dt`
    pub(super) fn rate(&self, t: N, q: &[N], p: &[N]) -> N {
        self.value(Role::ClockRate, t, [q, p])
    }
}

/// Whether a number is positive and finite; NaN is not.
pub(super) fn is_positive(number: f64) -> bool {
    number > 0.0 && number.is_finite()
}
