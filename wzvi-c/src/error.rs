//! The error of a task: a text, and its kind as a short word for programs.

use std::fmt;

use wzvi::Error;

/// The error of a task.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TaskError {
    /// Its kind, one of those of [`TaskError::from`] or of the constructors.
    pub code: &'static str,
    /// What is wrong, where, and what to do.
    pub text: String,
}

impl TaskError {
    /// A setting that is missing, unknown or invalid.
    pub fn setting(text: impl Into<String>) -> Self {
        Self { code: "setting", text: text.into() }
    }

    /// A run that was stopped and has its results up to there.
    pub fn stopped() -> Self {
        Self {
            code: "stopped",
            text: "the run was stopped: its results are those of the work that is done".into(),
        }
    }

    /// A panic: a mistake of the library.
    pub fn panicked(text: &str) -> Self {
        Self { code: "panic", text: format!("the run panicked, which is a mistake of wzvi: {text}") }
    }
}

impl fmt::Display for TaskError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl<E: Into<Error>> From<E> for TaskError {
    fn from(error: E) -> Self {
        let error = error.into();
        let code = match &error {
            Error::Config(_) => "setting",
            Error::Name(_) => "name",
            Error::Noise(_) => "noise",
            Error::Step(_) => "step",
            Error::Derivative(_) => "derivative",
            Error::Stopped(_) => "stopped",
            Error::Losses(_) => "losses",
            Error::Internal(_) => "internal",
            _ => "other",
        };
        Self { code, text: error.to_string() }
    }
}
