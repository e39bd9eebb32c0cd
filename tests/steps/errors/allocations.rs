//! Steps allocate nothing.

use allocation_counter::measure;
use fixtures::extremes::{HenonHeiles, Metric, PENDULUM, Ring, state};
use fixtures::small::KUBO;
use fixtures::steps::steps_after;
use wzvi::prelude::*;
use wzvi::state::Vector;

/// Allocations of 100 steps with the given increments, and of a step that fails.
fn allocations<E, H: Discretized<E>>(system: &H, q: &[f64], p: &[f64]) -> [u64; 2] {
    let mut stepper = system.stepper::<E>(0.01).unwrap();
    let mut state = state::<H::Vector>(q, p);
    let dw = vec![0.02; system.noises()];
    let steps = measure(|| (0..100).for_each(|_| assert!(stepper.step(&mut state, &dw).is_ok())));
    state.q.components_mut()[0] = f64::NAN;
    let failure = measure(|| assert!(stepper.step(&mut state, &dw).is_err()));
    [steps.count_total, failure.count_total]
}

#[test]
fn generated_steps_allocate_nothing() {
    assert_ne!(measure(|| drop(std::hint::black_box(vec![0; 10]))).count_total, 0, "the counter counts");
    assert_eq!(allocations::<Midpoint, _>(&PENDULUM, &[0.3], &[0.5]), [0; 2]);
    assert_eq!(allocations::<DeltaPlus, _>(&PENDULUM, &[0.3], &[0.5]), [0; 2]);
    assert_eq!(allocations::<Midpoint, _>(&KUBO, &[0.3], &[0.5]), [0; 2]);
    assert_eq!(allocations::<Corrected<DeltaPlus>, _>(&KUBO, &[0.3], &[0.5]), [0; 2]);
    assert_eq!(allocations::<Midpoint, _>(&HenonHeiles, &[0.3, 0.1], &[0.1, 0.1]), [0; 2]);
    assert_eq!(allocations::<DeltaPlus, _>(&HenonHeiles, &[0.3, 0.1], &[0.1, 0.1]), [0; 2]);
    assert_eq!(allocations::<Midpoint, _>(&Metric, &[1.3], &[0.5]), [0; 2]);
    assert_eq!(
        allocations::<Uncorrected<Mixed<DeltaMinus, Lambda<1, 4>>>, _>(&Metric, &[1.3], &[0.5]),
        [0; 2]
    );
    assert_eq!(allocations::<Midpoint, _>(&Ring { k: 2.0 }, &[0.3, 0.1, 0.0], &[0.5, 0.0, 0.0]), [0; 2]);
}

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (1.0 + x * x) * px * px + 0.5 * py * py + 0.25 * (x * x + y * y).powi(2),
    noise = [|[x, y], _| 0.2 * x * y],
    embedding = [Midpoint, Verlet, Gauss<3>],
)]
struct Coupled;

#[hamiltonian(drift = |q, p| 0.5 * p * p + 0.5 * 1e4 * q * q + q.powi(4), embedding = [Gauss<4>, Verlet])]
struct StiffWell;

#[hamiltonian(
    drift = [
        |q: [f64; 4], p: [f64; 4]| (0..4).map(|i| 0.5 * p[i] * p[i] + 0.5 * q[i] * q[i]).sum::<f64>(),
        |q, _| 0.1 * (q[0] * q[1] + q[2] * q[3]).cos(),
    ],
    embedding = Verlet,
)]
struct Parted;

#[hamiltonian(
    drift = |q: [f64; N], p: [f64; N]| p.iter().map(|p| 0.5 * p * p).sum::<f64>()
        + (0..N - 1).map(|i| 0.5 * (q[i + 1] - q[i]).powi(2) + 0.25 * (q[i + 1] - q[i]).powi(4)).sum::<f64>(),
    embedding = [Midpoint, Verlet, Gauss<4>],
)]
struct Chain<const N: usize>;

#[hamiltonian(
    drift = |q: [f64; N], p: [f64; N]| p.iter().map(|p| (1.0 + p * p).sqrt()).sum::<f64>()
        + (0..N - 1).map(|i| 0.5 * (q[i + 1] - q[i]).powi(2)).sum::<f64>(),
    embedding = Gauss<4>,
)]
struct Relativistic<const N: usize>;

/// Asserts that 100 steps allocate nothing after some from a new state: the first keeps a copy of what the steps before left, the second
/// makes room for a copy of what the first one left.
fn none_after<E, H: Discretized<E>>(before: u32, system: &H, [q, p]: [&[f64]; 2], h: f64) {
    let mut state = state::<H::Vector>(q, p);
    let mut steps = steps_after::<E, H>(before, system, &mut state, h);
    assert_eq!(measure(|| steps(100)).count_total, 0, "{}", std::any::type_name::<(E, H)>());
}

/// Also where a step has stages or parts, in loops, and where it is stiff.
#[test]
fn steps_of_high_order_allocate_nothing() {
    let start: [&[f64]; 2] = [&[0.3, 0.1], &[0.1, 0.2]];
    assert_eq!(allocations::<Gauss<3>, _>(&Coupled, start[0], start[1])[0], 0);
    none_after::<Verlet, _>(2, &Coupled, start, 0.01);
    none_after::<Composed<Midpoint, KahanLi6>, _>(2, &Coupled, start, 0.01);
    none_after::<Composed<Verlet, Chin4>, _>(2, &StiffWell, [&[1e-3], &[0.1]], 1e-3);
    none_after::<Composed<Gauss<3>, Yoshida4>, _>(2, &Coupled, start, 0.01);
    let (q, p) = (std::array::from_fn::<_, 40, _>(|i| 0.1 * (i as f64).sin()), [0.0; 40]);
    let start: [&[f64]; 2] = [&q, &p];
    none_after::<Gauss<4>, _>(2, &Chain::<40>, start, 0.01);
    // Far from the origin the forces have rounding that momenta do not settle below. The first of these steps makes room to look closely.
    none_after::<Gauss<4>, _>(100, &Relativistic::<40>, [&q.map(|q| q + 1e6), &p], 0.01);
    none_after::<Verlet, _>(2, &Chain::<40>, start, 0.01);
    none_after::<Composed<Verlet, TakahashiImada4>, _>(2, &Chain::<40>, start, 0.01);
    none_after::<Composed<Midpoint, Suzuki4>, _>(2, &Chain::<40>, start, 0.01);
    assert_eq!(allocations::<Composed<Verlet, Srkn6>, _>(&Chain::<40>, &q, &p), [0; 2]);
    assert_eq!(allocations::<Composed<Verlet, Aba864>, _>(&Parted, &q[..4], &p[..4]), [0; 2]);
    none_after::<Gauss<4>, _>(2, &StiffWell, [&[1e-3], &[0.1]], 0.5);
}

/// A run allocates its buffers once, for 10 steps as for 10 000, also where it records each step.
#[test]
fn runs_allocate_the_same_for_any_number_of_steps() {
    let run = |steps: usize, every: u64| {
        let noise = Increments::from(vec![0.02; steps]);
        let run = KUBO.simulate::<Midpoint>(0.02).start(State::new([0.0], [1.0])).noise(noise);
        let (run, mut seen) = (run.steps(steps as u64).record_every(every), 0);
        let counted = measure(|| assert!(run.inspect(|_, _| seen += 1).run().is_ok()));
        (counted.count_total, seen)
    };
    for every in [0, 1, 3] {
        let ((few, _), (many, seen)) = (run(10, every), run(10_000, every));
        assert_eq!(few, many, "record_every({every})");
        assert!(few < 20 && seen > 3000, "{few} {seen}");
    }
}
