//! Progress on a terminal.

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
