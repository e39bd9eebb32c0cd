//! Splittings as words of letters: `Splitting<(B, A, O, A, B)>`.
//!
//! A drift [`A`] is the flow of `T(p)`, a kick [`B`] that of `V(q, t)`, and an [`O`] part friction and noise
//! of the bath. Letters of one kind have equal shares of the step unless shares are given: `A<1, 4>` is a
//! drift over a quarter of it. O parts always have equal shares. [`Word::spelled`] makes the word.
//!
//! A word is of order one because its shares add to one, and of order two if for each pair of different
//! letters `X`, `Y` the products of shares of an `X` before a `Y` add to one half, as they do in a palindrome
//! (E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*, section III.5). With O parts order
//! two is the highest.

use super::modes::Decay;
use crate::scheme::word::{Part, PartKind, Substep, Word};

/// A word of kicks, drifts and O parts, and how they are applied: a letter, a tuple of letters, or a scheme
/// with a name.
pub trait Letters {
    /// Its letters, in the order of the step.
    const LETTERS: &'static [Letter];
    /// The decay of the momenta in the O parts.
    const DECAY: Decay = Decay::Exponential;
    /// Whether kicks and drifts are shortened.
    const IS_SHORTENED: bool = false;
    /// The order of a step: one or two.
    const ORDER: u32 = order(Self::LETTERS);
    /// The number of O parts.
    const O_PARTS: usize = count(Self::LETTERS, Part::O) as usize;
}

/// A letter as it is written: a part, and its share of the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Letter {
    /// The part.
    pub part: Part,
    /// The numerator of the share; zero if none is given, for an equal share of all parts of the kind.
    pub numerator: u32,
    /// The denominator of the share.
    pub denominator: u32,
}

/// A drift, the flow of `T(p)`, over the fraction `N / D` of the step, or an equal share if none is given.
#[derive(Clone, Copy, Debug)]
pub enum A<const N: u32 = 0, const D: u32 = 1> {}

/// A kick, the flow of `V(q, t)`, likewise.
#[derive(Clone, Copy, Debug)]
pub enum B<const N: u32 = 0, const D: u32 = 1> {}

/// Friction and noise of the bath, over an equal share of the step.
#[derive(Clone, Copy, Debug)]
pub enum O {}

impl<const N: u32, const D: u32> Letters for A<N, D> {
    const LETTERS: &'static [Letter] = &[Letter { part: Part::A, numerator: N, denominator: D }];
}
impl<const N: u32, const D: u32> Letters for B<N, D> {
    const LETTERS: &'static [Letter] = &[Letter { part: Part::B, numerator: N, denominator: D }];
}
impl Letters for O {
    const LETTERS: &'static [Letter] = &[Letter { part: Part::O, numerator: 0, denominator: 1 }];
}

/// The letter of a word of one.
const fn only(letters: &[Letter]) -> Letter {
    assert!(letters.len() == 1, "words are made of letters, not of words");
    letters[0]
}

macro_rules! words {
    ($first:ident $($letter:ident)*) => {
        impl<$first: Letters, $($letter: Letters),*> Letters for ($first, $($letter,)*) {
            const LETTERS: &'static [Letter] = &[only($first::LETTERS), $(only($letter::LETTERS)),*];
        }
        words!($($letter)*);
    };
    () => {};
}

words!(L1 L2 L3 L4 L5 L6 L7 L8 L9 L10 L11 L12 L13 L14 L15 L16 L17 L18 L19 L20 L21 L22 L23 L24);

impl Word {
    /// The word of these letters; drifts and kicks each add to one step.
    pub(crate) fn spelled(letters: &[Letter]) -> Self {
        let unit = common_denominator(letters);
        let (mut substeps, mut drifted) = (Vec::new(), 0);
        for (i, &Letter { part, .. }) in letters.iter().enumerate() {
            let share = share(letters, i, unit);
            let [weight, node] = [share, drifted].map(|fraction| fraction as f64 / unit as f64);
            let number = count(&letters[..i], part) as usize;
            substeps.push(Substep::new(part, weight, node, number));
            drifted += if part == Part::A { share } else { 0 };
        }
        Part::mark_kicks(&mut substeps);
        Self { substeps }
    }

    /// This word with an O part and the drifts of equal weight on both sides of it as one part, if there is
    /// exactly one such place.
    pub(super) fn joined(&self) -> Self {
        let between = |around: &[Substep]| match around {
            [before, Substep { part: Part::O, number, .. }, after] => {
                let are_drifts = [before, after].iter().all(|substep| substep.part == Part::A);
                (are_drifts && before.weight == after.weight)
                    .then(|| Substep { number: *number, ..before.with(Part::AOA) })
            }
            _ => None,
        };
        let all = &self.substeps[..];
        let mut places =
            all.windows(3).enumerate().filter_map(|(first, around)| Some((first, between(around)?)));
        let substeps = match (places.next(), places.next()) {
            (Some((first, joined)), None) => [&all[..first], &[joined], &all[first + 3..]].concat(),
            _ => all.to_vec(),
        };
        Self { substeps }
    }
}

/// The kind of a letter, 0 to 2.
const fn kind(part: Part) -> usize {
    match part {
        Part::A => 0,
        Part::B => 1,
        _ => 2,
    }
}

/// The number of letters of the kind of this part.
const fn count(letters: &[Letter], part: Part) -> u64 {
    let (mut count, mut i) = (0, 0);
    while i < letters.len() {
        count += (kind(letters[i].part) == kind(part)) as u64;
        i += 1;
    }
    count
}

/// Numerator and denominator of the share of letter `i`.
const fn fraction(letters: &[Letter], i: usize) -> (u64, u64) {
    match letters[i] {
        Letter { part, numerator: 0, .. } => (1, count(letters, part)),
        Letter { numerator, denominator, .. } => (numerator as u64, denominator as u64),
    }
}

const fn gcd(mut a: u64, mut b: u64) -> u64 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

/// The common denominator of all shares.
const fn common_denominator(letters: &[Letter]) -> u64 {
    let (mut unit, mut i) = (1_u64, 0);
    while i < letters.len() {
        let (_, denominator) = fraction(letters, i);
        assert!(denominator != 0, "a share is a fraction");
        let factor = denominator / gcd(unit, denominator);
        assert!(
            unit <= u32::MAX as u64 / factor,
            "the shares of a word have a common denominator below 2^32"
        );
        unit *= factor;
        i += 1;
    }
    unit
}

const fn share(letters: &[Letter], i: usize, unit: u64) -> u64 {
    let (numerator, denominator) = fraction(letters, i);
    numerator * (unit / denominator)
}

/// Two if, for each pair of different letters, the products of their shares add to one half; else one.
const fn order(letters: &[Letter]) -> u32 {
    let unit = common_denominator(letters);
    let (mut sums, mut products, mut j) = ([0_u128; 3], [[0_u128; 3]; 3], 0);
    while j < letters.len() {
        let (of, share) = (kind(letters[j].part), share(letters, j, unit) as u128);
        let mut before = 0;
        while before < 3 {
            products[before][of] += sums[before] * share;
            before += 1;
        }
        sums[of] += share;
        j += 1;
    }
    let whole = unit as u128;
    assert!(sums[0] == whole, "the shares of the drifts add to one");
    assert!(sums[1] == whole, "the shares of the kicks add to one");
    let (mut order, mut pair) = (2, 0);
    while pair < 9 {
        let (x, y) = (pair / 3, pair % 3);
        if x != y && 2 * products[x][y] != sums[x] * sums[y] {
            order = 1;
        }
        pair += 1;
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scheme::word::ForceUse;

    /// Shares that are given and equal ones, the times of kicks, and the numbers of O parts.
    #[test]
    fn letters_spell_their_word() {
        let word = Word::spelled(<(O, B<1, 6>, A, B<2, 3>, A, B<1, 6>, O)>::LETTERS);
        let column = |of: fn(&Substep) -> f64| word.substeps.iter().map(of).collect::<Vec<_>>();
        let sixth = 1.0 / 6.0;
        let weights = [0.5, sixth, 0.5, 4.0 * sixth, 0.5, sixth, 0.5];
        assert_eq!(column(|substep| substep.weight), weights);
        assert_eq!(column(|substep| substep.share), [0.5, -sixth, 0.5, -4.0 * sixth, 0.5, -sixth, 0.5]);
        assert_eq!(column(|substep| substep.node), [0.0, 0.0, 0.0, 0.5, 0.5, 1.0, 1.0]);
        assert_eq!([0, 3, 6].map(|i| word.substeps[i].number), [0, 1, 1]);
        // O parts at the ends change no force.
        let ends = [1, 5].map(|i| word.substeps[i].force);
        assert_eq!(ends, [ForceUse::FromStepBefore, ForceUse::ForNextStep]);
    }

    /// An O part joins its drifts, with its number and their weight, unless there are two such places.
    #[test]
    fn one_bath_joins_its_drifts() {
        let joined = |letters| Word::spelled(letters).joined().substeps;
        let parts = |substeps: &[Substep]| substeps.iter().map(|s| s.part).collect::<Vec<_>>();
        let baoab = joined(<(B, A, O, A, B)>::LETTERS);
        assert_eq!(parts(&baoab), [Part::B, Part::AOA, Part::B]);
        assert_eq!((baoab[1].weight, baoab[1].number, baoab[2].node), (0.5, 0, 1.0));
        let second = joined(<(O, B, A, O, A, B, O)>::LETTERS);
        assert_eq!((second[2].part, second[2].number), (Part::AOA, 1));
        let two = <(B, A, O, A, B, A, O, A, B)>::LETTERS;
        assert_eq!(joined(two), Word::spelled(two).substeps);
        let unequal = <(A<1, 3>, O, A<2, 3>, B)>::LETTERS;
        assert_eq!(joined(unequal), Word::spelled(unequal).substeps);
    }
}
