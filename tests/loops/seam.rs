//! There is no seam between steps that are emitted as straight-line code and steps that are emitted in loops, nor between
//! the spellings of a size: what a system is, and what a step of it gives, depends on neither.

mod sizes;
mod values;
