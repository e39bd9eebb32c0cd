//! Through the re-export of another module, and of another crate's prelude.

pub(crate) mod outer {
    pub(crate) mod inner {
        pub(crate) use ::renamed as integrators;
    }
}

use outer::inner::integrators::prelude::*;

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + k * q * q,
    embedding = [Midpoint, DeltaPlus],
    crate = crate::reexport::outer::inner::integrators,
)]
struct Spring {
    k: f64,
}

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + q * q,
    embedding = Midpoint,
    crate = outer::inner::integrators,
)]
struct Relative;

pub(crate) fn run() {
    let _ = Spring { k: 1.0 }.stepper::<DeltaPlus>(0.1).is_ok();
    let _ = Relative.stepper::<Midpoint>(0.1).is_ok();
}
