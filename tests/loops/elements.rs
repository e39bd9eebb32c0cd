//! Systems whose sums stay loops: the same steps as the unrolled ones, at any size.

mod digits;
mod integrals;
mod lagrangian;
mod long;
mod lowering;
mod ranges;
mod sites;
mod tables;
mod wide;

use fixtures::steps::refused;
use fixtures::{larger, wave};
use wzvi::prelude::*;

use crate::lattice::Torus;
use crate::one_by_one::later_allocations;

/// Every system twice: with sums that stay loops, and with a literal size of 3 points, which is unrolled.
macro_rules! both_ways {
    (
        $sized:ident, $unrolled:ident, $point:ty, { $($field:ident : $ty:ty),* }, [$($embedding:ty),*],
        |$q:ident, $p:ident, $n:ident| $drift:expr
        $(, noise |$nq:ident, $np:ident| $noise:expr)?
    ) => {
        #[hamiltonian(
            drift = |$q: &[$point], $p: &[$point]| { let $n = $q.len(); $drift },
            $(noise = [|$nq, $np| $noise],)?
            embedding = [$($embedding),*],
        )]
        #[derive(Clone)]
        struct $sized { $($field: $ty),* }

        #[hamiltonian(
            drift = |$q: [$point; 3], $p: [$point; 3]| { let $n = $q.len(); $drift },
            $(noise = [|$nq: [$point; 3], $np: [$point; 3]| $noise],)?
            embedding = [$($embedding),*],
        )]
        #[derive(Clone)]
        struct $unrolled { $($field: $ty),* }
    };
}

both_ways!(
    Chain, ChainUnrolled, f64, { beta: f64, mass: [f64; 6] }, [DeltaPlus, Midpoint, DeltaMinus, Lambda<1, 4>],
    |q, p, n| {
        let v = |d: f64| 0.5 * d * d + 0.25 * beta * d.powi(4);
        (0..n).map(|i| p[i] * p[i] / (2.0 * mass[i])).sum::<f64>()
            + (0..n - 1).map(|i| v(q[i + 1] - q[i])).sum::<f64>()
            + v(q[0])
            + v(q[n - 1])
    }
);

both_ways!(
    Ring, RingUnrolled, f64, { k: f64 }, [DeltaPlus, Midpoint],
    |q, p, n| {
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + (0..n).map(|i| 1.0 - (k * (q[(i + 1) % n] - q[i])).cos()).sum::<f64>()
    }
);

both_ways!(
    Noisy, NoisyUnrolled, f64, { s: f64 },
    [
        Midpoint, Uncorrected<DeltaPlus>, Uncorrected<DeltaMinus>, Uncorrected<Lambda<1, 3>>, Mixed<DeltaPlus, Midpoint>,
        Uncorrected<Mixed<Midpoint, DeltaPlus>>
    ],
    |q, p, n| {
        (0..n).map(|i| 0.5 * p[i] * p[i] + 0.25 * q[i].powi(4)).sum::<f64>()
            + (0..n - 1).map(|i| 0.5 * (q[i + 1] - q[i]).powi(2)).sum::<f64>()
    },
    noise |q, p| s * q.iter().zip(p.iter()).map(|(q, p)| 0.5 * q * q * p + q).sum::<f64>()
);

/// The largest difference in so many steps.
fn difference<E, A: Discretized<E>, B: Discretized<E>>(
    sized: &A,
    unrolled: &B,
    h: f64,
    dw: &[f64],
    steps: u32,
) -> f64 {
    let degrees = unrolled.degrees();
    let start: [&[f64]; 2] = [&wave(degrees, 0.8, 0.2), &wave(degrees, 0.5, 1.1)];
    fixtures::steps::apart::<E, _, _>((sized, unrolled), start, (h, steps), dw)
}

/// Twenty steps of order one each round a few dozen times: 1e-13 is 20 steps of 20 ulp. None of the systems is unstable
/// on that time.
const ROUNDING: f64 = 1e-13;

#[test]
fn loops_and_unrolled_sums_take_the_same_steps() {
    macro_rules! same {
        ($loops:expr, $unrolled:expr, $h:expr, $dw:expr, $steps:expr, [$($scheme:ty),*]) => {
            $(assert!(difference::<$scheme, _, _>(&$loops, &$unrolled, $h, $dw, $steps) < ROUNDING);)*
        };
    }
    let (beta, mass) = (0.7, [1.0, 2.0, 0.5, 1.5, 1.0, 3.0]);
    let (chain, unrolled) = (Chain { beta, mass }, ChainUnrolled { beta, mass });
    same!(chain, unrolled, 0.1, &[], 20, [DeltaPlus, Midpoint, DeltaMinus, Lambda<1, 4>]);
    // So stiff that the fixed point does not contract.
    same!(chain, unrolled, 1.5, &[], 5, [Midpoint]);
    let (ring, unrolled) = (Ring { k: 1.3 }, RingUnrolled { k: 1.3 });
    same!(ring, unrolled, 0.1, &[], 20, [DeltaPlus, Midpoint]);
    same!(ring, unrolled, 1.2, &[], 5, [Midpoint]);
    let (noisy, unrolled) = (Noisy { s: 0.3 }, NoisyUnrolled { s: 0.3 });
    same!(noisy, unrolled, 0.05, &[0.13], 20, [Midpoint]);
    same!(noisy, unrolled, 0.05, &[0.03], 20, [Uncorrected<DeltaPlus>, Uncorrected<DeltaMinus>, Uncorrected<Lambda<1, 3>>]);
    same!(noisy, unrolled, 0.05, &[-0.1], 20, [Mixed<DeltaPlus, Midpoint>]);
    same!(noisy, unrolled, 0.05, &[-0.03], 20, [Uncorrected<Mixed<Midpoint, DeltaPlus>>]);
}

#[hamiltonian(
    drift = |q: [f64; N], p: [f64; N]| {
        let v = |d: f64| 0.5 * d * d + 0.25 * beta * d.powi(4);
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + (1..N).map(|i| v(q[i] - q[i - 1])).sum::<f64>()
            + v(q[0]) + v(q[N - 1])
    },
    embedding = [DeltaPlus, Midpoint],
)]
struct Fput<const N: usize> {
    beta: f64,
}

fn first_mode<const N: usize>() -> State<wzvi::nalgebra::SVector<f64, N>> {
    let q: [f64; N] = std::array::from_fn(|i| (std::f64::consts::PI * (i + 1) as f64 / (N + 1) as f64).sin());
    State::new(q, [0.0; N])
}

#[test]
fn sizes_are_const_generics() {
    assert_eq!(<Fput<32> as Discretized<Midpoint>>::PLAN.unknowns, 32);
    // Only the state knows them.
    let text = <Network as Discretized<Midpoint>>::PLAN.to_string();
    assert!(
        text.starts_with("step by Newton's method (unknowns by the size of the state) of order 2"),
        "{text}"
    );
    assert_eq!(<Fput<32> as Discretized<DeltaPlus>>::PLAN.solver, Solver::Explicit);
    let fput = Fput::<32> { beta: 0.25 };
    assert_eq!(fput.degrees(), 32);
    let mut state = first_mode::<32>();
    let mut stepper = fput.stepper::<Midpoint>(0.05).unwrap();
    let start = fput.energy(&state);
    let mut drift = 0.0_f64;
    for _ in 0..2000 {
        stepper.step(&mut state, &[]).unwrap();
        drift = larger(drift, (fput.energy(&state) / start - 1.0).abs());
    }
    // The modified energy is h²/24 of a third derivative away: below 1e-4 here, and it does not grow.
    assert!(drift > 0.0 && drift < 1e-4, "{drift}");
}

#[test]
fn the_way_to_the_solution_does_not_matter() {
    let fput = Fput::<32> { beta: 0.25 };
    let run = |iteration: Iteration| {
        let mut state = first_mode::<32>();
        let mut stepper = fput.stepper::<Midpoint>(0.05).unwrap().iteration(iteration);
        let mut iterations = 0;
        for _ in 0..100 {
            iterations += stepper.step(&mut state, &[]).unwrap().iterations;
        }
        (state, iterations)
    };
    let (automatic, many) = run(Iteration::Automatic);
    let (fixed, _) = run(Iteration::FixedPoint);
    let (newton, few) = run(Iteration::Newton);
    assert_eq!(automatic, fixed);
    assert!(few < many, "{few} {many}");
    for (a, b) in newton.q.iter().zip(&automatic.q) {
        assert!((a - b).abs() < ROUNDING, "{a} {b}");
    }
}

#[test]
fn a_pinned_fixed_point_is_not_replaced() {
    // The spectral radius of φ' is h²/4 · 4 sin²(π N/(2 (N + 1))) (1 + 3 β d²): above 8 for h = 3, below 1/100 for h = 0.1.
    let fput = Fput::<32> { beta: 0.25 };
    let step = |h: f64, iteration: Iteration| {
        let mut state = first_mode::<32>();
        // All modes take part.
        state.q[7] += 0.3;
        let before = state;
        let taken = fput.stepper::<Midpoint>(h).unwrap().iteration(iteration).step(&mut state, &[]);
        assert!(taken.is_ok() || state == before);
        taken.map_err(|error| error.cause)
    };
    let stiff = step(3.0, Iteration::FixedPoint);
    assert!(matches!(stiff, Err(wzvi::error::StepFailure::NotConverged { .. })), "{stiff:?}");
    for (h, iteration) in
        [(3.0, Iteration::Automatic), (3.0, Iteration::Newton), (0.1, Iteration::FixedPoint)]
    {
        let taken = step(h, iteration);
        assert!(taken.is_ok(), "h = {h}, {iteration:?}: {taken:?}");
    }
}

#[test]
fn steps_are_symplectic() {
    let q = first_mode::<5>().q;
    for h in [0.1, 1.5] {
        let start: [&[f64]; 2] = [q.as_slice(), &[0.0, 0.1, 0.2, 0.3, 0.4]];
        let gap =
            fixtures::steps::asymmetry::<Midpoint, _>(&Fput::<5> { beta: 0.25 }, start, [0.0, h], &[], 1.0);
        assert!(gap < 1e-12, "h = {h}: {gap:e}");
    }
}

/// Oscillators along the edges of a graph.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let kinetic: f64 = p.iter().map(|p| 0.5 * p * p).sum();
        let edges: f64 = (0..bonds.len())
            .map(|b| strength[b] * (1.0 - (q[self.bonds[b][0]] - q[self.bonds[b][1]]).cos()))
            .sum();
        kinetic + edges
    },
    noise = [|q, p, k| sigma * (k as f64 + 1.0) * q[k]; 4],
    embedding = [Midpoint, DeltaPlus],
)]
struct Network {
    bonds: Vec<[usize; 2]>,
    strength: Vec<f64>,
    sigma: f64,
}

#[hamiltonian(
    drift = |q: [f64; 4], p: [f64; 4]| {
        let kinetic: f64 = p.iter().map(|p| 0.5 * p * p).sum();
        kinetic + 2.0 * (1.0 - (q[0] - q[2]).cos()) + 0.5 * (1.0 - (q[3] - q[2]).cos())
            + 1.5 * (1.0 - (q[1] - q[0]).cos())
    },
    noise = [|q, p, k| sigma * (k as f64 + 1.0) * q[k]; 4],
    embedding = [Midpoint, DeltaPlus],
)]
struct NetworkUnrolled {
    sigma: f64,
}

#[test]
fn tables_place_elements_and_families_drive_them() {
    let network = Network { bonds: vec![[0, 2], [3, 2], [1, 0]], strength: vec![2.0, 0.5, 1.5], sigma: 0.4 };
    let unrolled = NetworkUnrolled { sigma: 0.4 };
    assert_eq!((network.noises(), unrolled.noises()), (4, 4));
    let dw = [0.1, -0.2, 0.05, 0.3];
    assert!(difference::<Midpoint, _, _>(&network, &unrolled, 0.1, &dw, 20) < ROUNDING);
    assert!(difference::<Midpoint, _, _>(&network, &unrolled, 1.0, &dw, 3) < ROUNDING);
    assert!(difference::<DeltaPlus, _, _>(&network, &unrolled, 0.1, &dw, 20) < ROUNDING);
    let state = State::new(wave(4, 1.0, 0.0), wave(4, 1.0, 2.0));
    let flat: State<wzvi::nalgebra::SVector<f64, 4>> = State::new(
        wzvi::nalgebra::SVector::<f64, 4>::from_vec(wave(4, 1.0, 0.0)),
        wzvi::nalgebra::SVector::<f64, 4>::from_vec(wave(4, 1.0, 2.0)),
    );
    for k in 0..4 {
        assert!((network.energy_rate(k, &state) - unrolled.energy_rate(k, &flat)).abs() < 1e-15);
        let energies = [network.noise_energy(k, &state), unrolled.noise_energy(k, &flat)];
        assert!((energies[0] - energies[1]).abs() < 1e-15, "{energies:?}");
    }
    assert!(network.noise_energy(4, &state).is_nan());
}

#[test]
fn indices_out_of_range_are_found_before_a_step() {
    let network = Network { bonds: vec![[0, 9]], strength: vec![1.0], sigma: 0.0 };
    let mut stepper = network.stepper::<Midpoint>(0.1).unwrap();
    let state = State::new(vec![0.1; 4], vec![0.0; 4]);
    let error = refused(&state, |state| stepper.step(state, &[0.0; 4]));
    assert!(error.cause.to_string().starts_with("`bonds[0][1]` is 9, but the state has 4;"), "{error}");
    assert!(network.energy(&state).is_nan());
    let short = Network { bonds: vec![[0, 1], [1, 2]], strength: vec![1.0], sigma: 0.0 };
    refused(&state, |state| short.stepper::<Midpoint>(0.1).unwrap().step(state, &[0.0; 4]));
}

#[test]
fn steps_allocate_nothing() {
    let mut mode = first_mode::<64>();
    assert_eq!(later_allocations::<Midpoint, _>(&Fput::<64> { beta: 0.25 }, &mut mode, 0.05, 100), 0);
    let chain = Chain { beta: 0.7, mass: [1.0; 6] };
    let mut state = State::new(wave(6, 1.0, 0.0), wave(6, 1.0, 2.0));
    for h in [0.05, 1.5] {
        assert_eq!(later_allocations::<Midpoint, _>(&chain, &mut state, h, 10), 0, "h = {h}");
    }
}

const SITES: usize = 20;

/// Ends held by a condition on the index, size from a constant.
#[hamiltonian(
    drift = |q: [f64; SITES], p: [f64; SITES]| {
        let kinetic: f64 = p.iter().map(|p| 0.5 * p * p).sum();
        let springs: f64 = (0..SITES)
            .map(|i| {
                let left = if i == 0 { 0.0 } else { q[i - 1] };
                0.25 * (q[i] - left).powi(4)
            })
            .sum();
        kinetic + springs + 0.25 * q[SITES - 1].powi(4)
    },
    embedding = [Midpoint],
)]
struct Held;

/// The same with the ends written apart and a literal size.
#[hamiltonian(
    drift = |q: [f64; 20], p: [f64; 20]| {
        let springs: f64 = q.windows(2).map(|w| 0.25 * (w[1] - w[0]).powi(4)).sum();
        p.iter().map(|p| 0.5 * p * p).sum::<f64>() + springs + 0.25 * q[0].powi(4) + 0.25 * q[19].powi(4)
    },
    embedding = [Midpoint],
)]
struct Apart;

#[test]
fn conditions_on_indices_split_loops() {
    assert_eq!(<Held as Discretized<Midpoint>>::PLAN.unknowns, 20);
    let q = first_mode::<20>().q;
    let start: [&[f64]; 2] = [q.as_slice(), &[0.0; 20]];
    assert!(fixtures::steps::apart::<Midpoint, _, _>((&Held, &Apart), start, (0.1, 20), &[]) < ROUNDING);
}

#[test]
fn lattices_in_two_dimensions_run() {
    let torus = Torus::square(7, 0.0);
    let mut state: State<wzvi::nalgebra::DVector<f64>> = State::new(wave(49, 1.0, 0.3), wave(49, 0.4, 0.1));
    let mut by_hand = state.p.iter().map(|p| 0.5 * p * p).sum::<f64>();
    for i in 0..7 {
        for j in 0..7 {
            let own = state.q[7 * i + j];
            let (down, right) = (state.q[7 * ((i + 1) % 7) + j], state.q[7 * i + (j + 1) % 7]);
            by_hand += 0.5 * (down - own).powi(2) + 0.5 * (right - own).powi(2) + 0.25 * own.powi(4);
        }
    }
    // Forty-nine sites, energies of order 100.
    assert!((torus.energy(&state) - by_hand).abs() < 1e-11, "{} {by_hand}", torus.energy(&state));
    for h in [0.05, 1.0] {
        let mut newton = state.clone();
        torus.stepper::<Midpoint>(h).unwrap().step(&mut state, &[]).unwrap();
        torus.stepper::<Midpoint>(h).unwrap().iteration(Iteration::Newton).step(&mut newton, &[]).unwrap();
        assert!((&state.q - &newton.q).amax() < ROUNDING && (&state.p - &newton.p).amax() < ROUNDING);
    }
}

#[test]
fn energies_of_many_sizes_agree_with_the_compensated_step() {
    // Compensated sums keep the state of a linear chain closer to the plain one than rounding grows.
    let fput = Fput::<40> { beta: 0.0 };
    let mut plain = first_mode::<40>();
    let mut carried = plain;
    let mut stepper = fput.stepper::<Midpoint>(0.05).unwrap();
    let mut compensated = fput.stepper::<Midpoint>(0.05).unwrap().compensated();
    for _ in 0..1000 {
        stepper.step(&mut plain, &[]).unwrap();
        compensated.step(&mut carried, &[]).unwrap();
    }
    assert!(compensated.is_compensated());
    // A thousand roundings of numbers of order one at worst.
    assert!((plain.q - carried.q).amax() < 1000.0 * f64::EPSILON);
    assert!(plain.q != carried.q);
}
