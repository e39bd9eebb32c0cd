//! Steps: systems, and the schemes that step them.

pub mod bath;
pub mod clock;
pub mod compose;
pub mod constraints;
pub(crate) mod continuation;
pub mod dense;
pub mod elements;
pub mod embedding;
pub mod gauss;
pub mod modified;
pub mod plan;
pub mod poles;
pub mod system;
pub(crate) mod word;
