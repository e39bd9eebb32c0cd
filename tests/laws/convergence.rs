//! Orders of convergence on shared Wiener paths, against exact solutions or a fine step on the path.
//!
//! Strong errors are root mean squares over paths at `T = 1`. The slope of `log2 error` over `log2 h` is fitted by
//! least squares; its standard error comes from the jackknife over ten batches of paths. A slope passes within four of
//! them and [`SYSTEMATIC`], the terms of higher order at these step sizes (`O(h)` or `O(√h)` of the error at the
//! coarsest step, spread over the fit) and the error of the reference (at most `h_ref/h = 1/16` of the finest).

use std::any::type_name;
use std::ops::RangeInclusive;

use fixtures::small::{DoubleWell, KUBO, Kubo, TwoAdditive};
use wzvi::prelude::*;
use wzvi::state::Vector;

const SYSTEMATIC: f64 = 0.08;
const BATCHES: usize = 10;
const SEED: u64 = 20_250_101;

type Point = Vec<f64>;

/// The state at `T = 1` on the path that `noise` is at, in `2^level` steps.
fn end<E, H: Discretized<E>>(system: &H, start: &State<H::Vector>, level: u32, noise: &mut Wiener) -> Point {
    let steps = 1_u64 << level;
    let h = 1.0 / steps as f64;
    let path =
        system.simulate::<E>(h).start(start.clone()).noise(noise).steps(steps).record_every(0).run().unwrap();
    [path.last().q.components(), path.last().p.components()].concat()
}

fn square_distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum()
}

/// Slope of a least-squares line through `(x, y)`.
fn slope(x: &[f64], y: &[f64]) -> f64 {
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let (mx, my) = (mean(x), mean(y));
    let covariance: f64 = x.iter().zip(y).map(|(x, y)| (x - mx) * (y - my)).sum();
    covariance / x.iter().map(|x| (x - mx).powi(2)).sum::<f64>()
}

/// Mean squares per batch and level.
struct Errors {
    name: &'static str,
    levels: Vec<u32>,
    batches: Vec<Vec<f64>>,
}

impl Errors {
    /// `square_error(path, level)` over `paths` paths.
    fn new(
        name: &'static str,
        levels: impl Iterator<Item = u32>,
        paths: usize,
        mut square_errors: impl FnMut(u64, &[u32]) -> Vec<f64>,
    ) -> Self {
        let levels: Vec<u32> = levels.collect();
        let mut batches = vec![vec![0.0; levels.len()]; BATCHES];
        for path in 0..paths {
            let batch = &mut batches[path * BATCHES / paths];
            for (sum, square) in batch.iter_mut().zip(square_errors(path as u64, &levels)) {
                *sum += square * BATCHES as f64 / paths as f64;
            }
        }
        Self { name, levels, batches }
    }

    /// Root mean squares per level without batch `omitted`.
    fn without(&self, omitted: Option<usize>) -> Vec<f64> {
        let kept: Vec<_> = self
            .batches
            .iter()
            .enumerate()
            .filter(|(i, _)| Some(*i) != omitted)
            .map(|(_, batch)| batch)
            .collect();
        (0..self.levels.len())
            .map(|l| (kept.iter().map(|batch| batch[l]).sum::<f64>() / kept.len() as f64).sqrt())
            .collect()
    }

    /// A statistic of the root mean squares, and its standard error.
    fn jackknife(&self, statistic: impl Fn(&[f64]) -> f64) -> (f64, f64) {
        let n = BATCHES as f64;
        let parts: Vec<f64> = (0..BATCHES).map(|i| statistic(&self.without(Some(i)))).collect();
        let mean = parts.iter().sum::<f64>() / n;
        let variance = parts.iter().map(|x| (x - mean).powi(2)).sum::<f64>() * (n - 1.0) / n;
        (statistic(&self.without(None)), variance.sqrt())
    }

    fn check_order(&self, expected: f64) {
        let x: Vec<f64> = self.levels.iter().map(|&level| -f64::from(level)).collect();
        let of = |errors: &[f64]| slope(&x, &errors.iter().map(|error| error.log2()).collect::<Vec<_>>());
        let (slope, error) = self.jackknife(of);
        let errors: Vec<String> = self.without(None).iter().map(|error| format!("{error:.2e}")).collect();
        println!("{}: order {slope:.3} ± {error:.3}, errors {errors:?}", self.name);
        assert!((slope - expected).abs() <= 4.0 * error + SYSTEMATIC, "{}: {slope} ± {error}", self.name);
        // An estimate that could not tell 1/2 from 1 is none.
        assert!(4.0 * error <= 0.15, "{}: ± {error}", self.name);
    }
}

/// Errors against the mid-point rule at `2^fine` steps on the same path.
fn strong<E, H>(system: &H, start: State<H::Vector>, levels: RangeInclusive<u32>, fine: u32) -> Errors
where
    H: Discretized<E> + Discretized<Midpoint>,
{
    Errors::new(type_name::<(E, H)>(), levels, 300, |path, levels| {
        let mut noise = Wiener::seed(SEED).path(path);
        let exact = end::<Midpoint, H>(system, &start, fine, &mut noise);
        levels
            .iter()
            .map(|&level| square_distance(&end::<E, H>(system, &start, level, &mut noise), &exact))
            .collect()
    })
}

/// Errors of a scheme on Kubo's oscillator from (0, 1) against the rotation by `a + sigma W(1)`.
fn kubo<E>(levels: impl Iterator<Item = u32>, paths: usize) -> Errors
where
    Kubo: Discretized<E>,
{
    Errors::new(type_name::<(E, Kubo)>(), levels, paths, |path, levels| {
        // As they are: the constant of the error is that of Gaussian increments.
        let mut noise = Wiener::seed(SEED).path(path).untruncated();
        let (sin, cos) = (KUBO.a + KUBO.sigma * noise.value(0, 1.0).unwrap()).sin_cos();
        let start = State::new([0.0], [1.0]);
        levels
            .iter()
            .map(|&level| square_distance(&end::<E, Kubo>(&KUBO, &start, level, &mut noise), &[sin, cos]))
            .collect()
    })
}

#[test]
fn kubo_by_the_midpoint_has_order_one_and_the_predicted_constant() {
    kubo::<Midpoint>(4..=8, 500).check_order(1.0);
    kubo::<Corrected<DeltaPlus>>(5..=9, 500).check_order(1.0);

    let errors = kubo::<Midpoint>(8..=8, 6000);
    let Kubo { a, sigma } = KUBO;
    let expected = (15.0 * sigma.powi(6) / 144.0 + (a * sigma * sigma / 4.0).powi(2)).sqrt();
    let (constant, error) = errors.jackknife(|errors| 256.0 * errors[0]);
    println!("Kubo, Midpoint: error / h = {constant:.4} ± {error:.4}, predicted {expected:.4}");
    assert!((constant / expected - 1.0).abs() <= 0.05, "{constant} ± {error} instead of {expected}");
    assert!(4.0 * error <= 0.06 * expected, "± {error}");
}

/// `E|z(1)|²` of a scheme that is linear in the state, in `2^level` steps from (0, 1) with Gaussian increments: exact,
/// since the second moments of a step are polynomials of degree 4 in ΔW at most, for which five nodes of Gauss and
/// Hermite are exact.
fn second_moment(level: u32) -> f64 {
    let (a, b) = (5.0 - 10f64.sqrt(), 5.0 + 10f64.sqrt());
    let (wa, wb) = ((7.0 + 2.0 * 10f64.sqrt()) / 60.0, (7.0 - 2.0 * 10f64.sqrt()) / 60.0);
    let nodes = [(0.0, 8.0 / 15.0), (a.sqrt(), wa), (-a.sqrt(), wa), (b.sqrt(), wb), (-b.sqrt(), wb)];
    let h = 1.0 / f64::from(1_u32 << level);
    // Rows of E[(qq, qp, pp)'] in terms of (qq, qp, pp), from the images of (1, 0) and (0, 1).
    let mut map = [[0.0; 3]; 3];
    for (node, weight) in nodes {
        let image = |q: f64, p: f64| {
            let mut state = State::new([q], [p]);
            let mut stepper = KUBO.stepper::<Uncorrected<DeltaPlus>>(h).unwrap();
            stepper.step(&mut state, &[h.sqrt() * node]).unwrap();
            [state.q[0], state.p[0]]
        };
        let ([qa, pa], [qb, pb]) = (image(1.0, 0.0), image(0.0, 1.0));
        let rows = [
            [qa * qa, 2.0 * qa * qb, qb * qb],
            [qa * pa, qa * pb + qb * pa, qb * pb],
            [pa * pa, 2.0 * pa * pb, pb * pb],
        ];
        for (sum, row) in map.iter_mut().flatten().zip(rows.iter().flatten()) {
            *sum += weight * row;
        }
    }
    let mut moments = [0.0, 0.0, 1.0];
    for _ in 0..1_u32 << level {
        moments = map.map(|row| row.iter().zip(&moments).map(|(a, b)| a * b).sum());
    }
    moments[0] + moments[2]
}

#[test]
fn kubo_by_delta_plus_converges_to_the_predicted_wrong_limit() {
    // docs/guide/theory.md, section 4.
    const LIMIT: f64 = 1.415_701_365_42;
    // Richardson extrapolation of an error h (c1 + c2 h + c3 h²), with a rest of the order h⁴.
    let mut table: Vec<f64> = (8..12).map(second_moment).collect();
    println!("Kubo, DeltaPlus: E|z(1)|² = {table:?}");
    let mut factor = 2.0;
    while table.len() > 1 {
        table = table.windows(2).map(|pair| (factor * pair[1] - pair[0]) / (factor - 1.0)).collect();
        factor *= 2.0;
    }
    println!("Kubo, DeltaPlus: E|z(1)|² -> {:.12}, predicted {LIMIT}", table[0]);
    // h⁴ at 2^-8 times a constant, and 4096 roundings; the prediction has 12 digits.
    assert!((table[0] - LIMIT).abs() <= 1e-10, "{}", table[0]);

    // Random paths agree within their confidence interval, far away from 1.
    let (level, paths) = (9, 4000_u32);
    let (mut sum, mut squares) = (0.0, 0.0);
    for path in 0..paths {
        let mut noise = Wiener::seed(SEED).path(u64::from(path)).untruncated();
        let start = State::new([0.0], [1.0]);
        let z = end::<Uncorrected<DeltaPlus>, _>(&KUBO, &start, level, &mut noise);
        let square = z[0] * z[0] + z[1] * z[1];
        sum += square;
        squares += square * square;
    }
    let n = f64::from(paths);
    let mean = sum / n;
    let error = ((squares / n - mean * mean) / (n - 1.0)).sqrt();
    println!("Kubo, DeltaPlus: E|z(1)|² = {mean:.4} ± {error:.4} from {paths} paths, h = 2^-{level}");
    // Four standard errors; the bias at this step is known.
    assert!((mean - second_moment(level)).abs() <= 4.0 * error, "{mean} ± {error}");
    assert!(mean - 1.0 >= 10.0 * error);

    kubo::<Uncorrected<DeltaPlus>>(6..=10, 500).check_order(0.0);
}

#[test]
fn one_nonlinear_noise() {
    let (system, start) = (DoubleWell { sigma: 0.3 }, State::new([0.5], [0.5]));
    strong::<Midpoint, _>(&system, start, 4..=8, 12).check_order(1.0);
    strong::<Corrected<DeltaPlus>, _>(&system, start, 4..=8, 12).check_order(1.0);
    strong::<Corrected<Lambda<1, 4>>, _>(&system, start, 4..=8, 12).check_order(1.0);
    // The wrong limit does not depend on h: H0 - sigma² q p / 2.
    strong::<Uncorrected<DeltaPlus>, _>(&system, start, 8..=10, 12).check_order(0.0);
}

#[hamiltonian(
    drift = |q, p| 0.5 * (p * p + q * q),
    noise = [|q, _| 0.5 * sigma * q * q, |_, p| 0.5 * sigma * p * p],
    embedding = [Midpoint, DeltaPlus],
)]
struct NonCommuting {
    sigma: f64,
}

#[test]
#[cfg_attr(feature = "short", ignore = "takes the longest: part of .ci/release")]
fn noises_that_do_not_commute_halve_the_order() {
    let (system, start) = (NonCommuting { sigma: 1.0 }, State::new([0.3], [1.0]));
    strong::<Midpoint, _>(&system, start, 4..=8, 13).check_order(0.5);
    strong::<DeltaPlus, _>(&system, start, 4..=8, 13).check_order(0.5);
}

/// Two commuting noises with `D = 0`, whose mixed product `∂H_1/∂q · ∂H_2/∂p = w a` is not constant: the algebra of
/// `1, x, y, x y` with `x² = y² = 0` acts on (a, b, c, d).
#[hamiltonian(
    drift = |[_a, _b, _c, _d], [_s, _u, _v, _w]| 0.0,
    noise = [
        |[a, _, c, _], [_, u, _, w]| u * a + w * c,
        |[a, b, _, _], [_, _, v, w]| v * a + w * b,
    ],
    embedding = [DeltaPlus, Corrected<DeltaPlus>, Midpoint],
)]
struct Nilpotent;

#[test]
fn corrected_has_order_one_where_noises_commute() {
    let start: State<<Nilpotent as Hamiltonian>::Vector> =
        State::new([1.0, 0.5, -0.5, 0.25], [0.5, 1.0, -1.0, 2.0]);
    let exact = |[x, y]: [f64; 2]| {
        let ([a, b, c, d], [s, u, v, w]): ([f64; 4], [f64; 4]) = (start.q.into(), start.p.into());
        vec![
            a,
            b + x * a,
            c + y * a,
            d + x * c + y * b + x * y * a,
            s - x * u - y * v + x * y * w,
            u - y * w,
            v - x * w,
            w,
        ]
    };
    let errors = |path: u64, distance: &mut dyn FnMut(&mut Wiener, &[f64]) -> Vec<f64>| {
        let mut noise = Wiener::seed(SEED).path(path).untruncated();
        let w = [0, 1].map(|k| noise.value(k, 1.0).unwrap());
        distance(&mut noise, &exact(w))
    };
    Errors::new("commuting, DeltaPlus", 4..=8, 400, |path, levels| {
        errors(path, &mut |noise, exact| {
            let ends = levels.iter().map(|&level| end::<DeltaPlus, _>(&Nilpotent, &start, level, noise));
            ends.map(|end| square_distance(&end, exact)).collect()
        })
    })
    .check_order(0.5);
    // With the counter-term each step is the exact flow of its increments.
    for path in 0..100 {
        errors(path, &mut |noise, exact| {
            let end = end::<Corrected<DeltaPlus>, _>(&Nilpotent, &start, 8, noise);
            // A few roundings of each of 256 steps.
            let bound = 1e-15 * 256.0 * exact.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
            assert!(square_distance(&end, exact).sqrt() <= bound, "{end:?} instead of {exact:?}");
            vec![]
        });
    }
}

#[test]
fn additive_noise() {
    let (system, start) = (TwoAdditive { sigma: 0.75, gamma: 1.0 }, State::new([0.3], [1.0]));
    strong::<Midpoint, _>(&system, start, 4..=8, 12).check_order(1.0);
    strong::<DeltaPlus, _>(&system, start, 4..=8, 12).check_order(1.0);
}
