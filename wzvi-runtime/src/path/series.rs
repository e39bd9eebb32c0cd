//! Averages along one long path, whose neighbouring values are not independent.
//!
//! With the autocorrelation `ρ(t)` of a stationary series, `τ = 1/2 + Σ_{t ≥ 1} ρ(t)` is its integrated autocorrelation time, in samples, and the mean of `N`
//! values has the variance `2 τ σ² / N`: as of `N / 2τ` independent ones.
//!
//! Two estimates: by [batch means](BatchMeans) of every size, which take a few numbers of memory and end runs that are exact enough
//! ([`TimeAveraging::until_error`]), and, with the feature `correlation`, by the autocorrelation function itself
//! (`Autocorrelation`), which also gives the correlation time. Several paths from different starts show whether one path has seen all of phase space:
//! [`Chains`] compares their means.

mod averages;
mod batches;
mod chains;
#[cfg(feature = "correlation")]
mod correlation;
mod student;
mod tally;
mod temperature;
#[cfg(feature = "correlation")]
mod transform;

pub use crate::error::SeriesError;
pub use averages::{TimeAverage, TimeAverages, TimeAveraging};
pub use batches::BatchMeans;
pub use chains::Chains;
#[cfg(feature = "correlation")]
pub use correlation::{Autocorrelation, ByLag};
pub(crate) use tally::Averaged;
pub use temperature::{Equipartition, Share};
pub(crate) use temperature::{configurational, configurational_of, kinetic, kinetic_of};
