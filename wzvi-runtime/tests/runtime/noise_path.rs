//! A Wiener path is a function of time: the order of the queries, the partition and the direction change nothing.

use super::noise_wong_zakai::IMPLICIT;
use wzvi_runtime::noise::{Increments, Interval, Noise, NoiseError, Paths, Wiener, WongZakai};

/// A small generator for the queries, unrelated to the one under test.
struct Lcg(u64);

impl Lcg {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn below(&mut self, n: usize) -> usize {
        (self.uniform() * n as f64) as usize
    }
}

/// Times of all kinds: decimal, dyadic, thirds, irrational, tiny, far, negative, edges of octaves.
fn times() -> Vec<f64> {
    let mut lcg = Lcg(1);
    let mut times = vec![0.0, 1.0, 2.0, 1024.0, -1.0, -2.0, 1e-9, -1e-9, 1e6 + 0.1, 4e9 + 0.25, -1e6];
    for n in 0..60 {
        let n = f64::from(n);
        times.extend([n * 0.02, n / 128.0, n / 3.0, n * 0.0314, -n * 0.1, 1000.0 + n * 1e-3]);
        times.push((lcg.uniform() - 0.4) * 10f64.powf(8.0 * lcg.uniform() - 3.0));
        times.push(std::f64::consts::PI * n);
    }
    times
}

#[test]
fn the_order_of_queries_changes_no_bit() {
    let times = times();
    let mut lcg = Lcg(2);
    let fresh = |a: f64, b: f64| Wiener::seed(3).increment(1, a, b).unwrap();
    let integral = |a: f64, b: f64| Wiener::seed(3).integral(1, a, b).unwrap();
    let mut used = Wiener::seed(3);
    for _ in 0..1_500 {
        let (a, b) = (times[lcg.below(times.len())], times[lcg.below(times.len())]);
        used.value(lcg.below(3), a).unwrap();
        let got = used.increment(1, a, b).unwrap();
        assert_eq!(got.to_bits(), fresh(a, b).to_bits(), "{a} {b}");
        assert_eq!(got, -used.increment(1, b, a).unwrap());
        let got = used.integral(1, a, b).unwrap();
        assert_eq!(got.to_bits(), integral(a, b).to_bits(), "{a} {b}");
        assert_eq!(got, -used.integral(1, b, a).unwrap());
    }
}

/// `W(c) - W(a) = (W(b) - W(a)) + (W(c) - W(b))`, and the same for integrals, to rounding: some fifty terms.
#[test]
fn increments_and_integrals_are_additive() {
    let times = times();
    let mut lcg = Lcg(4);
    let mut w = Wiener::seed(5);
    for _ in 0..1_500 {
        let mut abc = [0.0; 3].map(|_| times[lcg.below(times.len())]);
        abc.sort_by(f64::total_cmp);
        let [a, b, c] = abc;
        let [ab, bc, ac] = [[a, b], [b, c], [a, c]].map(|[a, b]| w.increment(0, a, b).unwrap());
        let scale = (c - a).sqrt();
        assert!((ab + bc - ac).abs() <= 1e-14 * scale, "{a} {b} {c}: {ab} {bc} {ac}");
        let [i, j, k] = [[a, b], [b, c], [a, c]].map(|[a, b]| w.area(0, a, b).unwrap());
        let sum = i + j + (c - b) * ab;
        // The times themselves are rounded: c - b is known to an ulp of c or to the resolution of the tree.
        let time_error = 2e-15 * a.abs().max(c.abs()).max(1024.0) * ab.abs();
        assert!((sum - k).abs() <= 1e-13 * scale.powi(3) + time_error, "{a} {b} {c}: {sum} {k}");
    }
}

#[test]
fn runs_with_different_steps_share_the_path() {
    for (h, parts) in [(0.02, 2), (0.02, 20), (0.1, 5), (1.0 / 16.0, 64), (1.0 / 3.0, 4), (0.0371, 3)] {
        let (mut coarse, mut fine) = (Wiener::seed(8), Wiener::seed(8));
        for step in 0..300 {
            let (mut big, mut sum) = ([0.0], 0.0);
            coarse.increments(&Interval { start: -1.0, h, step }, &mut big).unwrap();
            for part in 0..parts {
                let mut small = [0.0];
                let h = h / parts as f64;
                fine.increments(&Interval { start: -1.0, h, step: step * parts + part }, &mut small).unwrap();
                sum += small[0];
            }
            // Off the grids a time may be rounded differently in the two runs, by 1e-12: W then differs by 1e-6.
            let tolerance = if h == 0.0371 { 1e-5 } else { 1e-13 };
            assert!((sum - big[0]).abs() < tolerance, "{h} / {parts}, {step}: {sum} {big:?}");
        }
    }
}

#[test]
fn a_run_back_gets_minus_the_increments() {
    let noises: [fn() -> Box<dyn Noise>; 6] = [
        || Box::new(Wiener::seed(9)),
        || Box::new(WongZakai::averaged(0.02).seed(9)),
        || Box::new(WongZakai::averaged(0.05).seed(9).centred()),
        || Box::new(WongZakai::averaged(0.1).seed(9).literal()),
        || Box::new(WongZakai::averaged(0.05).seed(9).exact()),
        || Box::new(WongZakai::averaged(0.05).seed(9).exact_centred().truncated(1)),
    ];
    for (kind, noise) in noises.iter().enumerate() {
        for (start, h) in [(0.0, 0.02), (-3.0, 0.02), (100.0, 1.0 / 128.0)] {
            let (mut forth, mut back) = (noise(), noise());
            let (steps, mut dw, mut minus) = (300, [0.0; 2], [0.0; 2]);
            let end = start + steps as f64 * h;
            for step in 0..steps {
                forth.increments(&Interval { start, h, step }, &mut dw).unwrap();
                let step = steps - 1 - step;
                back.increments(&Interval { start: end, h: -h, step }, &mut minus).unwrap();
                assert_eq!(dw, minus.map(|x| -x), "{kind}: {start} {h} {step}");
            }
        }
    }
}

/// From T = 200 back to 0 in steps of 0.02: the times of the way back carry the rounding errors of 200, and are recognised.
#[test]
fn long_runs_back_meet_the_same_times() {
    let (mut forth, mut back) = (Wiener::seed(10), Wiener::seed(10));
    for step in 0..10_000 {
        let (mut dw, mut minus) = ([0.0], [0.0]);
        forth.increments(&Interval { start: 0.0, h: 0.02, step }, &mut dw).unwrap();
        back.increments(&Interval { start: 200.0, h: -0.02, step: 9_999 - step }, &mut minus).unwrap();
        assert_eq!(dw[0], -minus[0], "{step}");
    }
}

/// The increments of tiny steps at large times are sums of small terms, not differences of large ones.
#[test]
fn small_increments_keep_their_digits() {
    let mut w = Wiener::seed(11);
    for start in [0.0, 1000.0, 65536.0] {
        let h = 2f64.powi(-20);
        let whole = w.increment(0, start, start + h).unwrap();
        let parts: f64 = (0..64)
            .map(|i| {
                w.increment(0, start + h * f64::from(i) / 64.0, start + h * f64::from(i + 1) / 64.0).unwrap()
            })
            .sum();
        assert!((whole - parts).abs() < 1e-14 * h.sqrt(), "{start}: {whole} {parts}");
    }
}

#[test]
fn builders_select_paths() {
    let value = |mut w: Wiener| w.value(0, 0.3).unwrap();
    let base = value(Wiener::seed(1));
    assert_ne!(base, value(Wiener::seed(2)));
    assert_ne!(base, value(Wiener::seed(1).path(1)));
    assert_ne!(base, Wiener::seed(1).value(1, 0.3).unwrap());
    assert_ne!(base, Wiener::seed(1).value(0, -0.3).unwrap());
    assert_eq!(base, value(Wiener::seed(1).untruncated()));
    assert_eq!(Wiener::seed(1).value(0, 0.0), Ok(0.0));
    let mut moved = Wiener::seed(1).path(5);
    value(moved.clone());
    moved.value(0, 77.0).unwrap();
    moved.set_path(0);
    assert_eq!(base, value(moved));
    assert_eq!(base, value(WongZakai::averaged(1.0).path(4).seed(1).path(0).left().into_wiener()));
}

#[test]
fn thirds_of_pi_are_shallow_in_units_of_pi() {
    let unit = std::f64::consts::PI / 100.0;
    let (mut coarse, mut fine) = (Wiener::seed(1).unit(unit), Wiener::seed(1).unit(unit));
    for step in 0..1000 {
        let mut dw = [[0.0]; 3];
        coarse.increments(&Interval { start: 0.0, h: unit, step }, &mut dw[0]).unwrap();
        fine.increments(&Interval { start: 0.0, h: unit / 2.0, step: 2 * step }, &mut dw[1]).unwrap();
        fine.increments(&Interval { start: 0.0, h: unit / 2.0, step: 2 * step + 1 }, &mut dw[2]).unwrap();
        assert!((dw[0][0] - dw[1][0] - dw[2][0]).abs() < 1e-15);
    }
}

#[test]
fn errors_say_what_is_wrong() {
    let step = Interval { start: 0.0, h: 0.1, step: 0 };
    let ask =
        |noise: &mut dyn Noise, interval: Interval| noise.increments(&interval, &mut [0.0]).unwrap_err();
    for start in [f64::NAN, f64::INFINITY, 1e300] {
        let error = ask(&mut Wiener::seed(0), Interval { start, ..step });
        assert!(matches!(error, NoiseError::Time { .. }), "{error}");
    }
    for h in [0.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(ask(&mut Wiener::seed(0), Interval { h, ..step }), NoiseError::StepSize(_)));
        assert!(matches!(
            ask(&mut WongZakai::averaged(0.1), Interval { h, ..step }),
            NoiseError::StepSize(_)
        ));
    }
    for eps in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(ask(&mut WongZakai::averaged(eps), step), NoiseError::Window(_)));
        assert!(WongZakai::averaged(eps).value(0, 1.0).is_err());
    }
    for k in [0.0, 0.99, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(ask(&mut Wiener::seed(0).truncated(k), step), NoiseError::Truncation(_)));
    }
    for unit in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(ask(&mut Wiener::seed(0).unit(unit), step), NoiseError::Unit(_)));
        assert!(matches!(Wiener::seed(0).unit(unit).value(0, 0.0), Err(NoiseError::Unit(_))));
    }
    let error = ask(&mut Increments::from([0.5]), Interval { step: 1, ..step });
    assert_eq!(error.to_string(), "step 1 has no increments: 1 steps were given; give more or end earlier");
}

/// Times that are none have no integral, on either side.
#[test]
fn integrals_of_no_time_are_errors() {
    for (a, b) in [(f64::NAN, 1.0), (1.0, f64::NAN), (f64::NAN, f64::NAN), (0.0, f64::INFINITY)] {
        for outcome in [Wiener::seed(1).integral(0, a, b), Wiener::seed(1).area(0, a, b)] {
            assert!(matches!(outcome, Err(NoiseError::Time { .. })), "{a} {b}: {outcome:?}");
        }
    }
}

/// A process has its path whatever its number, and whichever others were asked for before.
#[test]
fn every_process_has_a_path() {
    let mut all = Wiener::seed(3).path(2);
    for process in [usize::MAX, 5000, 3, usize::MAX - 1, 1000, 2000, 5000, usize::MAX] {
        let value = Wiener::seed(3).path(2).value(process, 0.7).unwrap();
        assert_eq!(all.value(process, 0.7).unwrap().to_bits(), value.to_bits(), "{process}");
    }
    all.value(0, 0.1).unwrap();
    let again = Wiener::seed(3).path(4).value(usize::MAX, 0.7).unwrap();
    assert_eq!(all.path(4).value(usize::MAX, 0.7).unwrap(), again);
}

/// Steps whose ends are one time of the tree have no increments that mean anything: an error before the run, or in the step.
#[test]
fn steps_below_the_distance_of_times_are_refused() {
    let prepared = |mut noise: Wiener, h: f64, start: f64| noise.prepare(&IMPLICIT, h, 1, start);
    assert!(prepared(Wiener::seed(1), 1e-3, 0.0).is_ok() && prepared(Wiener::seed(1), 1e-6, 900.0).is_ok());
    assert!(prepared(Wiener::seed(1).unit(1e-15), 1e-15, 0.0).is_ok());
    for (h, start) in [(1e-15, 0.0), (1e-10, 0.0), (1e-3, 1e12)] {
        let error = prepared(Wiener::seed(1), h, start).unwrap_err().to_string();
        assert!(error.contains("too short"), "{error}");
    }
    let none = Wiener::seed(1).increments(&Interval { start: 0.0, h: 1e-15, step: 3 }, &mut [0.0]);
    assert!(matches!(none, Err(NoiseError::Setting(_))), "{none:?}");
}
