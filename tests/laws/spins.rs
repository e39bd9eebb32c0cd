//! Spins as pairs of oscillators: long runs, and exact laws in random fields.

use fixtures::larger;
use fixtures::spins::{self, Ring, some_start};
use wzvi::prelude::*;

/// Without noise the energy oscillates by `O(h²)` and does not drift: the means of both halves of the run differ by far less.
#[test]
fn lengths_and_energy_over_a_million_steps() {
    spins::energies_with_constant_lengths(0.3, 1_000_000);
    let energies = spins::energies_with_constant_lengths(0.0, 1_000_000);
    let worst = energies.iter().map(|energy| (energy - energies[0]).abs()).fold(0.0, larger);
    let (first, second) = energies.split_at(energies.len() / 2);
    let mean = |list: &[f64]| list.iter().sum::<f64>() / list.len() as f64;
    let drift = (mean(second) - mean(first)).abs();
    println!("energy within {worst:.1e} of {:.3}, drift {drift:.1e}", energies[0]);
    assert!(worst < 0.02 * energies[0].abs() && drift < 0.1 * worst, "{worst:.1e} {drift:.1e}");
}

/// Every bond decays by the double brackets of its six noises: `E H_0(t) = H_0(0) e^{-2σ²t}`, in the sense of Stratonovich. A
/// step turns a spin by `4 atan(x/4)` where the exact angle is `x`, whose mean square is smaller by a part `σ²h/4` or so. At
/// h = 0.02 that is 0.0005, and the exponent is 0.72.
#[test]
fn the_mean_energy_in_random_fields_decays_exactly() {
    let (ring, start) = (Ring::new(6, 0.3), some_start(6));
    let first = ring.energy(&start);
    let run = ring.ensemble::<Midpoint>(0.02).start(start).paths(20_000).seed(5).until(4.0);
    let statistics = run.observe("energy", |state| ring.energy(state)).run().unwrap();
    let (mean, error) = (statistics.mean("energy").unwrap(), statistics.standard_error("energy").unwrap());
    let expected = first * (-2.0 * 0.09 * 4.0_f64).exp();
    println!("{mean:.4} ± {error:.4}, expected {expected:.4}");
    assert!((mean - expected).abs() < 4.0 * error + 5e-4 * expected.abs(), "{mean} {error} {expected}");
    assert!(error < 0.01 * first.abs());
}

/// Uniform spins stay uniform, exactly, whatever the step: the step keeps the volume of phase space and all lengths. Bonds are
/// independent of each other, with the mean square 1/3.
#[test]
fn uniform_spins_stay_uniform() {
    let ring = Ring::new(6, 0.3);
    // A normal vector of four numbers has a uniform spin.
    let uniform = |draw: &mut wzvi::ensemble::Draw| {
        let mut site = || {
            let z = wzvi::nalgebra::Vector4::from_fn(|_, _| draw.normal()).normalize() * 2.0;
            ([z[0], z[1]], [z[2], z[3]])
        };
        let (q, p): (Vec<_>, Vec<_>) = (0..6).map(|_| site()).unzip();
        State::new(q, p)
    };
    let run = ring.ensemble::<Midpoint>(0.4).starts(uniform).paths(10_000).seed(6).until(12.0);
    let run = run.observe("H", |state| ring.energy(state)).observe("H²", |state| ring.energy(state).powi(2));
    let statistics = run.observe("z²", |state| spins::spins(state)[0][2].powi(2)).run().unwrap();
    for (name, expected) in [("H", 0.0), ("H²", 2.0), ("z²", 1.0 / 3.0)] {
        let (mean, error) = (statistics.mean(name).unwrap(), statistics.standard_error(name).unwrap());
        println!("{name}: {mean:.4} ± {error:.4}, expected {expected:.4}");
        assert!((mean - expected).abs() < 4.0 * error && error < 0.03, "{name}: {mean} {error}");
    }
}
