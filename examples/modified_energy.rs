//! Is the step short enough for the theory? A symplectic step nearly conserves a modified Hamiltonian if it is. The pendulum from (2, 0) to T = 1000,
//! by several schemes, with steps for which the theory holds, and steps for which it does not.
//!
//! ```text
//! cargo run --release --example modified_energy
//! ```

#![allow(clippy::print_stdout, reason = "an example talks")]

use wzvi::modified::ModifiedBy;
use wzvi::nalgebra::SVector;
use wzvi::prelude::*;

/// `H = p²/2 - cos q`
#[hamiltonian(drift = |q, p| 0.5 * p * p - q.cos(), embedding = [DeltaPlus, Midpoint, Verlet])]
struct Pendulum;

const END: f64 = 1000.0;
const STEPS: [f64; 6] = [1.6, 0.8, 0.4, 0.2, 0.1, 0.05];

/// The largest changes of the energy and of the modified energy, for each step size.
fn row<E: ModifiedBy>(name: &str) -> Result<(), wzvi::Error>
where
    Pendulum: Discretized<E, Vector = SVector<f64, 1>>,
{
    let mut drifts = Vec::new();
    for h in STEPS {
        // The longest steps are too long, as the table shows.
        let run = Pendulum.simulate::<E>(h).start(State::new([2.0], [0.0])).until(END).unwatched();
        let path = run.run()?;
        drifts.push([path.energy_drift(&Pendulum), path.shadow_energy_drift(&Pendulum)]);
    }
    for (line, what) in [(0, "energy"), (1, "modified energy")] {
        print!("{:30} {what:16}", if line == 0 { name } else { "" });
        drifts.iter().for_each(|drift| print!("{:>9}", format!("{:.1e}", drift[line])));
        println!();
    }
    Ok(())
}

fn main() -> Result<(), wzvi::Error> {
    println!(
        "Pendulum from (2, 0) to T = {END}: largest change of the energy and of the modified energy, h ="
    );
    print!("{:47}", "");
    STEPS.iter().for_each(|h| print!("{h:>9}"));
    println!();
    row::<DeltaPlus>("DeltaPlus")?;
    row::<Midpoint>("Midpoint")?;
    row::<Verlet>("Verlet")?;
    row::<Composed<Midpoint, Suzuki4>>("Composed<Midpoint, Suzuki4>")?;
    row::<Composed<Verlet, Yoshida4>>("Composed<Verlet, Yoshida4>")?;
    row::<Composed<Verlet, Suzuki4>>("Composed<Verlet, Suzuki4>")?;
    row::<Composed<Verlet, BlanesMoan4>>("Composed<Verlet, BlanesMoan4>")?;
    row::<Composed<Verlet, KahanLi6>>("Composed<Verlet, KahanLi6>")
}
