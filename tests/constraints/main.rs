//! Motion on the manifold of constraints: steps of the references, orders, projections, failures, runs.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test stops at the first error")]
#![allow(missing_docs, unreachable_pub, reason = "test systems")]

mod between;
mod failures;
mod general;
mod holds;
mod linkages;
mod references;
mod rigid_bodies;
mod runs;
mod symplectic;
mod systems;
