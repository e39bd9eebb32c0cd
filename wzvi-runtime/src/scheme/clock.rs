//! Clocks: steps that follow the motion.
//!
//! A clock is a function `Q(q, p, t) > 0`, the wanted step in units of a constant `eps`. Naive steps
//! `h = eps Q` lose the energy of long runs. [`Clocked`] keeps a density `ρ` beside the state, which is `1/Q`
//! along the exact motion:
//!
//! ```text
//! h_n = eps/ρ_n,   z_{n+1} = Φ_{h_n}(z_n),   ρ_{n+1} = ρ_n + eps G(z_{n+1}),   G = -d ln Q/dt
//! ρ_0 = 1/Q(z_0) + (eps/2) G(z_0)
//! ```
//!
//! with a symmetric step `Φ`. This is a symmetric splitting of `z' = f/ρ`, `ρ' = G`: it is reversible and of
//! the order of `Φ`, up to that of the clock itself, and `ρ Q` oscillates without drift (E. Hairer, G.
//! Söderlind, "Explicit, time reversible, adaptive step size control", SIAM J. Sci. Comput. 26, 2005).
//!
//! [`Extended`] steps the Hamiltonian `K = Q (H + p_t)` of the extended phase space, whose flow is that of
//! `H` in the time `τ` of the clock: symplectic, and errors of the energy are restored where `Q` is large (E.
//! Hairer, "Variable time step integration with symplectic methods", Appl. Numer. Math. 25, 1997). For
//! `H = T(p) + V(q)` with `V < 0`, [`Logarithmic`] steps `K = f(T + p_t) - f(-V)` explicitly (S. Mikkola, K.
//! Tanikawa 1999; M. Preto, S. Tremaine 1999).
//!
//! Tested by `tests/steps/clock.rs`.

mod density;
mod evaluation;
mod extended;
mod side;
mod text;

use std::marker::PhantomData;

use crate::scheme::compose::{Composed, Verlet};
use crate::scheme::elements::Elements;
use crate::scheme::embedding::Midpoint;
use crate::scheme::gauss::Gauss;

pub use density::{ClockMemory, ClockMemoryOf, ClockedComposition, ClockedSteps};
pub use extended::{
    ExplicitPair, ExtendedGauss, ExtendedMemory, LogarithmicSplitting, PairNode, SplittingNode, StageMemory,
};
pub(crate) use side::SideStepper;

/// The constant step of a clock, a fraction: steps take `eps Q` in time. It has no unit if `Q` is a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eps(pub f64);

/// Steps of the symmetric scheme `E` over `h_n = eps/ρ_n`, with the density `ρ` of the [clock](self).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Clocked<E>(PhantomData<E>);

/// Steps of `E` of the Hamiltonian `Q (H + p_t)`, for the [clock](self) `Q`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Extended<E>(PhantomData<E>);

/// Drift, kick, drift of `f(T + p_t) - f(-V)` with `f'(x) = x^{-N/D}`, for `H = T(p) + V(q)` with `V < 0`
/// ([clocks](self)). `Logarithmic<1, 1>` is the logarithmic Hamiltonian, whose orbits of Kepler's problem are
/// exact but for their time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Logarithmic<const N: u32, const D: u32>;

/// A system with a clock; generated for `clock = ...`. Its elements have values for
/// [`Role::Clock`](crate::scheme::elements::Role::Clock) and
/// [`Role::ClockRate`](crate::scheme::elements::Role::ClockRate).
#[diagnostic::on_unimplemented(
    message = "`{Self}` has no clock",
    label = "a scheme with a clock needs one",
    note = "add `clock = curvature`, `clock = pairs` or `clock = |q, p| ...` to the `#[hamiltonian(...)]` of `{Self}`"
)]
pub trait Clock: Elements {
    /// `Q` and `G` as text.
    const CLOCK: &'static str;
}

/// A system whose clock extends its phase space; generated where `Extended` is listed. Its elements have
/// derivatives for [`Role::Clock`](crate::scheme::elements::Role::Clock).
#[diagnostic::on_unimplemented(
    message = "`{Self}` lists no scheme `Extended<...>`",
    label = "not generated for `{Self}`",
    note = "only listed schemes are compiled: add it to `embedding = [...]` in the `#[hamiltonian(...)]` of `{Self}`"
)]
pub trait Extends: Clock {
    /// Whether the Hamiltonian or the clock reads the time.
    const READS_TIME: bool = Self::FACTS.kind.reads_time;
}

/// A system `T(p) + V(q)` with `V < 0`, by proof; generated where `Logarithmic` is listed. Its elements have
/// values and derivatives for [`Role::Summand`](crate::scheme::elements::Role::Summand): 0 is `T`, 1 is `V`.
#[diagnostic::on_unimplemented(
    message = "`{Self}` lists no scheme `Logarithmic<N, D>`",
    label = "not generated for `{Self}`",
    note = "only listed schemes are compiled: add it to `embedding = [...]` in the `#[hamiltonian(...)]` of `{Self}`"
)]
pub trait Attractive: Elements {}

/// Schemes whose step backwards undoes the step forwards, of any order: [`Clocked`] takes these.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not symmetric, and steps of changing size would drift",
    label = "a clock needs a symmetric scheme",
    note = "`Midpoint`, `Verlet`, `Gauss<S>` and their compositions are"
)]
pub trait SelfAdjoint {}

impl SelfAdjoint for Midpoint {}
impl SelfAdjoint for Verlet {}
impl<const S: usize> SelfAdjoint for Gauss<S> {}
// Weights and tables are palindromes, which the build checks.
impl<E: SelfAdjoint, W> SelfAdjoint for Composed<E, W> {}

/// A step by a clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockReading {
    /// The time at its end.
    pub t: f64,
    /// Its length in time.
    pub h: f64,
    /// The density `ρ` there, of which the next step takes `eps/ρ`; NaN for schemes without one.
    pub density: f64,
}
