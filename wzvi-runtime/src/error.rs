//! Errors. Each says where, why and what to do; none leaves a state changed.

/// Writes the messages of an error: for each pattern of the type a format and its arguments. The message of
/// an error contains those of its causes, so that none has a source.
macro_rules! messages {
    ($type:ty: $($pattern:pat $(if $guard:expr)? => $format:literal $(, $argument:expr)*;)+) => {
        impl std::fmt::Display for $type {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                match self {
                    $($pattern $(if $guard)? => write!(f, $format $(, $argument)*),)+
                }
            }
        }

        impl std::error::Error for $type {}
    };
}
pub(crate) use messages;

mod words;

mod bath;
mod derivative;
mod failed;
mod failure;
mod index;
mod internal;
mod noise;
mod stopped;

use crate::ground::digits::ShortestDecimal;
pub use bath::BathError;

pub use derivative::DerivativeError;
pub use failed::FailedLanes;
pub use failure::StepFailure;
#[doc(hidden)]
pub use index::Name;
pub use index::{IndexError, IndexLimit};
pub use internal::{InternalError, StepPromise};
pub use noise::NoiseError;
pub use stopped::StoppedError;

/// A step that failed. The state is unchanged, bit for bit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepError {
    /// Steps that this stepper had taken before.
    pub step: u64,
    /// Time at the start of the step.
    pub t: f64,
    /// Step size; NaN of a step by a clock, whose size is not known where it fails.
    pub h: f64,
    /// Why.
    pub cause: StepFailure,
}

messages! { StepError:
    Self { step, t, h, cause } if h.is_nan() => "step {step} from t = {} by a clock: {cause}", ShortestDecimal(*t);
    Self { step, t, h, cause } => "step {step} from t = {} with h = {}: {cause}", ShortestDecimal(*t), ShortestDecimal(*h);
}

/// A run that cannot start.
#[derive(Clone, Debug, PartialEq)]
pub enum ConfigError {
    /// The step size is zero, NaN or infinite.
    StepSize(f64),
    /// The step of a clock is not a positive number.
    Eps(f64),
    /// A small system indexes beyond the end of a `Vec`, or an entry of a list is NaN.
    Parameter,
    /// A field of the system is NaN.
    NotANumber {
        /// Its name in the Hamiltonians.
        parameter: &'static str,
    },
    /// An integer of the system is out of range.
    Index(IndexError),
    /// Friction, temperature or masses are invalid.
    Bath(BathError),
    /// A matrix that does not change from step to step is singular.
    Singular {
        /// Step size.
        h: f64,
        /// Absolute value of the pivot.
        pivot: f64,
        /// Largest absolute value in the matrix.
        scale: f64,
    },
    /// An increment within the truncation reaches a pole of the step: there the step has no solution, and
    /// near it any. Computed for noises whose Hamiltonian is quadratic, with the drift at the start.
    Pole {
        /// The noise, from 0.
        noise: usize,
        /// Step size.
        h: f64,
        /// The increment at the pole, in absolute value.
        increment: f64,
        /// The largest increment of the run, in absolute value.
        bound: f64,
        /// A step size whose increments reach no pole.
        largest: f64,
    },
    /// A setting that the builder needs is missing.
    Missing(&'static str),
    /// The end of the run is NaN, infinite, on the wrong side of the start, or more steps away than can be
    /// counted; or times are so late that steps of this size end where they begin.
    End {
        /// Start time.
        start: f64,
        /// End time asked for.
        end: f64,
        /// Step size.
        h: f64,
    },
    /// The start has the wrong number of components, or one of them is not finite.
    Start(StepFailure),
    /// The start of a path of an ensemble has the wrong number of components, or one of them is not finite.
    PathStart {
        /// Number of the path, from 0.
        path: u64,
        /// The failure of the step.
        cause: StepFailure,
    },
    /// The system of a path of an ensemble cannot be run.
    PathSystem {
        /// Number of the path, from 0.
        path: u64,
        /// The error of the system.
        cause: Box<ConfigError>,
    },
    /// Something was asked for that needs a bath at one constant temperature.
    NoEquilibrium {
        /// The method that needs the temperature, as it is written.
        asked: &'static str,
        /// Why there is no such temperature.
        why: &'static str,
        /// The methods to call instead.
        instead: &'static str,
    },
    /// A setting of a noise or a builder is invalid; the message says what to do.
    Setting(String),
}

messages! { ConfigError:
    Self::Eps(eps) => "`Eps({})`: the step of a clock is a positive number, 0.3 for example; a run goes backwards where its end is before its start", ShortestDecimal(*eps);
    Self::StepSize(h) => "the step size is {}; it must be finite and not zero", ShortestDecimal(*h);
    Self::Parameter =>
        "a Hamiltonian indexes beyond the end of a `Vec`, a parameter of the system is NaN, or what a step computes from parameters and its \
         size overflows";
    Self::NotANumber { parameter } => "the parameter `{parameter}` of the system is NaN";
    Self::Index(error) => "{error}";
    Self::Bath(error) => "{error}";
    Self::Singular { h, pivot, scale } =>
        "the matrix of the step is singular for h = {} (pivot {pivot:.1e} at scale {scale:.1e}); \
         take another step size", ShortestDecimal(*h);
    Self::Pole { noise, h, increment, bound, largest } =>
        "a step of {} has a pole where the increment of noise {noise} is ±{increment:.3}, and increments of such steps are truncated at ±{bound:.3} only; \
         take steps of at most {}", ShortestDecimal(*h), ShortestDecimal(*largest);
    Self::Missing(what) => "the run needs {what}";
    Self::End { start, end, h } =>
        "cannot run from t = {} to t = {} in steps of {}; check the sign of h, and its size, which must not vanish beside t",
        ShortestDecimal(*start), ShortestDecimal(*end), ShortestDecimal(*h);
    Self::Start(cause) => "the start is not usable: {cause}";
    Self::PathSystem { path, cause } => "the system of path {path} is not usable: {cause}";
    Self::PathStart { path, cause } => "the start of path {path} is not usable: {cause}";
    Self::NoEquilibrium { asked, why, instead } =>
        "`{asked}` needs one constant temperature of a heat bath, but {why}: {instead}";
    Self::Setting(what) => "{}", what;
}

/// Refuses a setting; `what` says what is wrong with it, and what to do.
pub(crate) fn wrong<T, E: From<ConfigError>>(what: impl Into<String>) -> Result<T, E> {
    Err(ConfigError::Setting(what.into()).into())
}

/// Refuses a number that is not finite and above 0, in the words `what`.
pub(crate) fn above_zero<E: From<ConfigError>>(
    x: f64,
    what: impl Fn(ShortestDecimal) -> String,
) -> Result<(), E> {
    match x.is_finite() && x > 0.0 {
        true => Ok(()),
        false => wrong(format!("{}: take a finite number above 0", what(ShortestDecimal(x)))),
    }
}

/// An unknown name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownName {
    /// The kind of thing with a name: `observable`, `event` or `variable`.
    pub kind: &'static str,
    /// The name.
    pub name: String,
    /// The names that exist.
    pub known: Vec<String>,
}

impl UnknownName {
    /// The thing with this name among all of its kind.
    pub(crate) fn find<N: AsRef<str>, T>(
        kind: &'static str,
        name: &str,
        all: impl Iterator<Item = (N, T)> + Clone,
    ) -> Result<T, Self> {
        let known = all.clone().map(|(known, _)| known.as_ref().to_owned());
        let unknown = || Self { kind, name: name.to_owned(), known: known.collect() };
        all.clone().find(|(known, _)| known.as_ref() == name).map(|(_, found)| found).ok_or_else(unknown)
    }
}

messages! { UnknownName:
    Self { kind, name, known } if known.is_empty() => "no {kind} has the name `{name}`: the run has none";
    Self { kind, name, known } => "no {kind} has the name `{name}`: there are `{}`", known.join("`, `");
}
