//! Thermostats: the steps, what they sample, and what they refuse.

mod large;
mod refusals;
mod runs;
mod steps;
mod sweeps;
mod temperatures;
