//! The momentum `P` of a step, where the equation of its start has several solutions.

use wzvi::prelude::*;
use wzvi::system::Segment;

type Both = Mixed<DeltaMinus, Midpoint>;

#[hamiltonian(
    drift = |q, p| 0.5 * p * p,
    noise = [|q, p| 0.5 * q * q * (3.0 * p).sin()],
    embedding = Mixed<DeltaMinus, Midpoint>,
)]
struct Waves;

/// A stiff force, and a noise that acts on both.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * k * q * q,
    noise = [|q, p| 0.1 * q * p],
    embedding = Mixed<DeltaMinus, Midpoint>,
)]
struct Spring {
    k: f64,
}

/// What is left of `∂L_d/∂P = 0`, `p_i = -D_1 L_d` and `p_{i+1} = D_2 L_d` with the `P` between two states.
fn left<H>(system: &H, [before, after]: [&State<H::Vector>; 2], h: f64, dw: f64) -> [f64; 3]
where
    H: Discretized<Both> + Hamiltonian<Vector = wzvi::nalgebra::SVector<f64, 1>>,
{
    let p = system.step_momentum(before, after, h, &[dw]);
    let segment = Segment { q0: before.q, q1: after.q, p, t: before.t, h };
    let gradient = system.discrete_lagrangian_gradient(&segment, &[dw]);
    [gradient.p[0], gradient.q0[0] + before.p[0], gradient.q1[0] - after.p[0]]
}

/// Newton's method from `p_i` finds another solution of the first equation, with which the others are off by a tenth.
#[test]
fn it_satisfies_the_equations_of_both_ends() {
    let h = 0.1;
    for (q, p, dw) in [(1.51, -1.04, 0.69), (-1.3, 1.06, -0.84), (-1.03, -1.0, -0.9)] {
        let before = State::new([q], [p]);
        let mut after = before;
        Waves.stepper::<Both>(h).unwrap().step(&mut after, &[dw]).unwrap();
        let left = left(&Waves, [&before, &after], h, dw);
        // A dozen terms of order one.
        assert!(left.iter().all(|left| left.abs() < 12.0 * f64::EPSILON), "{q} {p}: {left:?}");
    }
}

#[test]
fn states_that_no_step_joins_have_none() {
    let (h, dw) = (0.1, 0.69);
    let before = State::new([1.51], [-1.04]);
    let mut after = before;
    Waves.stepper::<Both>(h).unwrap().step(&mut after, &[dw]).unwrap();
    after.p[0] += 1e-12;
    assert!(left(&Waves, [&before, &after], h, dw).iter().all(|left| left.is_nan()));
}

/// The force of a stiff spring rounds by far more than the momenta.
#[test]
fn stiff_steps_have_theirs() {
    for (k, h) in [(1e4, 1e-3), (1e8, 1e-5), (1e12, 1e-8), (1e12, 1e-6)] {
        let spring = Spring { k };
        let mut stepper = spring.stepper::<Both>(h).unwrap();
        let mut state = State::new([1.0], [0.3]);
        for n in 0..20 {
            let (before, dw) = (state, h.sqrt() * f64::from(n).sin());
            stepper.step(&mut state, &[dw]).unwrap();
            let [_, start, end] = left(&spring, [&before, &state], h, dw);
            // Roundings of the force, with its increments.
            let tolerance = 12.0 * f64::EPSILON * (1.0 + k * h) * (state.q[0].abs() + before.q[0].abs());
            let momenta = 12.0 * f64::EPSILON * (state.p[0].abs() + before.p[0].abs());
            assert!(start.abs().max(end.abs()) <= tolerance + momenta, "{k} {h} {n}: {start} {end}");
        }
    }
}

/// `P = p_i - a P` with `a` the increment: its error is followed by a geometric series, of which eight terms were taken for all even where they grow, so that
/// any two momenta were joined.
#[test]
fn momenta_whose_error_is_not_bounded_are_not_known() {
    #[hamiltonian(drift = |q, p| 0.5 * p * p, noise = [|q, p| q * p], embedding = Mixed<DeltaMinus, Midpoint>)]
    struct Stretch;
    let h = 0.1;
    for (dw, is_known) in [(0.1, true), (0.9, true), (1.5, true), (50.0, false), (-50.0, false)] {
        let before = State::new([0.5], [0.3]);
        let mut after = before;
        Stretch.stepper::<Both>(h).unwrap().step(&mut after, &[dw]).unwrap();
        let known = left(&Stretch, [&before, &after], h, dw);
        // A dozen terms of the size of the largest number.
        let size = 1.0 + dw.abs() * (after.p[0].abs() + after.q[0].abs());
        assert!(
            known.iter().all(|left| if is_known {
                left.abs() < 12.0 * f64::EPSILON * size
            } else {
                left.is_nan()
            }),
            "{dw}: {known:?}"
        );
        after.p[0] += 1e-3 * after.p[0].abs();
        let moved = left(&Stretch, [&before, &after], h, dw);
        assert!(moved.iter().all(|left| left.is_nan()), "{dw}: {moved:?}");
    }
}
