//! Runs that another thread watches: their progress, and a request to stop.
//!
//! ```ignore
//! let handle = Handle::new();
//! std::thread::scope(|scope| {
//!     scope.spawn(|| {
//!         sleep(Duration::from_secs(60));
//!         println!("{:?}", handle.progress());
//!         handle.stop();
//!     });
//!     let statistics = kubo.ensemble::<Midpoint>(0.02).handle(&handle) /* ... */ .run()?;
//!     println!("{}", statistics.is_partial());
//! });
//! ```
//!
//! A stopped run keeps its results so far, and writes its checkpoint, if it has one.
//! [`run_partial`](crate::trajectory::simulate::Simulation::run_partial) of a single path returns the path
//! with `Error::Stopped`; averages, ensembles and multilevel runs return their results, marked as partial.
//!
//! Tested by `tests/ensembles/control.rs`.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// How far a run is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Progress {
    /// The work that is done, in paths of an ensemble or steps of any other run.
    pub done: u64,
    /// The total, as far as it is known.
    pub all: u64,
}

/// Stops runs from any thread, and knows their progress. A clone is the same handle.
#[derive(Clone, Default)]
pub struct Handle(Arc<HandleState>);

#[derive(Default)]
pub(super) struct HandleState {
    pub(super) is_stopped: AtomicBool,
    /// Whether Ctrl-C stops the runs.
    hears_interrupt: AtomicBool,
    done: AtomicU64,
    all: AtomicU64,
    report: Option<Box<dyn Fn(Progress) + Send + Sync>>,
}

impl fmt::Debug for Handle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut fields = f.debug_struct("Handle");
        fields.field("is_stopped", &self.is_stopped()).field("progress", &self.progress());
        fields.finish_non_exhaustive()
    }
}

impl Handle {
    /// A handle for one run, or for several.
    pub fn new() -> Self {
        Self::default()
    }

    /// A handle whose runs call `report` about ten times a second, from one of their threads.
    pub fn reporting(report: impl Fn(Progress) + Send + Sync + 'static) -> Self {
        Self(Arc::new(HandleState { report: Some(Box::new(report)), ..HandleState::default() }))
    }

    /// Lets Ctrl-C stop the runs of this handle instead of ending the program; a second Ctrl-C ends it. A
    /// program with a signal handler of its own keeps that handler, and calls [`Handle::stop`] in it.
    #[cfg(all(feature = "interrupt", not(target_family = "wasm")))]
    #[must_use = "it is the handle to give to runs"]
    pub fn on_interrupt(self) -> Self {
        self.0.hears_interrupt.store(true, Ordering::Relaxed);
        super::interrupt::watch(&self.0);
        self
    }

    /// Stops its runs, those under way and those that begin later, within about a tenth of a second or with
    /// the step that is being taken.
    pub fn stop(&self) {
        self.0.is_stopped.store(true, Ordering::Relaxed);
    }

    /// Whether the runs of the handle were stopped.
    pub fn is_stopped(&self) -> bool {
        self.0.is_stopped.load(Ordering::Relaxed)
    }

    /// The progress of the run that reported last.
    pub fn progress(&self) -> Progress {
        Progress { done: self.0.done.load(Ordering::Relaxed), all: self.0.all.load(Ordering::Relaxed) }
    }

    pub(super) fn hears_interrupt(&self) -> bool {
        self.0.hears_interrupt.load(Ordering::Relaxed)
    }

    /// A run has come so far.
    pub(super) fn reach(&self, done: u64, all: u64) {
        self.0.done.store(done, Ordering::Relaxed);
        self.0.all.store(all, Ordering::Relaxed);
    }

    pub(super) fn report(&self) {
        if let Some(report) = &self.0.report {
            report(self.progress());
        }
    }
}
