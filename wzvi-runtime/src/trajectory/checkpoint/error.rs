//! Errors of checkpoints.

use std::io;
use std::path::{Path, PathBuf};

use crate::error::{InternalError, messages};
use crate::saving::FileError;

/// A checkpoint that could not be written, or from which no run can resume. No file was changed.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum CheckpointError {
    /// A file could not be read or written. An earlier checkpoint, if there is one, is unchanged.
    File(FileError),
    /// The file is not a checkpoint.
    Foreign {
        /// The file.
        path: PathBuf,
    },
    /// The file is a checkpoint of something else.
    Kind {
        /// The file.
        path: PathBuf,
        /// The kind of run that the checkpoint belongs to.
        kind: &'static str,
    },
    /// The file has another version of the format.
    Version {
        /// The file.
        path: PathBuf,
        /// Its version.
        found: String,
        /// The version that this program reads and writes.
        expected: u32,
    },
    /// The file is a checkpoint, but its content has changed since it was written.
    Damaged {
        /// The file.
        path: PathBuf,
        /// How.
        damage: Damage,
    },
    /// The file is a checkpoint of another run.
    OtherRun {
        /// The file.
        path: PathBuf,
        /// The differences, at least one.
        differences: Vec<Difference>,
    },
    /// The file is of this run, but lies beyond the requested end.
    Beyond {
        /// The file.
        path: PathBuf,
        /// Steps up to the checkpoint.
        step: u64,
        /// Steps asked for.
        steps: u64,
    },
    /// The file is of this ensemble, but has more paths than requested.
    MorePaths {
        /// The file.
        path: PathBuf,
        /// Paths in the checkpoint.
        done: u64,
        /// Paths asked for.
        paths: u64,
    },
    /// Another program wrote the file while this run began. One that does so later is the
    /// [`FileError::Taken`] of a run that goes on.
    Taken {
        /// The file.
        path: PathBuf,
    },
    /// The source of the increments has no identity.
    Noise,
    /// A bug of the library. Nothing was written.
    Internal(InternalError),
}

/// The damage of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Damage {
    /// Its length has changed.
    Length {
        /// Bytes that were written.
        expected: u64,
        /// Bytes found.
        found: u64,
    },
    /// The checksum of its content does not match.
    Checksum {
        /// The checksum that was written.
        expected: u64,
        /// The checksum of the content.
        found: u64,
    },
    /// Its first line cannot be read.
    Header,
    /// Its content is inconsistent.
    Content(String),
}

/// One difference between the run of a checkpoint and this one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// The setting.
    pub field: String,
    /// The value in the checkpoint; `None` if there is none.
    pub checkpoint: Option<String>,
    /// The value in this run; `None` if there is none.
    pub run: Option<String>,
}

impl CheckpointError {
    /// The message of the operating system.
    pub(crate) fn file<'p>(path: &'p Path, action: &'static str) -> impl FnOnce(io::Error) -> Self + use<'p> {
        move |error| Self::File(FileError::system(path, action)(error))
    }
}

messages! { CheckpointError:
    Self::File(error) => "{error}";
    Self::Foreign { path } =>
        "{} is not a file of wzvi; it was not changed: name another file", path.display();
    Self::Kind { path, kind } =>
        "{} is a checkpoint of {kind}; it was not changed: name another file", path.display();
    Self::Version { path, found, expected } =>
        "{} has version {found} of the format, but this program reads version {expected}; finish the run with \
         the program that wrote it, or name another file to start anew", path.display();
    Self::Damaged { path, damage } =>
        "{} is damaged: {damage}; put back a copy, or remove it to start anew", path.display();
    Self::OtherRun { path, differences } =>
        "{} is the checkpoint of another run: {}. Run with the settings of the checkpoint, or name another file to start anew",
        path.display(), in_words(differences);
    Self::Beyond { path, step, steps } =>
        "{} is at step {step}, beyond the {steps} steps of this run; ask for at least {step}, or name \
         another file to start anew", path.display();
    Self::MorePaths { path, done, paths } =>
        "{} has {done} paths, more than the {paths} of this run; ask for at least {done}, or name another \
         file to start anew", path.display();
    Self::Taken { path } =>
        "{} was changed during the run; use it for one run at a time", path.display();
    Self::Internal(error) => "{error}";
    Self::Noise =>
        "the source of the increments has no identity, so a checkpoint cannot tell whether a resumed run has \
         the same source; implement `Noise::identity` for it";
}

messages! { Damage:
    Self::Length { expected, found } => "{expected} bytes were written, but it has {found}";
    Self::Checksum { expected, found } => "its checksum is {found:016x}, not {expected:016x}";
    Self::Header => "its first line cannot be read";
    Self::Content(cause) => "its content is invalid ({cause})";
}

messages! { Difference:
    Self { field, checkpoint, run } => "{field} is {} there and {} here", or_none(checkpoint), or_none(run);
}

fn in_words(differences: &[Difference]) -> String {
    differences.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}

fn or_none(value: &Option<String>) -> &str {
    value.as_deref().unwrap_or("not set")
}

impl From<FileError> for CheckpointError {
    fn from(error: FileError) -> Self {
        Self::File(error)
    }
}
