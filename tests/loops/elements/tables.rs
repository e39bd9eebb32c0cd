//! Lists of tuples, lists of lists, and loops that add up.

use fixtures::steps::refused;
use wzvi::prelude::*;

use super::{NetworkUnrolled, ROUNDING, difference};

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let mut total = 0.0;
        for p in p {
            total += 0.5 * p * p;
        }
        for &(a, b, k) in &self.bonds {
            total += k * (1.0 - (q[a] - q[b]).cos());
        }
        for (i, list) in self.near.iter().enumerate() {
            for &j in list.iter() {
                total += 1.5 * (1.0 - (q[i] - q[j]).cos());
            }
        }
        total
    },
    noise = [|q, p, k| sigma * (k as f64 + 1.0) * q[k]; self.near.len()],
    embedding = [Midpoint, DeltaPlus],
)]
struct Listed {
    bonds: Vec<(usize, usize, f64)>,
    near: Vec<Vec<usize>>,
    sigma: f64,
}

fn listed() -> Listed {
    Listed { bonds: vec![(0, 2, 2.0), (3, 2, 0.5)], near: vec![vec![], vec![0], vec![], vec![]], sigma: 0.4 }
}

#[test]
fn tuples_and_lists_of_lists_place_elements() {
    let unrolled = NetworkUnrolled { sigma: 0.4 };
    let dw = [0.1, -0.2, 0.05, 0.3];
    assert_eq!(listed().noises(), 4);
    assert!(difference::<Midpoint, _, _>(&listed(), &unrolled, 0.1, &dw, 20) < ROUNDING);
    assert!(difference::<DeltaPlus, _, _>(&listed(), &unrolled, 0.1, &dw, 20) < ROUNDING);
}

#[test]
fn what_they_hold_is_checked_before_a_step() {
    let mut beyond = listed();
    beyond.near[2].push(7);
    let state = State::new(vec![0.1; 4], vec![0.0; 4]);
    let error = refused(&state, |state| beyond.stepper::<Midpoint>(0.1).unwrap().step(state, &[0.0; 4]));
    assert!(error.cause.to_string().starts_with("`near[2][0]` is 7, but the state has 4;"), "{error}");
}
