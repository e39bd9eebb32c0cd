//! Values as sequences of numbers, which a tape records and restores.
//!
//! Tested by `tests/paths/checkpoint/resume.rs`.

use std::marker::PhantomData;

/// Values that a checkpoint keeps and ranks send, to the last bit: the memory of a step, a statistic.
///
/// One method serves both directions, so that reading cannot disagree with writing.
pub trait Numbers {
    /// Passes every number to a tape, in an order that depends only on the type and on what was passed
    /// before. A tape that is read replaces the numbers, so that the words of one value make another one
    /// equal to it.
    fn pass(&mut self, tape: &mut Tape);
}

impl Numbers for () {
    fn pass(&mut self, _tape: &mut Tape) {}
}

impl<S> Numbers for PhantomData<S> {
    fn pass(&mut self, _tape: &mut Tape) {}
}

impl Numbers for f64 {
    fn pass(&mut self, tape: &mut Tape) {
        tape.number(self);
    }
}

impl Numbers for u64 {
    fn pass(&mut self, tape: &mut Tape) {
        tape.word(self);
    }
}

/// The length of the text, then eight of its bytes in each word.
impl Numbers for String {
    fn pass(&mut self, tape: &mut Tape) {
        let mut bytes = std::mem::take(self).into_bytes();
        let mut length = bytes.len() as u64;
        tape.word(&mut length);
        let words = tape.length(bytes.len().div_ceil(8));
        bytes.resize(8 * words, 0);
        for word in bytes.as_chunks_mut().0 {
            let mut number = u64::from_le_bytes(*word);
            tape.word(&mut number);
            *word = number.to_le_bytes();
        }
        bytes.truncate(usize::try_from(length).unwrap_or(usize::MAX));
        match Self::from_utf8(bytes) {
            Ok(text) => *self = text,
            Err(_) => tape.refuse(),
        }
    }
}

impl Numbers for bool {
    fn pass(&mut self, tape: &mut Tape) {
        tape.flag(self);
    }
}

impl<T: Numbers, const N: usize> Numbers for [T; N] {
    fn pass(&mut self, tape: &mut Tape) {
        self.iter_mut().for_each(|part| part.pass(tape));
    }
}

/// Its length comes first, so that a vector of any other length becomes equal to it.
impl<T: Numbers + Default> Numbers for Vec<T> {
    fn pass(&mut self, tape: &mut Tape) {
        let length = tape.length(self.len());
        self.resize_with(length, T::default);
        self.iter_mut().for_each(|entry| tape.entry(|tape| entry.pass(tape)));
    }
}

/// Whether it is there comes first.
impl<T: Numbers + Default> Numbers for Option<Box<T>> {
    fn pass(&mut self, tape: &mut Tape) {
        let mut is_there = self.is_some();
        tape.flag(&mut is_there);
        if is_there {
            self.get_or_insert_default().pass(tape);
        }
    }
}

/// `Numbers` of a struct from the list of its fields:
///
/// ```text
/// numbers! { impl[] Numbers for Moments { kept: count, comoment[..], of_each[..]; fixed: has_covariances } }
/// ```
///
/// | list | its fields |
/// |---|---|
/// | `kept` | in checkpoints, in this order; of `name[..]` each entry, as many as there are, without their number |
/// | `fixed` | follow from the system and the settings of the run, which are the same when it is resumed |
/// | `result` | say something about the last step, and are read before the next one |
/// | `scratch` | mean nothing outside their step, or their chunk of paths |
///
/// A field in none of the lists does not compile.
macro_rules! numbers {
    (
        impl[$($generics:tt)*] Numbers for $type:ty {
            kept: $($kept:ident $([$entries:tt])?),*
            $(; fixed: $($fixed:ident),+)?
            $(; result: $($result:ident),+)?
            $(; scratch: $($scratch:ident),+)?
        }
    ) => {
        impl<$($generics)*> $crate::ground::numbers::Numbers for $type {
            fn pass(&mut self, tape: &mut $crate::ground::numbers::Tape) {
                let Self { $($kept,)* $($($fixed: _,)+)? $($($result: _,)+)? $($($scratch: _,)+)? } = self;
                let _ = &tape;
                $($crate::ground::numbers::numbers!(@pass tape, $kept $([$entries])?);)*
            }
        }
    };
    (@pass $tape:ident, $kept:ident) => {
        $crate::ground::numbers::Numbers::pass($kept, $tape)
    };
    (@pass $tape:ident, $kept:ident [..]) => {
        $kept.iter_mut().for_each(|entry| $crate::ground::numbers::Numbers::pass(entry, $tape))
    };
}

pub(crate) use numbers;

/// For all tuples that generated code has, by names and places of their parts: as long as those for which the
/// standard library has `Default` and `Debug`, which a memory needs as well.
macro_rules! for_tuples {
    ($implement:ident) => {
        $implement! {
            (A 0)
            (A 0 B 1)
            (A 0 B 1 C 2)
            (A 0 B 1 C 2 D 3)
            (A 0 B 1 C 2 D 3 E 4)
            (A 0 B 1 C 2 D 3 E 4 F 5)
            (A 0 B 1 C 2 D 3 E 4 F 5 G 6)
            (A 0 B 1 C 2 D 3 E 4 F 5 G 6 H 7)
            (A 0 B 1 C 2 D 3 E 4 F 5 G 6 H 7 I 8)
            (A 0 B 1 C 2 D 3 E 4 F 5 G 6 H 7 I 8 J 9)
            (A 0 B 1 C 2 D 3 E 4 F 5 G 6 H 7 I 8 J 9 K 10)
            (A 0 B 1 C 2 D 3 E 4 F 5 G 6 H 7 I 8 J 9 K 10 L 11)
        }
    };
}

pub(crate) use for_tuples;

macro_rules! tuples {
    ($(($($part:ident $place:tt)+))+) => {$(
        impl<$($part: Numbers),+> Numbers for ($($part,)+) {
            fn pass(&mut self, tape: &mut Tape) {
                $(self.$place.pass(tape);)+
            }
        }
    )+};
}

for_tuples!(tuples);

/// A list of 64-bit words. A number is its bits, so that zeros keep their sign and NaN its payload.
#[derive(Debug)]
pub struct Tape {
    way: TapeMode,
    /// If set, only this lane is recorded, as it would be alone, or replaced.
    lane: Option<usize>,
}

#[derive(Debug)]
enum TapeMode {
    /// Records what is passed.
    Writing(Vec<u64>),
    /// Replaces what is passed.
    Reading {
        /// The recorded words: one list, or one of each lane. Words that do not belong to a lane must be
        /// equal in all.
        lists: Vec<std::vec::IntoIter<u64>>,
        /// Whether more was passed than was recorded, or the record is inconsistent.
        short: bool,
    },
}

impl Tape {
    /// The words of everything that `pass` shows.
    pub(crate) fn write(mut pass: impl FnMut(&mut Self)) -> Vec<u64> {
        Self::recorded(None, &mut pass)
    }

    /// The words of one lane of everything that `pass` shows.
    pub(crate) fn split(lane: usize, mut pass: impl FnMut(&mut Self)) -> Vec<u64> {
        Self::recorded(Some(lane), &mut pass)
    }

    fn recorded(lane: Option<usize>, pass: &mut dyn FnMut(&mut Self)) -> Vec<u64> {
        let mut tape = Self { way: TapeMode::Writing(Vec::new()), lane };
        pass(&mut tape);
        match tape.way {
            TapeMode::Writing(words) => words,
            TapeMode::Reading { lists, .. } => lists.into_iter().flatten().collect(),
        }
    }

    /// Replaces everything that `pass` shows by the words; `None` if there are more or fewer of them.
    pub(crate) fn read(words: Vec<u64>, mut pass: impl FnMut(&mut Self)) -> Option<()> {
        Self::replaced(None, vec![words], &mut pass)
    }

    /// Replaces all lanes of everything that `pass` shows by the words of each; `None` if they do not fit, or
    /// not each other.
    pub(crate) fn join(lanes: Vec<Vec<u64>>, mut pass: impl FnMut(&mut Self)) -> Option<()> {
        Self::replaced(None, lanes, &mut pass)
    }

    /// Replaces one lane of everything that `pass` shows by the words; `None` if they do not fit.
    pub(crate) fn place(lane: usize, words: Vec<u64>, mut pass: impl FnMut(&mut Self)) -> Option<()> {
        Self::replaced(Some(lane), vec![words], &mut pass)
    }

    fn replaced(lane: Option<usize>, lists: Vec<Vec<u64>>, pass: &mut dyn FnMut(&mut Self)) -> Option<()> {
        let lists = lists.into_iter().map(Vec::into_iter).collect();
        let mut tape = Self { way: TapeMode::Reading { lists, short: false }, lane };
        pass(&mut tape);
        let TapeMode::Reading { lists, short } = tape.way else { return None };
        (!short && lists.iter().all(|words| words.len() == 0)).then_some(())
    }

    /// Records or replaces a word.
    pub fn word(&mut self, word: &mut u64) {
        match &mut self.way {
            TapeMode::Writing(words) => words.push(*word),
            TapeMode::Reading { lists, short } => {
                // The other lanes keep theirs.
                let is_own = |first: u64| self.lane.is_none() || first == *word;
                let mut read = lists.iter_mut().map(Iterator::next);
                match read.next().flatten() {
                    Some(first) if is_own(first) && read.all(|other| other == Some(first)) => *word = first,
                    _ => *short = true,
                }
            }
        }
    }
    /// Records or replaces a number of each lane.
    pub fn lanes(&mut self, numbers: &mut [f64]) {
        self.words_of_lanes(numbers, |number| number.to_bits(), |word| Some(f64::from_bits(word)));
    }

    /// Records or replaces a boolean of each lane: 0 or 1.
    pub fn flags(&mut self, flags: &mut [bool]) {
        let read = |word| (word < 2).then_some(word == 1);
        self.words_of_lanes(flags, |flag| u64::from(*flag), read);
    }

    /// Records or replaces a small count of each lane.
    pub fn counts(&mut self, counts: &mut [u8]) {
        self.words_of_lanes(counts, |count| u64::from(*count), |word| u8::try_from(word).ok());
    }

    /// Records or replaces one word of each lane.
    fn words_of_lanes<T>(
        &mut self,
        list: &mut [T],
        write: impl Fn(&T) -> u64,
        read: impl Fn(u64) -> Option<T>,
    ) {
        let list = match self.lane {
            Some(lane) => list.get_mut(lane..=lane).unwrap_or_default(),
            None => list,
        };
        match &mut self.way {
            TapeMode::Writing(words) => words.extend(list.iter().map(write)),
            TapeMode::Reading { lists, short } => {
                let is_joined = lists.len() != 1;
                *short |= is_joined && lists.len() != list.len();
                for (lane, entry) in list.iter_mut().enumerate() {
                    let words = lists.get_mut(if is_joined { lane } else { 0 });
                    match words.and_then(Iterator::next).and_then(&read) {
                        Some(read) => *entry = read,
                        None => *short = true,
                    }
                }
            }
        }
    }

    /// Records or replaces an entry of a list. An entry without words gets one, so that a list never has more
    /// entries than words, which [`Tape::length`] relies on.
    fn entry(&mut self, pass: impl FnOnce(&mut Self)) {
        let before = self.position();
        pass(self);
        if self.position() == before {
            let mut filler = 0;
            self.word(&mut filler);
            if filler != 0 {
                self.refuse();
            }
        }
    }

    /// The number of words that were recorded, or that are left to read.
    fn position(&self) -> usize {
        match &self.way {
            TapeMode::Writing(words) => words.len(),
            TapeMode::Reading { lists, .. } => lists.first().map_or(0, ExactSizeIterator::len),
        }
    }

    /// Records a length, or reads one, which cannot exceed the words that are left.
    pub fn length(&mut self, length: usize) -> usize {
        let mut word = length as u64;
        self.word(&mut word);
        let TapeMode::Reading { lists, short } = &mut self.way else { return length };
        let left = lists.iter().map(ExactSizeIterator::len).min().unwrap_or(0);
        let read = usize::try_from(word).ok().filter(|&read| read <= left);
        *short |= read.is_none();
        read.unwrap_or(0)
    }

    /// Whether the tape replaces what is passed.
    pub fn is_reading(&self) -> bool {
        matches!(self.way, TapeMode::Reading { .. })
    }

    /// Whether the tape replaces what is passed in all lanes.
    pub(crate) fn replaces_all(&self) -> bool {
        self.is_reading() && self.lane.is_none()
    }

    /// Marks what was read as inconsistent: reading then fails.
    pub fn refuse(&mut self) {
        if let TapeMode::Reading { short, .. } = &mut self.way {
            *short = true;
        }
    }

    /// Records or replaces a count that has fewer bits than a word; one that is too large is inconsistent.
    pub fn count<T: Copy + Into<u64> + TryFrom<u64>>(&mut self, count: &mut T) {
        let mut word = (*count).into();
        self.word(&mut word);
        match T::try_from(word) {
            Ok(read) => *count = read,
            Err(_) => self.refuse(),
        }
    }

    /// Records or replaces a boolean: 0 or 1.
    pub fn flag(&mut self, flag: &mut bool) {
        let mut word = u8::from(*flag);
        self.count(&mut word);
        match word {
            0 | 1 => *flag = word == 1,
            _ => self.refuse(),
        }
    }

    /// Records or replaces several words.
    pub fn words<'x>(&mut self, words: impl IntoIterator<Item = &'x mut u64>) {
        words.into_iter().for_each(|word| self.word(word));
    }

    /// Records or replaces a number.
    pub fn number(&mut self, number: &mut f64) {
        let mut word = number.to_bits();
        self.word(&mut word);
        *number = f64::from_bits(word);
    }

    /// Records or replaces several numbers.
    pub fn numbers<'x>(&mut self, numbers: impl IntoIterator<Item = &'x mut f64>) {
        numbers.into_iter().for_each(|number| self.number(number));
    }
}

#[cfg(test)]
mod tests {
    use super::{Numbers, Tape};
    use crate::algebra::solve::Extrapolation;
    use crate::algebra::state_sum::{FixedCompensatedSum, StateSum};

    fn words(value: &mut impl Numbers) -> Vec<u64> {
        Tape::write(|tape| value.pass(tape))
    }

    /// The words of one value make another one equal to it.
    fn copied<T: Numbers>(mut value: T, mut other: T) -> T {
        let expected = words(&mut value);
        assert_eq!(Tape::read(expected.clone(), |tape| other.pass(tape)), Some(()));
        assert_eq!(words(&mut other), expected);
        other
    }

    #[test]
    fn numbers_make_an_equal_value() {
        let (mut memory, mut carry) =
            (Extrapolation::<f64, 2>::default(), FixedCompensatedSum::<f64, 1>::default());
        for n in 0..4 {
            let copy = copied((memory, (carry, vec![0.5; n])), Default::default());
            assert_eq!(copy.0.guess::<true>(), memory.guess::<true>());
            assert_eq!((copy.1.0, copy.1.1), (carry, vec![0.5; n]));
            // The number of known points counts too: the next record must do the same to both.
            let (mut one, mut other) = (memory, copy.0);
            one.record::<true>([7.0, -0.0]);
            other.record::<true>([7.0, -0.0]);
            assert_eq!(one.guess::<true>(), other.guess::<true>());
            let x = f64::from(n as u32);
            memory.record::<true>([x * x, x.sin()]);
            carry.keep(&[x], &[-x]);
        }
        assert_eq!(copied(vec![1.0, -0.0], vec![3.0; 9]), [1.0, -0.0]);
    }

    #[test]
    fn texts_come_back() {
        for text in ["", "a", "eight by", "ξ over nine bytes"] {
            assert_eq!(copied((text.to_owned(), 7_u64), ("before".to_owned(), 0)), (text.to_owned(), 7));
        }
        let (mut read, nonsense) = (String::new(), u64::from_le_bytes([0xFF; 8]));
        assert_eq!(Tape::read(vec![1, 1, nonsense], |tape| read.pass(tape)), None);
    }

    /// A list has its length even where its entries have no words, and nothing follows it.
    #[test]
    fn entries_without_words_come_back() {
        assert_eq!(copied(vec![(); 3], vec![]).len(), 3);
        assert_eq!(copied((vec![(); 15], vec![vec![(); 2]; 2]), Default::default()).1, [[(); 2]; 2]);
        // A list that is longer than the file.
        for words in [vec![u64::MAX], vec![4, 0, 0, 0], vec![1, 7]] {
            assert_eq!(Tape::read(words, |tape| vec![(); 0].pass(tape)), None);
        }
    }

    #[test]
    fn every_bit_comes_back() {
        let payload = f64::from_bits(0x7FF8_0000_DEAD_BEEF);
        let values = [0.0, -0.0, 1.5, f64::MIN_POSITIVE / 8.0, f64::INFINITY, payload];
        let mut numbers = values;
        let words = Tape::write(|tape| tape.numbers(&mut numbers));
        assert_eq!(numbers.map(f64::to_bits), values.map(f64::to_bits));
        let mut read = [1.0; 6];
        assert_eq!(Tape::read(words.clone(), |tape| tape.numbers(&mut read)), Some(()));
        assert_eq!(read.map(f64::to_bits), values.map(f64::to_bits));
        assert_eq!(Tape::read(words.clone(), |tape| tape.numbers(&mut [0.0; 5])), None);
        assert_eq!(Tape::read(words, |tape| tape.numbers(&mut [0.0; 7])), None);
        let words = Tape::write(|tape| assert_eq!(tape.length(3), 3));
        assert_eq!(words, [3]);
        assert_eq!(Tape::read(words, |tape| assert_eq!(tape.length(1), 0)), None);
        assert_eq!(Tape::read(vec![0], |tape| assert_eq!(tape.length(1), 0)), Some(()));
        assert_eq!(Tape::read(vec![], Tape::refuse), None);
    }

    /// Lanes are split and joined again if they count the same.
    #[cfg(feature = "ensemble")]
    #[test]
    fn lanes_split_and_join() {
        use crate::algebra::lanes::Lanes;
        let mut together = Extrapolation::<Lanes<3>, 1>::default();
        let mut alone: [Extrapolation<Lanes<1>, 1>; 3] = Default::default();
        for x in [0.5, -0.25, 4.0] {
            together.record::<true>([Lanes::new([x, 2.0 * x, -x])]);
            for (memory, factor) in alone.iter_mut().zip([1.0, 2.0, -1.0]) {
                memory.record::<true>([Lanes::new([factor * x])]);
            }
        }
        for (lane, memory) in alone.iter_mut().enumerate() {
            assert_eq!(Tape::split(lane, |tape| together.pass(tape)), words(memory));
        }
        let apart = move || alone.map(|mut memory| words(&mut memory)).to_vec();
        let mut joined = Extrapolation::<Lanes<3>, 1>::default();
        assert_eq!(Tape::join(apart(), |tape| joined.pass(tape)), Some(()));
        assert_eq!(words(&mut joined), words(&mut together));
        // One lane has recorded fewer steps, and goes on as it would alone.
        let mut fresh = Extrapolation::<Lanes<1>, 1>::default();
        assert_eq!(Tape::place(1, words(&mut fresh), |tape| joined.pass(tape)), Some(()));
        for x in [3.0, 1.0, -0.5] {
            joined.record::<true>([Lanes::new([x, x * x, 1.0])]);
            fresh.record::<true>([Lanes::new([x * x])]);
            alone[2].record::<true>([Lanes::new([1.0])]);
            for (lane, memory) in [(1, &mut fresh), (2, &mut alone[2])] {
                assert_eq!(Tape::split(lane, |tape| joined.pass(tape)), words(memory));
            }
        }
        // One is missing.
        assert_eq!(Tape::join(apart().split_off(1), |tape| joined.pass(tape)), None);
    }

    #[test]
    fn counts_and_flags_are_integers() {
        let words = Tape::write(|tape| {
            tape.count(&mut 200_u8);
            tape.count(&mut u32::MAX.clone());
            tape.flag(&mut true.clone());
        });
        assert_eq!(words, [200, u64::from(u32::MAX), 1]);
        let (mut byte, mut count, mut flag) = (0_u8, 0_u32, false);
        let mut read = |words: Vec<u64>| {
            Tape::read(words, |tape| {
                tape.count(&mut byte);
                tape.count(&mut count);
                tape.flag(&mut flag);
            })
        };
        assert_eq!(read(words), Some(()));
        for nonsense in [[256, 0, 0], [0, 1 << 32, 0], [0, 0, 2]] {
            assert_eq!(read(nonsense.to_vec()), None);
        }
        assert_eq!((byte, count, flag), (0, 0, false));
    }
}
