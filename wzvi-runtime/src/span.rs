//! From where to where a run goes, and which of its nodes are recorded: the same for every builder.

use crate::error::{ConfigError, StepFailure};
use crate::state::{State, Vector};
use crate::system::Discretized;

/// Step numbers are exact as `f64` up to here; time is `t_0 + n h`.
pub(crate) const MOST_STEPS: u64 = 1 << 53;

/// The end of a run, as the user says it.
#[derive(Clone, Copy, Debug)]
pub(crate) enum End {
    Time(f64),
    Steps(u64),
}

/// Where a run starts and where it ends.
#[derive(Clone, Debug)]
pub(crate) struct Span<V> {
    pub(crate) start: Option<State<V>>,
    pub(crate) end: Option<End>,
}

impl<V> Default for Span<V> {
    fn default() -> Self {
        Self { start: None, end: None }
    }
}

impl<V: Vector> Span<V> {
    /// The first state, and the number of steps of size `h` to the end.
    ///
    /// # Errors
    /// [`ConfigError`] where one of them is missing, does not fit the system, or cannot be reached.
    pub(crate) fn checked<H: Discretized<E, Vector = V>, E>(
        self,
        system: &H,
        h: f64,
    ) -> Result<(State<V>, u64), ConfigError> {
        let start = checked(system, self.start)?;
        let steps = count(self.end, start.t, h)?;
        Ok((start, steps))
    }
}

const START: &str = "a start: add `.start(State::new(q, p))`";
const END: &str = "an end: add `.until(time)` or `.steps(number)`";

fn checked<H: Discretized<E>, E>(
    system: &H,
    start: Option<State<H::Vector>>,
) -> Result<State<H::Vector>, ConfigError> {
    let state = start.ok_or(ConfigError::Missing(START))?;
    let (q, p) = (state.q.components(), state.p.components());
    // Where only the state knows the size, the momenta have to match the coordinates.
    let expected = if system.fits(q.len()) { q.len() } else { system.degrees() };
    for got in [q.len(), p.len()] {
        if !system.fits(got) || got != q.len() {
            return Err(ConfigError::Start(StepFailure::Dimension { expected, got }));
        }
    }
    system.check(q.len()).map_err(ConfigError::Start)?;
    if q.iter().chain(p).chain([&state.t]).all(|x| x.is_finite()) {
        Ok(state)
    } else {
        Err(ConfigError::Start(StepFailure::NonFiniteInput))
    }
}

fn count(end: Option<End>, start: f64, h: f64) -> Result<u64, ConfigError> {
    match end.ok_or(ConfigError::Missing(END))? {
        End::Time(end) => steps_between(start, end, h).ok_or(ConfigError::End { start, end, h }),
        End::Steps(steps) if steps <= MOST_STEPS => Ok(steps),
        End::Steps(steps) => Err(ConfigError::End { start, end: start + steps as f64 * h, h }),
    }
}

/// `⌈(end - start)/h⌉`, or the integer that the quotient would be but for rounding; `None` if it is negative, NaN or
/// more than can be counted.
pub(crate) fn steps_between(start: f64, end: f64, h: f64) -> Option<u64> {
    let quotient = (end - start) / h;
    // One rounding each in start, end, their difference, h and the quotient, and one to spare.
    let allowance = 2.0 * f64::EPSILON * (quotient + (start.abs() + end.abs()) / h.abs());
    let nearest = quotient.round();
    let steps = if (quotient - nearest).abs() <= allowance { nearest } else { quotient.ceil() };
    // Also false for NaN.
    (quotient >= 0.0 && steps <= MOST_STEPS as f64).then_some(steps as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_counted_despite_rounding() {
        assert_eq!(steps_between(0.0, 20.0, 0.02), Some(1000));
        assert_eq!(steps_between(0.0, 0.3, 0.1), Some(3)); // 2.9999999999999996
        assert_eq!(steps_between(0.1, 0.7, 0.1), Some(6)); // 5.999999999999999
        assert_eq!(steps_between(0.1 + 0.2, 0.9, 0.3), Some(2));
        assert_eq!(steps_between(0.0, 1.0, 0.3), Some(4));
        assert_eq!(steps_between(0.0, 1.0 + 1e-12, 0.25), Some(5));
        assert_eq!(steps_between(0.0, 1e-17, 1.0), Some(1));
        assert_eq!(steps_between(2.0, 2.0, 0.1), Some(0));
        assert_eq!(steps_between(1.0, -1.0, -0.5), Some(4));
        for n in 1..2000_u32 {
            for h in [0.1, 0.02, 1e-3, 1.0 / 3.0, 0.7] {
                for t0 in [0.0, 0.1, -17.3, 1e3] {
                    assert_eq!(
                        steps_between(t0, t0 + f64::from(n) * h, h),
                        Some(u64::from(n)),
                        "{t0} {n} {h}"
                    );
                }
            }
        }
    }

    #[test]
    fn ends_that_cannot_be_reached_are_refused() {
        let (nan, inf) = (f64::NAN, f64::INFINITY);
        for (start, end, h) in
            [(0.0, -1.0, 0.1), (0.0, 1.0, -0.1), (0.0, nan, 0.1), (0.0, inf, 0.1), (0.0, 1e300, 1e-300)]
        {
            assert_eq!(steps_between(start, end, h), None, "{start} {end} {h}");
        }
        assert_eq!(steps_between(0.0, 9_007_199_254_740_994.0, 1.0), None);
    }
}
