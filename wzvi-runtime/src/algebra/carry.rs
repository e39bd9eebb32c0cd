//! Compensated summation of the increments of a state.
//!
//! A step adds an increment to the state, and the sum is rounded. The rounding error is known exactly (D. E. Knuth,
//! *The Art of Computer Programming* 2, section 4.2.2) and is added to the next increment, so that over many steps the
//! errors of these additions do not accumulate. The rounding of the increments themselves remains, which is
//! smaller by the ratio of increment to state.

use std::fmt::Debug;

use crate::algebra::scalar::Scalar;
use crate::ground::numbers::{Numbers, Tape};

/// The rounding errors of a state that are carried to the next step, or nothing for plain sums.
pub trait Carry<S>: Clone + Debug + Default + Numbers {
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
}

/// Plain sums.
#[derive(Clone, Copy, Debug, Default)]
pub struct Plain;

impl<S: Scalar> Carry<S> for Plain {
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
}

impl Numbers for Plain {
    fn pass(&mut self, _tape: &mut Tape) {}
}

/// Compensated sums for `D` degrees of freedom: rounding errors are carried to the next step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compensation<S, const D: usize> {
    coordinates: [S; D],
    momenta: [S; D],
}

impl<S: Scalar, const D: usize> Default for Compensation<S, D> {
    fn default() -> Self {
        Self { coordinates: [S::from_f64(0.0); D], momenta: [S::from_f64(0.0); D] }
    }
}

impl<S: Scalar, const D: usize> Carry<S> for Compensation<S, D> {
    const CARRIES: bool = true;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of_coordinate(&self, i: usize) -> S {
        self.coordinates[i]
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of_momentum(&self, i: usize) -> S {
        self.momenta[i]
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
        for (carried, lost) in self.coordinates.iter_mut().zip(coordinates) {
            *carried = *lost;
        }
        for (carried, lost) in self.momenta.iter_mut().zip(momenta) {
            *carried = *lost;
        }
    }
}

impl<S: Numbers, const D: usize> Numbers for Compensation<S, D> {
    fn pass(&mut self, tape: &mut Tape) {
        let Self { coordinates, momenta } = self;
        coordinates.pass(tape);
        momenta.pass(tape);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_lost() {
        // Ten million additions of a tenth: exact but for the rounding of 0.1 itself.
        let mut carry = Compensation::<f64, 1>::default();
        let (mut plain, mut sum) = (0.0_f64, 0.0_f64);
        for _ in 0..10_000_000 {
            plain += 0.1;
            let lost;
            (sum, lost) = Compensation::<f64, 1>::add(sum, 0.1, carry.of_coordinate(0));
            carry.keep(&[lost], &[0.0]);
        }
        assert_eq!(sum, 1e6);
        assert!((plain - 1e6).abs() > 1e-5);
    }

    #[test]
    fn the_lost_part_is_exact() {
        for (base, increment) in [(1.0, 1e-17), (1e-17, 1.0), (1e16, 1.5), (-3.0, 2.999_999_999_999_999_6)] {
            let (sum, lost) = <Compensation<f64, 1> as Carry<f64>>::add(base, increment, 0.0);
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
