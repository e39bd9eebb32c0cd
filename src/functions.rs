//! Functions that `f64` does not have, for Hamiltonians and for programs: the same values in both.
//!
//! In closures of [`#[hamiltonian]`](crate::hamiltonian) and in bodies of
//! [`#[hamiltonian_fn]`](crate::hamiltonian_fn) they are functions and methods: `wzvi::functions::erf(x)`,
//! `erf(x)` after an import, `x.erf()`. In other code, `erf` and `erfc` are functions only: the standard
//! library has unstable methods of these names, and `rustc` would warn. The others are methods of
//! [`SpecialFunctions`], too.
//!
//! ```
//! use wzvi::functions::{erf, j0};
//! use wzvi::prelude::*;
//!
//! /// A well whose walls are smoothed steps, in the field of a standing cylindrical wave.
//! #[hamiltonian(
//!     drift = |q, p| 0.5 * p * p + 0.5 * ((q - 2.0).erf() - (q + 2.0).erf()) + depth * j0(q),
//!     embedding = Verlet,
//! )]
//! struct Well {
//!     depth: f64,
//! }
//!
//! fn main() -> Result<(), wzvi::Error> {
//!     let well = Well { depth: 0.1 };
//!     let path = well.simulate::<Verlet>(0.01).start(State::new([0.5], [0.0])).until(10.0).run()?;
//!     assert!(path.energy_drift(&well) < 1e-4);
//!     let q: f64 = path.last().q[0];
//!     println!("{} {} {}", erf(q), j0(q), q.sinc());
//!     Ok(())
//! }
//! ```

use wzvi_macros::hamiltonian_fn;
use wzvi_runtime::algebra::scalar::Special;

/// The error function, `2/√π ∫_0^x exp(-s²) ds`.
#[hamiltonian_fn(crate = crate)]
pub fn erf(x: f64) -> f64 {
    x.erf()
}

/// `1 - erf(x)`, to all digits where it is small.
#[hamiltonian_fn(crate = crate)]
pub fn erfc(x: f64) -> f64 {
    x.erfc()
}

/// `sin(x)/x`, and 1 at 0, where it is smooth.
#[hamiltonian_fn(crate = crate)]
pub fn sinc(x: f64) -> f64 {
    x.sinc()
}

/// The Bessel function of the first kind of order 0.
#[hamiltonian_fn(crate = crate)]
pub fn j0(x: f64) -> f64 {
    x.j0()
}

/// The Bessel function of the first kind of order 1.
#[hamiltonian_fn(crate = crate)]
pub fn j1(x: f64) -> f64 {
    x.j1()
}

/// The functions of this module as methods of `f64`, but for the error functions.
pub trait SpecialFunctions {
    /// [`sinc`]
    fn sinc(self) -> f64;
    /// [`j0`]
    fn j0(self) -> f64;
    /// [`j1`]
    fn j1(self) -> f64;
}

impl SpecialFunctions for f64 {
    fn sinc(self) -> f64 {
        Special::Sinc(0).value(self)
    }
    fn j0(self) -> f64 {
        Special::Bessel(0).value(self)
    }
    fn j1(self) -> f64 {
        self * Special::Bessel(1).value(self)
    }
}

/// The error functions as methods: for the bodies of Hamiltonians only.
#[doc(hidden)]
pub trait ErrorFunctions {
    /// [`erf`]
    fn erf(self) -> f64;
    /// [`erfc`]
    fn erfc(self) -> f64;
}

impl ErrorFunctions for f64 {
    fn erf(self) -> f64 {
        Special::Erf.value(self)
    }
    fn erfc(self) -> f64 {
        Special::Erfc.value(self)
    }
}
