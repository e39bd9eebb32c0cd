//! The file: one line with its kind, version, steps or chunks that are done, length and checksum, then words
//! of 64 bits, the least byte first.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::keeper::RunDescription;
use crate::ground::checksum::Checksum;
use crate::ground::numbers::{Numbers, Tape, numbers};
use crate::trajectory::checkpoint::{CheckpointError, Damage};

/// The version that is read and written.
pub(super) const VERSION: u32 = 5;
/// Bytes of a word.
const WORD: usize = 8;

/// The kind of run that a checkpoint belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CheckpointKind {
    Path,
    Ensemble,
    Multilevel,
}

/// How the first line begins in every version, and the kind of run that it marks.
const KINDS: [(&str, &str); 3] = [
    ("wzvi-checkpoint ", "a single path"),
    ("wzvi-ensemble ", "an ensemble"),
    ("wzvi-multilevel ", "a multilevel run"),
];

impl CheckpointKind {
    pub(super) fn magic(self) -> &'static str {
        KINDS[self as usize].0
    }
}

/// A run at one of its nodes, or after some of its chunks.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Saved {
    /// The identity of the run.
    pub(super) run: RunDescription,
    /// Steps or chunks that are done.
    pub(super) done: u64,
    /// The results after them.
    pub(super) content: Vec<u64>,
}

numbers! { impl[] Numbers for Saved { kept: run, done, content } }

/// The first line and the words of a file.
pub(super) struct Encoded {
    pub(super) line: Vec<u8>,
    words: Vec<u64>,
}

impl Encoded {
    pub(super) fn new(kind: CheckpointKind, saved: &mut Saved) -> Self {
        let words = Tape::write(|tape| saved.pass(tape));
        let mut checksum = Checksum::default();
        words.iter().for_each(|word| checksum.add(&word.to_le_bytes()));
        Self { line: first_line(kind, saved.done, words.len() * WORD, checksum).into_bytes(), words }
    }

    pub(super) fn write(&self, to: &mut impl Write) -> io::Result<()> {
        to.write_all(&self.line)?;
        self.words.iter().try_for_each(|word| to.write_all(&word.to_le_bytes()))
    }
}

fn first_line(kind: CheckpointKind, done: u64, length: usize, checksum: Checksum) -> String {
    format!("{}{VERSION} {done} {length} {checksum:?}\n", kind.magic())
}

/// The first line of a file, two of which are the same if their first lines are, and what the file says.
pub(super) fn decode(
    kind: CheckpointKind,
    path: &Path,
    bytes: &[u8],
) -> (Vec<u8>, Result<Saved, CheckpointError>) {
    let end = bytes.iter().position(|&byte| byte == b'\n').map_or(bytes.len(), |end| end + 1);
    let (line, content) = bytes.split_at(end);
    (line.to_owned(), read(kind, path.to_owned(), line, content))
}

fn read(kind: CheckpointKind, path: PathBuf, line: &[u8], content: &[u8]) -> Result<Saved, CheckpointError> {
    let Some(rest) = line.strip_prefix(kind.magic().as_bytes()) else {
        // An empty file, or the start of a first line, is the remainder of a checkpoint.
        let is_cut = content.is_empty() && kind.magic().as_bytes().starts_with(line);
        let other = KINDS.iter().find(|(magic, _)| line.starts_with(magic.as_bytes()));
        return Err(match other {
            Some((_, kind)) => CheckpointError::Kind { path, kind },
            None if is_cut => CheckpointError::Damaged { path, damage: Damage::Header },
            None => CheckpointError::Foreign { path },
        });
    };
    let damaged = |damage| Err(CheckpointError::Damaged { path: path.clone(), damage });
    let Some(Ok(rest)) = rest.strip_suffix(b"\n").map(std::str::from_utf8) else {
        return damaged(Damage::Header);
    };
    let mut words = rest.split(' ');
    match words.next() {
        Some(version) if version == VERSION.to_string() => {}
        Some(version) if !version.is_empty() && version.bytes().all(|byte| byte.is_ascii_digit()) => {
            return Err(CheckpointError::Version { path, found: version.to_owned(), expected: VERSION });
        }
        _ => return damaged(Damage::Header),
    }
    let (Some(_), Some(Ok(expected)), Some(Ok(checksum)), None) = (
        words.next(),
        words.next().map(str::parse::<u64>),
        words.next().map(|digits| u64::from_str_radix(digits, 16)),
        words.next(),
    ) else {
        return damaged(Damage::Header);
    };
    let found = content.len() as u64;
    if found != expected {
        return damaged(Damage::Length { expected, found });
    }
    let mut own = Checksum::default();
    own.add(content);
    if own.value() != checksum {
        return damaged(Damage::Checksum { expected: checksum, found: own.value() });
    }
    let (words, []) = content.as_chunks::<WORD>() else { return damaged(nonsense()) };
    let mut saved = Saved::default();
    let words = words.iter().map(|word| u64::from_le_bytes(*word)).collect();
    if Tape::read(words, |tape| saved.pass(tape)).is_none() {
        return damaged(nonsense());
    }
    // There is one way to write a line: `+12`, `012` and capital digits are not what was written.
    let is_written = line == first_line(kind, saved.done, content.len(), own).as_bytes();
    if is_written { Ok(saved) } else { damaged(Damage::Header) }
}

/// The error for contents with a right checksum that no run can have written.
pub(super) fn nonsense() -> Damage {
    Damage::Content("a part of it has the wrong length".to_owned())
}
