//! Errors between ranks.

use crate::error::messages;

/// A run on several ranks that ended on all of them.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ClusterError {
    /// MPI was told that ranks have one thread.
    Threading,
    /// The settings of the ranks differ.
    Settings {
        /// A rank that differs from rank 0.
        rank: i32,
        /// The setting that differs.
        difference: String,
    },
    /// Another rank failed.
    Rank {
        /// Its number, from 0.
        rank: i32,
        /// Its message.
        cause: String,
    },
    /// A rank sent data that the program cannot read: the ranks run different programs.
    Message {
        /// Its number, from 0.
        rank: i32,
    },
}

messages! { ClusterError:
    Self::Threading => "MPI was initialised for single-threaded programs; use \
         `mpi::initialize_with_threading(Threading::Funneled)`";
    Self::Settings { rank, difference } =>
        "rank {rank} has settings other than those of rank 0 ({difference}); give all ranks the same settings";
    Self::Rank { rank, cause } => "rank {rank} ended the run: {cause}";
    Self::Message { rank } =>
        "rank {rank} sent results of another shape; start the same program on all ranks";
}
