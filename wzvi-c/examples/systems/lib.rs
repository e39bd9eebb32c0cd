//! A library of three systems, which the C program and the tests of the Python package load.

#![forbid(unsafe_code)]

mod definitions;

use definitions::{Kubo, Network, Pendulum};

wzvi_c::export!(Kubo, Pendulum, Network);
