//! Every map against discrete trajectories, action values and gradients of the action computed to 40 digits.
//!
//! `data/discrete_trajectories.json` holds the inputs (all exact in binary64) and the results. The bound of 1e-12,
//! relative to the largest component of the state, leaves a few hundred roundings for ten steps.

use fixtures::extremes::{state, vector};
use fixtures::reference::{data, list, number, numbers};
use fixtures::small::Kubo;
use fixtures::steps::{distance, numbers as components};
use serde_json::Value;
use wzvi::prelude::*;
use wzvi::state::Vector;

const BOUND: f64 = 1e-12;

#[hamiltonian(
    drift = |q1, p1| (p1.powi(2) + q1.powi(2)) / 2.0,
    noise = [|_, p1| sigma * p1, |q1, _| -gamma * q1],
    embedding = [Uncorrected<DeltaPlus>, Uncorrected<DeltaMinus>, Midpoint, Uncorrected<Lambda<1, 4>>,
                 Corrected<DeltaPlus>, Mixed<DeltaPlus, Midpoint>],
)]
struct TwoAdditive {
    sigma: f64,
    gamma: f64,
}

#[hamiltonian(
    drift = |q1, p1| 0.5 * p1 * q1,
    noise = [|q1, p1| 0.75 * p1 * q1],
    embedding = [Uncorrected<DeltaPlus>, Uncorrected<DeltaMinus>, Midpoint, Uncorrected<Lambda<1, 4>>,
                 Corrected<DeltaPlus>, Mixed<DeltaPlus, Midpoint>],
)]
struct Hyperbolic;

#[hamiltonian(
    drift = |q1, p1| (1.0 + q1.powi(2)) * p1.powi(2) / 2.0,
    noise = [|q1, p1| 0.5 * p1 * q1],
    embedding = [Uncorrected<DeltaPlus>, Uncorrected<DeltaMinus>, Midpoint, Uncorrected<Lambda<1, 4>>,
                 Corrected<DeltaPlus>, Mixed<DeltaPlus, Midpoint>],
)]
struct Metric;

#[hamiltonian(
    drift = |[q1, q2], [p1, p2]|
        (p1 * p1 + p2 * p2) / 2.0 + (q1 * q1 + q2 * q2) / 2.0 + q1 * q1 * q2 - q2.powi(3) / 3.0,
    noise = [|[q1, _], _| 0.25 * q1, |[q1, q2], _| 0.125 * q1 * q2],
    embedding = [Uncorrected<DeltaPlus>, Uncorrected<DeltaMinus>, Midpoint, Uncorrected<Lambda<1, 4>>,
                 Corrected<DeltaPlus>, Mixed<DeltaPlus, Midpoint>],
)]
struct HenonHeiles;

#[hamiltonian(
    drift = |q1, p1, t| p1 * p1 / 2.0 + (1.0 + 0.5 * (2.0 * t).cos()) * q1 * q1 / 2.0,
    noise = [|q1, p1, t| 0.25 * t.sin() * q1 * p1, |q1, _, t| (0.5 + t).ln() * q1],
    embedding = [Uncorrected<DeltaPlus>, Uncorrected<DeltaMinus>, Midpoint, Uncorrected<Lambda<1, 4>>,
                 Corrected<DeltaPlus>, Mixed<DeltaPlus, Midpoint>],
)]
struct ParametricTime;

fn check_trajectory<E, H: Discretized<E>>(system: &H, case: &Value, map: &str) {
    let trajectory = &case["trajectories"][map];
    let mut state = state::<H::Vector>(&numbers(&case["q0"]), &numbers(&case["p0"])).at(number(&case["t0"]));
    let mut stepper = system.stepper::<E>(number(&case["h"])).unwrap();
    for i in 0..10 {
        stepper.step(&mut state, &numbers(&case["dW"][i])).unwrap();
        let exact = [numbers(&trajectory["q"][i + 1]), numbers(&trajectory["p"][i + 1])].concat();
        let error = distance(&components(&state), &exact) / distance(&exact, &vec![0.0; exact.len()]);
        assert!(error <= BOUND, "{map}, step {i}: off by {error:.1e}: {state:?} instead of {exact:?}");
    }
}

/// `S = Σ_i L_d(q_i, q_{i+1}, P_i)` with `P_i = (1-l) p_i + l p_{i+1}`, and its gradient by the chain rule.
fn check_action<E, H: Discretized<E>>(system: &H, case: &Value, map: &str, l: f64) {
    let check = &case["action_check"];
    let expected = &check[map];
    let n = check["N"].as_u64().unwrap() as usize;
    let (h, t0) = (number(&case["h"]), number(&case["t0"]));
    let node = |key: &str, i: usize| numbers(&check[key][i]);
    let d = node("q", 0).len();
    let (mut action, mut by_q, mut by_p) = (0.0, vec![vec![0.0; d]; n + 1], vec![vec![0.0; d]; n + 1]);
    for i in 0..n {
        let p: Vec<f64> =
            node("p", i).iter().zip(&node("p", i + 1)).map(|(a, b)| (1.0 - l) * a + l * b).collect();
        let segment = wzvi::system::Segment {
            q0: vector(&node("q", i)),
            q1: vector(&node("q", i + 1)),
            p: vector(&p),
            t: t0 + i as f64 * h,
            h,
        };
        let dw = numbers(&case["dW"][i]);
        action += system.discrete_lagrangian(&segment, &dw);
        let gradient = system.discrete_lagrangian_gradient(&segment, &dw);
        for j in 0..d {
            by_q[i][j] += gradient.q0.components()[j];
            by_q[i + 1][j] += gradient.q1.components()[j];
            by_p[i][j] += (1.0 - l) * gradient.p.components()[j];
            by_p[i + 1][j] += l * gradient.p.components()[j];
        }
    }
    let want = number(&expected["S"]);
    assert!((action - want).abs() <= BOUND * want.abs().max(1.0), "{map}: S = {action}, not {want}");
    for (key, got) in [("dS_dq", by_q), ("dS_dp", by_p)] {
        for (i, got) in got.iter().enumerate() {
            let want = numbers(&expected[key][i]);
            assert!(distance(got, &want) <= BOUND, "{map}: {key}[{i}] = {got:?}, not {want:?}");
        }
    }
}

/// All maps and actions of one case.
macro_rules! check_case {
    ($test:ident, $name:literal, $system:expr) => {
        #[test]
        fn $test() {
            let file = data("discrete_trajectories");
            let case = list(&file["cases"]).iter().find(|case| case["name"] == $name).unwrap();
            let system = $system;
            check_trajectory::<Uncorrected<DeltaPlus>, _>(&system, case, "delta_plus");
            check_trajectory::<Uncorrected<DeltaMinus>, _>(&system, case, "delta_minus");
            check_trajectory::<Midpoint, _>(&system, case, "midpoint");
            check_trajectory::<Uncorrected<Lambda<1, 4>>, _>(&system, case, "lambda_quarter");
            check_trajectory::<Corrected<DeltaPlus>, _>(&system, case, "delta_plus_counter_dw");
            check_trajectory::<Mixed<DeltaPlus, Midpoint>, _>(&system, case, "mixed_drift0_noise_half");
            check_action::<Uncorrected<DeltaPlus>, _>(&system, case, "delta_plus", 0.0);
            check_action::<Midpoint, _>(&system, case, "midpoint", 0.5);
            check_action::<Uncorrected<Lambda<1, 4>>, _>(&system, case, "lambda_quarter", 0.25);
        }
    };
}

check_case!(kubo, "kubo", Kubo { a: 1.5, sigma: 1.0 });
check_case!(two_additive, "two_additive", TwoAdditive { sigma: 0.75, gamma: 1.0 });
check_case!(hyperbolic, "hyperbolic_pq", Hyperbolic);
check_case!(metric, "metric_1d", Metric);
check_case!(henon_heiles, "henon_heiles", HenonHeiles);
check_case!(parametric_time, "parametric_time", ParametricTime);
