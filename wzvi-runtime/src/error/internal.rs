//! What the library promises to itself.

/// A mistake of wzvi and not of its user: something that it relies on does not hold. Nothing was returned that depends on it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InternalError {
    promise: &'static str,
    data: String,
}

#[cfg(feature = "ensemble")]
impl InternalError {
    /// `promise` does not hold, as `data` shows.
    pub(crate) fn new(promise: &'static str, data: impl std::fmt::Display) -> Self {
        Self { promise, data: data.to_string() }
    }
}

messages! { InternalError:
    Self { promise, data } =>
        "this is a mistake of wzvi {}, not of yours; please report it: this should hold: {promise} ({data})",
        env!("CARGO_PKG_VERSION");
}
