//! Digits: generated steps against the same discrete equations solved to 150 digits, over all sizes of states,
//! parameters, increments and steps.

#[path = "../../wzvi-macros/src/symbolic/tests/real.rs"]
mod real;
mod reference;
mod reversibility;
mod scales;
mod steps;
mod systems;
