//! Noise forces: consistency, orders, what is kept, and runs beside each other.

use fixtures::larger;
use wzvi::nalgebra::SVector;
use wzvi::prelude::*;

/// `dp = s p ∘ dW`, `p = p_0 e^{s W}`.
#[hamiltonian(
    drift = |q, p| 0.0 * q + 0.0 * p,
    noise_force = [|_q, p| sigma * p],
    embedding = [Midpoint, Verlet, Gauss<2>, Uncorrected<DeltaPlus>, Uncorrected<DeltaMinus>],
)]
struct Geometric {
    sigma: f64,
}

const SIGMA: f64 = 0.6;

/// The mean of `ln p(1) - s W(1)` over increments of both signs, for steps `h`.
fn drift<E>(h: f64) -> f64
where
    Geometric: Discretized<E, Vector = SVector<f64, 1>>,
{
    let system = Geometric { sigma: SIGMA };
    let steps = (1.0 / h).round() as usize;
    let mut stepper = system.stepper::<E>(h).unwrap();
    let mut state = State::new([0.0], [1.0]);
    for step in 0..steps {
        // Increments of two values have the moments that count, and a sum that vanishes.
        let dw = if step % 2 == 0 { h.sqrt() } else { -h.sqrt() };
        stepper.step(&mut state, &[dw]).unwrap();
    }
    state.p[0].ln()
}

#[test]
fn consistent_schemes_follow_the_stratonovich_system() {
    for h in [1e-2, 1e-3, 1e-4] {
        assert!(drift::<Midpoint>(h).abs() < h, "{}", drift::<Midpoint>(h));
        assert!(drift::<Verlet>(h).abs() < h);
        assert!(drift::<Gauss<2>>(h).abs() < h);
        // Another force d = (1/2 - l) s² p.
        let wrong = 0.5 * SIGMA * SIGMA;
        assert!((drift::<Uncorrected<DeltaPlus>>(h) - wrong).abs() < h);
        assert!((drift::<Uncorrected<DeltaMinus>>(h) + wrong).abs() < h);
    }
    const { assert!(<Geometric as Discretized<Midpoint>>::PLAN.consistent) };
    const { assert!(!<Geometric as Discretized<Uncorrected<DeltaPlus>>>::PLAN.consistent) };
    let plan = <Geometric as Discretized<Midpoint>>::PLAN;
    assert_eq!((plan.noise, plan.commuting), (NoiseClass::Multiplicative, Knowledge::Proven));
    assert!(plan.conserves_energy == Knowledge::Proven, "without a kinetic energy no power");
}

/// Noise Hamiltonians come before noise forces.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.25 * q.powi(4),
    noise = [|q, _p| 0.3 * q],
    noise_force = [|q, _p| 0.2 * q.cos(), |_q, _p| -0.1],
    embedding = [DeltaPlus, Midpoint, Verlet, Gauss<2>],
)]
struct Driven;

#[test]
fn increments_are_those_of_noises_then_of_forces() {
    assert_eq!(Driven.noises(), 3);
    let state = State::new([0.4], [0.7]);
    let gradient = Driven.noise_gradient(1, &state);
    assert_eq!((gradient.q[0], gradient.p[0]), (-0.2 * 0.4f64.cos(), 0.0));
    assert_eq!(Driven.noise_energy(1, &state), 0.0);
    assert_eq!(Driven.noise_gradient(0, &state).q[0], 0.3);
    // Power: f ∂H/∂p.
    assert!((Driven.energy_rate(1, &state) - 0.2 * 0.4f64.cos() * 0.7).abs() < 1e-16);
    // One step of DeltaPlus by hand: forces depend on coordinates alone.
    let (h, dw) = (0.1, [0.3, -0.5, 0.2]);
    let mut stepped = state;
    Driven.stepper::<DeltaPlus>(h).unwrap().step(&mut stepped, &dw).unwrap();
    let p = 0.7 - h * 0.4f64.powi(3) - 0.3 * dw[0] + 0.2 * 0.4f64.cos() * dw[1] - 0.1 * dw[2];
    assert!((stepped.p[0] - p).abs() < 4e-16 && (stepped.q[0] - (0.4 + h * p)).abs() < 4e-16);
    const { assert!(matches!(<Driven as Discretized<DeltaPlus>>::PLAN.solver, Solver::Explicit)) };
    const { assert!(matches!(<Driven as Discretized<Verlet>>::PLAN.solver, Solver::Explicit)) };
    const { assert!(matches!(<Driven as Discretized<DeltaPlus>>::PLAN.noise, NoiseClass::Position)) };
    const { assert!(matches!(<Driven as Discretized<DeltaPlus>>::PLAN.commuting, Knowledge::Proven)) };
    const { assert!(matches!(<Driven as Discretized<DeltaPlus>>::PLAN.conserves_energy, Knowledge::Refuted)) };
}

/// Drag along the radius keeps the angular momentum, and a force across the motion the energy.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) - 1.0 / (x * x + y * y).sqrt(),
    force = |[x, y], [px, py]| {
        let radial = drag * (x * px + y * py) / (x * x + y * y);
        [-radial * x, -radial * y]
    },
    invariant = [|[x, y], [px, py]| x * py - y * px],
    embedding = [Midpoint, DeltaPlus, Verlet, Gauss<2>],
)]
struct Radial {
    drag: f64,
}

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) + 0.5 * (x * x + y * y),
    force = |[x, _y], [px, py]| [field * x * py, -field * x * px],
    embedding = [Midpoint],
)]
struct Magnetic {
    field: f64,
}

#[test]
fn symmetries_that_forces_share_are_kept() {
    let system = Radial { drag: 0.2 };
    let start = State::new([1.0, 0.2], [-0.1, 0.9]);
    macro_rules! kept {
        ($($scheme:ty),*) => {$(
            let path = system.simulate::<$scheme>(0.05).start(start).steps(200).run().unwrap();
            let drift = path.states().iter().map(|state| (system.invariant(0, state) - system.invariant(0, &start)).abs());
            // Two hundred roundings of numbers of size one.
            assert!(drift.fold(0.0, larger) < 1e-13);
        )*};
    }
    kept!(Midpoint, DeltaPlus, Verlet, Gauss<2>);
    const { assert!(matches!(<Radial as Discretized<Midpoint>>::PLAN.conserves_energy, Knowledge::Refuted)) };
    const { assert!(matches!(<Magnetic as Discretized<Midpoint>>::PLAN.conserves_energy, Knowledge::Proven)) };
    let text = <Radial as Discretized<Midpoint>>::EQUATIONS;
    assert!(text.contains("F0 = [") && text.contains("F0 · ∂H0/∂p"), "{text}");
    assert!(!text.contains("kept by the step nearly"), "{text}");
}

#[test]
fn paths_of_ensembles_are_paths() {
    macro_rules! same {
        ($($scheme:ty),*) => {$(
            // Twenty roundings of numbers of size one: sums of single paths are compensated.
            fixtures::steps::lanes_are_steppers::<$scheme, _>(&Driven, [&[0.4], &[0.7]], 0.05);
        )*};
    }
    same!(DeltaPlus, Midpoint, Verlet);
}
