//! Paths of schemes, lists of one, and a half that is written otherwise; what a step of each scheme does is in the tests of steps.

use wzvi::prelude::*;

/// The path of a type is the user's business.
#[hamiltonian(drift = |q, p| q * p, embedding = [wzvi::embedding::Midpoint, ::wzvi::prelude::Corrected<DeltaPlus>,])]
struct Paths;

#[hamiltonian(drift = |q, p| q * p, embedding = Lambda<1, 3>, invariant = |q, p| q * p)]
struct Single;

/// Consistent with every noise.
#[hamiltonian(drift = |q, p| q * p, noise = |q, p| q * p, embedding = [Lambda<1, 2>, Mixed<Lambda<1, 3>, Lambda<2, 4>>])]
struct Halves;

fn once<E, H: Discretized<E, Vector = wzvi::nalgebra::SVector<f64, 1>>>(system: &H, dw: &[f64]) {
    let mut state = State::new([0.5], [1.0]);
    system.stepper::<E>(0.01).unwrap().step(&mut state, dw).unwrap();
    assert!(H::PLAN.consistent && state.t == 0.01);
}

#[test]
fn compiles_and_runs() {
    once::<Midpoint, _>(&Paths, &[]);
    once::<Corrected<DeltaPlus>, _>(&Paths, &[]);
    once::<Lambda<1, 3>, _>(&Single, &[]);
    once::<Lambda<1, 2>, _>(&Halves, &[0.1]);
    once::<Mixed<Lambda<1, 3>, Lambda<2, 4>>, _>(&Halves, &[0.1]);
    assert_eq!(Single.invariants(), 1);
}
