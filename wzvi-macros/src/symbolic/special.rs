//! Functions of one real number that `f64` does not have: all that the compiler knows of them but the
//! identities of [`super::residue`].
//!
//! ```text
//! erf'    =  2/√π exp(-x²)            erfc' = -2/√π exp(-x²)
//! sinc_n' = -x sinc_(n+1)(x)          sinc_n(x) = j_n(x)/xⁿ    with the spherical Bessel function j_n
//! bess_n' = -x bess_(n+1)(x)          bess_n(x) = J_n(x)/xⁿ    with the Bessel function J_n of the first kind
//! ```
//!
//! Both families are smooth and even: `sinc_0 = sinc`, `bess_0 = j0`, and `j1 = x bess_1(x)` (DLMF 10.6.6,
//! 10.51.3). Emitted code calls the variant of the same name in the run time's `algebra/scalar/special.rs`.
//!
//! Tests: `symbolic/tests/random.rs`, `lower/tests/identities.rs`.

use std::f64::consts::FRAC_2_SQRT_PI;

use super::function::Parity;
use super::{Expr, Function, Graph};

/// A function of one real number.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub(crate) enum Special {
    /// `2/√π ∫_0^x exp(-s²) ds`
    Erf,
    /// `1 - erf(x)`, without cancellation.
    Erfc,
    /// `j_n(x)/xⁿ` for the spherical Bessel function of order `n`; `sin(x)/x` for order 0.
    Sinc(u32),
    /// `J_n(x)/xⁿ` for the Bessel function of the first kind of order `n`.
    Bessel(u32),
}

/// The functions by the names that users write, as `x^power · special(x)`.
pub(crate) const NAMES: [(&str, i32, Special); 5] = [
    ("erf", 0, Special::Erf),
    ("erfc", 0, Special::Erfc),
    ("sinc", 0, Special::Sinc(0)),
    ("j0", 0, Special::Bessel(0)),
    ("j1", 1, Special::Bessel(1)),
];

impl Special {
    /// The function that users call by this name, and the power of the argument that multiplies it.
    pub(crate) fn named(name: &str) -> Option<(i32, Self)> {
        NAMES.iter().find(|(known, ..)| *known == name).map(|&(_, power, special)| (power, special))
    }

    /// The name, without the order in a family.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Erf => "erf",
            Self::Erfc => "erfc",
            Self::Sinc(_) => "sinc",
            Self::Bessel(_) => "bessel",
        }
    }

    /// The order in a family.
    pub(crate) fn order(self) -> u32 {
        match self {
            Self::Erf | Self::Erfc => 0,
            Self::Sinc(n) | Self::Bessel(n) => n,
        }
    }

    pub(super) fn parity(self) -> Parity {
        match self {
            Self::Erf => Parity::Odd,
            Self::Erfc => Parity::None,
            Self::Sinc(_) | Self::Bessel(_) => Parity::Even,
        }
    }

    /// `2ν` for the Bessel function `J_ν` of a family.
    pub(super) fn twice(self, k: u32) -> u32 {
        2 * k + u32::from(matches!(self, Self::Sinc(_)))
    }

    /// `1/f(0)`, where it is an integer that fits.
    pub(super) fn inverse_at_zero(self) -> Option<i64> {
        match self {
            Self::Erf => None,
            Self::Erfc | Self::Sinc(_) | Self::Bessel(_) => {
                (1..=self.order()).try_fold(1_i64, |all, k| all.checked_mul(self.twice(k).into()))
            }
        }
    }

    /// Whether `f(x) > 0` for all `x`.
    pub(super) fn is_positive(self) -> bool {
        match self {
            Self::Erfc => true,
            Self::Erf | Self::Sinc(_) | Self::Bessel(_) => false,
        }
    }

    /// Whether `|f(x)| <= 1` for all `x`.
    pub(super) fn is_within_one(self) -> bool {
        match self {
            Self::Erf | Self::Sinc(_) | Self::Bessel(_) => true,
            Self::Erfc => false,
        }
    }

    /// `f'(x)`
    pub(super) fn slope(self, graph: &mut Graph, x: Expr) -> Expr {
        let next = match self {
            Self::Erf | Self::Erfc => {
                let square = graph.multiply(x, x);
                let exponent = graph.negate(square);
                let bell = graph.apply(Function::Exp, &[exponent]);
                let height = graph.float(FRAC_2_SQRT_PI);
                let slope = graph.multiply(height, bell);
                return if self == Self::Erf { slope } else { graph.negate(slope) };
            }
            Self::Sinc(n) => Self::Sinc(n + 1),
            Self::Bessel(n) => Self::Bessel(n + 1),
        };
        let next = graph.apply(Function::Special(next), &[x]);
        let slope = graph.multiply(x, next);
        graph.negate(slope)
    }

    /// A bound of `|f'|` where `least <= |x| <= most`.
    ///
    /// `sinc_n` and `bess_n` are Fourier transforms of positive densities on `[-1, 1]` (DLMF 10.9.4,
    /// 10.54.1), so their slopes are at most `f(0)`; and `|f_n'| = |x f_(n+1)| <= |x| f_(n+1)(0)`.
    pub(super) fn steepest(self, least: f64, most: f64) -> f64 {
        match self {
            Self::Erf | Self::Erfc => FRAC_2_SQRT_PI * (-least.max(0.0).powi(2)).exp(),
            Self::Sinc(n) | Self::Bessel(n) => self.at_zero(n).min(most * self.at_zero(n + 1)),
        }
    }

    fn at_zero(self, n: u32) -> f64 {
        (1..=n).fold(1.0, |value, k| value / f64::from(self.twice(k)))
    }

    pub(super) fn value(self, x: f64) -> f64 {
        self.with_rounding(x).0
    }

    /// `f(x)`, and a bound of its rounding error.
    pub(super) fn with_rounding(self, x: f64) -> (f64, f64) {
        const UNIT: f64 = 4.0 * f64::EPSILON;
        let exact = |value: f64| (value, UNIT * value.abs());
        let sinc = |x: f64| if x == 0.0 { 1.0 } else { libm::sin(x) / x };
        let [first, second] = match self {
            Self::Erf => return exact(libm::erf(x)),
            Self::Erfc => return exact(libm::erfc(x)),
            Self::Sinc(0) => return exact(sinc(x)),
            Self::Sinc(_) => [sinc(x), (sinc(x) - libm::cos(x)) / x / x],
            Self::Bessel(_) => [libm::j0(x), libm::j1(x) / x],
        };
        let n = self.order();
        let rounding = f64::from(n + 1) * UNIT;
        if n == 0 {
            return (first, rounding * x.abs().sqrt().recip().min(1.0));
        }
        if !x.is_finite() {
            return if x.is_nan() { (x, x) } else { (0.0, 0.0) };
        }
        if x.abs() > f64::from(n) {
            // `f_(k+1) = (2ν f_k - f_(k-1))/x²`, stable beyond `|x| = n`; errors are in parts of the
            // oscillations.
            let climb = |(below, at), k| (at, (f64::from(self.twice(k)) * at - below) / x / x);
            let (_, value) = (1..n).fold((first, second), climb);
            let decay = -f64::from(self.twice(n) + 1) / 2.0;
            return (value, rounding * x.abs().powf(decay).min(self.at_zero(n)));
        }
        // `f_n(x) = Σ_k f_n(0) Π_(j<=k) -x²/(2j (2j + 2ν))`
        let (mut term, mut value, mut size) = (self.at_zero(n), 0.0, 0.0);
        let mut k = 0;
        while term.abs() > f64::EPSILON * f64::EPSILON * size {
            (value, size) = (value + term, size + term.abs());
            k += 1;
            term *= -x * x / f64::from(2 * k * (2 * k + self.twice(n)));
        }
        (value, f64::from(k + 1) * rounding * size)
    }
}
