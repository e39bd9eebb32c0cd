//! Attributes before and after, items in functions, conditions.

use ::core::clone::Clone;
use ::core::prelude::v1::derive;
use ::renamed::embedding::{DeltaPlus, Midpoint};

/// Before.
#[derive(::core::clone::Clone, ::core::fmt::Debug, ::core::cmp::PartialEq)]
#[::renamed::hamiltonian(drift = |q, p| k * q * p, embedding = Midpoint, crate = ::renamed)]
#[must_use = "between"]
#[derive(::core::cmp::PartialOrd)]
#[cfg_attr(all(), repr(C))]
/// After.
#[non_exhaustive]
pub(crate) struct Decorated {
    /// Documented.
    #[doc(alias = "stiffness")]
    pub k: f64,
    #[cfg(any())]
    missing: NoSuchType,
    #[cfg(not(any()))]
    present: u8,
}

#[cfg(any())]
#[::renamed::hamiltonian(drift = |q, p| nonsense, embedding = Nowhere, crate = ::renamed)]
struct Absent;

#[cfg_attr(
    all(),
    ::renamed::hamiltonian(drift = |q, p| self.k * q * p, embedding = DeltaPlus, crate = ::renamed)
)]
struct Conditional {
    #[cfg(any())]
    k: NoSuchType,
    #[cfg(not(any()))]
    k: f64,
}

#[deprecated]
#[::renamed::hamiltonian(drift = |q, p| k * q * p, embedding = Midpoint, crate = ::renamed)]
struct Old {
    #[deprecated]
    k: f64,
}

pub(crate) fn run() {
    use ::renamed::integrate::Integrate as _;

    const SHIFT: f64 = 1.0;

    #[::renamed::hamiltonian(
        drift = |q, p| k * q * p + SHIFT,
        noise = [|q, _| q],
        embedding = [DeltaPlus, Midpoint],
        crate = ::renamed,
    )]
    struct Inner {
        k: f64,
    }

    let _ = Inner { k: 1.0 }.stepper::<Midpoint>(0.1).is_ok();
    let decorated = Decorated { k: 1.0, present: 0 };
    let _ = (Clone::clone(&decorated) == decorated, decorated.present, decorated.stepper::<Midpoint>(0.1).is_ok());
    let _ = Conditional { k: 1.0 }.stepper::<DeltaPlus>(0.1).is_ok();
    #[allow(deprecated)]
    let _ = Old { k: 1.0 }.stepper::<Midpoint>(0.1).is_ok();
}
