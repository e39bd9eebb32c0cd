//! A run that was stopped.

/// A single path was stopped by its [`Handle`](crate::ground::handle::Handle).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StoppedError {
    /// Steps taken.
    pub done: u64,
    /// Steps requested.
    pub all: u64,
}

messages! { StoppedError:
    Self { done, all } =>
        "the run was stopped after {done} of {all} steps; `.run_partial()` returns what is done";
}
