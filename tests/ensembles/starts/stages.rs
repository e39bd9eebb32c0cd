//! Paths whose steps have stages, beside each other.

use std::sync::Mutex;

use wzvi::ensemble::Draw;
use wzvi::prelude::*;

use crate::stepped::stepped;

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
    const PATHS: usize = 45;
    let (swing, h, steps) = (Swing { m: 0.2, k: 1.5, s: 0.3 }, 0.25, 40);
    let start = |draw: &mut Draw| State::new([0.07 * draw.path() as f64 - 1.5], [0.5 * draw.normal()]);
    let run = || swing.ensemble::<Gauss<3>>(h).starts(start).seed(8);
    let (ends, reference) = ends!(run(), PATHS, steps);
    let mut sweeps = [u32::MAX, 0];
    for (path, end) in ends.iter().enumerate() {
        let mut state = *run().paths(PATHS as u64).steps(0).replay(path as u64).unwrap().0.last();
        let noise = StepNormals::seed(8).path(path as u64);
        let (infos, error) = stepped::<Gauss<3>, _>(&swing, h, &mut state, noise, steps);
        assert_eq!((state.q, state.p, error), (end.q, end.p, None), "path {path}");
        for info in infos {
            sweeps = [sweeps[0].min(info.iterations), sweeps[1].max(info.iterations)];
        }
    }
    assert!(sweeps[0] + 3 < sweeps[1], "{sweeps:?} sweeps: no path waits for another");
    assert!(run().paths(PATHS as u64).steps(steps).threads(2).run().unwrap() == reference);
}
