//! The error of dense output against a fine reference.

use fixtures::small::{Driven, Pendulum};
use wzvi::dense::DenseOutput;
use wzvi::nalgebra::SVector;
use wzvi::prelude::*;

type V1 = SVector<f64, 1>;

/// Two degrees of freedom in loops, with masses: the Nyström form of systems of any size.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        (0..q.len()).map(|i| 0.5 * p[i] * p[i] / (1.0 + i as f64)).sum::<f64>()
            + (0..q.len() - 1).map(|i| 1.0 - (q[i + 1] - q[i]).cos()).sum::<f64>()
            + 0.5 * q[0] * q[0]
    },
    embedding = [Verlet, Gauss<4>, Gauss<16>],
)]
struct Chain;

fn distance<V: wzvi::state::Vector>(a: &State<V>, b: &State<V>) -> [f64; 2] {
    [(&a.q, &b.q), (&a.p, &b.p)].map(|(a, b)| fixtures::steps::distance(a.components(), b.components()))
}

/// The largest errors of q and p inside steps of size `h`, of `E` from nodes of the reference, which is `Gauss<16>` in sixteenths of the step.
fn inside<E, H>(system: &H, start: &State<H::Vector>, h: f64, steps: u32) -> ([f64; 2], u32)
where
    H: Discretized<E> + Discretized<Gauss<16>>,
{
    const PARTS: u32 = 16;
    let mut fine = system.stepper::<Gauss<16>>(h / f64::from(PARTS)).unwrap();
    let mut reference = start.clone();
    let (mut errors, mut order) = ([0.0_f64; 2], 0);
    for _ in 0..steps {
        let mut state = reference.clone();
        let mut dense = DenseOutput::of(&state);
        system.stepper::<E>(h).unwrap().step_densely(&mut state, &[], &mut dense).unwrap();
        assert_eq!((dense.at(0.0), dense.at(1.0)), (reference.clone(), state));
        order = dense.order();
        for part in 1..=PARTS {
            fine.step(&mut reference, &[]).unwrap();
            let theta = f64::from(part) / f64::from(PARTS);
            let found = distance(&dense.at(theta), &reference);
            errors = [errors[0].max(found[0]), errors[1].max(found[1])];
        }
    }
    (errors, order)
}

/// The measured order of single steps and their insides along a path, and the one that the output says it has.
fn order<E, H>(system: &H, start: &State<H::Vector>, h: f64) -> (f64, u32)
where
    H: Discretized<E> + Discretized<Gauss<16>>,
{
    let [coarse, fine] = [(h, 8), (h / 2.0, 16)].map(|(h, steps)| inside::<E, H>(system, start, h, steps));
    let size = |errors: [f64; 2]| errors[0].max(errors[1]);
    ((size(coarse.0) / size(fine.0)).log2(), coarse.1)
}

/// The collocation polynomial has the uniform order `S + 1`: an error of order `h^{S+1}` inside a step.
#[test]
fn the_collocation_polynomial_has_order_s_plus_one() {
    macro_rules! check {
        ($($stages:literal, $h:literal);+) => {$(
            let start = State::new([0.6], [0.4]);
            for (name, (measured, said)) in [
                ("pendulum", order::<Gauss<$stages>, _>(&Pendulum, &State::new([2.0], [0.3]), $h)),
                ("driven", order::<Gauss<$stages>, _>(&Driven, &start.at(0.3), $h)),
            ] {
                assert_eq!(said, $stages + 1);
                assert!((measured - f64::from(said)).abs() < 0.35, "{name} Gauss<{}>: {measured}", $stages);
            }
        )+};
    }
    check!(2, 0.1; 4, 0.2; 8, 0.3);
    let start = State::new(vec![0.4, -0.2, 0.9], vec![0.1, 0.5, -0.3]);
    let (measured, said) = order::<Gauss<4>, _>(&Chain, &start, 0.2);
    assert!(said == 5 && (measured - 5.0).abs() < 0.35, "chain: {measured}");
}

/// Of a composition of order r the error inside a step is that of one step, `h^{r+1}`; of a scheme of order two or one likewise, since the cubic is
/// beyond it.
#[test]
fn other_schemes_lose_nothing_between_the_nodes() {
    macro_rules! check {
        ($($scheme:ty, $order:literal, $h:literal, $said:literal);+ $(;)?) => {$(
            for (name, (measured, said)) in [
                ("pendulum", order::<$scheme, _>(&Pendulum, &State::new([2.0], [0.3]), $h)),
                ("driven", order::<$scheme, _>(&Driven, &State::new([0.6], [0.4]).at(0.3), $h)),
            ] {
                assert_eq!(said, $said);
                let expected = f64::from($order + 1);
                println!("{name} {}: {measured}", stringify!($scheme));
                assert!(measured > expected - 0.4, "{name} {}: {measured}", stringify!($scheme));
            }
        )+};
    }
    check! {
        Midpoint, 2, 0.05, 4;
        Verlet, 2, 0.05, 4;
        Composed<Verlet, Suzuki4>, 4, 0.1, 5;
        Composed<Verlet, BlanesMoan4>, 4, 0.1, 5;
        Composed<Midpoint, Yoshida4>, 4, 0.1, 5;
        Composed<Verlet, KahanLi6>, 6, 0.2, 7;
        Composed<Verlet, BlanesMoan6>, 6, 0.2, 7;
        Composed<Verlet, KahanLi8>, 8, 0.3, 9;
        Composed<Verlet, SuzukiUmeno8>, 8, 0.2, 9;
    }
    let (measured, said) = order::<DeltaPlus, _>(&Pendulum, &State::new([2.0], [0.3]), 0.05);
    assert!(said == 4 && (measured - 2.0).abs() < 0.2, "{measured}");
    let start = State::new(vec![0.4, -0.2, 0.9], vec![0.1, 0.5, -0.3]);
    let (measured, _) = order::<Composed<Verlet, KahanLi6>, _>(&Chain, &start, 0.2);
    assert!((measured - 7.0).abs() < 0.4, "chain: {measured}");
}

/// The pendulum from (2, 0), the largest errors of q and p inside the steps of a run that is exact at the nodes.
#[test]
fn the_pendulum_between_its_nodes() {
    macro_rules! check {
        ($($stages:literal, $h:expr, $q:literal, $p:literal);+ $(;)?) => {$(
            let steps = (20.0_f64 / $h).round() as u32;
            let ([q, p], _) = inside::<Gauss<$stages>, _>(&Pendulum, &State::new([2.0], [0.0]), $h, steps);
            println!("Gauss<{}>, h = {:.3}: q {q:.1e}, p {p:.1e}", $stages, $h);
            // Published to one digit.
            assert!(q < 1.6 * $q && p < 1.6 * $p, "Gauss<{}>, h = {}: {q:e}, {p:e}", $stages, $h);
        )+};
    }
    check! {
        8, 1.0, 9e-9, 2e-7;
        8, 5.0 / 9.0, 3e-11, 8e-10;
        16, 2.5, 2e-9, 2e-8;
        16, 5.0 / 3.0, 5e-12, 7e-11;
        16, 1.25, 3e-14, 8e-13;
    }
}

/// One stage is the mid-point, between the nodes, too.
#[test]
fn one_stage_is_the_mid_point_between_the_nodes() {
    fn middle<E>() -> (u32, State<V1>)
    where
        Pendulum: Discretized<E, Vector = V1>,
    {
        let mut state = State::new([2.0], [0.1]);
        let mut dense = DenseOutput::of(&state);
        Pendulum.stepper::<E>(0.1).unwrap().step_densely(&mut state, &[], &mut dense).unwrap();
        (dense.order(), dense.at(0.3))
    }
    assert_eq!(middle::<Gauss<1>>(), middle::<Midpoint>());
}

/// After the first step, which finds out how large the system is.
#[test]
fn dense_steps_allocate_nothing() {
    fn allocations<E, H: Discretized<E>>(system: &H, start: &State<H::Vector>) -> u64 {
        let (mut state, mut dense) = (start.clone(), DenseOutput::of(start));
        let mut inside = start.clone();
        let mut stepper = system.stepper::<E>(0.1).unwrap();
        stepper.step_densely(&mut state, &[], &mut dense).unwrap();
        let counted = allocation_counter::measure(|| {
            for _ in 0..10 {
                stepper.step_densely(&mut state, &[], &mut dense).unwrap();
                dense.write(0.3, &mut inside);
            }
        });
        counted.count_total
    }
    let start = State::new(vec![0.4, -0.2, 0.9], vec![0.1, 0.5, -0.3]);
    assert_eq!(allocations::<Gauss<4>, _>(&Chain, &start), 0);
    assert_eq!(allocations::<Verlet, _>(&Chain, &start), 0);
    assert_eq!(allocations::<Composed<Verlet, KahanLi8>, _>(&Chain, &start), 0);
    let start = State::new([0.4], [0.1]);
    assert_eq!(allocations::<Gauss<8>, _>(&Driven, &start), 0);
    assert_eq!(allocations::<Gauss<8>, _>(&Pendulum, &start), 0);
    assert_eq!(allocations::<Composed<Midpoint, KahanLi6>, _>(&Driven, &start), 0);
}
