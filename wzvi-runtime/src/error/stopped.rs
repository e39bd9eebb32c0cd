//! A run that was stopped.

/// A single path was stopped by its [`Handle`](crate::ground::handle::Handle).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StoppedError {
    /// Steps taken.
    pub done: u64,
    /// Steps requested; 2^53 of a run by a clock to a time.
    pub all: u64,
}

/// The steps of a run whose number is not known before its end: of a clock.
const UNKNOWN: u64 = 1 << 53;

messages! { StoppedError:
    Self { done, all: UNKNOWN } =>
        "the run was stopped after {done} steps; `.run_partial()` returns what is done";
    Self { done, all } =>
        "the run was stopped after {done} of {all} steps; `.run_partial()` returns what is done";
}
