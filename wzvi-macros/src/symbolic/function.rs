//! The functions: names, emission and evaluation. Derivatives of the elementary ones are in `differentiate`.
//!
//! Functions that `f64` does not have are in `special`.
//!
//! Tests: `symbolic/tests/random.rs`.

use super::special::Special;

/// The parity: `f(-x)` in terms of `f(x)`, if known.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Parity {
    Even,
    Odd,
    None,
}

/// Each function with the method of `f64` and of the runtime's `Scalar` that computes it, its arguments and
/// its parity.
macro_rules! functions {
    ($($name:ident = $method:ident($x:ident $(, $y:ident)?) $(, $parity:ident)?;)+) => {
        /// A function of real arguments that the graph keeps as one node.
        ///
        /// `sqrt` of an argument that is not proven nonnegative is a function; of one that is, it is a power.
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
        pub(crate) enum Function {
            $($name,)+
            /// A function that `f64` does not have.
            Special(Special),
        }

        impl Function {
            /// The functions of `f64`.
            pub(crate) const ALL: &[Self] = &[$(Self::$name,)+];

            /// The method of `f64` and of `Scalar`; for special functions the name.
            pub(crate) fn method(self) -> &'static str {
                match self {
                    $(Self::$name => stringify!($method),)+
                    Self::Special(special) => special.name(),
                }
            }

            pub(crate) fn arity(self) -> usize {
                match self {
                    $(Self::$name => [stringify!($x) $(, stringify!($y))?].len(),)+
                    Self::Special(_) => 1,
                }
            }

            pub(crate) fn parity(self) -> Parity {
                match self {
                    $($(Self::$name => Parity::$parity,)?)+
                    Self::Special(special) => special.parity(),
                    _ => Parity::None,
                }
            }

            /// The value in binary64; `arguments` has [`Function::arity`] elements.
            pub(crate) fn evaluate(self, arguments: &[f64]) -> f64 {
                match (self, arguments) {
                    $((Self::$name, [$x $(, $y)?, ..]) => $x.$method($(*$y)?),)+
                    (Self::Special(special), [x, ..]) => special.value(*x),
                    _ => f64::NAN,
                }
            }
        }
    };
}

functions! {
    Sqrt = sqrt(x);
    Cbrt = cbrt(x), Odd;
    Exp = exp(x);
    Exp2 = exp2(x);
    ExpM1 = exp_m1(x);
    Ln = ln(x);
    Ln1p = ln_1p(x);
    Log2 = log2(x);
    Log10 = log10(x);
    Sin = sin(x), Odd;
    Cos = cos(x), Even;
    Tan = tan(x), Odd;
    Asin = asin(x), Odd;
    Acos = acos(x);
    Atan = atan(x), Odd;
    Sinh = sinh(x), Odd;
    Cosh = cosh(x), Even;
    Tanh = tanh(x), Odd;
    Asinh = asinh(x), Odd;
    Acosh = acosh(x);
    Atanh = atanh(x), Odd;
    Abs = abs(x), Even;
    Signum = signum(x);
    Powf = powf(x, y);
    Atan2 = atan2(x, y);
    Hypot = hypot(x, y);
    Min = min(x, y);
    Max = max(x, y);
}

impl Function {
    /// Whether all values are between -1 and 1.
    pub(crate) fn is_within_one(self) -> bool {
        match self {
            Self::Special(special) => special.is_within_one(),
            _ => matches!(self, Self::Sin | Self::Cos | Self::Tanh),
        }
    }
}
