//! Systems of any size: steps whose sums stay loops, in tiles, in vector instructions, over pairs and tables.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test stops at the first error")]
#![allow(missing_docs, unreachable_pub, reason = "test systems")]

mod choice;
mod collective;
mod elements;
mod lattice;
mod one_by_one;
mod pairs;
mod ranges;
#[allow(unused, clippy::all, clippy::pedantic, reason = "written by a program")]
mod random {
    include!(concat!(env!("OUT_DIR"), "/loops.rs"));
}
mod scenes;
mod seam;
mod spellings;
mod sweeps;
mod tables;
mod tiles;
mod units;
