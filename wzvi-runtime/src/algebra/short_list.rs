//! Short lists by value.
//!
//! State, increments and stepper of a small system stay in registers only if no function receives their
//! address, not even one that is called once in a million steps. Rare calls therefore receive copies.

use std::ops::{Deref, DerefMut};

use crate::algebra::scalar::Scalar;

/// The longest list that is copied: longer ones are not in registers anyway.
const MOST: usize = 16;

/// A copy of a short list.
#[derive(Clone, Copy)]
pub(crate) struct ShortList<S> {
    numbers: [S; MOST],
    length: usize,
}

impl<S: Scalar> ShortList<S> {
    /// A copy; `None` if the list is long.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn of(list: &[S]) -> Option<Self> {
        let mut numbers = [S::from_f64(0.0); MOST];
        numbers.get_mut(..list.len())?.copy_from_slice(list);
        Some(Self { numbers, length: list.len() })
    }
}

impl<S> Deref for ShortList<S> {
    type Target = [S];

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn deref(&self) -> &[S] {
        &self.numbers[..self.length]
    }
}

impl<S> DerefMut for ShortList<S> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn deref_mut(&mut self) -> &mut [S] {
        &mut self.numbers[..self.length]
    }
}

/// A list, short or not.
#[derive(Clone, Copy)]
pub(crate) enum ShortOrLong<'a, S> {
    Short(ShortList<S>),
    Long(&'a [S]),
}

impl<'a, S: Scalar> ShortOrLong<'a, S> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn of(list: &'a [S]) -> Self {
        ShortList::of(list).map_or(Self::Long(list), Self::Short)
    }
}

impl<S> Deref for ShortOrLong<'_, S> {
    type Target = [S];

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn deref(&self) -> &[S] {
        match self {
            Self::Short(few) => few,
            Self::Long(list) => list,
        }
    }
}
