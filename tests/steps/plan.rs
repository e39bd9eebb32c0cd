//! What the compiler chooses is what a person would: how each step is solved, how many unknowns, what is known.

use fixtures::small::{HenonHeiles, Kubo, TwoAdditive};
use wzvi::prelude::*;

use Knowledge::{Proven, Refuted};
use NoiseClass::{Additive, Momentum, Multiplicative, Position};
use Solver::{Explicit, Linear, Newton};

fn plan<E, H: Discretized<E>>() -> Plan {
    H::PLAN
}

/// Solver and size of the largest coupled block.
fn solver<E, H: Discretized<E>>() -> (Solver, usize) {
    (H::PLAN.solver, H::PLAN.unknowns)
}

#[hamiltonian(
    drift = |q, p| 0.5 * p * p - omega * omega * q.cos(),
    embedding = [DeltaPlus, Midpoint, DeltaMinus, Lambda<1, 4>],
)]
struct Pendulum {
    omega: f64,
}

#[test]
fn pendulum() {
    assert_eq!(solver::<DeltaPlus, Pendulum>(), (Explicit, 0));
    assert_eq!(solver::<DeltaMinus, Pendulum>(), (Explicit, 0));
    assert_eq!(solver::<Midpoint, Pendulum>(), (Newton, 1));
    assert_eq!(solver::<Lambda<1, 4>, Pendulum>(), (Newton, 1));
    let plan = plan::<Midpoint, Pendulum>();
    assert_eq!((plan.noise, plan.consistent, plan.conserves_energy), (NoiseClass::None, true, Proven));
    assert_eq!(plan.commuting, Proven);
    assert!(!plan.truncates_increments());
}

#[test]
fn kubo() {
    let midpoint = plan::<Midpoint, Kubo>();
    assert_eq!(
        midpoint,
        Plan {
            solver: Linear,
            unknowns: 1,
            order: 2,
            noise: Multiplicative,
            consistent: true,
            conserves_energy: Proven,
            energy_jumps: false,
            commuting: Proven,
            // Its flow has; the step does not, being of order two.
            has_weak_order_two: true,
            is_out_of_equilibrium: false,
        }
    );
    assert!(midpoint.truncates_increments());
    assert_eq!((midpoint.strong_order(), midpoint.weak_order()), (Some(1.0), Some(1.0)));
    let uncorrected = plan::<Uncorrected<DeltaPlus>, Kubo>();
    assert_eq!((uncorrected.order, uncorrected.strong_order(), uncorrected.weak_order()), (1, None, None));
    assert_eq!(solver::<Uncorrected<DeltaPlus>, Kubo>(), (Explicit, 0));
    assert!(!plan::<Uncorrected<DeltaPlus>, Kubo>().consistent);
    assert!(plan::<Corrected<DeltaPlus>, Kubo>().consistent);
    // The counter-term reads q p: P is found by one division.
    assert_eq!(solver::<Corrected<DeltaPlus>, Kubo>(), (Linear, 1));
    assert!(plan::<Mixed<DeltaPlus, Midpoint>, Kubo>().consistent);
}

#[test]
fn two_additive_noises() {
    for plan in [plan::<Midpoint, TwoAdditive>(), plan::<DeltaPlus, TwoAdditive>()] {
        assert_eq!((plan.noise, plan.consistent), (Additive, true));
        // {p, q} is constant; H0 is not kept.
        assert_eq!((plan.commuting, plan.conserves_energy), (Proven, Refuted));
        assert!(!plan.truncates_increments());
    }
    assert_eq!(solver::<Midpoint, TwoAdditive>(), (Linear, 1));
    assert_eq!(solver::<DeltaPlus, TwoAdditive>(), (Explicit, 0));
}

/// `q1` moves freely and drives `q2`; `p1` follows from both.
#[hamiltonian(
    drift = |[x, y], [u, v]| 0.5 * x * x + u * x.cos() + 0.5 * v * v + y.powi(4) / 4.0 + x * y,
    embedding = [DeltaPlus, Midpoint],
)]
struct Triangular;

#[hamiltonian(
    drift = |[x, y], [u, v]| 0.5 * (u * u + v * v) - x.cos() - y.cos(),
    embedding = [DeltaPlus, Midpoint],
)]
struct TwoPendulums;

#[hamiltonian(drift = |q, p| (1.0 + q * q) * p * p / 2.0, embedding = [DeltaPlus, Midpoint, DeltaMinus])]
struct Metric;

#[hamiltonian(
    drift = |q: [f64; 3], p: [f64; 3]| {
        let kinetic: f64 = p.iter().map(|p| 0.5 * p * p).sum();
        let springs: f64 = (0..3).map(|i| 0.5 * (q[(i + 1) % 3] - q[i]).powi(2)).sum();
        kinetic + springs
    },
    embedding = [DeltaPlus, Midpoint],
)]
struct Ring;

#[hamiltonian(drift = |q, p| a * q * p, noise = [|q, p| b * q * p], embedding = [Midpoint, Uncorrected<DeltaPlus>])]
struct Hyperbolic {
    a: f64,
    b: f64,
}

#[hamiltonian(drift = |_q, p| (1.0 + p * p).sqrt(), embedding = [DeltaPlus, Midpoint])]
struct Free;

#[hamiltonian(
    drift = |[x, y], [u, v]| (1.0 + u * u + v * v).sqrt() + x.sin() * y.sin(),
    embedding = [DeltaPlus, Midpoint],
)]
struct Relativistic;

#[hamiltonian(
    drift = |[x, y], [u, v]| (1.0 + u * u).sqrt() + v.cosh() + x.cos() + y.powi(4),
    embedding = Midpoint,
)]
struct RelativisticPair;

#[test]
fn solvers_of_deterministic_systems() {
    assert_eq!(solver::<DeltaPlus, HenonHeiles>(), (Explicit, 0));
    assert_eq!(solver::<Midpoint, HenonHeiles>(), (Newton, 2));
    assert_eq!(solver::<Midpoint, Triangular>(), (Newton, 1));
    assert_eq!(solver::<Midpoint, TwoPendulums>(), (Newton, 1));
    assert_eq!(solver::<DeltaPlus, TwoPendulums>(), (Explicit, 0));
    assert_eq!(solver::<DeltaPlus, Metric>(), (Newton, 1));
    assert_eq!(solver::<Midpoint, Metric>(), (Newton, 2));
    assert_eq!(solver::<DeltaPlus, Ring>(), (Explicit, 0));
    assert_eq!(solver::<Midpoint, Ring>(), (Linear, 3));
    assert_eq!(solver::<Midpoint, Hyperbolic>(), (Linear, 1));
    assert_eq!(solver::<Uncorrected<DeltaPlus>, Hyperbolic>(), (Linear, 1));
    assert_eq!(solver::<DeltaPlus, Free>(), (Explicit, 0));
    assert_eq!(solver::<Midpoint, Free>(), (Explicit, 0));
    assert_eq!(solver::<DeltaPlus, Relativistic>(), (Explicit, 0));
    assert_eq!(solver::<Midpoint, Relativistic>(), (Newton, 2));
    assert_eq!(solver::<Midpoint, RelativisticPair>(), (Newton, 1));
}

#[test]
fn a_triangular_system_is_solved_in_sequence() {
    let text = <Triangular as Discretized<Midpoint>>::EQUATIONS;
    let (_, step) = text.split_once("\nStep\n").unwrap();
    let blocks: Vec<&str> = step.lines().take_while(|line| line.starts_with("  ")).collect();
    // Whatever the order of independent ones, x comes before y and y before u.
    let position = |of: &[&str]| blocks.iter().position(|line| of.iter().any(|name| line.contains(name)));
    let (x, y, u) = (position(&["Δx"]), position(&["Δy", "δv"]), position(&["δu"]));
    assert!(x < y && y < u && x.is_some(), "{text}");
}

/// A system whose noise and energy are the point.
macro_rules! noisy {
    ($name:ident, drift = $drift:expr, noise = $noise:expr) => {
        #[hamiltonian(drift = $drift, noise = $noise, embedding = [Midpoint, Uncorrected<DeltaPlus>])]
        struct $name;
    };
}

noisy!(ByPosition, drift = |q, p| 0.5 * p * p - q.cos(), noise = [|q, _p| 0.3 * q * q, |q, _p| q.sin()]);
noisy!(ByMomentum, drift = |q, p| 0.5 * p * p + q.powi(4), noise = [|_q, p| 0.3 * p * p]);
noisy!(
    NonCommuting,
    drift = |q, p| 0.5 * (p * p + q * q),
    noise = [|q, _p| 0.5 * q * q, |_q, p| 0.5 * p * p]
);
noisy!(Separable, drift = |q, p| 0.5 * p * p + q.powi(4), noise = [|q, p| q.sin() + p.cos()]);
noisy!(Affine, drift = |q, p| 0.5 * p * p + q.powi(4), noise = [|q, p| 2.0 * q + 3.0 * p]);
noisy!(
    FunctionOfEnergy,
    drift = |q, p| 0.5 * p * p - q.cos(),
    noise = [|q, p| (0.5 * p * p - q.cos()).sin()]
);

#[hamiltonian(drift = |q, p, t| 0.5 * p * p - t.cos() * q.cos(), embedding = Midpoint)]
struct Driven;

#[test]
fn noise_and_conservation() {
    let facts = |plan: Plan| (plan.noise, plan.consistent, plan.conserves_energy, plan.commuting);
    assert_eq!(facts(plan::<Uncorrected<DeltaPlus>, ByPosition>()), (Position, true, Refuted, Proven));
    assert_eq!(facts(plan::<Uncorrected<DeltaPlus>, ByMomentum>()), (Momentum, true, Refuted, Proven));
    assert_eq!(
        facts(plan::<Uncorrected<DeltaPlus>, NonCommuting>()),
        (Multiplicative, true, Refuted, Refuted)
    );
    assert_eq!(facts(plan::<Uncorrected<DeltaPlus>, Separable>()), (Multiplicative, false, Refuted, Proven));
    assert_eq!(facts(plan::<Midpoint, Separable>()), (Multiplicative, true, Refuted, Proven));
    assert_eq!(facts(plan::<Uncorrected<DeltaPlus>, Affine>()), (Additive, true, Refuted, Proven));
    assert_eq!(
        facts(plan::<Midpoint, FunctionOfEnergy>()),
        (Multiplicative, true, Proven, Proven),
        "{{f(H), H}} = 0"
    );
    assert_eq!(plan::<Midpoint, Driven>().conserves_energy, Refuted);
}

/// Whether these are lines of a text, whose indentation does not count.
fn has_lines(text: &str, lines: &[&str]) {
    for line in lines {
        assert!(text.lines().any(|candidate| candidate.trim() == *line), "no line {line:?} in\n{text}");
    }
}

#[test]
fn equations_are_those_of_the_paper() {
    let text = <Pendulum as Discretized<DeltaPlus>>::EQUATIONS;
    has_lines(
        text,
        &[
            "H0 = p²/2 - omega² cos(q)",
            "L_d = P Δq - h (P²/2 - omega² cos(q_i))",
            // The paper's q_{i+1} = q_i + h p_{i+1}, p_{i+1} = p_i - h omega² sin(q_i).
            "∂L_d/∂P = 0:  Δq = h P",
            "p_i = -D1 L_d:  P = p_i + δp,  δp = -h omega² sin(q_i)",
            "p_{i+1} = D2 L_d:  p_{i+1} - p_i = δp",
            "H0 is a first integral: kept by the step nearly, within O(h)",
        ],
    );
    let text = <Kubo as Discretized<Uncorrected<DeltaPlus>>>::EQUATIONS;
    has_lines(
        text,
        &[
            "H1 = sigma (p² + q²)/2",
            "L_d = P Δq - h a (P² + q_i²)/2 - sigma ΔW (P² + q_i²)/2",
            "∂L_d/∂P = 0:  Δq = h a P + sigma P ΔW",
            "p_i = -D1 L_d:  P = p_i + δp,  δp = -h a q_i - sigma q_i ΔW",
            "p_{i+1} = D2 L_d:  p_{i+1} - p_i = δp",
            "converges to another system, with drift Hamiltonian H0 - D; D = sigma² q p/2",
            "h → 0, then ε → 0: X_{ε,n} → X_ε → X",
            "ε → 0, then h → 0: X_{ε,n} → X_n → the system with H0 - D, not X: not asymptotically preserving",
        ],
    );
    let text = <Kubo as Discretized<Midpoint>>::EQUATIONS;
    has_lines(
        text,
        &[
            "q_{i+1/2} = q_i + Δq/2",
            "∂L_d/∂P = 0:  Δq = h a P + sigma P ΔW",
            "p_i = -D1 L_d:  P = p_i + δp,  δp = (-h a q_{i+1/2} - sigma q_{i+1/2} ΔW)/2",
            "p_{i+1} = D2 L_d:  p_{i+1} - p_i = 2 δp",
            "converges to the Stratonovich system; D = 0",
            "ε → 0, then h → 0: X_{ε,n} → X_n → X: asymptotically preserving",
            "each first integral of X is one of every X_ε: its rates along H0 and each noise vanish one by one",
        ],
    );
    let without_noise = <Pendulum as Discretized<Midpoint>>::EQUATIONS;
    assert!(!without_noise.contains("X_"), "{without_noise}");
}

#[hamiltonian(
    drift = |q, p| 0.5 * (p * p + q * q),
    noise = [|q, _| -s * q],
    embedding = [DeltaPlus, Midpoint, Verlet, Mixed<Midpoint, DeltaPlus>, Gauss<2>],
)]
struct Shaken {
    s: f64,
}

#[hamiltonian(
    drift = |q, p| 0.5 * p * p,
    noise = [|q, _| 0.5 * s * q * q],
    embedding = [Midpoint, Verlet],
)]
struct Lensed {
    s: f64,
}

#[hamiltonian(
    drift = |q, p| 0.5 * a * (q * q + p * p),
    noise = [|q, p| 0.5 * s * (q * q + p * p)],
    embedding = [Midpoint, Gauss<2>],
)]
struct Turning {
    a: f64,
    s: f64,
}

/// `E z_i z_j` at `t = 1` from `z = (1, 0)`, of steps that are affine in the state: their means over a normal increment, by the trapezoidal rule, which
/// is exact to rounding for such integrands.
fn second_moments<E, H: Discretized<E, Vector = wzvi::nalgebra::SVector<f64, 1>>>(
    system: &H,
    steps: u32,
) -> [f64; 3] {
    let h = 1.0 / f64::from(steps);
    let mut stepper = system.stepper::<E>(h).unwrap();
    let mut maps = Vec::new();
    for i in -180..=180 {
        let x = 0.05 * f64::from(i);
        let weight = 0.05 * (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
        let mut image = |q: f64, p: f64| {
            let mut state = State::new([q], [p]);
            stepper.step(&mut state, &[h.sqrt() * x]).unwrap();
            [state.q[0], state.p[0]]
        };
        let (zero, one, two) = (image(0.0, 0.0), image(1.0, 0.0), image(0.0, 1.0));
        maps.push((
            weight,
            zero,
            [[one[0] - zero[0], two[0] - zero[0]], [one[1] - zero[1], two[1] - zero[1]]],
        ));
    }
    // Means and moments [q², qp, p²] of the state.
    let (mut mean, mut moments) = ([1.0, 0.0], [1.0, 0.0, 0.0]);
    for _ in 0..steps {
        let (mut next_mean, mut next) = ([0.0; 2], [0.0; 3]);
        for (weight, b, a) in &maps {
            let row = |i: usize| a[i][0] * mean[0] + a[i][1] * mean[1];
            (0..2).for_each(|i| next_mean[i] += weight * (row(i) + b[i]));
            for (slot, (i, j)) in [(0, 0), (0, 1), (1, 1)].into_iter().enumerate() {
                let square = a[i][0] * a[j][0] * moments[0]
                    + (a[i][0] * a[j][1] + a[i][1] * a[j][0]) * moments[1]
                    + a[i][1] * a[j][1] * moments[2];
                next[slot] += weight * (square + row(i) * b[j] + row(j) * b[i] + b[i] * b[j]);
            }
        }
        (mean, moments) = (next_mean, next);
    }
    moments
}

/// The order of the second moments, from three step sizes.
fn weak_order<E, H: Discretized<E, Vector = wzvi::nalgebra::SVector<f64, 1>>>(system: &H) -> f64 {
    let [coarse, middle, fine] = [16, 32, 64].map(|steps| second_moments::<E, H>(system, steps));
    let distance = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    (distance(coarse, middle) / distance(middle, fine)).log2()
}

/// Measured without paths. The next term of the error is `h` to `h²` times the first: a tenth of the order.
#[test]
fn the_weak_order_is_the_one_of_the_plan() {
    fn check<E, H: Discretized<E, Vector = wzvi::nalgebra::SVector<f64, 1>>>(system: &H, order: f64) {
        let measured = weak_order::<E, H>(system);
        assert_eq!(H::PLAN.weak_order(), Some(order), "{measured}");
        assert!((measured - order).abs() < 0.15, "{measured} {order}");
    }
    let shaken = Shaken { s: 1.0 };
    check::<Midpoint, _>(&shaken, 2.0);
    check::<Verlet, _>(&shaken, 2.0);
    check::<Gauss<2>, _>(&shaken, 2.0);
    check::<DeltaPlus, _>(&shaken, 1.0);
    // The drift at the middle, the noise at the start.
    check::<Mixed<Midpoint, DeltaPlus>, _>(&shaken, 1.0);
    // Σ {H_k, {H_k, H_0}} = s² q²
    check::<Midpoint, _>(&Lensed { s: 1.0 }, 1.0);
    check::<Verlet, _>(&Lensed { s: 1.0 }, 1.0);
    // The energy is kept: second moments show the phase.
    check::<Midpoint, _>(&Turning { a: 1.5, s: 1.0 }, 1.0);
    check::<Gauss<2>, _>(&Turning { a: 1.5, s: 1.0 }, 2.0);
}
