//! What an ensemble is, for its checkpoint.
//!
//! Chunks are merged in the order of their numbers, so that what is known of the first `n` is all that the others need: a
//! run that goes on merges the same chunks in the same order as one that was never stopped.

use super::identity::{self, Fields};
use super::keeper::Described;
use crate::algebra::state::{State, Vector};
use crate::scheme::system::{Discretized, PreparedOf};

impl Described {
    /// `settings` are those that only ensembles have, `observed` what the observables are at some states.
    pub(crate) fn of_ensemble<H: Discretized<E>, E>(
        system: &H,
        prepared: &PreparedOf<H, E>,
        h: f64,
        start: &State<H::Vector>,
        settings: Fields,
        observed: &[f64],
    ) -> Self {
        let mut all = identity::scheme::<H, E>(system, start.q.components().len(), h);
        all.extend(identity::parameters(system));
        all.extend(settings);
        let mut derived = identity::derived(system, prepared, start);
        let observed = identity::checksum(observed.iter().map(|number| number.to_bits()));
        derived.push(("what the observables and events are on path 0 (checksum)".to_owned(), observed));
        Self::new(all, derived, start)
    }
}
