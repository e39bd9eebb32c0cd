//! The first terms, as text, of the modified Hamiltonian that steps without noise and explicit time follow
//! (backward error analysis; E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*, chapter IX;
//! the run time finds the same terms for compositions).
//!
//! ```text
//! H~ = H + h a H_p · H_q + h² (b H_pp(H_q, H_q) + c H_qq(H_p, H_p) + d H_pq(H_q, H_p))
//! one quadrature point l:  a = l - 1/2,  b = c = 1/12 - l (1 - l)/2,  d = 1/3 - l (1 - l)
//! several, with mean l:    c + Σ w (l_s - l)²/2 in place of c, since h H gains that h³ H_qq(H_p, H_p)
//! Verlet:                  a = 0,  b = -1/24,  c = d = 1/12
//! ```
//!
//! With `K = H_p · H_q` and `T(p) + V(q)` the last one vanishes, and the other two are `K_p · H_q` and
//! `K_q · H_p`.

use super::facts::Facts;
use super::sums::{Calculus, Increments};
use crate::embedding::Embedding;
use crate::model::Half;
use crate::symbolic::{Graph, Rational, signed};

/// `a`, and `b`, `c`, `d`.
#[derive(Debug, PartialEq)]
struct Coefficients {
    first: Rational,
    second: [Rational; 3],
}

impl Coefficients {
    /// `None` for schemes with several stages.
    fn of(embedding: &Embedding) -> Option<Self> {
        let fraction = |numerator, denominator| Rational::new(numerator, denominator);
        if *embedding == Embedding::Verlet {
            let twelfth = fraction(1, 12)?;
            return Some(Self { first: Rational::ZERO, second: [fraction(-1, 24)?, twelfth, twelfth] });
        }
        if embedding.stages().is_some() {
            return None;
        }
        let [points, _] = embedding.points();
        let l = points.mean();
        let product = l.multiply(Rational::ONE.add(l.negate())?)?.negate();
        let alike = fraction(1, 12)?.add(product.multiply(Rational::HALF)?)?;
        let spread = points.spread().multiply(Rational::HALF)?;
        let second = [alike, alike.add(spread)?, Rational::THIRD.add(product)?];
        Some(Self { first: l.add(Rational::HALF.negate())?, second })
    }
}

const FIRST: &str = "H_p·H_q";
const SECOND: [&str; 3] = ["H_pp(H_q,H_q)", "H_qq(H_p,H_p)", "H_pq(H_q,H_p)"];

/// The formula, and for `T(p) + V(q)` its terms; `None` if no modified Hamiltonian exists or is known.
pub(crate) fn text(graph: &mut Graph, facts: &Facts, embedding: &Embedding) -> Option<String> {
    // The expansion assumes a smooth function; the brackets are those of one piece.
    let has_one = facts.energy.is_conservative && facts.boundaries[0].is_empty();
    let Coefficients { first, second } = Coefficients::of(embedding).filter(|_| has_one)?;
    let edge = format!("h {FIRST}");
    let first_order = [(Rational::ONE, "H0"), (first, &edge)];
    let second_order = SECOND.iter().zip(second).take(if facts.is_separable { 2 } else { 3 });
    let second_order = sum(second_order.map(|(name, factor)| (factor, *name)));
    let formula = format!("{} + h² ({second_order})", sum(first_order));
    let order = if first.is_zero() { "O(h⁴)" } else { "O(h³)" };
    let mut text = format!("  modified energy, kept within {order}: {formula}\n");
    if facts.is_separable && !facts.drift.iter().any(|weighted| weighted.element.is_collective()) {
        let (space, drift) = (&mut facts.space.clone(), &facts.drift);
        let (q, p) = (Half::Coordinates, Half::Momenta);
        let mut sums = Calculus { space, graph };
        let together = sums.contract((drift, p), (drift, q), Increments::Each)?;
        let by_p = sums.contract((&together, p), (drift, q), Increments::Each)?;
        let by_q = sums.contract((&together, q), (drift, p), Increments::Each)?;
        let edge = (FIRST, &together, !first.is_zero());
        let [of_p, of_q, _] = second.map(|factor| !factor.is_zero());
        for (name, value, is_there) in [edge, (SECOND[0], &by_p, of_p), (SECOND[1], &by_q, of_q)] {
            if is_there {
                let value = facts.space.display(graph, value, Rational::ONE);
                text.push_str(&format!("    {name} = {value}\n"));
            }
        }
    }
    Some(text)
}

/// The sum of the terms with nonzero factors.
fn sum<'t>(terms: impl IntoIterator<Item = (Rational, &'t str)>) -> String {
    let terms = terms.into_iter().filter(|(factor, _)| !factor.is_zero()).map(|(factor, term)| {
        let (over, under) = (factor.numerator().unsigned_abs(), factor.denominator());
        let over = if over == 1 { String::new() } else { format!("{over} ") };
        let under = if under == 1 { String::new() } else { format!("/{under}") };
        (factor.is_negative(), format!("{over}{term}{under}"))
    });
    signed(terms)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop")]

    use super::*;

    #[test]
    fn terms_are_those_of_known_schemes() {
        let of = |numbers: [(i128, i128); 4]| {
            let [a, b, c, d] = numbers.map(|(over, under)| Rational::new(over, under).unwrap());
            Some(Coefficients { first: a, second: [b, c, d] })
        };
        // Hairer, Lubich, Wanner, example IX.3.4 (for the symplectic Euler method) and exercises.
        assert_eq!(Coefficients::of(&Embedding::DeltaPlus), of([(-1, 2), (1, 12), (1, 12), (1, 3)]));
        assert_eq!(Coefficients::of(&Embedding::DeltaMinus), of([(1, 2), (1, 12), (1, 12), (1, 3)]));
        assert_eq!(Coefficients::of(&Embedding::Midpoint), of([(0, 1), (-1, 24), (-1, 24), (1, 12)]));
        assert_eq!(Coefficients::of(&Embedding::Verlet), of([(0, 1), (-1, 24), (1, 12), (1, 12)]));
        assert_eq!(Coefficients::of(&Embedding::Gauss(1)), Coefficients::of(&Embedding::Midpoint));
        assert_eq!(Coefficients::of(&Embedding::Gauss(2)), None);
    }
}
