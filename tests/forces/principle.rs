//! The equations of the principle themselves: residuals, loops beside straight lines, virtual work.

use wzvi::prelude::*;
use wzvi::state::Vector;
use wzvi::system::Segment;

use crate::systems::*;

/// Steps of two systems that are the same leave the same states.
pub(crate) fn same<E, A: Discretized<E>, B: Discretized<E>>(a: &A, b: &B, start: [&[f64]; 2], dw: &[f64]) {
    let gap = fixtures::steps::apart::<E, _, _>((a, b), start, (0.05, 20), dw);
    // Some twenty roundings of numbers below 4, and the tolerance of two iterations.
    assert!(gap < 4e-14, "{}: {gap:e}", std::any::type_name::<E>());
}

/// The same by several schemes.
macro_rules! same_by {
    ($a:expr, $b:expr, $start:expr, $dw:expr, $($scheme:ty),*) => {
        $($crate::principle::same::<$scheme, _, _>($a, $b, $start, $dw);)*
    };
}
pub(crate) use same_by;

#[test]
fn loops_do_what_straight_lines_do() {
    let (a, b) = (DrivenInline { drag: 0.4, push: 0.9 }, DrivenLoops { drag: 0.4, push: 0.9 });
    let start: [&[f64]; 2] = [&[0.7], &[-0.6]];
    same_by!(&a, &b, start, &[], DeltaPlus, DeltaMinus, Midpoint, Lambda<1, 3>, Verlet, Gauss<2>, Gauss<3>);

    let mass = [1.0, 0.5, 2.0, 1.5, 0.8];
    let a = ChainInline { mass, drag: 0.3, sigma: 0.2 };
    let b = ChainLoops { mass: mass.to_vec(), drag: 0.3, sigma: 0.2 };
    let start: [&[f64]; 2] = [&[0.1, -0.2, 0.4, 0.0, 0.3], &[0.5, -0.4, 0.2, 0.9, -0.7]];
    let dw = [0.2, -0.1, 0.3, 0.15, -0.25];
    same_by!(&a, &b, start, &dw, Midpoint, DeltaPlus, DeltaMinus, Verlet, Gauss<2>);
}

/// The segment between two states.
fn segment<E, H: Discretized<E>>(
    system: &H,
    a: &State<H::Vector>,
    b: &State<H::Vector>,
    h: f64,
    dw: &[f64],
) -> Segment<H::Vector> {
    let p = Discretized::<E>::step_momentum(system, a, b, h, dw);
    Segment { q0: a.q.clone(), q1: b.q.clone(), p, t: a.t, h }
}

pub(crate) fn residual<E, H: Discretized<E>>(system: &H, start: State<H::Vector>, dw: &[f64]) {
    let h = 0.07;
    let mut stepper = system.stepper::<E>(h).unwrap();
    let mut states = vec![start.clone()];
    let mut state = start;
    for _ in 0..2 {
        stepper.step(&mut state, dw).unwrap();
        states.push(state.clone());
    }
    let first = segment::<E, H>(system, &states[0], &states[1], h, dw);
    let second = segment::<E, H>(system, &states[1], &states[2], h, dw);
    let residual = Discretized::<E>::euler_lagrange_residual(system, &first, &second, dw, dw);
    for r in residual.node.components().iter().chain(residual.momentum.components()) {
        // Roundings of a few terms of size one.
        assert!(r.abs() < 2e-14, "{}: {residual:?}", std::any::type_name::<E>());
    }
    // Its momenta are those of the states.
    let gradient = Discretized::<E>::discrete_lagrangian_gradient(system, &first, dw);
    for (a, b) in gradient.q1.components().iter().zip(states[1].p.components()) {
        assert!((a - b).abs() < 1e-14, "{}", std::any::type_name::<E>());
    }
    for (a, b) in gradient.q0.components().iter().zip(states[0].p.components()) {
        assert!((a + b).abs() < 1e-14, "{}", std::any::type_name::<E>());
    }
}

#[test]
fn steps_solve_the_forced_equations() {
    let mass = [1.0, 0.5, 2.0, 1.5, 0.8];
    let a = ChainInline { mass, drag: 0.3, sigma: 0.2 };
    let b = ChainLoops { mass: mass.to_vec(), drag: 0.3, sigma: 0.2 };
    let (q, p) = ([0.1, -0.2, 0.4, 0.0, 0.3], [0.5, -0.4, 0.2, 0.9, -0.7]);
    let dw = [0.2, -0.1, 0.3, 0.15, -0.25];
    macro_rules! all {
        ($($scheme:ty),*) => {$(
            residual::<$scheme, _>(&a, State::new(q, p), &dw);
            residual::<$scheme, _>(&b, State::new(q.to_vec(), p.to_vec()), &dw);
        )*};
    }
    all!(DeltaPlus, DeltaMinus, Midpoint, Verlet, Gauss<2>, Composed<Verlet, Yoshida4>);
    let (a, b) = (DrivenInline { drag: 0.4, push: 0.9 }, DrivenLoops { drag: 0.4, push: 0.9 });
    residual::<Lambda<1, 3>, _>(&a, State::new([0.7], [-0.6]), &[]);
    residual::<Lambda<1, 3>, _>(&b, State::new([0.7], [-0.6]), &[]);
}
