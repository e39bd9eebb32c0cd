//! Orders against exact solutions, and against finer steps.

use wzvi::nalgebra::SVector;
use wzvi::prelude::*;

use crate::systems::*;

type V = SVector<f64, 1>;

pub(crate) const DRAG: f64 = 0.3;
pub(crate) const PUSH: f64 = 0.8;

/// `q'' + g q' + q = f cos 2t`: the steady part and the decaying one.
pub(crate) fn exact(t: f64, q0: f64, p0: f64) -> [f64; 2] {
    // Steady: q = a cos 2t + b sin 2t with (1 - 4) a + 2 g b = f, (1 - 4) b - 2 g a = 0.
    let d = 9.0 + 4.0 * DRAG * DRAG;
    let (a, b) = (-3.0 * PUSH / d, 2.0 * DRAG * PUSH / d);
    let steady = |t: f64| {
        let (s, c) = (2.0 * t).sin_cos();
        [a * c + b * s, 2.0 * (b * c - a * s)]
    };
    let [qs, ps] = steady(0.0);
    let (x, v) = (q0 - qs, p0 - ps);
    let (r, w) = (DRAG / 2.0, (1.0 - DRAG * DRAG / 4.0).sqrt());
    let (s, c) = (w * t).sin_cos();
    let e = (-r * t).exp();
    let beta = (v + r * x) / w;
    let q = e * (x * c + beta * s);
    let p = e * (-r * (x * c + beta * s) + w * (beta * c - x * s));
    let [qs, ps] = steady(t);
    [q + qs, p + ps]
}

fn error<E, H: Discretized<E, Vector = V>>(system: &H, h: f64) -> f64 {
    let (mut state, mut stepper) = (State::new([1.1], [-0.4]), system.stepper::<E>(h).unwrap());
    for _ in 0..(4.0 / h).round() as u32 {
        stepper.step(&mut state, &[]).unwrap();
    }
    let [q, p] = exact(4.0, 1.1, -0.4);
    (state.q[0] - q).abs().max((state.p[0] - p).abs())
}

fn order<E, H: Discretized<E, Vector = V>>(system: &H, h: f64, expected: f64) {
    let (coarse, fine) = (error::<E, H>(system, h), error::<E, H>(system, h / 2.0));
    let measured = (coarse / fine).log2();
    assert!((measured - expected).abs() < 0.15, "order {measured}, expected {expected}: {coarse:e} {fine:e}");
    assert!(fine < 0.05, "{fine}");
}

pub(crate) fn orders<H>(system: &H)
where
    H: Discretized<DeltaPlus, Vector = V>
        + Discretized<DeltaMinus, Vector = V>
        + Discretized<Midpoint, Vector = V>
        + Discretized<Verlet, Vector = V>
        + Discretized<Gauss<2>, Vector = V>
        + Discretized<Gauss<3>, Vector = V>
        + Discretized<Gauss<4>, Vector = V>
        + Discretized<Composed<Verlet, BlanesMoan4>, Vector = V>
        + Discretized<Composed<Midpoint, Yoshida4>, Vector = V>,
{
    order::<DeltaPlus, H>(system, 0.01, 1.0);
    order::<DeltaMinus, H>(system, 0.01, 1.0);
    order::<Midpoint, H>(system, 0.05, 2.0);
    order::<Verlet, H>(system, 0.05, 2.0);
    order::<Gauss<2>, H>(system, 0.1, 4.0);
    order::<Gauss<3>, H>(system, 0.2, 6.0);
    order::<Gauss<4>, H>(system, 0.4, 8.0);
    order::<Composed<Verlet, BlanesMoan4>, H>(system, 0.1, 4.0);
    order::<Composed<Midpoint, Yoshida4>, H>(system, 0.1, 4.0);
}

#[test]
fn driven_oscillators_have_the_order_of_the_scheme() {
    orders(&Oscillator { drag: DRAG, push: PUSH });
}

/// A force of positions that has no potential, and one that turns in time.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + 0.7 * py * py + 0.3 * px * py) + 0.25 * (x * x + y * y).powi(2),
    force = |[x, y], _p, t| [-0.6 * y + 0.2 * t.cos(), 0.6 * x + 0.1 * x * y],
    embedding = [Verlet, Gauss<6>],
)]
struct Curl;

/// The error at `t = 2`, beside much finer steps of high order.
fn error_of_curl<E>(h: f64) -> f64
where
    Curl: Discretized<E, Vector = SVector<f64, 2>>,
{
    let start = State::new([0.8, -0.3], [0.2, 0.5]);
    let path = Curl.simulate::<E>(h).start(start).until(2.0).run().unwrap();
    let fine = Curl.simulate::<Gauss<6>>(0.05).start(start).until(2.0).run().unwrap();
    (path.last().q - fine.last().q).norm() + (path.last().p - fine.last().p).norm()
}

#[test]
fn tables_of_kicks_take_forces_without_a_potential() {
    macro_rules! order {
        ($($table:ty, $h:expr, $order:expr);*) => {$(
            let [coarse, fine] = [$h, $h / 2.0].map(error_of_curl::<Composed<Verlet, $table>>);
            let measured = (coarse / fine).log2();
            assert!((measured - $order).abs() < 0.25, "{measured}: {coarse:e} {fine:e}");
        )*};
    }
    order!(Chin4, 0.1, 4.0; Srkn6, 0.2, 6.0; BlanesMoan6, 0.2, 6.0);
    const { assert!(matches!(<Curl as Discretized<Verlet>>::PLAN.solver, Solver::Explicit)) };
}
