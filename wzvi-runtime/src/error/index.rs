//! Integers of a system that are out of range.

use std::fmt;

/// Levels of nested lists whose indices an error shows.
const LEVELS: usize = 3;

/// The remedy for an index that becomes negative.
const ROUND: &str =
    "change the integers of the system, or write `(i + n - 1) % n` where an index wraps around";

/// A list or an integer of a system.
#[doc(hidden)]
#[derive(Debug, PartialEq)]
pub struct Name {
    /// As the Hamiltonian names it.
    pub name: &'static str,
    /// The text after the indices: the part of a tuple, a length.
    pub suffix: &'static str,
}

impl Name {
    /// A name from its parts.
    pub const fn new(name: &'static str, suffix: &'static str) -> Self {
        Self { name, suffix }
    }
}

/// An integer of a system that is out of range: its name, its value, and its limit.
#[derive(Clone, Copy, PartialEq)]
pub struct IndexError {
    name: &'static Name,
    at: [u32; LEVELS],
    levels: u8,
    limit: IndexLimit,
    /// The halves of an `i128`, high and low, which keep errors small.
    value: [u64; 2],
}

/// The condition on an integer of a system.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum IndexLimit {
    /// The index of a point of the state: less than this.
    Points(usize),
    /// The index of an entry of the list: less than this.
    Entries(usize),
    /// An `isize`.
    Integers,
    /// Not negative: an integer of an unsigned type, or its distance from the largest or least number of a
    /// type.
    Natural,
    /// Not zero.
    Divisor,
}

impl IndexError {
    pub(crate) fn new(name: &'static Name, value: i128, limit: IndexLimit) -> Self {
        let value = [(value >> 64) as u64, value as u64];
        Self { name, at: [0; LEVELS], levels: 0, limit, value }
    }

    /// Adds an index to the name, up to the number that fits.
    pub(crate) fn push(&mut self, index: i128) {
        if let (Some(at), Ok(index)) = (self.at.get_mut(usize::from(self.levels)), u32::try_from(index)) {
            *at = index;
            self.levels += 1;
        }
    }

    /// The value.
    pub fn value(&self) -> i128 {
        let [high, low] = self.value;
        (i128::from(high) << 64) | i128::from(low)
    }

    /// The condition that the integer does not satisfy.
    pub fn limit(&self) -> IndexLimit {
        self.limit
    }

    /// The name of the integer, as the Hamiltonian writes it: `bonds[17].1`. For [`IndexLimit::Entries`] the
    /// list that is read there.
    pub fn name(&self) -> String {
        let at: String =
            self.at[..usize::from(self.levels)].iter().map(|index| format!("[{index}]")).collect();
        let suffix = if matches!(self.limit, IndexLimit::Entries(_)) { "" } else { self.name.suffix };
        format!("{}{at}{suffix}", self.name.name)
    }
}

impl fmt::Debug for IndexError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("IndexError")
            .field("name", &self.name())
            .field("value", &self.value())
            .field("limit", &self.limit)
            .finish()
    }
}

impl fmt::Display for IndexError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, value) = (self.name(), self.value());
        match self.limit {
            IndexLimit::Points(_) if value < 0 => {
                return write!(f, "`{name}` is {value}, but points are numbered from 0; {ROUND}");
            }
            IndexLimit::Natural => {
                let why = "an integer leaves its type where this is negative";
                return write!(f, "`{name}` is {value}, but {why}; {ROUND}");
            }
            IndexLimit::Points(points) => write!(f, "`{name}` is {value}, but the state has {points}")?,
            IndexLimit::Entries(length) => {
                write!(f, "`{name}` is read at {value}, but it has {length} entries")?
            }
            IndexLimit::Integers => {
                write!(f, "`{name}` is {value}, but integers range from {} to {}", isize::MIN, isize::MAX)?;
            }
            IndexLimit::Divisor => write!(f, "`{name}` is a divisor, but it is 0")?,
        }
        f.write_str("; change the integers of the system, or the size of the state")
    }
}

impl std::error::Error for IndexError {}
