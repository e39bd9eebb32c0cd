//! Whole paths, kept for those who want to see them.

use crate::error::ConfigError;
#[cfg(feature = "serde")]
use crate::ground::numbers::Tape;

/// The observables of every path at every recorded node.
#[derive(Clone, Debug, PartialEq)]
pub struct Paths {
    nodes: usize,
    observables: usize,
    /// By path, node, observable; NaN from the node on that a path does not reach.
    values: Vec<f64>,
}

impl Paths {
    pub(crate) fn new(nodes: usize, observables: usize) -> Self {
        Self { nodes, observables, values: Vec::new() }
    }

    /// Bytes that so many paths take.
    pub(crate) fn bytes(paths: u64, nodes: usize, observables: usize) -> u128 {
        u128::from(paths) * (nodes * observables * size_of::<f64>()) as u128
    }

    /// Takes the memory for so many paths.
    pub(crate) fn reserve(&mut self, paths: u64) -> Result<(), ConfigError> {
        let bytes = Self::bytes(paths, self.nodes, self.observables);
        let numbers = usize::try_from(bytes / size_of::<f64>() as u128).unwrap_or(usize::MAX);
        self.values.try_reserve_exact(numbers).map_err(|_| {
            ConfigError::Setting(format!("there is no memory for the {bytes} bytes of all paths: keep fewer"))
        })
    }

    /// Makes room for one more path; its number.
    pub(crate) fn begin(&mut self) -> usize {
        let path = self.count();
        self.values.resize(self.values.len() + self.nodes * self.observables, f64::NAN);
        path
    }

    pub(crate) fn put(&mut self, path: usize, node: usize, values: &[f64]) {
        let first = (path * self.nodes + node) * self.observables;
        self.values[first..first + self.observables].copy_from_slice(values);
    }

    pub(crate) fn merge(&mut self, other: &Self) {
        self.values.extend_from_slice(&other.values);
    }

    #[cfg(feature = "serde")]
    pub(crate) fn pass(&mut self, tape: &mut Tape) {
        let length = tape.length(self.values.len());
        self.values.resize(length, f64::NAN);
        tape.numbers(&mut self.values);
        if !length.is_multiple_of((self.nodes * self.observables).max(1)) {
            tape.refuse();
        }
    }

    /// How many paths there are.
    pub fn count(&self) -> usize {
        self.values.len() / (self.nodes * self.observables).max(1)
    }

    /// The observables of a path at a recorded node, NaN if it failed before; `None` for a path or node that does not exist.
    pub fn at(&self, path: usize, node: usize) -> Option<&[f64]> {
        let first = (path * self.nodes + node) * self.observables;
        if node < self.nodes { self.values.get(first..first + self.observables) } else { None }
    }
}
