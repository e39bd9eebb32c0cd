//! Functions of one real number that `f64` does not have, and the functions that their derivatives lead to.
//!
//! ```text
//! erf'    =  2/√π exp(-x²)            erfc' = -2/√π exp(-x²)
//! sinc_n' = -x sinc_(n+1)(x)          sinc_n(x) = j_n(x)/xⁿ    with the spherical Bessel function j_n
//! bess_n' = -x bess_(n+1)(x)          bess_n(x) = J_n(x)/xⁿ    with the Bessel function J_n of the first kind
//! ```
//!
//! Both families are smooth and even: `sinc_0 = sinc`, `bess_0 = j0`, and `j1 = x bess_1(x)` (DLMF 10.6.6,
//! 10.51.3). Values are those of the crate `libm` and IEEE additions, multiplications and divisions in a
//! fixed order: the same bits for single numbers and in lanes, on every machine. The compiler has its own
//! rows for them, in `symbolic/special.rs`.

use super::Scalar;

/// A function of one real number.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub enum Special {
    /// `2/√π ∫_0^x exp(-s²) ds`
    Erf,
    /// `1 - erf(x)`, without cancellation.
    Erfc,
    /// `j_n(x)/xⁿ` for the spherical Bessel function of order `n`; `sin(x)/x` for order 0.
    Sinc(u32),
    /// `J_n(x)/xⁿ` for the Bessel function of the first kind of order `n`.
    Bessel(u32),
}

impl Special {
    /// `f(x)`; NaN for NaN, and the limits for infinities.
    pub fn value(self, x: f64) -> f64 {
        match self {
            Self::Erf => libm::erf(x),
            Self::Erfc => libm::erfc(x),
            Self::Sinc(_) | Self::Bessel(_) if x.is_infinite() => 0.0,
            Self::Sinc(n) => SINC.member(n, x),
            Self::Bessel(1) => bess_1(x),
            Self::Bessel(n) => BESSEL.member(n, x),
        }
    }

    /// `f'(x)`
    pub(super) fn slope<S: Scalar>(self, x: S) -> S {
        match self {
            Self::Erf => (-(x * x)).exp() * std::f64::consts::FRAC_2_SQRT_PI,
            Self::Erfc => -Self::Erf.slope(x),
            Self::Sinc(n) => -x * x.special(Self::Sinc(n + 1)),
            Self::Bessel(n) => -x * x.special(Self::Bessel(n + 1)),
        }
    }

    /// A bound of `|f'|` where `least <= |x| <= most`.
    ///
    /// `sinc_n` and `bess_n` are Fourier transforms of positive densities on `[-1, 1]` (DLMF 10.9.4,
    /// 10.54.1), so their slopes are at most `f(0)`; and `|f_n'| = |x f_(n+1)| <= |x| f_(n+1)(0)`.
    pub(super) fn steepest(self, least: f64, most: f64) -> f64 {
        match self {
            Self::Erf | Self::Erfc => {
                let least = least.max(0.0);
                std::f64::consts::FRAC_2_SQRT_PI * libm::exp(-least * least)
            }
            Self::Sinc(n) => SINC.at_zero(n).min(most * SINC.at_zero(n + 1)),
            Self::Bessel(n) => BESSEL.at_zero(n).min(most * BESSEL.at_zero(n + 1)),
        }
    }

    /// A bound of the rounding error of [`Special::value`]: of the functions that oscillate, in parts of
    /// their amplitude.
    ///
    /// Measured in `tests/runtime/special.rs`.
    pub fn rounding(self, x: f64) -> f64 {
        let units = |n: u32| f64::from(4 + n) * f64::EPSILON;
        match self {
            Self::Erf | Self::Erfc => 2.0 * f64::EPSILON * self.value(x).abs(),
            Self::Sinc(n) => units(n) * SINC.amplitude(n, x),
            Self::Bessel(n) => units(n) * BESSEL.amplitude(n, x),
        }
    }
}

/// A family `f_n` with `f_(k-1) = 2ν f_k - x² f_(k+1)`, `ν = k` or `k + ½`: `√(π/2) J_ν(x)/x^ν` or
/// `J_ν(x)/x^ν` (DLMF 10.6.1, 10.51.1).
#[derive(Clone, Copy)]
struct Family {
    /// Whether `ν = k + ½`.
    is_spherical: bool,
    /// `f_0`
    first: fn(f64) -> f64,
    /// `f_1` where `|x| > 1`.
    second: fn(f64) -> f64,
}

const SINC: Family = Family { is_spherical: true, first: sinc, second: sinc_1 };
const BESSEL: Family = Family { is_spherical: false, first: libm::j0, second: bess_1 };

impl Family {
    /// `2ν`
    fn twice(self, k: u32) -> u32 {
        2 * k + u32::from(self.is_spherical)
    }

    /// `f_n(0)`
    fn at_zero(self, n: u32) -> f64 {
        (1..=n).fold(1.0, |value, k| value / f64::from(self.twice(k)))
    }

    /// The size of the oscillations, within a constant.
    fn amplitude(self, n: u32, x: f64) -> f64 {
        let decay = f64::from(self.twice(n) + 1) / 2.0;
        self.at_zero(n).min(libm::pow(x.abs(), -decay))
    }

    /// `f_n(x)`.
    ///
    /// Beyond `|x| = n` the recurrence is stable upwards. Below, `J_ν` is the solution that decays with its
    /// order: the recurrence is stable downwards, from an order where the start no longer matters, and `f_0`
    /// or `f_1` gives the factor (W. Gautschi, SIAM Review 9 (1967) 24). Neither loses digits.
    fn member(self, n: u32, x: f64) -> f64 {
        let of = |k: u32| f64::from(self.twice(k));
        if n == 0 {
            return (self.first)(x);
        }
        if x.abs() > f64::from(n) {
            let (mut below, mut value) = ((self.first)(x), (self.second)(x));
            for k in 1..n {
                // Not by x²: it overflows before the quotient vanishes.
                (below, value) = (value, (of(k) * value - below) / x / x);
            }
            return value;
        }
        let square = x * x;
        // `f_k` within a factor, and those of order n, 1 and 0.
        let (mut above, mut value, mut of_n) = (0.0, 1e-290, 0.0);
        for k in (1..=n + n / 2 + 12).rev() {
            if k == n {
                of_n = value;
            }
            (above, value) = (value, of(k) * value - square * above);
        }
        let [by_first, by_second] = [of_n / value, of_n / above];
        // `f_0` has no zero below 2.4, and where it has one, `x f_1` is of its size.
        let first = (self.first)(x);
        if x.abs() < 1.5 {
            return first * by_first;
        }
        let second = (self.second)(x);
        if (x * second).abs() > first.abs() { second * by_second } else { first * by_first }
    }
}

/// `sin(x)/x`, 1 at 0.
fn sinc(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { libm::sin(x) / x }
}

/// `(sin(x)/x - cos(x))/x²`, which cancels below 1.
fn sinc_1(x: f64) -> f64 {
    (sinc(x) - libm::cos(x)) / x / x
}

/// `J_1(x)/x`: ½ where the next term, `x²/16`, is below rounding.
fn bess_1(x: f64) -> f64 {
    if x.abs() < 1e-8 { 0.5 } else { libm::j1(x) / x }
}
