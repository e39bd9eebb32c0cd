//! The file: one line with its kind, version, length and checksum, then JSON.

use std::fmt;

use serde::de::{self, DeserializeOwned};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::error::Damage;
use crate::ground::checksum::Checksum;

/// The version that is read and written.
pub(super) const VERSION: u32 = 3;

/// What a file keeps.
pub(super) trait Content: Serialize + DeserializeOwned {
    /// What the first line starts with, in every version: one of [`KINDS`].
    const MAGIC: &'static str;
}

impl Content for Saved {
    const MAGIC: &'static str = "wzvi-checkpoint ";
}

/// What there are checkpoints of.
const KINDS: [(&str, &str); 2] = [("wzvi-checkpoint ", "a single path"), ("wzvi-ensemble ", "an ensemble")];

/// A run at one of its nodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Saved {
    /// What the user set, by name.
    pub(super) settings: Vec<(String, String)>,
    /// Checksums of what follows from that, by name.
    pub(super) derived: Vec<(String, String)>,
    /// The first state: `t`, `q`, `p`.
    pub(super) start: Words,
    /// Steps since then.
    pub(super) step: u64,
    /// The state after them.
    pub(super) state: Words,
    /// Checksum of energies and forces there.
    pub(super) forces: String,
    /// What the stepper remembers.
    pub(super) stepper: Words,
    /// What the recorder counts and sums.
    pub(super) recorder: Words,
    /// Sums of all increments.
    pub(super) wiener: Words,
    /// Recorded nodes after the start, in the other file.
    pub(super) nodes: u64,
    /// Their checksum.
    pub(super) nodes_checksum: Word,
}

/// 64 bits, written as sixteen hexadecimal digits: JSON has no way to write every `f64`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Word(pub(super) u64);

/// Several of them.
pub(super) type Words = Vec<Word>;

impl Serialize for Word {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(&format_args!("{:016x}", self.0))
    }
}

impl<'de> Deserialize<'de> for Word {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Digits;
        impl de::Visitor<'_> for Digits {
            type Value = Word;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("sixteen hexadecimal digits")
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<Word, E> {
                let is_word = text.len() == 16 && text.bytes().all(|byte| byte.is_ascii_hexdigit());
                let word = is_word.then(|| u64::from_str_radix(text, 16).ok()).flatten();
                word.map(Word).ok_or_else(|| E::invalid_value(de::Unexpected::Str(text), &self))
            }
        }
        deserializer.deserialize_str(Digits)
    }
}

/// Why a file is not read.
#[derive(Debug, PartialEq)]
pub(super) enum Unreadable {
    Foreign,
    Kind(&'static str),
    Version(String),
    Damaged(Damage),
}

fn header<C: Content>(content: &[u8]) -> String {
    let mut checksum = Checksum::default();
    checksum.add(content);
    format!("{}{VERSION} {} {checksum:?}\n", C::MAGIC, content.len())
}

/// The bytes of a file.
pub(super) fn encode<C: Content>(saved: &C) -> Result<Vec<u8>, Damage> {
    let mut content = serde_json::to_vec(saved).map_err(|error| Damage::Content(error.to_string()))?;
    content.push(b'\n');
    let mut bytes = header::<C>(&content).into_bytes();
    bytes.append(&mut content);
    Ok(bytes)
}

/// What a file says.
pub(super) fn decode<C: Content>(bytes: &[u8]) -> Result<C, Unreadable> {
    let Some(rest) = bytes.strip_prefix(C::MAGIC.as_bytes()) else {
        // An empty file, or the start of a first line, is what is left of a checkpoint.
        let is_cut = C::MAGIC.as_bytes().starts_with(bytes);
        let other = KINDS.iter().find(|(magic, _)| bytes.starts_with(magic.as_bytes()));
        return Err(match other {
            Some((_, kind)) => Unreadable::Kind(kind),
            None if is_cut => Unreadable::Damaged(Damage::Header),
            None => Unreadable::Foreign,
        });
    };
    let damaged = |damage| Err(Unreadable::Damaged(damage));
    let Some(end) = rest.iter().position(|&byte| byte == b'\n') else { return damaged(Damage::Header) };
    let (line, content) = (&rest[..end], &rest[end + 1..]);
    let Ok(line) = std::str::from_utf8(line) else { return damaged(Damage::Header) };
    let mut words = line.split(' ');
    match words.next() {
        Some(version) if version == VERSION.to_string() => {}
        Some(version) if !version.is_empty() && version.bytes().all(|byte| byte.is_ascii_digit()) => {
            return Err(Unreadable::Version(version.to_owned()));
        }
        _ => return damaged(Damage::Header),
    }
    let (Some(Ok(length)), Some(Ok(expected)), None) = (
        words.next().map(str::parse::<u64>),
        words.next().map(|digits| u64::from_str_radix(digits, 16)),
        words.next(),
    ) else {
        return damaged(Damage::Header);
    };
    let found = content.len() as u64;
    if found != length {
        return damaged(Damage::Length { expected: length, found });
    }
    let mut checksum = Checksum::default();
    checksum.add(content);
    if checksum.value() != expected {
        return damaged(Damage::Checksum { expected, found: checksum.value() });
    }
    // There is one way to write a line: `+12`, `012` and capital digits are not what was written.
    if !bytes.starts_with(header::<C>(content).as_bytes()) {
        return damaged(Damage::Header);
    }
    serde_json::from_slice(content).map_err(|error| Unreadable::Damaged(Damage::Content(error.to_string())))
}

/// The first line of a file: two checkpoints with the same one are the same.
pub(super) fn first_line(bytes: &[u8]) -> &[u8] {
    let end = bytes.iter().position(|&byte| byte == b'\n').map_or(bytes.len(), |end| end + 1);
    &bytes[..end]
}

/// Words for the file.
pub(super) fn words(bits: Vec<u64>) -> Words {
    bits.into_iter().map(Word).collect()
}

/// Words from the file.
pub(super) fn bits(words: &[Word]) -> Vec<u64> {
    words.iter().map(|word| word.0).collect()
}
