//! Anything that can go wrong with a run: the errors of all rooms, those of rooms below included.

#[cfg(feature = "mpi")]
mod cluster;
#[cfg(feature = "ensemble")]
mod level;
#[cfg(feature = "svg")]
mod plot;
#[cfg(feature = "report")]
mod report;

use std::fmt;

use crate::error::{
    ConfigError, DerivativeError, InternalError, NoiseError, StepError, StoppedError, UnknownName,
};
#[cfg(feature = "mpi")]
pub use cluster::ClusterError;
#[cfg(feature = "ensemble")]
pub use level::{LevelError, LevelFailure};
#[cfg(feature = "svg")]
pub use plot::PlotError;
#[cfg(feature = "report")]
pub use report::ReportError;

pub use crate::calculus::DomainError;
pub use crate::saving::FileError;
#[cfg(feature = "ensemble")]
pub use crate::statistics::StatisticsError;
pub use crate::trajectory::checkpoint::{CheckpointError, Damage, Difference};
pub use crate::trajectory::recorded::PathError;
pub use crate::trajectory::series::SeriesError;

/// An enum of errors, each of which it is made of: its messages are theirs.
macro_rules! any_of {
    ($(#[$meta:meta])* $name:ident: $($(#[doc = $doc:literal])* $(#[cfg($cfg:meta)])? $variant:ident($error:ty),)+) => {
        $(#[$meta])*
        pub enum $name {
            $($(#[doc = $doc])* $(#[cfg($cfg)])? $variant($error),)+
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                match self {
                    $($(#[cfg($cfg)])? Self::$variant(error) => error.fmt(f),)+
                }
            }
        }

        $($(#[cfg($cfg)])?
        impl From<$error> for $name {
            fn from(error: $error) -> Self {
                Self::$variant(error)
            }
        })+
    };
}

any_of! {
    /// Anything that can go wrong, for `main` and `?`: its `Debug` is its `Display`, which is what a `main`
    /// that returns it shows.
    ///
    /// The message of an error contains those of its causes: [`source`](std::error::Error::source) has
    /// nothing to add.
    #[derive(Clone, PartialEq)]
    #[non_exhaustive]
    Error:
    /// The run could not start.
    Config(ConfigError),
    /// A step failed.
    Step(StepError),
    /// A derivative of the end of a run is out of the range of numbers.
    Derivative(Box<DerivativeError>),
    /// The source of the increments had none for this run or this step.
    Noise(NoiseError),
    /// A recorded path cannot answer.
    Path(PathError),
    /// A name that the run does not have.
    Name(UnknownName),
    /// A discrete function was evaluated off its time scale, or combined with one on another.
    Domain(DomainError),
    /// A mistake of the library.
    Internal(InternalError),
    /// A file could not be written.
    File(FileError),
    /// A single path was stopped.
    Stopped(StoppedError),
    /// A path of a multilevel run has no value.
    #[cfg(feature = "ensemble")]
    Level(LevelError),
    /// More paths of an ensemble failed than it allows.
    #[cfg(feature = "ensemble")]
    Losses(Box<crate::statistics::LossError>),
    /// The statistics of an ensemble cannot answer a question.
    #[cfg(feature = "ensemble")]
    Statistics(StatisticsError),
    /// A checkpoint could not be written, or is not one of this run.
    Checkpoint(CheckpointError),
    /// A run on several ranks ended on all of them.
    #[cfg(feature = "mpi")]
    Cluster(ClusterError),
    /// A plot could not be drawn or written.
    #[cfg(feature = "svg")]
    Plot(PlotError),
    /// A measurement could not be made or written.
    #[cfg(feature = "report")]
    Report(ReportError),
}

impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl std::error::Error for Error {}
