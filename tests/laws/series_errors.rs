//! Errors of averages along a path cover the mean in 95 %, or are not given; runs of averages are stopped, kept and compared as others are.

use wzvi::prelude::*;
use wzvi::series::{BatchMeans, Chains, TimeAverages};

/// Two wells in a bath.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + height * (q * q - 1.0).powi(2),
    friction = gamma,
    temperature = kt,
    embedding = Baoab,
)]
#[derive(Clone, Debug)]
pub struct Wells {
    pub height: f64,
    pub gamma: f64,
    pub kt: f64,
}

const LOW: Wells = Wells { height: 1.0, gamma: 1.0, kt: 0.25 };
/// Crossed about once in `e^{20}` units of time.
const HIGH: Wells = Wells { height: 5.0, gamma: 1.0, kt: 0.25 };

/// Normals by Box and Muller's formula, in pairs, from a congruential generator.
struct Normals {
    state: u64,
    spare: Option<f64>,
}

impl Normals {
    fn seed(state: u64) -> Self {
        Self { state, spare: None }
    }

    fn uniform(&mut self) -> f64 {
        self.state =
            self.state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.state >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }

    fn next(&mut self) -> f64 {
        self.spare.take().unwrap_or_else(|| {
            let radius = (-2.0 * self.uniform().ln()).sqrt();
            let (sin, cos) = (std::f64::consts::TAU * self.uniform()).sin_cos();
            self.spare = Some(radius * sin);
            radius * cos
        })
    }
}

/// `x_n = a x_{n-1} + b x_{n-2} + ξ_n`, started in its stationary law; its mean is 0.
fn autoregressive([a, b]: [f64; 2], length: u32, normals: &mut Normals) -> BatchMeans {
    let variance = (1.0 - b) / ((1.0 + b) * ((1.0 - b).powi(2) - a * a));
    let correlation = a / (1.0 - b);
    let mut before = variance.sqrt() * normals.next();
    let mut x = correlation * before + (variance * (1.0 - correlation * correlation)).sqrt() * normals.next();
    let mut batches = BatchMeans::new();
    for _ in 0..length {
        (before, x) = (x, a * x + b * before + normals.next());
        batches.add(x);
    }
    batches
}

/// Of how many series the error is known, and how many of these have the mean within it.
fn covered(coefficients: [f64; 2], length: u32, runs: u32) -> (u32, u32) {
    let mut normals = Normals::seed(u64::from(length));
    let found = (0..runs).map(|_| autoregressive(coefficients, length, &mut normals));
    found.fold((0, 0), |(known, covered), batches| match batches.error_bound() {
        bound if bound.is_nan() => {
            assert!(batches.standard_error().is_nan());
            (known, covered)
        }
        bound => {
            assert!(bound > batches.standard_error());
            (known + 1, covered + u32::from(batches.mean().abs() <= 1.96 * bound))
        }
    })
}

/// 95 ± 2 % of the series with an error, of which there are enough to be counted to 0.7 %.
fn check(coefficients: [f64; 2], length: u32, runs: u32) {
    let (known, covered) = covered(coefficients, length, runs);
    let fraction = f64::from(covered) / f64::from(known);
    println!("{coefficients:?}, {length}: known in {known} of {runs}, covered {fraction:.3}");
    assert!(
        known >= 1000 && (0.93..0.97).contains(&fraction),
        "{coefficients:?} {length} {known} {fraction}"
    );
}

#[test]
fn errors_of_correlated_series_cover() {
    for (coefficients, length) in
        [([0.0, 0.0], 256), ([0.9, 0.0], 2048), ([-0.9, 0.0], 2048), ([1.6, -0.8], 2048), ([0.5, 0.4], 4096)]
    {
        check(coefficients, length, 2000);
    }
}

/// Series that have an error by chance, and one in a hundred at most of those that are shorter still, which covers 91 % (1230 of 200 000 series).
#[test]
fn errors_of_short_series_cover_where_they_are_given() {
    for (coefficients, length, runs) in [
        ([0.7, 0.0], 256, 20_000),
        ([0.9, 0.0], 1024, 20_000),
        ([0.9, 0.0], 1500, 32_000),
        ([0.5, 0.4], 2048, 20_000),
    ] {
        check(coefficients, length, runs);
    }
    let (known, _) = covered([0.5, 0.4], 1024, 20_000);
    assert!(known < 200, "{known} of 20 000");
}

#[test]
fn errors_of_long_correlated_series_cover() {
    for (coefficients, length, runs) in [
        ([0.0, 0.0], 1 << 14, 2000),
        ([0.5, 0.0], 1 << 12, 2000),
        ([-0.9, 0.0], 1 << 14, 2000),
        ([0.9, 0.0], 1 << 14, 2000),
        ([0.99, 0.0], 1 << 15, 2000),
        ([0.999, 0.0], 1 << 18, 1200),
        ([1.88, -0.98], 1 << 14, 2000),
        ([1.88, -0.98], 1 << 17, 1200),
    ] {
        check(coefficients, length, runs);
    }
}

#[test]
fn series_that_are_too_short_have_no_error() {
    // Four, forty and a hundred correlation times; the last are known by chance.
    for (coefficients, length, most) in
        [([0.999, 0.0], 4096, 0), ([0.99, 0.0], 4096, 4), ([0.9, 0.0], 1024, 60)]
    {
        let (known, _) = covered(coefficients, length, 400);
        assert!(known <= most, "{coefficients:?} {length} {known}");
    }
    let constant = (0..1000).fold(BatchMeans::new(), |mut batches, _| {
        batches.add(1.0);
        batches
    });
    assert!(constant.standard_error().is_nan() && constant.error_bound().is_nan());
}

#[test]
fn series_that_oscillate_have_their_own_time() {
    // Of e^{-n/100} cos(2π n/20): (1 - a - b)² S(0) = 1, τ = 0.0557 of a sample.
    let (a, b): (f64, f64) = (1.88, -0.98);
    let variance = (1.0 - b) / ((1.0 + b) * ((1.0 - b).powi(2) - a * a));
    let time = 0.5 / ((1.0 - a - b).powi(2) * variance);
    let batches = autoregressive([a, b], 1 << 18, &mut Normals::seed(1));
    // V of 13 degrees of freedom, to 0.39.
    assert!((batches.time() / time - 1.0).abs() < 3.0 * 0.39, "{} {time}", batches.time());
}

#[test]
fn targets_that_are_met_cover() {
    let mut normals = Normals::seed(5);
    let (runs, target, mut outside) = (400, 0.3, 0);
    for _ in 0..runs {
        let (mut batches, mut x, mut next) = (BatchMeans::new(), normals.next() / f64::sqrt(1.0 - 0.81), 64);
        loop {
            x = 0.9 * x + normals.next();
            batches.add(x);
            if batches.count() == next {
                next += 64.max(next / 50);
                if batches.error_bound() <= target {
                    break;
                }
            }
        }
        outside += u32::from(batches.mean().abs() > 1.96 * target);
    }
    // 5 % of 400 are 20 ± 4.4.
    assert!(outside <= 33, "{outside}");
}

#[test]
fn temperatures_of_a_double_well_cover() {
    let (mut known, mut covered) = (0, 0);
    for seed in 0..400 {
        let run = LOW.simulate::<Baoab>(0.05).start(State::new([-1.0], [0.0])).noise(StepNormals::seed(seed));
        let shares = run.steps(6000).run().expect("a path").equipartition(&LOW);
        for share in [shares.kinetic[0], shares.configurational[0]] {
            assert_eq!(share.error_bound.is_nan(), share.standard_error.is_nan());
            known += i32::from(!share.error_bound.is_nan());
            covered += i32::from((share.temperature - LOW.kt).abs() <= 1.96 * share.error_bound);
        }
    }
    // The kinetic one at least; counted to 1.1 %, three of which are allowed below 93 %.
    println!("{covered} of {known}");
    assert!(known > 300 && f64::from(covered) > (0.93 - 0.033) * f64::from(known), "{covered} of {known}");
}

/// Averages of a path in two wells, up to a target if there is one.
fn averages(
    system: &Wells,
    q: f64,
    seed: u64,
    target: Option<f64>,
) -> TimeAverages<<Wells as Hamiltonian>::Vector> {
    let run = system.simulate::<Baoab>(0.1).start(State::new([q], [0.0])).noise(StepNormals::seed(seed));
    let run = run.observe("q", |state| state.q[0]).steps(1 << 18).time_averages().discard(20.0);
    let run = if let Some(target) = target { run.until_error("q", target) } else { run };
    run.run().expect("averages")
}

#[test]
fn chains_see_what_one_path_does_not() {
    let of = |system: &Wells, target: Option<f64>| {
        let starts = [-1.0, 1.0, -1.0, 1.0].into_iter().zip(1..);
        let runs: Vec<_> = starts.map(|(q, seed)| averages(system, q, seed, target)).collect();
        assert!(runs.iter().all(|run| run.met_targets == target.map(|_| true) && !run.is_partial));
        Chains::of("q", &runs).expect("chains")
    };
    let apart = of(&HIGH, Some(0.01));
    assert!(!apart.agree() && apart.disagreement > 5.0 && apart.error_bound > 0.5, "{apart:?}");
    // Thousands of correlation times each, over a barrier of 1.2 kT.
    let together = of(&Wells { height: 0.3, ..LOW }, None);
    assert!(together.agree() && together.mean.abs() < 4.0 * 0.02, "{together:?}");
    assert!(Chains::of("q", &[averages(&LOW, 1.0, 1, Some(0.2))]).is_err());
    assert!(Chains::of("p", &[averages(&LOW, 1.0, 1, Some(0.2))]).is_err());
}

mod kept {
    use super::*;
    use wzvi::checkpoint::Checkpoint;
    use wzvi::error::Error;

    type Averages = TimeAverages<<Wells as Hamiltonian>::Vector>;

    /// To the last bit, NaN included.
    fn text(averages: &Averages) -> String {
        format!("{averages:?}")
    }

    /// The averages of every second node up to a target, with a checkpoint, stopped when it is asked about that if `stops`.
    fn run(folder: &std::path::Path, target: f64, steps: u64, stops: bool) -> Result<Averages, Error> {
        let run = LOW.simulate::<Baoab>(0.1).start(State::new([1.0], [0.0])).noise(StepNormals::seed(1));
        let run =
            run.observe("q", |state| state.q[0]).observe("H", |state| LOW.energy(state)).record_every(2);
        let run = run.checkpoint(Checkpoint::to(folder.join("averages.wzvi")).every_steps(1001)).steps(steps);
        run.time_averages().discard(15.0).until_error("H", target).stop_when(move || stops).run()
    }

    #[test]
    fn runs_go_on_from_their_checkpoints() {
        let ((parted, whole), most) = ((fixtures::folder!("parted"), fixtures::folder!("whole")), 1 << 22);
        let expected = run(&whole, 0.01, most, false).expect("averages");
        assert!(expected.met_targets == Some(true) && !expected.is_partial);
        let part = run(&parted, 0.01, 3001, false).expect("averages");
        assert!(part.met_targets == Some(false) && part.steps == 3001 && !part.is_partial);
        let stopped = run(&parted, 1e-9, 1 << 40, true).expect("averages");
        assert!(stopped.is_partial && stopped.met_targets == Some(false) && stopped.steps > 3001);
        if stopped.steps <= expected.steps {
            assert_eq!(text(&run(&parted, 0.01, most, false).expect("averages")), text(&expected));
        }
        // One that has met its targets has them at once, and goes on to smaller ones.
        assert_eq!(text(&run(&whole, 0.01, most, true).expect("averages")), text(&expected));
        assert!(run(&whole, 0.008, most, false).expect("averages").steps > expected.steps);
        let other = LOW.simulate::<Baoab>(0.1).start(State::new([1.0], [0.0])).noise(StepNormals::seed(1));
        let other = other.checkpoint(Checkpoint::to(whole.join("averages.wzvi")).every_steps(1001));
        let error = other.steps(1 << 22).record_every(0).run().expect_err("a path is no average");
        assert!(error.to_string().contains("the averages of"), "{error}");
    }
}
