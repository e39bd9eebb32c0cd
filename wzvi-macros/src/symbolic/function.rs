//! The elementary functions: their name, how they are emitted and evaluated. Derivatives are in `differentiate`.

/// A function of real arguments that the graph keeps as one node.
///
/// `sqrt` of an argument that is not proven nonnegative is a function; of one that is, it is a power.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Function {
    Sqrt,
    Cbrt,
    Exp,
    Exp2,
    ExpM1,
    Ln,
    Ln1p,
    Log2,
    Log10,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Asinh,
    Acosh,
    Atanh,
    Abs,
    Signum,
    /// `powf(base, exponent)`
    Powf,
    /// `atan2(y, x)`
    Atan2,
    Hypot,
    Min,
    Max,
}

impl Function {
    pub(crate) const ALL: [Function; 28] = [
        Self::Sqrt,
        Self::Cbrt,
        Self::Exp,
        Self::Exp2,
        Self::ExpM1,
        Self::Ln,
        Self::Ln1p,
        Self::Log2,
        Self::Log10,
        Self::Sin,
        Self::Cos,
        Self::Tan,
        Self::Asin,
        Self::Acos,
        Self::Atan,
        Self::Sinh,
        Self::Cosh,
        Self::Tanh,
        Self::Asinh,
        Self::Acosh,
        Self::Atanh,
        Self::Abs,
        Self::Signum,
        Self::Powf,
        Self::Atan2,
        Self::Hypot,
        Self::Min,
        Self::Max,
    ];

    /// The method of `f64` and of the runtime's `Scalar` that computes it.
    pub(crate) fn method(self) -> &'static str {
        match self {
            Self::Sqrt => "sqrt",
            Self::Cbrt => "cbrt",
            Self::Exp => "exp",
            Self::Exp2 => "exp2",
            Self::ExpM1 => "exp_m1",
            Self::Ln => "ln",
            Self::Ln1p => "ln_1p",
            Self::Log2 => "log2",
            Self::Log10 => "log10",
            Self::Sin => "sin",
            Self::Cos => "cos",
            Self::Tan => "tan",
            Self::Asin => "asin",
            Self::Acos => "acos",
            Self::Atan => "atan",
            Self::Sinh => "sinh",
            Self::Cosh => "cosh",
            Self::Tanh => "tanh",
            Self::Asinh => "asinh",
            Self::Acosh => "acosh",
            Self::Atanh => "atanh",
            Self::Abs => "abs",
            Self::Signum => "signum",
            Self::Powf => "powf",
            Self::Atan2 => "atan2",
            Self::Hypot => "hypot",
            Self::Min => "min",
            Self::Max => "max",
        }
    }

    pub(crate) fn arity(self) -> usize {
        match self {
            Self::Powf | Self::Atan2 | Self::Hypot | Self::Min | Self::Max => 2,
            _ => 1,
        }
    }

    /// The value in binary64; `arguments` has [`Function::arity`] elements.
    pub(crate) fn evaluate(self, arguments: &[f64]) -> f64 {
        let x = arguments[0];
        let y = arguments.get(1).copied().unwrap_or(f64::NAN);
        match self {
            Self::Sqrt => x.sqrt(),
            Self::Cbrt => x.cbrt(),
            Self::Exp => x.exp(),
            Self::Exp2 => x.exp2(),
            Self::ExpM1 => x.exp_m1(),
            Self::Ln => x.ln(),
            Self::Ln1p => x.ln_1p(),
            Self::Log2 => x.log2(),
            Self::Log10 => x.log10(),
            Self::Sin => x.sin(),
            Self::Cos => x.cos(),
            Self::Tan => x.tan(),
            Self::Asin => x.asin(),
            Self::Acos => x.acos(),
            Self::Atan => x.atan(),
            Self::Sinh => x.sinh(),
            Self::Cosh => x.cosh(),
            Self::Tanh => x.tanh(),
            Self::Asinh => x.asinh(),
            Self::Acosh => x.acosh(),
            Self::Atanh => x.atanh(),
            Self::Abs => x.abs(),
            Self::Signum => x.signum(),
            Self::Powf => x.powf(y),
            Self::Atan2 => x.atan2(y),
            Self::Hypot => x.hypot(y),
            Self::Min => x.min(y),
            Self::Max => x.max(y),
        }
    }
}
