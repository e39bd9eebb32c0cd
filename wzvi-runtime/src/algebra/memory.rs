//! Data that one step passes to the next, and the settings of the solver that a caller may fix.

use std::fmt::Debug;
use std::marker::PhantomData;
use std::ops::AddAssign;

use crate::ground::numbers::{Numbers, for_tuples};

pub use crate::algebra::threads::Threads;

/// How the equations of an implicit step are iterated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Iteration {
    /// The fixed point or Newton's method, whichever finishes with fewer operations as far as the contraction
    /// tells.
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
    /// The steps solve no equations.
    Explicit,
    /// The Jacobian is narrow, or small: it is factored in a band.
    Band {
        /// Diagonals on each side.
        half_width: usize,
    },
    /// The band would be too wide: GMRES on products with the Jacobian, with factors of an earlier one as
    /// preconditioner.
    Krylov,
}

/// The cost of the linear equations of Newton's method, over all steps so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinearWork {
    /// Matrices that were factored.
    pub factorisations: u64,
    /// Products with the Jacobian where linear equations are solved by these.
    pub products: u64,
}

impl AddAssign for LinearWork {
    fn add_assign(&mut self, other: Self) {
        self.factorisations += other.factorisations;
        self.products += other.products;
    }
}

/// A request to a memory.
#[derive(Clone, Debug)]
pub enum MemoryRequest {
    /// Forget the steps before, and keep what was allocated.
    Forget,
    /// Keep only the last step, to take the same step again with a slightly larger size: it starts where that
    /// one ended.
    Hold,
    /// Solve by this iteration.
    Pin(Iteration),
    /// Take large steps on this many threads.
    Share(Threads),
    /// So many derivatives of each step follow from one solution of its equations, over all steps in numbers
    /// with derivatives.
    Derivatives(usize),
}

/// How steps are solved.
#[derive(Clone, Copy, Debug)]
pub struct SolverReport {
    /// The iteration that was [asked for](MemoryRequest::Pin).
    pub pinned: Iteration,
    /// How linear equations are solved, where a system of any size has some.
    pub method: Option<Method>,
    /// The cost of linear equations.
    pub linear_work: LinearWork,
}

impl Default for SolverReport {
    fn default() -> Self {
        let (pinned, linear_work) = (Iteration::Automatic, LinearWork::default());
        Self { pinned, method: None, linear_work }
    }
}

impl SolverReport {
    /// The report of both: what the first says, or else the second, with the work of both.
    pub(crate) fn and(self, Self { pinned, method, linear_work, .. }: Self) -> Self {
        let mut both = Self { method: self.method.or(method), ..self };
        both.pinned = if both.pinned == Iteration::Automatic { pinned } else { both.pinned };
        both.linear_work += linear_work;
        both
    }
}

/// Data that one step keeps for the starting value of the next.
pub trait StepMemory: Clone + Debug + Default + Numbers {
    /// Carries out a request, as far as it concerns this memory.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn tell(&mut self, request: &MemoryRequest) {
        if let MemoryRequest::Forget = request {
            *self = Self::default();
        }
    }

    /// Whether the next step may run in lanes.
    fn allows_lanes(&self) -> bool {
        true
    }

    /// Takes over the memory of a step that was solved with another one.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn adopt(&mut self, left: Self) {
        *self = left;
    }

    /// After a step in numbers with derivatives: lends its values and its factors to the memory of other
    /// derivatives. `are_solved`: these take the same step, and need not solve it again.
    fn hand_values(&mut self, _to: &mut Self, _are_solved: bool) {}

    /// Becomes a copy, without allocating where it has room.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn copy(&mut self, other: &Self) {
        self.clone_from(other);
    }

    /// How steps are solved.
    fn report(&self) -> SolverReport {
        SolverReport::default()
    }

    /// The cost of linear equations.
    fn linear_work(&self) -> LinearWork {
        self.report().linear_work
    }
}

impl StepMemory for () {}
impl<S> StepMemory for PhantomData<S> {}

/// One memory for each part of a step.
impl<M: StepMemory> StepMemory for Vec<M> {
    fn tell(&mut self, request: &MemoryRequest) {
        self.iter_mut().for_each(|memory| memory.tell(request));
    }

    fn allows_lanes(&self) -> bool {
        self.iter().all(M::allows_lanes)
    }

    /// Memory by memory; as many as there are in `left` where none was in use yet.
    fn adopt(&mut self, left: Self) {
        if self.len() == left.len() {
            self.iter_mut().zip(left).for_each(|(memory, left)| memory.adopt(left));
        } else {
            *self = left;
        }
    }

    /// The report of the first part, with the work of all.
    fn report(&self) -> SolverReport {
        let mut linear_work = LinearWork::default();
        self.iter().for_each(|memory| linear_work += memory.linear_work());
        let first = self.first().map_or_else(SolverReport::default, M::report);
        SolverReport { linear_work, ..first }
    }
}

/// The methods of a memory that consists of others, its parts, and of results of the last step.
macro_rules! of_parts {
    (($($part:tt)*) $($result:ident)*) => {
        #[cfg_attr(not(debug_assertions), inline(always))]
        fn tell(&mut self, request: &$crate::algebra::memory::MemoryRequest) {
            let _ = request;
            $(self.$part.tell(request);)*
        }

        fn allows_lanes(&self) -> bool {
            true $(&& self.$part.allows_lanes())*
        }

        #[cfg_attr(not(debug_assertions), inline(always))]
        fn adopt(&mut self, left: Self) {
            let _ = &left;
            $(self.$part.adopt(left.$part);)*
            $(self.$result = left.$result;)*
        }

        #[cfg_attr(not(debug_assertions), inline(always))]
        fn copy(&mut self, other: &Self) {
            let _ = other;
            $(self.$part.copy(&other.$part);)*
            $(self.$result.clone_from(&other.$result);)*
        }

        /// The first that says something, with the work of all.
        fn report(&self) -> $crate::algebra::memory::SolverReport {
            [$(self.$part.report()),*].into_iter().fold(
                $crate::algebra::memory::SolverReport::default(),
                $crate::algebra::memory::SolverReport::and,
            )
        }
    };
}

pub(crate) use of_parts;

/// [`StepMemory`] of a struct of memories, with `Clone` and [`Numbers`], from the list of its fields:
///
/// ```text
/// step_memory! {
///     impl[S: Scalar, M: StepMemory] StepMemory for CompositionMemory<S, M> { kept: parts; scratch: start, dw }
/// }
/// ```
///
/// | list | its fields | checkpoints | copies | requests |
/// |---|---|---|---|---|
/// | `kept` | memories | yes | yes | passed on |
/// | `result` | of the last step, read before the next one | no | yes | |
/// | `scratch` | mean nothing outside their step | no | no: the copy has its own | |
///
/// A field in none of the lists does not compile. Lanes take what checkpoints have, one path at a time.
///
/// Three memories answer requests themselves, and their requests and copies are written by hand:
/// `Extrapolation`, the loops' `LoopMemory` and Gauss's `GaussMemory`. Forgetting is a count there, and a
/// copy leaves out lists of which nothing is known, so no list of fields says what they do. What checkpoints
/// have of them is declared by `numbers!` for loops. The other two have no list of fields there: the masks
/// of `Extrapolation` are written as a count for each lane, and Gauss's derivatives at the stages are there
/// only once a step is known, in lists whose size a checkpoint sets.
macro_rules! step_memory {
    (
        impl[$($generics:tt)*] StepMemory for $type:ty {
            kept: $($kept:ident),*
            $(; result: $($result:ident),+)?
            $(; scratch: $($scratch:ident),+)?
        }
    ) => {
        $crate::ground::numbers::numbers! {
            impl[$($generics)*] Numbers for $type {
                kept: $($kept),* $(; result: $($result),+)? $(; scratch: $($scratch),+)?
            }
        }

        impl<$($generics)*> Clone for $type {
            fn clone(&self) -> Self {
                Self {
                    $($kept: self.$kept.clone(),)*
                    $($($result: self.$result.clone(),)+)?
                    $($($scratch: Default::default(),)+)?
                }
            }

            fn clone_from(&mut self, other: &Self) {
                $crate::algebra::memory::StepMemory::copy(self, other);
            }
        }

        impl<$($generics)*> $crate::algebra::memory::StepMemory for $type {
            $crate::algebra::memory::of_parts! { ($($kept)*) $($($result)+)? }
        }
    };
}

pub(crate) use step_memory;

macro_rules! tuples {
    ($(($($part:ident $place:tt)+))+) => {$(
        impl<$($part: StepMemory),+> StepMemory for ($($part,)+) {
            of_parts! { ($($place)+) }
        }
    )+};
}

for_tuples!(tuples);
