//! The clock and its rate at a state.

use super::Clock;
use crate::algebra::scalar::Constant;
use crate::error::StepFailure;
use crate::scheme::elements::{EvaluationPoint, Role};

/// A system and its parameters, which may have derivatives.
#[derive(Debug)]
pub(super) struct ClockOf<'a, H, N> {
    pub(super) system: &'a H,
    /// All parameters, where they have derivatives; else none.
    pub(super) parameters: &'a [N],
}

impl<H: Clock, N: Constant<Constant = N>> ClockOf<'_, H, N> {
    /// `Q(q, p, t)`
    ///
    /// # Errors
    /// [`StepFailure::ClockNotPositive`]
    pub(super) fn period(&self, t: N, q: &[N], p: &[N]) -> Result<N, StepFailure> {
        let at = EvaluationPoint::new([q, p], t, self.parameters, &[]);
        let period = self.system.value(Role::Clock, 1.0, &at);
        let value = period.lane(0);
        if is_positive(value) { Ok(period) } else { Err(StepFailure::ClockNotPositive { value }) }
    }

    /// `G = -d ln Q/dt`
    pub(super) fn rate(&self, t: N, q: &[N], p: &[N]) -> N {
        let at = EvaluationPoint::new([q, p], t, self.parameters, &[]);
        self.system.value(Role::ClockRate, 1.0, &at)
    }
}

/// Whether a number is positive and finite; NaN is not.
pub(super) fn is_positive(number: f64) -> bool {
    number > 0.0 && number.is_finite()
}
