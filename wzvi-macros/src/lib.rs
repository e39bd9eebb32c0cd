//! The compiler of `wzvi`.
#![allow(dead_code, reason = "the passes above the symbolic core come next")]

mod discretise;
mod model;
mod symbolic;
