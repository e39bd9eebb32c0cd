//! Derivatives of a run that no number can hold.

use crate::ground::digits::ShortestDecimal;

/// A derivative of the end of a run is out of the range of `f64`.
#[derive(Clone, Debug, PartialEq)]
pub struct DerivativeError {
    /// The variable of the start, the parameter or the step size by which it was differentiated.
    pub by: String,
    /// The natural logarithm of the largest entry of its column; infinite if a step has no finite derivative.
    pub ln_size: f64,
    /// Steps up to there.
    pub step: u64,
    /// Time there.
    pub t: f64,
}

messages! { DerivativeError:
    Self { by, ln_size, step, t } if ln_size.is_finite() =>
        "after {step} steps, at t = {}, the derivative by {by} has the size e^{ln_size:.6}, which `f64` cannot hold; take the run in \
         parts, each from the end of the one before, and multiply their matrices with a factor taken out",
        ShortestDecimal(*t);
    Self { by, ln_size: _, step, t } =>
        "step {step} from t = {} has no finite derivative by {by}, although its end is finite: the Hamiltonian has no second \
         derivative there, or a constant none at its value",
        ShortestDecimal(*t);
}
