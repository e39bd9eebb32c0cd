//! Many paths at once.

mod dispatch;
mod draws;

pub use dispatch::{InstructionSet, Kernel};
