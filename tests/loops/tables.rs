//! Elements that tables of integers place: their slopes are computed beside each other in vector instructions, with the bits of one
//! placement after the other.
//!
//! The reference for bits is the same generated step on [`Lanes<1>`], which takes no vector registers and no blocks, and for the order
//! of sums a loop by hand.

use fixtures::Uniform;
use wzvi::lanes::Lanes;
use wzvi::prelude::*;
use wzvi::scalar::Scalar as _;

use crate::one_by_one::{H, check, check_others, check_scheme, numbers};

/// Oscillators on a graph with strengths of the bonds, from one table, and a field that changes in time.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64], t| {
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + bonds.iter().map(|&(a, b, k)| k * (1.0 - (q[a] - q[b]).cos())).sum::<f64>()
            + field.iter().zip(at).map(|(f, &site)| f * (q[site] + 0.1 * t).sin()).sum::<f64>()
    },
    embedding = [DeltaPlus, DeltaMinus, Verlet, Midpoint, Lambda<1, 4>],
)]
struct Network {
    bonds: Vec<(usize, usize, f64)>,
    field: Vec<f64>,
    at: Vec<usize>,
}

/// The strengths are one: what is computed by hand has no rounding but that of the sine and of sums.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + bonds.iter().map(|&[a, b]| 1.0 - (q[a] - q[b]).cos()).sum::<f64>()
    },
    embedding = [DeltaPlus, Verlet, Midpoint],
)]
struct Plain {
    bonds: Vec<[usize; 2]>,
}

/// A molecule: bonds with a Morse potential, whose lengths are in lists beside the table, and angles of three atoms.
#[hamiltonian(
    drift = |q: &[[f64; 3]], p: &[[f64; 3]]| {
        let n = q.len();
        (0..n).map(|i| 0.5 * (p[i][0] * p[i][0] + p[i][1] * p[i][1] + p[i][2] * p[i][2]) / mass[i]).sum::<f64>()
            + (0..bonds.len())
                .map(|b| {
                    let [i, j] = bonds[b];
                    let [x, y, z] = [q[i][0] - q[j][0], q[i][1] - q[j][1], q[i][2] - q[j][2]];
                    let r = (x * x + y * y + z * z + 0.01).sqrt();
                    let s = 1.0 - (a * (length[b] - r)).exp();
                    depth * s * s
                })
                .sum::<f64>()
            + angles
                .iter()
                .map(|&[i, j, k]| {
                    let dot = (q[i][0] - q[j][0]) * (q[k][0] - q[j][0]) + (q[i][2] - q[j][2]) * (q[k][2] - q[j][2]);
                    0.1 * (-dot * dot).exp()
                })
                .sum::<f64>()
    },
    embedding = [DeltaPlus, DeltaMinus, Verlet, Midpoint],
)]
struct Molecule {
    a: f64,
    depth: f64,
    mass: Vec<f64>,
    bonds: Vec<[usize; 2]>,
    length: Vec<f64>,
    angles: Vec<[usize; 3]>,
}

/// A list of neighbours of each site, of any length; a partner of each site, whose slope is added beside that of the site itself; and
/// every third site.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let n = q.len();
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + (0..n).map(|i| near[i].iter().map(|&j| k * (1.0 - (q[i] - q[j]).cos())).sum::<f64>()).sum::<f64>()
            + (0..n).map(|i| 0.3 * (0.5 * (q[i] - q[partner[i]])).exp()).sum::<f64>()
            + (0..n / 3).map(|i| k * (q[3 * i] * q[n - 1 - i]).atan()).sum::<f64>()
    },
    embedding = [DeltaPlus, DeltaMinus, Verlet, Midpoint],
)]
struct Neighbours {
    k: f64,
    near: Vec<Vec<usize>>,
    partner: Vec<usize>,
}

/// Momenta that a table couples, and a noise on each bond.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + bonds.iter().map(|&[a, b]| k * (1.0 + (p[a] - p[b]).powi(2)).ln()).sum::<f64>()
            + bonds.iter().map(|&[a, b]| k * (q[a] - q[b]).tanh()).sum::<f64>()
    },
    noise = [|q, p, b| sigma * (q[bonds[b][0]] - 0.5 * q[bonds[b][1]]).sin(); bonds.len()],
    embedding = [Uncorrected<DeltaPlus>, Uncorrected<DeltaMinus>, Midpoint],
)]
struct Driven {
    k: f64,
    sigma: f64,
    bonds: Vec<[usize; 2]>,
}

/// Elements that read both halves of the phase space, so that nothing is explicit.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + bonds.iter().map(|&[a, b]| 0.1 * (q[a] * p[b]).sin()).sum::<f64>()
    },
    embedding = [DeltaPlus, Midpoint],
)]
struct Twisted {
    bonds: Vec<[usize; 2]>,
}

/// So many tuples of sites: random ones, and among them neighbours in the table that have a site in common, the same bond twice, and
/// bonds with both ends at one site.
fn tuples<const D: usize>(count: usize, n: usize) -> Vec<[usize; D]> {
    let mut random = Uniform(7);
    let mut all: Vec<[usize; D]> = Vec::new();
    for number in 0..count {
        let mut own = std::array::from_fn(|_| random.below(n));
        match (number % 5, all.last()) {
            (1, Some(before)) => own[0] = before[D - 1],
            (2, Some(before)) => own = *before,
            (3, _) => own = [own[0]; D],
            _ => {}
        }
        all.push(own);
    }
    all
}

/// Below and above the size of blocks, and of chunks of 256.
const COUNTS: [usize; 9] = [0, 1, 2, 15, 16, 17, 33, 255, 600];

/// Below and above the number of degrees of freedom from which there are blocks.
const SIZES: [usize; 4] = [5, 63, 64, 300];

fn network(n: usize, count: usize) -> Network {
    let strength = numbers(count, 0.4);
    let bonds = tuples(count, n).into_iter().zip(strength).map(|([a, b], k)| (a, b, k)).collect();
    let at = tuples(count, n).into_iter().map(|[site]| site).collect();
    Network { bonds, field: numbers(count, 0.8), at }
}

fn molecule(n: usize, count: usize) -> Molecule {
    let mass = (0..n).map(|i| 1.0 + 0.5 * (i as f64).sin()).collect();
    let length = numbers(count, 0.1).iter().map(|x| 1.0 + 0.1 * x).collect();
    Molecule { a: 0.7, depth: 0.2, mass, bonds: tuples(count, n), length, angles: tuples(count / 2, n) }
}

fn neighbours(n: usize, count: usize) -> Neighbours {
    let mut random = Uniform(3);
    let lengths = (0..n).map(|i| if i == 0 { count } else { (i * i) % 7 });
    let near = lengths.map(|length| (0..length).map(|_| random.below(n)).collect()).collect();
    Neighbours { k: 0.1, near, partner: (0..n).map(|_| random.below(n)).collect() }
}

#[test]
fn placements_by_tables_have_the_bits_of_one_after_the_other() {
    for n in SIZES {
        for count in COUNTS {
            let what = |name: &str| format!("{name} of {n} sites and {count} placements");
            check(&network(n, count), n, &what("network"));
            check_others(&network(n, count), n, &what("network"));
            check(&molecule(n, count), 3 * n, &what("molecule"));
            check(&neighbours(n, count), n, &what("neighbours"));
        }
    }
}

#[test]
fn momenta_and_noises_by_tables_have_the_bits_of_one_after_the_other() {
    for n in SIZES {
        for count in COUNTS {
            let driven = Driven { k: 0.3, sigma: 0.1, bonds: tuples(count, n) };
            let start = [numbers(n, 0.2), numbers(n, 1.1)];
            let what = format!("driven, {n} sites and {count} bonds");
            check_scheme::<Uncorrected<DeltaPlus>, _>(&driven, &start, H, &what);
            check_scheme::<Uncorrected<DeltaMinus>, _>(&driven, &start, H, &what);
        }
    }
}

#[test]
fn rare_arguments_of_functions_have_the_bits_of_one_after_the_other() {
    for place in [0, 1, 17, 70] {
        let mut start = [numbers(71, 0.2), numbers(71, 1.1)];
        // Beyond what the reduction by π/2 in lanes takes.
        start[0][place] = 1e9;
        check_scheme::<DeltaPlus, _>(&network(71, 100), &start, H, "far away");
    }
}

#[test]
fn sums_have_the_order_of_the_placements() {
    let (n, h) = (80, 0.0625);
    let bonds = tuples(500, n);
    let (q, p) = (numbers(n, 0.2), numbers(n, 1.1));
    let mut sums = vec![0.0; n];
    for &[a, b] in &bonds {
        let pull = h * Lanes::new([q[a] - q[b]]).sin()[0];
        sums[a] += pull;
        sums[b] += -pull;
    }
    let next_p: Vec<f64> = p.iter().zip(&sums).map(|(p, sum)| p - sum).collect();
    let next_q: Vec<f64> = q.iter().zip(&next_p).map(|(q, p)| q + h * p).collect();
    let plain = Plain { bonds };
    let mut state = State::new(q, p);
    plain.stepper::<DeltaPlus>(h).unwrap().step(&mut state, &[]).unwrap();
    let bits = |list: &[f64]| -> Vec<u64> { list.iter().map(|x| x.to_bits()).collect() };
    assert_eq!(bits(state.p.as_slice()), bits(&next_p));
    assert_eq!(bits(state.q.as_slice()), bits(&next_q));
}

/// The equations of the mid-point step hold to rounding.
#[test]
fn fixed_points_are_those_of_the_equations() {
    let (n, h) = (96, 0.05);
    let plain = Plain { bonds: tuples(300, n) };
    let mut state = State::new(numbers(n, 0.2), numbers(n, 1.1));
    let mut stepper = plain.stepper::<Midpoint>(h).unwrap();
    for _ in 0..3 {
        let before = state.clone();
        stepper.step(&mut state, &[]).unwrap();
        let middle: Vec<f64> = before.q.iter().zip(state.q.iter()).map(|(a, b)| 0.5 * (a + b)).collect();
        let mut force = vec![0.0; n];
        for &[a, b] in &plain.bonds {
            let pull = (middle[a] - middle[b]).sin();
            force[a] -= pull;
            force[b] += pull;
        }
        for (i, force) in force.iter().enumerate() {
            // A dozen terms of order one, and three roundings of the state.
            let residual = state.p[i] - before.p[i] - h * force;
            assert!(residual.abs() < 1e-14, "site {i}: {residual:e}");
        }
    }
}

#[test]
fn elements_of_both_halves_step_as_those_of_small_systems() {
    // A ring below the size from which there are blocks, and the same ring many times beside itself.
    let ring = |copies: usize| -> Vec<[usize; 2]> {
        (0..copies).flat_map(|copy| (0..8).map(move |i| [8 * copy + i, 8 * copy + (i + 3) % 8])).collect()
    };
    let (q, p) = (numbers(8, 0.2), numbers(8, 1.1));
    let repeat = |list: &[f64]| list.repeat(20);
    let (few, many) = (Twisted { bonds: ring(1) }, Twisted { bonds: ring(20) });
    let (mut small, mut large) = (State::new(q.clone(), p.clone()), State::new(repeat(&q), repeat(&p)));
    let (mut few, mut many) =
        (few.stepper::<DeltaPlus>(0.05).unwrap(), many.stepper::<DeltaPlus>(0.05).unwrap());
    for _ in 0..5 {
        few.step(&mut small, &[]).unwrap();
        many.step(&mut large, &[]).unwrap();
    }
    for (i, a) in large.q.iter().chain(large.p.iter()).enumerate() {
        let b = if i < 160 { small.q[i % 8] } else { small.p[i % 8] };
        // Both end at the rounding of their own iterations.
        assert!((a - b).abs() < 1e-13, "number {i}: {a} and {b}");
    }
}

#[test]
fn a_step_that_fails_changes_nothing() {
    let mut system = molecule(40, 100);
    system.length[77] = 1e6;
    let state = State::new(numbers(120, 0.2), numbers(120, 1.1));
    let error =
        fixtures::steps::refused(&state, |state| system.stepper::<DeltaPlus>(0.1).unwrap().step(state, &[]));
    assert!(error.cause.to_string().contains("finite"), "{error}");
}

const ACROSS: usize = 3;
const ALONG: usize = 2;

/// Indices that reach back by more than a period, and a size that is a product of constants.
#[hamiltonian(
    drift = |q: [f64; ACROSS * ALONG], p: [f64; ACROSS * ALONG]| (0..q.len())
        .map(|i| 0.5 * p[i] * p[i] + 0.5 * k[(i as isize - 7).rem_euclid(3) as usize] * q[i] * q[i])
        .sum::<f64>(),
    embedding = Midpoint,
)]
struct Reaching {
    k: [f64; 3],
}

#[test]
fn remainders_of_negative_numbers_are_those_of_rust() {
    let system = Reaching { k: [1.0, 2.0, 4.0] };
    for at in 0..6 {
        let mut q = [0.0; 6];
        q[at] = 1.0;
        let k = system.k[(at as isize - 7).rem_euclid(3) as usize];
        assert_eq!(system.energy(&State::new(q, [0.0; 6])), 0.5 * k, "site {at}");
    }
}
