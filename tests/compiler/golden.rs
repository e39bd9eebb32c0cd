//! The golden expansions compile and step: `golden` has what `#[hamiltonian]` writes for several systems, as it was
//! reviewed; `GOLDEN=overwrite cargo test -p wzvi-macros golden` renews it.

#![allow(warnings, clippy::all, missing_docs, reason = "generated code, and not for users")]

macro_rules! scenes {
    ($($name:ident),*) => { $( #[rustfmt::skip] pub mod $name; )* };
}
scenes!(
    all_pairs,
    bath,
    branch,
    chain,
    clock,
    corrected,
    flows,
    forced,
    lattice,
    network,
    newton_block,
    noise,
    noise_family,
    oscillators,
    pendulum,
    rod,
    rods
);

use wzvi::prelude::*;

/// One step of 0.01 from (q, p) with the increments `dw` moves the state and fails nowhere.
macro_rules! steps {
    ($system:expr, $scheme:ty, $q:expr, $p:expr, $dw:expr) => {{
        let system = $system;
        let mut stepper = system.stepper::<$scheme>(0.01).expect("a step size");
        let mut state = State::new($q, $p);
        let before = state.clone();
        stepper.step(&mut state, &$dw).expect("a step");
        assert!(state.q != before.q && state.q.iter().chain(state.p.iter()).all(|x| x.is_finite()));
    }};
}

#[test]
fn golden_expansions_step() {
    steps!(flows::Perturbed { omega: 1.0, epsilon: 0.1 }, Composed<Verlet, Aba864>, [0.3], [0.2], []);
    steps!(pendulum::Pendulum { omega: 1.0 }, Midpoint, [0.3], [0.2], []);
    steps!(clock::Kepler { m: 1.0, k: 1.0 }, Verlet, [0.3, 0.1], [0.2, -0.4], []);
    steps!(newton_block::HenonHeiles, Midpoint, [0.3, 0.1], [0.2, -0.4], []);
    steps!(noise::Kubo { a: 1.0, sigma: 0.5 }, Midpoint, [0.3], [0.2], [0.05]);
    steps!(noise::Kubo { a: 1.0, sigma: 0.5 }, Uncorrected<DeltaPlus>, [0.3], [0.2], [0.05]);
    steps!(corrected::Multiplicative { sigma: 0.5 }, Corrected<DeltaPlus>, [0.3], [0.2], [0.05]);
    steps!(
        oscillators::Oscillators { m: 1.0, n: 2.0, k: 1.0, c: 0.3 },
        Midpoint,
        [0.3, 0.1],
        [0.2, -0.4],
        []
    );
    steps!(branch::Wall { edge: 0.1, stiffness: 2.0 }, Midpoint, [0.3], [0.2], []);
    steps!(forced::Driven { push: 0.5, gamma: 0.3 }, Midpoint, [0.3], [0.2], []);
    let heated = bath::Heated { m: 2.0, gamma: 0.3, kt: 1.0 };
    steps!(heated, Baoab, [0.3, 0.1], [0.2, -0.4], [0.05, -0.03]);
    steps!(chain::Chain { beta: 0.5 }, Midpoint, vec![0.3, 0.1, -0.2], vec![0.2, -0.4, 0.1], []);
    steps!(lattice::Lattice::<3> { k: 0.5 }, DeltaPlus, vec![0.3; 6], vec![0.2; 6], []);
    let bodies = all_pairs::Bodies { g: 1.0, mass: vec![1.0, 2.0] };
    steps!(bodies, DeltaPlus, vec![0.3, 0.1, 1.4, -0.7], vec![0.2, 0.1, -0.1, 0.0], []);
    let network = network::Network { bonds: vec![[0, 2], [1, 2]], strength: vec![1.0, 0.5] };
    steps!(network, DeltaPlus, vec![0.3, 0.1, 1.4], vec![0.2, 0.1, -0.1], []);
    let bath = noise_family::Bath { sigma: 0.5, sites: 2 };
    steps!(bath, Midpoint, vec![0.3, 0.1], vec![0.2, 0.1], [0.05, -0.03]);
    steps!(rod::Rod { g: 1.0, l: 1.0 }, Rattle, [0.6, -0.8], [0.8, 0.6], []);
    let rods = rods::Rods::<2> { g: 1.0, l: 1.0, sigma: 0.5 };
    steps!(rods, Rattle, vec![0.6, -0.8, 0.6, -1.8], vec![0.8, 0.6, 0.8, 0.6], [0.05, -0.03]);
}
