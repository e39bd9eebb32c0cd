//! Sums over sites in nonlinear functions: the steps of straight lines, of double sums, and at the cost of one sum.

use fixtures::steps::{advance, asymmetry, distance, end};
use wzvi::prelude::*;

/// A system in straight lines at three sites, and in loops with a const generic and on slices.
macro_rules! spelled {
    ($name:ident: $($scheme:ty),*; |$q:ident, $p:ident, $n:ident, $t:pat_param| $body:expr) => {
        mod $name {
            use super::*;
            spelled!(@ Small, [f64; 3], 3, []; $($scheme),*; $q $p $n $t, $body);
            spelled!(@ General, [f64; N], N, [<const N: usize>]; $($scheme),*; $q $p $n $t, $body);
            spelled!(@ Slice, &[f64], $q.len(), []; $($scheme),*; $q $p $n $t, $body);

            #[test]
            fn all_spellings_are_one_system() {
                $(for j in [0.7, 60.0] {
                    let systems = (Small { j }, General::<3> { j }, Slice { j });
                    agree::<$scheme, _, _>(&systems.0, &systems.2, 3);
                    agree::<$scheme, _, _>(&systems.1, &systems.2, 3);
                })*
            }

            #[test]
            fn steps_are_symplectic() {
                $({
                    let [q, p] = start(3);
                    let apart =
                        asymmetry::<$scheme, _>(&Slice { j: 0.7 }, [&q, &p], [0.25, 0.125], &[], 1.0);
                    // Roundings of derivatives of size one, through a solution to rounding.
                    assert!(apart < 1e-13, "{}: {apart:e}", stringify!($scheme));
                })*
            }
        }
    };
    (@ $name:ident, $vector:ty, $len:expr, [$($generics:tt)*]; $($scheme:ty),*; $q:ident $p:ident $n:ident $t:pat_param, $body:expr) => {
        #[hamiltonian(
            drift = |$q: $vector, $p: $vector, $t| {
                let $n = $len;
                $body
            },
            embedding = [$($scheme),*],
        )]
        pub(super) struct $name $($generics)* {
            pub(super) j: f64,
        }
    };
}

fn start(n: usize) -> [Vec<f64>; 2] {
    let wave = |factor: f64| (0..n).map(|i| (factor * (i as f64 + 0.3)).sin()).collect();
    [wave(1.7), wave(0.9)]
}

/// Steps of two spellings end at the same state.
fn agree<E, A: Discretized<E>, B: Discretized<E>>(one: &A, other: &B, n: usize) {
    let [q, p] = start(n);
    let gap = distance(&end::<E, _>(one, [&q, &p], 0.5, 10), &end::<E, _>(other, [&q, &p], 0.5, 10));
    // Roundings of ten steps, of sums of up to 80 numbers in another order, with forces up to 60.
    assert!(gap < 2e-12, "{}: {gap:e}", std::any::type_name::<E>());
}

spelled!(mean_field: Verlet, Midpoint, Gauss<2>; |q, p, n, _| {
    let c: f64 = q.iter().map(|q| q.cos()).sum();
    let s: f64 = q.iter().map(|q| q.sin()).sum();
    p.iter().map(|p| 0.5 * p * p).sum::<f64>() - 0.5 * j / n as f64 * (c * c + s * s)
});
spelled!(trap: Midpoint; |q, p, n, _| {
    let total = (0..n).map(|i| 1.0 + 0.1 * i as f64).sum::<f64>();
    let mean = (0..n).map(|i| (1.0 + 0.1 * i as f64) * q[i]).sum::<f64>() / total;
    let well = |x: f64| 0.25 * x.powi(4) + 0.1 * j * x * x;
    p.iter().map(|p| 0.5 * p * p).sum::<f64>() + q.iter().map(|q| well(q - mean)).sum::<f64>()
});
spelled!(magnet: Verlet, Lambda<1, 4>; |q, p, n, t| {
    let mean = q.iter().map(|q| q.tanh()).sum::<f64>() / n as f64;
    p.iter().map(|p| 0.5 * p * p).sum::<f64>() + q.iter().map(|q| 0.25 * q.powi(4)).sum::<f64>()
        - j * (mean + 0.1 * t.sin()).cosh().ln()
});
spelled!(both_halves: Midpoint, DeltaPlus, Verlet; |q, p, n, _| {
    let total = p.iter().sum::<f64>();
    let work = (0..n).map(|i| q[i].cos() * p[i]).sum::<f64>();
    p.iter().map(|p| 0.5 * p * p).sum::<f64>() + q.iter().map(|q| 0.01 * j * q * q).sum::<f64>()
        + 0.1 * (total * total + 1.0).sqrt() * (0.2 * work).sin()
});
spelled!(of_a_sum_of_a_sum: Midpoint; |q, p, n, _| {
    let mean = q.iter().sum::<f64>() / n as f64;
    let variance = q.iter().map(|q| (q - mean) * (q - mean)).sum::<f64>() / n as f64;
    p.iter().map(|p| 0.5 * p * p).sum::<f64>() + j * (1.0 + variance).sqrt() + 0.5 * q.iter().map(|q| q * q).sum::<f64>()
});
spelled!(momenta_along_a_chain: Verlet, Midpoint; |q, p, n, _| {
    let total = p.iter().sum::<f64>();
    p.iter().map(|p| 0.5 * p * p).sum::<f64>() + 0.1 * j * (1.0 + total * total).sqrt()
        + (1..n).map(|i| 0.25 * (q[i] - q[i - 1]).powi(4)).sum::<f64>()
});
spelled!(factor_of_each_term: Midpoint; |q, p, n, _| {
    let total = p.iter().sum::<f64>() / n as f64;
    p.iter().map(|p| 0.5 * p * p).sum::<f64>() + q.iter().map(|q| 0.05 * j * total * q.cos()).sum::<f64>()
});
spelled!(condition: Verlet, Midpoint; |q, p, n, _| {
    let norm = q.iter().map(|q| q * q).sum::<f64>() / n as f64;
    let outside = if norm > 0.25 { 0.1 * j * (norm - 0.25).powi(3) } else { 0.0 };
    p.iter().map(|p| 0.5 * p * p).sum::<f64>() + 0.5 * q.iter().map(|q| q * q).sum::<f64>() + outside
});

/// Points in the plane around their mean, which exchange angular momentum with nothing.
#[hamiltonian(
    drift = |q: [[f64; 2]; N], p: [[f64; 2]; N]| {
        let x = q.iter().map(|q| q[0]).sum::<f64>();
        let y = q.iter().map(|q| q[1]).sum::<f64>();
        p.iter().map(|p| 0.5 * (p[0] * p[0] + p[1] * p[1])).sum::<f64>() + depth * (1.0 + x * x + y * y).ln()
    },
    invariant = [|q, p| q.iter().zip(p).map(|(q, p)| q[0] * p[1] - q[1] * p[0]).sum::<f64>()],
    embedding = [Verlet, Midpoint],
)]
struct Plane<const N: usize> {
    depth: f64,
}

/// Rotors whose total momentum is conserved, by proof.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let n = q.len() as f64;
        let c = q.iter().map(|q| q.cos()).sum::<f64>();
        let s = q.iter().map(|q| q.sin()).sum::<f64>();
        p.iter().map(|p| 0.5 * p * p).sum::<f64>() - 0.5 * j / n * (c * c + s * s)
    },
    invariant = [|q, p| p.iter().sum::<f64>()],
    embedding = [Verlet, Midpoint, Gauss<4>],
)]
struct Rotors {
    j: f64,
}

/// The same as a double sum.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let n = q.len() as f64;
        let pairs = (0..q.len()).map(|i| (0..q.len()).map(|k| (q[i] - q[k]).cos()).sum::<f64>()).sum::<f64>();
        p.iter().map(|p| 0.5 * p * p).sum::<f64>() - 0.5 * j / n * pairs
    },
    embedding = [Verlet, Midpoint, Gauss<4>],
)]
struct Pairs {
    j: f64,
}

#[test]
fn a_mean_field_is_the_sum_over_all_pairs() {
    let (one, other) = (Rotors { j: 1.3 }, Pairs { j: 1.3 });
    for n in [5, 80] {
        agree::<Verlet, _, _>(&one, &other, n);
        agree::<Midpoint, _, _>(&one, &other, n);
        agree::<Gauss<4>, _, _>(&one, &other, n);
    }
}

/// Springs that are stiff beside the mean field, and a mean field that is stiff itself.
#[test]
fn newton_steps_have_the_terms_of_rank_one() {
    for (j, n) in [(1.3, 80), (2e3, 80), (2e3, 700)] {
        let [q, p] = start(n);
        let rotors = Rotors { j };
        let mut ends = Vec::new();
        for iteration in [Iteration::Newton, Iteration::Automatic] {
            let mut state = State::new(q.clone(), p.clone());
            let mut stepper = rotors.stepper::<Midpoint>(0.05).unwrap().iteration(iteration);
            let step = stepper.step(&mut state, &[]).unwrap();
            // With the whole Jacobian Newton's method squares the error.
            assert!(iteration != Iteration::Newton || step.iterations <= 8, "{j}, {n}: {}", step.iterations);
            ends.push([state.q.as_slice(), state.p.as_slice()].concat());
        }
        // Roundings of momenta up to 50, through the equations of a stiff step.
        let gap = distance(&ends[0], &ends[1]);
        assert!(gap < 1e-11, "{j}, {n}: {gap:e}");
    }
}

#[test]
fn proven_momenta_are_kept_to_rounding() {
    let [q, p] = start(200);
    for end in [
        end::<Verlet, _>(&Rotors { j: 2.0 }, [&q, &p], 5.0, 100),
        end::<Midpoint, _>(&Rotors { j: 2.0 }, [&q, &p], 5.0, 100),
    ] {
        let [before, after] = [&p, &end[200..]].map(|p| p.iter().sum::<f64>());
        // 100 steps of 200 roundings of numbers up to 2.
        assert!((after - before).abs() < 1e-11, "{before} {after}");
    }
    let [q, p] = start(60);
    let spin =
        |z: &[f64]| (0..30).map(|i| z[2 * i] * z[60 + 2 * i + 1] - z[2 * i + 1] * z[60 + 2 * i]).sum::<f64>();
    let end = end::<Midpoint, _>(&Plane::<30> { depth: 1.0 }, [&q, &p], 5.0, 100);
    assert!((spin(&end) - spin(&[q, p].concat())).abs() < 1e-11);
}

#[test]
fn the_slopes_are_in_the_text() {
    let text = <Rotors as Discretized<Midpoint>>::EQUATIONS;
    for line in ["S1 = Σ_(i=0..n - 1) [cos(q[i])]", "= ∂H/∂S1 =", "first integral Σ_(i=0..n - 1) [p[i]]: "]
    {
        assert!(text.contains(line), "{line}\n{text}");
    }
    assert_eq!(<Rotors as Discretized<Verlet>>::PLAN.solver, Solver::Explicit);
    assert_eq!(<Rotors as Discretized<Verlet>>::PLAN.conserves_energy, Knowledge::Proven);
}

/// Noise and a force that act through the mean, with their sums written out where the size is a literal.
macro_rules! driven {
    ($name:ident, $vector:ty, |$q:ident| $n:expr) => {
        #[hamiltonian(
            drift = |$q: $vector, p: $vector| (0..$n).map(|i| 0.5 * (p[i] * p[i] + $q[i] * $q[i])).sum::<f64>(),
            noise = [|$q, p| sigma * ($q.iter().sum::<f64>() / $n as f64).tanh(), |$q, p| 0.1 * $q.iter().sum::<f64>().cos()],
            force = |$q: $vector, p: $vector| {
                let mean = p.iter().sum::<f64>() / $n as f64;
                (0..$n).map(move |i| -drag * mean.tanh() / p[i].cosh())
            },
            embedding = [Verlet, Midpoint],
        )]
        struct $name {
            sigma: f64,
            drag: f64,
        }
    };
}
driven!(DrivenThree, [f64; 3], |q| 3);
driven!(DrivenSlice, &[f64], |q| q.len());

#[test]
fn noises_and_forces_read_sums() {
    let ([q, p], dw) = (start(3), [0.3, -0.2]);
    let (one, other) = (DrivenThree { sigma: 0.8, drag: 0.3 }, DrivenSlice { sigma: 0.8, drag: 0.3 });
    let gap = distance(
        &advance::<Midpoint, f64, _>(&one, [&q, &p], [0.0, 0.25], &dw),
        &advance::<Midpoint, f64, _>(&other, [&q, &p], [0.0, 0.25], &dw),
    );
    // Some roundings of numbers up to 2, through a solution to rounding.
    assert!(gap < 1e-14, "{gap:e}");
}
