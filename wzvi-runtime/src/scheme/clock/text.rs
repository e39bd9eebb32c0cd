//! The text of steps by a clock, assembled at compile time.

use std::marker::PhantomData;

use super::Clock;
use crate::scheme::compose::BoundedText;
use crate::scheme::system::Discretized;

/// Largest length of a text in bytes.
const ROOM: usize = 1 << 16;

/// The steps of the density.
const STEPS: &str = "
Steps of size h_n by a clock, eps constant
  h_n = eps/rho_n,   rho_{n+1} = rho_n + eps G(z_{n+1}),   rho_0 = 1/Q(z_0) + eps G(z_0)/2
of

";

/// `EQUATIONS` of steps of `E` by a clock, for the system `H`.
pub(super) struct ClockedText<H, E>(PhantomData<(H, E)>);

impl<H: Clock + Discretized<E>, E> ClockedText<H, E> {
    const TEXT: BoundedText<ROOM> = BoundedText::joined(&[H::CLOCK, STEPS, <H as Discretized<E>>::EQUATIONS]);
    /// The text.
    pub(super) const ALL: &'static str = {
        let text: &'static BoundedText<ROOM> = &Self::TEXT;
        text.as_str()
    };
}
