//! What a source of increments is.

use std::fmt::Debug;

/// What a source of increments is: its kind and its settings, by name. Two sources with equal identities give the same
/// increments for the same step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Identity {
    settings: Vec<(String, String)>,
}

impl Identity {
    /// A source of this kind, a name that no other source has.
    pub fn of(kind: &str) -> Self {
        Self { settings: vec![("noise".to_owned(), kind.to_owned())] }
    }

    /// A source with this setting as well, which is compared as its `Debug` text. That of a number is exact.
    pub fn with(mut self, name: &str, value: impl Debug) -> Self {
        self.settings.push((format!("noise {name}"), format!("{value:?}")));
        self
    }

    /// The same settings of another kind of source.
    #[cfg(feature = "noise")]
    pub(crate) fn renamed(mut self, kind: &str) -> Self {
        self.settings[0].1 = kind.to_owned();
        self
    }

    /// Names and values, the kind first.
    #[cfg(feature = "serde")]
    pub(crate) fn into_settings(self) -> Vec<(String, String)> {
        self.settings
    }
}
