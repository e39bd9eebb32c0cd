//! Assumptions of the library about itself, and the error if one does not hold.

/// A bug of wzvi, not of its user: an assumption of the library does not hold. Nothing was returned that
/// depends on it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InternalError {
    promise: &'static str,
    data: String,
}

/// How every message about one begins.
pub(super) const MISTAKE: &str = concat!(
    "this is a bug in wzvi ",
    env!("CARGO_PKG_VERSION"),
    ", not a mistake of yours; please report it: an assumption does not hold"
);

impl InternalError {
    /// `promise` does not hold, as `data` shows.
    pub(crate) fn new(promise: &'static str, data: impl std::fmt::Display) -> Self {
        Self { promise, data: data.to_string() }
    }
}

/// An assumption of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepPromise {
    /// A system whose steps go tile by tile has tiles.
    Tiles,
    /// Friction and noise are taken together with the drifts around them only where rates and masses are
    /// lists.
    ListedRates,
    /// The constants of a step have derivatives only where its scheme takes them along.
    PlainConstants,
    /// Friction and noise of a bath are parts of steps with a bath.
    Bath,
    /// A step with constraints has room for each of its drifts.
    ConstraintRoom,
    /// Words on a manifold have drifts, kicks, and friction and noise.
    ConstraintParts,
}

impl StepPromise {
    pub(super) const ALL: [Self; 6] = [
        Self::Tiles,
        Self::ListedRates,
        Self::PlainConstants,
        Self::Bath,
        Self::ConstraintRoom,
        Self::ConstraintParts,
    ];
}

messages! { StepPromise:
    Self::Tiles => "a system whose steps go tile by tile has tiles";
    Self::ListedRates => "friction and noise are taken together with drifts only where rates and masses are lists";
    Self::PlainConstants => "the constants of a step have derivatives only where its scheme takes them along";
    Self::Bath => "friction and noise of a bath are parts of steps with a bath";
    Self::ConstraintRoom => "a step with constraints has room for each of its drifts";
    Self::ConstraintParts => "words on a manifold have drifts, kicks, and friction and noise";
}

messages! { InternalError:
    Self { promise, data } =>
        "{MISTAKE}: {promise} ({data})";
}
