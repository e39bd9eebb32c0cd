//! Systems of elements: masses and places of very different size, and all units.

use fixtures::steps::distance;
use fixtures::wave;
use wzvi::prelude::*;

/// On-site springs, springs to the next, and a quartic coupling, with masses of their own; as loops and unrolled.
macro_rules! chain {
    ($name:ident, $point:ty) => {
        #[hamiltonian(
            drift = |q: $point, p: $point| {
                (0..q.len()).map(|i| p[i] * p[i] / (2.0 * mass[i]) + 0.5 * own[i] * q[i] * q[i]).sum::<f64>()
                    + (1..q.len()).map(|i| {
                        let d = q[i] - q[i - 1];
                        0.5 * next[i - 1] * d * d + 0.25 * quartic * d * d * d * d
                    }).sum::<f64>()
            },
            embedding = Midpoint,
        )]
        struct $name {
            mass: [f64; 8],
            own: [f64; 8],
            next: [f64; 7],
            quartic: f64,
        }
    };
}

/// Without the quartic coupling.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + q.iter().map(|q| 0.5 * k * q * q).sum::<f64>()
            + (1..q.len()).map(|i| 0.5 * k * (q[i] - q[i - 1]) * (q[i] - q[i - 1])).sum::<f64>()
    },
    embedding = Midpoint,
)]
struct LinearChain {
    k: f64,
}

chain!(Chain, &[f64]);
chain!(Unrolled, [f64; 8]);

/// A free body, and two on springs.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        (0..q.len()).map(|i| p[i] * p[i] / (2.0 * mass[i]) + 0.5 * own[i] * q[i] * q[i]).sum::<f64>()
    },
    embedding = Midpoint,
)]
struct Bodies {
    mass: Vec<f64>,
    own: Vec<f64>,
}

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + (0..side).map(|i| (0..side).map(|j| {
                let own = q[i * side + j];
                let (right, down) = (q[i * side + (j + 1) % side] - own, q[(i + 1) % side * side + j] - own);
                0.5 * k * (right * right + down * down)
            }).sum::<f64>()).sum::<f64>()
    },
    embedding = Midpoint,
)]
struct Lattice {
    side: usize,
    k: f64,
}

/// `q' = (q (1 - a) + h p / m) / (1 + a)`, `a = h² k / 4m`
fn spring_step(q: f64, p: f64, mass: f64, k: f64, h: f64) -> f64 {
    let a = 0.25 * h * h * k / mass;
    (q * (1.0 - a) + h * p / mass) / (1.0 + a)
}

#[test]
fn a_heavy_body_far_away_hides_nothing() {
    let h = 0.1;
    for (mass, off, k) in [(1e9, 1e6, 300.0), (1e12, 1e10, 1e4), (1e30, 1e20, 1e3), (1e-30, 1e-10, 1e6)] {
        let bodies = Bodies { mass: vec![mass, 1.0, 1.0], own: vec![0.0, k, 2.0 * k] };
        let mut state = State::new(vec![off, 0.3, -0.2], vec![mass, 0.5, 0.1]);
        bodies.stepper::<Midpoint>(h).unwrap().step(&mut state, &[]).unwrap();
        for (i, (q, p, k)) in [(0.3, 0.5, k), (-0.2, 0.1, 2.0 * k)].into_iter().enumerate() {
            let exact = spring_step(q, p, 1.0, k, h);
            let error = (state.q[i + 1] - exact).abs();
            // Of the start, of the increment, and of their sum: four roundings.
            assert!(
                error <= 4.0 * f64::EPSILON * q.abs(),
                "M = {mass:e}, k = {k}: {} {exact}",
                state.q[i + 1]
            );
        }
    }
}

/// Masses over 30 decades, each with a spring that gives it a frequency of its own between 1 and 30.
fn mixed(order: &[i32; 8], quartic: f64) -> ([f64; 8], [f64; 8], [f64; 7], f64) {
    let mass = order.map(|decade| 10.0_f64.powi(decade));
    let own = std::array::from_fn(|i| mass[i] * (1.0 + (3 * i % 8) as f64).powi(2));
    let next = std::array::from_fn(|i| 0.5 * mass[i].min(mass[i + 1]));
    (mass, own, next, quartic)
}

#[test]
fn masses_over_thirty_decades_go_as_in_the_unrolled_step() {
    for order in
        [[-15, -10, -5, 0, 4, 8, 12, 15], [15, -15, 10, -10, 5, -5, 0, 1], [0, 15, 14, 0, -15, -14, 3, 0]]
    {
        for (quartic, h) in [(0.0, 0.1), (0.0, 1.0), (1e-15, 0.1)] {
            let (mass, own, next, quartic) = mixed(&order, quartic);
            let (chain, unrolled) =
                (Chain { mass, own, next, quartic }, Unrolled { mass, own, next, quartic });
            let q: [f64; 8] = std::array::from_fn(|i| (1.3 * i as f64).sin());
            let p: [f64; 8] = std::array::from_fn(|i| mass[i] * (0.7 * i as f64).cos());
            let mut one = State::new(q.to_vec(), p.to_vec());
            let mut other = State::new(q, p);
            let mut stepper = chain.stepper::<Midpoint>(h).unwrap();
            let mut expected = unrolled.stepper::<Midpoint>(h).unwrap();
            for n in 0..20 {
                stepper
                    .step(&mut one, &[])
                    .unwrap_or_else(|error| panic!("{order:?}, h = {h}, step {n}: {error}"));
                expected.step(&mut other, &[]).unwrap();
                for (i, mass) in mass.iter().enumerate() {
                    // Each by its own size: amplitude 1 to 2, speed up to 8 times that; 20 steps of some roundings.
                    let (dq, dp) = (one.q[i] - other.q[i], (one.p[i] - other.p[i]) / mass);
                    assert!(
                        dq.abs() <= 1e-13 && dp.abs() <= 1e-12,
                        "{order:?}, quartic {quartic:e}, h = {h}, step {n}, site {i}: {dq:e} {dp:e}"
                    );
                }
            }
        }
    }
}

/// So many steps of `h`, all of which are taken.
fn go<H: Discretized<Midpoint>>(
    system: &H,
    state: &mut State<H::Vector>,
    h: f64,
    steps: u32,
    what: impl Fn() -> String,
) {
    let mut stepper = system.stepper::<Midpoint>(h).unwrap();
    for n in 0..steps {
        stepper.step(state, &[]).unwrap_or_else(|error| panic!("{}, step {n}: {error}", what()));
    }
}

/// The step of a linear system, scaled by 10^k, is the scaled step.
#[test]
fn linear_systems_are_homogeneous() {
    for stiffness in [1.0, 1e4, 1e8] {
        let chain = LinearChain { k: stiffness };
        let step = |scale: f64| {
            let q = (0..8).map(|i| scale * (1.3 * f64::from(i)).sin()).collect::<Vec<_>>();
            let p = (0..8).map(|i| scale * (0.7 * f64::from(i)).cos()).collect::<Vec<_>>();
            let mut state = State::new(q, p);
            go(&chain, &mut state, 0.1, 5, || format!("{scale:e}"));
            state
        };
        let one = step(1.0);
        for k in (-290..=290).step_by(10) {
            let scale = 10.0_f64.powi(k);
            let scaled = step(scale);
            // The force is a difference of terms of `stiffness`, five times over.
            let bound = 100.0 * f64::EPSILON * (1.0 + stiffness.sqrt());
            for i in 0..8 {
                let (dq, dp) = (scaled.q[i] / scale - one.q[i], scaled.p[i] / scale - one.p[i]);
                assert!(
                    dq.abs() <= bound && dp.abs() <= bound * (1.0 + stiffness.sqrt()),
                    "1e{k}, {stiffness:e}, {i}: {dq:e} {dp:e}"
                );
            }
        }
    }
}

#[test]
fn a_stiff_lattice_is_homogeneous() {
    let lattice = Lattice { side: 64, k: 1e4 };
    let step = |scale: f64| {
        let mut state = State::new(wave(4096, scale, 0.0), wave(4096, scale, 1.0));
        go(&lattice, &mut state, 0.01, 2, || format!("{scale:e}"));
        state
    };
    let one = step(1.0);
    for k in [-280, -150, 150, 280] {
        let scale = 10.0_f64.powi(k);
        let scaled = step(scale);
        let size = one.q.amax();
        let error = distance((&scaled.q / scale).as_slice(), one.q.as_slice());
        assert!(error <= 1e-12 * size, "1e{k}: {error:e}");
    }
}

/// Long chains at rest, displaced as a whole, and with rounding for an amplitude.
#[test]
fn chains_at_rest_far_from_the_origin() {
    const STEPS: u32 = 1000;
    let chain = Chain { mass: [1.0; 8], own: [0.0; 8], next: [100.0; 7], quartic: 10.0 };
    for place in [0.0, 1.0, -1e6, 1e12] {
        for exponent in [-300, -20, -16, -10, -3] {
            let amplitude = 10.0_f64.powi(exponent);
            let q: Vec<f64> = (0..8).map(|i| place + amplitude * (1.3 * f64::from(i)).sin()).collect();
            let mut state = State::new(q.clone(), vec![0.0; 8]);
            go(&chain, &mut state, 0.05, STEPS, || format!("{place:e}, 1e{exponent}"));
            let moved = distance(state.q.as_slice(), &q);
            // Rounding of places gives the whole chain a speed: a random walk of kicks of h k ε |place|.
            let kick = 5.0 * f64::EPSILON * place.abs();
            let bound = 10.0 * amplitude + 10.0 * kick * 0.05 * f64::from(STEPS).powf(1.5);
            assert!(moved <= bound, "{place:e}, 1e{exponent}: {moved:e} > {bound:e}");
        }
    }
}
