//! The structures of Hamiltonians that the compiler proves, and the parts of compositions for each.

use std::marker::PhantomData;

use super::flows::KickDrift;
use super::pair::Pair;
use super::substeps::{Half, Once, Substep};
use super::text::{DRIFT_KICK, Equations};
use super::{Composed, Composes, Symmetric, Verlet};
use crate::scheme::elements::Elements;
use crate::scheme::system::{Discretized, Scheme};

/// The structure of a system, as far as steps of `E` exploit it.
pub trait Structure<E> {
    /// The scheme that takes the parts `W` of a step.
    type Steps<W>;
    /// Text for users: the steps by which a splitting is taken.
    const NOTE: &'static str;
    /// Appends the parts of a step of `E` with this weight.
    fn step(weight: f64, into: &mut Vec<Substep>);
    /// The parts for a sequence of alternating drifts (`Half::First`) and kicks (`Half::Second`).
    fn splitting(sequence: &[Substep]) -> Vec<Substep>;
}

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
    E: Symmetric,
    H: Elements + Discretized<E>,
    W: Composes<E, E::Structure<H>, Steps: Scheme<H>>,
{
    type Scheme = W::Steps;
    type Prepared = <W::Steps as Scheme<H>>::Prepared<f64>;
    const EQUATIONS: &'static str = Equations::<H, E, W>::ALL;
}

/// The scheme that takes single steps of `E`.
pub type WholeOf<H, E> = <Once as Composes<E, <E as Symmetric>::Structure<H>>>::Steps;

/// Structures with a kinetic energy that is a quadratic form with constant coefficients.
pub trait QuadraticKinetic {}

impl QuadraticKinetic for Nystrom {}
impl QuadraticKinetic for Parted<Nystrom> {}

/// Structures of two parts whose flows are known.
pub trait TwoFlows: Structure<Verlet> {
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

impl<E: Symmetric> Structure<E> for General {
    type Steps<W> = Pair<E::First, E::Second, W>;
    const NOTE: &'static str = ", by steps of DeltaMinus (drift) and DeltaPlus (kick) of which each is \
                                a coefficient less the one before";

    fn step(weight: f64, into: &mut Vec<Substep>) {
        E::substeps(weight, into);
    }

    /// Alternating steps of the adjoint pair, with the weights `z_1 = x_1`, `z_{i+1} = x_{i+1} - z_i` for the coefficients `x` without the
    /// last one. A drift comes first in `DeltaMinus`, a kick in `DeltaPlus`.
    fn splitting(sequence: &[Substep]) -> Vec<Substep> {
        let mut rest = 0.0;
        let coefficients = sequence.split_last().map_or(&[][..], |(_, coefficients)| coefficients);
        let steps = coefficients.iter().map(|&(part, coefficient)| {
            rest = coefficient - rest;
            let half = if part == Half::First { Half::Second } else { Half::First };
            (half, rest)
        });
        steps.collect()
    }
}

impl<K: Structure<Verlet>> Structure<Verlet> for Parted<K> {
    type Steps<W> = K::Steps<W>;
    const NOTE: &'static str = K::NOTE;

    fn step(weight: f64, into: &mut Vec<Substep>) {
        K::step(weight, into);
    }

    fn splitting(sequence: &[Substep]) -> Vec<Substep> {
        K::splitting(sequence)
    }
}

macro_rules! by_flows {
    ($($structure:ty),+) => {$(
        impl Structure<Verlet> for $structure {
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
