//! Every expression, statement and method. Values are in `tests/steps/values.rs`.
#![deny(warnings)]

use wzvi::prelude::*;

#[hamiltonian(
    drift = |q, p| {
        let roots = q.sqrt() + q.cbrt() + q.recip() + f64::sqrt(q) + f64::recip(p);
        let powers = q.powi(3) + q.powi(-2) + q.powf(1.5) + f64::powf(q, 0.3) + f64::powi(p, 2);
        let logarithms = q.exp() + q.exp2() + q.exp_m1() + q.ln() + q.ln_1p() + q.log(3.0) + q.log2() + q.log10();
        let circular = q.sin() + q.cos() + q.tan() + q.asin() + q.acos() + q.atan() + q.atan2(p) + q.hypot(p);
        let hyperbolic = q.sinh() + q.cosh() + q.tanh() + q.asinh() + p.acosh() + q.atanh();
        let pieces = q.abs() + q.signum() + q.min(p) + q.max(p) + q.clamp(0.0, 1.0) + q.mul_add(p, 1.0);
        let angles = q.to_radians() + q.to_degrees();
        let (sine, cosine) = q.sin_cos();
        roots + powers + logarithms + circular + hyperbolic + pieces + angles + sine * cosine
    },
    embedding = DeltaPlus,
)]
struct Functions;

#[hamiltonian(
    drift = |q, p| {
        const HALF: f64 = 0.5;
        // Shadowing.
        let q = 2.0 * q;
        let square = |x: f64| x * x;
        let spring = |x: f64, (k, l): (f64, f64)| HALF * k * square(x - l);
        let lifted = move |y| spring(y, (a, 1.0));
        let mut total = 0.0;
        for i in 0..3 {
            total += lifted(q * i as f64);
            total -= 0.5;
        }
        total *= 2.0;
        total /= 3.0;
        let [first, .., last] = [q, p, a];
        let (x, y) = if q > p && !(p < 0.0) || q == 1.0 { (first, last) } else { (last, first) };
        let inner = {
            let z = x - y;
            z * z
        };
        let z = if a <= 0.0 { inner } else if a != 2.0 { -inner } else { 1e-3 * inner };
        let r = &z;
        total + *r + (if 1 < 2 { p } else { q }) + 1_000.5 + 2f64 + (2_u8 as f64) + (7 / 2 * 3 % 5) as f64
    },
    embedding = [Midpoint, DeltaPlus],
)]
struct Statements {
    a: f64,
}

#[hamiltonian(
    drift = |q: [f64; 4], p: [f64; 4]| {
        let kinetic: f64 = p.iter().map(|p| 0.5 * p * p).sum();
        let ring: f64 = (0..4).map(|i| (q[(i + 1) % 4] - q[i]).powi(2)).sum();
        let chain: f64 = q.windows(2).map(|w| (w[1] - w[0]).cos()).sum();
        let table = q.iter().zip(&self.k).map(|(q, k)| k * q * q).sum::<f64>();
        let pairs: f64 = (0..4).map(|i| (0..i).map(|j| (q[i] - q[j]).powi(2)).sum::<f64>()).sum();
        let enumerated: f64 = q.iter().enumerate().map(|(i, x)| i as f64 * x).sum();
        let folded = q.iter().fold(1.0, |product, x| product * (1.0 + 0.1 * x * x));
        let product = p[1..3].iter().product::<f64>();
        let odd: f64 = (0..4).filter(|i| i % 2 == 1).map(|i| q[i]).sum();
        let stepped: f64 = (0..=3).rev().step_by(2).skip(1).take(1).map(|i| q[i]).sum();
        let chained: f64 = q.iter().chain(p.iter()).copied().sum();
        let flat: f64 = (0..2).flat_map(|i| (0..2).map(move |j| (i, j))).map(|(i, j)| q[i] * p[j]).sum();
        let list: Vec<f64> = q.iter().map(|x| x * x).collect();
        let mapped = q.map(|x| 2.0 * x);
        let [a, rest @ ..] = q;
        let total = list[0] + list.len() as f64 + mapped[3] + a + rest[0] + [0.5; 3][1];
        kinetic + ring + chain + table + pairs + enumerated + folded + product + odd + stepped + chained + flat + total
    },
    embedding = Midpoint,
)]
struct Iterators {
    k: [f64; 4],
}

#[test]
fn compiles_and_runs() {
    let mut state = State::new([0.25], [1.5]);
    assert!(Functions.energy(&state).is_finite());
    Statements { a: 1.0 }.stepper::<DeltaPlus>(0.01).unwrap().step(&mut state, &[]).unwrap();
    let mut state = State::new([0.1, 0.2, 0.4, 0.3], [0.5, 0.25, -0.5, -0.25]);
    Iterators { k: [1.0; 4] }.stepper::<Midpoint>(0.001).unwrap().step(&mut state, &[]).unwrap();
}
