//! Steps of systems in loops are the same in all units, as those of small systems are (`tests/steps/units.rs`): exactly the same bits where each coordinate,
//! momentum, energy and the time is written in others by a power of two. Bands, sparse factors, products with the Jacobian, sweeps of `Gauss`, and lanes.

use std::collections::BTreeMap;
use std::sync::Mutex;

use fixtures::Uniform;
use wzvi::elements::Method;
use wzvi::nalgebra::DVector;
use wzvi::prelude::*;

/// A torus of `side` times `side` sites in quartic wells, whose masses may depend on the place, in units of coordinates, momenta and energy.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| energy * (
        (0..q.len()).map(|i| 0.5 * momentum * momentum * p[i] * p[i] * (1.0 + bend * place * place * q[i] * q[i])).sum::<f64>()
            + (0..side).map(|i| (0..side).map(|j| {
                let own = place * q[i * side + j];
                let right = place * q[i * side + (j + 1) % side];
                let down = place * q[(i + 1) % side * side + j];
                0.5 * spring * ((right - own) * (right - own) + (down - own) * (down - own)) + 0.25 * own * own * own * own
            }).sum::<f64>()).sum::<f64>()
    ),
    embedding = Midpoint,
)]
#[derive(Clone, Copy)]
struct Torus {
    side: usize,
    bend: f64,
    spring: f64,
    place: f64,
    momentum: f64,
    energy: f64,
}

/// A chain with fixed ends in quartic wells.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| energy * (p.iter().map(|p| 0.5 * (momentum * p) * (momentum * p)).sum::<f64>()
        + (1..q.len()).map(|i| 0.5 * (place * (q[i] - q[i - 1])).powi(2)).sum::<f64>() + q.iter().map(|q| 0.25 * (place * q).powi(4)).sum::<f64>()),
    embedding = [Midpoint, Lambda<1, 3>, Gauss<2>, Gauss<4>, Verlet],
)]
#[derive(Clone, Copy)]
struct Chain {
    place: f64,
    momentum: f64,
    energy: f64,
}

/// Units of a coordinate, of energy and of time, as powers of two.
type Units = [i32; 3];

fn power(exponent: i32) -> f64 {
    2.0_f64.powi(exponent)
}

fn chain([a, e, tau]: Units) -> Chain {
    Chain { place: power(-a), momentum: power(a - e), energy: power(e - tau) }
}

fn torus(side: usize, bend: f64, spring: f64) -> impl Fn(Units) -> Torus {
    move |[a, e, tau]| Torus {
        side,
        bend,
        spring,
        place: power(-a),
        momentum: power(a - e),
        energy: power(e - tau),
    }
}

fn all_units() -> Vec<Units> {
    let mut random = Uniform(3);
    let mut exponent = || (100.0 * random.draw()) as i32;
    (0..6).map(|_| [exponent(), exponent(), exponent()]).collect()
}

type Many = State<DVector<f64>>;

fn in_units(start: &Many, [a, e, _]: Units) -> Many {
    State::new(&start.q * power(a), &start.p * power(e - a))
}

/// In units of one.
fn bits(state: &Many, [a, e, _]: Units) -> Vec<u64> {
    let q = state.q.iter().map(|x| (x * power(-a)).to_bits());
    q.chain(state.p.iter().map(|x| (x * power(a - e)).to_bits())).collect()
}

fn starts(paths: usize, sites: usize) -> Vec<Many> {
    let mut random = Uniform(17);
    let mut list = move || (0..sites).map(|_| random.draw()).collect::<Vec<f64>>();
    (0..paths).map(|_| State::new(list(), list())).collect()
}

/// Steps in units of one and in others; how their linear equations were solved.
fn compare<H, E>(system: impl Fn(Units) -> H, sites: usize, h: f64, steps: usize) -> Option<Method>
where
    H: Discretized<E, Vector = DVector<f64>>,
{
    let run = |units: Units| {
        let (system, mut state) = (system(units), in_units(&starts(1, sites)[0], units));
        let mut stepper = wzvi::step::Stepper::<H, E>::new(&system, h * power(units[2])).unwrap();
        let taken: Vec<_> = (0..steps).map(|_| stepper.step(&mut state, &[]).map_err(|_| ())).collect();
        (taken, bits(&state, units), stepper.method())
    };
    let one = run([0; 3]);
    assert!(one.0.iter().all(Result::is_ok), "{:?}", one.0);
    for units in all_units().into_iter().take(2) {
        assert!(one == run(units), "units {units:?}, h = {h}: {:?} for {:?}", run(units).0, one.0);
    }
    one.2
}

#[test]
fn bands_and_sweeps() {
    for h in [0.1, 2.0] {
        compare::<_, Midpoint>(chain, 24, h, 2);
        compare::<_, Lambda<1, 3>>(chain, 24, h, 2);
    }
    for h in [0.1, 0.6] {
        compare::<_, Gauss<2>>(chain, 24, h, 2);
        compare::<_, Gauss<4>>(chain, 24, h, 2);
    }
    // In tiles.
    compare::<_, Midpoint>(chain, 130, 0.2, 2);
    compare::<_, Verlet>(chain, 130, 0.2, 2);
    compare::<_, Gauss<4>>(chain, 130, 0.2, 2);
}

#[test]
fn wide_jacobians() {
    // Too long for the fixed point.
    let method = compare::<_, Midpoint>(torus(28, 0.0, 1.0), 784, 1.5, 2);
    assert_eq!(method, Some(Method::Krylov));
    // Stiff: all entries of the factors are made.
    compare::<_, Midpoint>(torus(28, 0.0, 1e4), 784, 0.5, 2);
    // Coordinates and momenta are unknown, in units of their own.
    compare::<_, Midpoint>(torus(28, 0.3, 1.0), 784, 0.6, 2);
}

/// Each lane has units of its own.
#[test]
fn lanes() {
    let paths = 8;
    let run = |units: &[Units], h: f64| {
        let seen = Mutex::new(BTreeMap::new());
        let systems = units.iter().map(|&units| chain(units)).collect::<Vec<_>>();
        let starts: Vec<Many> =
            starts(paths, 6).iter().zip(units).map(|(start, &units)| in_units(start, units)).collect();
        let tau = power(units[0][2]);
        let ensemble = wzvi::ensemble::Ensemble::<Chain, Midpoint>::new(&systems[0], h * tau).steps(4);
        let run = ensemble.systems_from(systems.clone()).starts_from(starts).inspect(|path, state| {
            seen.lock().unwrap().insert((path, (state.t / tau).to_bits()), bits(state, units[path as usize]));
        });
        run.run_in::<8>().unwrap();
        seen.into_inner().unwrap()
    };
    for h in [0.1, 0.6] {
        let one = run(&[[0; 3]; 8], h);
        assert_eq!(one.len(), 16);
        for tau in [0, 90, -100] {
            let units: Vec<Units> =
                all_units().iter().chain(&all_units()[..2]).map(|&[a, e, _]| [a, e, tau]).collect();
            assert!(one == run(&units, h), "h = {h}, {units:?}");
        }
    }
}
