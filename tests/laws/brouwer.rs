//! Rounding makes the energy of a long run walk at random (Brouwer's law), whatever the units are: errors of single steps do not add up.
//!
//! With `e(n)` the change of the energy after `n` steps, relative to it, the root mean square of `e` over the orbits of an ensemble grows like `√n`, and
//! its mean is zero. A stopping rule that compares unknowns of different size leaves the same error in every step, which grows like `n`.

use wzvi::prelude::*;

/// A planet.
#[hamiltonian(drift = |[x, y], [px, py]| (px * px + py * py) / (2.0 * m) - k / x.hypot(y), embedding = Gauss<8>)]
struct Planet {
    m: f64,
    k: f64,
}

/// A pendulum of mass `m` and length `l`, by its angle.
#[hamiltonian(
    drift = |angle, momentum| momentum * momentum / (2.0 * m * l * l) - m * g * l * angle.cos(),
    embedding = Gauss<4>,
)]
struct Pendulum {
    m: f64,
    l: f64,
    g: f64,
}

/// A particle in a well that stiffens outwards.
#[hamiltonian(drift = |q, p| 0.5 * p * p + 0.5 * q * q + 0.25 * q * q * q * q, embedding = Gauss<8>)]
struct Well;

const PATHS: usize = 64;
/// Steps from one recorded node to the next, and nodes.
const EVERY: u64 = 5_000;
const NODES: usize = 100;

/// The root mean square and the mean of the relative change of the energy, after one stretch of steps and after all.
fn changes<E, H: Discretized<E> + Sync>(system: &H, h: f64, starts: Vec<State<H::Vector>>) -> [[f64; 2]; 2] {
    let run = system.ensemble::<E>(h).starts_from(starts).steps(EVERY * NODES as u64).record_every(EVERY);
    let run = run.observe("energy", |state| system.energy(state)).keep_paths(1 << 20);
    let statistics = run.run_in::<8>().unwrap();
    let paths = statistics.paths().unwrap();
    let energy = |path: usize, node: usize| paths.at(path, node).unwrap()[0];
    [1, NODES].map(|node| {
        let changes: Vec<f64> = (0..PATHS).map(|path| energy(path, node) / energy(path, 0) - 1.0).collect();
        let mean = |of: &dyn Fn(f64) -> f64| changes.iter().map(|&x| of(x)).sum::<f64>() / PATHS as f64;
        [mean(&|x| x * x).sqrt(), mean(&|x| x)]
    })
}

/// A hundred times as many steps change the energy ten times as much, by its root mean square of 64 orbits: it is known to `1/√128`, both to 13 %, and five times that is
/// two thirds. An error that is the same in every step makes it a hundred. The mean is zero to a root mean square divided by eight.
fn walks<E, H: Discretized<E> + Sync>(
    name: &str,
    system: &H,
    h: f64,
    start: impl Fn(f64) -> State<H::Vector>,
) {
    let starts = (0..PATHS).map(|path| start(path as f64 / PATHS as f64)).collect();
    let [[first, _], [last, mean]] = changes::<E, H>(system, h, starts);
    println!(
        "{name}: {first:.1e} after {EVERY} steps, {last:.1e} after {NODES} times as many, mean {mean:.1e}"
    );
    assert!(last < 10.0 * first * (1.0 + 5.0 * 0.13), "{name}: {first:e}, {last:e}");
    assert!(mean.abs() < 4.0 * last / 8.0, "{name}: {mean:e} of {last:e}");
}

/// A thousand steps an orbit of eccentricity 0.7, from its apocentre, of slightly different sizes.
#[test]
fn energies_of_planets_walk_at_random() {
    // The Earth around the Sun: kg, kg m³/s², m.
    let (mass, sun) = (5.972e24, 1.327_124e20);
    for (name, m, k, size) in [("units of one", 1.0, 1.0, 1.0), ("SI", mass, mass * sun, 1.496e11_f64)] {
        let (planet, e) = (Planet { m, k }, 0.7);
        let h = std::f64::consts::TAU * (m * size.powi(3) / k).sqrt() / 1000.0;
        walks::<Gauss<8>, _>(&format!("planet, {name}"), &planet, h, |x| {
            let a = size * (1.0 + 0.1 * x);
            State::new([a * (1.0 + e), 0.0], [0.0, (m * k / a * (1.0 - e) / (1.0 + e)).sqrt()])
        });
    }
}

#[test]
fn energies_of_unequal_scales_walk_at_random() {
    // Momenta of 1e-6, of 1e6 and, for a bob of a microgram on a thread of a metre, in SI units.
    for (name, m, l, g) in [("light", 1e-6, 1.0, 1.0), ("heavy", 1e6, 1.0, 1.0), ("SI", 1e-9, 1.0, 9.81)] {
        let (pendulum, h) = (Pendulum { m, l, g }, std::f64::consts::TAU * (l / g).sqrt() / 100.0);
        let start = |x: f64| State::new([0.5 + 0.7 * x], [0.0]);
        walks::<Gauss<4>, _>(&format!("pendulum, {name}"), &pendulum, h, start);
    }
}

/// Stages in Nyström form are `q + h s`. The double 0.2 is a fifth and a quarter of a rounding: its products with doubles lie at five places between two
/// doubles, off centre, so that their roundings have a mean. It depends on the leading digits of `s`, and the energy drifts: with `h = 0.2` this test
/// fails, with a mean of 8.1e-13. Products with a fraction over a power of two round without bias.
#[test]
fn steps_of_few_bits_round_without_bias() {
    walks::<Gauss<8>, _>("well, h = 13/64", &Well, 13.0 / 64.0, |x| State::new([1.25 + 0.1 * x], [0.0]));
}
