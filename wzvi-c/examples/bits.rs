//! Prints the numbers of paths and ensembles of the example `systems` as hexadecimal words. The C program and the Python
//! package print the same ones.

#![forbid(unsafe_code)]

use wzvi::prelude::*;
use wzvi::state::Vector;
use wzvi::trajectory::Trajectory;

#[path = "systems/definitions.rs"]
mod definitions;

use definitions::{Kubo, Network, Pendulum};

fn main() -> Result<(), wzvi::Error> {
    let kubo = Kubo { a: 1.5, sigma: 1.0 };
    let start = State::new([0.0], [1.0]);
    print_path(&kubo.simulate::<Midpoint>(0.02).start(start).noise(Wiener::seed(7)).until(2.0).run()?);
    for threads in 1..=3 {
        let run =
            kubo.ensemble::<Midpoint>(0.02).start(start).paths(3000).seed(7).until(2.0).threads(threads);
        let radius = |state: &SystemState<Kubo>| (state.q[0] * state.q[0] + state.p[0] * state.p[0]).sqrt();
        let statistics = run.observe("q", |state| state.q[0]).observe("radius", radius).run()?;
        print(statistics.nodes().iter().flat_map(|node| [node.mean(0), node.mean(1)]));
        print(statistics.nodes().iter().flat_map(|node| [node.standard_error(0), node.standard_error(1)]));
    }
    let pendulum = Pendulum { g: 9.81 };
    print_path(&pendulum.simulate::<Midpoint>(0.01).start(State::new([2.0], [0.0])).until(10.0).run()?);
    let network = Network { k: 2.0, springs: vec![[0, 1], [1, 2], [2, 3], [3, 0]] };
    let start = State::new(vec![1.0, 0.0, 0.0, 0.0], vec![0.0, 0.0, 0.0, 0.5]);
    print_path(&network.simulate::<Verlet>(0.05).start(start).until(5.0).run()?);
    Ok(())
}

/// All coordinates, then all momenta.
fn print_path<V: Vector, E>(path: &Trajectory<V, E>) {
    print(path.iter().flat_map(|state| state.q.components()).copied());
    print(path.iter().flat_map(|state| state.p.components()).copied());
}

fn print(numbers: impl Iterator<Item = f64>) {
    numbers.for_each(|number| println!("{:016x}", number.to_bits()));
}
