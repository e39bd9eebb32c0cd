//! Increments of the driving noise: Wiener paths, their Wong-Zakai approximations, and increments that are given.
//!
//! A [`Wiener`] is a path, not a stream: `W(t)` is a function of the seed, the path of the ensemble, the process and the time.
//! Asking for it on any partition, forwards, backwards or at random, gives the same path bit by bit, so that runs with different
//! step sizes share it. A [`WongZakai`] averages such a path over a window. [`Increments`] are numbers of the caller's.
//!
//! ```
//! use wzvi_runtime::noise::{Interval, Noise, Wiener};
//!
//! let mut noise = Wiener::seed(7);
//! let mut dw = [0.0; 2]; // two processes
//! noise.increments(&Interval { start: 0.0, h: 0.02, step: 3 }, &mut dw)?;
//! assert_eq!(dw[1], noise.increment(1, 0.06, 0.08)?);
//! # Ok::<(), wzvi_runtime::noise::NoiseError>(())
//! ```

mod bridge;
mod cursor;
mod error;
mod grid;
mod increments;
mod normal;
mod stream;
mod truncation;
mod wiener;
mod wong_zakai;

pub use error::NoiseError;
pub use increments::Increments;
pub use truncation::{Truncation, clip_bound};
pub use wiener::Wiener;
pub use wong_zakai::{Sampling, WongZakai};

/// One step of a run, `[start + n h, start + (n + 1) h]`. Times are computed from the number of the step, never accumulated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Time at the start of the run.
    pub start: f64,
    /// Step size; negative runs backwards.
    pub h: f64,
    /// Number n of the step, from 0.
    pub step: u64,
}

impl Interval {
    /// Time after `n` steps, `start + n h`.
    #[inline]
    pub fn time(&self, n: f64) -> f64 {
        self.start + n * self.h
    }

    /// Time at the start of the step.
    #[inline]
    pub fn begin(&self) -> f64 {
        self.time(self.step as f64)
    }

    /// Time at the end of the step.
    #[inline]
    pub fn end(&self) -> f64 {
        self.time(self.step as f64 + 1.0)
    }
}

/// A source of increments.
pub trait Noise {
    /// Writes the increments of a step into `dw`, one for each process.
    ///
    /// A step taken backwards gets exactly minus the increments of the same step taken forwards (except for [`Increments`], which are
    /// given step by step).
    ///
    /// # Errors
    /// See [`NoiseError`]; `dw` is then unspecified.
    fn increments(&mut self, interval: &Interval, dw: &mut [f64]) -> Result<(), NoiseError>;

    /// Checks the settings, for a run that wants to fail before its first step.
    ///
    /// # Errors
    /// The error that every call of [`Noise::increments`] would give.
    fn check(&self) -> Result<(), NoiseError> {
        Ok(())
    }

    /// Truncates the increments with this `k` unless the user has set or refused a truncation: what a run does for an implicit
    /// scheme with multiplicative noise ([`Truncation::DEFAULT`]). Given increments are never changed.
    fn truncate_by_default(&mut self, k: f64) {
        let _ = k;
    }
}

/// A noise that has a path for every member of an ensemble.
pub trait Paths: Noise {
    /// Goes to the path with this number and keeps the memory that was allocated.
    fn set_path(&mut self, path: u64);
}
