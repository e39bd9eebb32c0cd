//! Sums over sites in nonlinear functions: the steps of straight lines, of double sums, and at the cost of one sum.

use allocation_counter::measure;
use fixtures::folder;
use fixtures::steps::{
    advance, apart, asymmetry, distance, end, form_apart, has_order, lanes_are_steppers, numbers,
};
use wzvi::checkpoint::Checkpoint;
use wzvi::elements::Method;
use wzvi::error::Error;
use wzvi::modified::ModifiedHamiltonian;
use wzvi::nalgebra::DVector;
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

/// Sites of a lattice that winds around a torus, and a stiff mean field: too wide for a band.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let n = q.len();
        let mean = q.iter().sum::<f64>() / n as f64;
        let bond = |i: usize, k: usize| 0.5 * stiff * (q[i] - q[k]).powi(2);
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + (0..n).map(|i| bond(i, (i + 1) % n) + bond(i, (i + 35) % n) + 0.25 * q[i].powi(4)).sum::<f64>()
            + j * n as f64 * mean * mean * (1.0 + mean * mean)
    },
    embedding = Midpoint,
)]
struct Torus {
    stiff: f64,
    j: f64,
}

/// The products with vectors have the terms of rank one, and factors without these precondition them.
#[test]
fn krylov_steps_have_the_terms_of_rank_one() {
    let ([q, p], torus) = (start(1200), Torus { stiff: 1e3, j: 1e5 });
    let mut state = State::new(q, p);
    let mut stepper = torus.stepper::<Midpoint>(0.05).unwrap().iteration(Iteration::Newton);
    for _ in 0..2 {
        let step = stepper.step(&mut state, &[]).unwrap();
        // With another Jacobian the iteration converges by a constant factor a step, if at all.
        assert!(step.iterations <= 10, "{}", step.iterations);
    }
    assert_eq!(stepper.method(), Some(Method::Krylov));
}

/// Orders of kicks and drifts, of implicit steps and their compositions, in a system with one force for all.
#[test]
fn steps_have_their_orders() {
    let ([q, p], rotors) = (start(20), Rotors { j: 1.3 });
    let start: [&[f64]; 2] = [&q, &p];
    // Terms of the next orders change what is measured by less than 0.1 at these step sizes.
    has_order::<Verlet, _>(&rotors, start, (2.0, 20), 2, 0.1);
    has_order::<Midpoint, _>(&rotors, start, (2.0, 20), 2, 0.1);
    has_order::<Composed<Verlet, BlanesMoan6>, _>(&rotors, start, (2.0, 10), 6, 0.1);
    has_order::<Composed<Midpoint, Yoshida4>, _>(&rotors, start, (2.0, 40), 4, 0.1);
    has_order::<Gauss<4>, _>(&rotors, start, (2.0, 4), 8, 0.1);
}

/// The modified energy of a step of order two is kept to order four.
#[test]
fn modified_energies_are_kept() {
    fn drift<E, H>(system: &H, steps: u32) -> f64
    where
        E: wzvi::modified::ModifiedBy,
        H: Discretized<E, Vector = DVector<f64>> + wzvi::modified::Conservative,
    {
        let ([q, p], h) = (start(6), 4.0 / f64::from(steps));
        let (mut state, mut stepper) = (State::new(q, p), system.stepper::<E>(h).unwrap());
        let modified = ModifiedHamiltonian::<E>::new(h);
        let before = modified.energy(system, &state);
        let gaps = (0..steps).map(|_| {
            stepper.step(&mut state, &[]).unwrap();
            (modified.energy(system, &state) - before).abs()
        });
        gaps.fold(0.0, f64::max)
    }
    let rotors = Rotors { j: 1.3 };
    for order in [
        (drift::<Verlet, _>(&rotors, 40) / drift::<Verlet, _>(&rotors, 80)).log2(),
        (drift::<Midpoint, _>(&rotors, 40) / drift::<Midpoint, _>(&rotors, 80)).log2(),
    ] {
        assert!((order - 4.0).abs() < 0.2, "{order}");
    }
}

/// Runs that stop and go on have the bits of those that do not, also where only the state has a size.
#[test]
fn resumed_runs_have_the_same_bits() {
    fn check<E>(j: f64, n: usize)
    where
        Rotors: Discretized<E, Vector = DVector<f64>>,
    {
        let ([q, p], rotors, folder) = (start(n), Rotors { j }, folder!("collective"));
        let run = |steps| rotors.simulate::<E>(0.05).start(State::new(q.clone(), p.clone())).steps(steps);
        let file = || Checkpoint::to(folder.join("run"));
        for steps in [3, 8] {
            run(steps).checkpoint(file()).run().unwrap();
        }
        let resumed = run(12).checkpoint(file()).run().unwrap();
        let whole = run(12).run().unwrap();
        assert_eq!(resumed.states(), whole.states(), "{} {j} {n}", std::any::type_name::<E>());
        assert_eq!(resumed.iterations(), whole.iterations(), "{} {j} {n}", std::any::type_name::<E>());
    }
    check::<Verlet>(1.3, 5);
    for (j, n) in [(1.3, 5), (1e3, 70)] {
        check::<Midpoint>(j, n);
        check::<Gauss<4>>(j, n);
    }
}

/// The derivative of the end by the start is symplectic, and that of straight lines.
#[test]
fn tangents_are_those_of_straight_lines() {
    fn tangent<E, H: Discretized<E>>(system: &H) -> Result<Vec<Vec<f64>>, Error> {
        let [q, p] = start(3);
        let start = fixtures::extremes::state(&q, &p);
        let tangent = system.simulate::<E>(0.1).start(start).steps(20).tangent()?;
        Ok(tangent.by_start.column_iter().map(|column| column.iter().copied().collect()).collect())
    }
    macro_rules! check {
        ($($scheme:ty),*) => {$(
            let one = tangent::<$scheme, _>(&mean_field::Slice { j: 0.7 }).unwrap();
            let other = tangent::<$scheme, _>(&mean_field::Small { j: 0.7 }).unwrap();
            // Roundings of 20 steps, of derivatives up to 3.
            assert!(distance(&one.concat(), &other.concat()) < 1e-13, "{}", stringify!($scheme));
            assert!(form_apart(&one, 1.0) < 1e-13, "{}", stringify!($scheme));
        )*};
    }
    check!(Verlet, Midpoint, Gauss<2>);
}

/// Steps and tangents make no lists but those of their first step, and Newton's method none at its first
/// use.
#[test]
fn steps_allocate_nothing() {
    fn steps<E>(rotors: &Rotors, iteration: Iteration) -> u64
    where
        Rotors: Discretized<E, Vector = DVector<f64>>,
    {
        let [q, p] = start(20);
        let (mut state, mut stepper) = (State::new(q, p), rotors.stepper::<E>(0.05).unwrap());
        (0..3).for_each(|_| assert!(stepper.step(&mut state, &[]).is_ok()));
        let mut stepper = stepper.iteration(iteration);
        measure(|| (0..3).for_each(|_| assert!(stepper.step(&mut state, &[]).is_ok()))).count_total
    }
    let rotors = Rotors { j: 1.3 };
    assert_eq!(steps::<Verlet>(&rotors, Iteration::Automatic), 0);
    assert_eq!(steps::<Midpoint>(&rotors, Iteration::Automatic), 0);
    assert_eq!(steps::<Midpoint>(&rotors, Iteration::Newton), 0);
    assert_eq!(steps::<Gauss<4>>(&rotors, Iteration::Automatic), 0);
    let tangent = |steps| {
        let [q, p] = start(3);
        let run = mean_field::Slice { j: 0.7 };
        let run = run.simulate::<Midpoint>(0.05).start(State::new(q, p)).steps(steps);
        measure(|| assert!(run.tangent().is_ok())).count_total
    };
    assert_eq!(tangent(4), tangent(30));
}

/// Sites with a quadratic mean field in a bath, or slowed by friction.
macro_rules! damped {
    ($name:ident, $vector:ty, |$q:ident| $n:expr, $($keys:tt)*) => {
        #[hamiltonian(
            drift = |$q: $vector, p: $vector| {
                let total = $q.iter().sum::<f64>();
                (0..$n).map(|i| 0.5 * p[i] * p[i] + 0.75 * $q[i] * $q[i]).sum::<f64>() - j * total * total / (2.0 * $n as f64)
            },
            friction = gamma,
            $($keys)*
        )]
        struct $name {
            j: f64,
            gamma: f64,
            kt: f64,
        }
    };
}
damped!(HeatedThree, [f64; 3], |q| 3, temperature = kt, embedding = [Baoab, Thermostat<Midpoint>],);
damped!(HeatedSlice, &[f64], |q| q.len(), temperature = kt, embedding = [Baoab, Thermostat<Midpoint>],);
damped!(
    SlowedThree,
    [f64; 3],
    |q| 3,
    force = |q, p| {
        let flow = p.iter().map(|p| p * p * p).sum::<f64>();
        (0..3).map(move |i| -0.1 * kt * flow * q[i].cos())
    },
    embedding = Midpoint,
);
damped!(
    SlowedSlice,
    &[f64],
    |q| q.len(),
    force = |q, p| {
        let flow = p.iter().map(|p| p * p * p).sum::<f64>();
        (0..q.len()).map(move |i| -0.1 * kt * flow * q[i].cos())
    },
    embedding = Midpoint,
);

/// With friction of one rate the momenta of a step are scaled, and sums over them with them.
#[test]
fn friction_and_baths_do_not_depend_on_the_spelling() {
    let [q, p] = start(3);
    let start: [&[f64]; 2] = [&q, &p];
    let (j, gamma, kt) = (0.9, 0.8, 0.7);
    let (one, other) = (HeatedThree { j, gamma, kt }, HeatedSlice { j, gamma, kt });
    // Some roundings of numbers up to 2 in each of 12 steps.
    assert!(apart::<Baoab, _, _>((&one, &other), start, (0.1, 12), &[0.3; 3]) < 1e-14);
    assert!(apart::<Thermostat<Midpoint>, _, _>((&one, &other), start, (0.1, 12), &[0.3; 6]) < 1e-14);
    let (one, other) = (SlowedThree { j, gamma, kt }, SlowedSlice { j, gamma, kt });
    assert!(apart::<Midpoint, _, _>((&one, &other), start, (0.1, 12), &[]) < 1e-14);
}

/// `M²/N` of a Gaussian measure: `kT / (k - J)`.
#[test]
fn a_bath_has_the_canonical_fluctuations_of_the_mean_field() {
    let heated = HeatedSlice { j: 0.9, gamma: 1.0, kt: 0.7 };
    let rest = State::new(vec![0.0; 4], vec![0.0; 4]);
    let run = heated.ensemble::<Baoab>(0.2).start(rest).paths(400).seed(3).until(30.0);
    let run = run.observe("m2", |state| state.q.sum().powi(2) / state.q.len() as f64).run().unwrap();
    let (found, exact) = (run.last().unwrap().mean(0), 0.7 / (1.5 - 0.9));
    // 400 squares of normals have a relative deviation of √(2/400); positions of Baoab are exact here.
    assert!((found / exact - 1.0).abs() < 4.0 * (2.0_f64 / 400.0).sqrt(), "{found} {exact}");
}

/// Paths in lanes have the bits of steppers: of kicks, of Newton's method, of baths and with noise.
#[test]
fn lanes_are_paths_alone() {
    let ([q, p], heated) = (start(13), HeatedSlice { j: 0.9, gamma: 1.0, kt: 0.7 });
    let (start, driven): ([&[f64]; 2], _) = ([&q, &p], DrivenSlice { sigma: 0.1, drag: 0.3 });
    lanes_are_steppers::<Verlet, _>(&driven, start, 0.05);
    lanes_are_steppers::<Midpoint, _>(&driven, start, 0.05);
    lanes_are_steppers::<Baoab, _>(&heated, start, 0.05);
    lanes_are_steppers::<Thermostat<Midpoint>, _>(&heated, start, 0.05);
    let rotors = Rotors { j: 3e3 };
    let starts = (0..6).map(|path| {
        let scale = |list: &[f64]| list.iter().map(|x| 0.3 * f64::from(path) * x).collect::<Vec<_>>();
        State::new(scale(&q), scale(&p))
    });
    let starts: Vec<_> = starts.collect();
    let run = rotors.ensemble::<Gauss<4>>(0.05).starts_from(starts.clone()).steps(6);
    let run = run.record_every(6).keep_paths(1 << 20).run().unwrap();
    // Some of these steps are hard.
    for (path, mut state) in starts.into_iter().enumerate() {
        let mut stepper = rotors.stepper::<Gauss<4>>(0.05).unwrap().plain();
        (0..6).for_each(|_| assert!(stepper.step(&mut state, &[]).is_ok()));
        let kept = run.paths().and_then(|paths| paths.at(path, 1)).unwrap();
        assert_eq!(kept[..26], numbers(&state), "path {path}");
    }
}
