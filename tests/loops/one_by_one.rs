//! Steps in vector instructions beside the same steps number by number.

use wzvi::lanes::Lanes;
use wzvi::nalgebra::DVector;
use wzvi::prelude::*;

pub(crate) const H: f64 = 0.01;

/// Numbers of which no two are equal.
pub(crate) fn numbers(n: usize, seed: f64) -> Vec<f64> {
    (0..n).map(|i| (1.3 * i as f64 + seed).sin() + 0.01 * i as f64).collect()
}

/// Steps of `h` in vector instructions, and number by number.
pub(crate) fn check_scheme<E, H: Discretized<E, Vector = DVector<f64>>>(
    system: &H,
    start: &[Vec<f64>; 2],
    h: f64,
    what: &str,
) {
    let alone = |list: &[f64]| -> Vec<Lanes<1>> { list.iter().map(|&x| Lanes::new([x])).collect() };
    let [mut q, mut p] = start.clone();
    let (mut own_q, mut own_p) = (alone(&q), alone(&p));
    let prepared = system.prepare(h).unwrap();
    let (mut memory, mut own_memory) = (system.memory(), Default::default());
    for step in 0..3 {
        let t = h * f64::from(step);
        let dw: Vec<f64> =
            numbers(system.increments(q.len()), 0.7 * f64::from(step)).iter().map(|x| 0.1 * x).collect();
        let work = system.advance(&prepared, t, h, &mut q, &mut p, &dw, &mut memory).unwrap();
        let dw = alone(&dw);
        let own = system.advance(&prepared, t, h, &mut own_q, &mut own_p, &dw, &mut own_memory).unwrap();
        assert_eq!(work.iterations, own.iterations, "{what}: {} numbers, step {step}", q.len());
        for (i, (a, b)) in q.iter().chain(&p).zip(own_q.iter().chain(&own_p)).enumerate() {
            assert_eq!(a.to_bits(), b[0].to_bits(), "{what}: number {i} of {} after step {step}", q.len());
        }
    }
}

/// The allocations of so many steps of `h` after a first one, which makes room.
pub(crate) fn later_allocations<E, H: Discretized<E>>(
    system: &H,
    state: &mut State<H::Vector>,
    h: f64,
    steps: u32,
) -> u64 {
    let mut stepper = system.stepper::<E>(h).unwrap();
    stepper.step(state, &[]).unwrap();
    let counted = allocation_counter::measure(|| {
        (0..steps).for_each(|_| assert!(stepper.step(state, &[]).is_ok()));
    });
    counted.count_total
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
