//! Words that are written down and read back by the same code, so that reading cannot disagree with writing.

/// A list of 64-bit words. A number is its bits, so that zeros keep their sign and NaN its payload.
#[derive(Debug)]
pub(crate) enum Tape {
    /// Takes down what it is shown.
    Writing(Vec<u64>),
    /// Replaces what it is shown.
    Reading {
        /// What was taken down.
        words: std::vec::IntoIter<u64>,
        /// Whether it was shown more than was taken down, or what was makes no sense.
        short: bool,
    },
}

impl Tape {
    /// The words of everything that `pass` shows.
    pub(crate) fn write(pass: impl FnOnce(&mut Self)) -> Vec<u64> {
        let mut tape = Self::Writing(Vec::new());
        pass(&mut tape);
        match tape {
            Self::Writing(words) => words,
            Self::Reading { words, .. } => words.collect(),
        }
    }

    /// Replaces everything that `pass` shows by the words; `None` if there are more or fewer of them.
    pub(crate) fn read(words: Vec<u64>, pass: impl FnOnce(&mut Self)) -> Option<()> {
        let mut tape = Self::Reading { words: words.into_iter(), short: false };
        pass(&mut tape);
        match tape {
            Self::Reading { words, short } => (!short && words.len() == 0).then_some(()),
            Self::Writing(_) => None,
        }
    }

    /// Takes down or replaces a word.
    pub(crate) fn word(&mut self, word: &mut u64) {
        match self {
            Self::Writing(words) => words.push(*word),
            Self::Reading { words, short } => match words.next() {
                Some(read) => *word = read,
                None => *short = true,
            },
        }
    }

    /// Takes down a length, or reads one that no more words can follow than there are.
    pub(crate) fn length(&mut self, length: usize) -> usize {
        let mut word = length as u64;
        self.word(&mut word);
        match self {
            Self::Writing(_) => length,
            Self::Reading { words, short } => {
                let read = usize::try_from(word).ok().filter(|&read| read <= words.len());
                *short |= read.is_none();
                read.unwrap_or(0)
            }
        }
    }

    /// Whether it replaces what it is shown.
    pub(crate) fn is_reading(&self) -> bool {
        matches!(self, Self::Reading { .. })
    }

    /// What was read makes no sense: [`Tape::read`] gives nothing.
    pub(crate) fn refuse(&mut self) {
        if let Self::Reading { short, .. } = self {
            *short = true;
        }
    }

    /// Takes down or replaces several words.
    pub(crate) fn words<'x>(&mut self, words: impl IntoIterator<Item = &'x mut u64>) {
        words.into_iter().for_each(|word| self.word(word));
    }

    /// Takes down or replaces a number.
    pub(crate) fn number(&mut self, number: &mut f64) {
        let mut word = number.to_bits();
        self.word(&mut word);
        *number = f64::from_bits(word);
    }

    /// Takes down or replaces several numbers.
    pub(crate) fn numbers<'x>(&mut self, numbers: impl IntoIterator<Item = &'x mut f64>) {
        numbers.into_iter().for_each(|number| self.number(number));
    }
}

#[cfg(test)]
mod tests {
    use super::Tape;

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
}
