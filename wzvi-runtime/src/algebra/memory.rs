//! What one step leaves for the next, and what a caller may pin of how it is solved.

use std::fmt::Debug;
use std::marker::PhantomData;
use std::ops::Range;

use crate::ground::numbers::Numbers;

pub use crate::algebra::threads::Threads;

/// How the equations of an implicit step are iterated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Iteration {
    /// By what contracts.
    #[default]
    Automatic,
    /// `x ← φ(x)` only; an error where that does not contract.
    FixedPoint,
    /// Newton's method with a new Jacobian in every iteration.
    Newton,
}

/// How the linear equations of Newton's method are solved, by the pattern of the Jacobian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// The first step finds out how large the system is.
    Undecided,
    /// There are none.
    Explicit,
    /// The Jacobian is narrow, or small: it is factored in a band.
    Band {
        /// Diagonals on each side.
        half_width: usize,
    },
    /// The band would be too wide: GMRES on products with the Jacobian, with factors of an earlier one as preconditioner.
    Krylov,
}

/// What the linear equations of Newton's method took, of all steps so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinearWork {
    /// Matrices that were factored.
    pub factorisations: u64,
    /// Products with the Jacobian where linear equations are solved by these.
    pub products: u64,
}

/// What one step leaves for the starting value of the next.
pub trait StepMemory: Clone + Debug + Default + Numbers {
    /// Forgets the steps before, and keeps what was allocated.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn forget(&mut self) {
        *self = Self::default();
    }

    /// Keeps of the steps before the last one alone, for the same step anew, a bit longer: it starts where that one ended.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn hold(&mut self) {}

    /// Takes what a step left that was solved with another memory.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn adopt(&mut self, left: Self) {
        *self = left;
    }

    /// Pins how implicit steps are iterated, where there is a choice.
    fn pin(&mut self, _iteration: Iteration) {}

    /// What was pinned.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn pinned(&self) -> Iteration {
        Iteration::Automatic
    }

    /// On how many threads a step may run, where it is that of a large system; on the caller's unless this is called.
    fn share(&mut self, _threads: Threads) {}

    /// How many blocks of equations the last careful step found that have no unknown in common; 1 where it was not asked for.
    fn blocks(&self) -> usize {
        1
    }

    /// Careful steps solve these blocks only, and leave the degrees of freedom of others as they are.
    fn restrict(&mut self, _blocks: Range<usize>) {}

    /// How linear equations are solved, where that depends on the size of the system.
    fn method(&self) -> Option<Method> {
        None
    }

    /// What linear equations took, where that is counted: in steps of systems in loops.
    fn linear_work(&self) -> LinearWork {
        LinearWork::default()
    }
}

impl StepMemory for () {}
impl<S> StepMemory for PhantomData<S> {}

/// As for [`Numbers`].
macro_rules! tuples {
    ($(($($part:ident)+))+) => {$(
        impl<$($part: StepMemory),+> StepMemory for ($($part,)+) {
            #[cfg_attr(not(debug_assertions), inline(always))]
            #[allow(non_snake_case, reason = "a part is called as its type")]
            fn hold(&mut self) {
                let ($($part,)+) = self;
                $($part.hold();)+
            }
        }
    )+};
}

tuples! {
    (A)
    (A B)
    (A B C)
    (A B C D)
    (A B C D E)
    (A B C D E F)
    (A B C D E F G)
    (A B C D E F G H)
    (A B C D E F G H I)
    (A B C D E F G H I J)
    (A B C D E F G H I J K)
    (A B C D E F G H I J K L)
}
