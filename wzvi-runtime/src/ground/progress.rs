//! How far a long run is: one line on a terminal, nothing elsewhere.
//!
//! Tested by `tests/ensembles/control.rs`.

use std::io::{IsTerminal, Write, stderr};
use std::time::{Duration, Instant};

use crate::ground::clock;
use crate::ground::due::Due;
use crate::ground::handle::Handle;

/// Runs that are over by then show nothing.
const PATIENCE: Duration = Duration::from_secs(1);
/// Between two looks at the line.
const PAUSE: Duration = Duration::from_millis(100);

/// A line that shows the progress of a run until this is dropped, and the handle that reports it, too.
pub(crate) struct ProgressLine {
    /// The name of the things that are counted.
    unit: &'static str,
    handle: Option<Handle>,
    /// When the handle's function was called.
    reported: Option<Instant>,
    /// `None` without a terminal or without a clock.
    watch: Option<ProgressTimer>,
    is_shown: bool,
}

struct ProgressTimer {
    began: Instant,
    /// The last look at the line.
    looked: Instant,
    wait: Duration,
}

impl ProgressLine {
    pub(crate) fn new(unit: &'static str, is_quiet: bool, handle: Option<Handle>) -> Self {
        let is_silent = is_quiet || !stderr().is_terminal();
        let now = if is_silent { None } else { clock::now() };
        let watch = now.map(|now| ProgressTimer { began: now, looked: now, wait: PATIENCE });
        Self { unit, handle, reported: None, watch, is_shown: false }
    }

    /// So many are done, of so many.
    pub(crate) fn show(&mut self, done: u64, all: u64) {
        if let Some(handle) = &self.handle {
            handle.reach(done, all);
            if self.reported.is_none_or(|reported| clock::since(reported) >= PAUSE) {
                self.reported = clock::now();
                handle.report();
            }
        }
        let Some(watch) = &mut self.watch else { return };
        let Some(now) = clock::now() else { return };
        if now.duration_since(watch.looked) < watch.wait {
            return;
        }
        (watch.looked, watch.wait) = (now, PAUSE);
        self.is_shown = true;
        let mut line = line(self.unit, done, all, clock::since(watch.began));
        if self.handle.as_ref().is_some_and(Handle::hears_interrupt) {
            line += " (Ctrl-C stops and keeps what is done)";
        }
        // An error of the terminal cannot be reported on the terminal.
        let _ = write!(stderr(), "\r\x1b[K{line}").and_then(|()| stderr().flush());
    }
}

/// How far a single path is, and whether it is to stop. Without a terminal and a handle it is never due.
pub(crate) struct StepsShown<'k> {
    line: Option<(ProgressLine, Due)>,
    stop: Option<&'k dyn Fn() -> bool>,
    /// The nodes from which and to which the run goes.
    first: u64,
    end: u64,
}

impl<'k> StepsShown<'k> {
    /// From one node to another.
    pub(crate) fn new(
        is_quiet: bool,
        handle: Option<Handle>,
        stop: Option<&'k dyn Fn() -> bool>,
        [first, end]: [u64; 2],
    ) -> Self {
        let progress = ProgressLine::new("steps", is_quiet, handle);
        let is_due = progress.watch.is_some() || progress.handle.is_some() || stop.is_some();
        Self { line: is_due.then(|| (progress, Due::new(None, Some(PAUSE), first, end))), stop, first, end }
    }

    /// Counts the steps before the first one as done, too: of one run of several.
    pub(crate) fn with_those_before(self) -> Self {
        Self { first: 0, ..self }
    }

    /// The next node to look at.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn next_node(&self) -> u64 {
        self.line.as_ref().map_or(u64::MAX, |(_, due)| due.next_node())
    }

    /// The run has reached a node; whether its handle or a function wants it to stop there.
    pub(crate) fn at_node(&mut self, node: u64) -> bool {
        let Self { line: Some((progress, due)), stop, .. } = self else { return false };
        if !due.is_due(node) {
            return false;
        }
        progress.show(node.saturating_sub(self.first), self.end.saturating_sub(self.first));
        due.done();
        let is_stopped =
            || progress.handle.as_ref().is_some_and(Handle::is_stopped) || stop.is_some_and(|stop| stop());
        node < self.end && is_stopped()
    }
}

impl Drop for ProgressLine {
    fn drop(&mut self) {
        if self.is_shown {
            let _ = write!(stderr(), "\r\x1b[K").and_then(|()| stderr().flush());
        }
    }
}

fn line(unit: &str, done: u64, all: u64, elapsed: Duration) -> String {
    let part = (done as f64 / all.max(1) as f64).min(1.0);
    let rate = done as f64 / elapsed.as_secs_f64().max(1e-9);
    let left = if rate > 0.0 { all.saturating_sub(done) as f64 / rate } else { f64::INFINITY };
    format!("{:3.0} %, {}{unit}/s, {} left", 100.0 * part, metric(rate), duration(left))
}

/// Three digits and a prefix.
fn metric(rate: f64) -> String {
    let (scaled, prefix) = match rate {
        rate if rate >= 1e9 => (rate / 1e9, " G"),
        rate if rate >= 1e6 => (rate / 1e6, " M"),
        rate if rate >= 1e3 => (rate / 1e3, " k"),
        rate => (rate, " "),
    };
    let digits = if scaled >= 100.0 { 0 } else { 1 };
    format!("{scaled:.digits$}{prefix}")
}

fn duration(seconds: f64) -> String {
    let whole = seconds.ceil() as u64;
    match whole {
        _ if !seconds.is_finite() => "?".into(),
        0..60 => format!("{whole} s"),
        60..3600 => format!("{} min {:02} s", whole / 60, whole % 60),
        _ => format!("{} h {:02} min", whole / 3600, whole % 3600 / 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_says_how_far_how_fast_and_how_long() {
        let line = |done, all, seconds| line("paths", done, all, Duration::from_secs(seconds));
        assert!(
            line(5000, 20_000, 2).starts_with(" 25 %, 2.5 kpaths/s, 6 s left"),
            "{}",
            line(5000, 20_000, 2)
        );
        assert!(line(1, 7201, 1).contains("1.0 paths/s, 2 h 00 min left"));
        assert!(line(3_000_000_000, 3_000_000_000, 2).starts_with("100 %, 1.5 Gpaths/s, 0 s left"));
        assert!(line(100, 7400, 60).contains("1 h 13 min left"));
        assert!(line(4, 400, 3).contains("4 min 57 s left"));
        assert!(line(0, 10, 3).contains("0.0 paths/s, ? left"));
        assert!(line(30, 20, 1).starts_with("100 %"));
        assert!(line(0, 0, 0).starts_with("  0 %"));
    }
}
