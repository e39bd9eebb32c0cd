//! Increments of the driving noise: Wiener paths, their Wong-Zakai approximations, and increments that are
//! given.
//!
//! * A [`Wiener`] is a path, not a stream: `W(t)` is a function of the seed, the path of the ensemble, the
//!   process and the time. Any partition, forwards, backwards or at random, gives the same path bit by bit,
//!   so that runs with different step sizes share it.
//! * A [`WongZakai`] averages such a path over a window.
//! * [`StepNormals`] are one normal for each step. They are faster, and another step size is another sample.
//! * [`Increments`] are given numbers.
//!
//! Each of them drives single paths and ensembles.
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

pub(crate) mod blocks;
mod bridge;
mod cursor;
mod grid;
pub(crate) mod random;
pub(crate) mod step_normals;
mod stream;
mod truncation;
mod wiener;
mod wong_zakai;

pub use crate::increments::{Increments, Interval, Noise, NoiseError};
pub use step_normals::StepNormals;
pub use truncation::{Truncation, clip_bound};
pub use wiener::Wiener;
pub use wong_zakai::{Sampling, WongZakai};

/// A noise that has a path for every member of an ensemble.
pub trait Paths: Noise {
    /// Goes to the path with this number and keeps the memory that was allocated.
    fn set_path(&mut self, path: u64);

    /// This noise, if it is one that lanes draw by themselves.
    #[doc(hidden)]
    fn step_normals(&self) -> Option<StepNormals> {
        None
    }

    /// The seed, of a noise that has one.
    #[doc(hidden)]
    fn seed_number(&self) -> Option<u64> {
        None
    }
}

/// A noise of any type that every thread can have a copy of.
pub(crate) trait Driver: Paths + Send + Sync {
    fn copy<'a>(&self) -> Box<dyn Driver + 'a>
    where
        Self: 'a;
}

impl<N: Paths + Clone + Send + Sync> Driver for N {
    fn copy<'a>(&self) -> Box<dyn Driver + 'a>
    where
        Self: 'a,
    {
        Box::new(self.clone())
    }
}

/// No noise is the same for every member of an ensemble.
impl Paths for crate::increments::NoNoise {
    fn set_path(&mut self, _path: u64) {}
}

/// Numbers are one path: every member of an ensemble has it.
impl Paths for Increments {
    fn set_path(&mut self, _path: u64) {}
}
