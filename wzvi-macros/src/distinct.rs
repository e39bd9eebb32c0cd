//! Lists without repetition.

use std::collections::HashMap;
use std::hash::Hash;

/// One value for each key, in the order in which the keys came.
pub(crate) struct Distinct<K, V> {
    pub(crate) values: Vec<V>,
    places: HashMap<K, usize>,
}

impl<K, V> Default for Distinct<K, V> {
    fn default() -> Self {
        Self { values: Vec::new(), places: HashMap::new() }
    }
}

impl<K: Eq + Hash, V> Distinct<K, V> {
    /// The place of the value of `key`, which is `made` if it has none.
    pub(crate) fn place(&mut self, key: K, made: impl FnOnce() -> V) -> usize {
        *self.places.entry(key).or_insert_with(|| {
            self.values.push(made());
            self.values.len() - 1
        })
    }
}
