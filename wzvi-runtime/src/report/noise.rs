//! The noise of a measurement: that of paths from some number on.

use crate::increments::{Identity, Interval, Noise, NoiseError};
use crate::noise::Paths;
use crate::plan::Plan;

/// A noise of any type that can be copied.
pub(super) trait Driver<'a>: Paths + Send + Sync {
    fn copy(&self) -> Box<dyn Driver<'a> + 'a>;
}

impl<'a, N: Paths + Clone + Send + Sync + 'a> Driver<'a> for N {
    fn copy(&self) -> Box<dyn Driver<'a> + 'a> {
        Box::new(self.clone())
    }
}

/// A noise whose path 0 is path `first` of another.
pub(super) struct Shifted<'a> {
    pub(super) noise: Box<dyn Driver<'a> + 'a>,
    pub(super) first: u64,
}

impl Clone for Shifted<'_> {
    fn clone(&self) -> Self {
        Self { noise: (*self.noise).copy(), first: self.first }
    }
}

impl Noise for Shifted<'_> {
    fn prepare(&mut self, plan: &Plan, h: f64, processes: usize, start: f64) -> Result<(), NoiseError> {
        self.noise.prepare(plan, h, processes, start)
    }

    fn increments(&mut self, interval: &Interval, dw: &mut [f64]) -> Result<(), NoiseError> {
        self.noise.increments(interval, dw)
    }

    fn identity(&self) -> Option<Identity> {
        self.noise.identity()
    }
}

impl Paths for Shifted<'_> {
    fn set_path(&mut self, path: u64) {
        self.noise.set_path(self.first.wrapping_add(path));
    }
}
