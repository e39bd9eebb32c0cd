//! Rigid bodies with noise and in a bath.

use wzvi::constraints::RigidBody;
use wzvi::nalgebra::{Rotation3, SVector, Vector3};
use wzvi::prelude::*;

/// A free body, whose third axis a random field turns.
#[hamiltonian(
    drift = |q: Rotation, p|
        (0..3).map(|i| (0..3).map(|a| p[i][a] * p[i][a] / (2.0 * d[a])).sum::<f64>()).sum::<f64>(),
    noise = [|q, _, k| sigma * q[k][2]; 3],
    embedding = Rattle,
)]
struct InRandomField {
    d: [f64; 3],
    sigma: f64,
}

/// A heavy top in a bath.
#[hamiltonian(
    drift = |q: Rotation, p|
        (0..3).map(|i| (0..3).map(|a| p[i][a] * p[i][a] / (2.0 * d[a])).sum::<f64>()).sum::<f64>() + q[2][2],
    friction = 1.0,
    temperature = 0.5,
    embedding = GBaoab,
)]
struct WarmTop {
    d: [f64; 3],
}

type BodyState = State<SVector<f64, 9>>;

fn tilted() -> Rotation3<f64> {
    Rotation3::from_euler_angles(0.4, -0.9, 1.3)
}

/// `dL = -σ c_3 × ∘dW` for the third axis `c_3`, which has no noise of its own: `E|L|² = |L_0|² + 2σ²T`.
#[test]
fn random_torque_adds_to_the_square_of_the_angular_momentum() {
    let (body, sigma, end) = (RigidBody::new([1.0, 1.7, 2.2]).unwrap(), 0.5, 2.0);
    let system = InRandomField { d: body.masses(), sigma };
    let start = body.state(tilted(), Vector3::new(0.3, -1.1, 0.7));
    let square = move |state: &BodyState| body.angular_momentum_in_space(state).norm_squared();
    let expected = square(&start) + 2.0 * sigma * sigma * end;
    let statistics = system
        .ensemble::<Rattle>(0.02)
        .start(start)
        .paths(4000)
        .seed(11)
        .until(end)
        .observe("L2", square)
        .run_in::<8>()
        .unwrap();
    let (mean, error) = (statistics.mean("L2").unwrap(), statistics.standard_error("L2").unwrap());
    // Four standard errors; the error of the step is of order h = 0.02 of the change, 0.02.
    assert!((mean - expected).abs() < 4.0 * error + 0.02, "{mean} {expected} {error}");
    assert!(error < 0.05);
}

/// The height of the centre of mass has the law of Langevin, `⟨q_33⟩ = 1/β - coth β` with `β = 1/kT = 2`.
#[test]
fn a_top_in_a_bath_has_the_law_of_langevin() {
    let body = RigidBody::new([1.0, 1.0, 1.5]).unwrap();
    let top = WarmTop { d: body.masses() };
    let statistics = top
        .ensemble::<GBaoab>(0.2)
        .start(body.state(tilted(), Vector3::zeros()))
        .paths(4000)
        .seed(5)
        .until(20.0)
        .observe("height", |state: &BodyState| state.q[8])
        .run_in::<8>()
        .unwrap();
    let (mean, error) = (statistics.mean("height").unwrap(), statistics.standard_error("height").unwrap());
    let expected = 0.5 - 1.0 / 2f64.tanh();
    // The error of the step is (3 ± 2)e-3 at h = 0.2.
    assert!((mean - expected).abs() < 4.0 * error + 0.003, "{mean} {expected} {error}");
    assert!(error < 0.01);
}
