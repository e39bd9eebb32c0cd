//! Slopes of synthetic curves.

use wzvi::report::fit::{Sample, Slope, fit};

fn samples(exponents: std::ops::RangeInclusive<i32>, error: impl Fn(f64) -> f64) -> Vec<Sample> {
    let h = exponents.map(|k| 2f64.powi(-k));
    h.map(|h| Sample { h, error: error(h), standard_error: 0.02 * error(h) }).collect()
}

#[track_caller]
fn order(slope: &Slope) -> (f64, &[f64], &[f64], &[f64]) {
    match slope {
        Slope::Order { order, used, pre_asymptotic, plateau, .. } => (*order, used, pre_asymptotic, plateau),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_power_law_is_recovered_from_all_points_in_any_order() {
    for (expected, factor) in [(0.5, 3.0), (1.0, 0.1), (2.0, 7.0), (4.0, 1e-3)] {
        let mut points = samples(2..=9, |h| factor * h.powf(expected));
        points.swap(0, 5);
        let slope = fit(&points);
        let (found, used, before, after) = order(&slope);
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        assert_eq!((used.len(), before.len(), after.len()), (8, 0, 0));
        assert!(used.is_sorted_by(|a, b| a > b));
        let Slope::Order { factor: found, .. } = slope else { unreachable!() };
        assert!((found / factor - 1.0).abs() < 1e-10);
    }
}

#[test]
fn a_plateau_is_left_out() {
    // Order two down to a floor of rounding.
    let slope = fit(&samples(2..=12, |h| h * h + 1e-5));
    let (found, used, before, after) = order(&slope);
    assert!((found - 2.0).abs() < 0.05, "{found}");
    assert!(before.is_empty() && after.len() >= 3, "{slope:?}");
    assert!(used.iter().all(|h| h * h > 5e-5), "{used:?}");
    assert!(slope.words().contains("plateau"), "{}", slope.words());
}

#[test]
fn a_pre_asymptotic_bend_is_left_out() {
    // Saturated errors at large steps, order one at small ones.
    let slope = fit(&samples(0..=13, |h| 50.0 * h / (1.0 + 50.0 * h)));
    let (found, _, before, after) = order(&slope);
    // The bend is slow: the local slope is 0.84 at 2^-8.
    assert!((found - 1.0).abs() < 0.08, "{slope:?}");
    assert!(before.len() >= 4 && after.is_empty(), "{slope:?}");
    // A steep part in front: order four before order one takes over.
    let slope = fit(&samples(0..=12, |h| h + 1e4 * h.powi(4)));
    let (found, _, before, after) = order(&slope);
    assert!((found - 1.0).abs() < 0.06, "{slope:?}");
    assert!(!before.is_empty() && after.is_empty(), "{slope:?}");
}

#[test]
fn both_ends_are_left_out_at_once() {
    let slope = fit(&samples(0..=14, |h| 1.0 / (1.0 + 0.002 / (h * h)) + 1e-5));
    let (found, _, before, after) = order(&slope);
    assert!((found - 2.0).abs() < 0.1, "{slope:?}");
    assert!(before.len() >= 3 && after.len() >= 2, "{slope:?}");
}

#[test]
fn noise_in_the_errors_is_weighed() {
    // One point is three times too large and says so.
    let mut points = samples(2..=7, |h| h);
    points[5].error *= 3.0;
    points[5].standard_error = points[5].error;
    let (found, used, ..) = (match fit(&points) {
        Slope::Order { order, used, .. } => Some((order, used)),
        _ => None,
    })
    .unwrap();
    assert_eq!(used.len(), 6);
    assert!((found - 1.0).abs() < 0.02, "{found}");
}

#[test]
fn what_has_no_slope_says_so() {
    assert_eq!(fit(&samples(2..=3, |h| h)), Slope::TooFew { points: 2 });
    assert_eq!(fit(&samples(2..=9, |_| 0.0)), Slope::TooFew { points: 0 });
    assert_eq!(fit(&samples(2..=9, |_| f64::NAN)), Slope::TooFew { points: 0 });
    let Slope::Flat { error, .. } = fit(&samples(2..=9, |h| 0.4 + 0.1 * h)) else { panic!() };
    assert!((error - 0.4).abs() < 0.02);
    let crooked = fit(&samples(2..=7, |h| if h.log2() as i32 % 2 == 0 { 1.0 } else { 100.0 }));
    assert_eq!(crooked, Slope::Crooked { points: 6 });
    assert!(fit(&samples(2..=3, |h| h)).words().contains("too few"));
}
