//! The identity of a source of increments.
//!
//! Tested by `tests/paths/checkpoint/other_run.rs`.

use std::fmt::{self, Debug};

/// The identity of a source of increments: its kind and its settings, by name. Two sources with equal
/// identities give the same increments for the same step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Identity {
    settings: Vec<(String, String)>,
}

impl Identity {
    /// The identity of a source of this kind, a name that no other source has.
    pub fn of(kind: &str) -> Self {
        Self { settings: vec![("noise".to_owned(), kind.to_owned())] }
    }

    /// Adds a setting, which is compared by its `Debug` text. The text of a number is exact.
    pub fn with(mut self, name: &str, value: impl Debug) -> Self {
        self.settings.push((format!("noise {name}"), format!("{value:?}")));
        self
    }

    /// The settings of this source, with another kind.
    #[cfg(feature = "noise")]
    pub(crate) fn renamed(mut self, kind: &str) -> Self {
        self.settings[0].1 = kind.to_owned();
        self
    }

    /// Names and values, the kind first.
    pub(crate) fn into_settings(self) -> Vec<(String, String)> {
        self.settings
    }
}

/// The kind, and the settings in brackets.
impl fmt::Display for Identity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut settings = self.settings.iter();
        if let Some((_, kind)) = settings.next() {
            write!(f, "{kind}")?;
        }
        let mut separator = " (";
        for (name, value) in settings {
            write!(f, "{separator}{} {value}", name.trim_start_matches("noise "))?;
            separator = "; ";
        }
        if separator == "; " { write!(f, ")") } else { Ok(()) }
    }
}
