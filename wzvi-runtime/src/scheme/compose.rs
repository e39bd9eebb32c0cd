//! Compositions of schemes: [`Verlet`] and [`Composed`].
//!
//! A step of size `h` with increments `ΔW` approximates the flow of the step Hamiltonian
//! `F = h H_0 + Σ_k ΔW_k H_k`, frozen over the step. A composition takes steps of `γ_1 F, γ_2 F, ...` one
//! after the other: steps of size `γ_j h` with increments `γ_j ΔW`, at the times
//! `t + (γ_1 + ... + γ_{j-1}) h`. It is symplectic, like its parts, and the weights determine its order
//! without noise (E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*, sections II.4, V.3).
//!
//! There are two kinds of weights. [`Weights`] are a palindrome for any [symmetric](Symmetric) scheme of
//! order two. [`Partitioned`] are the coefficients of a splitting in drifts and kicks. They also serve
//! Hamiltonians that do not split, by the adjoint pair of [`Verlet`] (R. I. McLachlan, "On the numerical
//! integration of ordinary differential equations by symmetric composition methods", SIAM J. Sci. Comput. 16,
//! 1995).
//!
//! The parts of a step depend on the structure of the system, which the compiler has proven:
//!
//! * [`PairComposition`]: steps of the scheme and its adjoint, for any Hamiltonian.
//! * [`KickDrift`]: kicks and drifts, for `T(p) + V(q, t)`.
//! * [`SummandSplitting`]: the flows of two summands, for `drift = [H_A, H_B]` with the tables for two parts.
//!
//! [`Composes::word`] lists them: `scheme/word.rs` says what a word is.

mod checks;
pub(crate) mod flows;
mod gradient;
mod kepler;
mod lagrangian;
mod linear;
pub(crate) mod lists;
pub(crate) mod memory;
mod pair;
mod plans;
mod structure;
mod summands;
mod tables;
mod text;
pub(crate) mod tiled;

use std::marker::PhantomData;

pub(crate) use text::BoundedText;
use text::{DRIFT_KICK, turns};

use super::word::{Part, PartKind, Weighted, Word};

pub(crate) use plans::plan;

pub use checks::{check_table, check_weights};
#[doc(hidden)]
pub use flows::KickDrift;
#[doc(hidden)]
pub use pair::{BasicMethod, PairComposition};
#[doc(hidden)]
pub(crate) use structure::WHOLE;
#[doc(hidden)]
pub use structure::{General, Nystrom, Parted, QuadraticKinetic, Separable, SingleStep, TwoFlows, WholeOf};
#[doc(hidden)]
pub use summands::{Form, Summand, SummandSplitting};
pub use tables::{
    Aba864, Aba1064, BlanesMoan4, BlanesMoan6, Chin4, KahanLi6, KahanLi8, Srkn6, Suzuki4, SuzukiUmeno8,
    TakahashiImada4, Yoshida4, Yoshida6,
};
#[doc(hidden)]
pub use text::Listing;

/// [`DeltaPlus`](crate::scheme::embedding::DeltaPlus) over half the step, then
/// [`DeltaMinus`](crate::scheme::embedding::DeltaMinus) over the other half: the Störmer-Verlet scheme,
/// symmetric and of order two. For `T(p) + V(q, t)` it is explicit: kick, drift, kick, with one evaluation of
/// the force for each step. For any other Hamiltonian it is the generalised Störmer-Verlet scheme. Each half
/// takes half of the increments, which makes it consistent with every Stratonovich system.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Verlet;

/// Steps of `E` with the weights of `W`, one after the other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Composed<E, W>(PhantomData<(E, W)>);

/// Weights of a composition of steps of a symmetric scheme of order two.
///
/// The build checks that the weights are a palindrome with sum 1, and that the sums of their odd powers
/// vanish as the order requires. With `const _: () = check_weights::<Own>();` ([`check_weights`]),
/// `cargo check` does so, too. The other order conditions are not checked. See docs/guide/cookbook-parts.md
/// for an example.
#[diagnostic::on_unimplemented(
    message = "`{Self}` cannot compose this scheme",
    label = "not for this scheme",
    note = "partitioned tables (`BlanesMoan4`, ..., `Table` of your own) compose `Verlet` only; palindromes (`Yoshida4`, ..., your own `Weights`) compose `Midpoint`, `Verlet`, `Gauss<S>` and, with constraints, `Rattle`"
)]
pub trait Weights {
    /// The order of the composition.
    const ORDER: u32;
    /// All weights, in order.
    const GAMMA: &'static [f64];
}

/// Coefficients of a splitting into alternating drifts, the flow of `T(p)`, and kicks, the flow of `V(q)`.
/// For a table of your own, write `Composed<Verlet, `[`Table`]`<Own>>`.
///
/// The build checks that the coefficients are a palindrome, and that those of drifts and those of kicks each
/// sum to 1.
pub trait Partitioned {
    /// The order.
    const ORDER: u32;
    /// Whether the first one is a drift.
    const STARTS_WITH_DRIFT: bool;
    /// The coefficients of drifts and kicks in turn, a palindrome; those of each kind sum to 1.
    const SEQUENCE: &'static [f64];
}

/// The weights of a composition of [`Verlet`] by a table of your own: `Composed<Verlet, Table<MyTable>>`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Table<W>(PhantomData<W>);

/// Symmetric schemes, whose step backwards undoes the step forwards, and how they take the steps of a system
/// with the structure `K`. [`Weights`] compose these.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not symmetric, and its compositions have no higher order",
    note = "`Midpoint`, `Verlet`, `Gauss<S>` and, with constraints, `Rattle` are"
)]
pub trait Symmetric<K = General>: Sized {
    /// The scheme itself, or the scheme of its first half.
    type Basic;
    /// The scheme itself, or the adjoint of the basic scheme, which is that of its second half.
    type Adjoint;
    /// The kinds of parts in the words of its steps.
    type Part: PartKind;
    /// The scheme that takes the words `W`.
    type Steps<W>;
    /// The parts of a step.
    const STEP: &'static [Weighted<Self::Part>];
}

/// Weights that can compose `E` for a system of the structure `K`.
#[diagnostic::on_unimplemented(
    message = "`{Self}` cannot compose `{E}` for this system",
    label = "not for this system",
    note = "partitioned tables (`BlanesMoan4`, ..., `Table` of your own) compose `Verlet` only; palindromes (`Yoshida4`, ..., your own `Weights`) compose `Midpoint`, `Verlet`, `Gauss<S>` and, with constraints, `Rattle`",
    note = "`Srkn6`, `Chin4` and `TakahashiImada4` take `T(p) + V(q, t)` with constant masses, a kinetic energy that is quadratic, and neither friction \
            nor a force that depends on momenta: `BlanesMoan4`, `BlanesMoan6` and `KahanLi6` compose `Verlet` for every Hamiltonian, with friction and \
            forces, too",
    note = "`Aba864` and `Aba1064` take two parts with exact flows: `T(p) + V(q, t)`, or `drift = [H_A, H_B]`, without friction"
)]
pub trait Composes<E, K = General> {
    /// The order of the composition.
    const ORDER: u32;
    /// The description in `EQUATIONS`.
    const LISTING: Listing;
    /// The kinds of parts in the words.
    type Part: PartKind;
    /// The scheme that takes the steps.
    type Steps;
    /// The parts of a step, in order.
    fn word() -> Word<Self::Part>;
}

/// The word of a step that composes steps of `E` by `W`, for a system of the structure `K`, as a type:
/// [`Composes::word`] has its parts.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct ComposedWord<E, K, W>(PhantomData<(E, K, W)>);

impl<E: Symmetric<K>, W: Weights, K> Composes<E, K> for W {
    const ORDER: u32 = W::ORDER;
    const LISTING: Listing = Listing::Steps(W::GAMMA);
    type Part = E::Part;
    type Steps = E::Steps<ComposedWord<E, K, W>>;

    fn word() -> Word<E::Part> {
        const { check_weights::<W>() };
        Word::composed(E::STEP, W::GAMMA)
    }
}

/// The drifts and kicks of a partitioned table.
fn drifts_and_kicks<W: Partitioned>() -> Vec<Weighted> {
    const { check_table::<W>() };
    let turns = if W::STARTS_WITH_DRIFT { [Part::A, Part::B] } else { [Part::B, Part::A] };
    let sequence = W::SEQUENCE.iter().zip(turns.into_iter().cycle());
    sequence.map(|(&weight, part)| Weighted { part, weight }).collect()
}

/// The drifts and kicks of a table; kicks with a factor `c` that is not zero are by `b V - c h³ |V'|²`.
fn with_squares<W: Partitioned>(factors: &[f64]) -> Vec<Weighted> {
    let mut table = drifts_and_kicks::<W>();
    for (Weighted { part, .. }, &factor) in table.iter_mut().zip(factors) {
        if *part == Part::B && factor != 0.0 {
            *part = Part::GradientB(factor);
        }
    }
    table
}

/// The kinds of parts in words of steps of `Verlet`.
type PartOf<K> = <Verlet as Symmetric<K>>::Part;

/// Drifts and kicks in turn, as steps of `Verlet` take them.
type InTurn<K, W> = <Verlet as Symmetric<K>>::Steps<ComposedWord<Verlet, K, W>>;

/// Drifts and kicks in turn, some kicks with the square of the force.
type WithSquares<K, W> = KickDrift<ComposedWord<Verlet, K, W>, true>;

/// Tables for the structures `K`: the kinds of parts, the scheme that takes the steps, the names of the two
/// flows and a note on them, and the factors of squares of forces if there are any.
macro_rules! for_structures {
    ($([$($generic:tt)*] $table:ty = $weights:ty: $part:ty, $steps:ty, $names:expr, $note:expr $(, $squares:expr)?;)+) => {$(
        #[diagnostic::do_not_recommend]
        impl<$($generic)*> Composes<Verlet, K> for $table
        where
            Verlet: Symmetric<K>,
        {
            const ORDER: u32 = <$weights as Partitioned>::ORDER;
            const LISTING: Listing = turns::<$weights>($names, $note);
            type Part = $part;
            type Steps = $steps;

            fn word() -> Word<$part> {
                <$part>::of_table(&for_structures!(@table $weights $(, $squares)?))
            }
        }
    )+};
    (@table $weights:ty) => { drifts_and_kicks::<$weights>() };
    (@table $weights:ty, $squares:expr) => {{
        const { assert!($squares.len() == Self::SEQUENCE.len(), "squares have one factor for each drift and kick") };
        with_squares::<$weights>($squares)
    }};
}

for_structures! {
    [K, W: Partitioned] Table<W> = W: PartOf<K>, InTurn<K, Self>, DRIFT_KICK, PartOf::<K>::NOTE;
    [K] BlanesMoan4 = Self: PartOf<K>, InTurn<K, Self>, DRIFT_KICK, PartOf::<K>::NOTE;
    [K] BlanesMoan6 = Self: PartOf<K>, InTurn<K, Self>, DRIFT_KICK, PartOf::<K>::NOTE;
    [K: QuadraticKinetic] Srkn6 = Self: Part, KickDrift<ComposedWord<Verlet, K, Self>>, DRIFT_KICK, "";
    [K: QuadraticKinetic] Chin4 = Self: Part, WithSquares<K, Self>, DRIFT_KICK, Self::NOTE, Self::GRADIENT;
    [K: QuadraticKinetic] TakahashiImada4 = Self: Part, WithSquares<K, Self>, DRIFT_KICK, Self::NOTE, Self::GRADIENT;
    [K: TwoFlows] Aba864 = Self: K::Part, K::Flows<ComposedWord<Verlet, K, Self>>, K::PARTS, "";
    [K: TwoFlows] Aba1064 = Self: K::Part, K::Flows<ComposedWord<Verlet, K, Self>>, K::PARTS, "";
}
