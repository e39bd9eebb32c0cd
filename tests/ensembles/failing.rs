//! One path of many that fails, and one that must be halved: the others are the paths that they are alone.

use std::any::type_name;
use std::collections::BTreeSet;

use fixtures::stepped::stepped;
use fixtures::steps::numbers;
use wzvi::bath::{A, B, O};
use wzvi::prelude::*;
use wzvi::state::Vector;

/// A barrier at `q = 0`, a minimum at 0.3, and no bound from `q = 10` on; arithmetic and roots only, so that lanes have the bits of a single path.
macro_rules! small {
    ($name:ident, [$($keys:tt)*], $schemes:tt) => {
        #[hamiltonian(
            drift = |q, p| 0.5 * p * p + 0.5 * q * q - q * q * q / 30.0 + 0.1 / q.sqrt(),
            $($keys)*
            embedding = $schemes,
        )]
        struct $name;
    };
}

small!(Conservative, [], [Verlet, Midpoint, Gauss<2>]);
small!(Damped, [friction = 0.1,], [Verlet, Midpoint, DeltaMinus]);
small!(Forced, [force = |_q, p| -0.1 * p,], [Verlet]);
small!(Placed, [friction = |q| 0.1 * q * q,], [Verlet]);
small!(Additive, [noise = [|q, _p| 0.01 * q],], [Verlet]);
small!(Kicked, [noise = [|q, _p| 0.01 * q * q],], [Verlet]);
small!(Scaled, [noise = [|q, p| 0.01 * q * p],], [Verlet, Midpoint, Corrected<DeltaPlus>]);
small!(Bath, [friction = 0.1, temperature = 1e-4,], [Splitting<(B, A, O, A, B)>, Thermostat<Verlet>, Thermostat<Midpoint>, Gjf]);

#[hamiltonian(
    drift = |q, p| 0.5 * (1.0 + 0.1 * q * q) * p * p + 0.5 * q * q - q * q * q / 30.0 + 0.1 / q.sqrt(),
    embedding = [Verlet, Lambda<1, 4>],
)]
struct Metric;

#[hamiltonian(
    drift = [|q, p| 0.5 * (p * p + q * q), |q, _p| 0.1 / q.sqrt() - q * q * q / 30.0],
    embedding = Verlet,
)]
struct TwoParts;

/// The same at each of twelve sites, in loops.
macro_rules! large {
    ($name:ident, [$($keys:tt)*], $schemes:tt) => {
        #[hamiltonian(
            drift = |q: [f64; 12], p: [f64; 12]| {
                let v = |q: f64| 0.5 * q * q - q * q * q / 30.0 + 0.1 / q.sqrt();
                (0..12).map(|i| 0.5 * p[i] * p[i] + v(q[i])).sum::<f64>()
                    + (1..12).map(|i| 0.01 * (q[i] - q[i - 1]).powi(2)).sum::<f64>()
            },
            $($keys)*
            embedding = $schemes,
        )]
        struct $name;
    };
}

large!(Sites, [], [Verlet, Midpoint]);
large!(DampedSites, [friction = 0.1,], [Verlet, Midpoint]);
large!(ScaledSites, [noise = [|q, p, k| 0.01 * q[k] * p[k]; 12],], [Verlet]);
large!(HeatedSites, [friction = 0.1, temperature = 1e-4,], [Splitting<(B, A, O, A, B)>, Thermostat<Verlet>]);

const H: f64 = 0.2;
const STEPS: u64 = 12;
/// The first step overflows, and has no solution.
const LOST: u64 = 3;
/// Near the barrier, which a long step leaps over, and near the point from which nothing comes back.
const HARD: [u64; 2] = [5, 6];

/// Nine paths; how many were halved and arrived.
fn check<S, E>(system: &S) -> usize
where
    S: Discretized<E> + Sync,
{
    let what = type_name::<(E, S)>();
    let degrees = system.degrees();
    let start = |path: u64| {
        let [first_q, first_p] = match path {
            LOST => [1e200, 0.0],
            5 => [0.3, -1.0],
            6 => [20.0, 0.0],
            _ => [0.25 + 0.02 * path as f64, 0.1],
        };
        let (mut q, mut p) = (S::Vector::zeros(degrees), S::Vector::zeros(degrees));
        q.components_mut().fill(0.3);
        (q.components_mut()[0], p.components_mut()[0]) = (first_q, first_p);
        State { q, p, t: 0.0 }
    };
    let run = |halvings| {
        let all = system.ensemble::<E>(H).starts_from((0..9).map(start).collect::<Vec<_>>());
        let all = all.noise(Wiener::seed(3)).retry(Retry::halving(halvings)).allow_losses(1.0);
        all.steps(STEPS).record_every(1).keep_paths(1 << 20).threads(1)
    };
    let mut arrived = 0;
    for halvings in [0, 8] {
        let lanes = run(halvings).run_in::<4>().unwrap_or_else(|error| panic!("{what}: {error}"));
        // As text: of paths that failed there are NaN.
        let alone = run(halvings).run_in::<1>().unwrap_or_else(|error| panic!("{what}: {error}"));
        assert_eq!(format!("{lanes:?}"), format!("{alone:?}"), "{what}");
        let failed: BTreeSet<u64> = lanes.failures().iter().map(|failure| failure.path).collect();
        let hard: BTreeSet<u64> = [LOST, HARD[0], HARD[1]].into();
        assert!(failed.contains(&LOST) && failed.is_subset(&hard), "{what}: {failed:?}");
        for path in 0..9 {
            let (replayed, _) = run(halvings).replay(path).unwrap();
            let halved = replayed.iterations().halved;
            assert!(halved == 0 || hard.contains(&path), "{what}: path {path}");
            arrived += usize::from(halved > 0 && !failed.contains(&path));
            // Where steps were halved, too, a lane goes on as the path that is replayed.
            for (node, state) in replayed.states().iter().enumerate() {
                let (kept, state) =
                    (lanes.paths().and_then(|paths| paths.at(path as usize, node)), numbers(state));
                assert_eq!(kept.unwrap()[..state.len()], state, "{what}: path {path}, node {node}");
            }
            if halved == 0 {
                let single = stepped::<E, S>(system, H, start(path), Wiener::seed(3).path(path), STEPS);
                assert_eq!(replayed.states(), single.nodes, "{what}: path {path}");
            }
        }
    }
    println!("{what}: {arrived}");
    arrived
}

macro_rules! all {
    ($($system:ident: $($scheme:ty),*;)*) => { [$($(check::<_, $scheme>(&$system)),*),*] };
}

#[test]
fn a_path_that_fails_or_is_halved_leaves_the_others_alone() {
    let arrived = all! {
        Conservative: Verlet, Midpoint, Gauss<2>, Composed<Verlet, BlanesMoan4>, Composed<Midpoint, Yoshida4>;
        Damped: Verlet, Midpoint, DeltaMinus, Composed<Verlet, Yoshida4>;
        Forced: Verlet;
        Placed: Verlet;
        Additive: Verlet;
        Kicked: Verlet;
        Scaled: Verlet, Midpoint, Corrected<DeltaPlus>;
        Bath: Splitting<(B, A, O, A, B)>, Thermostat<Verlet>, Thermostat<Midpoint>, Gjf;
        Metric: Verlet, Lambda<1, 4>;
        TwoParts: Verlet, Composed<Verlet, Aba864>;
        Sites: Verlet, Midpoint;
        DampedSites: Verlet, Midpoint;
        ScaledSites: Verlet;
        HeatedSites: Splitting<(B, A, O, A, B)>, Thermostat<Verlet>;
    };
    // Those by kicks and drifts, most of them.
    assert!(arrived.iter().filter(|&&arrived| arrived > 0).count() > 15, "{arrived:?}");
}
