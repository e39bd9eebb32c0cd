//! The solution of a step is the one that continues the state, or an error: against a continuation in the step size that is as strict as it is slow.
//!
//! The equations of an implicit step have several solutions where `h² V''` is not small. The right one comes from no change at all as the step grows.
//! Here it is followed in parts of 2e-3, each predicted from those before and solved by Newton's method in all stages of a Gauss method at once, in
//! code that shares nothing with the library; a part in which the determinant changes its sign, or that is not solved, is halved up to sixteen times before the
//! branch is said to end. [`Reference`] is that; random states of wells and fields, with steps from 0.05 to 2, are its input.

use fixtures::extremes::state;
use fixtures::small::Sites;
use fixtures::steps::{distance, numbers};
use fixtures::{Uniform, larger};
use wzvi::error::StepFailure;
use wzvi::nalgebra::{DMatrix, DVector};
use wzvi::prelude::*;

/// Wells of one degree of freedom: Gauss methods eliminate the momenta.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * a * q * q + b * q * q * q + c * q * q * q * q + d * (k * q).cos(),
    embedding = [Midpoint, Gauss<2>, Gauss<3>, Gauss<4>, Gauss<6>, Gauss<8>],
)]
struct Well {
    a: f64,
    b: f64,
    c: f64,
    d: f64,
    k: f64,
}

/// A mass that depends on the place, and a field that acts on the momentum.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p * (1.0 + e * q * q) + f * p * q * q + s * q.sin() + 0.5 * a * q * q + c * q * q * q * q + d * (k * q).cos(),
    embedding = [Midpoint, Gauss<2>, Gauss<3>, Gauss<4>, Gauss<6>, Gauss<8>],
)]
struct Field {
    a: f64,
    c: f64,
    d: f64,
    k: f64,
    e: f64,
    f: f64,
    s: f64,
}

/// The same wells beside a noise, whose increments are zero here: then no step has previous ones to be compared with, and none is checked.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * a * q * q + b * q * q * q + c * q * q * q * q + d * (k * q).cos(),
    noise = [|q, p| q],
    embedding = [Midpoint],
)]
struct Driven {
    a: f64,
    b: f64,
    c: f64,
    d: f64,
    k: f64,
}

impl Derivatives for Driven {
    fn derivatives(&self, q: &[f64], p: &[f64], gradient: &mut [f64], hessian: &mut [f64]) {
        let Self { a, b, c, d, k } = *self;
        Well { a, b, c, d, k }.derivatives(q, p, gradient, hessian);
    }
}

/// First and second derivatives by `q` and `p`, in that order.
trait Derivatives {
    fn derivatives(&self, q: &[f64], p: &[f64], gradient: &mut [f64], hessian: &mut [f64]);
}

impl Derivatives for Well {
    fn derivatives(&self, q: &[f64], p: &[f64], gradient: &mut [f64], hessian: &mut [f64]) {
        let Self { a, b, c, d, k } = *self;
        let (q, p) = (q[0], p[0]);
        let force = a * q + 3.0 * b * q * q + 4.0 * c * q.powi(3) - d * k * (k * q).sin();
        gradient.copy_from_slice(&[force, p]);
        let slope = a + 6.0 * b * q + 12.0 * c * q * q - d * k * k * (k * q).cos();
        hessian.copy_from_slice(&[slope, 0.0, 0.0, 1.0]);
    }
}

impl Derivatives for Field {
    fn derivatives(&self, q: &[f64], p: &[f64], gradient: &mut [f64], hessian: &mut [f64]) {
        let Self { a, c, d, k, e, f, s } = *self;
        let (q, p) = (q[0], p[0]);
        let force = p * p * e * q + 2.0 * f * p * q + s * q.cos() + a * q + 4.0 * c * q.powi(3)
            - d * k * (k * q).sin();
        gradient.copy_from_slice(&[force, p * (1.0 + e * q * q) + f * q * q]);
        let slope = p * p * e + 2.0 * f * p - s * q.sin() + a + 12.0 * c * q * q - d * k * k * (k * q).cos();
        let mixed = 2.0 * p * e * q + 2.0 * f * q;
        hessian.copy_from_slice(&[slope, mixed, mixed, 1.0 + e * q * q]);
    }
}

impl Derivatives for Sites {
    fn derivatives(&self, q: &[f64], p: &[f64], gradient: &mut [f64], hessian: &mut [f64]) {
        let (x, y, g) = (q[0], q[1], self.g);
        let force = |x: f64| 8.0 * x.powi(3) - 6.0 * x;
        gradient.copy_from_slice(&[force(x) + g * y * y, force(y) + 2.0 * g * x * y, p[0], p[1]]);
        let slope = |x: f64| 24.0 * x * x - 6.0;
        hessian.fill(0.0);
        (hessian[0], hessian[1]) = (slope(x), 2.0 * g * y);
        (hessian[4], hessian[5]) = (2.0 * g * y, slope(y) + 2.0 * g * x);
        (hessian[10], hessian[15]) = (1.0, 1.0);
    }
}

/// Gauss nodes, weights and coefficients, from the Lagrange polynomials at the roots of a Legendre polynomial.
struct Reference {
    b: Vec<f64>,
    a: Vec<Vec<f64>>,
}

impl Reference {
    fn new(stages: usize) -> Self {
        let legendre = |n: usize, x: f64| {
            let (mut before, mut value) = (1.0, x);
            for k in 1..n {
                (before, value) =
                    (value, ((2 * k + 1) as f64 * x * value - k as f64 * before) / (k + 1) as f64);
            }
            (value, n as f64 * (before - x * value) / (1.0 - x * x))
        };
        let root = |i: usize| {
            let mut x = -(std::f64::consts::PI * (i as f64 + 0.75) / (stages as f64 + 0.5)).cos();
            for _ in 0..50 {
                let (value, slope) = legendre(stages, x);
                x -= value / slope;
            }
            x
        };
        let nodes: Vec<f64> = (0..stages).map(root).collect();
        let c: Vec<f64> = nodes.iter().map(|x| 0.5 * (x + 1.0)).collect();
        let b: Vec<f64> =
            nodes.iter().map(|&x| 1.0 / ((1.0 - x * x) * legendre(stages, x).1.powi(2))).collect();
        let lagrange = |j: usize, x: f64| -> f64 {
            (0..stages).filter(|&m| m != j).map(|m| (x - c[m]) / (c[j] - c[m])).product()
        };
        // The quadrature itself is exact for the integrals.
        let a = (0..stages)
            .map(|i| {
                (0..stages)
                    .map(|j| (0..stages).map(|m| c[i] * b[m] * lagrange(j, c[i] * c[m])).sum())
                    .collect()
            })
            .collect();
        Self { b, a }
    }

    /// Stages of a step of size `h` by Newton's method from a start; they and the sign of the determinant, or nothing unless corrections halve.
    fn solve<H: Derivatives>(
        &self,
        system: &H,
        h: f64,
        start: &[f64],
        mut y: Vec<f64>,
    ) -> Option<(Vec<f64>, bool)> {
        let (s, n) = (self.b.len(), start.len());
        let unknowns = s * n;
        let mut last = f64::INFINITY;
        for _ in 0..30 {
            let mut residual = DVector::from_fn(unknowns, |row, _| y[row] - start[row % n]);
            let mut matrix = DMatrix::<f64>::identity(unknowns, unknowns);
            for j in 0..s {
                let (mut gradient, mut hessian) = (vec![0.0; n], vec![0.0; n * n]);
                let (q, p) = y[j * n..(j + 1) * n].split_at(n / 2);
                system.derivatives(q, p, &mut gradient, &mut hessian);
                for i in 0..s {
                    for k in 0..n {
                        // dq = H_p, dp = -H_q
                        let (row, sign) = if k < n / 2 { (k + n / 2, 1.0) } else { (k - n / 2, -1.0) };
                        residual[i * n + k] -= sign * h * self.a[i][j] * gradient[row];
                        for l in 0..n {
                            matrix[(i * n + k, j * n + l)] -= sign * h * self.a[i][j] * hessian[row * n + l];
                        }
                    }
                }
            }
            let factors = matrix.lu();
            let corrections = factors.solve(&residual)?;
            let size = |v: &[f64]| v.iter().fold(0.0, |most, x| larger(most, x.abs()));
            let correction = size(corrections.as_slice());
            y.iter_mut().zip(&corrections).for_each(|(y, c)| *y -= c);
            if correction <= 1e-13 * (1.0 + size(&y)) {
                return Some((y, factors.determinant() < 0.0));
            }
            if correction.is_nan() || correction > 0.5 * last {
                return None;
            }
            last = correction;
        }
        None
    }

    /// The end of the step that continues the state; else the fraction up to which it does.
    fn follow<H: Derivatives>(&self, system: &H, h: f64, start: &[f64]) -> Result<Vec<f64>, f64> {
        const PART: f64 = 2e-3;
        let (s, n) = (self.b.len(), start.len());
        let still: Vec<f64> = (0..s * n).map(|k| start[k % n]).collect();
        let (mut before, mut now) = ((-PART, still.clone()), (0.0, still));
        let mut part = PART;
        while now.0 < 1.0 {
            let next = if now.0 + 1.001 * part >= 1.0 { 1.0 } else { now.0 + part };
            let ratio = (next - now.0) / (now.0 - before.0);
            let guess: Vec<f64> = if now.0 == 0.0 {
                now.1.clone()
            } else {
                now.1.iter().zip(&before.1).map(|(a, b)| a + ratio * (a - b)).collect()
            };
            // A predicted part is within half of what it moves, where that is anything.
            let solved = self.solve(system, next * h, start, guess.clone()).filter(|(y, is_reversed)| {
                !is_reversed && (now.0 == 0.0 || distance(y, &guess) <= 0.5 * distance(y, &now.1) + 1e-3)
            });
            match solved {
                Some((y, _)) => {
                    before = std::mem::replace(&mut now, (next, y));
                    part = (2.0 * part).min(PART);
                }
                None if part > PART / 65536.0 => part *= 0.5,
                None => return Err(now.0),
            }
        }
        let mut end = start.to_vec();
        for j in 0..s {
            let (mut gradient, mut hessian) = (vec![0.0; n], vec![0.0; n * n]);
            let (q, p) = now.1[j * n..(j + 1) * n].split_at(n / 2);
            system.derivatives(q, p, &mut gradient, &mut hessian);
            for k in 0..n / 2 {
                end[k] += h * self.b[j] * gradient[n / 2 + k];
                end[n / 2 + k] -= h * self.b[j] * gradient[k];
            }
        }
        Ok(end)
    }
}

const WELLS: [Well; 6] = [
    Well { a: -6.0, b: 0.0, c: 2.0, d: 0.0, k: 1.0 },
    Well { a: 0.0, b: 0.0, c: 0.0, d: -1.0, k: 1.0 },
    Well { a: 1.0, b: 0.0, c: 0.0, d: 0.5, k: 3.0 },
    Well { a: 1.0, b: -0.3, c: 0.1, d: 0.0, k: 1.0 },
    Well { a: -1.0, b: 0.0, c: 0.25, d: 0.0, k: 1.0 },
    Well { a: 2.0, b: 1.0, c: 0.5, d: 1.0, k: 2.0 },
];

const FIELDS: [Field; 4] = [
    Field { a: 0.0, c: 0.0, d: -1.0, k: 1.0, e: 0.0, f: 0.3, s: 0.0 },
    Field { a: 0.0, c: 0.0, d: 0.0, k: 1.0, e: 1.0, f: 0.3, s: 1.0 },
    Field { a: -2.0, c: 1.0, d: 0.0, k: 1.0, e: 0.2, f: 0.0, s: 0.0 },
    Field { a: 1.0, c: 0.0, d: 0.7, k: 2.0, e: 0.0, f: -0.5, s: 0.0 },
];

/// What became of steps from random states.
#[derive(Debug, Default)]
struct Counts {
    steps: u64,
    right: u64,
    hard: u64,
    /// Another branch as `Ok`, or one where there is none.
    wrong: u64,
    /// The same, reported as doubtful.
    doubtful: u64,
    /// Refused, though the reference goes on.
    lost: u64,
    /// Refused, and rightly so.
    refused: u64,
}

/// The end of one step from a state.
fn step<H: Discretized<E>, E>(system: &H, h: f64, [q, p]: [&[f64]; 2]) -> Result<Vec<f64>, StepFailure> {
    let mut state = state(q, p);
    system.stepper::<E>(h).unwrap().step(&mut state, &[]).map_err(|error| error.cause)?;
    Ok(numbers(&state))
}

/// The largest distance of two ends, in units of what they are. Both are solved to rounding, which conditions of 1e5 leave below 1e-8; another branch
/// is nearer only where two of them meet.
fn apart(end: &[f64], other: &[f64]) -> f64 {
    end.iter().zip(other).fold(0.0, |most, (a, b)| larger(most, (a - b).abs() / (1.0 + b.abs())))
}

/// Steps of one scheme: runs of a few from random states, of which the first has nothing to extrapolate from.
fn compare<H: Derivatives + Discretized<E>, E>(
    system: &H,
    stages: usize,
    [steps, seed]: [u64; 2],
    counts: &mut Counts,
) {
    const RUN: u32 = 4;
    let (reference, mut random, degrees) = (Reference::new(stages), Uniform(seed), system.degrees());
    let (before, dw) = (counts.steps, vec![0.0; system.increments(degrees)]);
    while counts.steps - before < steps {
        let h = 1.025 + 0.975 * random.draw();
        let q: Vec<f64> = (0..degrees).map(|_| 2.0 * random.draw()).collect();
        let p: Vec<f64> = (0..degrees).map(|_| 3.0 * random.draw()).collect();
        let mut state = state(&q, &p);
        let mut stepper = system.stepper::<E>(h).unwrap();
        for n in 0..RUN {
            let start = numbers(&state);
            let taken = stepper.step(&mut state, &dw);
            let (end, followed) = (numbers(&state), reference.follow(system, h, &start));
            let what = format!("{stages} stages, h = {h:?}, q = {q:?}, p = {p:?}, step {n}");
            counts.steps += 1;
            match (&taken, &followed) {
                (Ok(info), Ok(other)) if apart(&end, other) < 1e-8 => {
                    counts.right += 1;
                    counts.hard += u64::from(info.is_hard);
                }
                (Ok(info), other) => {
                    counts.wrong += u64::from(!info.is_doubtful);
                    counts.doubtful += u64::from(info.is_doubtful);
                    println!("another: {what}: {end:?}, {info:?} for {other:?}");
                }
                (Err(error), Ok(end)) => {
                    counts.lost += 1;
                    println!("lost: {what}: {error} for {end:?}");
                }
                (Err(_), Err(_)) => counts.refused += 1,
            }
            if taken.is_err() {
                break;
            }
        }
    }
}

/// Steps of each scheme and system, and the seed of their random states, as the environment says.
fn settings() -> [u64; 2] {
    [("STEPS", 20), ("SEED", 7)]
        .map(|(name, else_is)| std::env::var(name).map_or(else_is, |number| number.parse().unwrap()))
}

/// No other branch as `Ok`, and at most 1 % refused that can be followed. `STEPS=167 SEED=7 cargo test --workspace --release --test laws branches -- --nocapture` is 10^4 steps.
#[test]
#[cfg_attr(feature = "short", ignore = "takes long: part of .ci/release")]
fn random_steps_continue_their_state() {
    let ([steps, seed], mut all) = (settings(), Counts::default());
    macro_rules! of {
        ($system:expr, $name:expr, $($scheme:ty, $stages:expr);+) => {$(
            compare::<_, $scheme>($system, $stages, [steps, seed + $stages], &mut all);
            println!("up to {}, {}: {all:?}", $name, stringify!($scheme));
        )+};
    }
    for (i, well) in WELLS.iter().enumerate() {
        of!(well, format!("well {i}"), Midpoint, 1; Gauss<2>, 2; Gauss<3>, 3; Gauss<4>, 4; Gauss<6>, 6; Gauss<8>, 8);
    }
    for (i, field) in FIELDS.iter().enumerate() {
        of!(field, format!("field {i}"), Midpoint, 1; Gauss<2>, 2; Gauss<3>, 3; Gauss<4>, 4; Gauss<6>, 6; Gauss<8>, 8);
    }
    of!(&Sites { g: 0.1 }, "sites", Midpoint, 1; Gauss<2>, 2; Gauss<4>, 4);
    assert_eq!(all.wrong, 0, "{all:?}");
    assert!(100 * (all.lost + all.doubtful) <= all.steps, "{all:?}");
}

/// With noise, a step that is far too long may be on another branch, one in a thousand of these (docs/guide/solver.md).
#[test]
fn noisy_steps_mostly_continue_their_state() {
    let mut all = Counts::default();
    for Well { a, b, c, d, k } in WELLS {
        compare::<_, Midpoint>(&Driven { a, b, c, d, k }, 1, settings(), &mut all);
    }
    println!("with noise: {all:?}");
    assert!(100 * (all.wrong + all.lost + all.doubtful) <= all.steps, "{all:?}");
}

/// Newton's method from zero finds another branch of these, of which two have a determinant of the other sign.
#[test]
fn steps_that_took_another_branch_take_theirs() {
    for (h, q, p, end) in [
        (1.2110799095785991, 1.59361314169284, -2.913978209711982, [-0.49215, -0.53049]),
        (1.5623668714255263, 0.36399835055286367, -0.3744768562063454, [1.1389, 1.3664]),
    ] {
        let found = step::<_, Midpoint>(&WELLS[0], h, [&[q], &[p]]).unwrap();
        assert!(apart(&found, &end) < 1e-4, "h = {h}: {found:?}");
    }
}

/// Two sites whose branch folds at 0.685 of the step.
#[test]
fn a_step_without_solution_is_refused() {
    let (q, p) = ([0.28970507888540187, 0.023464527220164122], [-0.6653666178918991, 2.2717320121626834]);
    let refused = step::<_, Midpoint>(&Sites { g: 0.1 }, 1.2400922435667148, [&q, &p]);
    let Err(StepFailure::NoSolution { reached }) = refused else { panic!("{refused:?}") };
    assert!((reached - 0.685).abs() < 1e-3, "{reached}");
}

/// They were said to end at 100 and at 83 % of the step.
#[test]
fn branches_that_go_on_are_followed() {
    let start: [&[f64]; 2] = [&[2.4226158039943133], &[2.154383125221064]];
    let found = step::<_, Gauss<2>>(&FIELDS[1], 0.216771236646276, start).unwrap();
    assert!(apart(&found, &[10.52593522, 0.38384452]) < 1e-8, "{found:?}");
    let start: [&[f64]; 2] = [&[1.0408675305068087], &[-0.6035365078746842]];
    let found = step::<_, Gauss<2>>(&WELLS[0], 1.8614907200976254, start).unwrap();
    assert!(apart(&found, &[0.96902141, 0.73301663]) < 1e-8, "{found:?}");
}

/// The guess for a step after a hard one is nearer to another branch than to its own, and Newton's method contracts there at once; on the way of the
/// two sites, one iteration contracts by accident far from where it started.
#[test]
fn runs_leave_hard_steps_on_their_branch() {
    let (q, p) = ([-0.49514271753632677, -1.757832284204897], [-2.8248624702579495, -1.5356239539409942]);
    let taken = [
        follow_run(&WELLS[0], 1.1788991315147956, [&[-0.7713954891219279], &[1.2232998105796071]]),
        follow_run(&WELLS[2], 1.331842010251052, [&[0.8573843314845702], &[-2.8205404035121844]]),
        follow_run(&Sites { g: 0.1 }, 1.8443364871566015, [&q, &p]),
    ];
    assert!(taken.iter().all(|&steps| steps >= 2), "{taken:?}: too few to leave a hard step behind");
}

/// Steps of a run start from what the steps before extrapolate to, where the first of them has nothing: both have the same judge.
#[test]
fn a_run_stays_on_its_branch() {
    for h in [0.2, 0.5, 0.8, 1.1] {
        follow_run(&WELLS[0], h, [&[0.9], &[0.4]]);
    }
}

/// Steps of a run, each compared with the reference, until both refuse one; their number, at most sixty.
fn follow_run<H: Derivatives + Discretized<Midpoint>>(system: &H, h: f64, [q, p]: [&[f64]; 2]) -> u32 {
    let (reference, mut state) = (Reference::new(1), state(q, p));
    let mut stepper = system.stepper::<Midpoint>(h).unwrap();
    for n in 0..60 {
        let followed = reference.follow(system, h, &numbers(&state));
        let taken = stepper.step(&mut state, &[]);
        match (taken, followed) {
            (Ok(_), Ok(end)) => {
                assert!(apart(&numbers(&state), &end) < 1e-8, "h = {h}, {n}: {state:?} for {end:?}");
            }
            (Err(_), Err(_)) => return n,
            (taken, followed) => panic!("h = {h}, {n}: {taken:?} for {followed:?}"),
        }
    }
    60
}
