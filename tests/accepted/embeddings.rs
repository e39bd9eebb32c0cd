//! Every embedding, bare where it is consistent.

use wzvi::prelude::*;

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + omega * (1.0 - q.cos()),
    embedding = [
        DeltaPlus, Midpoint, DeltaMinus, Lambda<1, 4>, Mixed<Midpoint, DeltaPlus>, Corrected<DeltaPlus>,
        Uncorrected<DeltaPlus>, Corrected<Mixed<Lambda<1, 3>, DeltaMinus>>,
    ],
)]
struct Deterministic {
    omega: f64,
}

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + q.powi(4),
    noise = [|q, _| sigma * q, |q, _| q.sin()],
    embedding = [DeltaPlus, DeltaMinus, Midpoint, Lambda<2, 3>, Mixed<DeltaPlus, Midpoint>, Mixed<Midpoint, DeltaMinus>],
)]
struct Additive {
    sigma: f64,
}

#[hamiltonian(
    drift = |q, p| 0.5 * a * (q * q + p * p),
    noise = |q, p| 0.5 * sigma * (q * q + p * p),
    embedding = [
        Midpoint, Lambda<1, 2>, Mixed<DeltaPlus, Midpoint>, Mixed<Lambda<1, 3>, Lambda<1, 2>>, Corrected<DeltaPlus>,
        Uncorrected<DeltaPlus>, Corrected<DeltaMinus>, Uncorrected<DeltaMinus>, Corrected<Lambda<1, 4>>,
        Uncorrected<Lambda<1, 4>>, Corrected<Mixed<Midpoint, DeltaPlus>>, Uncorrected<Mixed<Midpoint, DeltaPlus>>,
    ],
    invariant = [|q, p| q * q + p * p],
)]
struct Multiplicative {
    a: f64,
    sigma: f64,
}

/// The path of a type is the user's business.
#[hamiltonian(drift = |q, p| q * p, embedding = [wzvi::embedding::Midpoint, ::wzvi::prelude::Corrected<DeltaPlus>,])]
struct Paths;

#[hamiltonian(drift = |q, p| q * p, embedding = Lambda<1, 3>, invariant = |q, p| q * p)]
struct Single;

fn once<E, H: Discretized<E>>(system: &H, mut state: State<H::Vector>, dw: &[f64])
where
    H::Vector: Copy,
{
    system.stepper::<E>(0.01).unwrap().step(&mut state, dw).unwrap();
    assert!(H::EQUATIONS.len() > 20);
    assert!(state.t == 0.01);
}

#[test]
fn compiles_and_runs() {
    let state = || State::new([0.5], [1.0]);
    let system = Deterministic { omega: 1.0 };
    once::<DeltaPlus, _>(&system, state(), &[]);
    once::<DeltaMinus, _>(&system, state(), &[]);
    once::<Lambda<1, 4>, _>(&system, state(), &[]);
    once::<Corrected<Mixed<Lambda<1, 3>, DeltaMinus>>, _>(&system, state(), &[]);
    let system = Additive { sigma: 1.0 };
    once::<DeltaPlus, _>(&system, state(), &[0.1, 0.05]);
    once::<Mixed<Midpoint, DeltaMinus>, _>(&system, state(), &[0.1, 0.05]);
    let system = Multiplicative { a: 1.0, sigma: 0.5 };
    once::<Lambda<1, 2>, _>(&system, state(), &[0.1]);
    once::<Mixed<Lambda<1, 3>, Lambda<1, 2>>, _>(&system, state(), &[0.1]);
    once::<Corrected<Mixed<Midpoint, DeltaPlus>>, _>(&system, state(), &[0.1]);
    once::<Uncorrected<Mixed<Midpoint, DeltaPlus>>, _>(&system, state(), &[0.1]);
    assert!(<Multiplicative as Discretized<Midpoint>>::PLAN.consistent);
    assert!(!<Multiplicative as Discretized<Uncorrected<DeltaPlus>>>::PLAN.consistent);
    once::<Midpoint, _>(&Paths, state(), &[]);
    once::<Corrected<DeltaPlus>, _>(&Paths, state(), &[]);
    once::<Lambda<1, 3>, _>(&Single, state(), &[]);
    assert_eq!((system.invariants(), Single.invariants()), (1, 1));
}
