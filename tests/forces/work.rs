//! What forces and baths do to the energy: `H(end) - H(start) = work + heat`, where the work has a part that is the error of the scheme.

use wzvi::nalgebra::SVector;
use wzvi::prelude::*;

/// A forced and damped Duffing oscillator.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * q * q + 0.25 * q.powi(4),
    force = |q, p, t| push * t.cos() - 0.1 * q * q * p,
    friction = gamma,
    embedding = [Midpoint, Verlet, Gauss<2>, Gauss<3>],
)]
#[derive(Clone, Debug)]
struct Duffing {
    pub push: f64,
    pub gamma: f64,
}

/// The same without friction, so that stages give the dense output.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * q * q + 0.25 * q.powi(4),
    force = |q, p, t| push * t.cos() - 0.1 * q * q * p,
    embedding = [Gauss<2>, Gauss<3>],
)]
#[derive(Clone, Debug)]
struct Driven {
    pub push: f64,
}

/// A thermostat under a force that turns: no equilibrium, heat flows out.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) + 0.5 * (x * x + y * y),
    force = |[x, y], _| [-turn * y, turn * x],
    friction = gamma,
    temperature = kt,
    embedding = [Baoab, Thermostat<Midpoint>],
)]
#[derive(Clone, Debug)]
struct Stirred {
    pub turn: f64,
    pub gamma: f64,
    pub kt: f64,
}

/// The shadow work of a run to `t = 6`.
fn imbalance<H, E>(system: &H, h: f64) -> f64
where
    H: Discretized<E, Vector = SVector<f64, 1>>,
{
    let start = State::new([0.5], [0.2]);
    let path = system.simulate::<E>(h).start(start).until(6.0).run().expect("a path");
    assert!(path.work().abs() > 0.01);
    path.shadow_work().expect("an account").abs()
}

#[test]
fn the_balance_has_the_order_of_the_scheme() {
    let (duffing, driven) = (Duffing { push: 0.8, gamma: 0.3 }, Driven { push: 0.8 });
    let order = |errors: [f64; 2]| (errors[0] / errors[1]).log2();
    let midpoint = [0.1, 0.05].map(|h| imbalance::<_, Midpoint>(&duffing, h));
    let verlet = [0.1, 0.05].map(|h| imbalance::<_, Verlet>(&duffing, h));
    let two = [0.2, 0.1].map(|h| imbalance::<_, Gauss<2>>(&driven, h));
    let three = [0.3, 0.15].map(|h| imbalance::<_, Gauss<3>>(&driven, h));
    let damped = [0.2, 0.1].map(|h| imbalance::<_, Gauss<2>>(&duffing, h));
    for (errors, expected) in [(midpoint, 2.0), (verlet, 2.0), (two, 4.0), (three, 6.0), (damped, 4.0)] {
        assert!(order(errors) > expected - 0.5, "{errors:?} {expected}");
    }
}

#[test]
fn what_is_stirred_gives_heat_to_its_bath() {
    let system = Stirred { turn: 0.3, gamma: 1.0, kt: 0.5 };
    let start = State::new([0.5, 0.0], [0.0, 0.0]);
    let run = system.simulate::<Thermostat<Midpoint>>(0.02).start(start).noise(StepNormals::seed(5));
    let path = run.until(4000.0).record_every(0).run().expect("a path");
    // The mid-point keeps the energy, and a linear force works along a straight line as in its middle.
    let shadow = path.shadow_work().expect("an account").abs();
    assert!(shadow < 1e-9 * path.work(), "{shadow} {} {}", path.work(), path.heat());
    // Stationary moments of the linear system: x² + y² has the mean 2c, x py - y px the mean 2l with l γ = turn c, and c = kT + l turn/γ... so that
    // the power turn · 2l is 2 turn² c/γ with c (1 - turn²/γ²) = kT.
    let c = system.kt / (1.0 - (system.turn / system.gamma).powi(2));
    let power = 2.0 * system.turn.powi(2) * c / system.gamma;
    assert!((path.work() / 4000.0 / power - 1.0).abs() < 0.1, "{} {power}", path.work() / 4000.0);
}
