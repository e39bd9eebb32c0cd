//! Splittings as words of letters: drifts, kicks, friction and noise.

use std::fmt;

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{ToTokens, quote};

use crate::diagnostics::promised;
use crate::symbolic::Rational;

/// The most letters that the run time takes.
pub(crate) const MOST_LETTERS: usize = 24;

/// The part of the system that a letter advances.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum LetterKind {
    Drift,
    Kick,
    Bath,
}

impl LetterKind {
    pub(crate) const ALL: [Self; 3] = [Self::Drift, Self::Kick, Self::Bath];

    pub(crate) fn letter(self) -> &'static str {
        match self {
            Self::Drift => "A",
            Self::Kick => "B",
            Self::Bath => "O",
        }
    }
}

/// A letter, with the share of the step that was given to it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Letter {
    pub(crate) kind: LetterKind,
    pub(crate) share: Option<(u32, u32)>,
}

/// The letters of a step, one after the other.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct Word(pub(crate) Vec<Letter>);

impl Word {
    /// With equal shares.
    pub(crate) fn of(letters: &str) -> Self {
        let kinds = letters
            .chars()
            .filter_map(|letter| LetterKind::ALL.into_iter().find(|kind| kind.letter().chars().eq([letter])));
        Self(kinds.map(|kind| Letter { kind, share: None }).collect())
    }

    /// Each letter, and how much of the step it lasts.
    pub(crate) fn shares(&self) -> Vec<(LetterKind, Rational)> {
        let of_kind = |kind| self.0.iter().filter(|letter| letter.kind == kind).count();
        let share = |letter: &Letter| {
            let (n, d) =
                letter.share.map_or((1, of_kind(letter.kind) as i128), |(n, d)| (n.into(), d.into()));
            (letter.kind, promised(Rational::new(n, d), "shares are fractions of 32 bits"))
        };
        self.0.iter().map(share).collect()
    }

    /// The sum of the shares of a kind; `None` beyond the arithmetic of fractions.
    pub(crate) fn total(&self, of: LetterKind) -> Option<Rational> {
        let mut shares = self.shares().into_iter().filter(|(kind, _)| *kind == of);
        shares.try_fold(Rational::ZERO, |sum, (_, share)| sum.add(share))
    }

    /// Two if for each pair of different letters the products of shares of the one before the other add to
    /// one half, else one.
    pub(crate) fn order(&self) -> u32 {
        let shares = self.shares();
        let sum = |x: LetterKind, y: LetterKind| {
            let mut pairs = shares.iter().enumerate().flat_map(|(j, &(of, second))| {
                let before = shares[..j].iter().filter(move |(kind, _)| *kind == x && of == y);
                before.map(move |(_, first)| first.multiply(second))
            });
            pairs.try_fold(Rational::ZERO, |sum, product| sum.add(product?))
        };
        let is_half = |x, y| x == y || sum(x, y) == Some(Rational::HALF);
        if LetterKind::ALL.iter().all(|&x| LetterKind::ALL.iter().all(|&y| is_half(x, y))) { 2 } else { 1 }
    }

    /// Whether no friction is between two drifts; those before the first friction of a step go on from those
    /// after the last one of the step before.
    pub(crate) fn has_drifts_together(&self) -> bool {
        let mut kinds: Vec<LetterKind> =
            self.shares().iter().map(|&(kind, _)| kind).filter(|kind| *kind != LetterKind::Kick).collect();
        kinds.dedup();
        let ends_alike = kinds.len() > 1 && kinds.first() == kinds.last();
        kinds.iter().skip(usize::from(ends_alike)).filter(|kind| **kind == LetterKind::Drift).count() <= 1
    }

    /// Whether it reads the same backwards.
    pub(crate) fn is_symmetric(&self) -> bool {
        let shares = self.shares();
        shares.iter().eq(shares.iter().rev())
    }

    /// The letters as types.
    pub(crate) fn types(&self, wzvi: &impl ToTokens) -> TokenStream {
        let letters = self.0.iter().map(|Letter { kind, share }| {
            let name = Ident::new(kind.letter(), Span::call_site());
            let share = share.map(|(n, d)| {
                let [n, d] = [n, d].map(Literal::u32_unsuffixed);
                quote!(<#n, #d>)
            });
            quote!(#wzvi::bath::#name #share)
        });
        quote!((#(#letters,)*))
    }
}

impl fmt::Display for Word {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let letters = self.0.iter().map(|Letter { kind, share }| match share {
            Some((n, d)) => format!("{}<{n}, {d}>", kind.letter()),
            None => kind.letter().to_owned(),
        });
        write!(f, "({})", letters.collect::<Vec<_>>().join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_are_those_of_the_products() {
        let rows = [
            ("BAOAB", 2, true),
            ("BAOA", 1, false),
            ("OBAB", 1, false),
            ("AOBOA", 2, true),
            ("OBAABO", 2, true),
        ];
        for (letters, order, is_symmetric) in rows {
            let word = Word::of(letters);
            assert_eq!((word.order(), word.is_symmetric()), (order, is_symmetric), "{letters}");
        }
        // AB: 2/3 · 3/4 = 1/2, and BA has the rest of one; without an O no product with it is one half.
        let letter = |kind, n, d| Letter { kind, share: Some((n, d)) };
        let word = Word(vec![
            letter(LetterKind::Kick, 1, 4),
            letter(LetterKind::Drift, 2, 3),
            letter(LetterKind::Kick, 3, 4),
            letter(LetterKind::Drift, 1, 3),
        ]);
        let sums = [word.total(LetterKind::Drift), word.total(LetterKind::Kick)];
        assert_eq!(sums, [Some(Rational::ONE); 2]);
        assert_eq!((word.order(), word.is_symmetric()), (1, false));
    }
}
