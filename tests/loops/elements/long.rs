//! Long chains and long runs: memory, hard steps, checkpoints.

use wzvi::elements::Method;
use wzvi::memory::StepMemory;
use wzvi::nalgebra::DVector;
use wzvi::prelude::*;

use super::{Chain, ChainUnrolled, difference, wave};

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let v = |d: f64| 0.5 * d * d + 0.25 * beta * d.powi(4);
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + q.windows(2).map(|w| v(w[1] - w[0])).sum::<f64>()
            + v(q[0]) + v(q[q.len() - 1])
    },
    embedding = [DeltaPlus, Midpoint],
)]
struct Long {
    beta: f64,
}

/// The most bytes per site that a stepper and two steps hold at one time, the state not among them.
fn bytes_per_site<E>(n: usize, h: f64) -> f64
where
    Long: Discretized<E, Vector = DVector<f64>>,
{
    let mut state = State::new(wave(n, 0.5, 0.1), wave(n, 0.5, 0.2));
    let long = Long { beta: 0.3 };
    let counted = allocation_counter::measure(|| {
        let mut stepper = long.stepper::<E>(h).unwrap();
        stepper.step(&mut state, &[]).unwrap();
        stepper.step(&mut state, &[]).unwrap();
    });
    counted.bytes_max as f64 / n as f64
}

#[test]
fn memory_is_a_few_vectors() {
    // Ten million sites in 4 GB are 400 bytes each, 16 of them the state.
    let n = 20_000;
    let explicit = bytes_per_site::<DeltaPlus>(n, 0.05);
    println!("DeltaPlus: {explicit:.0} bytes per site");
    assert!(explicit < 60.0, "{explicit}");
    // A stiff chain also holds a band, and what judges the rounding of each equation: that is all there is to it.
    for (h, most) in [(0.05, 220.0), (2.0, 384.0)] {
        let implicit = bytes_per_site::<Midpoint>(n, h);
        println!("Midpoint, h = {h}: {implicit:.0} bytes per site");
        assert!(implicit < most, "h = {h}: {implicit}");
    }
    let long = Long { beta: 0.3 };
    let mut stepper = long.stepper::<Midpoint>(2.0).unwrap();
    stepper.step(&mut State::new(wave(50, 0.5, 0.1), wave(50, 0.5, 0.2)), &[]).unwrap();
    assert_eq!(stepper.method(), Some(Method::Band { half_width: 1 }));
}

/// All forces are linear.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| p.iter().map(|p| 0.5 * p * p).sum::<f64>()
        + q.windows(2).map(|w| 0.5 * (w[1] - w[0]) * (w[1] - w[0])).sum::<f64>(),
    embedding = Midpoint,
)]
struct Springs;

/// Matrices that are factored in steps of these sizes, too long for the fixed point.
fn factorisations<H: Discretized<Midpoint, Vector = DVector<f64>>>(system: &H, sizes: &[f64]) -> Vec<u64> {
    let (mut q, mut p) = (wave(50, 0.05, 0.1), wave(50, 0.05, 0.2));
    let (mut memory, mut before) = (system.memory(), 0);
    let count = |&h: &f64| {
        let prepared = system.prepare(h).unwrap();
        system.advance(&prepared, 0.0, h, &mut q, &mut p, &[], &mut memory).unwrap();
        let all = memory.linear_work().factorisations;
        all - std::mem::replace(&mut before, all)
    };
    sizes.iter().map(count).collect()
}

/// With the factors of another size a step would end at the same solution, after more iterations.
#[test]
fn factors_serve_steps_of_their_size() {
    let sizes = [1.5, 1.5, 1.6];
    for made in [factorisations(&Long { beta: 0.3 }, &sizes), factorisations(&Springs, &sizes)] {
        assert!(made[0] > 0 && made[1] == 0 && made[2] > 0, "{made:?}");
    }
}

#[test]
fn hard_steps_find_the_solution_of_unrolled_ones() {
    // Springs so stiff that Newton's method from zero needs shortened corrections; what it finds has to be the same.
    let mass = [1.0, 2.0, 0.5, 1.5, 1.0, 3.0];
    for (beta, h) in [(50.0, 0.5), (200.0, 0.3), (1000.0, 0.2)] {
        let (loops, unrolled) = (Chain { beta, mass }, ChainUnrolled { beta, mass });
        // Three steps of a stiff chain magnify rounding by h² times the largest curvature each.
        let bound = 1e-13 * (h * h * beta * 3.0_f64).powi(3);
        let worst = difference::<Midpoint, _, _>(&loops, &unrolled, h, &[], 3);
        assert!(worst < bound, "beta = {beta}: {worst:e}");
    }
}

#[test]
fn runs_of_any_size_go_on_from_a_checkpoint() {
    let folder = fixtures::folder!("elements");
    for (h, n) in [(0.05, 30), (1.5, 30)] {
        let long = Long { beta: 0.3 };
        let run = |steps: u64| {
            long.simulate::<Midpoint>(h).start(State::new(wave(n, 0.5, 0.1), wave(n, 0.5, 0.2))).steps(steps)
        };
        let whole = run(24).run().unwrap();
        for stop in [0, 1, 2, 3, 7, 23] {
            let to = || Checkpoint::to(folder.join(format!("{h}-{stop}"))).every_steps(5);
            run(stop).checkpoint(to()).run().unwrap();
            let resumed = run(24).checkpoint(to()).run().unwrap();
            let bits = |path: &DVector<f64>| path.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&resumed.last().q), bits(&whole.last().q), "h = {h}, stopped after {stop}");
            assert_eq!(bits(&resumed.last().p), bits(&whole.last().p));
        }
    }
}
