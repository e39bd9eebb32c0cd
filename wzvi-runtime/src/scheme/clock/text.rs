//! The text of steps by a clock, assembled at compile time.

use std::marker::PhantomData;

use super::Clock;
use crate::scheme::compose::{BoundedText, Verlet};
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

/// Gauss steps in the extended phase space.
const GAUSS: &str = "
Steps of constant eps in the time tau of the clock, dt/dtau = Q, of
  K = Q (H0 + p_t),   p_t = -H0 at the start
by the stages below with K in place of H0 and eps in place of h, where t and p_t are a coordinate and its momentum
  (unless the time is read, p_t is constant and t <- t + eps sum_i b_i Q(i))

";

/// The explicit pair.
const PAIR: &str = "
Steps of constant eps in the time tau of the clock, dt/dtau = Q(q), of
  K = Q (H0 + p_t),   H0 = T(p) + V(q),   T = p M^-1 p/2,   p_t = -H0 at the start
Plus(eps/2), then Minus(eps/2), which are explicit but for one number each
  Plus(e)   a = p - e Q V',   D = T(a - e D Q') + V + p_t,   p <- a - e D Q',   q <- q + e Q M^-1 p,   t <- t + e Q
  Minus(e)  c = Q(q + e c M^-1 p),   q <- q + e c M^-1 p,   D = T + V + p_t,   p <- p - e (c V' + D Q'),   t <- t + e c
where H0 is that of

";

/// The splitting with a separable clock.
const LOGARITHMIC: &str = "
Clock
  dt/dtau = (-V)^-a,   a = N/D of Logarithmic<N, D>
Steps of constant eps in the time tau, with H0 = T(p) + V(q), V < 0, of
  K = f(T + p_t) - f(-V),   f'(x) = x^-a,   p_t = -H0 at the start
A(eps/2), B(eps), A(eps/2)
  A(e)  q <- q + e (T + p_t)^-a T',   t <- t + e (T + p_t)^-a
  B(e)  p <- p - e (-V)^-a V'
where H0 is that of

";

/// `EQUATIONS` of steps in the extended phase space, whose plain ones are those of `E`.
pub(super) struct ExtendedText<H, E>(PhantomData<(H, E)>);

impl<H: Clock + Discretized<E>, E> ExtendedText<H, E> {
    const OF_GAUSS: BoundedText<ROOM> =
        BoundedText::joined(&[H::CLOCK, GAUSS, <H as Discretized<E>>::EQUATIONS]);
    const OF_PAIR: BoundedText<ROOM> =
        BoundedText::joined(&[H::CLOCK, PAIR, <H as Discretized<E>>::EQUATIONS]);
    /// The text of Gauss steps.
    pub(super) const GAUSS: &'static str = {
        let text: &'static BoundedText<ROOM> = &Self::OF_GAUSS;
        text.as_str()
    };
    /// The text of the explicit pair.
    pub(super) const PAIR: &'static str = {
        let text: &'static BoundedText<ROOM> = &Self::OF_PAIR;
        text.as_str()
    };
}

/// `EQUATIONS` of the splitting with a separable clock.
pub(super) struct LogarithmicText<H>(PhantomData<H>);

impl<H: Discretized<Verlet>> LogarithmicText<H> {
    const TEXT: BoundedText<ROOM> =
        BoundedText::joined(&[LOGARITHMIC, <H as Discretized<Verlet>>::EQUATIONS]);
    /// The text.
    pub(super) const ALL: &'static str = {
        let text: &'static BoundedText<ROOM> = &Self::TEXT;
        text.as_str()
    };
}
