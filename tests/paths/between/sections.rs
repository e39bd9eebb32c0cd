//! Crossings of sections on single paths.

use fixtures::small::{Kepler, Pendulum};
use std::f64::consts::{FRAC_PI_2, PI};

use wzvi::prelude::*;
use wzvi::section::{Crossing, Direction};

use super::systems::{Oscillator, Shaken, V1, start};

fn times(crossings: &[Crossing<V1>]) -> Vec<f64> {
    crossings.iter().map(|crossing| crossing.state.t).collect()
}

/// `q = cos t` is zero at odd multiples of π/2, in turn falling and rising.
#[test]
fn the_oscillator_crosses_at_known_times() {
    let run = || Oscillator.simulate::<Gauss<8>>(0.25).start(start()).until(40.0).record_every(0);
    let path = run().section(|state| state.q[0]).run().unwrap();
    assert_eq!(path.crossings().len(), 13);
    for (n, crossing) in path.crossings().iter().enumerate() {
        let exact = FRAC_PI_2 + n as f64 * PI;
        assert!((crossing.state.t - exact).abs() < 1e-12, "{n}: {:e}", crossing.state.t - exact);
        assert!(crossing.state.q[0].abs() < 1e-15);
        let (direction, p) = if n % 2 == 0 { (Direction::Falling, -1.0) } else { (Direction::Rising, 1.0) };
        assert_eq!((crossing.section, crossing.direction), (0, direction));
        assert!((crossing.state.p[0] - p).abs() < 1e-12);
    }
    let rising = run().section_towards(Direction::Rising, |state| state.q[0]).run().unwrap();
    let of_both: Vec<_> =
        path.crossings().iter().filter(|crossing| crossing.direction == Direction::Rising).collect();
    assert_eq!(rising.crossings().iter().collect::<Vec<_>>(), of_both);
    // A section changes nothing of the path.
    assert_eq!(path.states(), run().run().unwrap().states());
    // Starting on it is no crossing; several come in the order of time.
    let both = run().section(|state| state.p[0]).section(|state| state.q[0] - 0.5).run().unwrap();
    let sections: Vec<usize> = both.crossings().iter().take(7).map(|crossing| crossing.section).collect();
    assert_eq!(sections, [1, 0, 1, 0, 1, 0, 1]);
    assert!((both.crossings()[1].state.t - PI).abs() < 1e-12);
    assert!(times(both.crossings()).is_sorted());
    // Backwards: times fall, and sides are those that the run comes from.
    let back = Oscillator.simulate::<Gauss<8>>(-0.25).start(start()).until(-5.0);
    let back = back.section(|state| state.q[0]).run().unwrap();
    assert!((back.crossings()[0].state.t + FRAC_PI_2).abs() < 1e-12);
    assert_eq!(back.crossings()[0].direction, Direction::Falling);
}

/// The zeros of the pendulum, by the elliptic integral, with every kind of dense output.
#[test]
fn the_pendulum_crosses_at_known_times() {
    let quarter = Pendulum::quarter(2.0);
    macro_rules! check {
        ($($scheme:ty, $h:literal, $tolerance:literal);+ $(;)?) => {$(
            let path = Pendulum.simulate::<$scheme>($h).start(State::new([2.0], [0.0])).until(30.0);
            let path = path.record_every(0).section(|state| state.q[0]).run().unwrap();
            assert_eq!(path.crossings().len(), 7);
            for (n, crossing) in path.crossings().iter().enumerate() {
                let error = crossing.state.t - (2.0 * n as f64 + 1.0) * quarter;
                assert!(error.abs() < $tolerance, "{} {n}: {error:e}", stringify!($scheme));
            }
        )+};
    }
    check! {
        Gauss<8>, 0.25, 1e-12;
        Gauss<16>, 1.0, 1e-12;
        Composed<Verlet, KahanLi8>, 0.05, 1e-12;
        Composed<Verlet, BlanesMoan6>, 0.05, 1e-9;
        Verlet, 0.01, 1e-3;
    }
}

/// Both crossings of a step that only just reaches the section are found, and none of one that does not.
#[test]
fn a_step_may_cross_twice_or_touch() {
    // q = cos t is largest at 2π, inside a step of 0.7.
    let run = |level: f64| {
        let path = Oscillator.simulate::<Gauss<8>>(0.7).start(start()).until(10.0).record_every(0);
        path.section(move |state| state.q[0] - level).run().unwrap().crossings().to_vec()
    };
    for distance in [0.1, 1e-2, 1e-3_f64] {
        let level = distance.cos();
        let found = run(level);
        // The start is above the section, and leaves it.
        let expected = [distance, 2.0 * PI - distance, 2.0 * PI + distance];
        assert_eq!(found.len(), 3, "{distance}: {:?}", times(&found));
        for (t, expected) in times(&found).into_iter().zip(expected) {
            // The error of the polynomial of h = 0.7, 4e-11 or less, is divided by the slope.
            assert!((t - expected).abs() < 1e-10 / distance, "{distance}: {t} {expected}");
        }
    }
    assert!(run(1.0 + 1e-6).is_empty());
}

/// With noise the crossings are those of the interpolated path, which is the same path at its nodes.
#[test]
fn noisy_paths_cross_where_they_are_interpolated() {
    let run = || Shaken.simulate::<Gauss<2>>(0.05).start(start()).noise(Wiener::seed(2)).until(20.0);
    let path = run().section(|state| state.q[0]).run().unwrap();
    let states = path.states();
    let changes: Vec<_> =
        states.iter().zip(&states[1..]).filter(|(a, b)| (a.q[0] < 0.0) != (b.q[0] < 0.0)).collect();
    assert!(changes.len() > 3 && changes.len() <= path.crossings().len());
    for (before, after) in changes {
        assert!(path.crossings().iter().any(|crossing| (before.t..=after.t).contains(&crossing.state.t)));
    }
    assert!(path.crossings().iter().all(|crossing| crossing.state.q[0].abs() < 1e-15));
    assert_eq!(path.states(), run().run().unwrap().states());
}

/// Steps that are halved are looked into part by part.
#[test]
fn halved_steps_are_looked_into() {
    // The centre is one that steps of this size run into.
    let start = State::new([1.9, 0.0], [0.0, (0.1_f64 / 1.9).sqrt()]);
    let run = |h: f64| {
        let path = Kepler.simulate::<Midpoint>(h).start(start).retry(Retry::halving(12)).until(6.0);
        path.record_at([2.9, 2.95, 3.05, 3.1]).section(|state| state.q[0]).section(|state| state.q[1]).run()
    };
    let path = run(0.2).unwrap();
    assert!(path.iterations().halved > 0);
    let (_, plain) = (0, Kepler.simulate::<Midpoint>(0.2).start(start).retry(Retry::halving(12)).until(6.0));
    assert_eq!(path.last(), plain.run().unwrap().last());
    assert!(!path.crossings().is_empty() && path.len() == 6);
    let zero = |crossing: &Crossing<_>| {
        let State { q, .. }: State<wzvi::nalgebra::SVector<f64, 2>> = crossing.state;
        q[crossing.section].abs()
    };
    assert!(path.crossings().iter().all(|crossing| zero(crossing) < 1e-12));
    assert!(path.crossings().iter().map(|crossing| crossing.state.t).is_sorted());
}

/// Sections of systems of any size: kept crossings are all that is allocated.
#[test]
fn looking_inside_allocates_nothing() {
    #[hamiltonian(
        drift = |q: &[f64], p: &[f64]| {
            (0..q.len()).map(|i| 0.5 * (p[i] * p[i] + (1.0 + i as f64) * q[i] * q[i])).sum::<f64>()
        },
        embedding = [Verlet, Gauss<4>],
    )]
    struct Oscillators;
    fn allocations<E>(steps: u64) -> u64
    where
        Oscillators: Discretized<E, Vector = wzvi::nalgebra::DVector<f64>>,
    {
        let start = State::new(vec![1.0, 0.4, 0.2], vec![0.0, 0.1, 0.2]);
        let run = Oscillators.simulate::<E>(0.01).start(start).steps(steps).record_every(0);
        let run = run.section(|state| state.q[0] - 3.0).section(|state| state.p[1] + 4.0);
        allocation_counter::measure(|| assert!(run.run().unwrap().crossings().is_empty())).count_total
    }
    // The first run of a process asks how many cores there are.
    allocations::<Verlet>(1);
    assert_eq!(allocations::<Verlet>(200), allocations::<Verlet>(100));
    assert_eq!(allocations::<Gauss<4>>(200), allocations::<Gauss<4>>(100));
}
