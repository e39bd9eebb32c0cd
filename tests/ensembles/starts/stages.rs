//! Paths whose steps have stages, beside each other.

use std::slice::from_ref;

use fixtures::stepped::{failed, paths_are_steppers};
use wzvi::ensemble::Draw;
use wzvi::prelude::*;

/// Not separable, with a function that lanes compute by themselves, the time, and noise that multiplies.
#[hamiltonian(
    drift = |q, p, t| 0.5 * p * p / (1.0 + m * q * q) - k * q.cos() + 0.1 * t.sin() * q,
    noise = [|q, p| s * q * p],
    embedding = [Gauss<3>],
)]
struct Swing {
    m: f64,
    k: f64,
    s: f64,
}

/// Paths with different starts need different numbers of sweeps, with functions and with noise.
#[test]
fn stages_of_paths_beside_each_other_are_those_of_steppers() {
    let swing = Swing { m: 0.2, k: 1.5, s: 0.3 };
    let start = |draw: &mut Draw| State::new([0.07 * draw.path() as f64 - 1.5], [0.5 * draw.normal()]);
    let run = || swing.ensemble::<Gauss<3>>(0.25).starts(start);
    let paths = paths_are_steppers(run, from_ref(&swing), (0.25, 40), (45, 8));
    assert_eq!(failed(&paths), 0);
    let infos = paths.iter().flat_map(|path| &path.infos);
    let sweeps = infos
        .fold([u32::MAX, 0], |[least, most], info| [least.min(info.iterations), most.max(info.iterations)]);
    assert!(sweeps[0] + 3 < sweeps[1], "{sweeps:?} sweeps: no path waits for another");
}
