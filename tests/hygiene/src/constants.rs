//! Constants and statics with the letters of the equations, which would turn careless bindings into patterns.
#![allow(non_upper_case_globals, dead_code)]

use ::renamed::embedding::{Corrected, DeltaPlus, Midpoint};

const h: f64 = 1.0;
const q: f64 = 1.0;
const p: f64 = 1.0;
const t: f64 = 1.0;
const f: f64 = 1.0;
const n: usize = 1;
const term: usize = 1;
const result: f64 = 1.0;
const q0: f64 = 1.0;
const segment: f64 = 1.0;
static dw: f64 = 1.0;
static state: f64 = 1.0;
static system: f64 = 1.0;
static memory: f64 = 1.0;

#[::renamed::hamiltonian(
    drift = |x, y, time| 0.5 * y * y * (1.0 + x * x) + k * x.sin() * time,
    noise = [|x, _| x.cos(), |x, y| x * y],
    embedding = [Corrected<DeltaPlus>, Midpoint],
    invariant = |_, _| 1.0,
    crate = ::renamed,
)]
struct Letters {
    k: f64,
}

pub(crate) fn run() {
    use ::renamed::integrate::Integrate as _;
    let _ = Letters { k: 1.0 }.stepper::<Midpoint>(0.1).is_ok();
}
