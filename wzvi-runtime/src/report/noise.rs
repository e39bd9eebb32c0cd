//! The noise of a measurement: that of paths from some number on, the same for all schemes.
//!
//! A thermostat with one O part in a step is driven by one Wiener process `W` for each degree of freedom. A
//! thermostat with two O parts is driven by two, `W_1` and `W_2`, and converges to the path of
//! `(W_1 + W_2) / √2`. With `W_{1,2} = (W ± W') / √2` and an independent `W'`, these are independent Wiener
//! processes, and both thermostats converge to the path of `W`.
//!
//! Tested by `tests/paths/report/thermostats.rs`.

use std::f64::consts::FRAC_1_SQRT_2;

use crate::increments::{Identity, Interval, Noise, NoiseError};
use crate::noise::{Driver, Paths};
use crate::scheme::plan::Plan;

/// A noise whose path 0 is path `first` of another, for a system of so many degrees of freedom and noises
/// beside its bath.
pub(super) struct Shifted<'a> {
    pub(super) noise: Box<dyn Driver + 'a>,
    pub(super) first: u64,
    pub(super) degrees: usize,
    pub(super) noises: usize,
}

impl Clone for Shifted<'_> {
    fn clone(&self) -> Self {
        Self { noise: (*self.noise).copy(), ..*self }
    }
}

impl Noise for Shifted<'_> {
    fn prepare(&mut self, plan: &Plan, h: f64, processes: usize, start: f64) -> Result<(), NoiseError> {
        self.noise.prepare(plan, h, processes, start)
    }

    fn increments(&mut self, interval: &Interval, dw: &mut [f64]) -> Result<(), NoiseError> {
        self.noise.increments(interval, dw)?;
        if let Some(of_bath) = dw.get_mut(self.noises..)
            && of_bath.len() == 2 * self.degrees
        {
            let (first, second) = of_bath.split_at_mut(self.degrees);
            for (first, second) in first.iter_mut().zip(second) {
                let (sum, difference) = (*first + *second, *first - *second);
                (*first, *second) = (sum * FRAC_1_SQRT_2, difference * FRAC_1_SQRT_2);
            }
        }
        Ok(())
    }

    fn largest_increment(&self, h: f64) -> f64 {
        self.noise.largest_increment(h)
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
