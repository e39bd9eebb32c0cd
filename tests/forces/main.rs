//! Forces, friction and baths: the discrete Lagrange-d'Alembert principle, thermostats, work and heat.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test stops at the first error")]
#![allow(missing_docs, unreachable_pub, reason = "test systems")]

mod balance;
mod bath;
mod friction;
mod gjf;
mod ito;
mod noise;
mod orders;
mod principle;
mod systems;
mod thermostats;
mod words;
mod work;
