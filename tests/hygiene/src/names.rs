//! Items around a system with the names that generated code could be careless about. Its words as fields, coordinates, types and
//! sizes are in `golden`.
#![allow(non_upper_case_globals, non_camel_case_types, missing_docs, dead_code, unused_macros, clippy::pedantic)]

use ::renamed::embedding::{DeltaPlus, Midpoint};

mod std {}
mod core {}
mod wzvi {}
mod nalgebra {}
mod __private {}
type usize = ::core::primitive::usize;
struct S;
struct F;
struct Self_;
struct State;
struct Vector;
struct Result;
struct Option;
struct Ok;
struct Err;
struct Some;
struct None;
struct Fn;
struct Sized;
struct Vec;
struct String;
struct Box;
struct SVector;
struct Scalar;
struct Hamiltonian;
struct Discretized;
struct __wzvi;
struct __S;
trait Clone {}
trait Copy {}
trait Add {}
trait Into {}
trait Default {}

/// Methods of the same names as those that generated code calls.
trait Shadow {
    fn sin(&self) -> i32 {
        0
    }
    fn powi(&self, _: i32) -> i32 {
        0
    }
    fn sin_cos(&self) -> i32 {
        0
    }
    fn is_nan(&self) -> i32 {
        0
    }
    fn energy(&self) -> i32 {
        0
    }
    fn components(&self) -> i32 {
        0
    }
    fn step(&self) -> i32 {
        0
    }
}
impl<T> Shadow for T {}

macro_rules! vec { ($($x:tt)*) => { compile_error!("not mine") }; }
macro_rules! panic { ($($x:tt)*) => { compile_error!("not mine") }; }
macro_rules! unimplemented { ($($x:tt)*) => { compile_error!("not mine") }; }
macro_rules! assert { ($($x:tt)*) => { compile_error!("not mine") }; }
macro_rules! matches { ($($x:tt)*) => { compile_error!("not mine") }; }
macro_rules! debug_assert { ($($x:tt)*) => { compile_error!("not mine") }; }

#[::renamed::hamiltonian(
    drift = |q: f64, p: f64, t: f64| 0.5 * p * p + a * (h.sin() + q * q).sqrt() + self.a + dw + t.sin() * q,
    noise = [|q, _| state * q, |q: f64, _| q.sin() * q.cos()],
    embedding = [DeltaPlus, Midpoint],
    crate = ::renamed,
)]
struct Letters {
    a: f64,
    h: f64,
    dw: f64,
    state: f64,
}

/// `f64` is the user's word as well; the fields are written out of its reach.
mod float {
    use ::renamed::embedding::Midpoint;

    #[allow(clippy::upper_case_acronyms)]
    struct f64;

    #[::renamed::hamiltonian(
        drift = |q, p| 0.5 * k * (q * q + p * p) + q.sin(),
        noise = [|q, _| q],
        embedding = Midpoint,
        crate = ::renamed,
    )]
    struct Shadowed {
        k: ::core::primitive::f64,
        _other: f64,
    }

    pub(super) fn run() -> bool {
        ::renamed::integrate::Integrate::stepper::<Midpoint>(&Shadowed { k: 1.0, _other: f64 }, 0.1).is_ok()
    }
}

/// Type parameters and lifetimes of the names that implementations use.
#[::renamed::hamiltonian(
    drift = |q, p| 0.5 * k * (q * q + p * p) + D as f64,
    noise = [|q, _| q],
    embedding = [DeltaPlus, Midpoint],
    crate = ::renamed,
)]
struct Generic<'a, S, E, F, V, const D: usize>
where
    S: ::core::clone::Clone,
    F: ::core::ops::Fn(E) -> V,
{
    k: f64,
    s: &'a [S],
    f: F,
    e: [::core::marker::PhantomData<(E, V)>; D],
}

pub(crate) fn run(x: f64) {
    use ::renamed::integrate::Integrate as _;
    let letters = Letters { a: x, h: x, dw: x, state: x };
    let _ = letters.stepper::<Midpoint>(0.1).is_ok();
    let generic =
        Generic { k: x, s: &[x], f: |y: f64| y, e: [const { ::core::marker::PhantomData }; 3] };
    let _ = (generic.s, &generic.f, generic.e);
    let _ = generic.stepper::<Midpoint>(0.1).is_ok();
    let _ = float::run();
}
