//! The counter-term of noises of one site, of neighbours and of all sites.

use wzvi::prelude::*;

use super::{ROUNDING, difference};

macro_rules! kubo {
    ($name:ident, $points:ty, $noise:tt) => {
        #[hamiltonian(
            drift = |q: $points, p: $points| {
                let n = q.len();
                (0..n).map(|i| 0.5 * p[i] * p[i] + 0.25 * q[i].powi(4)).sum::<f64>()
                    + (1..n).map(|i| 0.5 * (q[i] - q[i - 1]).powi(2)).sum::<f64>()
            },
            noise = $noise,
            embedding = [
                Corrected<DeltaPlus>, Corrected<DeltaMinus>, Corrected<Lambda<1, 4>>, Corrected<Mixed<Midpoint, DeltaPlus>>,
            ],
        )]
        struct $name {
            sigma: [f64; 6],
        }
    };
}

kubo!(Family, &[f64], [|q, p, k| sigma[k] * (0.5 * q[k] * q[k] + 0.3 * q[k] * p[k] + p[k].cos()); 6]);
kubo!(
    FamilyUnrolled,
    [f64; 6],
    [|q, p, k| sigma[k] * (0.5 * q[k] * q[k] + 0.3 * q[k] * p[k] + p[k].cos()); 6]
);
// Two noises that do not commute, in sums of different form.
kubo!(
    Pair,
    &[f64],
    [
        |q, p| (0..q.len()).map(|i| sigma[i] * (q[i] * p[i] + q[i].sin())).sum::<f64>(),
        |q, p| q.iter().skip(1).zip(p.iter().skip(1)).map(|(q, p)| 0.2 * (q * q + p * p)).sum::<f64>(),
    ]
);
kubo!(
    PairUnrolled,
    [f64; 6],
    [
        |q: [f64; 6], p: [f64; 6]| (0..6).map(|i| sigma[i] * (q[i] * p[i] + q[i].sin())).sum::<f64>(),
        |q: [f64; 6], p: [f64; 6]| (1..6).map(|i| 0.2 * (q[i] * q[i] + p[i] * p[i])).sum::<f64>(),
    ]
);

// Noises that read neighbours, around the ring and in a sum: their counter-terms couple three sites.
kubo!(Neighbours, &[f64], [|q, p, k| sigma[k] * (q[k] * p[(k + 1) % 6] + 0.1 * q[k].powi(3)); 6]);
kubo!(NeighboursUnrolled, [f64; 6], [|q, p, k| sigma[k] * (q[k] * p[(k + 1) % 6] + 0.1 * q[k].powi(3)); 6]);
kubo!(
    Bonds,
    &[f64],
    [
        |q, p| (1..q.len()).map(|i| sigma[i] * q[i] * p[i - 1]).sum::<f64>() + q[0] * q[0] * p[0],
        |q, p| (0..q.len()).map(|i| 0.1 * (q[i] * q[i] + p[i] * p[i])).sum::<f64>(),
    ]
);
kubo!(
    BondsUnrolled,
    [f64; 6],
    [
        |q: [f64; 6], p: [f64; 6]| (1..6).map(|i| sigma[i] * q[i] * p[i - 1]).sum::<f64>()
            + q[0] * q[0] * p[0],
        |q: [f64; 6], p: [f64; 6]| (0..6).map(|i| 0.1 * (q[i] * q[i] + p[i] * p[i])).sum::<f64>(),
    ]
);

const SIGMA: [f64; 6] = [0.3, 0.5, 0.2, 0.4, 0.1, 0.6];

#[test]
fn corrected_steps_are_those_of_unrolled_sums() {
    let families = (Family { sigma: SIGMA }, FamilyUnrolled { sigma: SIGMA });
    let pairs = (Pair { sigma: SIGMA }, PairUnrolled { sigma: SIGMA });
    let neighbours = (Neighbours { sigma: SIGMA }, NeighboursUnrolled { sigma: SIGMA });
    let bonds = (Bonds { sigma: SIGMA }, BondsUnrolled { sigma: SIGMA });
    let (six, two) = ([0.1, -0.07, 0.02, 0.05, -0.11, 0.03], [0.08, -0.05]);
    macro_rules! agree {
        ($($scheme:ty),*) => {$(
            assert!(difference::<$scheme, _, _>(&families.0, &families.1, 0.05, &six, 20) < ROUNDING);
            assert!(difference::<$scheme, _, _>(&pairs.0, &pairs.1, 0.05, &two, 20) < ROUNDING);
            assert!(difference::<$scheme, _, _>(&neighbours.0, &neighbours.1, 0.05, &six, 20) < ROUNDING);
            assert!(difference::<$scheme, _, _>(&bonds.0, &bonds.1, 0.05, &two, 20) < ROUNDING);
        )*};
    }
    agree!(
        Corrected<DeltaPlus>,
        Corrected<DeltaMinus>,
        Corrected<Lambda<1, 4>>,
        Corrected<Mixed<Midpoint, DeltaPlus>>
    );
}

#[test]
fn the_counter_term_is_part_of_the_discrete_lagrangian() {
    let family = Family { sigma: SIGMA };
    let rows: Vec<[f64; 6]> =
        (0..10).map(|n| std::array::from_fn(|k| 0.1 * (n as f64 + 2.0 * k as f64).sin())).collect();
    let path = family
        .simulate::<Corrected<Lambda<1, 4>>>(0.05)
        .start(State::new(vec![0.3, -0.2, 0.5, 0.1, 0.7, -0.4], vec![0.1; 6]))
        .noise(Increments::from(rows))
        .steps(10)
        .run()
        .unwrap();
    // Differences of momenta of order one.
    assert!(path.euler_lagrange_residual(&family).unwrap() < 1e-14);
    let (before, after) = (&path.states()[3], &path.states()[4]);
    let dw: [f64; 6] = std::array::from_fn(|k| 0.1 * (3.0 + 2.0 * k as f64).sin());
    let discrete = |q1: &wzvi::nalgebra::DVector<f64>| {
        let p = Discretized::<Corrected<Lambda<1, 4>>>::step_momentum(&family, before, after, 0.05, &dw);
        let segment = wzvi::system::Segment { q0: before.q.clone(), q1: q1.clone(), p, t: before.t, h: 0.05 };
        (
            Discretized::<Corrected<Lambda<1, 4>>>::discrete_lagrangian(&family, &segment, &dw),
            Discretized::<Corrected<Lambda<1, 4>>>::discrete_lagrangian_gradient(&family, &segment, &dw),
        )
    };
    let (_, gradient) = discrete(&after.q);
    for i in 0..6 {
        let moved = |by: f64| {
            let mut q1 = after.q.clone();
            q1[i] += by;
            discrete(&q1).0
        };
        // Central differences of a smooth function of order one: 1e-4² and 1e-16 / 1e-4.
        let slope = (moved(1e-4) - moved(-1e-4)) / 2e-4;
        assert!((slope - gradient.q1[i]).abs() < 1e-8, "{i}: {slope} {}", gradient.q1[i]);
    }
}
