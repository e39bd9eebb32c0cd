//! What a lane does is what a stepper does: the same bits, and the same errors.

#[allow(dead_code, unreachable_pub, reason = "a module of several crates")]
#[path = "../../fixtures/portable.rs"]
mod portable;

use fixtures::small::Kepler;
use fixtures::stepped::{failed, hard, paths_are_steppers};
use std::slice::from_ref;

use wzvi::error::Error;
use wzvi::increments::Interval;
use wzvi::nalgebra;
use wzvi::prelude::*;

use super::{DoubleWell, KUBO};
use portable::{Morse, Others, Powers, Rotors, Shaken, Swing, Warm, start};

/// Two degrees of freedom, three unknowns or more in one block.
#[hamiltonian(
    drift = |[x, y], [u, v]| 0.5 * (u * u + v * v) * (1.0 + x * x) + 0.25 * (x * x + y * y - 1.0).powi(2),
    noise = [|[x, y], [u, v]| s * (x * u + y * y * v), |[x, y], [u, v]| s * x * y],
    embedding = [Midpoint, Corrected<DeltaPlus>],
)]
pub(crate) struct Tangled {
    pub(crate) s: f64,
}

/// Mechanical: a symmetric Jacobian.
#[hamiltonian(
    drift = |[x, y, z], [u, v, w]| 0.5 * (u * u + v * v + w * w) + 0.25 * (x * x + y * y + z * z - 1.0).powi(2),
    noise = [|[x, y, z], [u, v, w]| s * x * y * z],
    embedding = [Midpoint],
)]
pub(crate) struct Mechanical {
    pub(crate) s: f64,
}

/// Paths beside those of steppers: how many steps were hard, and how many paths failed.
fn as_steppers<H: Discretized<E> + Sync, E>(
    system: &H,
    h: f64,
    start: &State<H::Vector>,
    paths: u64,
    steps: u64,
) -> (u64, u64) {
    let run = || system.ensemble::<E>(h).start(start.clone());
    let paths = paths_are_steppers(run, from_ref(system), (h, steps), (paths, 9));
    (hard(&paths), failed(&paths))
}

/// A lane does what a stepper does; where the short way fails, too.
#[test]
fn a_lane_is_the_path_of_a_stepper() {
    as_steppers::<_, Midpoint>(&KUBO, 0.1, &State::new([0.0], [1.0]), 20, 50);
    let well = DoubleWell { sigma: 0.3 };
    as_steppers::<_, Midpoint>(&well, 0.01, &State::new([0.5], [0.5]), 20, 50);
    let (hard, failed) =
        as_steppers::<_, Midpoint>(&DoubleWell { sigma: 1.5 }, 0.5, &State::new([0.5], [2.0]), 25, 60);
    assert!(hard > 25 && failed > 0 && failed < 25, "{hard} {failed}");
    let start = State::new([0.5, 0.3], [0.2, -0.4]);
    let tangled = Tangled { s: 0.8 };
    let (hard, failed) = as_steppers::<_, Midpoint>(&tangled, 0.3, &start, 40, 20);
    assert!(hard > 20 && failed > 0 && failed < 40, "{hard} {failed}");
    let (hard, failed) = as_steppers::<_, Corrected<DeltaPlus>>(&tangled, 0.1, &start, 40, 20);
    assert!(hard > 20 && failed > 0 && failed < 40, "{hard} {failed}");
    let start = State::new([0.5, 0.3, 0.1], [0.2, -0.4, 1.0]);
    let (hard, failed) = as_steppers::<_, Midpoint>(&Mechanical { s: 2.0 }, 0.8, &start, 40, 40);
    assert!(hard > 20 && failed < 40, "{hard} {failed}");
}

/// The same with elementary functions, of the state, of time and of parameters, and in every kind of step.
#[test]
fn a_lane_has_the_functions_of_a_stepper() {
    macro_rules! of {
        ($system:expr, $degrees:literal, $h:literal: $($scheme:ty),*) => {{
            let (system, start) = ($system, start($degrees));
            $(as_steppers::<_, $scheme>(&system, $h, &start, 4, 12);)*
        }};
    }
    of!(Swing { a: 1.3 }, 1, 0.2: DeltaPlus, Midpoint, Verlet, Gauss<2>, Gauss<8>);
    // The others in steps that need second derivatives, too.
    of!(Morse { a: 0.8 }, 1, 0.1: Midpoint, Gauss<4>);
    of!(Powers { a: 1.3 }, 2, 0.1: Midpoint, Gauss<4>);
    of!(Others, 1, 0.1: Midpoint, Gauss<4>);
    of!(Warm { a: 0.7, gamma: 0.6, kt: -0.4 }, 1, 0.1: Baoab, Obabo, Thermostat<Midpoint>);
    of!(Shaken { s: 0.4 }, 1, 0.1: Corrected<DeltaPlus>, Midpoint, Gauss<2>);
    of!(Rotors, 9, 0.1: DeltaPlus, Midpoint, Verlet, Gauss<2>);
    of!(Rotors, 270, 0.1: Midpoint, Verlet);
}

/// Double wells of a size that the state has: every site is solved for itself.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        (0..q.len()).map(|i| 0.5 * p[i] * p[i] + 0.25 * stiffness[i] * (q[i] * q[i] - 1.0).powi(2)).sum::<f64>()
    },
    noise = [|q, p, k| s * q[k] * p[k]; stiffness.len()],
    embedding = [Midpoint],
)]
pub(crate) struct DoubleWells {
    pub(crate) s: f64,
    pub(crate) stiffness: Vec<f64>,
}

/// Explicit steps in loops.
#[hamiltonian(
    drift = |q: [f64; N], p: [f64; N]| {
        (0..N).map(|i| 0.5 * p[i] * p[i] + 0.25 * q[i].powi(4)).sum::<f64>()
            + (1..N).map(|i| 0.5 * k * (q[i] - q[i - 1]).powi(2)).sum::<f64>()
    },
    noise = [|q, p, j| s * q[j] * q[j]; N],
    embedding = [DeltaPlus, Midpoint],
)]
pub(crate) struct Springs<const N: usize> {
    pub(crate) k: f64,
    pub(crate) s: f64,
}

/// The same of steps that are taken in loops, in lanes or not; where sites are hard to solve, too.
#[test]
fn a_lane_of_a_system_in_loops_is_the_path_of_a_stepper() {
    let wave = |n, phase| fixtures::wave(n, 1.0, phase);
    let start = State::new(wave(5, 0.2), wave(5, 1.1));
    let wells =
        |s, stiffness: f64| DoubleWells { s, stiffness: (0..5).map(|i| stiffness + i as f64).collect() };
    let (hard, failed) = as_steppers::<_, Midpoint>(&wells(0.3, 1.0), 0.01, &start, 10, 20);
    assert_eq!((hard, failed), (0, 0));
    let (hard, failed) = as_steppers::<_, Midpoint>(&wells(1.5, 1.0), 0.3, &start, 6, 20);
    assert!(hard > 54 && failed < 6, "{hard} {failed}");
    let start = State {
        q: nalgebra::SVector::from_vec(wave(7, 0.2)),
        p: nalgebra::SVector::from_vec(wave(7, 1.1)),
        t: 0.0,
    };
    let shaken = Springs::<7> { k: 1.0, s: 0.5 };
    as_steppers::<_, DeltaPlus>(&shaken, 0.05, &start, 10, 20);
    as_steppers::<_, Midpoint>(&shaken, 0.05, &start, 5, 20);
}

/// Sites that nothing couples have a hard step each: all of them succeed where each alone does, and there only.
#[test]
fn a_site_among_others_is_followed_as_alone() {
    let (h, steps) = (0.3, 10);
    let sites = |stiffness: &[f64]| DoubleWells { s: 1.5, stiffness: stiffness.to_vec() };
    let stiffness = [1.0, 2.0, 3.0, 4.0, 5.0];
    let (together, apart) = (sites(&stiffness), stiffness.map(|own| sites(&[own])));
    let (q, p) = ([0.2, 1.0, 0.3, -0.8, -0.8], [0.9, 0.7, -0.5, -1.0, 0.0]);
    let (mut hard, mut failed) = (0, 0);
    for path in 55..65 {
        let mut noise = StepNormals::seed(9).path(path);
        noise.prepare(&<DoubleWells as Discretized<Midpoint>>::PLAN, h, 5, 0.0).unwrap();
        let mut steppers = apart.each_ref().map(|site| site.stepper::<Midpoint>(h).unwrap().plain());
        let mut stepper = together.stepper::<Midpoint>(h).unwrap().plain();
        let mut state = State::new(q.to_vec(), p.to_vec());
        let mut own: [_; 5] = std::array::from_fn(|i| State::new(vec![q[i]], vec![p[i]]));
        let mut dw = [0.0; 5];
        for step in 0..steps {
            noise.increments(&Interval { start: 0.0, h, step }, &mut dw).unwrap();
            let taken = stepper.step(&mut state, &dw);
            let of_each = (0..5).map(|i| steppers[i].step(&mut own[i], &dw[i..=i]));
            let of_each: Result<Vec<_>, _> = of_each.collect();
            assert_eq!(taken.is_ok(), of_each.is_ok(), "path {path}, step {step}: {taken:?} {of_each:?}");
            let Ok(info) = taken else {
                failed += 1;
                break;
            };
            hard += u64::from(info.is_hard);
            // Both solve the same equations to rounding, which chaos multiplies.
            for (i, own) in own.iter().enumerate() {
                let size = 1.0 + state.q[i].abs() + state.p[i].abs();
                let apart = (state.q[i] - own.q[0]).abs() + (state.p[i] - own.p[0]).abs();
                assert!(apart < 1e-6 * size, "path {path}, step {step}, site {i}: {apart:e}");
            }
        }
    }
    assert!(hard > 20 && failed < 10, "{hard} {failed}");
}

/// Without noise every path is that of a stepper, which remembers its steps; also into a collision.
#[test]
fn without_noise_all_paths_are_those_of_a_stepper() {
    as_steppers::<_, Midpoint>(&Kepler, 0.01, &State::new([1.0, 0.0], [0.0, 0.9]), 20, 1000);
    let start = State::new([1.0, 0.0], [0.0, 0.0]);
    let failure = Kepler.ensemble::<Midpoint>(0.01).start(start).paths(3).steps(200).run();
    let mut state = start;
    let mut stepper = Kepler.stepper::<Midpoint>(0.01).unwrap().plain();
    let error = (0..200).find_map(|_| stepper.step(&mut state, &[]).err()).unwrap();
    assert_eq!(failure, Err(Error::Step(error)));
}
