//! Ensembles on several ranks: the bits of one process, and an end of all where one fails. Needs `mpirun` of Open MPI:
//! `cargo test --workspace --features mpi --test cluster`.

#![cfg(feature = "mpi")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first error")]

mod cluster {
    mod bits;
    mod failures;
    mod ranks;
}
