//! A setting that several methods of a builder make, of which a run takes one.

use std::fmt::Display;

use crate::error::{ConfigError, wrong};

/// A setting that one of several methods makes: `until` or `steps`, `seed` or `noise`.
#[derive(Clone, Debug)]
pub(crate) struct ExclusiveSetting<T> {
    value: Option<T>,
    /// The methods that were called, each with the arguments of its last call.
    calls: Vec<(&'static str, String)>,
}

impl<T> Default for ExclusiveSetting<T> {
    fn default() -> Self {
        Self { value: None, calls: Vec::new() }
    }
}

impl<T> ExclusiveSetting<T> {
    /// Sets the value by a method, with its arguments in words. Another call of the same method replaces the
    /// one before.
    pub(crate) fn set(&mut self, method: &'static str, arguments: impl Display, value: T) {
        let call = (method, arguments.to_string());
        match self.calls.iter_mut().find(|(other, _)| *other == method) {
            Some(before) => *before = call,
            None => self.calls.push(call),
        }
        // Messages are the same in whatever order methods were called.
        self.calls.sort_unstable_by(|(a, _), (b, _)| b.cmp(a));
        self.value = Some(value);
    }

    /// The value that was set last.
    pub(crate) fn value(&self) -> Option<&T> {
        self.value.as_ref()
    }

    /// Checks that one method has set it at most; `rule` says why.
    ///
    /// # Errors
    /// [`ConfigError::Setting`] with two methods that have.
    pub(crate) fn check(&self, rule: &str) -> Result<(), ConfigError> {
        match &self.calls[..] {
            [(a, of_a), (b, of_b), ..] => {
                wrong(format!("`{a}({of_a})` and `{b}({of_b})`: {rule}; leave one of them out"))
            }
            _ => Ok(()),
        }
    }

    /// The value, if one method has set it.
    ///
    /// # Errors
    /// The errors of [`ExclusiveSetting::check`].
    pub(crate) fn checked(self, rule: &str) -> Result<Option<T>, ConfigError> {
        self.check(rule)?;
        Ok(self.value)
    }
}

/// In the place of arguments that have no words.
pub(crate) const SOME: &str = "...";
