//! From systems to systems: what is declared becomes what is derived from.

pub(crate) mod collect;
pub(crate) mod friction;
pub(crate) mod unroll;
