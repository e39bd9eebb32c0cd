//! Observables that a system declares, and the quantities of a system by their names.

use wzvi::prelude::*;
use wzvi::system::Quantity;

/// A spring in the plane.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) + 0.5 * k * (x * x + y * y),
    noise = [|[x, y], [px, py]| sigma * (x * py - y * px)],
    invariant = [momentum = |[x, y], [px, py]| x * py - y * px],
    observe = [
        radius = |[x, y], _| x.hypot(y),
        side = |[x, y], _, t| if t > 0.05 { x.signum() } else { 2.0 * y.signum() },
        tension = |[x, y], _| k * distance(x, y),
    ],
    embedding = [Midpoint, Gauss<2>],
)]
#[derive(Clone)]
struct Spring {
    k: f64,
    sigma: f64,
}

#[hamiltonian_fn]
fn distance(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

/// The same without observables.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) + 0.5 * k * (x * x + y * y),
    noise = [|[x, y], [px, py]| sigma * (x * py - y * px)],
    invariant = [momentum = |[x, y], [px, py]| x * py - y * px],
    embedding = [Midpoint, Gauss<2>],
)]
struct Unobserved {
    k: f64,
    sigma: f64,
}

/// A chain of any length.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| p.iter().map(|p| 0.5 * p * p).sum::<f64>()
        + q.windows(2).map(|q| 1.0 - (q[1] - q[0]).cos()).sum::<f64>(),
    observe = [
        length = |q, _| q[q.len() - 1] - q[0],
        roughness = |q, _| q.windows(2).map(|q| (q[1] - q[0]).abs()).sum::<f64>(),
        gyration = |q, _| (q.iter().map(|q| weight * q * q).sum::<f64>() / q.len() as f64).sqrt(),
        site = |q, _| q[watched],
    ],
    embedding = [Verlet, Midpoint],
)]
struct Chain {
    weight: f64,
    watched: usize,
}

/// The same without observables.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| p.iter().map(|p| 0.5 * p * p).sum::<f64>()
        + q.windows(2).map(|q| 1.0 - (q[1] - q[0]).cos()).sum::<f64>(),
    embedding = [Verlet, Midpoint],
)]
struct UnobservedChain;

/// Points in the plane.
#[hamiltonian(
    drift = |q: [[f64; 2]; N], p: [[f64; 2]; N]| (0..N).map(|i| {
        0.5 * mass[i] * (p[i][0] * p[i][0] + p[i][1] * p[i][1] + q[i][0] * q[i][0] + q[i][1] * q[i][1])
    }).sum::<f64>(),
    observe = [
        centre = |q, _| (0..N).map(|i| mass[i] * q[i][0]).sum::<f64>() / mass.iter().sum::<f64>(),
        spread = |q, _| (0..N).map(|i| q[i][0].max(q[i][1])).sum::<f64>().abs(),
    ],
    embedding = Verlet,
)]
struct Points<const N: usize> {
    mass: [f64; N],
}

fn spring() -> Spring {
    Spring { k: 4.0, sigma: 0.25 }
}

fn bits<V: wzvi::state::Vector>(state: &State<V>) -> Vec<u64> {
    state.q.components().iter().chain(state.p.components()).map(|x| x.to_bits()).collect()
}

#[test]
fn observables_have_the_values_of_their_closures() {
    let (system, state) = (spring(), State::new([-0.3, 0.4], [0.1, 0.7]));
    assert_eq!((system.observables(), system.invariants()), (3, 1));
    assert_eq!(system.variables().observables, ["radius", "side", "tension"]);
    let values = |state: &_| [0, 1, 2].map(|i| system.observable(i, state));
    assert_eq!(values(&state), [(-0.3_f64).hypot(0.4), 2.0, 4.0 * (0.3_f64 * 0.3 + 0.4 * 0.4).sqrt()]);
    assert_eq!(values(&state.at(0.1))[1], -1.0);
    assert!(system.observable(3, &State::new([0.0; 2], [0.0; 2])).is_nan());
}

#[test]
fn observables_of_loops_have_the_values_of_their_closures() {
    let chain = Chain { weight: 2.0, watched: 3 };
    for n in [4, 37] {
        let q: Vec<f64> = (0..n).map(|i| (0.7 * i as f64).sin()).collect();
        let state = State::new(q.clone(), vec![0.0; n]);
        let roughness: f64 = q.windows(2).map(|q| (q[1] - q[0]).abs()).sum();
        let gyration = (q.iter().map(|q| 2.0 * q * q).sum::<f64>() / n as f64).sqrt();
        let expected = [q[n - 1] - q[0], roughness, gyration, q[3]];
        for (i, expected) in expected.into_iter().enumerate() {
            // Sums have another order.
            let found = chain.observable(i, &state);
            assert!((found - expected).abs() <= 1e-14 * (1.0 + expected.abs()), "{n}, {i}: {found}");
        }
    }
    assert!(
        chain.observable(0, &State::new(vec![0.0; 3], vec![0.0; 3])).is_nan(),
        "`watched` is out of range"
    );

    let points = Points { mass: [1.0, 3.0, 4.0] };
    let state = State::new([1.0, -1.0, 2.0, 3.0, -0.5, -4.0], [0.0; 6]);
    assert_eq!(points.observable(0, &state), (1.0 + 6.0 - 2.0) / 8.0);
    assert_eq!(points.observable(1, &state), 1.0 + 3.0 - 0.5);
}

#[test]
fn steps_are_the_same_with_and_without_observables() {
    fn spring_path<E>(system: &impl Discretized<E, Vector = wzvi::nalgebra::SVector<f64, 2>>) -> Vec<u64> {
        let run = system.simulate::<E>(0.1).start(State::new([-0.3, 0.4], [0.1, 0.7]));
        bits(run.noise(Wiener::seed(5)).steps(20).run().unwrap().last())
    }
    fn chain_path<E>(system: &impl Discretized<E, Vector = wzvi::nalgebra::DVector<f64>>) -> Vec<u64> {
        let q: Vec<f64> = (0..9).map(|i| (0.7 * f64::from(i)).sin()).collect();
        let run = system.simulate::<E>(0.1).start(State::new(q, vec![0.1; 9]));
        bits(run.steps(20).run().unwrap().last())
    }
    let (spring, unobserved) = (spring(), Unobserved { k: 4.0, sigma: 0.25 });
    assert_eq!(spring_path::<Midpoint>(&spring), spring_path::<Midpoint>(&unobserved));
    assert_eq!(spring_path::<Gauss<2>>(&spring), spring_path::<Gauss<2>>(&unobserved));
    let chain = Chain { weight: 2.0, watched: 3 };
    assert_eq!(chain_path::<Verlet>(&chain), chain_path::<Verlet>(&UnobservedChain));
    assert_eq!(chain_path::<Midpoint>(&chain), chain_path::<Midpoint>(&UnobservedChain));

    fn text<H: Discretized<E>, E>() -> (&'static str, String) {
        (H::EQUATIONS, format!("{:?}", H::PLAN))
    }
    assert_eq!(text::<Spring, Midpoint>(), text::<Unobserved, Midpoint>());
    assert_eq!(text::<Chain, Midpoint>(), text::<UnobservedChain, Midpoint>());
}

#[test]
fn tables_and_plots_have_the_declared_observables() {
    let system = spring();
    let run =
        system.simulate::<Midpoint>(0.1).start(State::new([-0.3, 0.4], [0.1, 0.7])).noise(Wiener::seed(5));
    let path = run.steps(4).run().unwrap();
    let table = path.table().energies(&system).into_table();
    let names: Vec<&str> = table.columns().iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names[5..], ["energy", "momentum", "radius", "side", "tension"]);
    let figure = format!("{:?}", path.plot().observables(&system));
    assert!(["radius", "side", "tension"].iter().all(|name| figure.contains(name)), "{figure}");
}

#[test]
fn quantities_have_names() {
    let (system, state) = (spring(), State::new([-0.3, 0.4], [0.1, 0.7]).at(0.5));
    let named = |name| Quantity::named(&system, 2, name).unwrap();
    let all: Vec<(String, Quantity)> = Quantity::all(&system, 2).collect();
    let names: Vec<&str> = all.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["t", "x", "y", "px", "py", "energy", "momentum", "radius", "side", "tension"]);
    assert!(all.iter().all(|(name, quantity)| named(name) == *quantity));
    assert_eq!(
        [named("t"), named("y"), named("px")],
        [Quantity::Time, Quantity::Coordinate(1), Quantity::Momentum(0)]
    );
    assert_eq!(
        [named("energy"), named("momentum"), named("side")],
        [Quantity::Energy, Quantity::Invariant(0), Quantity::Observable(1)]
    );
    let values =
        ["t", "y", "px", "energy", "momentum", "side"].map(|name| named(name).value(&system, &state));
    let expected = [0.5, 0.4, 0.1, system.energy(&state), system.invariant(0, &state), -1.0];
    assert_eq!(values, expected);
    assert!(Quantity::Momentum(2).value(&system, &state).is_nan());

    let unknown = Quantity::named(&system, 2, "vx").unwrap_err().to_string();
    let known = "`t`, `x`, `y`, `px`, `py`, `energy`, `momentum`, `radius`, `side`, `tension`";
    assert_eq!(unknown, format!("no quantity has the name `vx`: there are {known}"));

    let chain = Chain { weight: 2.0, watched: 3 };
    assert_eq!(Quantity::named(&chain, 5000, "p[4711]"), Ok(Quantity::Momentum(4711)));
    assert!(Quantity::named(&chain, 5000, "p[5000]").is_err());
}

/// A coordinate with the name of the energy.
#[hamiltonian(
    drift = |energy, p| 0.5 * (p * p + energy * energy),
    embedding = Midpoint,
)]
struct Confused;

#[test]
fn a_variable_keeps_its_name() {
    assert_eq!(Quantity::named(&Confused, 1, "energy"), Ok(Quantity::Coordinate(0)));
    assert_eq!(Quantity::named(&Confused, 1, "energy_"), Ok(Quantity::Energy));
}

#[test]
fn ensembles_observe_quantities_of_their_own_systems() {
    let start = State::new([-0.3, 0.4], [0.1, 0.7]);
    let common = spring();
    let systems = || {
        let run = common.ensemble::<Midpoint>(0.1).start(start.clone()).paths(3).steps(2).seed(1);
        run.systems(|draw| Spring { k: 1.0 + draw.path() as f64, sigma: 0.25 })
    };
    let by_default = systems().keep_paths(1 << 20).run().unwrap();
    assert_eq!(by_default.observables(), ["x", "y", "px", "py", "energy", "radius", "side", "tension"]);
    let tension = Quantity::named(&common, 2, "tension").unwrap();
    let asked = systems().observe_quantity("pull", tension).keep_paths(1 << 20).run().unwrap();
    for path in 0..3 {
        let expected = (1.0 + path as f64) * (0.3_f64 * 0.3 + 0.4 * 0.4).sqrt();
        for (run, name) in [(&by_default, "tension"), (&asked, "pull")] {
            let place = run.index(name).unwrap();
            assert_eq!(run.paths().unwrap().at(path, 0).unwrap()[place], expected, "{name} of path {path}");
        }
    }
    let one = common.simulate::<Midpoint>(0.1).start(start).noise(Wiener::seed(5)).steps(2);
    let path = one.observe_quantity("pull", tension).run().unwrap();
    let values: Vec<f64> = path.iter().map(|state| common.observable(2, state)).collect();
    assert_eq!(path.observed("pull").unwrap(), values);
}
