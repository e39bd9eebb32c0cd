//! A double well on the ranks of an MPI communicator: the fraction of paths that have crossed the barrier, the same bits on
//! any number of ranks, and a checkpoint from which a killed run resumes. See `docs/guide/cluster.md`.
//!
//! `cargo build --release --features mpi --example cluster`, then
//! `mpirun -n 4 target/release/examples/cluster [paths [steps [checkpoint]]]`

use std::hash::{DefaultHasher, Hash, Hasher};
use std::time::Instant;

use wzvi::mpi::{self, Threading, traits::Communicator};
use wzvi::prelude::*;

/// A particle between two wells, driven by a multiplicative noise: Newton's method in every step.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.25 * (q * q - 1.0).powi(2),
    noise = [|q, p| sigma * q * p],
    embedding = [Midpoint],
)]
struct DoubleWell {
    /// Intensity of the noise.
    sigma: f64,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (universe, _) = mpi::initialize_with_threading(Threading::Funneled).ok_or("MPI runs already")?;
    let world = universe.world();
    let mut arguments = std::env::args().skip(1);
    let paths: u64 = arguments.next().map_or(Ok(200_000), |text| text.parse())?;
    let steps: u64 = arguments.next().map_or(Ok(500), |text| text.parse())?;
    let checkpoint = arguments.next();

    let well = DoubleWell { sigma: 0.3 };
    let mut run = well
        .ensemble::<Midpoint>(0.02)
        .start(State::new([-1.0], [0.0]))
        .paths(paths)
        .seed(7)
        .steps(steps)
        .record_every(steps.div_ceil(5))
        .observe("q", |state| state.q[0])
        .observe("crossed", |state| f64::from(u8::from(state.q[0] > 0.0)))
        .first_passage("barrier", |state| state.q[0]);
    if let Some(file) = checkpoint {
        run = run.checkpoint(Checkpoint::to(file));
    }
    let began = Instant::now();
    // Rank 0 has the statistics, and is the one that prints.
    let Some(statistics) = run.run_on(&world)? else { return Ok(()) };
    let seconds = began.elapsed().as_secs_f64();

    for node in statistics.nodes() {
        let (crossed, error) = (node.mean(1), node.standard_error(1));
        println!("t = {:5.2}: a fraction of {crossed:.5} ± {error:.5} in the right well", node.time());
    }
    let mut bits = DefaultHasher::new();
    format!("{statistics:?}").hash(&mut bits);
    println!(
        "{} ranks: {seconds:.2} s, {:.2} ns per path-step; all statistics hash to {:016x}",
        world.size(),
        1e9 * seconds / (paths * steps) as f64,
        bits.finish()
    );
    Ok(())
}
