//! `[(0, 1/2), (1, 1/2)]`: quadrature points with their weights, exactly as they are written.

use syn::{BinOp, Expr, ExprBinary, ExprTuple, ExprUnary, Lit, UnOp};

use super::peeled;
use crate::diagnostics::messages;
use crate::embedding::Points;
use crate::symbolic::Rational;

/// The most points, as for the stages of `Gauss`.
const MOST: usize = 16;

pub(super) fn read_points(list: &Expr) -> syn::Result<Points> {
    let Expr::Array(array) = list else { return Err(messages::not_points(list)) };
    if array.elems.is_empty() {
        return Err(messages::not_points(list));
    }
    if array.elems.len() > MOST {
        return Err(messages::too_many_points(list));
    }
    let mut points: Vec<(Rational, Rational)> = Vec::new();
    for pair in &array.elems {
        let (l, weight) = match pair {
            Expr::Tuple(ExprTuple { elems, .. }) if elems.len() == 2 => (&elems[0], &elems[1]),
            _ => return Err(messages::not_points(pair)),
        };
        let read = |number| exact(number).ok_or_else(|| messages::point_number(number));
        let point @ (at, share) = (read(l)?, read(weight)?);
        if at.is_negative() || Rational::ONE.add(at.negate()).is_none_or(Rational::is_negative) {
            return Err(messages::point_outside(l));
        }
        if points.iter().any(|&(known, _)| known == at) {
            return Err(messages::point_again(l));
        }
        if share.is_zero() {
            return Err(messages::point_without_weight(weight));
        }
        points.push(point);
    }
    let sum = points.iter().try_fold(Rational::ZERO, |sum, (_, weight)| sum.add(*weight));
    match sum {
        Some(sum) if !sum.is_one() => Err(messages::weights_of_points(list, &sum)),
        sum => sum.and(Points::new(points)).ok_or_else(|| messages::inexact_points(list)),
    }
}

/// The value of a literal, of its negative, or of a quotient.
fn exact(number: &Expr) -> Option<Rational> {
    match peeled(number) {
        Expr::Unary(ExprUnary { op: UnOp::Neg(_), expr, .. }) => Some(exact(expr)?.negate()),
        Expr::Binary(ExprBinary { left, op: BinOp::Div(_), right, .. }) => {
            exact(left)?.multiply(exact(right)?.recip()?)
        }
        Expr::Lit(literal) => match &literal.lit {
            Lit::Int(number) => Rational::new(number.base10_parse().ok()?, 1),
            Lit::Float(number) => Rational::from_decimal(number.base10_digits()),
            _ => None,
        },
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop")]

    use super::*;

    fn read(text: &str) -> Result<Points, String> {
        read_points(&syn::parse_str(text).unwrap()).map_err(|error| error.to_string())
    }

    #[test]
    fn numbers_are_exact() {
        let simpson = read("[(0, 1/6), (0.5, (2)/3), (1, 1 / 6)]").unwrap();
        let sixth = Rational::new(1, 6).unwrap();
        let mut points = simpson.iter();
        assert_eq!(points.next(), Some((Rational::ZERO, sixth)));
        assert_eq!(points.next().map(|(l, _)| l), Some(Rational::HALF));
        assert_eq!((simpson.mean(), simpson.spread()), (Rational::HALF, Rational::new(1, 12).unwrap()));
        assert!(simpson.are_symmetric() && !simpson.is_single());
        let radau = read("[(1/3, 3/4), (1, 0.25)]").unwrap();
        assert!(radau.mean() == Rational::HALF && !radau.are_symmetric());
        // Open Newton-Cotes, with a negative weight.
        assert!(read("[(1/4, 2/3), (1/2, -1/3), (3/4, 2/3)]").unwrap().are_symmetric());
    }

    #[test]
    fn mistakes_are_found() {
        let error = |text: &str| read(text).unwrap_err();
        assert!(error("[(0, 1/3), (1, 1/2)]").contains("these add up to 5/6"));
        assert!(error("[(0, 0.1), (1, 0.2)]").contains("these add up to 3/10"));
        assert!(error("[(3/2, 1)]").contains("to 1, where it ends"));
        assert!(error("[(-1, 1)]").contains("to 1, where it ends"));
        assert!(error("[(1/2, 1/2), (0.5, 1/2)]").contains("listed already"));
        assert!(error("[(0, 1), (1, 0)]").contains("weight 0"));
        assert!(error("[]").contains("expected quadrature points"));
        assert!(error("[(0, 1, 2)]").contains("expected quadrature points"));
        assert!(error("[(l, 1)]").contains("known exactly"));
        assert!(error("[(1/0, 1)]").contains("known exactly"));
        assert!(error("[(1e-30, 1)]").contains("known exactly"));
        let long = "[(1/9007199254740881, 1/2), (1/9007199254740847, 1/2)]";
        assert!(error(long).contains("too long"));
        let many = format!("[{}]", (0..17).map(|k| format!("({k}/17, 1/17)")).collect::<Vec<_>>().join(", "));
        assert!(error(&many).contains("at most 16"));
    }
}
