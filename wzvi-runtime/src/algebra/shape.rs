//! Lists of one entry per degree of freedom: arrays if their number is known at compile time,
//! else vectors.

use std::any::Any;
use std::fmt::Debug;

use crate::algebra::scalar::Scalar;

/// The type of the lists of a system.
pub trait Shape: Debug + Clone + Copy + Default + 'static {
    /// A list.
    type List<T: Copy + Debug>: AsRef<[T]> + AsMut<[T]> + Clone + Debug;

    /// Whether lists are arrays, whose length is known before there is a state.
    const IS_FIXED: bool;

    /// A list of `length` entries.
    fn list<T: Copy + Debug>(length: usize, fill: T) -> Self::List<T>;

    /// The lists of a step: `new` arrays, which stay in registers, or the vectors of `room`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lend<T>(room: &mut T, new: T) -> T {
        if Self::IS_FIXED { new } else { std::mem::replace(room, new) }
    }

    /// Replaces the numbers of a list by those of a vector of the same length, which may take the old ones in
    /// exchange. Only numbers that are `f64` come so.
    fn exchange<S: Scalar>(list: &mut Self::List<S>, new: &mut Vec<f64>);

    /// Replaces `kept` by a list of the same length, which may take the old numbers in exchange.
    fn keep<T: Copy + Debug>(kept: &mut Self::List<T>, list: &mut Self::List<T>);

    /// Returns the lists to `room`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn give_back<T>(room: &mut T, lent: T) {
        if !Self::IS_FIXED {
            *room = lent;
        }
    }
}

/// Arrays.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fixed<const D: usize>;

impl<const D: usize> Shape for Fixed<D> {
    type List<T: Copy + Debug> = [T; D];
    const IS_FIXED: bool = true;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn list<T: Copy + Debug>(_: usize, fill: T) -> [T; D] {
        [fill; D]
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn keep<T: Copy + Debug>(kept: &mut [T; D], list: &mut [T; D]) {
        *kept = *list;
    }

    fn exchange<S: Scalar>(list: &mut [S; D], new: &mut Vec<f64>) {
        if let Some(list) = S::as_f64s_mut(list) {
            list.copy_from_slice(new);
        }
    }
}

/// Vectors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dynamic;

impl Shape for Dynamic {
    type List<T: Copy + Debug> = Vec<T>;
    const IS_FIXED: bool = false;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn list<T: Copy + Debug>(length: usize, fill: T) -> Vec<T> {
        vec![fill; length]
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn keep<T: Copy + Debug>(kept: &mut Vec<T>, list: &mut Vec<T>) {
        std::mem::swap(kept, list);
    }

    fn exchange<S: Scalar>(list: &mut Vec<S>, new: &mut Vec<f64>) {
        if let Some(list) = (list as &mut dyn Any).downcast_mut() {
            std::mem::swap(list, new);
        }
    }
}
