//! Laws of motion on manifolds: the distribution in a bath, the share of steps without an end, and long runs.

use std::time::Instant;

use wzvi::nalgebra::DVector;
use wzvi::prelude::*;

#[hamiltonian(
    drift = |[x, y, z], [px, py, pz]| 0.5 * (px * px + py * py + pz * pz) + g * z,
    constraint = [|[x, y, z]| 0.5 * (x * x + y * y + z * z - 1.0)],
    friction = gamma,
    temperature = kt,
    embedding = GBaoab,
)]
struct WarmSphere {
    g: f64,
    gamma: f64,
    kt: f64,
}

/// The Langevin function, `⟨z⟩ = -(coth(1/kT) - kT)`, and equipartition among the two degrees that are left.
#[test]
fn a_bath_on_the_sphere_has_the_law_of_langevin() {
    let sphere = WarmSphere { g: 1.0, gamma: 1.0, kt: 0.5 };
    let h = 0.1;
    let statistics = sphere
        .ensemble::<GBaoab>(h)
        .start(State::new([0.0, 0.0, -1.0], [0.0; 3]))
        .paths(40_000)
        .seed(56)
        .until(12.0)
        .observe("z", |state| state.q[2])
        .observe("p²", |state| state.p.norm_squared())
        .run_in::<8>()
        .unwrap();
    let exact = -(1.0 / 2.0_f64.tanh() - 0.5);
    let (mean, error) = (statistics.mean("z").unwrap(), statistics.standard_error("z").unwrap());
    // Four errors, and what is left of the start: relaxation takes a time of order one.
    assert!((mean - exact).abs() < 4.0 * error, "{mean} {exact} ± {error}");
    let (mean, error) = (statistics.mean("p²").unwrap(), statistics.standard_error("p²").unwrap());
    // A step changes the kinetic energy by `O(h²)`: -2 % at 0.4, -0.13 % at 0.1.
    assert!((mean - 1.0).abs() < 4.0 * error + 0.2 * h * h, "{mean} ± {error}");
}

/// Without forces a drift of `h/2` has an end if `h |p| ≤ 2`: with two tangent momenta all but a share of
/// `e^{-2/(h² kT)}` of drifts.
#[test]
fn steps_without_an_end_have_their_share() {
    // Momenta are fresh in each step, and each path takes one: the first drift starts at rest.
    let (h, kt, paths) = (1.0, 0.5, 40_000_u32);
    let sphere = WarmSphere { g: 0.0, gamma: 60.0, kt };
    let statistics = sphere
        .ensemble::<GBaoab>(h)
        .start(State::new([0.0, 0.0, -1.0], [0.0; 3]))
        .paths(u64::from(paths))
        .seed(7)
        .steps(1)
        .allow_losses(1.0)
        .observe("z", |state| state.q[2])
        .run_in::<8>()
        .unwrap();
    let share = (-2.0 / (h * h * kt)).exp();
    let (found, expected) = (statistics.failures().len() as f64, share * f64::from(paths));
    assert!((found - expected).abs() < 4.0 * expected.sqrt(), "{found} {expected}");
}

/// Rods in a ring or a chain, in the plane.
#[hamiltonian(
    drift = |q: &[[f64; 2]], p: &[[f64; 2]]| (0..q.len())
        .map(|i| 0.5 * (p[i][0] * p[i][0] + p[i][1] * p[i][1]) + g * q[i][1])
        .sum::<f64>(),
    constraint = [
        [|q, _| 0.5 * (q[0][0] * q[0][0] + q[0][1] * q[0][1] - 1.0); self.held],
        [|q, k| {
            let ([a, b], [x, y]) = (q[k], q[(k + 1) % self.joints]);
            0.5 * ((x - a) * (x - a) + (y - b) * (y - b) - 1.0)
        }; self.rods],
    ],
    embedding = Rattle,
)]
struct Rods {
    joints: usize,
    held: usize,
    rods: usize,
    g: f64,
}

fn chain(joints: usize) -> (Rods, State<DVector<f64>>) {
    let q: Vec<f64> = (1..=joints).flat_map(|i| [0.6 * i as f64, -0.8 * i as f64]).collect();
    (Rods { joints, held: 1, rods: joints - 1, g: 1.0 }, State::new(q, vec![0.0; 2 * joints]))
}

/// The angular momentum and both momenta of a ring that nothing holds, over 1e5 steps: random walks of roundings.
#[test]
fn momenta_of_a_ring_are_kept_to_rounding() {
    const JOINTS: usize = 6;
    let angle = |i: usize| std::f64::consts::TAU * i as f64 / JOINTS as f64;
    let q: Vec<f64> = (0..JOINTS).flat_map(|i| [angle(i).cos(), angle(i).sin()]).collect();
    let p: Vec<f64> = (0..JOINTS)
        .flat_map(|i| [-0.3 * angle(i).sin() + 0.2 * angle(i).cos().powi(2), 0.3 * angle(i).cos()])
        .collect();
    let ring = Rods { joints: JOINTS, held: 0, rods: JOINTS, g: 0.0 };
    let momenta = |state: &State<DVector<f64>>| {
        let joints = state.q.as_slice().chunks(2).zip(state.p.as_slice().chunks(2));
        joints.fold([0.0; 3], |[x, y, turn], (q, p)| [x + p[0], y + p[1], turn + q[0] * p[1] - q[1] * p[0]])
    };
    // At rest as a whole, so that it stays where it is.
    let mut start = State::new(q, p);
    let [x, y, _] = momenta(&start);
    for joint in start.p.as_mut_slice().chunks_mut(2) {
        joint[0] -= x / JOINTS as f64;
        joint[1] -= y / JOINTS as f64;
    }
    let run =
        ring.simulate::<Rattle>(0.05).start(start).project_start().steps(100_000).record_every(1000).run();
    let path = run.unwrap();
    let first = momenta(&path.states()[0]);
    for state in path.states() {
        for (found, first) in momenta(state).iter().zip(first) {
            // The square root of 1e5 steps, and some roundings of numbers of order one in each.
            assert!((found - first).abs() < 2e-13, "{found} {first}");
        }
    }
}

/// The energy of a pendulum of three rods over 1e6 steps: the means of the first and of the last tenth.
#[test]
fn the_energy_of_a_pendulum_of_rods_does_not_drift() {
    let (rods, mut start) = chain(3);
    start.p.as_mut_slice().copy_from_slice(&[0.8, 0.6, 0.4, 0.3, 0.0, 0.0]);
    let mut energies = Vec::new();
    rods.simulate::<Rattle>(0.01)
        .start(start)
        .project_start()
        .steps(1_000_000)
        .record_every(0)
        .inspect(|state, node| {
            if node.step % 100 == 0 {
                energies.push(rods.energy(state));
            }
        })
        .run()
        .unwrap();
    let first = energies[0];
    let largest = energies.iter().map(|energy| (energy - first).abs()).fold(0.0, f64::max);
    let tenth = energies.len() / 10;
    let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
    let drift = (mean(&energies[..tenth]) - mean(&energies[9 * tenth..])).abs();
    // Errors of h² that come and go; the motion is chaotic, so that means of a tenth differ by some of them.
    assert!(largest < 2e-2 && drift < 0.05 * largest, "{largest:e} {drift:e}");
}

/// Four times as many constraints take four times as long, in lists that fit into no cache: the bound is the
/// geometric mean of that and of 16, the factor of a step that is quadratic in the number.
#[test]
fn the_time_of_a_step_is_linear_in_the_number_of_rods() {
    let seconds = |joints: usize| {
        let (rods, start) = chain(joints);
        // The upper rods carry all others: their frequency is √(n g/l), 180 for 32 000.
        let mut stepper = rods.stepper::<Rattle>(0.001).unwrap();
        let (mut state, mut least) = (start, f64::INFINITY);
        for _ in 0..8 {
            let begin = Instant::now();
            for _ in 0..10 {
                stepper.step(&mut state, &[]).unwrap();
            }
            least = f64::min(least, begin.elapsed().as_secs_f64() / 10.0);
        }
        least
    };
    let [few, many] = [8000, 32_000].map(seconds);
    assert!(many < 8.0 * few, "{few:e} s, {many:e} s");
}
