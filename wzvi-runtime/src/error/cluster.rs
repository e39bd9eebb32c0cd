//! What can go wrong between ranks.

use std::fmt;

/// A run on several ranks that ended on all of them.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ClusterError {
    /// MPI was told that ranks have one thread.
    Threading,
    /// The ranks were not given the same run.
    Settings {
        /// A rank that differs from rank 0.
        rank: i32,
        /// In what.
        difference: String,
    },
    /// Another rank cannot go on.
    Rank {
        /// Which one.
        rank: i32,
        /// What it says.
        cause: String,
    },
    /// A rank sent what the program does not understand: the ranks run different programs.
    Message {
        /// Which one.
        rank: i32,
    },
}

impl fmt::Display for ClusterError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Threading => f.write_str(
                "MPI was initialised for programs of one thread; use \
                 `mpi::initialize_with_threading(Threading::Funneled)`",
            ),
            Self::Settings { rank, difference } => write!(
                f,
                "rank {rank} runs something else than rank 0 ({difference}); give all ranks the same settings"
            ),
            Self::Rank { rank, cause } => write!(f, "rank {rank} ended the run: {cause}"),
            Self::Message { rank } => {
                write!(f, "rank {rank} sent results of another shape; start the same program on all ranks")
            }
        }
    }
}

impl std::error::Error for ClusterError {}
