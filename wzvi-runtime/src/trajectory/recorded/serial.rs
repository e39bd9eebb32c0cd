//! Trajectories in the formats of `serde`. No state has a NaN or an infinity, and those of observables and
//! energies are texts in formats without them ([`crate::ground::loose`]).

use std::marker::PhantomData;

use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

use super::{Path, Trajectory};
use crate::algebra::state::Vector;

impl<V: Serialize, E> Serialize for Trajectory<V, E> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.path.serialize(serializer)
    }
}

impl<'de, V: Vector + Deserialize<'de>, E> Deserialize<'de> for Trajectory<V, E> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let path = Path::<V>::deserialize(deserializer)?;
        match path.mistake() {
            None => Ok(Self { path, variables: None, unsaved: None, scheme: PhantomData }),
            Some(mistake) => Err(D::Error::custom(mistake)),
        }
    }
}

impl<V: Vector> Path<V> {
    /// The first reason why no run can have made this path, if there is one.
    fn mistake(&self) -> Option<&'static str> {
        let Some(first) = self.states.first() else { return Some("a trajectory has at least its start") };
        let d = first.q.components().len();
        let is_odd = |vector: &V| vector.components().len() != d;
        if self.states.iter().chain([&self.last]).any(|state| is_odd(&state.q) || is_odd(&state.p)) {
            return Some("the states of a trajectory have the same number of components");
        }
        if Some(self.increments.len()) != (self.states.len() - 1).checked_mul(self.processes) {
            return Some("a trajectory has one increment per interval and noise");
        }
        (self.states.last() != Some(&self.last))
            .then_some("the last recorded state is the end of the trajectory")
    }
}
