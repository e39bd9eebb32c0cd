//! Steps against references, and their limits.

use wzvi::nalgebra::{Matrix2, Vector2};
use wzvi::prelude::*;
use wzvi::step::StepInfo;

use fixtures::bath::{
    Chain, Coupled, Damped, Driven, Free, FreeChain, Linked, Oscillator, Rough, RoughLinked, RoughPlane,
};
use fixtures::{larger, reference};

/// Three steps of BAOAB and OBABO with given normals, computed with 40 digits.
#[test]
fn steps_are_those_of_the_reference() {
    let data = reference::data("langevin_steps");
    let mut seen = 0;
    for case in reference::list(&data["cases"]) {
        // Some ten roundings of numbers of the size of 1.
        let bound = 1e-14;
        let system = || {
            let (m, kt) = (reference::numbers(&case["mass"])[0], reference::number(&case["kT"]));
            let gamma = reference::numbers(&case["friction_matrix"][0])[0] / m;
            Oscillator { m, k: 1.0, b: 1.0, gamma, kt }
        };
        match case["scheme"].as_str() {
            Some("BAOAB") => reference::follow::<Baoab, _>(&system(), case, bound),
            Some("OBABO") => {
                reference::follow::<Obabo, _>(&system(), case, bound);
                // Its middle is a step of Verlet.
                reference::follow::<Thermostat<Verlet>, _>(&system(), case, bound);
            }
            _ => continue,
        }
        seen += 1;
    }
    assert_eq!(seen, 2);
}

const OSCILLATOR: Oscillator = Oscillator { m: 0.8, k: 1.3, b: 0.4, gamma: 0.0, kt: 0.7 };

/// The bits of a path with these increments in each step.
fn bits<H, E>(system: &H, start: &State<H::Vector>, h: f64, dw: &[f64]) -> (Vec<u64>, Vec<StepInfo>)
where
    H: Discretized<E> + Hamiltonian,
    H::Vector: wzvi::state::Vector,
{
    use wzvi::state::Vector;
    let (mut state, mut bits, mut infos) = (start.clone(), vec![], vec![]);
    let mut stepper = system.stepper::<E>(h).expect("steps");
    for _ in 0..100 {
        infos.push(stepper.step(&mut state, dw).expect("a step"));
        bits.extend(state.q.components().iter().chain(state.p.components()).map(|x| x.to_bits()));
    }
    (bits, infos)
}

#[test]
fn without_friction_nothing_is_added() {
    let (start, dw) = (State::new([0.3], [-0.4]), [0.2, -0.1]);
    let Oscillator { m, k, b, .. } = OSCILLATOR;
    let free = Free { m, k, b };
    let verlet = bits::<_, Verlet>(&free, &start, 0.1, &[]);
    assert_eq!(verlet.0, bits::<_, Obabo>(&OSCILLATOR, &start, 0.1, &dw).0);
    assert_eq!(verlet.0, bits::<_, Thermostat<Verlet>>(&OSCILLATOR, &start, 0.1, &dw).0);
    assert_eq!(verlet.0, bits::<_, Baoab>(&OSCILLATOR, &start, 0.1, &dw[..1]).0);
    let midpoint = bits::<_, Midpoint>(&free, &start, 0.1, &[]);
    assert_eq!(midpoint, bits::<_, Thermostat<Midpoint>>(&OSCILLATOR, &start, 0.1, &dw));
    let gauss = bits::<_, Gauss<2>>(&free, &start, 0.1, &[]);
    assert_eq!(gauss, bits::<_, Thermostat<Gauss<2>>>(&OSCILLATOR, &start, 0.1, &dw));
    // Backwards, too.
    let back = bits::<_, Midpoint>(&free, &start, -0.1, &[]);
    assert_eq!(back, bits::<_, Thermostat<Midpoint>>(&OSCILLATOR, &start, -0.1, &dw));
    // Any number of degrees of freedom that only the state knows.
    let chain = Chain { gamma: 0.0, kt: 1.0 };
    let start = State::new(vec![0.1, 0.4, -0.2], vec![0.3, 0.0, -0.5]);
    let verlet = bits::<_, Verlet>(&FreeChain, &start, 0.1, &[]);
    assert_eq!(verlet.0, bits::<_, Obabo>(&chain, &start, 0.1, &[0.3; 6]).0);
    assert_eq!(verlet.0, bits::<_, Baoab>(&chain, &start, 0.1, &[0.3; 3]).0);
}

#[test]
fn at_zero_temperature_there_is_friction_alone() {
    // A free particle: p decays by exp(-γ h) in each step, whatever drives the bath.
    let free = Oscillator { m: 0.8, k: 0.0, b: 0.0, gamma: 2.5, kt: 0.0 };
    let (mut state, h) = (State::new([0.0], [1.0]), 0.1_f64);
    let mut stepper = free.stepper::<Baoab>(h).expect("steps");
    for step in 1..=40 {
        stepper.step(&mut state, &[0.7]).expect("a step");
        let expected = (-2.5 * h * f64::from(step)).exp();
        // Two roundings for each step.
        assert!((state.p[0] / expected - 1.0).abs() < 80.0 * f64::EPSILON, "{step}");
    }
    // Without a temperature nothing is drawn, and the path is the same.
    let Oscillator { m, k, b, gamma, .. } = free;
    let silent = Damped { m, k, b, gamma };
    let (mut other, mut stepper) = (State::new([0.0], [1.0]), silent.stepper::<Baoab>(h).expect("steps"));
    for _ in 0..40 {
        stepper.step(&mut other, &[]).expect("a step");
    }
    assert_eq!(other, state);
}

#[test]
fn large_friction_forgets_exactly() {
    // γ h = 10⁶: momenta are new ones, √(m kT) ξ, whatever they were.
    let system = Oscillator { m: 0.5, k: 0.0, b: 0.0, gamma: 1e6, kt: 2.0 };
    let mut state = State::new([0.0], [1e5]);
    let mut stepper = system.stepper::<Obabo>(1.0).expect("steps");
    stepper.step(&mut state, &[0.25, -1.5]).expect("a step");
    assert_eq!((state.q[0], state.p[0]), (0.25 / 0.5, -1.5));
    // γ h = 10⁻¹²: the noise is √(2 m kT γ h) ξ, with no digit lost.
    let weak = Oscillator { gamma: 1e-12, ..system };
    let mut state = State::new([0.0], [0.0]);
    weak.stepper::<Baoab>(1.0).expect("steps").step(&mut state, &[1.0]).expect("a step");
    let expected = (2.0 * 0.5 * 2.0 * 1e-12_f64).sqrt() * (1.0 - 0.5e-12);
    assert!((state.p[0] / expected - 1.0).abs() < 8.0 * f64::EPSILON);
}

/// `E` and `R √h⁻¹` of the O part of a free system of these masses at a place, by their columns: nothing else moves momenta.
fn map_at<H>(system: &H, h: f64, place: [f64; 2], mass: &Matrix2<f64>) -> [Matrix2<f64>; 2]
where
    H: Discretized<Baoab, Vector = Vector2<f64>>,
{
    let (place, inverse) = (Vector2::from(place), mass.try_inverse().expect("masses"));
    let mut stepper = system.stepper::<Baoab>(h).expect("steps");
    let mut step = |p: Vector2<f64>, dw: Vector2<f64>| {
        // It acts in the middle of the step.
        let mut state = State { q: place - inverse * p * (0.5 * h), p, t: 0.0 };
        stepper.step(&mut state, dw.as_slice()).expect("a step");
        state.p
    };
    let (units, zero) = ([Vector2::x(), Vector2::y()], Vector2::zeros());
    let decay = units.map(|unit| step(unit, zero));
    let deviation = units.map(|unit| step(zero, unit * h.sqrt()));
    [decay, deviation].map(|columns| Matrix2::from_columns(&columns))
}

/// `|E M Eᵀ kT + R Rᵀ - kT M|`, largest entry relative to `kT` and the root of the masses.
fn imbalance([decay, deviation]: [Matrix2<f64>; 2], mass: &Matrix2<f64>, kt: f64) -> f64 {
    let left = kt * decay * mass * decay.transpose() + deviation * deviation.transpose() - kt * mass;
    let roots = mass.diagonal().map(f64::sqrt);
    left.component_div(&(kt * roots * roots.transpose())).iter().fold(0.0, |worst, x| larger(worst, x.abs()))
}

#[test]
fn fluctuations_balance_dissipation() {
    for (m, n) in [(1.0, 1.0), (0.3, 7.0), (1e-3, 20.0)] {
        for damping in [
            [[0.9, 0.2], [0.2, 0.4]],
            [[1e-9, 0.0], [0.0, 2.0]],
            // Of rank one.
            [[1.0, 2.0], [2.0, 4.0]],
            [[1e4, -3e3], [-3e3, 1e3]],
        ] {
            let (system, mass) = (Coupled { m, n, k: 0.0, damping, kt: 1.7 }, Matrix2::new(m, 0.0, 0.0, n));
            let [decay, deviation] = map_at(&system, 0.25, [0.0; 2], &mass);
            // Some roundings of numbers of the size of 1.
            let imbalance = imbalance([decay, deviation], &mass, 1.7);
            assert!(imbalance < 30.0 * f64::EPSILON, "{m} {n} {damping:?} {imbalance:e}");
            // The factor is the lower one, with a diagonal that is not negative.
            assert!(deviation.m12 == 0.0 && deviation.m11 >= 0.0 && deviation.m22 >= 0.0);
        }
    }
    // M⁻¹ with the rows (a, b), (b, c), and one rate.
    let (a, b, c, gamma) = (2.0, -0.6, 0.5, 0.8);
    let mass = Matrix2::new(a, b, b, c).try_inverse().expect("masses");
    let constant = map_at(&Linked { a, b, c, k: 0.0, gamma, kt: 1.7 }, 0.25, [0.3, 0.1], &mass);
    assert!(imbalance(constant, &mass, 1.7) < 30.0 * f64::EPSILON);
    let rough = RoughLinked { a, b, c, k: 0.0, gamma, kt: 1.7 };
    let [at_place, there] = [[0.0, 0.1], [0.5, 0.1]].map(|place| map_at(&rough, 0.25, place, &mass));
    assert!(imbalance(there, &mass, 1.7) < 30.0 * f64::EPSILON);
    assert!((0..2).all(|i| (at_place[i] - constant[i]).amax() < 8.0 * f64::EPSILON));
    // Against the exponential function, for little friction.
    let (damping, h) = ([[0.9e-3, 0.2e-3], [0.2e-3, 0.4e-3]], 0.25);
    let (system, mass) =
        (Coupled { m: 0.3, n: 7.0, k: 0.0, damping, kt: 1.0 }, Matrix2::new(0.3, 0.0, 0.0, 7.0));
    let [decay, _] = map_at(&system, h, [0.0; 2], &mass);
    let exact = (Matrix2::from(damping) * mass.try_inverse().expect("masses") * -h).exp();
    assert!((decay - exact).amax() < 10.0 * f64::EPSILON, "{decay} {exact}");
}

#[test]
fn sites_without_friction_are_left_alone() {
    let chain = Chain { gamma: 1.5, kt: 0.8 };
    let free = Chain { gamma: 0.0, kt: 0.8 };
    let start = State::new(vec![0.0, 0.0, 1.0, 0.0], vec![0.3, 0.0, 0.0, -0.5]);
    let [mut warm, mut cold] = [start.clone(), start];
    chain.stepper::<Baoab>(0.1).expect("steps").step(&mut warm, &[0.2, 0.3, 0.4, 0.5]).expect("a step");
    free.stepper::<Baoab>(0.1).expect("steps").step(&mut cold, &[0.0; 4]).expect("a step");
    assert_ne!(warm.p[0], cold.p[0]);
    // Its neighbour feels it by the force alone, the others not yet.
    // (Without any friction two half drifts are one, with other roundings.)
    for (warm, cold) in [(&warm.q, &cold.q), (&warm.p, &cold.p)] {
        assert!((2..4).all(|i| (warm[i] - cold[i]).abs() < 4.0 * f64::EPSILON));
    }
    assert!((warm.q[1] - cold.q[1]).abs() < 4.0 * f64::EPSILON);
}

#[test]
fn friction_of_a_place_is_that_of_a_constant_there() {
    let mass = Matrix2::new(0.6, 0.0, 0.0, 2.0);
    // Without friction of one mass where y is 0.
    for place in [[0.0, -0.7], [0.4, 0.3], [0.0, 0.0]] {
        let rough = RoughPlane { m: 0.6, n: 2.0, k: 0.0, kt: 1.1 };
        let [of_x, of_y] = RoughPlane::rates(place[0], place[1]);
        let damping = [[0.6 * of_x, 0.0], [0.0, 2.0 * of_y]];
        let flat = Coupled { m: 0.6, n: 2.0, k: 0.0, damping, kt: 1.1 };
        let (there, here) = (map_at(&rough, 0.2, place, &mass), map_at(&flat, 0.2, place, &mass));
        // The place itself is rounded.
        assert!((0..2).all(|i| (there[i] - here[i]).amax() < 10.0 * f64::EPSILON), "{there:?} {here:?}");
    }
    let (x, h) = (0.4, 0.2);
    let rough = Rough { m: 0.6, gamma: 0.5, edge: 9.0, kt: 1.1 };
    let same = Oscillator { m: 0.6, k: 1.0, b: 0.0, gamma: 0.5 * (1.0 + x * x), kt: 1.1 };
    let (p, q) = (0.5, x - 0.5 * h * 0.5 / 0.6);
    let begin = State::new([q], [p + 0.5 * h * q]);
    let [mut a, mut b] = [begin, begin];
    rough.stepper::<Baoab>(h).expect("steps").step(&mut a, &[0.3]).expect("a step");
    same.stepper::<Baoab>(h).expect("steps").step(&mut b, &[0.3]).expect("a step");
    assert!((a.q[0] - b.q[0]).abs() < 10.0 * f64::EPSILON && (a.p[0] - b.p[0]).abs() < 10.0 * f64::EPSILON);
}

#[test]
fn listed_noises_come_before_the_bath() {
    let system = Driven { sigma: 0.4, gamma: 1.2, kt: 0.9 };
    let silent = Oscillator { m: 1.0, k: 1.0, b: 0.0, gamma: 1.2, kt: 0.9 };
    let [mut a, mut b] = [State::new([0.2], [0.1]), State::new([0.2], [0.1])];
    let (h, dw) = (0.1, 0.3);
    system.stepper::<Obabo>(h).expect("steps").step(&mut a, &[dw, 0.05, -0.2]).expect("a step");
    // Half of the kick by σ ΔW with each kick of the step.
    let mut stepper = silent.stepper::<Obabo>(h).expect("steps");
    stepper.step(&mut b, &[0.05, -0.2]).expect("a step");
    let shift = -0.5 * 0.4 * dw;
    let decay = (-0.5 * 1.2 * h).exp();
    // The step is linear: the first kick drifts, the second one does not.
    let moved = h * shift;
    assert!((a.q[0] - b.q[0] - moved).abs() < 10.0 * f64::EPSILON);
    let expected = decay * (2.0 * shift - 0.5 * h * moved);
    assert!((a.p[0] - b.p[0] - expected).abs() < 10.0 * f64::EPSILON);
    let plan = <Driven as Discretized<Obabo>>::PLAN;
    assert_eq!((plan.noise, plan.weak_order()), (NoiseClass::Additive, Some(2.0)));
    let plan = <Oscillator as Discretized<Thermostat<Gauss<3>>>>::PLAN;
    assert_eq!((plan.noise, plan.order, plan.weak_order()), (NoiseClass::Thermal, 2, Some(2.0)));
    assert_eq!(plan.strong_order(), Some(1.0));
    assert_eq!(plan.conserves_energy, Knowledge::Refuted);
    assert!(!plan.truncates_increments());
}
