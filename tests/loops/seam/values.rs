//! Random systems emitted both ways, value by value.
//!
//! Tolerances are running error bounds: the same function is evaluated on numbers that carry the bound of their own
//! rounding ([`Rounded`]), of which two evaluations in different orders may be apart by as much as both have. Nothing is
//! compared with a fixed number.

use std::array::from_fn;

use wzvi::prelude::*;
use wzvi::scalar::{Dual, Rounded, Scalar};
use wzvi::state::Vector;

use fixtures::Uniform as Random;
use fixtures::extremes::state;
use fixtures::schemes::Scheme;
use fixtures::steps::segment;

use crate::random::{every_random_array, every_random_system, generic, literal};

const H: f64 = 1.0 / 64.0;
const CASES: usize = 12;
const STEPS: usize = 20;

/// What is compared where, and the largest difference in units of its bound.
struct Comparison<'n> {
    name: &'n str,
    worst: f64,
}

impl Comparison<'_> {
    /// Two values that have at most the errors of `bound` each.
    #[track_caller]
    fn close(&mut self, what: &str, a: f64, b: f64, bound: f64) {
        let apart = (a - b).abs();
        assert!(
            apart <= 2.0 * bound,
            "{}: {what}: {a:e} and {b:e} are {apart:.1e} apart, {bound:.1e}",
            self.name
        );
        self.worst = self.worst.max(if bound > 0.0 { apart / bound } else { 0.0 });
    }

    #[track_caller]
    fn rounded(&mut self, what: &str, a: Rounded, b: Rounded) {
        self.close(what, a.value, b.value, a.error.max(b.error));
    }
}

fn lifted<const N: usize>(z: [f64; N]) -> [Rounded; N] {
    z.map(Rounded::exact)
}

/// The gradient of a term, coordinates first, with its bound.
fn gradient<S: Scalar, const N: usize>(system: &impl Hamiltonian, term: usize, z: [S; N], t: f64) -> [S; N] {
    let mut slopes = [S::from_f64(0.0); N];
    let (dq, dp) = slopes.split_at_mut(N / 2);
    system.differentiate(term, &z[..N / 2], &z[N / 2..], t, dq, dp);
    slopes
}

/// Energies, gradients and rates of every term.
fn compare_values<const N: usize, A, B>(a: &A, b: &B, random: &mut Random, to: &mut Comparison<'_>)
where
    A: Hamiltonian,
    B: Hamiltonian,
{
    assert_eq!((a.degrees(), a.noises(), a.invariants()), (b.degrees(), b.noises(), b.invariants()));
    for _ in 0..CASES {
        let (z, t): ([f64; N], f64) = (from_fn(|_| 2.0 * random.draw()), random.draw());
        let exact = lifted(z);
        let (q, p) = exact.split_at(N / 2);
        let (x, y) = z.split_at(N / 2);
        let (of_a, of_b) = (state::<A::Vector>(x, y).at(t), state::<B::Vector>(x, y).at(t));
        let of_drift = gradient(a, 0, exact, t);
        for term in 0..=a.noises() {
            to.rounded("energy", a.evaluate(term, q, p, t), b.evaluate(term, q, p, t));
            let slopes = gradient(a, term, exact, t);
            for (a, b) in slopes.into_iter().zip(gradient(b, term, exact, t)) {
                to.rounded("gradient", a, b);
            }
            let Some(k) = term.checked_sub(1) else { continue };
            let mut rate = Rounded::exact(0.0);
            for i in 0..N / 2 {
                let (i, j) = (i, N / 2 + i);
                rate = rate + slopes[j] * of_drift[i] - slopes[i] * of_drift[j];
            }
            to.close("energy rate", a.energy_rate(k, &of_a), b.energy_rate(k, &of_b), rate.error);
        }
    }
}

/// `L_d` and its gradient by `(q_i, q_{i+1}, P)` with their bounds, from gradients of the Hamiltonians.
fn lagrangian<E: Scheme, const N: usize>(
    system: &impl Hamiltonian,
    [q0, q1, p]: [&[f64]; 3],
    [t, h]: [f64; 2],
    dw: &[f64],
) -> (Rounded, [Vec<Rounded>; 3]) {
    let d = N / 2;
    let exact = |x: f64| Rounded::exact(x);
    let mut value = exact(0.0);
    let mut slopes = [vec![exact(0.0); d], vec![exact(0.0); d], vec![exact(0.0); d]];
    for i in 0..d {
        let u = exact(q1[i]) - exact(q0[i]);
        value = value + exact(p[i]) * u;
        slopes[0][i] = -exact(p[i]);
        slopes[1][i] = exact(p[i]);
        slopes[2][i] = u;
    }
    let point = |l: f64| -> [Rounded; N] {
        from_fn(|i| match i.checked_sub(d) {
            None => exact(q0[i]) + (exact(q1[i]) - exact(q0[i])) * l,
            Some(i) => exact(p[i]),
        })
    };
    for term in 0..=dw.len() {
        let (l, weight) = if term == 0 { (E::L[0], h) } else { (E::L[1], dw[term - 1]) };
        let (z, t) = (point(l), t + l * h);
        value = value - system.evaluate(term, &z[..d], &z[d..], t) * weight;
        let slope = gradient(system, term, z, t);
        for i in 0..d {
            slopes[0][i] = slopes[0][i] - slope[i] * ((1.0 - l) * weight);
            slopes[1][i] = slopes[1][i] - slope[i] * (l * weight);
            slopes[2][i] = slopes[2][i] - slope[d + i] * weight;
        }
    }
    if E::IS_CORRECTED {
        counter_bounds::<N>(system, &point(E::L[1]), t + E::L[1] * h, dw, &mut value, &mut slopes);
    }
    (value, slopes)
}

/// Adds the bounds of the counter-term `(1/2 - l) Σ_jk ΔW_j ΔW_k ∂H_j/∂q · ∂H_k/∂p`: its products are as exact as its
/// factors, second derivatives as first ones relative to their size, which takes as many operations.
fn counter_bounds<const N: usize>(
    system: &impl Hamiltonian,
    z: &[Rounded; N],
    t: f64,
    dw: &[f64],
    value: &mut Rounded,
    slopes: &mut [Vec<Rounded>; 3],
) {
    let d = N / 2;
    let (mut sum, mut by) = ([Rounded::exact(0.0); N], [[Rounded::exact(0.0); N]; N]);
    for (k, &dw) in dw.iter().enumerate() {
        let slope = gradient(system, k + 1, *z, t);
        for j in 0..N {
            sum[j] = sum[j] + slope[j] * dw;
            let direction: [_; N] = from_fn(|i| match i == j {
                true => Dual::<1>::variable(z[i].value, 0),
                false => Dual::constant(z[i].value),
            });
            for (i, second) in gradient(system, k + 1, direction, t).into_iter().enumerate() {
                let size = slope[i].error / slope[i].value.abs().max(f64::MIN_POSITIVE);
                let error = second.derivative[0].abs() * size.clamp(f64::EPSILON, 1.0);
                by[j][i] = by[j][i] + Rounded { value: second.derivative[0], error } * dw;
            }
        }
    }
    let pair = |a: &[Rounded; N], b: &[Rounded; N]| (0..d).fold(0.0, |all, i| all + (a[i] * b[d + i]).error);
    value.error += pair(&sum, &sum);
    for j in 0..N {
        let error = pair(&by[j], &sum) + pair(&sum, &by[j]);
        match j.checked_sub(d) {
            None => slopes[..2].iter_mut().for_each(|part| part[j].error += error),
            Some(j) => slopes[2][j].error += error,
        }
    }
}

/// The discrete Lagrangian, its gradient, and one step with its momentum.
fn compare_scheme<E: Scheme, const N: usize, A, B>(a: &A, b: &B, random: &mut Random, to: &mut Comparison<'_>)
where
    A: Discretized<E>,
    B: Discretized<E>,
{
    let (of_a, of_b) = (A::PLAN, B::PLAN);
    assert_eq!((of_a.noise, of_a.consistent), (of_b.noise, of_b.consistent), "{}", to.name);
    assert_eq!(of_a.conserves_energy, of_b.conserves_energy, "{}", to.name);
    assert_eq!(of_a.commuting, of_b.commuting, "{}", to.name);
    for case in 0..CASES {
        let h = if case % 4 == 3 { -H } else { H };
        let (z, t): ([f64; N], f64) = (from_fn(|_| random.draw()), random.draw());
        let dw: Vec<f64> = (0..a.noises()).map(|_| H.sqrt() * random.draw()).collect();
        compare_lagrangians::<E, N, A, B>(a, b, (z, [t, h], &dw), random, to);
        compare_steps::<E, N, A, B>(a, b, (z, [t, h], &dw), to);
    }
    compare_paths::<E, N, A, B>(a, b, random, to);
}

fn compare_lagrangians<E: Scheme, const N: usize, A: Discretized<E>, B: Discretized<E>>(
    a: &A,
    b: &B,
    (z, [t, h], dw): ([f64; N], [f64; 2], &[f64]),
    random: &mut Random,
    to: &mut Comparison<'_>,
) {
    let q1: Vec<f64> = z[..N / 2].iter().map(|q| q + 0.1 * random.draw()).collect();
    let nodes = [&z[..N / 2], &q1, &z[N / 2..]];
    let (value, slopes) = lagrangian::<E, N>(a, nodes, [t, h], dw);
    let (of_a, of_b) = (segment::<A::Vector>(nodes, [t, h]), segment::<B::Vector>(nodes, [t, h]));
    let values = [a.discrete_lagrangian(&of_a, dw), b.discrete_lagrangian(&of_b, dw)];
    to.close("discrete Lagrangian", values[0], values[1], value.error);
    let (of_a, of_b) = (a.discrete_lagrangian_gradient(&of_a, dw), b.discrete_lagrangian_gradient(&of_b, dw));
    let parts = [(&of_a.q0, &of_b.q0), (&of_a.q1, &of_b.q1), (&of_a.p, &of_b.p)];
    for ((a, b), bounds) in parts.into_iter().zip(&slopes) {
        for ((a, b), bound) in a.components().iter().zip(b.components()).zip(bounds) {
            to.close("gradient of the discrete Lagrangian", *a, *b, bound.error);
        }
    }
}

/// One step of numbers of any kind.
fn step<E, S: Scalar, const N: usize, H: Discretized<E>>(
    system: &H,
    [t, h]: [f64; 2],
    mut z: [S; N],
    dw: &[S],
) -> [S; N] {
    let (q, p) = z.split_at_mut(N / 2);
    let prepared = system.prepare(h).unwrap();
    system.advance(&prepared, t, h, q, p, dw, &mut Default::default()).unwrap();
    z
}

/// What rounding may do to a step, component by component: that of its last iteration, by the equations that it solves.
fn bounds<E, const N: usize, H: Discretized<E>>(
    system: &H,
    z: [f64; N],
    at: [f64; 2],
    dw: &[f64],
) -> [f64; N] {
    let dw: Vec<Rounded> = dw.iter().copied().map(Rounded::exact).collect();
    step::<E, Rounded, N, H>(system, at, lifted(z), &dw).map(|x| x.error)
}

fn momentum<E, const N: usize, H: Discretized<E>>(
    system: &H,
    ends: [[f64; N]; 2],
    [t, h]: [f64; 2],
    dw: &[f64],
) -> Vec<f64> {
    let [before, after] = ends.map(|z| state(&z[..N / 2], &z[N / 2..]));
    system.step_momentum(&before.at(t), &after.at(t + h), h, dw).components().to_vec()
}

fn compare_steps<E: Scheme, const N: usize, A: Discretized<E>, B: Discretized<E>>(
    a: &A,
    b: &B,
    (z, at, dw): ([f64; N], [f64; 2], &[f64]),
    to: &mut Comparison<'_>,
) {
    let bounds = bounds::<E, N, A>(a, z, at, dw);
    let (by_a, by_b) = (step::<E, f64, N, A>(a, at, z, dw), step::<E, f64, N, B>(b, at, z, dw));
    for i in 0..N {
        to.close("step", by_a[i], by_b[i], bounds[i]);
    }
    let of_a = momentum::<E, N, A>(a, [z, by_a], at, dw);
    let of_b = momentum::<E, N, B>(b, [z, by_b], at, dw);
    for i in 0..N / 2 {
        to.close("momentum", of_a[i], of_b[i], 4.0 * bounds[N / 2 + i]);
    }
}

/// Steps one after the other, each way with its memory.
fn compare_paths<E: Scheme, const N: usize, A: Discretized<E>, B: Discretized<E>>(
    a: &A,
    b: &B,
    random: &mut Random,
    to: &mut Comparison<'_>,
) {
    let mut of_a: [f64; N] = from_fn(|_| random.draw());
    let mut of_b = of_a;
    let (prepared_a, prepared_b) = (a.prepare(H).unwrap(), b.prepare(H).unwrap());
    let (mut memory_a, mut memory_b) = (Default::default(), Default::default());
    // Errors of all steps before, and a short time to grow in.
    let mut bound = 0.0_f64;
    for step in 0..STEPS {
        let t = 0.25 + step as f64 * H;
        let dw: Vec<f64> = (0..a.noises()).map(|_| H.sqrt() * random.draw()).collect();
        let own = bounds::<E, N, A>(a, of_a, [t, H], &dw);
        bound = 1.5 * bound + own.into_iter().fold(0.0, f64::max);
        let (q, p) = of_a.split_at_mut(N / 2);
        a.advance(&prepared_a, t, H, q, p, &dw, &mut memory_a).unwrap();
        let (q, p) = of_b.split_at_mut(N / 2);
        b.advance(&prepared_b, t, H, q, p, &dw, &mut memory_b).unwrap();
        of_a.iter().zip(&of_b).for_each(|(a, b)| to.close("path", *a, *b, bound));
    }
}

macro_rules! check {
    ($test:ident, $name:ident { $($fields:tt)* }, $n:literal, [$($scheme:ty),*]) => {
        #[test]
        fn $test() {
            let (a, b) = (literal::$name { $($fields)* }, generic::$name { $($fields)* });
            let mut random = Random($n + stringify!($test).bytes().map(u64::from).sum::<u64>());
            let mut to = Comparison { name: stringify!($test), worst: 0.0 };
            compare_values::<$n, _, _>(&a, &b, &mut random, &mut to);
            $(
                assert!(<literal::$name as Discretized<$scheme>>::IN_LOOPS.is_none(), "in loops");
                assert!(<generic::$name as Discretized<$scheme>>::IN_LOOPS.is_some(), "in straight lines");
                compare_scheme::<$scheme, $n, _, _>(&a, &b, &mut random, &mut to);
                println!("{}: {}: at most {:.2} of the bound apart", to.name, stringify!($scheme), to.worst);
            )*
        }
    };
}

every_random_system!(check);
every_random_array!(check);
