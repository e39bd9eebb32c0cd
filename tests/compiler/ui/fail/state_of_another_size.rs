use wzvi::prelude::*;

#[hamiltonian(drift = |[x, y], [px, py]| 0.5 * (px * px + py * py + x * x + y * y), embedding = Midpoint)]
struct Plane;

fn main() {
    let _ = Plane.simulate::<Midpoint>(0.1).start(State::new([0.0; 3], [1.0; 2])).steps(3).run();
}
