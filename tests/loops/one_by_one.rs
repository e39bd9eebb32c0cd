//! Steps in vector instructions beside the same steps number by number.

pub(crate) use fixtures::rounding::numbers;
use fixtures::steps::steps_after;
use wzvi::lanes::Lanes;
use wzvi::nalgebra::DVector;
use wzvi::prelude::*;

pub(crate) const H: f64 = 0.01;

/// Steps of `h` from slices, from vectors that are exchanged, the same on several threads, and number by number in one pass: equal bits.
pub(crate) fn check_scheme<E, H: Discretized<E, Vector = DVector<f64>>>(
    system: &H,
    start: &[Vec<f64>; 2],
    h: f64,
    what: &str,
) {
    let alone = |list: &[f64]| -> Vec<Lanes<1>> { list.iter().map(|&x| Lanes::new([x])).collect() };
    let [mut q, mut p] = start.clone();
    let (n, mut own_q, mut own_p) = (q.len(), alone(&q), alone(&p));
    // Systems of one tile are never divided.
    let threads = if n > 256 { &[1, 2, 5][..] } else { &[1] };
    let stepper = |&threads: &usize| system.stepper::<E>(h).unwrap().threads(threads).unwrap();
    let mut runs: Vec<_> =
        threads.iter().map(|threads| (stepper(threads), State::new(q.clone(), p.clone()))).collect();
    let prepared = system.prepare(h).unwrap();
    let (mut memory, mut own_memory) = (system.memory(), Default::default());
    for step in 0..5 {
        let t = h * f64::from(step);
        if step == 3 {
            // Elsewhere: what the last step left is of no use.
            (q[n / 2], own_q[n / 2]) = (q[n / 2] + 0.5, own_q[n / 2] + 0.5);
            runs.iter_mut().for_each(|(_, state)| state.q[n / 2] += 0.5);
        }
        let dw: Vec<f64> =
            numbers(system.increments(n), 0.7 * f64::from(step)).iter().map(|x| 0.1 * x).collect();
        let own_dw = alone(&dw);
        let own = system.advance(&prepared, t, h, &mut own_q, &mut own_p, &own_dw, &mut own_memory).unwrap();
        let same = |q: &[f64], p: &[f64], iterations: u32, by: &str| {
            assert_eq!(iterations, own.iterations, "{what}: {n} numbers by {by}, step {step}");
            for (i, (a, b)) in q.iter().chain(p).zip(own_q.iter().chain(&own_p)).enumerate() {
                assert_eq!(
                    a.to_bits(),
                    b[0].to_bits(),
                    "{what}: number {i} of {n} by {by} after step {step}"
                );
            }
        };
        let work = system.advance(&prepared, t, h, &mut q, &mut p, &dw, &mut memory).unwrap();
        same(&q, &p, work.iterations, "slices");
        for ((stepper, state), threads) in runs.iter_mut().zip(threads) {
            let info = stepper.step(state, &dw).unwrap();
            same(state.q.as_slice(), state.p.as_slice(), info.iterations, &format!("{threads} threads"));
        }
        let exchanged: Vec<_> = runs.iter().map(|(stepper, _)| stepper.exchanged()).collect();
        assert!(exchanged.iter().all(|of| *of == exchanged[0]), "{what}: {exchanged:?}");
    }
}

/// The allocations of so many steps of `h` after a first one, which makes room.
pub(crate) fn later_allocations<E, H: Discretized<E>>(
    system: &H,
    state: &mut State<H::Vector>,
    h: f64,
    steps: u32,
) -> u64 {
    let mut later = steps_after::<E, H>(1, system, state, h);
    allocation_counter::measure(|| later(steps)).count_total
}

/// By a scheme of one part, and by one whose parts share their forces.
pub(crate) fn check<H>(system: &H, degrees: usize, what: &str)
where
    H: Hamiltonian<Vector = DVector<f64>> + Discretized<DeltaPlus> + Discretized<Verlet>,
{
    let start = [numbers(degrees, 0.2), numbers(degrees, 1.1)];
    check_scheme::<DeltaPlus, H>(system, &start, H, &format!("{what}, DeltaPlus"));
    check_scheme::<Verlet, H>(system, &start, H, &format!("{what}, Verlet"));
}

/// By the other explicit schemes.
pub(crate) fn check_others<H>(system: &H, degrees: usize, what: &str)
where
    H: Hamiltonian<Vector = DVector<f64>> + Discretized<DeltaMinus> + Discretized<Composed<Verlet, Yoshida4>>,
{
    let start = [numbers(degrees, 0.2), numbers(degrees, 1.1)];
    check_scheme::<DeltaMinus, H>(system, &start, H, &format!("{what}, DeltaMinus"));
    check_scheme::<Composed<Verlet, Yoshida4>, H>(system, &start, H, &format!("{what}, Yoshida4"));
}
