//! Items with the names that generated code could be careless about.
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

#[::renamed::hamiltonian(
    drift = |h, dw| 0.5 * dw * dw + state * (1.0 - f64::cos(h)) + (if h > state { h } else { state * h }),
    noise = [|memory, _, q| q * memory],
    embedding = [DeltaPlus, Midpoint],
    crate = ::renamed,
)]
struct Swapped {
    state: f64,
}

/// The field has the name of everything that is local to generated code.
#[::renamed::hamiltonian(
    drift = |__q, __p| 0.5 * __p * __p * __h + __q0 * __q * __q + __x0 * __q + __a0 + __term + __prepared,
    embedding = [DeltaPlus, Midpoint],
    crate = ::renamed,
)]
struct Underscored {
    __h: f64,
    __q0: f64,
    __x0: f64,
    __a0: f64,
    __term: f64,
    __prepared: f64,
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

/// Fields, coordinates and momenta with the names of what generated code imports and binds.
mod words {
    #![allow(non_snake_case)]

    use ::renamed::embedding::{DeltaPlus, Gauss, Midpoint, Uncorrected, Verlet};
    use ::core::iter::Iterator as _;
    use ::renamed::integrate::Integrate as _;

    const CAREFUL: f64 = 1.0;
    const SCHEME: f64 = 1.0;
    mod wzvi {
        pub(super) const MASS: f64 = 1.0;
    }

    #[::renamed::hamiltonian(
        drift = |x, y| 0.5 * y * y * (h + t + dw + q.abs() + self.p.abs() + carry + prepared + S + C)
            + (self.f64 + self.Option + self.Result + self.core + self.State + self.wzvi) * x.cos()
            + (next + term + segment + memory + self.r#type + CAREFUL + SCHEME + wzvi::MASS) * x * x,
        noise = [|x, y| S * x * y],
        embedding = [Uncorrected<DeltaPlus>, Midpoint],
        invariant = |_, _| h,
        crate = ::renamed,
    )]
    struct Fields {
        h: f64,
        t: f64,
        dw: f64,
        q: f64,
        p: f64,
        carry: f64,
        prepared: f64,
        S: f64,
        C: f64,
        f64: f64,
        Option: f64,
        Result: f64,
        core: f64,
        State: f64,
        wzvi: f64,
        next: f64,
        term: f64,
        segment: f64,
        memory: f64,
        r#type: f64,
    }

    #[::renamed::hamiltonian(
        drift = |[h, t, dw, carry, S, f64, State], [prepared, memory, C, Option, Result, core, wzvi]|
            0.5 * (prepared * prepared + memory * memory + C * C + Option * Option + Result * Result
                + core * core + wzvi * wzvi)
            + (h - t).cos() + (dw - carry).cos() + (S - f64).cos() + State.powi(4) * CAREFUL,
        noise = [|[h, _, _, _, _, _, _], _| h, |[_, _, dw, _, _, _, _], _| dw],
        embedding = [DeltaPlus, Midpoint, Gauss<2>],
        crate = ::renamed,
    )]
    struct Coordinates;

    #[::renamed::hamiltonian(
        drift = |at: &[f64], into: &[f64]| (0..at.len()).map(|k| 0.5 * into[k] * into[k] / len[k] + total * at[k].cos()).sum::<f64>()
            + (0..at.len() - 1).map(|low| end[low] * (at[low + 1] - at[low]).powi(4) * t).sum::<f64>(),
        noise = [|at: &[f64], _: &[f64], c| size * at[c] + CAREFUL; self.terms],
        embedding = [DeltaPlus, Midpoint],
        crate = ::renamed,
    )]
    struct Sums {
        len: [f64; 40],
        end: [f64; 40],
        total: f64,
        t: f64,
        size: f64,
        terms: usize,
    }

    /// Sizes with the names of types, of bindings and of constants.
    #[::renamed::hamiltonian(
        drift = |q: [f64; S], p: [f64; S]| (0..S).map(|i| 0.5 * (p[i] * p[i] + k * q[i] * q[i])).sum::<f64>(),
        embedding = [DeltaPlus, Midpoint, Verlet],
        crate = ::renamed,
    )]
    struct Sized<const S: usize, const h: usize, const Scalar: bool>
    where
        [f64; h]: ::core::marker::Sized,
    {
        k: f64,
    }

    pub(super) fn run(x: f64) -> bool {
        let fields = Fields {
            h: x,
            t: x,
            dw: x,
            q: x,
            p: x,
            carry: x,
            prepared: x,
            S: x,
            C: x,
            f64: x,
            Option: x,
            Result: x,
            core: x,
            State: x,
            wzvi: x,
            next: x,
            term: x,
            segment: x,
            memory: x,
            r#type: x,
        };
        let sums = Sums { len: [x; 40], end: [x; 40], total: x, t: x, size: x, terms: 2 };
        fields.stepper::<Midpoint>(0.1).is_ok()
            && fields.stepper::<Uncorrected<DeltaPlus>>(0.1).is_ok()
            && Coordinates.stepper::<Midpoint>(0.1).is_ok()
            && sums.stepper::<DeltaPlus>(0.1).is_ok()
            && Sized::<40, 2, true> { k: x }.stepper::<Midpoint>(0.1).is_ok()
    }
}

pub(crate) fn run(x: f64) {
    use ::renamed::integrate::Integrate as _;
    let letters = Letters { a: x, h: x, dw: x, state: x };
    let _ = letters.stepper::<Midpoint>(0.1).is_ok();
    let _ = Swapped { state: x }.stepper::<DeltaPlus>(0.1).is_ok();
    let underscored = Underscored { __h: x, __q0: x, __x0: x, __a0: x, __term: x, __prepared: x };
    let _ = underscored.stepper::<DeltaPlus>(0.1).is_ok();
    let generic =
        Generic { k: x, s: &[x], f: |y: f64| y, e: [const { ::core::marker::PhantomData }; 3] };
    let _ = (generic.s, &generic.f, generic.e);
    let _ = generic.stepper::<Midpoint>(0.1).is_ok();
    let _ = float::run();
    let _ = words::run(x);
}
