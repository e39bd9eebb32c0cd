//! Decides whether an expression is identically zero: not zero with a witness, zero with a probability of
//! error below 1e-15, or undecided.
//!
//! 1. The canonical form is the number 0.
//! 2. It vanishes at random points of finite fields ([`super::residue`]): zero, up to a probability below
//!    1e-15.
//! 3. A point where its value exceeds the rounding bound of its evaluation: not zero, with that point as
//!    witness.
//!
//! Tests: `symbolic/tests/mod.rs`, `lower/tests/identities.rs`.

use super::residue::{SplitMix, vanishes_modulo_primes};
use super::{Expr, Graph, Node, Symbol};

/// The answer to "is it zero wherever it is defined?".
#[derive(Clone, PartialEq, Debug)]
pub(crate) enum ZeroTest {
    Zero,
    Nonzero(Witness),
    /// Neither proven: an identity of functions that the test does not know, or a difference below rounding.
    Unknown,
}

impl ZeroTest {
    pub(crate) fn known(self) -> Knowledge {
        match self {
            Self::Zero => Knowledge::Proven,
            Self::Nonzero(witness) => Knowledge::Refuted(witness),
            Self::Unknown => Knowledge::Unknown(
                "it vanishes wherever it was evaluated, but by no identity that the compiler tries: those of fractions, \
                 square roots and `hypot`, of `sin`, `cos` and `tan` of sums, multiples and fractions of angles, of `exp`, `exp2`, \
                 `sinh`, `cosh` and `tanh`, and of powers of one base (not of sums of logarithms, inverse functions and `cbrt`)"
                    .to_owned(),
            ),
        }
    }
}

/// A point where the expression is certainly not zero.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Witness {
    /// The symbols that the expression contains, in order of creation.
    pub(crate) point: Vec<(Symbol, f64)>,
    pub(crate) value: f64,
}

/// The knowledge of a statement "this vanishes".
#[derive(Clone, Debug)]
pub(crate) enum Knowledge {
    Proven,
    Refuted(Witness),
    /// The reason why neither is known.
    Unknown(String),
}

impl Knowledge {
    pub(crate) fn is_proven(&self) -> bool {
        matches!(self, Self::Proven)
    }
}

/// Simple numbers first, for readable witnesses.
const SIMPLE: [f64; 12] = [0.5, 1.0, -0.75, 1.25, 2.0, -0.5, 1.5, 0.25, -1.0, 0.75, 3.0, -1.5];
const SIMPLE_POINTS: usize = 10;
const RANDOM_POINTS: usize = 40;
/// The most node evaluations at all points, and the fewest points for a very large expression.
const WORK: usize = 200_000;
const FEWEST_POINTS: usize = 3;

impl Graph {
    /// Decides whether the real expression `expr` is zero wherever it is defined.
    ///
    /// `Nonzero` is certain (up to the error bounds that are granted to the mathematical library). `Zero`
    /// holds up to the probability that [`super::residue`] states, and only if no floating-point witness
    /// contradicts it.
    pub(crate) fn test_zero(&self, expr: Expr) -> ZeroTest {
        match self.node(expr) {
            Node::Number(value) if value.is_zero() => return ZeroTest::Zero,
            Node::Compare(..) | Node::Not(_) | Node::Join(..) => return ZeroTest::Unknown,
            _ => {}
        }
        match self.find_witness(expr) {
            Some(witness) => ZeroTest::Nonzero(witness),
            None if vanishes_modulo_primes(self, expr) => ZeroTest::Zero,
            None => ZeroTest::Unknown,
        }
    }

    fn find_witness(&self, expr: Expr) -> Option<Witness> {
        let parts = self.reachable(&[expr]);
        let trials = (WORK / parts.len()).clamp(FEWEST_POINTS, SIMPLE_POINTS + RANDOM_POINTS);
        let mut symbols: Vec<Symbol> = parts.into_iter().filter_map(|part| self.as_symbol(part)).collect();
        symbols.sort_unstable();
        let mut random = SplitMix::new(0x5eed);
        (0..trials).find_map(|trial| {
            let point = symbols.iter().enumerate();
            let point = point.map(|(i, &symbol)| (symbol, coordinate(trial, i, &mut random)));
            let point: Vec<(Symbol, f64)> = point.collect();
            let value = |symbol: Symbol| {
                point.binary_search_by_key(&symbol, |&(known, _)| known).map_or(f64::NAN, |i| point[i].1)
            };
            let bounded = self.evaluate_bounded(&[expr], &value)[0];
            bounded.excludes_zero().then(|| Witness { point: point.clone(), value: bounded.value })
        })
    }
}

/// The `i`-th coordinate of a trial point: simple numbers, then random ones of mixed sign and scale.
pub(super) fn coordinate(trial: usize, i: usize, random: &mut SplitMix) -> f64 {
    if trial < SIMPLE_POINTS {
        let value = SIMPLE[(trial + i * (1 + trial / SIMPLE.len()) + i / SIMPLE.len()) % SIMPLE.len()];
        // Every second simple point lies in the domain of roots and logarithms.
        return if trial.is_multiple_of(2) { value } else { value.abs() };
    }
    let unit = random.unit();
    let sign = if trial.is_multiple_of(2) || random.unit() < 0.5 { 1.0 } else { -1.0 };
    let scale = match trial % 5 {
        0 => 10f64.powf(6.0 * random.unit() - 3.0),
        1 => 0.3,
        2 => 10.0,
        _ => 1.0,
    };
    sign * scale * (0.1 + 2.9 * unit)
}
