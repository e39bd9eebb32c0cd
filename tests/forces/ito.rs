//! Systems in the sense of Ito: their moments, and what the conversion adds.

use wzvi::nalgebra::SVector;
use wzvi::prelude::*;

/// `dp = μ p dt + s p dW`: `E p = p_0 e^{μ t}`, `E p² = p_0² e^{(2μ + s²) t}`.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p,
    force = |q, p| mu * p,
    noise_force = [|q, p| s * p],
    calculus = Ito,
    embedding = [Midpoint, Gauss<2>],
)]
struct Geometric {
    mu: f64,
    s: f64,
}

/// The same by hand.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p,
    force = |q, p| mu * p - 0.5 * s * s * p,
    noise_force = [|q, p| s * p],
    embedding = [Midpoint, Gauss<2>],
)]
struct ByHand {
    mu: f64,
    s: f64,
}

/// `dp = -q dt + √(1 + p²) dW`.
#[hamiltonian(
    drift = |q, p| 0.5 * (p * p + q * q),
    noise_force = [|q, p| (1.0 + p * p).sqrt()],
    calculus = Ito,
    embedding = Midpoint,
)]
struct Root;

/// `dq = p dt + s dW`, `dp = -s k q dW`: the correction is the field of `-s² k q/2`.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p,
    noise = [|q, p| s * (p + 0.5 * k * q * q)],
    calculus = Ito,
    embedding = Midpoint,
)]
struct Sheared {
    s: f64,
    k: f64,
}

/// One process for each site, in loops, with a table and the time: `c_i = -1/2 s_i² cos²(t) p_i`.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| p.iter().map(|p| 0.5 * p * p).sum::<f64>(),
    noise_force = [|q, p, t, k| (0..q.len()).map(|i| if i == k { s[i] * t.cos() * p[i] } else { 0.0 }).collect::<Vec<f64>>(); 3],
    calculus = Ito,
    embedding = Midpoint,
)]
struct Sites {
    s: Vec<f64>,
}

/// Two noises of which neither correction is that of a Hamiltonian, but whose sum is constant: `c = (s²/2,
/// 0)`, the field of `s² p/2`.
#[hamiltonian(
    drift = |q, p| 0.5 * (p * p + q * q),
    noise = [|q, p| s * q * p, |q, p| s * (0.5 * (q * q + p * p) + q)],
    calculus = Ito,
    embedding = Midpoint,
)]
struct Together {
    s: f64,
}

/// Two families of noises of sites, whose corrections cancel site by site.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| q.iter().zip(p).map(|(q, p)| 0.5 * (p * p + q * q)).sum::<f64>(),
    noise = [[|q, p, k| 0.5 * s * (q[k] * q[k] + p[k] * p[k]); 3], [|q, p, k| s * q[k] * p[k]; 3]],
    calculus = Ito,
    embedding = Midpoint,
)]
struct Cancelling {
    s: f64,
}

/// A wave of `q + p` beside a linear noise: the correction is the field of `s² b/2 cos(q + p)`, which is no
/// `D/2`.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p,
    noise = [|q, p| s * ((q + p).sin() + b * q)],
    calculus = Ito,
    embedding = Midpoint,
)]
struct Wave {
    s: f64,
    b: f64,
}

/// `y(1)` of `y' = rates(y)`, by the method of Runge and Kutta with 1000 steps: exact to rounding here.
fn moments<const N: usize>(start: [f64; N], rates: impl Fn([f64; N]) -> [f64; N]) -> [f64; N] {
    let h = 1e-3;
    let moved = |y: [f64; N], k: [f64; N], by: f64| std::array::from_fn(|i| y[i] + by * k[i]);
    (0..1000).fold(start, |y, _| {
        let k1 = rates(y);
        let k2 = rates(moved(y, k1, 0.5 * h));
        let k3 = rates(moved(y, k2, 0.5 * h));
        let k4 = rates(moved(y, k3, h));
        std::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]))
    })
}

/// `E q`, `E p`, `E q²`, `E qp` and `E p²` at time 1 within 5 standard errors and the bias of the step, against `exact`.
fn has_moments<H>(name: &str, system: &H, start: [f64; 2], exact: [f64; 5])
where
    H: Discretized<Midpoint, Vector = SVector<f64, 1>> + Sync,
{
    let names = ["q", "p", "qq", "qp", "pp"];
    let statistics = system
        .ensemble::<Midpoint>(0.02)
        .start(State::new([start[0]], [start[1]]))
        .paths(4000)
        .seed(11)
        .until(1.0)
        .observe("q", |state| state.q[0])
        .observe("p", |state| state.p[0])
        .observe("qq", |state| state.q[0].powi(2))
        .observe("qp", |state| state.q[0] * state.p[0])
        .observe("pp", |state| state.p[0].powi(2))
        .run()
        .unwrap();
    for (of, exact) in names.into_iter().zip(exact) {
        let (mean, error) = (statistics.mean(of).unwrap(), statistics.standard_error(of).unwrap());
        // The weak error of the mid-point is of order h, with a constant of the size of the moment.
        let tolerance = 5.0 * error + 0.02 * (0.1 + exact.abs());
        assert!((mean - exact).abs() < tolerance, "{name}: E {of} = {mean} ± {error}, not {exact}");
    }
}

#[test]
fn moments_are_those_of_the_ito_equation() {
    let (mu, s) = (-0.5, 0.6);
    let linear = |[q, p, qq, qp, pp]: [f64; 5]| {
        let growth = 2.0 * mu + s * s;
        [p, mu * p, 2.0 * qp, pp + mu * qp, growth * pp + 0.0 * q * qq]
    };
    has_moments("geometric", &Geometric { mu, s }, [0.0, 1.0], moments([0.0, 1.0, 0.0, 0.0, 1.0], linear));
    let oscillator = |[q, p, qq, qp, pp]: [f64; 5]| [p, -q, 2.0 * qp, pp - qq, 1.0 + pp - 2.0 * qp];
    has_moments("oscillator", &Root, [1.0, 0.0], moments([1.0, 0.0, 1.0, 0.0, 0.0], oscillator));
    let (s, k) = (0.8, 1.0);
    let sheared = |[q, p, qq, qp, pp]: [f64; 5]| {
        [p, 0.0 * pp, 2.0 * qp + s * s, pp - s * s * k * q, s * s * k * k * qq]
    };
    has_moments("sheared", &Sheared { s, k }, [0.3, 0.5], moments([0.3, 0.5, 0.09, 0.15, 0.25], sheared));
}

/// Of noises whose corrections are Hamiltonian, zero or of the momenta alone in their sum.
#[test]
fn corrections_of_several_noises_are_added_before_they_are_judged() {
    let s = 0.5;
    let together = |[q, p, qq, qp, pp]: [f64; 5]| {
        let square = s * s;
        [
            p,
            -q,
            2.0 * qp + square * (qq + pp),
            pp - qq - square * (2.0 * qp + p),
            -2.0 * qp + square * (pp + qq + 2.0 * q + 1.0),
        ]
    };
    has_moments("together", &Together { s }, [0.3, 0.5], moments([0.3, 0.5, 0.09, 0.15, 0.25], together));
    let state = State::new([2.0], [1.0]);
    let energy = Together { s }.energy(&state);
    assert!((energy - (2.5 + 0.5 * s * s)).abs() < 1e-15, "{energy}");
    // Nothing is added.
    let state = State::new(vec![0.3, -0.2, 0.5], vec![1.0, 0.4, -0.7]);
    let exact: f64 = state.q.iter().zip(&state.p).map(|(q, p)| 0.5 * (p * p + q * q)).sum();
    assert_eq!(Cancelling { s }.energy(&state), exact);
    assert!(<Cancelling as Discretized<Midpoint>>::EQUATIONS.contains("nothing: both senses are the same"));
}

/// `c = -1/2 (X · ∇) X` by differences, against the field of what the conversion adds to the drift.
#[test]
fn waves_beside_linear_noises_have_a_hamiltonian_correction() {
    let wave = Wave { s: 0.7, b: 1.3 };
    let field = |[q, p]: [f64; 2]| {
        let slope = (q + p).cos();
        [wave.s * slope, -wave.s * (slope + wave.b)]
    };
    let added = |[q, p]: [f64; 2]| wave.energy(&State::new([q], [p])) - 0.5 * p * p;
    let d = 1e-5;
    for z in [[0.3, -0.4], [1.1, 0.8], [-2.0, 0.5]] {
        let x = field(z);
        let moved = |sign: f64| field([z[0] + sign * d * x[0], z[1] + sign * d * x[1]]);
        let c = [0, 1].map(|i| -0.5 * (moved(1.0)[i] - moved(-1.0)[i]) / (2.0 * d));
        let slope = |half: usize| {
            let at = |sign: f64| {
                let mut moved = z;
                moved[half] += sign * d;
                added(moved)
            };
            (at(1.0) - at(-1.0)) / (2.0 * d)
        };
        // Both differences are exact to d² and rounding over d.
        assert!((slope(1) - c[0]).abs() < 1e-9 && (slope(0) + c[1]).abs() < 1e-9, "{z:?}: {c:?}");
    }
}

/// The converted system is the one written by hand, to the rounding of a force written in another order.
#[test]
fn the_conversion_is_the_one_by_hand() {
    let (ours, theirs) = (Geometric { mu: -0.5, s: 0.6 }, ByHand { mu: -0.5, s: 0.6 });
    let mut states = [State::new([0.1], [0.9]); 2];
    let (mut one, mut two) =
        (ours.stepper::<Gauss<2>>(0.05).unwrap(), theirs.stepper::<Gauss<2>>(0.05).unwrap());
    for step in 0..50 {
        let dw = [0.2 * f64::from(step).sin()];
        one.step(&mut states[0], &dw).unwrap();
        two.step(&mut states[1], &dw).unwrap();
        assert!(
            (states[0].p[0] - states[1].p[0]).abs() < 1e-13
                && (states[0].q[0] - states[1].q[0]).abs() < 1e-13
        );
    }
    let said = <Geometric as Discretized<Midpoint>>::EQUATIONS;
    assert!(said.contains("Conversion from Ito to Stratonovich"), "{said}");
    assert!(!<ByHand as Discretized<Midpoint>>::EQUATIONS.contains("Ito"));
    // A Hamiltonian correction is in the energy: H0 = p²/2 - s² k q/2.
    let state = State::new([2.0], [1.0]);
    assert!((Sheared { s: 0.8, k: 0.5 }.energy(&state) - (0.5 - 0.64 * 0.5)).abs() < 1e-15);
}

/// `p_i(h)` of one step without increments decays at half the square of the intensity.
#[test]
fn families_with_tables_and_time_are_converted() {
    let system = Sites { s: vec![0.2, 0.9, 1.4] };
    let mut state = State::new(vec![0.0; 3], vec![1.0, -2.0, 0.5]);
    let h = 1e-3;
    system.stepper::<Midpoint>(h).unwrap().step(&mut state, &[0.0; 3]).unwrap();
    for (i, (s, p)) in system.s.iter().zip([1.0, -2.0, 0.5]).enumerate() {
        let exact = p * (-0.5 * s * s * h).exp();
        // Local errors of the mid-point are of order h³, and cos²(h/2) is 1 - h²/4.
        assert!((state.p[i] - exact).abs() < 4.0 * h * h * h, "{i}: {} {exact}", state.p[i]);
    }
}
