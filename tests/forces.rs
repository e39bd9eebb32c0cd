//! Forces: the discrete Lagrange-d'Alembert principle, friction and noise forces, against solutions that are known.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[path = "forces/systems.rs"]
mod systems;

#[path = "forces/friction.rs"]
mod friction;
#[path = "forces/noise.rs"]
mod noise;
#[path = "forces/orders.rs"]
mod orders;
#[path = "forces/principle.rs"]
mod principle;
#[path = "forces/thermostats.rs"]
mod thermostats;
