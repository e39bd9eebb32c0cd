//! The structures of Hamiltonians that the compiler proves, and the parts of compositions for each.

use std::marker::PhantomData;

use super::flows::KickDrift;
use super::pair::{BasicMethod, PairComposition};
use super::summands::{Summand, SummandSplitting};
use super::text::{DRIFT_KICK, EquationsText};
use super::{Composed, Composes, Symmetric, Verlet, Weights};
use crate::scheme::elements::Elements;
use crate::scheme::embedding::{DeltaMinus, DeltaPlus, Midpoint, Uncorrected};
use crate::scheme::gauss::Gauss;
use crate::scheme::system::{Discretized, Scheme};
use crate::scheme::word::{Part, PartKind, Weighted};

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

/// One step, as a composition.
#[derive(Clone, Copy, Debug)]
pub enum SingleStep {}

#[diagnostic::do_not_recommend]
impl Weights for SingleStep {
    const ORDER: u32 = 2;
    const GAMMA: &'static [f64] = &[1.0];
}

/// The scheme that takes single steps of `E`.
pub type WholeOf<H, E> = <SingleStep as Composes<E, <H as Elements>::Structure>>::Steps;

/// Structures with a kinetic energy that is a quadratic form with constant coefficients.
pub trait QuadraticKinetic {}

impl QuadraticKinetic for Nystrom {}
impl QuadraticKinetic for Parted<Nystrom> {}

/// Structures of two parts whose flows are known.
pub trait TwoFlows {
    /// The kinds of the two flows, as parts of words.
    type Part: PartKind;
    /// The scheme that takes the words `W`.
    type Flows<W>;
    /// Text for users: the first part, then the second.
    const PARTS: [&'static str; 2] = DRIFT_KICK;
}

impl TwoFlows for Separable {
    type Part = Part;
    type Flows<W> = KickDrift<W>;
}
impl TwoFlows for Nystrom {
    type Part = Part;
    type Flows<W> = KickDrift<W>;
}
impl<K> TwoFlows for Parted<K> {
    type Part = Summand;
    type Flows<W> = SummandSplitting<W>;
    const PARTS: [&'static str; 2] = ["flow of H_A over ", "flow of H_B over "];
}

/// One step of a symmetric scheme.
pub(crate) const WHOLE: &[Weighted<BasicMethod>] = &[Weighted { part: BasicMethod::Itself, weight: 1.0 }];

impl<K> Symmetric<K> for Midpoint {
    type Basic = Self;
    type Adjoint = Self;
    type Part = BasicMethod;
    type Steps<W> = PairComposition<Self, Self, W>;
    const STEP: &'static [Weighted<BasicMethod>] = WHOLE;
}

impl<K, const S: usize> Symmetric<K> for Gauss<S> {
    type Basic = Self;
    type Adjoint = Self;
    type Part = BasicMethod;
    type Steps<W> = PairComposition<Self, Self, W>;
    const STEP: &'static [Weighted<BasicMethod>] = WHOLE;
}

impl Symmetric for Verlet {
    type Basic = Uncorrected<DeltaPlus>;
    type Adjoint = Uncorrected<DeltaMinus>;
    type Part = BasicMethod;
    type Steps<W> = PairComposition<Uncorrected<DeltaPlus>, Uncorrected<DeltaMinus>, W>;
    const STEP: &'static [Weighted<BasicMethod>] = &[
        Weighted { part: BasicMethod::Itself, weight: 0.5 },
        Weighted { part: BasicMethod::Adjoint, weight: 0.5 },
    ];
}

impl<K> Symmetric<Parted<K>> for Verlet
where
    Self: Symmetric<K>,
{
    type Basic = <Self as Symmetric<K>>::Basic;
    type Adjoint = <Self as Symmetric<K>>::Adjoint;
    type Part = <Self as Symmetric<K>>::Part;
    type Steps<W> = <Self as Symmetric<K>>::Steps<W>;
    const STEP: &'static [Weighted<Self::Part>] = <Self as Symmetric<K>>::STEP;
}

macro_rules! by_flows {
    ($($structure:ty),+) => {$(
        impl Symmetric<$structure> for Verlet {
            type Basic = <Self as Symmetric>::Basic;
            type Adjoint = <Self as Symmetric>::Adjoint;
            type Part = Part;
            type Steps<W> = KickDrift<W>;
            /// Kick and drift in `DeltaPlus`, drift and kick in `DeltaMinus`.
            const STEP: &'static [Weighted] = &[
                Weighted { part: Part::B, weight: 0.5 },
                Weighted { part: Part::A, weight: 1.0 },
                Weighted { part: Part::B, weight: 0.5 },
            ];
        }
    )+};
}

by_flows!(Separable, Nystrom);
