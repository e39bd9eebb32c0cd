//! The time, where there is one: targets such as `wasm32-unknown-unknown` have no clock, and asking for it
//! there is a trap.

use std::time::{Duration, Instant, SystemTime};

const IS_THERE: bool = !cfg!(all(target_family = "wasm", target_os = "unknown"));

pub(crate) fn now() -> Option<Instant> {
    IS_THERE.then(Instant::now)
}

pub(crate) fn date() -> Option<SystemTime> {
    IS_THERE.then(SystemTime::now)
}

/// The time that has gone by since a moment.
pub(crate) fn since(moment: Instant) -> Duration {
    now().map_or(Duration::ZERO, |now| now.duration_since(moment))
}
