//! The place and the time of a measurement.

use std::fs;

use serde::{Deserialize, Serialize};

use crate::ground::clock;

/// The program, the machine and the time of a measurement.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// Version of this library.
    pub wzvi: String,
    /// Whether optimised code ran: "release" or "debug".
    pub profile: String,
    /// Model of the processor, as the system names it.
    pub processor: String,
    /// Logical processors that this process may use.
    pub cores: usize,
    /// Operating system.
    pub system: String,
    /// Architecture.
    pub architecture: String,
    /// Start of the measurement, UTC.
    pub date: String,
}

impl Machine {
    /// This machine, now.
    pub fn here() -> Self {
        let unknown = || "unknown".to_owned();
        Self {
            wzvi: env!("CARGO_PKG_VERSION").to_owned(),
            profile: if cfg!(debug_assertions) { "debug" } else { "release" }.to_owned(),
            processor: processor().unwrap_or_else(unknown),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            system: system(),
            architecture: std::env::consts::ARCH.to_owned(),
            date: clock::date()
                .map_or_else(unknown, |now| humantime::format_rfc3339_seconds(now).to_string()),
        }
    }

    /// One line for people.
    pub fn line(&self) -> String {
        let Self { wzvi, profile, processor, cores, system, architecture, date } = self;
        format!("wzvi {wzvi} ({profile}), {processor}, {cores} cores, {system} {architecture}, {date}")
    }
}

fn processor() -> Option<String> {
    field(&fs::read_to_string("/proc/cpuinfo").ok()?, "model name", ':')
}

fn system() -> String {
    let named = || field(&fs::read_to_string("/etc/os-release").ok()?, "PRETTY_NAME", '=');
    match named() {
        Some(name) => format!("{} ({name})", std::env::consts::OS),
        None => std::env::consts::OS.to_owned(),
    }
}

/// The value of a line `key<separator>value`.
fn field(text: &str, key: &str, separator: char) -> Option<String> {
    let value = |line: &str| {
        let (found, value) = line.split_once(separator)?;
        (found.trim() == key).then(|| value.trim().trim_matches('"').to_owned())
    };
    text.lines().find_map(value)
}
