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
//! * [`PartFlows`]: the flows of two parts, for `drift = [H_A, H_B]` with the tables for two parts.

mod checks;
pub(crate) mod flows;
mod gradient;
mod lagrangian;
mod linear;
pub(crate) mod memory;
mod pair;
mod parts;
pub(crate) mod stages;
mod structure;
pub(crate) mod substeps;
mod tables;
mod text;
pub(crate) mod tiled;

use std::marker::PhantomData;

use text::{DRIFT_KICK, turns};

pub use checks::{check_table, check_weights};
#[doc(hidden)]
pub use flows::KickDrift;
#[doc(hidden)]
pub use pair::PairComposition;
#[doc(hidden)]
pub use parts::{Form, PartFlows};
#[doc(hidden)]
pub use structure::{General, Nystrom, Parted, QuadraticKinetic, Separable, TwoFlows, WholeOf};
#[doc(hidden)]
pub use substeps::{Half, SingleStep, Substep, Substeps};
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
    note = "partitioned tables (`BlanesMoan4`, ..., `Table` of your own) compose `Verlet` only; palindromes (`Yoshida4`, ..., your own `Weights`) compose `Midpoint`, `Verlet` and `Gauss<S>`"
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
    note = "`Midpoint`, `Verlet` and `Gauss<S>` are"
)]
pub trait Symmetric<K = General>: Sized {
    /// The scheme itself, or the first half of it.
    type First;
    /// The scheme itself, or the second half of it.
    type Second;
    /// The scheme that takes the parts `W` of a step.
    type Steps<W>;
    /// Text for users: the steps by which a splitting is taken.
    const NOTE: &'static str = structure::BY_PAIRS;
    /// Appends the parts of a step with this weight.
    fn step(weight: f64, into: &mut Vec<Substep>);
    /// The parts for a sequence of alternating drifts (`Half::First`) and kicks.
    fn splitting(sequence: &[Substep]) -> Vec<Substep> {
        structure::in_pairs(sequence)
    }
}

/// Weights that can compose `E` for a system of the structure `K`.
#[diagnostic::on_unimplemented(
    message = "`{Self}` cannot compose `{E}` for this system",
    label = "not for this system",
    note = "partitioned tables (`BlanesMoan4`, ..., `Table` of your own) compose `Verlet` only; palindromes (`Yoshida4`, ..., your own `Weights`) compose `Midpoint`, `Verlet` and `Gauss<S>`",
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
    /// The factors `c` of `h³ |V'|²`, one for each drift (zero) and kick, in the metric of the inverse
    /// masses; empty if kicks are by the potential alone.
    const GRADIENT: &'static [f64] = &[];
    /// The scheme that takes the steps.
    type Steps;
    /// The parts of a step, in order.
    fn substeps() -> Vec<Substep>;
}

impl<E: Symmetric<K>, W: Weights, K> Composes<E, K> for W {
    const ORDER: u32 = W::ORDER;
    const LISTING: Listing = Listing::Steps(W::GAMMA);
    type Steps = E::Steps<Substeps<E, K, W>>;

    fn substeps() -> Vec<Substep> {
        const { check_weights::<W>() };
        let mut substeps = Vec::new();
        W::GAMMA.iter().for_each(|&weight| E::step(weight, &mut substeps));
        substeps
    }
}

/// The drifts and kicks of a partitioned table.
fn of_table<W: Partitioned>() -> Vec<Substep> {
    const { check_table::<W>() };
    let halves = if W::STARTS_WITH_DRIFT { [Half::First, Half::Second] } else { [Half::Second, Half::First] };
    let sequence = W::SEQUENCE.iter().zip(halves.into_iter().cycle());
    sequence.map(|(&weight, half)| (half, weight)).collect()
}

/// Drifts and kicks in turn, as steps of `Verlet` take them.
type InTurn<K, W> = <Verlet as Symmetric<K>>::Steps<Substeps<Verlet, K, W>>;

/// Tables for the structures `K`: the scheme that takes the steps, the names of the two flows and a note on
/// them, and the parts of a step for the drifts and kicks of a table.
macro_rules! for_structures {
    ($([$($generic:tt)*] $table:ty = $weights:ty: $steps:ty, $names:expr, $note:expr, $splitting:expr $(, $gradient:expr)?;)+) => {$(
        #[diagnostic::do_not_recommend]
        impl<$($generic)*> Composes<Verlet, K> for $table
        where
            Verlet: Symmetric<K>,
        {
            const ORDER: u32 = <$weights as Partitioned>::ORDER;
            const LISTING: Listing = turns::<$weights>($names, $note);
            $(const GRADIENT: &'static [f64] = {
                assert!($gradient.len() == Self::SEQUENCE.len(), "a gradient has one factor for each drift and kick");
                $gradient
            };)?
            type Steps = $steps;

            fn substeps() -> Vec<Substep> {
                $splitting(&of_table::<$weights>())
            }
        }
    )+};
}

for_structures! {
    [K, W: Partitioned] Table<W> = W: InTurn<K, Self>, DRIFT_KICK, <Verlet as Symmetric<K>>::NOTE, <Verlet as Symmetric<K>>::splitting;
    [K] BlanesMoan4 = Self: InTurn<K, Self>, DRIFT_KICK, <Verlet as Symmetric<K>>::NOTE, <Verlet as Symmetric<K>>::splitting;
    [K] BlanesMoan6 = Self: InTurn<K, Self>, DRIFT_KICK, <Verlet as Symmetric<K>>::NOTE, <Verlet as Symmetric<K>>::splitting;
    [K: QuadraticKinetic] Srkn6 = Self: InTurn<K, Self>, DRIFT_KICK, "", <[Substep]>::to_vec;
    [K: QuadraticKinetic] Chin4 = Self: KickDrift<Substeps<Verlet, K, Self>, true>, DRIFT_KICK, Self::NOTE, <[Substep]>::to_vec, Self::GRADIENT;
    [K: QuadraticKinetic] TakahashiImada4 = Self: KickDrift<Substeps<Verlet, K, Self>, true>, DRIFT_KICK, Self::NOTE, <[Substep]>::to_vec, Self::GRADIENT;
    [K: TwoFlows] Aba864 = Self: K::Flows<Substeps<Verlet, K, Self>>, K::PARTS, "", <[Substep]>::to_vec;
    [K: TwoFlows] Aba1064 = Self: K::Flows<Substeps<Verlet, K, Self>>, K::PARTS, "", <[Substep]>::to_vec;
}
