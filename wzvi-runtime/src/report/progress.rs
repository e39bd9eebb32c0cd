//! Progress on a terminal, and Ctrl-C.

use std::sync::Once;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use indicatif::{ProgressBar, ProgressStyle};

/// A bar with the time that remains; nothing at all unless standard error is a terminal.
pub(crate) struct Progress(ProgressBar);

impl Progress {
    pub(crate) fn new(title: &str, work: usize) -> Self {
        let bar = ProgressBar::new(work as u64);
        let style = "{msg} [{wide_bar}] {percent} %, {eta} left (Ctrl-C keeps what is measured)";
        if let Ok(style) = ProgressStyle::with_template(style) {
            bar.set_style(style);
        }
        bar.set_message(title.to_owned());
        Self(bar)
    }

    pub(crate) fn advance(&self, work: usize) {
        self.0.inc(work as u64);
    }

    pub(crate) fn finish(&self) {
        self.0.finish_and_clear();
    }
}

static REQUESTED: AtomicBool = AtomicBool::new(false);
static MEASURING: AtomicUsize = AtomicUsize::new(0);
static HANDLER: Once = Once::new();

/// Ctrl-C during a measurement ends that; a second one, or one outside, the program.
pub(crate) struct Interrupt(());

impl Interrupt {
    pub(crate) fn watch() -> Self {
        // A program with a handler of its own keeps it.
        HANDLER.call_once(|| drop(ctrlc::try_set_handler(on_interrupt)));
        MEASURING.fetch_add(1, Ordering::SeqCst);
        Self(())
    }

    pub(crate) fn requested(&self) -> bool {
        REQUESTED.load(Ordering::Relaxed)
    }
}

impl Drop for Interrupt {
    fn drop(&mut self) {
        if MEASURING.fetch_sub(1, Ordering::SeqCst) == 1 {
            REQUESTED.store(false, Ordering::SeqCst);
        }
    }
}

fn on_interrupt() {
    let again = REQUESTED.swap(true, Ordering::SeqCst);
    if again || MEASURING.load(Ordering::SeqCst) == 0 {
        std::process::exit(130);
    }
}
