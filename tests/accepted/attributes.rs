//! The remedies of messages about attributes compile; so do attributes that change no value.

use wzvi::prelude::*;

pub const K: f64 = if cfg!(any()) { 1.0 } else { 4.0 };

/// A constant chosen outside, beside attributes that are accepted.
#[hamiltonian(
    drift = |q, p| {
        #[allow(unused_variables)]
        let unused = 1.0;
        /// The well.
        #[rustfmt::skip]
        let well = match n {
            #[expect(clippy::all)]
            1 => 0.5 * K * q * q,
            _ => 0.0,
        };
        0.5 * p * p + well
    },
    embedding = DeltaPlus,
)]
#[derive(Clone)]
#[cfg_attr(all(), derive(Debug))]
struct Chosen {
    n: usize,
    #[cfg(any())]
    absent: f64,
}

#[cfg(any())]
#[hamiltonian(drift = |q, p| 0.5 * p * p + q, embedding = DeltaPlus)]
struct Variant;

#[cfg(not(any()))]
#[hamiltonian(drift = |q, p| 0.5 * p * p + self.0 * well(q) + other(q), embedding = DeltaPlus)]
struct Variant(f64);

#[cfg(any())]
#[hamiltonian_fn]
fn well(q: f64) -> f64 {
    q
}

#[cfg(not(any()))]
#[hamiltonian_fn]
#[inline]
#[must_use]
fn well(q: f64) -> f64 {
    0.5 * q * q
}

#[hamiltonian_fn]
fn other(q: f64) -> f64 {
    0.5 * crate::attributes::K * q * q
}

/// The force at q = 1 is that of the branch that `rustc` takes.
#[test]
fn conditions_of_the_build_are_outside() -> Result<(), wzvi::Error> {
    let mut state = State::new([1.0], [0.0]);
    Chosen { n: 1 }.stepper::<DeltaPlus>(0.5)?.step(&mut state, &[])?;
    assert_eq!(state.p[0], -0.5 * K);
    let mut state = State::new([1.0], [0.0]);
    Variant(3.0).stepper::<DeltaPlus>(0.5)?.step(&mut state, &[])?;
    assert_eq!(state.p[0], -0.5 * (3.0 + 4.0));
    Ok(())
}
