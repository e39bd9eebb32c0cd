//! Kepler's flow as the flow of a part of the drift. `wzvi-runtime/src/scheme/compose/kepler.rs` tests the flow itself
//! against references.

use fixtures::extremes::state;
use fixtures::steps::{
    advance, asymmetry, distance, end, lagrangian_gradient_off, refused, step_apart, way_back,
};
use wzvi::error::StepFailure;
use wzvi::lanes::Lanes;
use wzvi::prelude::*;
use wzvi::scalar::{Dual, Scalar as _};

type Aba = Composed<Verlet, Aba864>;

/// A star and two planets in the coordinates of Jacobi: each planet is seen from the centre of mass of the bodies inside of
/// its orbit.
#[hamiltonian(
    drift = [
        |q: [[f64; 3]; 2], p: [[f64; 3]; 2]| {
            let distance = |q: [f64; 3]| q.iter().map(|x| x * x).sum::<f64>().sqrt();
            let square = |p: [f64; 3]| p.iter().map(|x| x * x).sum::<f64>();
            let (m0, [m1, m2]) = (star, planets);
            let inner = m0 + m1;
            0.5 * square(p[0]) * inner / (m0 * m1) + 0.5 * square(p[1]) * (inner + m2) / (inner * m2)
                - m0 * m1 / distance(q[0]) - inner * m2 / distance(q[1])
        },
        |q: [[f64; 3]; 2], _| {
            // From the outer planet to a point on the line through the star and the inner one.
            let distance = |at: f64| (0..3).map(|i| (q[1][i] - at * q[0][i]).powi(2)).sum::<f64>().sqrt();
            let (m0, [m1, m2]) = (star, planets);
            let inner = m0 + m1;
            inner * m2 / distance(0.0) - m0 * m2 / distance(-m1 / inner) - m1 * m2 / distance(m0 / inner)
        },
    ],
    embedding = [Verlet, Gauss<8>],
)]
struct TwoPlanets {
    star: f64,
    planets: [f64; 2],
}

impl TwoPlanets {
    /// Planets like Jupiter and Saturn but for a factor of their masses. G, the mass of the star and the larger axis of the
    /// inner orbit are 1.
    fn scaled(scale: f64) -> Self {
        Self { star: 1.0, planets: [9.5e-4 * scale, 2.9e-4 * scale] }
    }

    /// Pericentres of orbits with the eccentricities 0.05 and 0.06 and the axes 1 and 1.83.
    fn start(&self) -> [Vec<f64>; 2] {
        let [m1, m2] = self.planets;
        let inner = self.star + m1;
        let (first, second) = (m1 / inner, m2 * inner / (inner + m2));
        let (sin, cos) = 1.2_f64.sin_cos();
        let (r, v) = (1.83 * 0.94, (1.06_f64 / 0.94 / 1.83).sqrt());
        let q = vec![0.95, 0.0, 0.0, r * cos, r * sin, 0.03];
        let p = vec![0.0, first * (1.05_f64 / 0.95).sqrt(), 0.0, -second * v * sin, second * v * cos, 0.0];
        [q, p]
    }

    /// The distance of the coordinates from the exact ones after 1.2 orbits of the inner planet.
    fn error<E>(&self, steps: u32) -> f64
    where
        Self: Discretized<E>,
    {
        let [q, p] = self.start();
        let [ours, exact] =
            [end::<E, _>(self, [&q, &p], 7.5, steps), end::<Gauss<8>, _>(self, [&q, &p], 7.5, 60)];
        distance(&ours[..6], &exact[..6])
    }
}

/// The error is `ε h^8 + ε² h^6 + ε³ h^4` with the masses `ε` of the planets: with those of the solar system it falls with
/// `h^8` and is of the size of `ε`, with heavier planets with `h^4` in short steps. Orders show to within 0.4, where other
/// terms are not small yet, or no longer.
#[test]
fn planets_have_errors_that_are_small_by_their_masses() {
    let shows = |scale: f64, steps: u32, order: f64| {
        let system = TwoPlanets::scaled(scale);
        let [coarse, fine] = [steps, 2 * steps].map(|steps| system.error::<Aba>(steps));
        let measured = (coarse / fine).log2();
        assert!((measured - order).abs() < 0.4, "{order}: {measured} of {coarse:e}, {fine:e}");
    };
    shows(1.0, 6, 8.0);
    shows(100.0, 24, 4.0);
    let [whole, hundredth] = [1.0, 0.01].map(|scale| TwoPlanets::scaled(scale).error::<Aba>(12));
    assert!((whole / hundredth / 100.0 - 1.0).abs() < 0.05, "{whole:e} {hundredth:e}");
    // Kicks and drifts at the cost of more forces: 102 for 84.
    assert!(TwoPlanets::scaled(1.0).error::<Composed<Verlet, KahanLi8>>(6) > 1e5 * whole);
}

/// Twenty orbits of the inner planet with 20 steps each have 2800 forces. The energy error of flows of kicks and drifts
/// is of the size of the orbits, that of Kepler's flow by the masses of the planets smaller, and in `h^8`.
#[test]
fn energies_are_kept_better_than_by_kicks_and_drifts_at_equal_forces() {
    let system = TwoPlanets::scaled(1.0);
    let [q, p] = system.start();
    let h = std::f64::consts::TAU / 20.0;
    let ours = system.simulate::<Aba>(h).start(state(&q, &p)).steps(400).run().unwrap().energy_drift(&system);
    let run = system.simulate::<Composed<Verlet, KahanLi8>>(17.0 / 7.0 * h).start(state(&q, &p));
    let theirs = run.steps(164).unwatched().run().unwrap().energy_drift(&system);
    assert!(ours < 1e-9 && theirs > 1e5 * ours, "{ours:e} {theirs:e}");
}

/// Bodies in loops: two in the field of a centre, one in a repulsive one, and one that is free.
#[hamiltonian(
    drift = [
        |q: [[f64; 3]; N], p: [[f64; 3]; N]| {
            (0..N).map(|i| p[i].iter().map(|p| p * p).sum::<f64>() / (2.0 * mass[i])).sum::<f64>()
                - (0..N).map(|i| strength[i] / q[i].iter().map(|x| x * x).sum::<f64>().sqrt()).sum::<f64>()
        },
        |q: [[f64; 3]; N], _| epsilon * (1..N).map(|i| (q[i][0] - q[i - 1][1]).powi(2)).sum::<f64>(),
    ],
    embedding = [Verlet, Gauss<8>],
)]
struct InLoops<const N: usize> {
    mass: [f64; N],
    strength: [f64; N],
    epsilon: f64,
}

/// The same bodies, written out as other functions, and with Kepler's flow in the other part.
#[hamiltonian(
    drift = [
        |q: [[f64; 3]; 4], _| epsilon * (1..4).map(|i| (q[i][0] - q[i - 1][1]).powi(2)).sum::<f64>(),
        |q: [[f64; 3]; 4], p: [[f64; 3]; 4]| {
            let body = |i: usize, m: f64, k: f64| {
                let [x, y, z] = q[i];
                let [u, v, w] = p[i];
                (0.5 * u * u + 0.5 * v * v + 0.5 * w.powi(2)) / m - k * (x.hypot(y).powi(2) + z * z).powf(-0.5)
            };
            body(0, 1.0, 1.0) + body(1, 0.5, 0.7) + body(2, 2.0, -0.3) + body(3, 0.8, 0.0)
        },
    ],
    embedding = [Verlet, Gauss<8>],
)]
struct WrittenOut {
    epsilon: f64,
}

const MASS: [f64; 4] = [1.0, 0.5, 2.0, 0.8];
const STRENGTH: [f64; 4] = [1.0, 0.7, -0.3, 0.0];
const BODIES: [&[f64]; 2] = [
    &[1.0, 0.0, 0.1, 0.3, 1.7, 0.0, 0.4, -0.6, 0.2, 1.0, 1.0, 1.0],
    &[0.0, 0.9, 0.0, -0.3, 0.1, 0.05, -0.5, 0.3, 0.9, 0.1, 0.2, 0.3],
];

fn in_loops(epsilon: f64) -> InLoops<4> {
    InLoops { mass: MASS, strength: STRENGTH, epsilon }
}

#[test]
fn bodies_in_loops_and_written_out_move_alike() {
    let (looped, written) = (in_loops(0.02), WrittenOut { epsilon: 0.02 });
    for text in [<InLoops<4> as Discretized<Aba>>::EQUATIONS, <WrittenOut as Discretized<Aba>>::EQUATIONS] {
        assert!(
            text.contains("over a h: Kepler's, by universal variables, for each body of 3 coordinates"),
            "{text}"
        );
    }
    // The coefficients are for a small second part: the parts in the other order have errors of `ε h^4`.
    let [a, b, exact] = [
        end::<Aba, _>(&looped, BODIES, 3.0, 60),
        end::<Aba, _>(&written, BODIES, 3.0, 60),
        end::<Gauss<8>, _>(&looped, BODIES, 3.0, 60),
    ];
    assert!(distance(&a, &exact) < 1e-10, "{a:?} {exact:?}");
    assert!(distance(&b, &exact) < 1e-8, "{b:?} {exact:?}");
    let (looped, written) = (in_loops(0.0), WrittenOut { epsilon: 0.0 });
    // Eight flows of numbers below 2 and slopes of nearly 10.
    let apart = step_apart::<Aba, _, _>((&looped, &written), BODIES, [0.0, 2.0]);
    assert!(apart < 1e-13, "{apart:e}");
}

/// Steps of 0.5 and 1.2 are one of 1.7, as flows are.
#[test]
fn flows_are_a_group() {
    let system = in_loops(0.0);
    let step = |[q, p]: [&[f64]; 2], h: f64| advance::<Aba, f64, _>(&system, [q, p], [0.0, h], &[]);
    let first = step(BODIES, 0.5);
    let (whole, parts) = (step(BODIES, 1.7), step([&first[..12], &first[12..]], 1.2));
    assert!(distance(&whole, &parts) < 1e-13, "{:e}", distance(&whole, &parts));
    // Many periods of the first two bodies, and the same way back: condition 1e3 of the phase.
    assert!(way_back::<Aba, _>(&system, BODIES, [0.0, 700.0], &[]) < 1e-11);
}

#[test]
fn steps_are_symplectic_symmetric_and_variational() {
    let system = in_loops(0.1);
    // Roundings of derivatives of up to 100; long steps without kicks, whose derivatives would grow with each.
    for (system, h) in [(&system, 0.3), (&system, -1.1), (&in_loops(0.0), 30.0)] {
        let off = asymmetry::<Aba, _>(system, BODIES, [0.2, h], &[], 1.0);
        assert!(off < 1e-11, "{h}: {off:e}");
    }
    assert!(way_back::<Aba, _>(&system, BODIES, [0.2, 0.4], &[]) < 1e-14);
    let next: Vec<f64> = BODIES[0].iter().map(|x| x + 0.1).collect();
    let off = lagrangian_gradient_off::<Aba, _>(&system, [BODIES[0], &next, BODIES[1]], [0.3, 0.2]);
    assert!(off < 1e-8, "{off:e}");
    let path = system.simulate::<Aba>(0.2).start(state(BODIES[0], BODIES[1])).steps(20).run().unwrap();
    assert!(path.euler_lagrange_residual(&system).unwrap() < 1e-13);
}

/// Ellipses of short and long periods and a hyperbola beside each other have the bits of each alone.
#[test]
fn lanes_are_numbers_alone() {
    let system = in_loops(0.1);
    let scales = [1.0, 0.03, 4.0, 0.5];
    for h in [0.3, -2.0] {
        let lanes = |list: &[f64]| -> Vec<Lanes<4>> {
            list.iter().map(|&x| Lanes::new(scales.map(|scale| scale * x))).collect()
        };
        let (q, p) = (lanes(BODIES[0]), lanes(BODIES[1]));
        let together = advance::<Aba, _, _>(&system, [&q, &p], [0.0, h], &[]);
        for (lane, scale) in scales.into_iter().enumerate() {
            let alone = BODIES.map(|list| list.iter().map(|x| scale * x).collect::<Vec<f64>>());
            let alone = advance::<Aba, f64, _>(&system, [&alone[0], &alone[1]], [0.0, h], &[]);
            let ours: Vec<f64> = together.iter().map(|x| x.lane(lane)).collect();
            assert_eq!(ours, alone, "lane {lane}, h = {h}");
        }
    }
}

/// Derivatives of any number and of any order, against differences of those of one order less.
#[test]
fn derivatives_are_those_of_the_flow() {
    let system = in_loops(0.1);
    let with = |x: f64| {
        let mut q = BODIES[0].to_vec();
        q[1] = x;
        let lift = |list: &[f64]| -> Vec<Dual<1, Dual<1>>> {
            list.iter().map(|&x| Dual::constant(Dual::constant(x))).collect()
        };
        let (mut at, p) = (lift(&q), lift(BODIES[1]));
        at[1].value.derivative = [1.0];
        at[1].derivative[0].value = 1.0;
        let end = advance::<Aba, _, _>(&system, [&at, &p], [0.0, 2.5], &[]);
        let orders = |of: fn(&Dual<1, Dual<1>>) -> f64| -> Vec<f64> { end.iter().map(of).collect() };
        [
            orders(|x| x.value.value),
            orders(|x| x.value.derivative[0]),
            orders(|x| x.derivative[0].derivative[0]),
        ]
    };
    let [minus, here, plus] = [-1e-5, 0.0, 1e-5].map(with);
    for order in 0..2 {
        let slopes: Vec<f64> =
            plus[order].iter().zip(&minus[order]).map(|(plus, minus)| (plus - minus) / 2e-5).collect();
        // 1e-10/6 times a derivative of two orders more, below 1e5, and roundings of numbers below 100 over 1e-5.
        assert!(distance(&slopes, &here[order + 1]) < 2e-6, "{slopes:?} {:?}", here[order + 1]);
    }
}

/// Without angular momentum a body falls into its centre in the time `π/4 √2` from rest at distance 1, and a step ends before,
/// or is refused.
#[test]
fn collisions_are_refused() {
    let system = in_loops(0.0);
    let mut q = BODIES[0].to_vec();
    q[..3].copy_from_slice(&[0.6, 0.0, 0.8]);
    let mut p = BODIES[1].to_vec();
    p[..3].fill(0.0);
    let fall = std::f64::consts::PI / 8.0_f64.sqrt();
    for (h, is_before) in [(0.8 * fall, true), (1.2 * fall, false), (-1.2 * fall, false), (40.0, false)] {
        let mut stepper = system.stepper::<Aba>(h).unwrap();
        let mut start = state(&q, &p);
        if is_before {
            stepper.step(&mut start, &[]).unwrap();
            continue;
        }
        let error = refused(&start, |state| stepper.step(state, &[]));
        assert_eq!(error.cause, StepFailure::Collision { body: 0 }, "{error}");
    }
    q[..3].fill(0.0);
    let mut stepper = system.stepper::<Aba>(1.0).unwrap();
    let error = refused(&state(&q, &p), |state| stepper.step(state, &[]));
    assert_eq!(error.cause, StepFailure::Collision { body: 0 }, "{error}");
}
