//! Programs that shadow, rename and forbid whatever generated code might lean on. They only have to compile.
#![no_implicit_prelude]
#![deny(warnings, missing_docs, unsafe_code, unreachable_pub, unused_qualifications)]
#![deny(clippy::all, clippy::pedantic, clippy::unwrap_used, clippy::expect_used, clippy::panic)]
#![deny(non_snake_case, single_use_lifetimes, missing_debug_implementations, elided_lifetimes_in_paths)]

mod attributes;
/// Written by `tests/compiler/hygiene.rs`.
#[allow(warnings, non_snake_case, clippy::all, clippy::pedantic)]
mod golden {
    ::core::include!(::core::env!("GOLDEN_NAMES"));
}
mod macros;
mod names;
mod reexport;

/// The dependency under its new name.
#[::renamed::hamiltonian(
    drift = |q, p| 0.5 * a * (q * q + p * p),
    noise = [|q, p| 0.5 * sigma * (q * q + p * p)],
    embedding = [Uncorrected<DeltaPlus>, Corrected<DeltaPlus>, Midpoint, Mixed<Lambda<1, 3>, Midpoint>],
    invariant = |q, p| q * q + p * p,
    crate = ::renamed,
)]
#[derive(::core::clone::Clone, ::core::fmt::Debug)]
pub struct Kubo {
    /// Frequency.
    pub a: f64,
    /// Noise.
    pub sigma: f64,
}

use ::renamed::embedding::{Corrected, DeltaPlus, Lambda, Midpoint, Mixed, Uncorrected};

/// A caller of everything.
///
/// # Errors
///
/// Those of the steps.
pub fn run() -> ::core::result::Result<f64, ::renamed::Error> {
    use ::renamed::integrate::Integrate;
    use ::renamed::system::Hamiltonian;

    let kubo = Kubo { a: 1.0, sigma: 0.5 };
    let mut state = ::renamed::state::State::new([0.0], [1.0]);
    let mut stepper = kubo.stepper::<Midpoint>(0.1)?;
    stepper.step(&mut state, &[0.1])?;
    let mut stepper = kubo.stepper::<Corrected<DeltaPlus>>(0.1)?;
    stepper.step(&mut state, &[0.1])?;
    names::run(state.t);
    macros::run();
    attributes::run();
    reexport::run();
    ::core::result::Result::Ok(kubo.energy(&state))
}
