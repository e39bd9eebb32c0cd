//! Names that users give: first integrals, functions of types, states.

use wzvi::prelude::*;

/// A body in a plane; the potential is a function of its type, and one of another.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) + Planet::well(x, y) + Spring::energy(x * x + y * y, k),
    embedding = [Midpoint, Verlet],
    invariant = [momentum = |[x, y], [px, py]| x * py - y * px, |[x, y], [px, py]| 2.0 * (x * py - y * px)],
)]
struct Planet {
    k: f64,
}

#[hamiltonian_fn]
impl Planet {
    fn well(x: f64, y: f64) -> f64 {
        -Planet::inverse(x * x + y * y).sqrt()
    }

    fn inverse(x: f64) -> f64 {
        1.0 / x
    }
}

struct Spring;

#[hamiltonian_fn]
impl Spring {
    fn energy(squared: f64, k: f64) -> f64 {
        k * Spring::half(squared)
    }

    fn half(x: f64) -> f64 {
        Self::share(2.0) * x
    }

    fn share(parts: f64) -> f64 {
        1.0 / parts
    }
}

/// The same in loops.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| p.iter().map(|p| 0.5 * p * p).sum::<f64>()
        + (1..q.len()).map(|i| Spring::energy((q[i] - q[i - 1]).powi(2), 1.0)).sum::<f64>(),
    embedding = Verlet,
    invariant = [total = |q: &[f64], p: &[f64]| p.iter().sum::<f64>()],
)]
struct Chain;

const PLANET: Planet = Planet { k: 0.25 };

/// A function that names the type of a state.
fn distance(state: &SystemState<Planet>) -> f64 {
    state.q.norm()
}

/// One that is generic over the system.
fn first<H: Hamiltonian>(state: &SystemState<H>) -> f64
where
    H::Vector: wzvi::state::Vector,
{
    wzvi::state::Vector::components(&state.q)[0]
}

#[test]
fn functions_of_types_are_seen_through() {
    let state = State::new([3.0, 4.0], [1.0, 0.0]);
    assert_eq!(distance(&state), 5.0);
    assert_eq!(first::<Planet>(&state), 3.0);
    // 1/2 - 1/5 + 25/8
    assert!((PLANET.energy(&state) - 3.425).abs() <= 4.0 * f64::EPSILON);
}

#[test]
fn first_integrals_have_names_in_equations_and_tables() {
    assert_eq!(PLANET.variables().invariants, ["momentum", ""]);
    assert_eq!(Chain.variables().invariants, ["total"]);
    let text = <Planet as Discretized<Verlet>>::EQUATIONS;
    assert!(text.contains("first integral momentum = "), "{text}");
    let run =
        PLANET.simulate::<Verlet>(0.1).start(State::new([1.0, 0.0], [0.0, 1.0])).until(1.0).run().unwrap();
    let table = run.table().energies(&PLANET).into_table();
    let mut file = Vec::new();
    table.write_csv(&mut file).unwrap();
    let header = String::from_utf8(file).unwrap().lines().next().unwrap().to_owned();
    assert_eq!(header, "t,x,y,px,py,energy,momentum,invariant_1");
    let run = Chain
        .simulate::<Verlet>(0.1)
        .start(State::new(vec![0.0, 1.0], vec![0.0, 0.0]))
        .until(1.0)
        .run()
        .unwrap();
    let table = run.table().energies(&Chain).into_table();
    let mut file = Vec::new();
    table.write_csv(&mut file).unwrap();
    assert!(String::from_utf8(file).unwrap().starts_with("t,q[0],q[1],p[0],p[1],energy,total\n"));
}

#[test]
fn the_halves_of_verlet_are_called_by_their_names() {
    let text = <Planet as Discretized<Verlet>>::EQUATIONS;
    assert!(
        text.contains("\nDeltaPlus\n") && text.contains("\nDeltaMinus\n") && !text.contains("Uncorrected"),
        "{text}"
    );
}
