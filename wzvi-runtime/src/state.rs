//! Points of phase space.

use std::fmt::Debug;

use nalgebra::{DVector, SVector};

/// A vector of coordinates: `nalgebra::SVector<f64, D>` or `nalgebra::DVector<f64>`.
pub trait Vector: Clone + Debug + PartialEq {
    /// The zero vector with `len` components (for a vector of fixed size, its own).
    fn zeros(len: usize) -> Self;
    /// The components.
    fn components(&self) -> &[f64];
    /// The components, to change.
    fn components_mut(&mut self) -> &mut [f64];
}

impl<const D: usize> Vector for SVector<f64, D> {
    fn zeros(_len: usize) -> Self {
        Self::zeros()
    }
    #[inline(always)]
    fn components(&self) -> &[f64] {
        self.as_slice()
    }
    #[inline(always)]
    fn components_mut(&mut self) -> &mut [f64] {
        self.as_mut_slice()
    }
}

impl Vector for DVector<f64> {
    fn zeros(len: usize) -> Self {
        Self::zeros(len)
    }
    #[inline(always)]
    fn components(&self) -> &[f64] {
        self.as_slice()
    }
    #[inline(always)]
    fn components_mut(&mut self) -> &mut [f64] {
        self.as_mut_slice()
    }
}

/// A state: coordinates `q`, canonical momenta `p` and time `t`, in the units of the Hamiltonian.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct State<V> {
    /// Coordinates.
    pub q: V,
    /// Canonical (node) momenta.
    pub p: V,
    /// Time.
    pub t: f64,
}

impl<V: Vector> State<V> {
    /// The state with coordinates `q` and momenta `p` at `t = 0`, from arrays, `Vec`s or nalgebra vectors.
    pub fn new(q: impl Into<V>, p: impl Into<V>) -> Self {
        Self { q: q.into(), p: p.into(), t: 0.0 }
    }

    /// The same point of phase space at time `t`.
    #[must_use]
    pub fn at(mut self, t: f64) -> Self {
        self.t = t;
        self
    }
}
