//! Threads that share the work of one call.

use std::num::NonZero;
use std::panic::resume_unwind;
use std::sync::{Mutex, PoisonError};
use std::thread;

use crate::error::ConfigError;

/// The number of threads for one step of a large system.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Threads {
    /// The caller's thread alone.
    #[default]
    Caller,
    /// As many as pay off, at most one for each core.
    Cores,
    /// This number, as far as the system is large enough to be divided.
    Exactly(NonZero<usize>),
}

impl Threads {
    /// So many, or [`Threads::Cores`] if none are asked for.
    ///
    /// # Errors
    /// [`ConfigError::Setting`] for zero.
    pub(crate) fn asked(threads: Option<usize>) -> Result<Self, ConfigError> {
        let Some(threads) = threads else { return Ok(Self::Cores) };
        let none = || ConfigError::Setting("0 threads: take at least 1".into());
        NonZero::new(threads).map(Self::Exactly).ok_or_else(none)
    }

    /// Their number for work of which as many parts as `pay` are worth a thread each.
    pub(crate) fn number(self, pay: usize) -> usize {
        match self {
            Self::Caller => 1,
            Self::Exactly(number) => number.get(),
            Self::Cores if pay < 2 => 1,
            Self::Cores => cores().min(pay),
        }
    }
}

/// Threads that run at one time; one where the system does not say.
pub(crate) fn cores() -> usize {
    thread::available_parallelism().map_or(1, NonZero::get)
}

/// Runs on the caller's thread and on `others` at one time. A panic goes on in the caller.
pub(crate) fn with_threads(others: usize, run: &(dyn Fn() + Sync)) {
    thread::scope(|scope| {
        // If the system refuses a thread, there is one fewer.
        let spawned: Vec<_> =
            (0..others).map_while(|_| thread::Builder::new().spawn_scoped(scope, run).ok()).collect();
        run();
        for thread in spawned {
            if let Err(panic) = thread.join() {
                resume_unwind(panic);
            }
        }
    });
}

/// Does each job once, each on a thread of its own if the system allows, otherwise on fewer.
pub(crate) fn each<J: Send>(jobs: Vec<J>, work: impl Fn(J) + Sync) {
    let others = jobs.len().saturating_sub(1);
    let jobs = Mutex::new(jobs.into_iter());
    let next = || jobs.lock().unwrap_or_else(PoisonError::into_inner).next();
    with_threads(others, &|| {
        while let Some(job) = next() {
            work(job);
        }
    });
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU64, Ordering};

    use super::*;

    #[test]
    fn each_job_is_done_once() {
        for count in [0, 1, 2, 7] {
            let (sum, number) = (AtomicU64::new(0), AtomicU64::new(0));
            each((0..count).collect(), |job: u64| {
                sum.fetch_add(job * job, Ordering::SeqCst);
                number.fetch_add(1, Ordering::SeqCst);
            });
            assert_eq!(number.into_inner(), count);
            assert_eq!(sum.into_inner(), (0..count).map(|job| job * job).sum::<u64>());
        }
    }

    #[test]
    fn none_are_refused_and_no_more_are_taken_than_pay() {
        assert!(matches!(Threads::asked(Some(0)), Err(ConfigError::Setting(_))));
        assert_eq!(Threads::asked(None), Ok(Threads::Cores));
        assert_eq!(Threads::asked(Some(5)).map(|threads| threads.number(0)), Ok(5));
        assert_eq!(Threads::Cores.number(1), 1);
        assert!(Threads::Cores.number(3) <= cores().min(3));
        assert_eq!(Threads::Caller.number(100), 1);
    }
}
