//! Constants and statics with the letters of the equations, which would turn careless bindings into patterns.
#![allow(non_upper_case_globals, non_camel_case_types, dead_code)]

use ::core::iter::Iterator as _;
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
const sum: f64 = 1.0;
const product: f64 = 1.0;
const next: f64 = 1.0;
const effort: f64 = 1.0;
const iterate: f64 = 1.0;
const by_q: f64 = 1.0;
const x_start: f64 = 1.0;
const k_squared: f64 = 1.0;
static node_y: f64 = 1.0;
struct delta_y;
const wzvi: f64 = 1.0;
const S: f64 = 1.0;
const i0: f64 = 1.0;
const low: f64 = 1.0;
const len: f64 = 1.0;
const total: f64 = 1.0;
const at: f64 = 1.0;

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

#[::renamed::hamiltonian(
    drift = |x: &[f64], v: &[f64]| v.iter().map(|v| 0.5 * v * v).sum::<f64>()
        + (1..x.len()).map(|j| self.k * (x[j] - x[j - 1]).powi(4)).sum::<f64>(),
    embedding = [DeltaPlus, Midpoint],
    crate = ::renamed,
)]
struct Looped {
    k: f64,
}

pub(crate) fn run() {
    use ::renamed::integrate::Integrate as _;
    let _ = Looped { k: 1.0 }.stepper::<Midpoint>(0.1).is_ok();
    let _ = Letters { k: 1.0 }.stepper::<Midpoint>(0.1).is_ok();
}
