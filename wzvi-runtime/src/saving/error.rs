//! Errors of files.

use std::fs::FileType;
use std::io;
use std::path::{Path, PathBuf};

use crate::error::messages;

/// A file that could not be read or written. An existing file is unchanged.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FileError {
    /// The system refused.
    System {
        /// The file or folder.
        path: PathBuf,
        /// The action that failed, in words.
        action: &'static str,
        /// The kind of the failure.
        kind: io::ErrorKind,
        /// The message of the operating system.
        cause: String,
    },
    /// The name belongs to something other than a regular file.
    Special {
        /// The name.
        path: PathBuf,
        /// The action that is refused, in words.
        action: &'static str,
        /// The kind of thing that has the name: `"a folder"`, `"a device"`, ...
        found: &'static str,
    },
    /// Another run changed the file during this one.
    Taken {
        /// The file.
        path: PathBuf,
    },
}

impl FileError {
    /// The error for a failure that the operating system reports.
    pub(crate) fn system<'p>(
        path: &'p Path,
        action: &'static str,
    ) -> impl FnOnce(io::Error) -> Self + use<'p> {
        move |error| Self::System {
            path: path.to_owned(),
            action,
            kind: error.kind(),
            cause: error.to_string(),
        }
    }

    /// The file or folder.
    pub fn path(&self) -> &Path {
        match self {
            Self::System { path, .. } | Self::Special { path, .. } | Self::Taken { path } => path,
        }
    }
}

/// The kind of a file that is neither a regular file nor a link.
pub(crate) fn name(kind: FileType) -> &'static str {
    if kind.is_dir() {
        return "a folder";
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if kind.is_fifo() {
            return "a pipe";
        }
        if kind.is_socket() {
            return "a socket";
        }
    }
    "a device"
}

messages! { FileError:
    Self::System { path, action, cause, .. } => "cannot {action} {}: {cause}", path.display();
    Self::Special { path, action, found } =>
        "cannot {action} {}: it is {found}; name a regular file", path.display();
    Self::Taken { path } => "{} was changed during the run; use it for one run at a time", path.display();
}
