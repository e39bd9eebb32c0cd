//! The file of the recorded nodes: one line, then a row of words per node, appended once and never changed.
//!
//! The checkpoint says how many rows there are and their checksum. Rows beyond that are what a run wrote before it was
//! stopped; the run that goes on writes the same ones again.

use std::fs::{File, OpenOptions};
use std::io::{BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use crate::algebra::state::{State, Vector};
use crate::error::InternalError;
use crate::error::{CheckpointError, Damage};
use crate::ground::checksum::Checksum;
use crate::path::trajectory::{Kept, Recorder};
use crate::saving::file::{self, flush_folder, with_ending};

const VERSION: u32 = 1;
const HEADER: &[u8] = b"wzvi-nodes 1\n";
const MAGIC: &[u8] = b"wzvi-nodes ";
/// Bytes of a word.
const WORD: usize = 8;
/// Bytes that are written at a time.
const PIECE: usize = 1 << 16;

/// The recorded nodes of a run that are on the disk.
#[derive(Debug)]
pub(super) struct Nodes {
    path: PathBuf,
    /// Bytes per row: `t`, `q`, `p` and the increments since the row before.
    row: usize,
    degrees: usize,
    processes: usize,
    written: usize,
    checksum: Checksum,
    file: Option<File>,
}

impl Nodes {
    pub(super) fn new(checkpoint: &Path, degrees: usize, processes: usize) -> Self {
        Self {
            path: with_ending(checkpoint, ".nodes"),
            row: WORD * (1 + 2 * degrees + processes),
            degrees,
            processes,
            written: 0,
            checksum: Checksum::default(),
            file: None,
        }
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// How many, and their checksum.
    pub(super) fn written(&self) -> (u64, u64) {
        (self.written as u64, self.checksum.value())
    }

    /// Puts the rows of a checkpoint back into `recorder`.
    pub(super) fn read<V: Vector>(
        &mut self,
        count: u64,
        expected: u64,
        recorder: &mut Recorder<V>,
    ) -> Result<(), CheckpointError> {
        let kept = if count == 0 { (vec![], vec![]) } else { self.rows(count)? };
        let found = self.checksum.value();
        if found != expected {
            return Err(CheckpointError::damaged(&self.path, Damage::Checksum { expected, found }));
        }
        recorder.put_back(kept);
        Ok(())
    }

    fn rows<V: Vector>(&mut self, count: u64) -> Result<Kept<V>, CheckpointError> {
        let damaged = |damage| CheckpointError::damaged(&self.path, damage);
        let failed = || CheckpointError::file(&self.path, "read");
        let file = file::open(&self.path)?.ok_or_else(|| damaged(Damage::Missing))?;
        let found = file.metadata().map_err(failed())?.len();
        let mut file = BufReader::new(file);
        check_header(&self.path, &mut file)?;
        // Also if there are more than any file can have.
        let expected = count.saturating_mul(self.row as u64).saturating_add(HEADER.len() as u64);
        if found < expected {
            return Err(damaged(Damage::Length { expected, found }));
        }
        let (mut states, mut increments) = (Vec::new(), Vec::new());
        let mut row = vec![0; self.row];
        for _ in 0..count {
            file.read_exact(&mut row).map_err(failed())?;
            self.checksum.add(&row);
            let (words, _) = row.as_chunks::<WORD>();
            let mut numbers = words.iter().map(|word| f64::from_le_bytes(*word));
            let mut state = State { q: V::zeros(self.degrees), p: V::zeros(self.degrees), t: 0.0 };
            let components = state.q.components_mut().iter_mut().chain(state.p.components_mut());
            for (number, from) in [&mut state.t].into_iter().chain(components).zip(&mut numbers) {
                *number = from;
            }
            states.push(state);
            increments.extend(numbers);
        }
        self.written = states.len();
        Ok((states, increments))
    }

    /// Appends the nodes that were recorded since, and has them written to the disk.
    pub(super) fn append<V: Vector>(&mut self, recorder: &Recorder<V>) -> Result<(), CheckpointError> {
        let (states, increments) = recorder.nodes_after(self.written);
        if states.is_empty() {
            return Ok(());
        }
        if increments.len() != states.len() * self.processes {
            let found =
                format!("{} states, {} increments of {}", states.len(), increments.len(), self.processes);
            let error = InternalError::new("each recorded node has its increments", found);
            return Err(CheckpointError::Internal(error));
        }
        let mut file = match self.file.take() {
            Some(file) => file,
            None => self.open()?,
        };
        let mut checksum = self.checksum;
        let mut write = || {
            let mut buffer = Vec::with_capacity(PIECE.max(self.row));
            for (i, state) in states.iter().enumerate() {
                let dw = &increments[i * self.processes..(i + 1) * self.processes];
                let numbers =
                    [&state.t].into_iter().chain(state.q.components()).chain(state.p.components()).chain(dw);
                if buffer.len() + self.row > PIECE {
                    file.write_all(&buffer)?;
                    buffer.clear();
                }
                let first = buffer.len();
                numbers.for_each(|number| buffer.extend(number.to_bits().to_le_bytes()));
                checksum.add(&buffer[first..]);
            }
            file.write_all(&buffer)?;
            file.sync_data()
        };
        // After a failure the next attempt starts from the row it started from.
        write().map_err(CheckpointError::file(&self.path, "write"))?;
        self.written += states.len();
        self.checksum = checksum;
        self.file = Some(file);
        Ok(())
    }

    /// The file, with its first line, at the row to write next.
    fn open(&self) -> Result<File, CheckpointError> {
        let failed = || CheckpointError::file(&self.path, "write");
        let mut options = OpenOptions::new();
        options.read(true).write(true).create(true).truncate(false);
        let target = file::Target::of(&self.path, "write")?.into_path();
        let mut file = options.open(target).map_err(failed())?;
        let length = file.metadata().map_err(failed())?.len();
        if length < HEADER.len() as u64 {
            let mut start = Vec::new();
            file.read_to_end(&mut start).map_err(failed())?;
            if !HEADER.starts_with(&start) {
                return Err(CheckpointError::Foreign { path: self.path.clone() });
            }
            file.rewind().and_then(|()| file.write_all(HEADER)).map_err(failed())?;
            flush_folder(&self.path).map_err(failed())?;
        } else {
            check_header(&self.path, &mut file)?;
        }
        let offset = HEADER.len() as u64 + self.written as u64 * self.row as u64;
        file.seek(SeekFrom::Start(offset)).map_err(failed())?;
        Ok(file)
    }
}

fn check_header(path: &Path, file: &mut impl Read) -> Result<(), CheckpointError> {
    let mut header = Vec::new();
    file.take(HEADER.len() as u64).read_to_end(&mut header).map_err(CheckpointError::file(path, "read"))?;
    if header == HEADER {
        return Ok(());
    }
    let path = path.to_owned();
    if HEADER.starts_with(&header) {
        return Err(CheckpointError::Damaged { path, damage: Damage::Header });
    }
    match header.strip_prefix(MAGIC) {
        Some([version @ b'0'..=b'9', ..]) => {
            let found = char::from(*version).to_string();
            Err(CheckpointError::Version { path, found, expected: VERSION })
        }
        Some(_) => Err(CheckpointError::Damaged { path, damage: Damage::Header }),
        None => Err(CheckpointError::Foreign { path }),
    }
}
