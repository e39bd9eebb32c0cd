//! Steps of large systems at which the fixed point does not contract: what linear equations cost does not grow with the stiffness, and
//! factors serve many steps.

use fixtures::stiff::{Fput, Torus, field, waves};
use wzvi::elements::{Iteration, Method};
use wzvi::memory::{LinearWork, StepMemory};
use wzvi::nalgebra::DVector;
use wzvi::prelude::*;
use wzvi::system::MemoryOf;

type Memory<H> = MemoryOf<H, Midpoint, f64>;

/// What linear equations took in each step.
fn work<H: Discretized<Midpoint, Vector = DVector<f64>>>(
    system: &H,
    h: f64,
    state: &mut State<DVector<f64>>,
    steps: usize,
) -> Vec<(u32, LinearWork)> {
    let prepared = system.prepare(h).unwrap();
    let mut memory = system.memory();
    let mut total = LinearWork::default();
    (0..steps)
        .map(|_| {
            let (q, p) = (state.q.as_mut_slice(), state.p.as_mut_slice());
            let effort = system.advance(&prepared, 0.0, h, q, p, &[], &mut memory).unwrap();
            let before = std::mem::replace(&mut total, memory.linear_work());
            let taken = LinearWork {
                factorisations: total.factorisations - before.factorisations,
                products: total.products - before.products,
            };
            (effort.iterations, taken)
        })
        .collect()
}

/// At rest where these are.
fn still(q: Vec<f64>) -> State<DVector<f64>> {
    let p = vec![0.0; q.len()];
    State::new(q, p)
}

/// Springs from soft to stiff: once it is known what the linear equations take, a solution takes no more products than four, and factors
/// serve several steps.
#[test]
fn products_do_not_grow_with_the_stiffness() {
    let h = 0.05;
    for k_h_squared in [1.0, 1e2, 1e4, 1e6] {
        let torus = Torus { side: 64, stiffness: k_h_squared / (h * h), depth: 1.0 };
        let taken = work(&torus, h, &mut still(field(64)), 40);
        let late = &taken[20..];
        for (iterations, LinearWork { products, .. }) in late {
            assert!(*products <= 4 * u64::from(*iterations), "{k_h_squared:e}: {taken:?}");
        }
        let factorisations: u64 = late.iter().map(|(_, work)| work.factorisations).sum();
        assert!(factorisations <= 10, "{k_h_squared:e}: {taken:?}");
    }
}

/// At `k h² = 1` corrections that are smooth shrink under the fixed point, and rounding grows. It is tried in vain in fewer and fewer steps, which
/// take twice as many iterations as their neighbours.
#[test]
fn a_fixed_point_that_misleads_is_rarely_tried() {
    let h = 0.05;
    let torus = Torus { side: 64, stiffness: 1.0 / (h * h), depth: 1.0 };
    let taken = work(&torus, h, &mut still(field(64)), 160);
    let late: Vec<u32> = taken[40..].iter().map(|(iterations, _)| *iterations).collect();
    let least = *late.iter().min().unwrap();
    let tries = late.iter().filter(|&&iterations| 2 * iterations > 3 * least).count();
    assert!(tries <= 3, "after 32 steps, and after 64: {late:?}");
}

/// The table of `docs/guide/speed.md`.
#[test]
fn large_stiff_lattices_run() {
    let (h, steps) = (0.05, 40);
    for k_h_squared in [1.0, 1e2, 1e4, 1e6] {
        let torus = Torus { side: 256, stiffness: k_h_squared / (h * h), depth: 1.0 };
        let mut state = still(field(256));
        let energy = torus.energy(&state);
        let taken = work(&torus, h, &mut state, steps);
        let error = (torus.energy(&state) - energy).abs() / energy;
        let sum = |list: &[(u32, LinearWork)]| {
            list.iter().fold((0, 0, 0), |(iterations, products, factorisations), (own, work)| {
                (iterations + own, products + work.products, factorisations + work.factorisations)
            })
        };
        let (all, late) = (sum(&taken), sum(&taken[steps / 2..]));
        let per_step = |total: f64, steps: usize| total / steps as f64;
        println!(
            "{k_h_squared:e}: {:.1} iterations, {:.1} products, {} factorisations, {error:.1e}",
            per_step(f64::from(all.0), steps),
            per_step(late.1 as f64, steps / 2),
            all.2,
        );
        // As in the small lattices.
        assert!(late.1 <= 4 * u64::from(late.0), "{k_h_squared:e}: {late:?}");
        // The mid-point keeps quadratic energies. The rest of the wells, a thousandth of them where the field is a thousandth off their
        // bottoms, it keeps within `h² ω² / 12` of that, `ω² = 2`.
        assert!(error < 1e-3 * h * h * 2.0 / 12.0, "{k_h_squared:e}: {error:e}");
    }
}

/// The discrete Euler-Lagrange equations, which know nothing of how they were solved.
#[test]
fn stiff_lattices_are_solved_to_rounding() {
    let h = 0.05;
    for k_h_squared in [1.0, 1e2, 1e4, 1e6] {
        let torus = Torus { side: 32, stiffness: k_h_squared / (h * h), depth: 1.0 };
        let path = torus.simulate::<Midpoint>(h).start(still(field(32))).steps(10).run().unwrap();
        let residual = path.euler_lagrange_residual(&torus).unwrap();
        // Forces `h k q` of eight springs, each rounded, and increments of `q` that are rounded when they are added: `ε q` as well.
        let bound = 16.0 * f64::EPSILON * (1.0 + k_h_squared) / h;
        assert!(residual < bound, "{k_h_squared:e}: {residual:e} {bound:e}");
    }
}

#[test]
fn factors_serve_many_steps() {
    // The fixed point does not contract: (h ω / 2)² is 9 for the fastest waves.
    let (n, h, steps) = (1024, 3.0, 100);
    let fput = Fput { alpha: 0.25, beta: 0.25 };
    let (mut state, mut newton) = (still(waves(n)), still(waves(n)));
    let taken = work(&fput, h, &mut state, steps);
    let factorisations: u64 = taken.iter().map(|(_, work)| work.factorisations).sum();
    let iterations: u32 = taken.iter().map(|(iterations, _)| iterations).sum();
    let mut stepper = fput.stepper::<Midpoint>(h).unwrap().iteration(Iteration::Newton);
    assert_eq!(stepper.method(), Some(Method::Undecided));
    let mut each = 0;
    (0..steps).for_each(|_| each += stepper.step(&mut newton, &[]).unwrap().iterations);
    // New factors cost as much as two iterations with old ones: half as many as there are steps, and less in all than with
    // new ones in each iteration.
    assert!(2 * factorisations <= steps as u64, "{factorisations}");
    assert!(
        2 * factorisations + u64::from(iterations) < 3 * u64::from(each),
        "{factorisations} {iterations} {each}"
    );
    // Both solve each step to the rounding of its equations; a hundred roundings, of momenta that turn by `h ω / 2` of coordinates.
    let apart = (&state.q - &newton.q).amax().max((&state.p - &newton.p).amax());
    assert!(apart < 1e-12, "{apart:e}");
}

/// A copy of what the steps before left, without the factors, goes on with the same bits, and so does a step after one that failed.
#[test]
fn copies_and_failures_change_no_bits() {
    let fput = Fput { alpha: 0.25, beta: 0.25 };
    let torus = Torus { side: 40, stiffness: 4e4, depth: 20.0 };
    same_bits(&fput, 3.0, still(waves(300)));
    same_bits(&torus, 0.05, still(field(40)));
}

fn same_bits<H: Discretized<Midpoint, Vector = DVector<f64>>>(
    system: &H,
    h: f64,
    start: State<DVector<f64>>,
) {
    let prepared = system.prepare(h).unwrap();
    let run = |disturb: &mut dyn FnMut(usize, &mut Memory<H>)| {
        let (mut state, mut memory) = (start.clone(), system.memory());
        for step in 0..24 {
            disturb(step, &mut memory);
            let (q, p) = (state.q.as_mut_slice(), state.p.as_mut_slice());
            system.advance(&prepared, 0.0, h, q, p, &[], &mut memory).unwrap();
        }
        let numbers = state.q.iter().chain(&state.p).map(|x| x.to_bits()).collect::<Vec<_>>();
        (numbers, memory.linear_work())
    };
    let (expected, whole) = run(&mut |_, _| {});
    assert!(whole.factorisations <= 12, "{whole:?}");
    let (copied, again) = run(&mut |step, memory| {
        if step % 5 == 4 {
            *memory = memory.clone();
        }
    });
    assert!(copied == expected && again.factorisations > whole.factorisations, "{again:?}");
    let (failed, _) = run(&mut |step, memory| {
        if step % 7 == 3 {
            let n = start.q.len();
            let (mut q, mut p) = (vec![0.1; n], vec![0.0; n]);
            q[n / 2] = f64::INFINITY;
            assert!(system.advance(&prepared, 0.0, h, &mut q, &mut p, &[], memory).is_err());
        }
    });
    assert!(failed == expected);
}
