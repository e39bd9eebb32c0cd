//! The quantities of a system by their names: what tables, plots and programs in other languages show of a
//! state.
//!
//! Tested by `tests/paths/observables.rs`.

use super::Hamiltonian;
use crate::algebra::state::{State, Vector};
use crate::error::UnknownName;
use crate::ground::names::free;

/// A quantity of a system: a number at each state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// The time of the state.
    Time,
    /// A coordinate, by its number.
    Coordinate(usize),
    /// A momentum, by the number of its coordinate.
    Momentum(usize),
    /// The drift Hamiltonian.
    Energy,
    /// A proven first integral, by its number in `invariant = [...]`.
    Invariant(usize),
    /// An observable, by its number in `observe = [...]`.
    Observable(usize),
}

impl Quantity {
    /// The quantity of `system` with this name, for states with `degrees` degrees of freedom: a coordinate,
    /// a momentum or the time by the name in the closure of the drift, `q[3]` for one of an array; `energy`;
    /// a first integral or an observable by its name in the attribute. [`Quantity::all`] has all names.
    ///
    /// # Errors
    /// [`UnknownName`] with the names that exist.
    pub fn named<H: Hamiltonian + ?Sized>(
        system: &H,
        degrees: usize,
        name: &str,
    ) -> Result<Self, UnknownName> {
        let all: Vec<(String, Self)> = Self::all(system, degrees).collect();
        UnknownName::find("quantity", name, all.iter().map(|(known, quantity)| (known, *quantity)))
    }

    /// Its value at a state: NaN if there is no such quantity, or the state does not fit the system.
    pub fn value<H: Hamiltonian + ?Sized>(self, system: &H, state: &State<H::Vector>) -> f64 {
        let component =
            |vector: &H::Vector, i: usize| vector.components().get(i).copied().unwrap_or(f64::NAN);
        match self {
            Self::Time => state.t,
            Self::Coordinate(i) => component(&state.q, i),
            Self::Momentum(i) => component(&state.p, i),
            Self::Energy => system.energy(state),
            Self::Invariant(i) => system.invariant(i, state),
            Self::Observable(i) => system.observable(i, state),
        }
    }

    /// The quantities of `system` with their names, for states with `degrees` degrees of freedom: the time,
    /// coordinates, momenta, `energy`, first integrals, observables. The energy is `energy_` where a variable
    /// has that name.
    pub fn all<H: Hamiltonian + ?Sized>(
        system: &H,
        degrees: usize,
    ) -> impl Iterator<Item = (String, Self)> + use<H> {
        let names = system.variables();
        let (invariants, observables) = (system.invariants(), system.observables());
        let coordinates = (0..degrees).map(move |i| (names.q.name(i), Self::Coordinate(i)));
        let momenta = (0..degrees).map(move |i| (names.p.name(i), Self::Momentum(i)));
        let integrals = (0..invariants).map(move |i| (names.invariant(i), Self::Invariant(i)));
        let observed = (0..observables).map(move |i| (names.observable(i), Self::Observable(i)));
        let variables = [(names.t.to_owned(), Self::Time)].into_iter().chain(coordinates).chain(momenta);
        let others: Vec<(String, Self)> = integrals.chain(observed).collect();
        let variables: Vec<(String, Self)> = variables.collect();
        let energy = free("energy", variables.iter().chain(&others).map(|(known, _)| known.as_str()));
        variables.into_iter().chain([(energy, Self::Energy)]).chain(others)
    }
}
