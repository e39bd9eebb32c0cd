use wzvi::prelude::*;

#[hamiltonian(drift = |q, p| 0.5 * p * p - q.cos(), embedding = Midpoint)]
struct Pendulum;

fn main() {
    let run = Pendulum.simulate::<Midpoint>(0.1).start(State::new([1.0], [0.0])).steps(3);
    let _ = run.observe("energy", |state| state.energy()).run();
}
