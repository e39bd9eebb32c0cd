//! When an iteration has converged: see [`newton`](super::newton).
//!
//! Relative corrections may be a nineteenth too large or too small ([`Scalar::nearly_relative_to`](crate::scalar::Scalar::nearly_relative_to)).

/// Corrections below this fraction of an unknown change nothing.
pub(super) const ROUNDING: f64 = f64::EPSILON;
/// The part of a rounding that the correction after the last one may be: a third of one, where the corrections that it follows from are not exact.
pub(super) const UNSEEN: f64 = 0.25;
/// A start other than zero claims to be near the solution: its first correction has to be smaller than the solution itself, by what sizes may be wrong.
/// From zero it never is.
pub(super) const FROM_GUESS: f64 = 2.0 * (1.0 - 1.0 / 19.0);
/// The part of its square that the next correction may be. From zero the first correction is 1, whatever the equations are, and the Kantorovich number
/// of the start, `ω |c|` with `ω` the Lipschitz constant of `J⁻¹ J'`, is at most twice the next one, divided by the square of the first. Up to 1/2 there
/// is one solution near the start (P. Deuflhard, *Newton Methods for Nonlinear Problems*, section 2.1), and along the step from none at all that
/// number only grows. Half of what that allows: the number is taken from one correction, not from all points around.
pub(super) const CURVATURE: f64 = 0.125;
/// Corrections below twice this fraction of an unknown are those of a start that is no other solution's, and are to halve only.
pub(super) const NEAR: f64 = 1.0 / 4096.0;
/// A start that is extrapolated from three solutions, `3a - 3b + c`, has their roundings, and one of its own.
const ROUNDING_OF_GUESS: f64 = 8.0;

/// The corrections of an iteration, as far as they say when to stop.
#[derive(Clone, Copy)]
pub(crate) struct Convergence {
    last: f64,
    /// The cube of the relative correction that is good enough: `ROUNDING³` or `last² ROUNDING unseen`.
    enough: f64,
    unseen: f64,
    pub(crate) iterations: u32,
    is_guess: bool,
    /// Whether corrections need only halve.
    is_patient: bool,
    /// Whether `last` is that of unknowns beyond rounding only.
    is_beyond_rounding: bool,
}

/// What a correction says.
pub(crate) enum Verdict {
    /// It was the last.
    Converged,
    /// It is at most half of the one before.
    Contracting,
    /// It is not.
    Straying,
}

impl Convergence {
    #[inline(always)]
    pub(crate) fn new(is_guess: bool) -> Self {
        let last = if is_guess { FROM_GUESS } else { f64::INFINITY };
        let enough = ROUNDING * ROUNDING * ROUNDING;
        let (iterations, unseen, is_patient, is_beyond_rounding) = (0, UNSEEN, false, is_guess);
        Self { last, enough, unseen, iterations, is_guess, is_patient, is_beyond_rounding }
    }

    /// From a start that claims nothing, with corrections that need only halve: whoever judges solutions by other means.
    pub(super) fn patient(unseen: f64) -> Self {
        Self { is_patient: true, unseen, ..Self::new(false) }
    }

    /// A start that turned out to be zero claims nothing: there was no solution to extrapolate.
    pub(super) fn claim_nothing(&mut self) {
        (self.last, self.is_beyond_rounding) = (f64::INFINITY, false);
    }

    /// The first correction from zero.
    #[inline(always)]
    pub(super) fn begin(&mut self, relative: f64) {
        self.iterations = 1;
        self.expect(relative, relative * relative);
    }

    /// Whether this is a guess that no correction has been made to.
    pub(super) fn is_fresh_guess(&self) -> bool {
        self.is_guess && self.iterations == 0
    }

    /// The verdict on the largest correction relative to its unknown, where that is all it takes; `None`, and nothing is noted, where it
    /// depends on the residuals.
    #[inline(always)]
    pub(super) fn glance(&mut self, relative: f64) -> Option<Verdict> {
        let square = relative * relative;
        // `relative <= ROUNDING || relative (relative / last)² <= ROUNDING unseen` without dividing.
        let verdict = if square * relative <= self.enough {
            Verdict::Converged
        } else if self.allows(relative, self.last, self.iterations == 0) {
            self.expect(relative, square);
            Verdict::Contracting
        } else {
            // NaN, too.
            return None;
        };
        self.iterations += 1;
        Some(verdict)
    }

    /// `relative`: largest correction relative to its unknown. `beyond_rounding`: the same of the unknowns whose residual
    /// was more than so many times its rounding; 0 if there are none.
    #[inline(always)]
    pub(crate) fn judge(&mut self, relative: f64, beyond_rounding: impl FnOnce(f64) -> f64) -> Verdict {
        if let Some(verdict) = self.glance(relative) {
            return verdict;
        }
        let is_first = self.iterations == 0;
        self.iterations += 1;
        if !relative.is_finite() {
            return Verdict::Straying;
        }
        let beyond = beyond_rounding(roundings(self.is_guess && is_first));
        if beyond == 0.0 {
            return Verdict::Converged;
        }
        // What is rounding may have been the larger part of the correction before.
        let last = if self.is_beyond_rounding { self.last } else { self.last.max(relative) };
        if self.allows(beyond, last, is_first) {
            self.is_beyond_rounding = true;
            self.expect(beyond, beyond * beyond);
            return Verdict::Contracting;
        }
        Verdict::Straying
    }

    /// Quadratic convergence from a correction of this size, with its square.
    #[inline(always)]
    fn expect(&mut self, relative: f64, square: f64) {
        self.last = relative;
        // `relative` is above `ROUNDING` here, so that neither product underflows.
        let (predicted, floor) = (self.unseen * ROUNDING * square, ROUNDING * ROUNDING * ROUNDING);
        self.enough = if predicted > floor { predicted } else { floor };
    }

    /// Whether a correction may follow one of the size `last`; false for NaN. Nearly all are near, and cost one comparison more.
    #[inline(always)]
    fn allows(&self, relative: f64, last: f64, is_first: bool) -> bool {
        let halves = relative < 0.5 * last;
        halves && (relative < NEAR || is_first || self.is_patient || relative < CURVATURE * last * last)
    }

    /// A correction that does not count as one of a sequence: the next is judged by itself.
    pub(crate) fn forget(&mut self) {
        (self.last, self.enough) = (f64::INFINITY, ROUNDING * ROUNDING * ROUNDING);
        self.is_beyond_rounding = false;
    }
}

/// How many roundings of its terms a residual may be to count as zero.
pub(super) fn roundings(is_guess: bool) -> f64 {
    if is_guess { ROUNDING_OF_GUESS } else { 1.0 }
}
