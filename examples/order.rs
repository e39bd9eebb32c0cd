//! The best scheme for each target error: the pendulum from (2, 0) to T = 100 against its exact solution, by every scheme, with the
//! number of steps that each target requires.
//!
//! ```text
//! cargo run --release --example order
//! ```

#![allow(clippy::print_stdout, reason = "an example talks")]

use std::time::Instant;

use wzvi::nalgebra::SVector;
use wzvi::prelude::*;

/// `H = p²/2 - cos q`
#[hamiltonian(drift = |q, p| 0.5 * p * p - q.cos(), embedding = [Midpoint, Verlet, Gauss<2>, Gauss<4>, Gauss<8>, Gauss<16>])]
struct Pendulum;

/// The state at T = 100, to 25 digits rounded: the elliptic functions of the pendulum.
const EXACT: [f64; 2] = [1.982_325_653_157_030_5, 0.179_640_742_590_940_2];
const END: f64 = 100.0;

/// Target errors.
const WANTED: [f64; 4] = [1e-3, 1e-6, 1e-9, 1e-12];

/// One run: its error, the time per unit of time in nanoseconds, and iterations per step.
fn run<E>(steps: u32) -> Result<(f64, f64, f64), wzvi::Error>
where
    Pendulum: Discretized<E, Vector = SVector<f64, 1>>,
{
    let mut fastest = f64::INFINITY;
    let (mut error, mut iterations) = (0.0, 0);
    for _ in 0..5 {
        let mut stepper = Pendulum.stepper::<E>(END / f64::from(steps))?;
        let mut state = State::new([2.0], [0.0]);
        iterations = 0;
        let clock = Instant::now();
        for _ in 0..steps {
            iterations += stepper.step(&mut state, &[])?.iterations;
        }
        fastest = fastest.min(clock.elapsed().as_secs_f64());
        error = (state.q[0] - EXACT[0]).hypot(state.p[0] - EXACT[1]);
    }
    Ok((error, fastest * 1e9 / END, f64::from(iterations) / f64::from(steps)))
}

/// The cheapest run for each target error, by doubling and then by bisection of the number of steps.
fn row<E>(name: &str) -> Result<(), wzvi::Error>
where
    Pendulum: Discretized<E, Vector = SVector<f64, 1>>,
{
    print!("{name:30}");
    for wanted in WANTED {
        let mut steps = 16;
        while steps < 4_000_000 && !(run::<E>(steps).is_ok_and(|(error, ..)| error <= wanted)) {
            steps *= 2;
        }
        if steps >= 4_000_000 {
            print!("{:>20}", "-");
            continue;
        }
        let (mut few, mut enough) = (steps / 2, steps);
        while enough - few > 1 + enough / 32 {
            let middle = few.midpoint(enough);
            if run::<E>(middle).is_ok_and(|(error, ..)| error <= wanted) {
                enough = middle
            } else {
                few = middle
            }
        }
        let (_, time, _) = run::<E>(enough)?;
        print!("{:>20}", format!("{time:.0} ns ({enough})"));
    }
    println!();
    Ok(())
}

fn main() -> Result<(), wzvi::Error> {
    println!(
        "Pendulum from (2, 0) to T = {END}: time per unit of time, and the number of steps, for an error of"
    );
    print!("{:30}", "");
    WANTED.iter().for_each(|wanted| print!("{wanted:>20.0e}"));
    println!();
    row::<Midpoint>("Midpoint")?;
    row::<Verlet>("Verlet")?;
    row::<Composed<Verlet, Suzuki4>>("Composed<Verlet, Suzuki4>")?;
    row::<Composed<Verlet, Chin4>>("Composed<Verlet, Chin4>")?;
    row::<Composed<Verlet, BlanesMoan4>>("Composed<Verlet, BlanesMoan4>")?;
    row::<Composed<Verlet, BlanesMoan6>>("Composed<Verlet, BlanesMoan6>")?;
    row::<Composed<Verlet, KahanLi8>>("Composed<Verlet, KahanLi8>")?;
    row::<Gauss<2>>("Gauss<2>")?;
    row::<Gauss<4>>("Gauss<4>")?;
    row::<Gauss<8>>("Gauss<8>")?;
    row::<Gauss<16>>("Gauss<16>")?;
    Ok(())
}
