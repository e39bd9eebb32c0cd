//! From systems to systems: transforms the declared system into the one that equations are derived from.

pub(crate) mod clock;
pub(crate) mod collect;
pub(crate) mod divisors;
pub(crate) mod friction;
pub(crate) mod ito;
pub(crate) mod unroll;
