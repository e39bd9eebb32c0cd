//! The same closure twice: compiled by the macro, and by `rustc` as it stands.
//!
//! Energies may differ by what another order of additions and shared subexpressions cost (1e-14, some tens of
//! roundings, relative to the value), and symbolic gradients from those of dual numbers by 1e-12 of their size.

use wzvi::functions::{erf, erfc, j1, sinc};
use wzvi::prelude::*;
use wzvi::scalar::Dual;

/// Where every function is smooth: 0 < q < 1 < p.
const POINTS: [(f64, f64, f64); 8] = [
    (0.5, 2.0, 0.0),
    (0.125, 1.25, 1.0),
    (0.3, 1.7, -2.5),
    (0.9, 1.1, 0.1),
    (0.61, 2.9, 4.0),
    (0.07, 1.01, 0.75),
    (0.99, 3.5, -0.3),
    (0.414, 1.618, 2.75),
];

fn check<H: Hamiltonian>(
    name: &str,
    system: &H,
    exact: impl Fn(f64, f64, f64) -> f64,
    state: impl Fn(f64, f64, f64) -> State<H::Vector>,
) {
    for (q, p, t) in POINTS {
        let (energy, expected) = (system.energy(&state(q, p, t)), exact(q, p, t));
        let error = (energy - expected).abs();
        assert!(error <= 1e-14 * expected.abs(), "{name} at {q}, {p}, {t}: {energy} instead of {expected}");

        let [dual_q, dual_p] = Dual::<2>::variables([q, p]);
        let dual = system.evaluate(0, &[dual_q], &[dual_p], t);
        let [mut dq, mut dp] = [[0.0]; 2];
        system.differentiate(0, &[q], &[p], t, &mut dq, &mut dp);
        let scale = dual.derivative.iter().fold(expected.abs(), |scale, slope| scale.max(slope.abs()));
        for (found, expected) in [dq[0], dp[0]].into_iter().zip(dual.derivative) {
            let error = (found - expected).abs();
            assert!(error <= 1e-12 * scale, "{name} at {q}, {p}, {t}: slope {found} instead of {expected}");
        }
    }
}

/// One test per closure. The fields are in scope of both.
macro_rules! same_as_rust {
    ($a:ident, $n:ident, $k:ident; $($name:ident: $closure:expr;)*) => { $(
        #[test]
        #[allow(dead_code, unused_variables, clippy::all)]
        fn $name() {
            #[hamiltonian(drift = $closure, embedding = DeltaPlus)]
            struct System {
                $a: f64,
                $n: i32,
                $k: [f64; 3],
            }

            let system = System { $a: 1.375, $n: 3, $k: [0.5, -1.25, 2.0] };
            let ($a, $n, $k) = (1.375_f64, 3_i32, [0.5, -1.25, 2.0_f64]);
            check(stringify!($name), &system, typed($closure), |q, p, t| {
                let mut state = State::new([q], [p]);
                state.t = t;
                state
            });
        }
    )* };
}

/// Tells `rustc` what the parameters are.
fn typed<F: Fn(f64, f64, f64) -> f64>(f: F) -> F {
    f
}

same_as_rust! { a, n, k;
    oscillator: |q, p, _| 0.5 * a * (q * q + p * p);
    precedence: |q, p, _| q - p - a + q / p / a * 3.0 - -q * p;
    literals: |q, p, _| 1e-3 * q + 2_000.5 * p + 2f64 + 1.0e3 / 7. - 0.1;
    roots: |q, p, _| q.sqrt() * p.cbrt() + f64::sqrt(p) / f64::cbrt(q) + q.recip();
    integer_powers: |q, p, _| q.powi(3) - p.powi(-2) + q.powi(1) * p.powi(7) + q.powi(0);
    large_powers: |q, p, _| p.powi(40) + q.powi(-12) + f64::powi(p, 13);
    real_powers: |q, p, _| q.powf(1.5) + p.powf(-0.3) + q.powf(p) + f64::powf(p, 2.0);
    parameter_power: |q, p, _| q.powi(n) * p + p.powi(n);
    exponentials: |q, p, _| q.exp() + (-p).exp2() + q.exp_m1() * f64::exp(-p * p);
    logarithms: |q, p, _| p.ln() + q.ln_1p() + p.log2() * 3.0 + p.log10() + p.log(3.0);
    circular: |q, p, _| q.sin() + 2.0 * p.cos() * q.tan() + f64::sin(q * p) + 4.0;
    arcs: |q, p, _| q.asin() + q.acos() * p.atan() + q.atan2(p) + p.atan2(-q);
    hyperbolic: |q, p, _| q.sinh() + p.cosh() * q.tanh();
    inverse_hyperbolic: |q, p, _| q.asinh() + p.acosh() + q.atanh() * p;
    special: |q, p, _| erf(q) + erfc(p) * sinc(q * p) + wzvi::functions::j0(p) * j1(q) + q.sinc() * p.j1() - q.j0();
    hypotenuse: |q, p, _| q.hypot(p) + f64::hypot(a, q);
    sine_and_cosine: |q, p, _| { let (s, c) = q.sin_cos(); s * p + c * c + p.sin_cos().1.powi(2) };
    pieces: |q, p, _| (q - p).abs() + p.signum() + q.min(p) + q.max(0.4) + f64::max(q, a);
    clamped: |q, p, _| p.clamp(0.0, 1.5) * q + q.clamp(0.2, 0.8);
    fused: |q, p, _| q.mul_add(p, 3.0) + f64::mul_add(a, q, p);
    angles: |q, p, _| q.to_radians() + p.to_degrees();
    time: |q, p, t| p * p + (1.0 + 0.5 * t.cos()) * q * q + t * t;
    shadowing: |q, p, _| { let q = 2.0 * q; let q: f64 = q + p; let a = 3.0; q * q * a };
    closures: |q, p, _| {
        let spring = |x: f64, (k, l): (f64, f64)| 0.5 * k * (x - l) * (x - l);
        let shifted = move |x: f64| spring(x + a, (2.0, 0.5));
        let spring_at_one = |x: f64| spring(x, (a, 1.0));
        let apply = |f: &dyn Fn(f64) -> f64, x: f64| f(x);
        shifted(q) + apply(&spring_at_one, p) + p * shifted(q * p)
    };
    branches: |q, p, _| if q > 0.5 && !(p < 1.5) || q == 0.125 { q * p } else if q <= 0.3 { p * p } else { a + q };
    parameter_branches: |q, p, _| if a > 1.0 { q * p } else { p } + if n as f64 != 3.0 || q > p { q } else { 2.0 * p };
    nested_branches: |q, p, _| (if q < 0.5 { if p > 1.5 { q } else { p } } else { q * q }) * (if a == 1.375 { 2.0 } else { 1.0 });
    pairs_of_branches: |q, p, _| { let (x, y) = if q != 0.3 { (q, 2.0 * p) } else { (p, q) }; x * x + y };
    blocks: |q, p, _| { const HALF: f64 = 0.5; p + { let x = HALF * q; let y = { x * x }; y } };
    loops: |q, p, _| { let mut s = p; for i in 1..=4 { s += q * i as f64; s *= 1.25; } s /= 2.0; s -= p; s };
    sums: |q, p, _| (0..5).map(|i| (i as f64 + 1.0) * q.powi(i)).sum::<f64>() + p;
    nested_sums: |q, p, _| (0..4).map(|i| (0..i).map(|j| (i * j) as f64 * q + p).sum::<f64>()).sum::<f64>() + 1.0;
    products: |q, p, _| (1..=4).map(|i| q + i as f64).product::<f64>() * p;
    lists: |q, p, _| { let v = [q, p, q * p]; v[0] + 2.0 * v[(1 + 4) % 3] + v.len() as f64 + [q; 3][1] };
    fields: |q, p, _| k[0] * q + k[1] * p * p + k[2] + n as f64 + f64::from(n) * 0.5;
    zips: |q, p, _| [q, p, 1.0].iter().zip(k.iter()).map(|(x, k)| x * k).sum::<f64>() + 7.0;
    windows: |q, p, _| [q, p, a, q * q].windows(2).map(|w| (w[1] - w[0]).powi(2)).sum::<f64>();
    folds: |q, p, _| [q, p, a].iter().enumerate().fold(1.0, |s, (i, x)| s * (x + i as f64));
    filters: |q, p, _| (0..9).filter(|i| i % 3 == 1).map(|i| q.powi(i)).sum::<f64>() + p;
    chains: |q, p, _| [q].iter().chain(&[p, a]).rev().skip(1).step_by(1).copied().map(f64::sqrt).sum::<f64>();
    flat: |q, p, _| (0..2).flat_map(|i| (0..3).map(move |j| (i, j))).map(|(i, j)| q * i as f64 + p * j as f64).sum();
    integers: |q, p, _| q * (7 / 2 * 3 % 5 + 2_i32.pow(5) - (-3_i32).abs()) as f64 + p * (7_i32.min(4) as f64);
    constants: |q, p, _| q * std::f64::consts::PI + p / std::f64::consts::SQRT_2 + f64::EPSILON + f64::MAX.recip();
    rational: |q, p, _| (1.0 + q * q) / (p * p - q) + (q + p) / (q * p) / (1.0 + q);
    factored: |q, p, _| a * q * q + a * q * p + 3.0 * a * q + (q + 1.0) * (p - 3.0) * (q + 1.0);
    composed: |q, p, _| ((q * q + p).ln().sin() + 2.0).sqrt().exp() / (1.0 + (q * p).tanh().powi(2));
    kepler: |q, p, _| 0.5 * p * p - 1.0 / (q * q + 0.25).sqrt() + (q * q + 0.25).powf(-1.5);
    morse: |q, p, _| p * p / 2.0 + a * (1.0 - (-0.75 * (q - 0.5)).exp()).powi(2);
    bindings: |q, p, _| { let [x, .., z] = [q, a, p]; let r = &q; *r * x + z + if true { p } else { q } };
    captures: |q, p, _| { let mut f = 0.0; let g = move |x: f64| x + f; f = 1.0; g(q) + p + f };
    unpacked: |q, p, _| { let v = |x: f64, (y, z): (f64, f64)| x * y + z; v(q, (p, a)) + v(p, (a, q)) };
    collected: |q, p, _| { let v: Vec<f64> = (0..3).map(|i| q + i as f64).collect(); v[2] * p + v[1..].iter().sum::<f64>() };
    mapped: |q, p, _| [0.5; 3].map(|x| x * q).iter().sum::<f64>() + (0..3).zip(1..).map(|(i, j)| q * (i * j) as f64 + p).sum::<f64>();
    reversed: |q, p, _| (1..=3).rev().skip(1).take(1).step_by(1).map(|i| p + f64::from(i)).product::<f64>() * q;
    small_differences: |q, p, _| (1.0 - q.cos()) + (q.exp() - 1.0) + (1.0 + q).ln() + p;
}

/// Each of the shapes of phase space, once.
#[test]
fn shapes() {
    #[hamiltonian(
        drift = |q: [[f64; 2]; 2], p: [[f64; 2]; 2]|
            p.iter().map(|p| 0.5 * p[0] * p[0] + p[1]).sum::<f64>() + (q[1][0] - q[0][1]).powi(2),
        embedding = Midpoint,
    )]
    struct Points;
    let state = State::new([1.0, 2.0, 5.0, 4.0], [1.0, 10.0, 3.0, 100.0]);
    assert_eq!(Points.energy(&state), 0.5 + 10.0 + 4.5 + 100.0 + 9.0);
    let gradient = Points.energy_gradient(&state);
    assert_eq!(gradient.q.as_slice(), [0.0, -6.0, 6.0, 0.0]);
    assert_eq!(gradient.p.as_slice(), [1.0, 1.0, 3.0, 1.0]);

    #[hamiltonian(drift = |[x, y], [px, py]| x * py - y * px, embedding = Midpoint)]
    struct Named;
    assert_eq!(Named.energy(&State::new([1.0, 2.0], [3.0, 5.0])), -1.0);
}
