//! The law of the paths. Every statistic below is, under the right law, a standard normal up to O(1/n) (or chi-square); it is compared
//! with 5, which a right generator exceeds with probability 6e-7. The seeds are fixed, so the tests are deterministic; there are
//! fewer than 400 comparisons, so that a right implementation had a chance of 2e-4 of failing at its first run.

use wzvi::noise::{Interval, Noise, Paths, Wiener, WongZakai, clip_bound};

const BOUND: f64 = 5.0;

/// The z-scores of mean, variance, skewness and kurtosis of samples that should be standard normal.
fn moments(samples: &[f64]) -> [f64; 4] {
    let n = samples.len() as f64;
    let mean = |f: &dyn Fn(f64) -> f64| samples.iter().map(|&x| f(x)).sum::<f64>() / n;
    // Variances of x, x^2, He_3(x) and He_4(x): k!, with x^2 - 1 = He_2.
    [
        mean(&|x| x) * n.sqrt(),
        mean(&|x| x * x - 1.0) * (n / 2.0).sqrt(),
        mean(&|x| x * x * x - 3.0 * x) * (n / 6.0).sqrt(),
        mean(&|x| x.powi(4) - 6.0 * x * x + 3.0) * (n / 24.0).sqrt(),
    ]
}

/// The z-score of the correlation of two sets of standard normals that should be independent, and of that of their squares.
fn correlation(x: &[f64], y: &[f64]) -> [f64; 2] {
    let n = x.len() as f64;
    let sum: f64 = x.iter().zip(y).map(|(x, y)| x * y).sum();
    let squares: f64 = x.iter().zip(y).map(|(x, y)| (x * x - 1.0) * (y * y - 1.0)).sum();
    [sum / n.sqrt(), squares / (4.0 * n).sqrt()]
}

fn check(what: &str, scores: &[f64]) {
    assert!(scores.iter().all(|z| z.abs() < BOUND), "{what}: {scores:?}");
}

/// Quantities of the path, for each of `n` paths.
fn samples<T>(n: u64, seed: u64, mut f: impl FnMut(&mut Wiener) -> T) -> Vec<T> {
    let mut wiener = Wiener::seed(seed);
    (0..n)
        .map(|path| {
            wiener.set_path(path);
            f(&mut wiener)
        })
        .collect()
}

/// `W(b) - W(a) ~ N(0, b - a)`, and `int (W - chord) ~ N(0, (b - a)^3 / 12)` independently: near, far, within and across the cells.
#[test]
fn increments_and_areas_over_any_interval() {
    let intervals = [
        (0.0, 1.0),
        (0.0, 0.02),
        (0.1, 0.35),
        (0.98, 1.02),
        (0.3, 0.31),
        (1.0 / 3.0, 2.0 / 3.0),
        (0.123_456_7, 0.765_432_1),
        (1.5, 2.75),
        (3.9, 17.3),
        (0.0, 1000.0),
        (1e6 + 0.1, 1e6 + 0.3),
        (1023.99, 1024.01),
        (-0.7, -0.2),
        (-0.3, 0.5),
        (-20.0, 3.1),
        (1e-6, 3e-6),
        (std::f64::consts::E, std::f64::consts::PI),
    ];
    for (a, b) in intervals {
        let length: f64 = b - a;
        let both = samples(1500, 1, |w| {
            let w1 = w.increment(0, a, b).unwrap();
            let chord = w.area(0, a, b).unwrap() - 0.5 * length * w1;
            (w1 / length.sqrt(), chord / (length.powi(3) / 12.0).sqrt())
        });
        let (w, chord): (Vec<f64>, Vec<f64>) = both.into_iter().unzip();
        check(&format!("increment {a} {b}"), &moments(&w));
        check(&format!("area {a} {b}"), &moments(&chord));
        check(&format!("increment and area {a} {b}"), &correlation(&w, &chord));
    }
}

/// Increments along one path, over grids of all kinds: moments, and correlations of neighbours.
#[test]
fn increments_along_a_path() {
    for (i, h) in [1.0, 0.02, 1e-3, 1.0 / 128.0, 1.0 / 3.0, 0.0314, 0.7].into_iter().enumerate() {
        let mut wiener = Wiener::seed(100 + i as u64);
        let mut dw = [0.0; 2];
        let (x, y): (Vec<f64>, Vec<f64>) = (0..20_000)
            .map(|step| {
                wiener.increments(&Interval { start: -7.0, h, step }, &mut dw).unwrap();
                (dw[0] / h.sqrt(), dw[1] / h.sqrt())
            })
            .unzip();
        check(&format!("h = {h}"), &moments(&x));
        check(&format!("h = {h}, two processes"), &correlation(&x, &y));
        for lag in [1, 2, 5, 20] {
            check(&format!("h = {h}, lag {lag}"), &correlation(&x[lag..], &x[..x.len() - lag]));
        }
    }
}

/// Cells of equal probability, chi-square with 63 degrees of freedom: `(chi^2 - 63) / sqrt(126)`.
#[test]
fn increments_are_uniform_under_their_distribution_function() {
    let mut wiener = Wiener::seed(200);
    let mut dw = [0.0];
    let n = 64_000;
    let mut values: Vec<f64> = (0..n)
        .map(|step| {
            wiener.increments(&Interval { start: 0.0, h: 0.02, step }, &mut dw).unwrap();
            dw[0] / 0.02f64.sqrt()
        })
        .collect();
    values.sort_by(f64::total_cmp);
    // The distribution function by Simpson's rule between consecutive quantiles is not needed: integrate the density up to each edge.
    let density = |x: f64| (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
    let (mut x, mut probability, mut edges, width) = (-9.0, 0.0, vec![], 1e-4);
    while edges.len() < 63 {
        probability += width * (density(x) + 4.0 * density(x + width / 2.0) + density(x + width)) / 6.0;
        x += width;
        if probability >= (edges.len() + 1) as f64 / 64.0 {
            // Back to the exact quantile, to first order.
            edges.push(x - (probability - (edges.len() + 1) as f64 / 64.0) / density(x));
        }
    }
    let mut below = 0;
    let mut chi = 0.0;
    for edge in edges.into_iter().chain([f64::INFINITY]) {
        let next = values.partition_point(|&v| v < edge);
        chi += ((next - below) as f64 - 1000.0).powi(2) / 1000.0;
        below = next;
    }
    check("chi-square", &[(chi - 63.0) / 126f64.sqrt()]);
}

/// `E W(s) W(t) = min(s, t)`; disjoint increments are independent; so are the two sides of zero, paths, processes and seeds.
#[test]
fn covariances() {
    let n = 4000;
    for (s, t) in [(0.3_f64, 0.7_f64), (0.02, 0.021), (0.5, 12.3), (1.0, 3.0), (7.7, 8.1)] {
        // cov(W(t), int_0^t W) = t^2 / 2 and cov(W(s), int_0^t W) = s t - s^2 / 2, as regression residuals that are independent of W(s).
        let slope = (s * t - s * s / 2.0) / s;
        let variance = t.powi(3) / 3.0 - slope * slope * s;
        let of_paths = samples(n, 3, |w| {
            let early = w.value(0, s).unwrap();
            [
                early / s.sqrt(),
                w.increment(0, s, t).unwrap() / (t - s).sqrt(),
                w.value(0, -s).unwrap() / s.sqrt(),
                w.value(1, s).unwrap() / s.sqrt(),
                (w.integral(0, 0.0, t).unwrap() - slope * early) / variance.sqrt(),
            ]
        });
        let [early, late, mirror, process, rest] =
            std::array::from_fn(|i| of_paths.iter().map(|values| values[i]).collect::<Vec<f64>>());
        let seed = samples(n, 4, |w| w.value(0, s).unwrap() / s.sqrt());
        for (what, other) in [("later", &late), ("mirror", &mirror), ("process", &process), ("seed", &seed)] {
            check(&format!("{what} {s} {t}"), &correlation(&early, other));
        }
        check("path", &correlation(&early[..early.len() - 1], &early[1..]));
        check("integral", &moments(&rest));
        check("integral and value", &correlation(&early, &rest));
    }
}

/// Increments sampled from windows converge to `sqrt(v) W`, v = 1 + f (1 - f) / rho^2, and 1 / rho for rho < 1.
///
/// Their sum over N steps has covariance T with W(T), so that the variance of the difference is (v - 1) T, up to the two ends, where windows
/// stick out: at most (rho + 1) h together.
#[test]
fn sampled_windows_have_the_variance_of_theory() {
    let (h, steps, blocks) = (0.02, 200, 100);
    // Shorter than a step, of whole steps, and of parts of them.
    for rho in [0.25, 1.0, 1.5, 2.25, 3.0] {
        let f = f64::fract(rho);
        let v = if rho < 1.0 { 1.0 / rho } else { 1.0 + f * (1.0 - f) / (rho * rho) };
        let make = || WongZakai::averaged(rho * h).seed(42);
        let kinds = [
            ("left", make(), v),
            ("centred", make().centred(), v),
            ("literal", make().literal(), v),
            ("exact", make().exact(), 1.0),
        ];
        for (what, mut noise, v) in kinds {
            let (mut path, mut dw, mut square) = (Wiener::seed(42), [0.0], 0.0);
            for block in 0..blocks {
                let (from, to) = (block * steps, (block + 1) * steps);
                let mut gap = -path.increment(0, from as f64 * h, to as f64 * h).unwrap();
                for step in from..to {
                    noise.increments(&Interval { start: 0.0, h, step }, &mut dw).unwrap();
                    gap += dw[0];
                }
                square += gap * gap / (blocks as f64 * steps as f64 * h);
            }
            let chance = 1.0 + BOUND * f64::sqrt(2.0 / blocks as f64);
            let tolerance = (v - 1.0) * (chance - 1.0) + chance * (rho + 1.0) / steps as f64;
            assert!((square - (v - 1.0)).abs() < tolerance, "{what} {rho}: {square} {v} {tolerance}");
        }
    }
}

/// The documented standard deviations of single increments.
#[test]
fn deviations_of_window_increments() {
    for eps in [0.005, 0.02, 0.05] {
        let make = || WongZakai::averaged(eps).seed(43);
        let noises = [make(), make().centred(), make().literal(), make().exact(), make().exact_centred()];
        for (kind, mut noise) in noises.into_iter().enumerate() {
            let deviation = noise.deviation(0.02);
            let mut dw = [0.0];
            let values: Vec<f64> = (0..3000)
                .map(|path| {
                    noise.set_path(path);
                    noise.increments(&Interval { start: 0.1, h: 0.02, step: 3 }, &mut dw).unwrap();
                    dw[0] / deviation
                })
                .collect();
            check(&format!("{kind} eps = {eps}"), &moments(&values));
        }
    }
}

/// `E |W_eps(t) - W(t)|^2 = eps / 3` for the averaging kernel, `eps / 12` for the centred one; also next to and across zero.
#[test]
fn distance_to_the_path() {
    for (t, eps) in [(0.7, 0.02), (0.0, 0.1), (12.0, 1.0), (-0.03, 0.05)] {
        let gap = |centred: bool| {
            samples(4000, 44, |w| {
                let wong_zakai = WongZakai::of(w.clone(), eps);
                let mut wong_zakai = if centred { wong_zakai.centred() } else { wong_zakai };
                (wong_zakai.value(0, t).unwrap() - w.value(0, t).unwrap()) / eps.sqrt()
            })
        };
        check("averaged", &moments(&gap(false).iter().map(|x| x * 3f64.sqrt()).collect::<Vec<_>>()));
        check("centred", &moments(&gap(true).iter().map(|x| x * 12f64.sqrt()).collect::<Vec<_>>()));
    }
}

/// Truncation knows no unit of time: in steps of order one, increments are what they are without it. Of 60 000 normals, one is beyond the
/// least bound of 6 with probability 1e-4.
#[test]
fn truncation_leaves_ordinary_increments_alone() {
    for (h, k) in [(0.9, 1.0), (1.0, 4.0), (2.0, 4.0)] {
        let (mut free, mut clipped) = (Wiener::seed(45), Wiener::seed(45).truncated(k));
        let (mut dw, mut cut) = ([0.0], [0.0]);
        for step in 0..20_000 {
            let interval = Interval { start: 0.0, h, step };
            free.increments(&interval, &mut dw).unwrap();
            clipped.increments(&interval, &mut cut).unwrap();
            let limit = clip_bound(h, k) * f64::sqrt(h);
            assert_eq!(cut[0], dw[0].clamp(-limit, limit));
            assert_eq!(cut, dw);
        }
    }
}
