//! Whole steps in units in the last place.

use wzvi::prelude::*;

use fixtures::extremes::Random;

use super::reference::{Case, Errors, Point, Terms, compare, percentile};
use super::systems::{DoubleWell, KUBO, Kepler, Masses, Oscillator, Pendulum};

/// Random steps of one system.
const TRIES: usize = 100;

/// Prints the errors and checks the largest of them.
///
/// Whoever is given inputs that are rounded knows the increment to half of its own unit and half of what one unit in
/// each input changes it by. The bound allows four times that for the roundings of the step itself.
fn check<E: Point, H: Discretized<E> + Terms>(
    name: &str,
    system: &H,
    mut case: impl FnMut(&mut Random) -> Case,
) {
    const BOUND: f64 = 2.0;
    let mut random = Random(11);
    let mut errors = Vec::new();
    for _ in 0..TRIES {
        let case = case(&mut random);
        let found = compare::<E, H>(system, &case).unwrap_or_else(|error| panic!("{name}: {error} {case:?}"));
        assert!(found.conditioned <= BOUND, "{name}: {found:?} at {case:?}");
        errors.push(found);
    }
    let of = |part: fn(&Errors) -> f64| {
        let values: Vec<f64> = errors.iter().map(part).collect();
        [50, 95, 100].map(|percent| percentile(&values, percent))
    };
    println!(
        "{name:34} state {:7.2?}  increment {:7.2?}  conditioned {:5.2?}",
        of(|e| e.state),
        of(|e| e.increment),
        of(|e| e.conditioned)
    );
}

fn one(random: &mut Random, h: [f64; 2], noise: Option<f64>) -> Case {
    let h = random.sized(h[0], h[1]);
    let (q, p) = (vec![random.sized(-3.0, 0.5)], vec![random.sized(-3.0, 0.5)]);
    Case { h, q, p, dw: noise.map(|size| size * random.uniform()).into_iter().collect() }
}

#[test]
fn oscillator() {
    let slow = Oscillator { omega: 1.3 };
    check::<Midpoint, _>("oscillator, mid-point", &slow, |r| one(r, [-4.0, 8.0], None));
    check::<DeltaPlus, _>("oscillator, Δ+", &slow, |r| one(r, [-4.0, -0.3], None));
}

#[test]
fn pendulum() {
    let pendulum = Pendulum { m: 0.7, k: 1.9 };
    check::<Midpoint, _>("pendulum, mid-point", &pendulum, |r| one(r, [-4.0, -0.5], None));
    check::<DeltaPlus, _>("pendulum, Δ+", &pendulum, |r| one(r, [-4.0, -0.5], None));
    check::<DeltaMinus, _>("pendulum, Δ-", &pendulum, |r| one(r, [-4.0, -0.5], None));
}

#[test]
fn kubo() {
    check::<Midpoint, _>("Kubo, mid-point", &KUBO, |r| one(r, [-4.0, 0.0], Some(0.3)));
    check::<Uncorrected<DeltaPlus>, _>("Kubo, Δ+", &KUBO, |r| one(r, [-4.0, -1.0], Some(0.3)));
}

#[test]
fn double_well() {
    let well = DoubleWell { sigma: 0.3 };
    check::<Midpoint, _>("double well, mid-point", &well, |r| one(r, [-4.0, -1.0], Some(0.3)));
    check::<Uncorrected<DeltaPlus>, _>("double well, Δ+", &well, |r| one(r, [-4.0, -1.0], Some(0.3)));
}

#[test]
fn kepler() {
    let case = |random: &mut Random| Case {
        h: random.sized(-4.0, -1.5),
        q: vec![1.0 + 0.5 * random.uniform(), random.sized(-3.0, 0.0)],
        p: vec![random.sized(-3.0, 0.0), 1.0 + 0.3 * random.uniform()],
        dw: Vec::new(),
    };
    check::<Midpoint, _>("Kepler, mid-point", &Kepler, case);
}

#[test]
fn masses_of_one_and_a_million_million() {
    let masses = Masses { light: 1.0, heavy: 1e12, stiff: 1e3, soft: 1.0 };
    let case = |random: &mut Random| Case {
        h: random.sized(-4.0, -2.0),
        q: vec![random.sized(-3.0, 0.5), random.sized(-3.0, 0.5)],
        p: vec![random.sized(-3.0, 0.5), 1e12 * random.sized(-3.0, 0.5)],
        dw: Vec::new(),
    };
    check::<Midpoint, _>("masses 1 and 1e12, mid-point", &masses, case);
}
