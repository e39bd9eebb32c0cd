//! The time, where there is one: targets such as `wasm32-unknown-unknown` have no clock, and asking for it there is a trap.

use std::time::Duration;

#[cfg(not(all(target_family = "wasm", target_os = "unknown")))]
mod there {
    #[cfg(feature = "report")]
    use std::time::SystemTime;
    use std::time::{Duration, Instant};

    pub(crate) type Moment = Instant;

    pub(crate) fn now() -> Option<Moment> {
        Some(Instant::now())
    }

    pub(crate) fn between(earlier: &Moment, later: &Moment) -> Duration {
        later.duration_since(*earlier)
    }

    #[cfg(feature = "report")]
    pub(crate) fn date() -> Option<SystemTime> {
        Some(SystemTime::now())
    }
}

#[cfg(all(target_family = "wasm", target_os = "unknown"))]
mod there {
    use std::time::Duration;

    /// There is none.
    #[derive(Clone, Copy, Debug)]
    pub(crate) enum Moment {}

    pub(crate) fn now() -> Option<Moment> {
        None
    }

    pub(crate) fn between(_: &Moment, later: &Moment) -> Duration {
        match *later {}
    }

    #[cfg(feature = "report")]
    pub(crate) fn date() -> Option<std::time::SystemTime> {
        None
    }
}

#[cfg(feature = "report")]
pub(crate) use there::date;
pub(crate) use there::{Moment, between, now};

/// The time that has gone by since a moment.
pub(crate) fn since(moment: &Moment) -> Duration {
    now().map_or(Duration::ZERO, |now| between(moment, &now))
}
