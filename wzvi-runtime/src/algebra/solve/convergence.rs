//! When an iteration has converged: the constants that decide it, and the two laws that predict the next
//! correction.
//!
//! [`Convergence`] is that of Newton's method, where the next correction is about the square of this one:
//! `newton`, for one number and for lanes, and [`damped`](super::damped). [`Contraction`] is that of a fixed
//! point, where it is a fraction of this one: the iteration of elements, and the sweeps of `Gauss`.
//!
//! Relative corrections of `newton` may be a nineteenth too large or too small ([`Scalar::nearly_recip`]).

use crate::algebra::scalar::{Mask, Scalar, larger};

// The table of what decides that an iteration is solved, that it contracts, and that it stays near its start.
// Constants of cost stand where costs are counted, those of damping in `damped`. Where nothing else is said,
// a correction is measured relative to its unknown, an increment of the state.

/// The rounding of a number, relative to it. Corrections that are not larger change nothing.
pub(crate) const ROUNDING: f64 = f64::EPSILON;
/// The largest change that may be omitted, in roundings: with the changes that would follow it and the error
/// of the measured sizes it stays below the half that rounding to nearest makes itself. Newton's next
/// correction is a third with that error; changes that at least halve leave another quarter.
pub(crate) const UNSEEN: f64 = 0.25;
/// The largest change that may be omitted in the stages of `Gauss`, in roundings. It is not random as
/// rounding is, and so adds up over many steps. (With a fiftieth the energy of a Kepler orbit drifts by as
/// much in each step; with this it walks at random.)
pub(crate) const UNSEEN_IN_STAGES: f64 = 1e-6;
/// A sweep over stages that changes them by no more than this is the last, whatever the contraction: in
/// roundings of `|stage| + |state|`. Only stages a thousand times smaller than the state can change so little
/// without staying the same.
pub(crate) const SETTLED_STAGES: f64 = 0.0005;
/// Corrections contract if each is at most this part of the one before: what follows one of them is then no
/// larger than that one. Contraction at a lower rate is left to a method that costs less.
pub(crate) const CONTRACTION: f64 = 0.5;
/// The largest ratio of Newton's next correction to the square of this one. Relative to the step, the
/// correction after `c` is at most `ω c² / 2`, with `ω` the Lipschitz constant of `J⁻¹ J'`. From zero the
/// first correction is the whole step, and the Kantorovich number of the start is `ω`. Up to 1/2 there is one
/// solution near the start (P. Deuflhard, *Newton Methods for Nonlinear Problems*, section 2.1), and the
/// number grows with the size of the step. Other starts measure the same `ω`.
pub(super) const CURVATURE: f64 = 0.25;
/// The largest second correction, relative to the step: half of the bound from the Kantorovich number 1/2.
/// From zero the first correction is always 1, so the second is the only measurement of `ω`. Later ones are
/// then below 0.21 of the square of the one before (theorem 2.1 there), 0.24 in the measured sizes.
pub(super) const FIRST: f64 = 0.5 * CURVATURE;
/// A first correction below this part of the step is followed by smaller ones in any case.
const GUIDED: f64 = 1.0 / 16.0;
/// The bound on the second correction from an extrapolated start, whatever the first was. Such a start may be
/// anywhere; the bound ensures that the Jacobian is constant to `ω = 2^-9` between start and solution. It is
/// for a stiff unknown that alternates.
const ASTRAY: f64 = CURVATURE * GUIDED * GUIDED;
/// Corrections below twice this fraction of an unknown cannot lead to another solution, and need only
/// contract.
const NEAR: f64 = 1.0 / 4096.0;
/// The largest correction that predicts the next one, and its square: the whole step. A correction is larger
/// where it leaves an unknown near zero, which says nothing about the others.
const WHOLE: f64 = 1.0;
/// A sweep over stages that changes them by more than this, and does not contract, may lead to another
/// solution: in units of `|stage| + |state|`, as all changes of stages. That is no fraction of the step, as
/// [`GUIDED`] and [`NEAR`] are.
pub(crate) const WILD: f64 = 1.0 / 16.0;
/// With care, a sweep that changes them by more than this may, and by more than [`CAREFUL_CONTRACTION`] of
/// the sweep before.
pub(crate) const DOUBTFUL: f64 = 1.0 / 4096.0;
/// A map that contracts all distances to a quarter has one fixed point, within a third of the first change.
pub(crate) const CAREFUL_CONTRACTION: f64 = 0.25;

/// How large a number is against `|other|`, part by part (value, derivatives, lanes): the largest ratio, 0
/// for a part that vanishes; NaN if any part is. `f64::MIN_POSITIVE` is added to the divisor: a number that
/// is nearest to another differs from it by `ε (|x| + MIN_POSITIVE)` at most, subnormal or not. Derivatives
/// are compared as a gradient, by the largest.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn relative_to<S: Scalar>(number: S, other: S) -> f64 {
    if const { S::DERIVATIVES > 0 } {
        let of_values = relative_to(number.value(), other.value());
        return larger(of_values, relative_to(largest_derivative(number), largest_derivative(other)));
    }
    let of_lane = |lane| number.lane(lane).abs() / (other.lane(lane).abs() + f64::MIN_POSITIVE);
    (1..S::LANES).fold(of_lane(0), |most, lane| larger(most, of_lane(lane)))
}

fn largest_derivative<S: Scalar>(number: S) -> S::Value {
    let zero = S::Value::from_f64(0.0);
    (0..S::DERIVATIVES).fold(zero, |largest, part| number.derivative(part).larger(largest))
}

/// `|correction| / |unknown|` within a nineteenth, by lane; not finite where that is larger than all numbers.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn nearly_relative<S: Scalar>(correction: S, unknown: S) -> S {
    // One operation of all lanes after the other: compilers take the lanes of several at once apart.
    (correction * unknown.nearly_recip()).abs()
}

/// `|number| / size` of a size that is not negative, within an eighth, by lane and without derivatives;
/// `f64::MAX` for larger quotients and for NaN.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn nearly_over<S: Scalar>(number: S, size: S) -> S {
    if const { S::DERIVATIVES > 0 } {
        return S::of_value(nearly_over(number.value(), size.value()));
    }
    // The minimum is one instruction, but not the minimum with infinity, for which compilers emit a test of
    // bits.
    let (relative, most) = (nearly_relative(number, size), S::from_f64(f64::MAX));
    S::select(relative.less(most), relative, most)
}

/// A correction of a fixed point, relative to its unknowns, and the one before: by lane.
#[derive(Clone, Copy)]
pub(crate) struct Contraction<S> {
    correction: S,
    last: S,
}

impl<S: Scalar> Contraction<S> {
    /// From a correction and the one before; before the first, that is zero, from which nothing contracts.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn new(correction: S, last: S) -> Self {
        Self { correction, last }
    }

    /// The ratio of this correction to the one before.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn ratio(self) -> S {
        self.correction / self.last
    }

    /// Whether there is one before.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn is_second(self) -> S::Mask {
        S::from_f64(0.0).less(self.last)
    }

    /// Whether it contracts.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn contracts(self) -> S::Mask {
        self.correction.less(self.last * CONTRACTION)
    }

    /// Whether there is one before, from which it does not contract.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn stagnates(self) -> S::Mask {
        self.is_second() & (self.last * CONTRACTION).less(self.correction)
    }

    /// Whether the next correction may be omitted, if it is smaller by the same factor. `unseen`: the largest
    /// one that may, in roundings.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn leaves_unseen(self, unseen: f64) -> S::Mask {
        let (square, last) = (self.correction * self.correction, at_most_whole(self.last));
        self.contracts() & square.less_equal(last * (unseen * ROUNDING))
    }
}

/// The corrections of Newton's method, as far as they say when to stop: by lane.
#[derive(Clone, Copy)]
pub(super) struct Convergence<S> {
    /// The bound on the next correction if convergence is quadratic; below it no other test is needed.
    curved: S,
    /// The cube of the relative correction that is good enough: `ROUNDING³` or `last² ROUNDING unseen`.
    /// Infinite where one was: numbers stay in vector registers from iteration to iteration, truths do not.
    enough: S,
    unseen: f64,
    pub(super) iterations: u32,
    /// Whether the start was extrapolated.
    is_guess: bool,
    /// Whether corrections need only contract.
    is_patient: bool,
    /// Whether `curved` follows from unknowns beyond rounding only.
    is_beyond_rounding: bool,
}

/// The verdict on a correction.
pub(super) enum Verdict {
    /// It was the last.
    Converged,
    /// The iteration contracts.
    Contracting,
    /// The iteration does not contract.
    Straying,
}

/// The cube of a correction of a rounding.
const ENOUGH: f64 = ROUNDING * ROUNDING * ROUNDING;

impl<S: Scalar> Convergence<S> {
    /// Before the first correction: from zero it is the whole step, and proves nothing.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn new(is_guess: bool) -> Self {
        Self {
            curved: S::from_f64(if is_guess { GUIDED } else { f64::INFINITY }),
            enough: S::from_f64(ENOUGH),
            unseen: UNSEEN,
            iterations: 0,
            is_guess,
            is_patient: false,
            is_beyond_rounding: false,
        }
    }

    /// Notes the largest correction relative to its unknown, where that is all it takes, and returns where it
    /// was good enough; `None`, and nothing is noted, where a lane depends on its residuals.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn glance(&mut self, relative: S) -> Option<S::Mask> {
        let square = relative * relative;
        // `relative <= ROUNDING || relative (relative / last)² <= ROUNDING unseen` without dividing. A lane
        // that is done stays so, unless the next correction is not a number.
        let done = (square * relative).less_equal(self.enough);
        if done.all() {
            self.iterations += 1;
            return Some(done);
        }
        if self.is_patient || !(done | relative.less(self.curved)).all() {
            return None;
        }
        self.iterations += 1;
        // From an extrapolated start it is below `GUIDED`.
        self.expect(done, if self.is_guess { square } else { at_most_whole(square) });
        if !self.is_guess && self.iterations == 1 {
            self.curved = S::from_f64(FIRST);
        }
        Some(done)
    }

    /// Quadratic convergence from corrections with these squares, of lanes that are not done.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn expect(&mut self, done: S::Mask, square: S) {
        self.curved = square * CURVATURE;
        // The correction is above `ROUNDING` here, so that neither product underflows.
        let (predicted, floor) = (square * (self.unseen * ROUNDING), S::from_f64(ENOUGH));
        let enough = S::select(floor.less(predicted), predicted, floor);
        self.enough = S::select(done, S::from_f64(f64::INFINITY), enough);
    }

    /// The lanes that have ended while others go on: a single number ends with its iteration.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn ended(&self) -> S::Mask {
        match S::LANES {
            1 => S::Mask::from_bool(false),
            _ => self.enough.equal(S::from_f64(f64::INFINITY)),
        }
    }

    /// The iteration of a lane, to be judged by itself.
    pub(super) fn lane(&self, lane: usize) -> Convergence<f64> {
        let Self { unseen, iterations, is_guess, is_patient, is_beyond_rounding, .. } = *self;
        let (curved, enough) = (self.curved.lane(lane), self.enough.lane(lane));
        Convergence { curved, enough, unseen, iterations, is_guess, is_patient, is_beyond_rounding }
    }
}

/// A correction, or its square, as far as it predicts the next one.
#[cfg_attr(not(debug_assertions), inline(always))]
fn at_most_whole<S: Scalar>(size: S) -> S {
    let whole = S::from_f64(WHOLE);
    S::select(whole.less(size), whole, size)
}

impl Convergence<f64> {
    /// With corrections that need only contract, for callers that judge solutions by other means.
    pub(super) fn patient(unseen: f64) -> Self {
        Self { is_patient: true, unseen, ..Self::new(false) }
    }

    /// An extrapolated start that turned out to be zero claims nothing: there was no solution to extrapolate.
    pub(super) fn claim_nothing(&mut self) {
        *self = Self::new(false);
    }

    /// `relative`: largest correction relative to its unknown. `beyond_rounding`: the same of the unknowns
    /// whose residual was more than its rounding; 0 if there are none.
    pub(super) fn judge(&mut self, relative: f64, beyond_rounding: impl FnOnce() -> f64) -> Verdict {
        if let Some(is_last) = self.glance(relative) {
            return if is_last { Verdict::Converged } else { Verdict::Contracting };
        }
        self.iterations += 1;
        if !relative.is_finite() {
            return Verdict::Straying;
        }
        let square = at_most_whole(relative * relative);
        if self.iterations == 1 && !self.is_patient {
            // From an extrapolation: the first from zero is known at a glance.
            self.expect(false, square);
            self.curved = ASTRAY;
            return Verdict::Contracting;
        }
        let allowed = self.allowed(self.curved);
        if relative < allowed {
            self.expect(false, square);
            return Verdict::Contracting;
        }
        let beyond = beyond_rounding();
        if beyond == 0.0 {
            return Verdict::Converged;
        }
        // Rounding may have been the larger part of the correction before.
        let own = if self.is_beyond_rounding { 0.0 } else { self.allowed(CURVATURE * square) };
        if beyond < allowed.max(own) {
            self.is_beyond_rounding = true;
            self.expect(false, at_most_whole(beyond * beyond));
            return Verdict::Contracting;
        }
        Verdict::Straying
    }

    /// The bound of the next correction: `CURVATURE` times the square of the last one, and at most half of
    /// it.
    fn allowed(&self, curved: f64) -> f64 {
        // CURVATURE = CONTRACTION²
        let half = curved.sqrt();
        if self.is_patient { half } else { half.min(curved.max(NEAR)) }
    }

    /// A correction that does not count as one of a sequence: the next is judged by itself.
    pub(super) fn forget(&mut self) {
        (self.curved, self.enough) = (f64::INFINITY, ENOUGH);
        self.is_beyond_rounding = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::lanes::Lanes;
    use crate::algebra::scalar::Dual;

    /// The correction after one that ended near zero is as large as the step, and not the last.
    #[test]
    fn a_first_correction_that_ends_near_zero_predicts_nothing() {
        let mut convergence = Convergence::<f64>::new(true);
        assert!(matches!(convergence.judge(1e10, || 1e10), Verdict::Contracting));
        assert!(matches!(convergence.judge(0.5, || 0.5), Verdict::Straying));
    }

    /// Nor does a later one, whose square may overflow.
    #[test]
    fn a_correction_that_ends_at_zero_is_no_contraction() {
        let mut convergence = Convergence::<f64>::new(false);
        assert_eq!(convergence.glance(1.0), Some(false));
        assert!(matches!(convergence.judge(1e307, || 1e306), Verdict::Straying));
    }

    /// Nor does the first change of a fixed point predict the second, or one that is not finite the next.
    #[test]
    fn a_change_is_the_last_if_it_leaves_a_quarter_of_a_rounding() {
        let leaves_unseen = |change: f64, last: f64| Contraction::new(change, last).leaves_unseen(UNSEEN);
        for change in [1e-300, 1e-17, 1.0, 1e300, f64::INFINITY, f64::NAN] {
            let first = Contraction::new(change, 0.0);
            assert!(!first.leaves_unseen(UNSEEN) && !first.contracts() && !first.stagnates(), "{change}");
        }
        assert!(!leaves_unseen(1e-3, f64::INFINITY) && !leaves_unseen(1e-3, 1e300));
        for (next, is_unseen) in [(0.99, true), (1.01, false)] {
            let change = next * UNSEEN * ROUNDING / 0.49;
            assert_eq!(leaves_unseen(change, change / 0.49), is_unseen, "{next}");
        }
        assert!(!leaves_unseen(ROUNDING, 1.9 * ROUNDING), "that is no contraction");
        assert!(!leaves_unseen(f64::NAN, 1.0) && !leaves_unseen(1.0, f64::NAN));
    }

    /// Each lane has its own verdict.
    #[test]
    fn the_largest_of_other_lanes_is_no_change_of_this_one() {
        type Number = Dual<1, Lanes<2>>;
        let [number, size] = [[1.0, 1.0], [2.0, 1e10]].map(|x| Number::constant(Lanes::new(x)));
        let over = nearly_over(number, size).value;
        assert!((over[0] - 0.5).abs() < 0.5 / 8.0 && (over[1] - 1e-10).abs() < 1e-10 / 8.0, "{over:?}");
    }

    /// Between two powers of two the error does not depend on the power.
    #[test]
    fn sizes_are_nearly_right() {
        let mantissas = || (0..=1000).map(|k| 1.0 + f64::from(k) / 1000.0);
        for power in [-900, -500, -1, 0, 1, 500, 1000, 1020] {
            for mantissa in mantissas() {
                let size = mantissa * 2f64.powi(power);
                for number in [size, -0.3 * size, 1e-16 * size] {
                    let (near, exact) = (nearly_relative(number, -size), number.abs() / size);
                    assert!((near - exact).abs() <= exact / 19.0, "{number:e} {size:e}");
                    assert_eq!(near.to_bits(), nearly_over(number, size).to_bits());
                }
            }
        }
    }

    /// Where numbers have fewer digits, roundings are of one size, and so are errors of two and a half.
    #[test]
    fn what_is_subnormal_is_small() {
        for size in (0..52).map(|power| f64::from_bits(1 << power)) {
            let (near, exact) = (nearly_relative(5e-324, size), relative_to(5e-324, size));
            assert!(near > 0.0 && near <= 2.5 * exact, "{size:e}: {near:e} {exact:e}");
        }
        assert_eq!(nearly_relative(0.0, 0.0), 0.0);
        assert!(!nearly_relative(f64::INFINITY, f64::INFINITY).is_finite());
        assert!(!nearly_relative(f64::NAN, 1.0).is_finite());
    }
}
