//! Compensated summation of the increments of a state.
//!
//! A step adds an increment to the state, and the sum is rounded. The rounding error is known exactly (D. E.
//! Knuth, *The Art of Computer Programming* 2, section 4.2.2) and is added to the next increment, so that
//! over many steps the errors of these additions do not accumulate. The rounding of the increments themselves
//! remains, which is smaller by the ratio of increment to state.

use std::fmt::Debug;

use crate::algebra::scalar::Scalar;
use crate::algebra::shape::{Fixed, Shape};
use crate::ground::numbers::{Numbers, Tape};

/// The rounding errors of a state that are carried to the next step, or nothing for plain sums.
pub trait StateSum<S>: Clone + Debug + Default + Numbers {
    /// Whether it holds anything.
    const CARRIES: bool;
    /// The carried part of coordinate `i`, less than the degrees of freedom.
    fn of_coordinate(&self, i: usize) -> S;
    /// The carried part of momentum `i`, less than the degrees of freedom.
    fn of_momentum(&self, i: usize) -> S;
    /// `base + increment` plus the carried error, and the rounding error of that sum.
    fn add(base: S, increment: S, carried: S) -> (S, S);
    /// Keeps the rounding errors of a step that succeeded.
    fn keep(&mut self, coordinates: &[S], momenta: &[S]);
    /// The carried parts of all coordinates and of all momenta, `length` each; empty for plain sums.
    fn lists(&mut self, length: usize) -> [&[S]; 2];
    /// As [`StateSum::keep`], in exchange for those of the step before. Only numbers that are `f64` come so.
    fn exchange(&mut self, new: [&mut Vec<f64>; 2]);
}

/// Plain sums.
#[derive(Clone, Copy, Debug, Default)]
pub struct PlainSum;

impl<S: Scalar> StateSum<S> for PlainSum {
    const CARRIES: bool = false;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of_coordinate(&self, _i: usize) -> S {
        S::from_f64(0.0)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of_momentum(&self, _i: usize) -> S {
        S::from_f64(0.0)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add(base: S, increment: S, _carried: S) -> (S, S) {
        (base + increment, S::from_f64(0.0))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn keep(&mut self, _coordinates: &[S], _momenta: &[S]) {}
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lists(&mut self, _length: usize) -> [&[S]; 2] {
        [&[]; 2]
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn exchange(&mut self, _new: [&mut Vec<f64>; 2]) {}
}

impl Numbers for PlainSum {
    fn pass(&mut self, _tape: &mut Tape) {}
}

/// Compensated sums: rounding errors are carried to the next step. Vectors are empty until the first step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CompensatedSum<S: Scalar, H: Shape> {
    coordinates: H::List<S>,
    momenta: H::List<S>,
}

/// Compensated sums for `D` degrees of freedom.
pub type FixedCompensatedSum<S, const D: usize> = CompensatedSum<S, Fixed<D>>;

impl<S: Scalar, H: Shape> Default for CompensatedSum<S, H> {
    fn default() -> Self {
        let zeros = || H::list(0, S::from_f64(0.0));
        Self { coordinates: zeros(), momenta: zeros() }
    }
}

/// Makes a vector so long; arrays are.
#[cfg_attr(not(debug_assertions), inline(always))]
fn fit<S: Scalar, H: Shape>(list: &mut H::List<S>, length: usize) {
    if !H::IS_FIXED && list.as_ref().len() != length {
        *list = H::list(length, S::from_f64(0.0));
    }
}

impl<S: Scalar, H: Shape> StateSum<S> for CompensatedSum<S, H> {
    const CARRIES: bool = true;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of_coordinate(&self, i: usize) -> S {
        self.coordinates.as_ref().get(i).copied().unwrap_or(S::from_f64(0.0))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of_momentum(&self, i: usize) -> S {
        self.momenta.as_ref().get(i).copied().unwrap_or(S::from_f64(0.0))
    }
    /// The exact error of the rounded sum, whichever of the two is larger.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add(base: S, increment: S, carried: S) -> (S, S) {
        let addend = increment + carried;
        let sum = base + addend;
        let taken_in = sum - base;
        let lost = (base - (sum - taken_in)) + (addend - taken_in);
        (sum, lost)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn keep(&mut self, coordinates: &[S], momenta: &[S]) {
        fit::<S, H>(&mut self.coordinates, coordinates.len());
        fit::<S, H>(&mut self.momenta, momenta.len());
        for (carried, lost) in self.coordinates.as_mut().iter_mut().zip(coordinates) {
            *carried = *lost;
        }
        for (carried, lost) in self.momenta.as_mut().iter_mut().zip(momenta) {
            *carried = *lost;
        }
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lists(&mut self, length: usize) -> [&[S]; 2] {
        fit::<S, H>(&mut self.coordinates, length);
        fit::<S, H>(&mut self.momenta, length);
        [self.coordinates.as_ref(), self.momenta.as_ref()]
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn exchange(&mut self, [coordinates, momenta]: [&mut Vec<f64>; 2]) {
        H::exchange(&mut self.coordinates, coordinates);
        H::exchange(&mut self.momenta, momenta);
    }
}

/// Vectors with their length before them.
impl<S: Scalar, H: Shape> Numbers for CompensatedSum<S, H> {
    fn pass(&mut self, tape: &mut Tape) {
        for list in [&mut self.coordinates, &mut self.momenta] {
            if !H::IS_FIXED {
                fit::<S, H>(list, tape.length(list.as_ref().len()));
            }
            list.as_mut().iter_mut().for_each(|number| number.pass(tape));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_lost() {
        // Ten million additions of a tenth: exact but for the rounding of 0.1 itself.
        let mut carry = FixedCompensatedSum::<f64, 1>::default();
        let (mut plain, mut sum) = (0.0_f64, 0.0_f64);
        for _ in 0..10_000_000 {
            plain += 0.1;
            let lost;
            (sum, lost) = FixedCompensatedSum::<f64, 1>::add(sum, 0.1, carry.of_coordinate(0));
            carry.keep(&[lost], &[0.0]);
        }
        assert_eq!(sum, 1e6);
        assert!((plain - 1e6).abs() > 1e-5);
    }

    #[test]
    fn the_lost_part_is_exact() {
        for (base, increment) in [(1.0, 1e-17), (1e-17, 1.0), (1e16, 1.5), (-3.0, 2.999_999_999_999_999_6)] {
            let (sum, lost) = <FixedCompensatedSum<f64, 1> as StateSum<f64>>::add(base, increment, 0.0);
            assert_eq!(sum, base + increment);
            // Both parts are representable: check by exact integer arithmetic on scaled values.
            let scale = 2.0_f64.powi(60);
            let exact = |x: f64| (x * scale) as i128;
            if base.abs() < 1e16 {
                let error = exact(base) + exact(increment) - exact(sum) - exact(lost);
                assert!(error.abs() <= 2, "{base} + {increment}");
            }
        }
    }
}
