//! Ctrl-C during a long computation ends that, not the program.
//!
//! Tested by `tests/ensembles/control.rs`.

use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, Once, PoisonError, Weak};

use super::handle::HandleState;

static WATCHED: Mutex<Vec<Weak<HandleState>>> = Mutex::new(Vec::new());
static HANDLER: Once = Once::new();

/// Ctrl-C stops the runs of a handle as long as the handle lives.
pub(super) fn watch(handle: &Arc<HandleState>) {
    // A program with a handler of its own keeps it.
    HANDLER.call_once(|| drop(ctrlc::try_set_handler(on_interrupt)));
    WATCHED.lock().unwrap_or_else(PoisonError::into_inner).push(Arc::downgrade(handle));
}

/// A second Ctrl-C, or one that no run waits for, ends the program.
fn on_interrupt() {
    let mut watched = WATCHED.lock().unwrap_or_else(PoisonError::into_inner);
    watched.retain(|handle| handle.strong_count() > 0);
    let stopped = watched.iter().filter_map(Weak::upgrade);
    let newly = stopped.filter(|handle| !handle.is_stopped.swap(true, Ordering::Relaxed)).count();
    if newly == 0 {
        std::process::exit(130);
    }
}
