//! Checks the invariants that [`Node`] documents. Only tests pay for it.
