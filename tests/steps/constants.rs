//! Derivatives of the end of a run by parameters and by the step size, through steps in loops, flows, friction and baths.

use fixtures::are_refused;
use fixtures::bath::{self, Coupled, Oscillator, Rough};
use wzvi::Error;
use wzvi::embedding::Own;
use wzvi::nalgebra::{DMatrix, DVector};
use wzvi::prelude::*;
use wzvi::simulate::Tangent;
use wzvi::state::Vector;

use fixtures::own::RungeKutta4;

/// A driven chain of any size with noise at its ends; the parameters are in loops, beside the time and in a comparison.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64], t| {
        p.iter().map(|p| 0.5 * p * p / m).sum::<f64>()
            + q.windows(2).map(|w| 0.5 * k * (w[1] - w[0]).powi(2) + 0.25 * b * (w[1] - w[0]).powi(4)).sum::<f64>()
            + q.iter().map(|q| if k < m { 0.1 * k * q * q } else { 0.5 * (1.0 - (k * q).cos()) }).sum::<f64>()
            + f * (w * t).cos() * q[0]
    },
    embedding = [DeltaPlus, Midpoint, Verlet, Gauss<3>, Mixed<Midpoint, Midpoint>],
)]
#[derive(Clone, Debug)]
struct Chain {
    m: f64,
    k: f64,
    b: f64,
    f: f64,
    w: f64,
}

/// With noises, in loops.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| p.iter().map(|p| 0.5 * p * p).sum::<f64>() + q.iter().map(|q| 0.25 * k * q.powi(4)).sum::<f64>(),
    noise = [|q: &[f64], p: &[f64]| s * q.iter().zip(p).map(|(q, p)| q.sin() + 0.1 * q * p).sum::<f64>()],
    embedding = [Midpoint, Corrected<DeltaPlus>, Gauss<2>],
)]
#[derive(Clone, Debug)]
struct Noisy {
    k: f64,
    s: f64,
}

/// Bodies in the plane: rows of pairs, with a condition and a power of parameters.
#[hamiltonian(
    drift = |q: &[[f64; 2]], p: &[[f64; 2]]| {
        p.iter().map(|p| 0.5 * (p[0] * p[0] + p[1] * p[1])).sum::<f64>()
            + (0..q.len()).map(|i| (0..i).map(|j| {
                let (x, y) = (q[i][0] - q[j][0], q[i][1] - q[j][1]);
                let held = if g < e { g * x * x } else { y * y };
                0.01 * (held + (1.0 + x * x).powf(e)) - g / (x * x + y * y + e * e).sqrt()
            }).sum::<f64>()).sum::<f64>()
    },
    embedding = [DeltaPlus, Midpoint],
)]
#[derive(Clone, Debug)]
struct Bodies {
    g: f64,
    e: f64,
}

/// Oscillators on a graph: placements that are gathered, with a condition on parameters.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let strength = |c: f64| if c < s && c > 0.0 { c } else { s };
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + edges.iter().map(|[a, b]| strength(c) * (1.0 - (s * (q[*a] - q[*b])).cos())).sum::<f64>()
    },
    embedding = [DeltaPlus, Midpoint],
)]
#[derive(Clone, Debug)]
struct Network {
    edges: Vec<[usize; 2]>,
    c: f64,
    s: f64,
}

/// An integer selects what a small system reads.
#[hamiltonian(
    drift = |q: [f64; 3], p: [f64; 3]| p.iter().map(|p| 0.5 * p * p).sum::<f64>() + 0.5 * k * (q[site] - q[0]).powi(2) + 0.25 * q[1].powi(4),
    embedding = [DeltaPlus, Midpoint],
)]
struct Selected {
    k: f64,
    site: usize,
}

/// A list of numbers.
#[hamiltonian(drift = |q, p| 0.5 * p * p / m + 0.5 * weights[2] * q * q, embedding = Midpoint)]
struct Listed {
    m: f64,
    weights: [f64; 3],
}

/// Two driven sites in straight lines.
#[hamiltonian(
    drift = |[x, y], [u, v], t| 0.5 * (u * u + v * v + u * v) / m + 0.25 * k * (x.powi(4) + y * y) + 0.5 * (x - y).powi(2) + (w * t).sin() * x,
    noise = [|[x, y], _| s * (x * y).sin()],
    embedding = Verlet,
)]
struct Two {
    m: f64,
    k: f64,
    w: f64,
    s: f64,
}

/// A quadratic part with forces and friction, and a kick.
#[hamiltonian(
    drift = [|[x, y], [u, v]| 0.5 * (u * u + v * v) / m + 0.5 * k * (x * x + 2.0 * y * y) + c * x * y, |[x, y], _, t| 0.25 * b * (x - y).powi(4) + (w * t).sin() * x],
    friction = gamma, embedding = Verlet,
)]
struct Parts {
    m: f64,
    k: f64,
    c: f64,
    b: f64,
    w: f64,
    gamma: f64,
}

/// A Kepler problem with a quadratic kick.
#[hamiltonian(
    drift = [|[x, y], [u, v]| 0.5 * (u * u + v * v) / m - k / x.hypot(y), |[x, y], _| 0.5 * b * (x - y).powi(2)],
    embedding = Verlet,
)]
struct Orbit {
    m: f64,
    k: f64,
    b: f64,
}

/// Friction of a rate that steps take in.
#[hamiltonian(drift = |q, p| 0.5 * p * p + k * q * q, friction = gamma * gamma, embedding = [Midpoint, DeltaPlus, Gauss<2>, Gauss<3>])]
struct Damped {
    k: f64,
    gamma: f64,
}

/// The same for a chain.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| p.iter().map(|p| 0.5 * p * p).sum::<f64>() + q.windows(2).map(|w| 0.5 * k * (w[1] - w[0]).powi(2)).sum::<f64>(),
    friction = gamma, embedding = [Midpoint, DeltaPlus, Gauss<2>],
)]
struct DampedChain {
    k: f64,
    gamma: f64,
}

/// A mass matrix with one friction rate.
#[hamiltonian(
    drift = |[x, y], [u, v]| 0.5 * (u * u / m + 2.0 * v * v + u * v) + 0.5 * k * (x * x + 2.0 * y * y),
    friction = gamma, temperature = kt, embedding = [Baoab, Thermostat<Midpoint>],
)]
struct Massive {
    m: f64,
    k: f64,
    gamma: f64,
    kt: f64,
}

/// The end of a run with its derivatives by parameters and by the step size.
struct Ended {
    end: Vec<f64>,
    by_parameters: DMatrix<f64>,
    by_step_size: DVector<f64>,
}

fn ended<V: Vector>(tangent: Result<Tangent<V>, Error>) -> Ended {
    let Tangent { end, by_parameters, by_step_size, .. } = tangent.unwrap();
    let end = [end.q.components(), end.p.components()].concat();
    Ended { end, by_parameters, by_step_size: by_step_size.unwrap() }
}

/// `f'(0)` by four points `d` apart, and the bound `d⁴ f⁽⁵⁾/30 + 1.5 ε f/d` of its error for fifth derivatives of `size`, with 1e-13 for the roundings of a run.
fn slope(d: f64, size: f64, f: impl Fn(f64) -> Vec<f64>) -> (Vec<f64>, f64) {
    let [a, b, c, e] = [-2.0, -1.0, 1.0, 2.0].map(|k| f(k * d));
    let slope = |i: usize| (a[i] - 8.0 * b[i] + 8.0 * c[i] - e[i]) / (12.0 * d);
    ((0..a.len()).map(slope).collect(), d.powi(4) * size / 30.0 + 1.5e-13 / d)
}

/// Compares all columns with differences of the ends of runs of some twenty steps. With the same increments the step size has no differences of runs with noise:
/// then `H` times a number stands for it.
fn check<const N: usize>(what: &str, at: [f64; N], h: Option<f64>, run: impl Fn([f64; N], f64) -> Ended) {
    let (step, ours) = (h.unwrap_or(0.05), run(at, h.unwrap_or(0.05)));
    let agree = |column: &[f64], (differences, error): (Vec<f64>, f64), name: String| {
        for (ours, other) in column.iter().zip(differences) {
            assert!((ours - other).abs() <= error * other.abs().max(1.0), "{what}, {name}: {ours} {other}");
        }
        assert!(column.iter().any(|entry| *entry != 0.0), "{what}, {name}: nothing depends on it");
    };
    for number in 0..N {
        let varied =
            |d: f64| run(std::array::from_fn(|i| at[i] + if i == number { d } else { 0.0 }), step).end;
        let column: Vec<f64> = ours.by_parameters.column(number).iter().copied().collect();
        // Parameters of order one over one unit of time.
        agree(&column, slope(1e-3, 1e4, varied), format!("parameter {number}"));
    }
    if h.is_some() {
        // By twenty step sizes: 20⁵ times as large as by the time.
        let differences = slope(1e-4, 3.2e8, |d| run(at, step + d).end);
        agree(ours.by_step_size.as_slice(), differences, "step size".into());
    }
}

fn line(length: usize) -> State<DVector<f64>> {
    let at = |i: usize| 0.3 * (1.7 * i as f64).sin();
    let q: Vec<f64> = (0..length).map(at).collect();
    let p: Vec<f64> = (0..length).map(|i| at(i + 20)).collect();
    State { t: 0.3, ..State::new(q, p) }
}

/// Compares all columns of twenty steps of a system that is made from its parameters, with the noise of a seed or without noise.
pub(super) fn check_run<E, H: Discretized<E>, const N: usize>(
    make: impl Fn([f64; N]) -> H,
    names: [&str; N],
    at: [f64; N],
    start: &State<H::Vector>,
    seed: Option<u64>,
) {
    check(std::any::type_name::<(E, H)>(), at, seed.is_none().then_some(0.05), |at, h| {
        let system = make(at);
        let run = system.simulate::<E>(h).start(start.clone()).steps(20);
        match seed {
            Some(seed) => ended(run.noise(Wiener::seed(seed)).tangent_by(&names)),
            None => ended(run.tangent_by(&names)),
        }
    });
}

/// The same for several schemes.
macro_rules! check_schemes {
    ($make:expr, $names:expr, $at:expr, $start:expr, $seed:expr, [$($scheme:ty),*]) => {
        $($crate::constants::check_run::<$scheme, _, _>($make, $names, $at, $start, $seed);)*
    };
}
pub(super) use check_schemes;

#[test]
fn chains_of_any_size() {
    let at = |k| [0.5, k, 0.7, 1.1, 2.0];
    let (names, chain) = (["m", "k", "b", "f", "w"], |[m, k, b, f, w]: [f64; 5]| Chain { m, k, b, f, w });
    check_schemes!(chain, names, at(0.8), &line(5), None, [
        DeltaPlus, Midpoint, Verlet, Gauss<3>, Mixed<Midpoint, Midpoint>, Composed<Verlet, KahanLi8>,
        Composed<Midpoint, Yoshida4>, Own<RungeKutta4>
    ]);
    // On the other side of the comparison, which is in the functions of all schemes.
    check_schemes!(chain, names, at(0.3), &line(5), None, [DeltaPlus, Midpoint, Gauss<3>]);
}

/// Steps so long that they are solved by Newton's method: with factors in a band, and with products with the Jacobian.
#[test]
fn long_steps() {
    check("band", [0.5, 0.8, 0.7], Some(1.5), |[m, k, b], h| {
        let chain = Chain { m, k, b, f: 1.0, w: 1.0 };
        ended(chain.simulate::<Midpoint>(h).start(line(5)).steps(3).tangent_by(&["m", "k", "b"]))
    });
    let edges: Vec<[usize; 2]> = (0..400).map(|i| [i % 103, (i * i + 1) % 103]).collect();
    check("products", [0.9, 1.3], Some(1.5), |[c, s], h| {
        let network = Network { edges: edges.clone(), c, s };
        ended(network.simulate::<Midpoint>(h).start(line(103)).steps(1).tangent_by(&["c", "s"]))
    });
}

/// Kicks by the square of the force take second derivatives themselves.
#[test]
fn squares_of_the_force() {
    let (at, names) = ([0.9, 0.8, 0.7, 1.1, 2.0], ["m", "k", "b", "f", "w"]);
    let chain = |[m, k, b, f, w]: [f64; 5]| Chain { m, k, b, f, w };
    check_schemes!(chain, names, at, &line(5), None, [Composed<Verlet, Chin4>, Composed<Verlet, TakahashiImada4>]);
    let (at, names, start) =
        ([0.9, 0.8, 2.0, 0.4], ["m", "k", "w", "s"], State::new([0.4, -0.1], [0.2, 0.3]));
    let two = |[m, k, w, s]: [f64; 4]| Two { m, k, w, s };
    check_schemes!(two, names, at, &start, Some(5), [Composed<Verlet, Chin4>, Composed<Verlet, TakahashiImada4>]);
}

#[test]
fn noises_are_taken_as_given() {
    let (noisy, start) = (|[k, s]: [f64; 2]| Noisy { k, s }, State { t: 0.0, ..line(4) });
    check_schemes!(noisy, ["k", "s"], [0.8, 0.6], &start, Some(5), [
        Midpoint, Corrected<DeltaPlus>, Gauss<2>, Own<RungeKutta4>
    ]);
}

#[test]
fn pairs_and_gathered_placements() {
    let bodies = |[g, e]: [f64; 2]| Bodies { g, e };
    check_schemes!(bodies, ["g", "e"], [0.7, 2.0], &line(18), None, [DeltaPlus, Midpoint]);
    let network =
        |[c, s]: [f64; 2]| Network { edges: (0..9).map(|i| [i % 7, (3 * i + 1) % 7]).collect(), c, s };
    check_schemes!(network, ["c", "s"], [0.2, 1.3], &line(7), None, [DeltaPlus, Midpoint]);
}

#[test]
fn flows_of_parts() {
    let (at, names) = ([0.9, 1.3, 0.2, 0.7, 2.0, 0.3], ["m", "k", "c", "b", "w", "gamma"]);
    let start = State { t: 0.3, ..State::new([0.4, -0.1], [0.2, 0.3]) };
    let parts = |[m, k, c, b, w, gamma]: [f64; 6]| Parts { m, k, c, b, w, gamma };
    check_schemes!(parts, names, at, &start, None, [Composed<Verlet, Aba864>]);
    let (names, start) = (["m", "k", "b"], State::new([0.9, -0.1], [0.2, 0.8]));
    let orbit = |[m, k, b]: [f64; 3]| Orbit { m, k, b };
    check_schemes!(orbit, names, [0.9, 1.3, 0.2], &start, None, [Composed<Verlet, Aba864>]);
}

#[test]
fn friction_of_one_rate() {
    let (names, start) = (["k", "gamma"], State::new([0.4], [0.7]));
    let damped = |[k, gamma]: [f64; 2]| Damped { k, gamma };
    check_schemes!(damped, names, [0.8, 0.6], &start, None, [Midpoint, DeltaPlus, Gauss<2>, Gauss<3>]);
    let chain = |[k, gamma]: [f64; 2]| DampedChain { k, gamma };
    check_schemes!(chain, names, [0.8, 0.2], &line(4), None, [Midpoint, DeltaPlus, Gauss<2>]);
}

#[test]
fn baths() {
    let (one, two) = (State::new([0.4], [0.7]), State::new([0.4, 0.1], [0.7, -0.2]));
    let oscillator = |[m, k, b, gamma, kt]: [f64; 5]| Oscillator { m, k, b, gamma, kt };
    let (at, names) = ([0.9, 0.8, 0.3, 0.6, 0.7], ["m", "k", "b", "gamma", "kt"]);
    check_schemes!(oscillator, names, at, &one, Some(2), [
        Baoab, Obabo, Gjf, GjI, Thermostat<Verlet>, Thermostat<Midpoint>, Thermostat<Gauss<3>>
    ]);
    let massive = |[m, k, gamma, kt]: [f64; 4]| Massive { m, k, gamma, kt };
    let (at, names) = ([0.9, 0.8, 0.6, 0.7], ["m", "k", "gamma", "kt"]);
    check_schemes!(massive, names, at, &two, Some(2), [Baoab, Thermostat<Midpoint>]);
    let matrix = |[m, n, k, kt]: [f64; 4]| Coupled { m, n, k, damping: [[0.6, 0.2], [0.2, 0.9]], kt };
    check_schemes!(matrix, ["m", "n", "k", "kt"], [0.9, 1.2, 0.8, 0.7], &two, Some(2), [Baoab]);
    let chain = |[gamma, kt]: [f64; 2]| bath::Chain { gamma, kt };
    check_schemes!(chain, ["gamma", "kt"], [0.3, 0.7], &line(4), Some(2), [Baoab, Thermostat<Midpoint>]);
    let by_place = |[m, gamma, kt]: [f64; 3]| Rough { m, gamma, edge: 50.0, kt };
    check_schemes!(by_place, ["m", "gamma", "kt"], [0.9, 0.3, 0.7], &one, Some(2), [Obabo]);
}

/// Without a temperature the step size has differences, too.
#[test]
fn friction_of_a_bath_by_the_step_size() {
    let damped = |[m, k, b, gamma]: [f64; 4]| bath::Damped { m, k, b, gamma };
    let (at, names) = ([0.9, 0.8, 0.3, 0.6], ["m", "k", "b", "gamma"]);
    check_schemes!(damped, names, at, &State::new([0.4], [0.7]), None, [Baoab]);
}

#[test]
fn integers_select_what_is_read() {
    let (selected, start) =
        (|[k]: [f64; 1]| Selected { k, site: 2 }, State::new([0.4, 0.1, -0.2], [0.7, 0.0, 0.3]));
    check_schemes!(selected, ["k"], [0.8], &start, None, [DeltaPlus, Midpoint]);
}

/// Steps in straight lines have derivatives by entries of lists; those of the program read entries as they are.
#[test]
fn entries_of_lists() {
    let (weights, start) = ([0.1, 0.2, 0.3], State::new([0.4], [0.7]));
    check("lists", [0.8, 0.3], Some(0.05), |[m, weight], h| {
        let listed = Listed { m, weights: [0.1, 0.2, weight] };
        ended(listed.simulate::<Midpoint>(h).start(start).steps(40).tangent_by(&["m", "weights[2]"]))
    });
    let listed = Listed { m: 0.8, weights };
    let run = || listed.simulate::<Own<RungeKutta4>>(0.05).start(start).steps(40);
    assert!(run().tangent_by(&["m"]).is_ok());
    are_refused(run().tangent_by(&["weights[2]"]), "entries of lists");
}
