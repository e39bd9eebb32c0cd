//! Dual numbers `a + b ε` with `ε² = 0`: exact derivatives through any generic computation.
