//! Options that make no sense together are not offered.

use wzvi::prelude::*;

#[hamiltonian(
    drift = |q, p| 0.5 * (q * q + p * p),
    noise = [|q, p| 0.5 * s * (q * q + p * p)],
    embedding = Midpoint,
)]
struct Kubo {
    s: f64,
}

fn main() {
    let kubo = Kubo { s: 1.0 };
    let paths = || kubo.ensemble::<Midpoint>(0.1).start(State::new([0.0], [1.0])).steps(2).paths(4);
    let levels = || kubo.multilevel::<Midpoint>(0.1).start(State::new([0.0], [1.0])).steps(2).seed(1);

    // Antithetic and truncated normals are those of a seed; another noise says it itself.
    let _ = paths().noise(Wiener::seed(1)).antithetic();
    let _ = paths().noise(Wiener::seed(1)).truncation(wzvi::noise::Truncation::Off);
    // One observable, and nothing but its mean.
    let _ = levels().target(1e-2).run();
    let _ = levels().observe("q", |state| state.q[0]).observe("p", |state| state.p[0]);
    let _ = levels().noise(Wiener::seed(1));
    let _ = levels().allow_losses(0.5);
    let _ = levels().antithetic();
    let _ = levels().covariances(false);
    let _ = levels().first_passage("event", |state| state.q[0]);
    let _ = levels().histogram("q", 0.0, 1.0, 10);
    let _ = levels().keep_paths(1000);
    let _ = levels().quantiles();
    let _ = levels().record_at([0.1]);
    let _ = levels().record_every(1);
    let _ = levels().retry(Retry::halving(2));
    let _ = levels().until_error("q", 1e-2);
}
