//! Ctrl-C during a long computation ends that, not the program.

use std::sync::Once;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

static REQUESTED: AtomicBool = AtomicBool::new(false);
static WATCHING: AtomicUsize = AtomicUsize::new(0);
static HANDLER: Once = Once::new();

/// Ctrl-C while this lives is noted; a second one, or one outside, ends the program.
pub(crate) struct Interrupt(());

impl Interrupt {
    pub(crate) fn watch() -> Self {
        // A program with a handler of its own keeps it.
        HANDLER.call_once(|| drop(ctrlc::try_set_handler(on_interrupt)));
        WATCHING.fetch_add(1, Ordering::SeqCst);
        Self(())
    }

    pub(crate) fn requested(&self) -> bool {
        REQUESTED.load(Ordering::Relaxed)
    }
}

impl Drop for Interrupt {
    fn drop(&mut self) {
        if WATCHING.fetch_sub(1, Ordering::SeqCst) == 1 {
            REQUESTED.store(false, Ordering::SeqCst);
        }
    }
}

fn on_interrupt() {
    let again = REQUESTED.swap(true, Ordering::SeqCst);
    if again || WATCHING.load(Ordering::SeqCst) == 0 {
        std::process::exit(130);
    }
}
