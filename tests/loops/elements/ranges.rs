//! Indices and bounds that only the running program knows: found out of range before a step, by name, and without a loop.

use wzvi::error::{ConfigError, IndexError, IndexLimit, StepFailure};
use wzvi::nalgebra::DVector;
use wzvi::prelude::*;

fn at_rest(n: usize) -> State<DVector<f64>> {
    State::new(vec![0.1; n], vec![0.2; n])
}

/// The failure of one step, which leaves the state; energies are undefined then.
fn failure<S>(system: &S, n: usize) -> StepFailure
where
    S: Discretized<Midpoint, Vector = DVector<f64>>,
{
    let state = at_rest(n);
    let error =
        fixtures::steps::refused(&state, |state| system.stepper::<Midpoint>(0.1).unwrap().step(state, &[]));
    assert!(system.energy(&state).is_nan());
    error.cause
}

fn named<S>(system: &S, n: usize) -> IndexError
where
    S: Discretized<Midpoint, Vector = DVector<f64>>,
{
    match failure(system, n) {
        StepFailure::Index(error) => error,
        other => unreachable!("{other:?}"),
    }
}

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + (0..self.count).map(|k| 0.1 * q[0] * q[0] * k as f64).sum::<f64>()
            + 0.5 * q[self.offset].powi(2)
            + 0.5 * q[1 - self.back].powi(2)
            + (0..q.len()).map(|i| 0.5 * (q[(i * self.stride) % q.len()] - q[i]).powi(2)).sum::<f64>()
    },
    embedding = [Midpoint],
)]
struct Given {
    count: u64,
    offset: usize,
    stride: usize,
    back: usize,
}

#[test]
fn integers_beyond_all_indices_are_named() {
    let good = Given { count: 3, offset: 1, stride: 2, back: 1 };
    assert!(good.energy(&at_rest(4)).is_finite());
    good.stepper::<Midpoint>(0.1).unwrap().step(&mut at_rest(4), &[]).unwrap();

    for count in [1 << 63, u64::MAX] {
        let error = named(&Given { count, ..good }, 4);
        assert_eq!((error.name().as_str(), error.value()), ("count", i128::from(count)));
        assert_eq!(error.limit(), IndexLimit::Integers);
    }
    let error = named(&Given { offset: usize::MAX, ..good }, 4);
    assert_eq!((error.name().as_str(), error.value()), ("offset", usize::MAX as i128));
    // Products that overflow on the way to an index that would be in range.
    let error = named(&Given { stride: usize::MAX / 4, ..good }, 4);
    assert_eq!(error.limit(), IndexLimit::Integers);
    assert!(error.name().contains("stride"), "{error}");
    // Before the start.
    let error = named(&Given { back: 3, ..good }, 4);
    assert_eq!((error.value(), error.limit()), (-2, IndexLimit::Points(4)), "{error}");
    assert!(error.to_string().ends_with("write `(i + n - 1) % n` where an index wraps around"), "{error}");
    assert_eq!(failure(&Given { offset: 10, ..good }, 4), StepFailure::Dimension { expected: 11, got: 4 });
}

#[hamiltonian(
    drift = |q: &[[f64; 2]], p: &[[f64; 2]]| {
        p.iter().map(|p| 0.5 * (p[0] * p[0] + p[1] * p[1])).sum::<f64>()
            + (0..self.bonds.len()).map(|b| {
                let (i, j, k) = self.bonds[b];
                0.5 * k * (q[i][0] - q[j][1]).powi(2)
            }).sum::<f64>()
            + self.near.iter().enumerate().map(|(i, list)| {
                list.iter().map(|&j| 0.5 * weights[j] * (q[i][1] - q[j][0]).powi(2)).sum::<f64>()
            }).sum::<f64>()
    },
    embedding = [Midpoint],
)]
struct Tables {
    bonds: Vec<(usize, usize, f64)>,
    near: Vec<Vec<usize>>,
    weights: Vec<f64>,
}

fn tables() -> Tables {
    Tables {
        bonds: (0..20).map(|b| (b % 3, (b + 1) % 3, 1.0)).collect(),
        near: vec![vec![1, 2], vec![], vec![0]],
        weights: vec![1.0, 2.0, 3.0],
    }
}

#[test]
fn entries_are_named_with_their_place() {
    tables().stepper::<Midpoint>(0.1).unwrap().step(&mut points(), &[]).unwrap();
    let step = |system: &Tables| system.stepper::<Midpoint>(0.1).unwrap().step(&mut points(), &[]);
    let text = |system: &Tables| step(system).unwrap_err().cause.to_string();
    let mut beyond = tables();
    beyond.bonds[17].1 = 8;
    assert!(text(&beyond).starts_with("`bonds[17].1` is 8, but the state has 3;"), "{}", text(&beyond));
    let mut beyond = tables();
    beyond.near[2].push(5);
    // The list of weights is read first.
    let found = text(&beyond);
    assert!(
        found.starts_with("`weights` is read at 5, but it has 3 entries;")
            || found.starts_with("`near[2][1]` is 5,")
    );
    let mut short = tables();
    short.weights.pop();
    assert!(text(&short).starts_with("`weights` is read at 2, but it has 2 entries;"), "{}", text(&short));
    // A run says it before its first step.
    let error = beyond.simulate::<Midpoint>(0.1).start(points()).steps(3).run().unwrap_err();
    assert!(matches!(error, wzvi::Error::Config(ConfigError::Start(StepFailure::Index(_)))), "{error:?}");
}

fn points() -> State<DVector<f64>> {
    at_rest(6)
}

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        p[0] * p[0] + (0..self.nx).map(|i| (0..self.ny).map(|j| q[i * self.ny + j].powi(2)).sum::<f64>()).sum::<f64>()
            + (0..self.nx).map(|i| (0..i).map(|j| (q[i] - q[i - 1 - j]).powi(4)).sum::<f64>()).sum::<f64>()
    },
    embedding = [Midpoint],
)]
struct Field {
    nx: usize,
    ny: usize,
}

#[test]
fn ranges_are_found_without_running_loops() {
    let required = |nx: usize, ny: usize, n: usize| failure(&Field { nx, ny }, n);
    assert_eq!(required(100_000, 30_000, 10), StepFailure::Dimension { expected: 3_000_000_000, got: 10 });
    assert_eq!(required(3, 4, 11), StepFailure::Dimension { expected: 12, got: 11 });
    // These loops would take longer than the universe is old.
    assert!(matches!(required(1 << 33, 1 << 33, 10), StepFailure::Index(_)));
    assert!(Field { nx: 3, ny: 4 }.energy(&at_rest(12)).is_finite());
}

/// A system with `energy` beside `p[0]² / 2`, and a field.
macro_rules! unsigned {
    ($name:ident { $field:ident: $type:ty }, $space:ty, |$q:ident| $energy:expr) => {
        #[hamiltonian(drift = |$q: $space, p: $space| 0.5 * p[0] * p[0] + $energy, embedding = [Midpoint])]
        struct $name {
            $field: $type,
        }
    };
}

unsigned!(Shorter { m: usize }, &[f64], |q| (0..q.len() - m).map(|i| q[i] * q[i]).sum::<f64>());
unsigned!(Inner { m: u32 }, &[f64], |q| (0..q.len())
    .map(|i| (0..i as u32 - m).map(|j| q[j as usize] * q[i]).sum::<f64>())
    .sum::<f64>());
unsigned!(Rest { m: usize }, &[f64], |q| q.iter().take(3 - m).map(|q| q * q).sum::<f64>());
unsigned!(Number { m: usize }, &[f64], |q| (q.len() - m) as f64 * q[0]);
unsigned!(Halves { m: usize }, &[f64], |q| ((q.len() - m) / 2) as f64 * q[0]);
unsigned!(Narrow { m: usize }, &[f64], |q| (m as u8) as f64 * q[0]);
unsigned!(Least { m: i64 }, &[f64], |q| f64::from(m as i8) * q[0]);
unsigned!(Positive { m: i64 }, &[f64], |q| (m as usize) as f64 * q[0]);
unsigned!(Line { m: usize }, [f64; 3], |q| (q.len() - m) as f64 * q[0]);
unsigned!(Signed { m: i64 }, &[f64], |q| (0..q.len() as i64 - m).map(|i| q[i as usize]).sum::<f64>()
    + (3 - m) as f64 * q[0]);
unsigned!(Guarded { m: usize }, &[f64], |q| if m <= q.len() {
    (0..q.len() - m).map(|i| q[i]).sum::<f64>()
} else {
    q[0]
} + (0..q.len())
    .map(|i| if i >= m { (i - m) as f64 * q[i] } else { 0.0 })
    .sum::<f64>());

#[test]
fn integers_that_leave_their_type_are_refused() {
    macro_rules! left {
        ($system:expr, $name:literal, $value:literal) => {
            let error = named(&$system, 3);
            assert_eq!((error.name().as_str(), error.value()), ($name, $value), "{error}");
            assert_eq!(error.limit(), IndexLimit::Natural);
        };
    }
    // Where Rust panics.
    left!(Shorter { m: 5 }, "n - m", -2);
    left!(Inner { m: 1 }, "i - m", -1);
    left!(Rest { m: 4 }, "-m + 3", -1);
    left!(Number { m: 4 }, "n - m", -1);
    left!(Halves { m: 5 }, "n - m", -2);
    // Where it cuts off digits or the sign.
    left!(Narrow { m: 256 }, "-m + 255", -1);
    left!(Least { m: -130 }, "m + 128", -2);
    left!(Positive { m: -7 }, "m", -7);
    let error = Line { m: 5 }.stepper::<Midpoint>(0.1).map(drop).unwrap_err();
    assert!(matches!(error, ConfigError::Index(error) if error.limit() == IndexLimit::Natural), "{error}");
    assert!(Line { m: 5 }.energy(&State::new([0.1; 3], [0.2; 3])).is_nan());
}

#[test]
fn integers_in_their_type_are_as_in_rust() {
    macro_rules! energies {
        ($($system:expr => $energy:expr;)*) => {$(
            let state = at_rest(3);
            assert!(($system.energy(&state) - 0.02 - $energy).abs() < 1e-15, "{}", stringify!($system));
            $system.stepper::<Midpoint>(0.1).unwrap().step(&mut at_rest(3), &[]).unwrap();
        )*};
    }
    energies! {
        Shorter { m: 3 } => 0.0;
        Shorter { m: 1 } => 0.02;
        Inner { m: 0 } => 0.03;
        Rest { m: 1 } => 0.02;
        Number { m: 3 } => 0.0;
        Halves { m: 0 } => 0.1;
        Narrow { m: 255 } => 25.5;
        Least { m: -128 } => -12.8;
        Positive { m: 7 } => 0.7;
        Signed { m: 5 } => -0.2;
        Signed { m: 1 } => 0.4;
        Guarded { m: 5 } => 0.1;
        Guarded { m: 1 } => 0.2 + 0.1;
    }
}
