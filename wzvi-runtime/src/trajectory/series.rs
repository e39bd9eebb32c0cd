//! Averages along one long path, whose neighbouring values are not independent.
//!
//! With the autocorrelation `ρ(t)` of a stationary series, `τ = 1/2 + Σ_{t ≥ 1} ρ(t)` is its integrated
//! autocorrelation time, in samples, and the mean of `N` values has the variance `2 τ σ² / N`, like the mean
//! of `N / 2τ` independent ones.
//!
//! There are two estimates of the error. [Batch means](BatchMeans) of every size need little memory, and can
//! end a run when the error is small enough ([`TimeAveraging::until_error`]). With the feature `correlation`,
//! the autocorrelation function itself (`Autocorrelation`) also gives the correlation time. Several paths
//! from different starts show whether one path has seen all of phase space: [`Chains`] compares their means.

mod averages;
mod batches;
mod chains;
#[cfg(feature = "correlation")]
mod correlation;
mod error;
mod tally;
mod temperature;
#[cfg(feature = "correlation")]
mod transform;

pub use averages::{TimeAverage, TimeAverages, TimeAveraging};
pub use batches::BatchMeans;
pub use chains::Chains;
#[cfg(feature = "correlation")]
pub use correlation::{Autocorrelation, ByLag, LagIntegral};
pub use error::SeriesError;
pub(crate) use tally::Averaged;
pub use temperature::{Equipartition, Share};
pub(crate) use temperature::{configurational, configurational_of, kinetic, kinetic_of};
