//! Shared functions known so far.

use syn::{Block, Signature};

/// The functions that a body may call.
#[derive(Default)]
pub(crate) struct Library {
    pub(crate) functions: Vec<SharedFunction>,
    /// The methods of the struct, called as `self.name(...)`.
    pub(crate) methods: Vec<SharedFunction>,
    /// Whether definitions are still to come, so that calls of unknown functions are not yet mistakes.
    pub(crate) is_pending: bool,
}

/// A shared function.
pub(crate) struct SharedFunction {
    /// The path by which it is called, without spaces.
    pub(crate) name: String,
    pub(crate) signature: Signature,
    pub(crate) block: Block,
    /// The functions that it calls.
    pub(crate) library: Library,
    /// Whether its meaning depends on the type from which it is called.
    pub(crate) reads_self: bool,
}
