//! Too many paths that failed.

use std::fmt;

use super::{PathFailure, Statistics};

/// More paths failed than the run allows ([`Ensemble::allow_losses`](crate::ensemble::Ensemble::allow_losses)): the means are those of the others, and
/// nothing says how far the lost ones would have moved them.
#[derive(Clone, PartialEq)]
pub struct LossError {
    /// Paths that failed.
    pub failed: u64,
    /// Paths in all.
    pub begun: u64,
    /// The fraction that is allowed.
    pub allowed: f64,
    /// The first that failed.
    pub first: PathFailure,
    /// What is known of the others.
    pub statistics: Box<Statistics>,
}

/// Without the statistics, which are long.
impl fmt::Debug for LossError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { failed, begun, allowed, first, statistics: _ } = self;
        let mut fields = f.debug_struct("LossError");
        fields.field("failed", failed).field("begun", begun).field("allowed", allowed).field("first", first);
        fields.finish_non_exhaustive()
    }
}

impl fmt::Display for LossError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { failed, begun, allowed, first, .. } = self;
        write!(
            f,
            "{failed} of {begun} paths failed, more than the fraction of {allowed} that is allowed, and are missing in the means; the first, \
             path {}: {}. Halve steps that fail with `.retry(Retry::halving(n))`, take a smaller step, or add `.allow_losses(fraction)`",
            first.path, first.error
        )
    }
}

impl std::error::Error for LossError {}
