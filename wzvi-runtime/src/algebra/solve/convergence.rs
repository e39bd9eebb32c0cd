//! When an iteration has converged: see [`newton`](super::newton).
//!
//! Relative corrections may be a nineteenth too large or too small ([`Scalar::nearly_relative_to`](crate::algebra::scalar::Scalar::nearly_relative_to)).

/// Corrections below this fraction of an unknown change nothing.
pub(super) const ROUNDING: f64 = f64::EPSILON;
/// The part of a rounding that the correction after the last one may be: a third of one, where the corrections that it follows from are not exact.
pub(super) const UNSEEN: f64 = 0.25;
/// The part of its square that the next correction may be. Relative to the step, `c` is followed by at most `ω c² / 2`, with `ω` the Lipschitz constant of
/// `J⁻¹ J'`. From zero the first correction is the whole step, and the Kantorovich number of the start is `ω`: up to 1/2 there is one solution near the
/// start (P. Deuflhard, *Newton Methods for Nonlinear Problems*, section 2.1), and along the step from none at all that number only grows. Other starts
/// measure the same `ω`.
pub(super) const CURVATURE: f64 = 0.25;
/// The part of the step that the correction after the first may be: half of what the number 1/2 allows, since from zero the first correction is 1
/// whatever the equations are, and this one is all that is known of `ω`. Those after it are then below 0.21 of the square of the one before (theorem 2.1 there),
/// 0.24 as sizes are measured.
pub(super) const FIRST: f64 = 0.5 * CURVATURE;
/// What an extrapolated start has to be followed by after its first correction, however long that is: such a start may be anywhere, and the Jacobian is then
/// the same to `ω = 2^-9` on the way from there. That of a stiff unknown that alternates is.
pub(super) const ASTRAY: f64 = CURVATURE * GUIDED * GUIDED;
/// First corrections below this part of the step are followed by less in any case.
pub(super) const GUIDED: f64 = 1.0 / 16.0;
/// Corrections below twice this fraction of an unknown are those of a start that is no other solution's, and are to halve only.
pub(super) const NEAR: f64 = 1.0 / 4096.0;
/// The corrections of an iteration, as far as they say when to stop.
#[derive(Clone, Copy)]
pub(crate) struct Convergence {
    /// What the next correction is below where convergence is quadratic, so that nothing else has to be looked at.
    curved: f64,
    /// The cube of the relative correction that is good enough: `ROUNDING³` or `last² ROUNDING unseen`.
    enough: f64,
    unseen: f64,
    pub(crate) iterations: u32,
    /// What the correction after the first has to be below.
    second: f64,
    /// Whether corrections need only halve.
    is_patient: bool,
    /// Whether `curved` follows from unknowns beyond rounding only.
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
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn new(is_guess: bool) -> Self {
        let (curved, second) = if is_guess { (GUIDED, ASTRAY) } else { (0.0, FIRST) };
        let enough = ROUNDING * ROUNDING * ROUNDING;
        let (unseen, iterations, is_patient, is_beyond_rounding) = (UNSEEN, 0, false, false);
        Self { curved, enough, unseen, iterations, second, is_patient, is_beyond_rounding }
    }

    /// An extrapolated start that turned out to be zero claims nothing: there was no solution to extrapolate.
    pub(super) fn claim_nothing(&mut self) {
        self.second = FIRST;
    }

    /// With corrections that need only halve: whoever judges solutions by other means.
    pub(super) fn patient(unseen: f64) -> Self {
        Self { curved: f64::INFINITY, is_patient: true, unseen, ..Self::new(false) }
    }

    /// The first correction.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn begin(&mut self, relative: f64) {
        self.iterations = 1;
        self.expect(relative * relative);
        self.curved = self.second;
    }

    /// The verdict on the largest correction relative to its unknown, where that is all it takes; `None`, and nothing is noted, where it
    /// depends on the residuals.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn glance(&mut self, relative: f64) -> Option<Verdict> {
        let square = relative * relative;
        // `relative <= ROUNDING || relative (relative / last)² <= ROUNDING unseen` without dividing.
        let verdict = if square * relative <= self.enough {
            Verdict::Converged
        } else if relative < self.curved && !self.is_patient {
            self.expect(square);
            Verdict::Contracting
        } else {
            // NaN, too.
            return None;
        };
        self.iterations += 1;
        Some(verdict)
    }

    /// `relative`: largest correction relative to its unknown. `beyond_rounding`: the same of the unknowns whose residual
    /// was more than its rounding; 0 if there are none.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn judge(&mut self, relative: f64, beyond_rounding: impl FnOnce() -> f64) -> Verdict {
        if let Some(verdict) = self.glance(relative) {
            return verdict;
        }
        if !relative.is_finite() {
            self.iterations += 1;
            return Verdict::Straying;
        }
        if self.iterations == 0 && !self.is_patient {
            self.begin(relative);
            return Verdict::Contracting;
        }
        self.iterations += 1;
        let (allowed, square) = (self.allowed(self.curved), relative * relative);
        if relative < allowed {
            self.expect(square);
            return Verdict::Contracting;
        }
        let beyond = beyond_rounding();
        if beyond == 0.0 {
            return Verdict::Converged;
        }
        // What is rounding may have been the larger part of the correction before.
        let own = if self.is_beyond_rounding { 0.0 } else { self.allowed(CURVATURE * square) };
        if beyond < allowed.max(own) {
            self.is_beyond_rounding = true;
            self.expect(beyond * beyond);
            return Verdict::Contracting;
        }
        Verdict::Straying
    }

    /// What the next correction has to be below.
    fn allowed(&self, curved: f64) -> f64 {
        if self.is_patient { curved.sqrt() } else { allowed(curved) }
    }

    /// Quadratic convergence from a correction of this size, with its square.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn expect(&mut self, square: f64) {
        self.curved = CURVATURE * square;
        // The correction is above `ROUNDING` here, so that neither product underflows.
        let (predicted, floor) = (self.unseen * ROUNDING * square, ROUNDING * ROUNDING * ROUNDING);
        self.enough = if predicted > floor { predicted } else { floor };
    }

    /// A correction that does not count as one of a sequence: the next is judged by itself.
    pub(crate) fn forget(&mut self) {
        (self.curved, self.enough) = (f64::INFINITY, ROUNDING * ROUNDING * ROUNDING);
        self.is_beyond_rounding = false;
    }
}

/// What the next correction has to be below, from the part of the square of the last: half of that one, too.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn allowed(curved: f64) -> f64 {
    let half = curved.sqrt();
    half.min(curved.max(NEAR))
}
