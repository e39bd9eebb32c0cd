//! Schemes that are made of others: [`Verlet`] and [`Composed`].
//!
//! A step of size `h` with increments `ΔW` is the flow of the step Hamiltonian `F = h H_0 + Σ_k ΔW_k H_k`, which is frozen
//! over it. A composition takes steps of `γ_1 F, γ_2 F, ...` one after the other: steps of size `γ_j h` with increments
//! `γ_j ΔW`, at the times `t + (γ_1 + ... + γ_{j-1}) h`. It is symplectic as its parts are, and of the order that the weights
//! give it without noise (E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*, sections II.4, V.3).
//!
//! Two kinds of weights: a palindrome of weights for any [symmetric](Symmetric) scheme of order two ([`Weights`]), and the
//! coefficients of a splitting in drifts and kicks ([`Partitioned`]), which also serve Hamiltonians that do not split, by
//! the adjoint pair of [`Verlet`] (R. I. McLachlan, "On the numerical integration of ordinary differential equations by symmetric
//! composition methods", SIAM J. Sci. Comput. 16, 1995).

mod advance;
mod implement;
mod kept;
mod lagrangian;
mod tables;

use std::marker::PhantomData;

use crate::embedding::{DeltaMinus, DeltaPlus, Midpoint, Uncorrected};
use crate::gauss::Gauss;
use crate::plan::{Plan, Solver};

#[doc(hidden)]
pub use advance::{Prepared, advance, memory, prepare};
#[doc(hidden)]
pub use kept::Memory;
#[doc(hidden)]
pub use lagrangian::{gradient, value};
pub use tables::{BlanesMoan4, BlanesMoan6, KahanLi6, KahanLi8, Suzuki4, SuzukiUmeno8, Yoshida4, Yoshida6};

/// [`DeltaPlus`] of half the step, then [`DeltaMinus`] of the other half: the Störmer-Verlet scheme, symmetric and of order
/// two. Explicit for `T(p) + V(q)`, generalised Störmer-Verlet for any other Hamiltonian. Half of the increments
/// goes into each half, which makes it consistent with every Stratonovich system.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Verlet;

/// Steps of `E` with the weights of `W`, one after the other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Composed<E, W>(PhantomData<(E, W)>);

/// Weights of a composition of steps of a symmetric scheme of order two.
///
/// That they are a palindrome and their sum is 1 is checked when the program is compiled, and so is that the sums of their
/// odd powers vanish which the order needs. The other conditions of the order are a matter of trust. docs/order.md has an example.
pub trait Weights {
    /// The order of the composition.
    const ORDER: u32;
    /// All weights, in their order.
    const GAMMA: &'static [f64];
}

/// Coefficients of a splitting in drifts, the flow of `T(p)`, and kicks, the flow of `V(q)`, which take turns.
pub trait Partitioned {
    /// The order.
    const ORDER: u32;
    /// Whether the first one is a drift.
    const STARTS_WITH_DRIFT: bool;
    /// The coefficients of drifts and kicks in turn, a palindrome; those of each kind sum to 1.
    const SEQUENCE: &'static [f64];
}

/// Schemes whose step backwards undoes the step forwards: what [`Weights`] compose.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not symmetric, and its compositions have no higher order",
    note = "`Midpoint`, `Verlet` and `Gauss<S>` are"
)]
pub trait Symmetric {}

impl Symmetric for Midpoint {}
impl Symmetric for Verlet {}
impl<const S: usize> Symmetric for Gauss<S> {}

/// Which of the two schemes a part of a step is taken by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Half {
    /// [`Base::First`]
    First,
    /// [`Base::Second`]
    Second,
}

/// A part of a step: by which scheme, and what fraction of the step.
pub type Substep = (Half, f64);

/// The schemes that a composition of `Self` is made of.
pub trait Base {
    /// The scheme itself, or the first half of it.
    type First;
    /// The scheme itself, or the second half of it.
    type Second;
    /// What a step with this weight is made of.
    fn substeps(weight: f64, into: &mut Vec<Substep>);
}

impl Base for Midpoint {
    type First = Self;
    type Second = Self;
    fn substeps(weight: f64, into: &mut Vec<Substep>) {
        into.push((Half::First, weight));
    }
}

impl<const S: usize> Base for Gauss<S> {
    type First = Self;
    type Second = Self;
    fn substeps(weight: f64, into: &mut Vec<Substep>) {
        into.push((Half::First, weight));
    }
}

impl Base for Verlet {
    type First = Uncorrected<DeltaPlus>;
    type Second = Uncorrected<DeltaMinus>;
    fn substeps(weight: f64, into: &mut Vec<Substep>) {
        into.extend([(Half::First, 0.5 * weight), (Half::Second, 0.5 * weight)]);
    }
}

/// Weights that can compose `E`.
#[diagnostic::on_unimplemented(
    message = "`{Self}` cannot compose `{E}`",
    label = "not for `{E}`",
    note = "partitioned tables (`BlanesMoan4`, ...) compose `Verlet` only; palindromes (`Yoshida4`, ..., your own `Weights`) compose `Midpoint`, `Verlet` and `Gauss<S>`"
)]
pub trait Composes<E> {
    /// The order that they give.
    const ORDER: u32;
    /// The parts of a step, in their order.
    fn substeps() -> Vec<Substep>;
}

impl<E: Symmetric + Base, W: Weights> Composes<E> for W {
    const ORDER: u32 = W::ORDER;

    fn substeps() -> Vec<Substep> {
        const {
            assert!(is_palindrome(W::GAMMA), "the weights of a composition must be a palindrome");
            assert!(has_sum_one(W::GAMMA), "the weights of a composition must sum to 1");
            assert!(
                has_order(W::GAMMA, W::ORDER),
                "the sums of the odd powers of the weights below their order must vanish"
            );
        }
        let mut substeps = Vec::new();
        W::GAMMA.iter().for_each(|&weight| E::substeps(weight, &mut substeps));
        substeps
    }
}

/// `z_1 = x_1`, `z_{i+1} = x_{i+1} - z_i` for the coefficients `x`, without the last: steps of the pair in turn. A drift comes
/// first in [`DeltaMinus`], a kick in [`DeltaPlus`].
fn pair<W: Partitioned>() -> Vec<Substep> {
    const {
        assert!(is_palindrome(W::SEQUENCE), "the coefficients of a splitting must be a palindrome");
        assert!(W::SEQUENCE.len() % 2 == 1, "a splitting starts and ends with the same part");
    }
    let halves = if W::STARTS_WITH_DRIFT { [Half::Second, Half::First] } else { [Half::First, Half::Second] };
    let mut rest = 0.0;
    let coefficients = W::SEQUENCE.split_last().map_or(&[][..], |(_, coefficients)| coefficients);
    let steps = coefficients.iter().zip(halves.iter().cycle()).map(|(x, &half)| {
        rest = x - rest;
        (half, rest)
    });
    steps.collect()
}

macro_rules! partitioned {
    ($($table:ty),+) => {$(
        impl Composes<Verlet> for $table {
            const ORDER: u32 = <$table as Partitioned>::ORDER;
            fn substeps() -> Vec<Substep> {
                pair::<$table>()
            }
        }
    )+};
}

partitioned!(BlanesMoan4, BlanesMoan6);

/// Whether a list reads the same backwards, to the last bit.
const fn is_palindrome(list: &[f64]) -> bool {
    let mut i = 0;
    while i < list.len() {
        if list[i].to_bits() != list[list.len() - 1 - i].to_bits() {
            return false;
        }
        i += 1;
    }
    !list.is_empty()
}

/// `Σ γ^power` and `Σ |γ|^power`.
const fn power_sums(list: &[f64], power: u32) -> (f64, f64) {
    let (mut sum, mut size) = (0.0, 0.0);
    let mut i = 0;
    while i < list.len() {
        let mut term = 1.0;
        let mut k = 0;
        while k < power {
            term *= list[i];
            k += 1;
        }
        sum += term;
        size += if term < 0.0 { -term } else { term };
        i += 1;
    }
    (sum, size)
}

/// What rounding of `length` weights, of their powers and of their sum can make, per unit of their sizes.
const fn rounding(length: usize, power: u32) -> f64 {
    (length as f64 + 2.0 * power as f64) * f64::EPSILON
}

const fn has_sum_one(list: &[f64]) -> bool {
    let (sum, size) = power_sums(list, 1);
    let error = if sum < 1.0 { 1.0 - sum } else { sum - 1.0 };
    error <= rounding(list.len(), 1) * size
}

/// `Σ γ^3 = 0` for order 4, `Σ γ^5 = 0` as well for order 6, and so on.
const fn has_order(list: &[f64], order: u32) -> bool {
    let mut power = 3;
    while power < order {
        let (sum, size) = power_sums(list, power);
        let error = if sum < 0.0 { -sum } else { sum };
        if error > rounding(list.len(), power) * size {
            return false;
        }
        power += 2;
    }
    order >= 1
}

/// The plan of steps that are made of those of two plans, one after the other: symmetric, and therefore consistent.
pub const fn plan(first: Plan, second: Plan, order: u32) -> Plan {
    let hardest = match (first.solver, second.solver) {
        (Solver::Newton, _) | (_, Solver::Newton) => Solver::Newton,
        (Solver::Linear, _) | (_, Solver::Linear) => Solver::Linear,
        _ => Solver::Explicit,
    };
    let unknowns = if first.unknowns > second.unknowns { first.unknowns } else { second.unknowns };
    let order = if order > first.order { order } else { first.order };
    Plan { solver: hardest, unknowns, order, consistent: true, ..first }
}

/// The parts of one step of `E`.
pub fn of_one<E: Base>() -> Vec<Substep> {
    let mut substeps = Vec::new();
    E::substeps(1.0, &mut substeps);
    substeps
}
