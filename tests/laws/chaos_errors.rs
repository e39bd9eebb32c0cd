//! Errors of Lyapunov exponents: how often they cover the exponent of the chaotic sea.

use fixtures::small::HenonHeiles;
use wzvi::nalgebra::SVector;
use wzvi::prelude::*;

/// Length of a run.
const T: f64 = 1e4;
/// The mean exponent of runs of this length in the sea at energy 1/8, with an error of 0.0007: 200 runs by a scheme of order 8,
/// `Composed<Verlet, KahanLi8>` with h = 1/4. Single runs scatter by 0.009.
const MEAN: f64 = 0.0485;
const RUNS: usize = 64;

/// States in the sea, from one path that is longer than all runs together, so that no two runs share a stretch.
fn starts() -> Vec<State<SVector<f64, 2>>> {
    let apart = (10.0 * T) as u64;
    let path = HenonHeiles.simulate::<Verlet>(0.1).start(State::new([0.0, -0.25], [0.42081, 0.0]));
    let path = path.steps(apart * RUNS as u64).record_every(apart).run().unwrap();
    path.states().iter().skip(1).map(|state| State { t: 0.0, ..*state }).collect()
}

/// The error is the standard deviation of nine exponents, that of the run among them. If they were independent and normal,
/// the mean would be within one error in 66 % of the runs, and within two in 92 % (the law of Student for 8 degrees of freedom).
/// Exponents of single runs have a tail towards small values: four binomial deviations are allowed.
#[test]
fn errors_of_exponents_cover_the_mean_of_the_sea() {
    let starts = starts();
    let off = |start: &State<SVector<f64, 2>>| {
        let spectrum = HenonHeiles.simulate::<Verlet>(0.1).start(*start).until(T).lyapunov_of(1).unwrap();
        Some((spectrum.values[0] - MEAN).abs() / spectrum.errors?[0])
    };
    let off: Vec<f64> = std::thread::scope(|scope| {
        let halves = starts.chunks(RUNS / 2);
        let threads: Vec<_> =
            halves.map(|half| scope.spawn(move || half.iter().filter_map(off).collect::<Vec<_>>())).collect();
        threads.into_iter().flat_map(|thread| thread.join().unwrap()).collect()
    });
    // A run whose copies leave it late has no error.
    assert!(off.len() > RUNS / 2, "{} of {RUNS} runs have an error", off.len());
    let known = off.len() as f64;
    for (errors, share) in [(1.0, 0.66), (2.0, 0.92)] {
        let within = off.iter().filter(|&&off| off < errors).count() as f64;
        let deviation = (known * share * (1.0 - share)).sqrt();
        println!(
            "{within} of {known} within {errors} errors, {:.1} ± {deviation:.1} expected",
            known * share
        );
        assert!(
            (within - known * share).abs() < 4.0 * deviation,
            "{within} of {known} within {errors} errors"
        );
    }
}
