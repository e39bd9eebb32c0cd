//! The Hamiltonian whose flow the steps follow: backward error analysis.
//!
//! A symplectic step of size `h` of a system without noise and explicit time is, up to terms that are
//! exponentially small in `1/h`, the flow of a modified Hamiltonian (E. Hairer, C. Lubich, G. Wanner,
//! *Geometric Numerical Integration*, chapter IX)
//!
//! ```text
//! H~ = H + h H_2 + h² H_3 + h³ H_4 + h⁴ H_5 + ...
//! ```
//!
//! Steps conserve `H~` nearly exactly, and `H` only to their order. With one quadrature point `l`,
//!
//! ```text
//! H_2 = -(1/2 - l) H_p · H_q
//! H_3 = (1/12 - l (1 - l)/2) (H_pp(H_q, H_q) + H_qq(H_p, H_p)) + (1/3 - l (1 - l)) H_pq(H_q, H_p)
//! ```
//!
//! For [`Verlet`] `H_2 = 0` and `H_3 = H_qq(H_p, H_p)/12 - H_pp(H_q, H_q)/24 + H_pq(H_q, H_p)/12`. Every term
//! is a combination of contractions of derivatives of `H`, which are trees. Poisson brackets combine them
//! (`modified/series.rs`), which gives the terms of compositions as well.

mod contraction;
mod series;
mod tree;

use std::fmt;
use std::marker::PhantomData;

use crate::algebra::scalar::Scalar;
use crate::algebra::state::State;
use crate::scheme::compose::{BasicMethod, Composed, Composes, Symmetric, Verlet};
use crate::scheme::embedding::{Corrected, DeltaMinus, DeltaPlus, Lambda, Midpoint, Mixed, Uncorrected};
use crate::scheme::gauss::Gauss;
use crate::scheme::system::{Discretized, Hamiltonian};
use contraction::Contractions;
use series::{HIGHEST_ORDER, TreeSeries, modified};

/// Systems without noise whose Hamiltonian does not read the time: their symplectic steps conserve a modified
/// energy.
#[diagnostic::on_unimplemented(
    message = "steps of `{Self}` conserve no modified energy",
    label = "`{Self}` has noise, constraints, or a Hamiltonian that reads the time",
    note = "without noise and explicit time every symplectic step follows a modified Hamiltonian; with them there is none, and that \
            of steps on the manifold of constraints is not computed"
)]
pub trait Conservative: Hamiltonian {}

/// Schemes with known first terms of the modified Hamiltonian.
#[diagnostic::on_unimplemented(
    message = "no modified energy is known for steps by `{Self}`",
    note = "it is of `DeltaPlus`, `Midpoint`, `DeltaMinus`, `Lambda<N, D>`, `Verlet`, and compositions of `Midpoint` and `Verlet` of order up to 6"
)]
pub trait ModifiedBy {
    /// The order of the scheme.
    const ORDER: u32;
    /// Quadrature point and fraction of the step, for each part of a step.
    fn parts() -> Vec<(f64, f64)>;
}

/// Implements [`ModifiedBy`] for schemes of one quadrature point `l`, from 0 to 1.
macro_rules! of_one_point {
    ($($scheme:ty $([$($number:ident)+])?: $l:expr;)+) => {$(
        #[diagnostic::do_not_recommend]
        impl$(<$(const $number: u32),+>)? ModifiedBy for $scheme {
            const ORDER: u32 = if $l == 0.5 { 2 } else { 1 };
            fn parts() -> Vec<(f64, f64)> {
                vec![($l, 1.0)]
            }
        }
    )+};
}

of_one_point! {
    DeltaPlus: 0.0;
    Midpoint: 0.5;
    DeltaMinus: 1.0;
    Lambda<N, D> [N D]: N as f64 / D as f64;
    Gauss<1>: 0.5;
}

/// Implements [`ModifiedBy`] as for `E`, where only the embedding of the noise differs.
macro_rules! as_without_noise {
    ($($scheme:ty $([$noise:ident])?;)+) => {$(
        #[diagnostic::do_not_recommend]
        impl<E: ModifiedBy $(, $noise)?> ModifiedBy for $scheme {
            const ORDER: u32 = E::ORDER;
            fn parts() -> Vec<(f64, f64)> {
                E::parts()
            }
        }
    )+};
}

as_without_noise! {
    Mixed<E, Noise> [Noise];
    Corrected<E>;
    Uncorrected<E>;
}

#[diagnostic::do_not_recommend]
impl ModifiedBy for Verlet {
    const ORDER: u32 = 2;
    fn parts() -> Vec<(f64, f64)> {
        vec![(0.0, 0.5), (1.0, 0.5)]
    }
}

#[diagnostic::do_not_recommend]
impl<E, W> ModifiedBy for Composed<E, W>
where
    E: Symmetric<Basic: ModifiedBy, Adjoint: ModifiedBy>,
    W: Composes<E, Part = BasicMethod>,
{
    const ORDER: u32 = W::ORDER;
    fn parts() -> Vec<(f64, f64)> {
        let [basic, adjoint] = [E::Basic::parts(), E::Adjoint::parts()];
        let parts = W::word().substeps.into_iter().flat_map(|substep| {
            let of_step = if substep.part == BasicMethod::Itself { &basic } else { &adjoint };
            of_step.iter().map(move |&(l, share)| (l, share * substep.weight)).collect::<Vec<_>>()
        });
        parts.collect()
    }
}

/// The Hamiltonian that steps of size `h` by the scheme `E` follow, to its first terms.
///
/// ```text
/// H~ = H + h^r H_(r+1)          r = 2 for schemes of order 2, r for compositions of order r; for order 1 r = 2 and also h H_2
/// ```
///
/// Its error is `O(h³)` for schemes of order 1, `O(h⁴)` for those of order 2, and `O(h⁶)` and `O(h⁸)` for
/// compositions of order 4 and 6. It varies over a run by at least that.
#[derive(Clone)]
pub struct ModifiedHamiltonian<E> {
    series: TreeSeries,
    scheme: PhantomData<fn() -> E>,
}

impl<E> fmt::Debug for ModifiedHamiltonian<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ModifiedHamiltonian").finish_non_exhaustive()
    }
}

impl<E: ModifiedBy> ModifiedHamiltonian<E> {
    /// For steps of size `h`, in the time units of the Hamiltonian.
    pub fn new(h: f64) -> Self {
        const {
            assert!(
                E::ORDER <= HIGHEST_ORDER,
                "the modified energy is known for compositions of order up to 6: take one of them, or the scheme that is composed"
            );
        }
        let order = E::ORDER as usize;
        // Terms below the order vanish, and for symmetric schemes every other one.
        let sizes = order + 1..=order.next_multiple_of(2) + 1;
        let mut series = modified(&E::parts(), E::ORDER);
        let terms = series.terms().map(|(coefficient, &(_, size))| {
            if sizes.contains(&size) { coefficient * Scalar::powi(h, size as i32 - 1) } else { 0.0 }
        });
        series.coefficients = terms.collect();
        Self { series, scheme: PhantomData }
    }

    /// The modified energy of a state, in units of energy; NaN where the energy is. Costs a few gradients
    /// with derivatives.
    pub fn energy<H>(&self, system: &H, state: &State<H::Vector>) -> f64
    where
        H: Discretized<E> + Conservative,
    {
        let energy = system.energy(state);
        if !energy.is_finite() {
            return f64::NAN;
        }
        // Higher derivatives are compiled only for schemes that need them.
        if const { E::ORDER > 4 } {
            energy + self.terms(Contractions::<H, 5>::at(system, state))
        } else if const { E::ORDER > 2 } {
            energy + self.terms(Contractions::<H, 3>::at(system, state))
        } else {
            energy + self.terms(Contractions::<H, 1>::at(system, state))
        }
    }

    /// The sum of the terms beyond `H`.
    fn terms<H: Hamiltonian, const DEPTH: usize>(&self, mut contractions: Contractions<'_, H, DEPTH>) -> f64 {
        let terms = self.series.terms().filter(|(coefficient, _)| *coefficient != 0.0);
        terms.map(|(coefficient, (tree, _))| coefficient * contractions.value(tree)).sum()
    }
}

#[cfg(test)]
mod tests;
