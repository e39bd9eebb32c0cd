//! The file of one run: read once, then replaced again and again, unless someone else changes it.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use super::error::{CheckpointError, Difference};
use super::format::{self, Content, Unreadable, VERSION};
use super::replace::{remove_parts, replace};

/// Where a run writes itself down.
#[derive(Debug)]
pub(super) struct Own {
    path: PathBuf,
    /// The first line of the file as this run left it; `None` before there is one.
    line: Option<Vec<u8>>,
}

impl Own {
    pub(super) fn new(path: &Path) -> Self {
        Self { path: path.to_owned(), line: None }
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// What the file says; `None` if there is none.
    pub(super) fn read<C: Content>(&mut self) -> Result<Option<C>, CheckpointError> {
        let bytes = match fs::read(&self.path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            bytes => bytes.map_err(CheckpointError::file(&self.path, "read"))?,
        };
        self.line = Some(format::first_line(&bytes).to_owned());
        let path = self.path.clone();
        format::decode(&bytes).map(Some).map_err(|why| match why {
            Unreadable::Foreign => CheckpointError::Foreign { path },
            Unreadable::Kind(kind) => CheckpointError::Kind { path, kind },
            Unreadable::Version(found) => CheckpointError::Version { path, found, expected: VERSION },
            Unreadable::Damaged(damage) => CheckpointError::Damaged { path, damage },
        })
    }

    /// Replaces what the file says.
    pub(super) fn write<C: Content>(&mut self, content: &C) -> Result<(), CheckpointError> {
        let bytes = format::encode(content).map_err(|damage| CheckpointError::damaged(&self.path, damage))?;
        replace(&self.path, &bytes).map_err(CheckpointError::file(&self.path, "write"))?;
        self.line = Some(format::first_line(&bytes).to_owned());
        Ok(())
    }

    /// Whether the file is as this run left it: nothing of another run is replaced.
    pub(super) fn check_ours(&self) -> Result<(), CheckpointError> {
        let file = match File::open(&self.path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            file => Some(file.map_err(CheckpointError::file(&self.path, "read"))?),
        };
        let is_ours = match (&self.line, file) {
            (None, None) => true,
            (Some(line), Some(file)) => {
                let mut start = Vec::with_capacity(line.len());
                let read = file.take(line.len() as u64).read_to_end(&mut start);
                read.map_err(CheckpointError::file(&self.path, "read"))?;
                start == *line
            }
            _ => false,
        };
        if is_ours { Ok(()) } else { Err(CheckpointError::Taken { path: self.path.clone() }) }
    }

    /// Removes what a run left behind that was stopped while it wrote.
    pub(super) fn remove_parts<C: Content>(&self) {
        remove_parts(&self.path, C::MAGIC.as_bytes());
    }

    pub(super) fn other_run(&self, differences: Vec<Difference>) -> CheckpointError {
        CheckpointError::OtherRun { path: self.path.clone(), differences }
    }
}
