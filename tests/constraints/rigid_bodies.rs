//! Rotation matrices as coordinates.

use wzvi::constraints::RigidBody;
use wzvi::nalgebra::{DVector, Rotation3, SVector, Vector3};
use wzvi::prelude::*;

/// Kovalevskaya's top: `I = (2, 2, 1)`, and the weight is on the axis of the first moment.
#[hamiltonian(
    drift = |q: Rotation, p|
        (0..3).map(|i| (0..3).map(|a| p[i][a] * p[i][a] / (2.0 * d[a])).sum::<f64>()).sum::<f64>() + q[2][0],
    embedding = Rattle,
    invariant = [|q, p| (0..3).map(|a| q[0][a] * p[1][a] - q[1][a] * p[0][a]).sum::<f64>()],
)]
struct Kovalevskaya {
    d: [f64; 3],
}

/// A free body.
#[hamiltonian(
    drift = |q: Rotation, p|
        (0..3).map(|i| (0..3).map(|a| p[i][a] * p[i][a] / (2.0 * d[a])).sum::<f64>()).sum::<f64>(),
    embedding = Rattle,
)]
struct Free {
    d: [f64; 3],
}

/// Bodies that attract each other's first axes.
#[hamiltonian(
    drift = |q: [Rotation; N], p| {
        let kinetic: f64 =
            (0..N).map(|k| (0..9).map(|j| p[k][j / 3][j % 3] * p[k][j / 3][j % 3] / (2.0 * d[j % 3])).sum::<f64>()).sum();
        kinetic + (1..N).map(|k| coupling * (0..3).map(|i| q[k - 1][i][0] * q[k][i][0]).sum::<f64>()).sum::<f64>()
    },
    embedding = Rattle,
)]
struct Bodies<const N: usize> {
    d: [f64; 3],
    coupling: f64,
}

type BodyState = State<SVector<f64, 9>>;

fn asymmetric() -> RigidBody {
    RigidBody::new([1.0, 1.7, 2.2]).unwrap()
}

fn tilted() -> Rotation3<f64> {
    Rotation3::from_euler_angles(0.4, -0.9, 1.3)
}

/// The largest component of a difference.
fn apart<const D: usize>(a: SVector<f64, D>, b: SVector<f64, D>) -> f64 {
    (a - b).amax()
}

#[test]
fn helpers_agree_with_each_other_and_with_the_motion() {
    let (body, spin) = (asymmetric(), Vector3::new(0.3, -1.1, 0.7));
    let state = body.state(tilted(), spin);
    let inertia = Vector3::from(body.inertia());
    assert!(apart(body.angular_velocity_in_body(&state), spin) < 1e-15);
    assert!(apart(body.angular_momentum_in_body(&state), inertia.component_mul(&spin)) < 2e-15);
    assert!(apart(body.angular_velocity_in_space(&state), tilted() * spin) < 1e-15);
    let in_space = tilted() * inertia.component_mul(&spin);
    assert!(apart(body.angular_momentum_in_space(&state), in_space) < 2e-15);
    // The energy of a free body is that of Euler: Σ I_a ω_a²/2.
    let free = Free { d: body.masses() };
    let energy = 0.5 * inertia.dot(&spin.component_mul(&spin));
    assert!((free.energy(&state) - energy).abs() < 4.0 * f64::EPSILON * energy);
    // A small step turns the body about its angular velocity: (Q(t) - Q(0))/t = [ω]_× Q + O(t).
    let mut later = state;
    free.stepper::<Rattle>(1e-6).unwrap().step(&mut later, &[]).unwrap();
    let rate = (body.attitude(&later).matrix() - body.attitude(&state).matrix()) / 1e-6;
    let expected = (tilted() * spin).cross_matrix() * tilted().matrix();
    assert!((rate - expected).amax() < 1e-5);
}

/// Euler's equations of the free body, by a Runge-Kutta method with small steps.
#[test]
fn a_free_body_moves_by_the_equations_of_euler() {
    let (body, spin) = (asymmetric(), Vector3::new(0.05, 1.2, 0.1));
    let [i1, i2, i3] = body.inertia();
    let rate = |w: Vector3<f64>| {
        Vector3::new((i2 - i3) / i1 * w.y * w.z, (i3 - i1) / i2 * w.z * w.x, (i1 - i2) / i3 * w.x * w.y)
    };
    let (mut expected, dt) = (spin, 1e-3);
    for _ in 0..10_000 {
        let k1 = rate(expected);
        let k2 = rate(expected + 0.5 * dt * k1);
        let k3 = rate(expected + 0.5 * dt * k2);
        let k4 = rate(expected + dt * k3);
        expected += dt / 6.0 * (k1 + 2.0 * (k2 + k3) + k4);
    }
    let free = Free { d: body.masses() };
    let start = body.state(tilted(), spin);
    let path = free.simulate::<Composed<Rattle, KahanLi6>>(0.02).start(start).steps(500).run().unwrap();
    // The error of the sixth order: 2^6 smaller for half the step, below 1e-8 at this one.
    assert!(apart(body.angular_velocity_in_body(path.last()), expected) < 1e-8);
    // The angular momentum in space, to the rounding of 5000 substeps.
    let momentum = body.angular_momentum_in_space(&start);
    for state in path.iter() {
        assert!(apart(body.angular_momentum_in_space(state), momentum) < 1e-12);
    }
}

/// `|(ω1 + i ω2)² - (γ1 + i γ2)|²` for the vertical `γ` in the body, in units with `I_3 = 1` and weight 1.
fn integral_of_kovalevskaya(body: &RigidBody, state: &BodyState) -> f64 {
    let w = body.angular_velocity_in_body(state);
    let (re, im) = (w.x * w.x - w.y * w.y - state.q[6], 2.0 * w.x * w.y - state.q[7]);
    re * re + im * im
}

#[test]
fn the_integral_of_kovalevskaya_is_kept_to_the_order() {
    let body = RigidBody::new([2.0, 2.0, 1.0]).unwrap();
    let top = Kovalevskaya { d: body.masses() };
    let start = body.state(tilted(), Vector3::new(0.8, -0.5, 1.1));
    let vertical = body.angular_momentum_in_space(&start).z;
    fn change<E>(top: &Kovalevskaya, body: &RigidBody, start: BodyState, steps: u32, vertical: f64) -> f64
    where
        Kovalevskaya: Discretized<E, Vector = SVector<f64, 9>>,
    {
        let path = top.simulate::<E>(1.0 / f64::from(steps)).start(start).steps(steps.into()).run().unwrap();
        for state in path.iter() {
            assert!((body.angular_momentum_in_space(state).z - vertical).abs() < 1e-13);
        }
        (integral_of_kovalevskaya(body, path.last()) - integral_of_kovalevskaya(body, &start)).abs()
    }
    let order = |changes: [f64; 2], order: f64| {
        let found = (changes[0] / changes[1]).log2();
        assert!((found - order).abs() < 0.1, "{changes:?}: {found}");
    };
    order([64, 128].map(|steps| change::<Rattle>(&top, &body, start, steps, vertical)), 2.0);
    let fourth = |steps| change::<Composed<Rattle, Suzuki4>>(&top, &body, start, steps, vertical);
    order([64, 128].map(fourth), 4.0);
    let sixth = |steps| change::<Composed<Rattle, KahanLi6>>(&top, &body, start, steps, vertical);
    order([16, 32].map(sixth), 6.0);
}

#[test]
fn bodies_without_coupling_move_as_one_does() {
    let body = asymmetric();
    let spins = [Vector3::new(0.3, -1.1, 0.7), Vector3::new(-0.2, 0.4, 1.9), Vector3::new(1.0, 0.1, 0.0)];
    let starts = spins.map(|spin| body.state(tilted(), spin));
    let all = |part: fn(&BodyState) -> SVector<f64, 9>| -> Vec<f64> {
        starts.iter().flat_map(|start| part(start).as_slice().to_vec()).collect()
    };
    let mut together = State::new(all(|state| state.q), all(|state| state.p));
    let bodies = Bodies::<3> { d: body.masses(), coupling: 0.0 };
    let free = Free { d: body.masses() };
    let mut stepper = bodies.stepper::<Rattle>(0.05).unwrap();
    let mut each = starts;
    let mut alone = free.stepper::<Rattle>(0.05).unwrap();
    for _ in 0..100 {
        stepper.step(&mut together, &[]).unwrap();
        for state in &mut each {
            alone.step(state, &[]).unwrap();
        }
    }
    for (index, expected) in each.iter().enumerate() {
        let found = RigidBody::of_several(&together, index).unwrap();
        // Rounding of another elimination, over 100 steps.
        assert!(apart(found.q, expected.q) < 1e-12 && apart(found.p, expected.p) < 1e-12);
    }
    assert!(RigidBody::of_several(&together, 3).is_none());
    // With coupling they exchange angular momentum and keep its sum.
    let coupled = Bodies::<3> { coupling: 0.8, ..bodies };
    let total = |state: &State<DVector<f64>>| -> Vector3<f64> {
        (0..3).map(|k| body.angular_momentum_in_space(&RigidBody::of_several(state, k).unwrap())).sum()
    };
    let before = (total(&together), body.angular_momentum_in_space(&each[0]));
    let mut stepper = coupled.stepper::<Rattle>(0.05).unwrap();
    for _ in 0..100 {
        stepper.step(&mut together, &[]).unwrap();
    }
    assert!(apart(total(&together), before.0) < 1e-12);
    let first = RigidBody::of_several(&together, 0).unwrap();
    assert!(apart(body.angular_momentum_in_space(&first), before.1) > 0.1);
}

#[test]
fn moments_of_no_body_are_refused() {
    for (inertia, reason) in [
        ([1.0, 0.0, 1.0], "I_2 is 0"),
        ([1.0, 1.0, f64::NAN], "I_3 is NaN"),
        ([1.0, 1.0, 3.0], "I_3 = 3 exceeds the sum of the other two"),
        ([0.1, 0.2, 0.1 + 0.2], "the body is flat: I_3"),
    ] {
        let error = RigidBody::new(inertia).unwrap_err().to_string();
        assert!(error.contains(reason), "{error}");
    }
}
