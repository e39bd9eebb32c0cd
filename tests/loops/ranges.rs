//! Ranges and numbers of items that only the running program knows, against the same sums in Rust.

use wzvi::prelude::*;

const ONE: usize = 1;
const TWO: usize = 2;
const FIVE: i64 = 5;
const FACTOR: i32 = 3;
const HALF: f64 = 0.5;

/// Systems with sums over their coordinates, and the same sums as `reference`.
macro_rules! sums {
    ($($name:ident = |$q:ident, $m:ident| $sum:expr;)*) => {$(
        #[hamiltonian(
            drift = |$q: &[f64], p: &[f64]| 0.5 * p.iter().map(|p| p * p).sum::<f64>() + $sum,
            embedding = DeltaPlus,
        )]
        #[derive(Clone, Debug)]
        struct $name {
            $m: usize,
        }

        impl $name {
            fn reference(&self, $q: &[f64]) -> f64 {
                let $m = self.$m;
                $sum
            }

            /// The energy, and the force by the change of the momenta in a step.
            fn check() {
                for (degrees, $m) in (1..6).flat_map(|degrees| (0..8).map(move |m| (degrees, m))) {
                    let system = Self { $m };
                    let at: Vec<f64> = (0..degrees).map(|i| 0.3 + 0.37 * f64::from(i)).collect();
                    let mut state = State::new(at.clone(), vec![0.0; at.len()]);
                    let (found, expected) = (system.energy(&state), system.reference(&at));
                    let label = concat!(stringify!($name), " of degrees and m");
                    assert!((found - expected).abs() < 1e-13 * (1.0 + expected.abs()), "{label} {degrees} {}", $m);
                    system.stepper::<DeltaPlus>(1.0).unwrap().step(&mut state, &[]).unwrap();
                    for i in 0..at.len() {
                        let moved = |by: f64| {
                            let mut at = at.clone();
                            at[i] += by;
                            system.reference(&at)
                        };
                        // The error of the difference is d² / 6 times a third derivative, and rounding over d.
                        let force = -(moved(1e-4) - moved(-1e-4)) / 2e-4;
                        assert!((state.p[i] - force).abs() < 1e-6, "{label} {degrees} {}: force {i}", $m);
                    }
                }
            }
        }
    )*};
}

sums! {
    Twice = |q, m| (m..q.len())
        .map(|i| (0..q.len()).map(|j| if i < 2 * j { q[i] * q[j] * q[j] } else { 0.3 * q[i] }).sum::<f64>())
        .sum::<f64>();
    Alike = |q, m| (m..q.len())
        .map(|i| (0..q.len()).map(|j| if i == 2 * j { q[i] * q[j] * q[j] } else { 0.3 * q[i] }).sum::<f64>())
        .sum::<f64>();
    Wrapped = |q, m| (0..q.len())
        .map(|i| (0..q.len()).map(|j| if i <= (j + m) % 3 { q[i] * q[j] * q[j] } else { q[j] }).sum::<f64>())
        .sum::<f64>();
    Skipped = |q, m| q[0] * (q.iter().skip(m).count() + q.windows(3).len() + (m..q.len()).len()) as f64;
    Arithmetic = |q, m| (TWO - ONE..=(TWO * TWO)).chain(0..TWO * TWO + ONE - 1).map(|i| q[i % q.len()] * (i + m) as f64).sum::<f64>()
        + (-FIVE..FIVE).map(|i| i as f64 * q[(i + FIVE) as usize % q.len()].cos()).sum::<f64>();
    Divided = |q, m| (0..q.len()).map(|i| (i as i64 - m as i64).div_euclid(3) as f64 * q[i]).sum::<f64>();
    Compared = |q, m| q[0].powi((TWO + ONE) as i32) * if TWO * ONE == 2 && TWO > ONE { 1.5 } else { 0.5 }
        + q.iter().skip(TWO - ONE).step_by(2).sum::<f64>() * TWO.pow(3).min(TWO * 3) as f64
        + q[m % q.len()] * match (TWO + ONE) % TWO { 1 => -HALF / (HALF - 2.0), _ => HALF }
        + q[0] * f64::from(-FACTOR) + q[0] * f64::from(FACTOR * FACTOR)
        + q[0] * if HALF < HALF * HALF { -HALF } else { HALF - HALF * HALF };
    Chained = |q, m| q.iter().skip(m).chain(q.iter().take(2)).enumerate().map(|(i, q)| q * q * i as f64).sum::<f64>();
}

#[test]
fn an_outer_loop_is_not_split_by_the_variable_of_an_inner_one() {
    Twice::check();
    Alike::check();
    Wrapped::check();
}

#[test]
fn iterators_have_no_negative_number_of_items() {
    Skipped::check();
    Chained::check();
}

#[test]
fn arithmetic_of_constants_has_their_type() {
    Arithmetic::check();
    Divided::check();
    Compared::check();
}
