//! The compiler of `wzvi`.
#![allow(dead_code, reason = "the passes above the symbolic core come next")]

mod discretise;
mod emit;
mod model;
mod symbolic;
