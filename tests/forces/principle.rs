//! The equations of the principle themselves: residuals, loops beside straight lines, virtual work.

use wzvi::prelude::*;
use wzvi::state::Vector;
use wzvi::system::Segment;

use crate::systems::*;

/// A state of these coordinates, then momenta.
fn state<V: Vector>([q, p]: [&[f64]; 2]) -> State<V> {
    let vector = |list: &[f64]| {
        let mut vector = V::zeros(list.len());
        vector.components_mut().copy_from_slice(list);
        vector
    };
    State { q: vector(q), p: vector(p), t: 0.0 }
}

fn numbers<V: Vector>(state: &State<V>) -> Vec<f64> {
    state.q.components().iter().chain(state.p.components()).copied().collect()
}

/// Steps of two systems that are the same leave the same states.
pub(crate) fn same<E, A: Discretized<E>, B: Discretized<E>>(a: &A, b: &B, start: [&[f64]; 2], dw: &[f64]) {
    let h = 0.05;
    let (mut one, mut other) = (a.stepper::<E>(h).unwrap(), b.stepper::<E>(h).unwrap());
    let (mut x, mut y) = (state::<A::Vector>(start), state::<B::Vector>(start));
    for step in 0..20 {
        let dw: Vec<f64> =
            dw.iter().enumerate().map(|(k, dw)| dw * f64::from(step * 7 + k as u32).sin()).collect();
        one.step(&mut x, &dw).unwrap();
        other.step(&mut y, &dw).unwrap();
        for (a, b) in numbers(&x).iter().zip(&numbers(&y)) {
            // Some twenty roundings of numbers below 4, and the tolerance of two iterations.
            assert!((a - b).abs() < 4e-14, "{} step {step}: {a} {b}", std::any::type_name::<E>());
        }
    }
}

#[test]
fn loops_do_what_straight_lines_do() {
    let (a, b) = (DrivenInline { drag: 0.4, push: 0.9 }, DrivenLoops { drag: 0.4, push: 0.9 });
    let start: [&[f64]; 2] = [&[0.7], &[-0.6]];
    same::<DeltaPlus, _, _>(&a, &b, start, &[]);
    same::<DeltaMinus, _, _>(&a, &b, start, &[]);
    same::<Midpoint, _, _>(&a, &b, start, &[]);
    same::<Lambda<1, 3>, _, _>(&a, &b, start, &[]);
    same::<Verlet, _, _>(&a, &b, start, &[]);
    same::<Gauss<2>, _, _>(&a, &b, start, &[]);
    same::<Gauss<3>, _, _>(&a, &b, start, &[]);

    let mass = [1.0, 0.5, 2.0, 1.5, 0.8];
    let a = ChainInline { mass, drag: 0.3, sigma: 0.2 };
    let b = ChainLoops { mass: mass.to_vec(), drag: 0.3, sigma: 0.2 };
    let start: [&[f64]; 2] = [&[0.1, -0.2, 0.4, 0.0, 0.3], &[0.5, -0.4, 0.2, 0.9, -0.7]];
    let dw = [0.2, -0.1, 0.3, 0.15, -0.25];
    same::<Midpoint, _, _>(&a, &b, start, &dw);
    same::<DeltaPlus, _, _>(&a, &b, start, &dw);
    same::<DeltaMinus, _, _>(&a, &b, start, &dw);
    same::<Verlet, _, _>(&a, &b, start, &dw);
    same::<Gauss<2>, _, _>(&a, &b, start, &dw);
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
