//! From discrete equations to Rust.

pub(crate) mod stubs;
