//! Clocks as users may write them, and the schemes that they are for.

use wzvi::clock::Clock;
use wzvi::elements::{Elements, EvaluationPoint, Role};
use wzvi::prelude::*;

/// A value of a role.
fn value<H: Elements>(system: &H, role: Role, [q, p]: [&[f64]; 2], t: f64) -> f64 {
    let at = EvaluationPoint { q, p, t, h: 1.0, parameters: &[], dw: &[], acting: 0..0, scale: 1.0 };
    system.value(role, 1.0, &at)
}

fn is_near(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-13 * expected.abs(), "{found} {expected}");
}

#[hamiltonian_fn]
fn wide(q: f64, a: f64) -> f64 {
    1.0 + a * q * q
}

/// A function of another item, a field and the time.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * q * q,
    clock = |q, _, time| wide(q, self.a) * (2.0 + time.sin()),
    embedding = [Clocked<Verlet>, Clocked<Midpoint>, Extended<Gauss<2>>],
)]
struct Breathing {
    a: f64,
}

const W0: f64 = 0.5;

/// A frequency of a constant, and a field with the name that distances have in the text.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) - r * (x * x + y * y).sqrt().recip(),
    clock = curvature(W0 * self.r),
    embedding = [Verlet, Clocked<Verlet>],
)]
struct Centre {
    r: f64,
}

/// A size that is a const generic, and masses in a slice.
#[hamiltonian(
    drift = |q: [[f64; 2]; N], p: [[f64; 2]; N]| {
        (0..N).map(|i| 0.5 * (p[i][0] * p[i][0] + p[i][1] * p[i][1]) / self.mass[i]).sum::<f64>()
            - (1..N).map(|i| (0..i).map(|j| {
                self.mass[i] * self.mass[j] / (q[i][0] - q[j][0]).hypot(q[i][1] - q[j][1])
            }).sum::<f64>()).sum::<f64>()
    },
    clock = pairs,
    embedding = [Clocked<Verlet>, Extended<Verlet>, Logarithmic<1, 1>],
)]
struct Bodies<'m, const N: usize> {
    mass: &'m [f64],
}

/// Schemes without a list of their own.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) - 1.0 / (x * x + y * y).sqrt(),
    embedding = Logarithmic<3, 2>,
)]
struct Logarithm;

#[hamiltonian(
    drift = [|_, [px, py]| 0.5 * (px * px + py * py), |[x, y], _| -1.0 / (x * x + y * y).sqrt()],
    embedding = Logarithmic<1, 1>,
)]
struct Parted;

/// Noises that leave the clock as it is.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| (0..q.len()).map(|i| 0.5 * (p[i] * p[i] + q[i] * q[i])).sum::<f64>(),
    noise = [|q, p, k| sigma * q[k]; self.sites],
    clock = |q, _| (1.0 + q.iter().map(|q| q * q).sum::<f64>()).sqrt().recip(),
    embedding = Clocked<Verlet>,
)]
struct Driven {
    sigma: f64,
    sites: usize,
}

/// A clock of the energy that both Hamiltonians keep.
#[hamiltonian(
    drift = |q, p| 0.5 * (q * q + p * p),
    noise = |q, p| 0.5 * sigma * (q * q + p * p),
    clock = |q, p| (1.0 + q * q + p * p).sqrt(),
    embedding = Clocked<Midpoint>,
)]
struct Kubo {
    sigma: f64,
}

#[test]
fn clocks_mean_what_is_written() {
    let q = [0.3, -0.2];
    is_near(value(&Breathing { a: 2.0 }, Role::Clock, [&[0.3], &[0.1]], 0.4), 1.18 * (2.0 + 0.4_f64.sin()));
    let centre = Centre { r: 2.0 };
    // The eigenvalues of V'' are 1 and -2 times k/r³.
    let trace = 5.0 * (2.0 / 0.13_f64.powf(1.5)).powi(2) + 1.0;
    is_near(value(&centre, Role::Clock, [&q, &[0.1, 0.2]], 0.0), trace.powf(-0.25));
    assert!(Centre::CLOCK.contains("ϱ = √(x² + y²)"), "{}", Centre::CLOCK);
    let (places, mass) = ([0.0, 0.0, 1.0, 0.0, 0.0, 2.0], [3.0, 4.0, 5.0]);
    let bodies = Bodies::<3> { mass: &mass };
    let squares = 5.0_f64.sqrt() * (7.0 + 8.0 / 8.0 + 9.0 / 5.0_f64.powf(1.5));
    is_near(value(&bodies, Role::Clock, [&places, &[0.0; 6]], 0.0), squares.powf(-0.5));
    // At rest no distance changes.
    assert_eq!(value(&bodies, Role::ClockRate, [&places, &[0.0; 6]], 0.0), 0.0);
    assert_eq!(value(&Kubo { sigma: 0.3 }, Role::ClockRate, [&[0.3], &[0.1]], 0.0), 0.0);
    let driven = Driven { sigma: 0.1, sites: 2 };
    is_near(value(&driven, Role::Clock, [&q, &[0.1, 0.2]], 0.0), 1.13_f64.powf(-0.5));
    // dq/dt = p: G = q · p/(1 + q · q)
    is_near(value(&driven, Role::ClockRate, [&q, &[0.1, 0.2]], 0.0), (0.03 - 0.04) / 1.13);
}

#[test]
fn schemes_with_clocks_are_listed() -> Result<(), wzvi::Error> {
    let start = State::new([1.0, 0.0], [0.0, 1.1]);
    for end in [
        Logarithm.simulate::<Logarithmic<3, 2>>(Eps(0.05)).start(start.clone()).until(1.0).run()?.last().q[0],
        Parted.simulate::<Logarithmic<1, 1>>(Eps(0.05)).start(start.clone()).until(1.0).run()?.last().q[0],
        Centre { r: 1.0 }
            .simulate::<Clocked<Verlet>>(Eps(0.05))
            .start(start.clone())
            .until(1.0)
            .run()?
            .last()
            .q[0],
    ] {
        // One system by three schemes of order two.
        let plain = Logarithm.simulate::<Verlet>(0.001).start(start.clone()).until(1.0).run()?;
        assert!((end - plain.last().q[0]).abs() < 1e-3, "{end} {}", plain.last().q[0]);
    }
    Ok(())
}
