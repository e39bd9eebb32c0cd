//! The file of one run: read once, then replaced again and again, unless someone else changes it.

use std::io::{Read, Write};
use std::path::{Path, PathBuf};

use super::format::{self, Content, Unreadable, VERSION};
use crate::error::{CheckpointError, Difference};
use crate::saving::file::{self, Staged};

/// Where a run writes itself down.
#[derive(Debug)]
pub(super) struct Own {
    path: PathBuf,
    /// The first line of the file as this run left it; `None` before there is one.
    line: Option<Vec<u8>>,
}

impl Own {
    /// The file that `path` leads to: a run that names it in another way finds the same one, and what belongs to it.
    pub(super) fn new(path: &Path) -> Result<Self, CheckpointError> {
        Ok(Self { path: file::Target::of(path, "write")?.into_path(), line: None })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// What the file says; `None` if there is none.
    pub(super) fn read<C: Content>(&mut self) -> Result<Option<C>, CheckpointError> {
        let Some(mut file) = file::open(&self.path)? else { return Ok(None) };
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(CheckpointError::file(&self.path, "read"))?;
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
        let staged = Staged::write(&self.path, |file| file.write_all(&bytes))?;
        // Once more: the disk may have taken its time.
        self.check_ours()?;
        staged.publish()?;
        self.line = Some(format::first_line(&bytes).to_owned());
        Ok(())
    }

    /// Whether the file is as this run left it: nothing of another run is replaced.
    pub(super) fn check_ours(&self) -> Result<(), CheckpointError> {
        let is_ours = match (&self.line, file::open(&self.path)?) {
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
        file::remove_parts(&self.path, C::MAGIC.as_bytes());
    }

    pub(super) fn other_run(&self, differences: Vec<Difference>) -> CheckpointError {
        CheckpointError::OtherRun { path: self.path.clone(), differences }
    }
}
