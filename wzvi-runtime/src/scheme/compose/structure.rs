//! The structures of Hamiltonians that the compiler proves, and the parts of compositions for each.

use std::marker::PhantomData;

use super::flows::KickDrift;
use super::pair::PairComposition;
use super::parts::PartFlows;
use super::substeps::{Half, SingleStep, Substep};
use super::text::{DRIFT_KICK, EquationsText};
use super::{Composed, Composes, Symmetric, Verlet};
use crate::scheme::elements::Elements;
use crate::scheme::embedding::{DeltaMinus, DeltaPlus, Midpoint, Uncorrected};
use crate::scheme::gauss::Gauss;
use crate::scheme::system::{Discretized, Scheme};

/// Any Hamiltonian.
#[derive(Clone, Copy, Debug)]
pub struct General;

/// `T(p) + V(q, t)`
#[derive(Clone, Copy, Debug)]
pub struct Separable;

/// `T(p) + V(q, t)` where `T` is a quadratic form with constant coefficients.
#[derive(Clone, Copy, Debug)]
pub struct Nystrom;

/// `H_A + H_B` with known flows of both, as split by the user; the sum has the structure `K`.
#[derive(Clone, Copy, Debug)]
pub struct Parted<K>(PhantomData<K>);

impl<H, E, W> Discretized<Composed<E, W>> for H
where
    H: Elements + Discretized<E>,
    E: Symmetric<H::Structure>,
    W: Composes<E, H::Structure, Steps: Scheme<H>>,
{
    type Scheme = W::Steps;
    type Prepared = <W::Steps as Scheme<H>>::Prepared<f64>;
    const EQUATIONS: &'static str = EquationsText::<H, E, W>::ALL;
}

/// The scheme that takes single steps of `E`.
pub type WholeOf<H, E> = <SingleStep as Composes<E, <H as Elements>::Structure>>::Steps;

/// Structures with a kinetic energy that is a quadratic form with constant coefficients.
pub trait QuadraticKinetic {}

impl QuadraticKinetic for Nystrom {}
impl QuadraticKinetic for Parted<Nystrom> {}

/// Structures of two parts whose flows are known.
pub trait TwoFlows {
    /// The scheme that takes the flows of the parts `W`.
    type Flows<W>;
    /// Text for users: the first part, then the second.
    const PARTS: [&'static str; 2] = DRIFT_KICK;
}

impl TwoFlows for Separable {
    type Flows<W> = KickDrift<W>;
}
impl TwoFlows for Nystrom {
    type Flows<W> = KickDrift<W>;
}
impl<K> TwoFlows for Parted<K> {
    type Flows<W> = PartFlows<W>;
    const PARTS: [&'static str; 2] = ["flow of H_A over ", "flow of H_B over "];
}

/// The note of [`in_pairs`].
pub(super) const BY_PAIRS: &str = ", by steps of DeltaMinus (drift) and DeltaPlus (kick) of which each is a coefficient less the one before";

/// Drifts and kicks as alternating steps of the adjoint pair, with the weights `z_1 = x_1`,
/// `z_{i+1} = x_{i+1} - z_i` for the coefficients `x` without the last one. A drift comes first in
/// `DeltaMinus`, a kick in `DeltaPlus`.
pub(super) fn in_pairs(sequence: &[Substep]) -> Vec<Substep> {
    let mut rest = 0.0;
    let coefficients = sequence.split_last().map_or(&[][..], |(_, coefficients)| coefficients);
    let steps = coefficients.iter().map(|&(part, coefficient)| {
        rest = coefficient - rest;
        let half = if part == Half::First { Half::Second } else { Half::First };
        (half, rest)
    });
    steps.collect()
}

impl<K> Symmetric<K> for Midpoint {
    type First = Self;
    type Second = Self;
    type Steps<W> = PairComposition<Self, Self, W>;

    fn step(weight: f64, into: &mut Vec<Substep>) {
        into.push((Half::First, weight));
    }
}

impl<K, const S: usize> Symmetric<K> for Gauss<S> {
    type First = Self;
    type Second = Self;
    type Steps<W> = PairComposition<Self, Self, W>;

    fn step(weight: f64, into: &mut Vec<Substep>) {
        into.push((Half::First, weight));
    }
}

impl Symmetric for Verlet {
    type First = Uncorrected<DeltaPlus>;
    type Second = Uncorrected<DeltaMinus>;
    type Steps<W> = PairComposition<Uncorrected<DeltaPlus>, Uncorrected<DeltaMinus>, W>;

    fn step(weight: f64, into: &mut Vec<Substep>) {
        into.extend([(Half::First, 0.5 * weight), (Half::Second, 0.5 * weight)]);
    }
}

impl<K> Symmetric<Parted<K>> for Verlet
where
    Self: Symmetric<K>,
{
    type First = <Self as Symmetric<K>>::First;
    type Second = <Self as Symmetric<K>>::Second;
    type Steps<W> = <Self as Symmetric<K>>::Steps<W>;
    const NOTE: &'static str = <Self as Symmetric<K>>::NOTE;

    fn step(weight: f64, into: &mut Vec<Substep>) {
        <Self as Symmetric<K>>::step(weight, into);
    }

    fn splitting(sequence: &[Substep]) -> Vec<Substep> {
        <Self as Symmetric<K>>::splitting(sequence)
    }
}

macro_rules! by_flows {
    ($($structure:ty),+) => {$(
        impl Symmetric<$structure> for Verlet {
            type First = <Self as Symmetric>::First;
            type Second = <Self as Symmetric>::Second;
            type Steps<W> = KickDrift<W>;
            const NOTE: &'static str = "";

            /// Kick and drift in `DeltaPlus`, drift and kick in `DeltaMinus`.
            fn step(weight: f64, into: &mut Vec<Substep>) {
                let kick = (Half::Second, 0.5 * weight);
                into.extend([kick, (Half::First, weight), kick]);
            }

            fn splitting(sequence: &[Substep]) -> Vec<Substep> {
                sequence.to_vec()
            }
        }
    )+};
}

by_flows!(Separable, Nystrom);
