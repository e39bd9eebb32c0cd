//! The lemmas of the paper, with the limits of the sums corrected (docs/guide/theory.md, section 6).

use super::*;
use nalgebra::SVector;

/// Dyadic numbers `k/64` with `|k| < 2^20`, from a linear congruential generator: with a dyadic `h` nothing
/// below rounds, and equality is equality.
struct Dyadic(u64);

impl Dyadic {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 43) as f64 - f64::from(1 << 20)) / 64.0
    }

    fn function<S: Scale>(&mut self, scale: TimeScale) -> Function<S, f64> {
        Function::over(scale, |_| self.next())
    }
}

/// `N` and a dyadic `h`, also backwards.
fn scales() -> impl Iterator<Item = TimeScale> {
    let steps = [1, 2, 3, 7, 64, 100];
    let scale = |n: usize, h: f64| TimeScale::new(-0.75, -0.75 + n as f64 * h, n).unwrap();
    steps.into_iter().flat_map(move |n| [0.25, 2.0, -0.5].map(|h| scale(n, h)))
}

fn product<S: Scale>(f: &Function<S, f64>, v: &Function<S, f64>) -> Function<S, f64> {
    f.zip_with(v, |f, v| f * v).unwrap()
}

fn total<S: Scale>(f: &Function<S, f64>) -> f64 {
    f.values().iter().sum::<f64>() * f.scale().step_size()
}

#[test]
fn the_scales_are_those_of_the_paper() {
    let scale = TimeScale::new(1.0, 2.0, 4).unwrap();
    fn times<S: Scale>(scale: TimeScale) -> Vec<f64> {
        scale.points::<S>().map(|point| scale.time(point).unwrap()).collect()
    }
    assert_eq!(times::<Nodes>(scale), [1.0, 1.25, 1.5, 1.75, 2.0]);
    assert_eq!(times::<Plus<Nodes>>(scale), [1.0, 1.25, 1.5, 1.75]);
    assert_eq!(times::<Minus<Nodes>>(scale), [1.25, 1.5, 1.75, 2.0]);
    assert_eq!(times::<Interior>(scale), [1.25, 1.5, 1.75]);
    assert_eq!(times::<Midpoints>(scale), [1.125, 1.375, 1.625, 1.875]);
    assert_eq!(times::<Whole>(scale), [1.0, 1.125, 1.25, 1.375, 1.5, 1.625, 1.75, 1.875, 2.0]);
    assert_eq!(times::<Plus<Minus<Nodes>>>(scale), times::<Interior>(scale));
    for point in scale.points::<Interior>() {
        for there_and_back in [
            scale.sigma::<Nodes>(point).and_then(|next| scale.rho::<Nodes>(next)),
            scale.sigma::<Whole>(point).and_then(|next| scale.rho::<Whole>(next)),
        ] {
            assert_eq!(there_and_back, Ok(point));
        }
    }
    assert_eq!(scale.sigma::<Whole>(Point::node(1)), Ok(Point::midpoint(1)));
}

#[test]
fn outside_its_domain_everything_is_a_typed_error() {
    let scale = TimeScale::new(0.0, 1.0, 4).unwrap();
    let f = scale.sample::<Nodes, _>(|t| t);
    let off = |point, scale| Err(DomainError::Point { point, scale, steps: 4 });
    assert_eq!(f.at(Point::node(4)), Ok(&1.0));
    assert_eq!(f.at(Point::node(5)).cloned(), off(Point::node(5), "T"));
    assert_eq!(f.at(Point::midpoint(0)).cloned(), off(Point::midpoint(0), "T"));
    assert_eq!(f.at(Point::node(usize::MAX)).cloned(), off(Point::node(usize::MAX), "T"));
    assert!(matches!(f.delta_plus().at(Point::node(4)), Err(DomainError::Point { .. })));
    assert!(matches!(f.delta_minus().at(Point::node(0)), Err(DomainError::Point { .. })));
    assert!(scale.sigma::<Nodes>(Point::node(4)).is_err() && scale.rho::<Nodes>(Point::node(0)).is_err());
    assert!(scale.rho::<Midpoints>(Point::midpoint(0)).is_err() && scale.time(Point::midpoint(4)).is_err());
    assert!(f.restrict::<Whole>().is_err() && f.restrict::<Interior>().is_ok());
    let other = TimeScale::new(0.0, 2.0, 4).unwrap().sample::<Nodes, _>(|t| t);
    assert_eq!(f.zip_with(&other, |a, b| a + b), Err(DomainError::Different));
    assert_eq!(
        Function::<Nodes, f64>::new(scale, vec![0.0; 4]),
        Err(DomainError::Length { expected: 5, got: 4 })
    );
    for (a, b, n) in
        [(0.0, 1.0, 0), (0.0, 0.0, 3), (f64::NAN, 1.0, 3), (0.0, f64::INFINITY, 3), (-1e308, 1e308, 1)]
    {
        assert!(matches!(TimeScale::new(a, b, n), Err(DomainError::Interval { .. })), "{a} {b} {n}");
    }
    for lambda in [-0.1, 1.1, f64::NAN] {
        assert!(matches!(Lambda::sample(scale, lambda, |t| t), Err(DomainError::Lambda(_))));
    }
    assert_eq!(f.delta_plus().at(Point::midpoint(1)).unwrap_err().to_string().lines().count(), 1);
}

#[test]
fn the_derivative_of_the_extension_is_that_of_the_function() {
    let mut random = Dyadic(1);
    for scale in scales() {
        let f: Function<Nodes, f64> = random.function(scale);
        let (whole, coarse) = (f.extension().delta_plus(), f.delta_plus());
        for i in 0..scale.steps() {
            assert_eq!(whole.at(Point::midpoint(i)), coarse.at(Point::node(i)));
        }
        // The node before has the same value, as the extension is affine in between.
        assert_eq!(whole.restrict::<Plus<Nodes>>().unwrap(), coarse);
    }
}

#[test]
fn integration_by_parts() {
    let mut random = Dyadic(2);
    for scale in scales() {
        let n = scale.steps();
        let f: Function<Midpoints, f64> = random.function(scale);
        let v: Function<Nodes, f64> = random.function(scale);
        let slope = v.extension().delta_plus().restrict::<Midpoints>().unwrap();
        let left = product(&f, &slope).integral().unwrap();

        // Δ_{½,-}[f](t_{i+1/2}), moved to t_i by σ_∘.
        let derivative = f.delta_minus();
        let moved = Function::<Interior, f64>::over(scale, |point| {
            *derivative.at(scale.sigma::<Whole>(point).unwrap()).unwrap()
        });
        let inner = total(&product(&moved, &v.restrict().unwrap()));
        let (first, last) = (f.at(Point::midpoint(0)).unwrap(), f.at(Point::midpoint(n - 1)).unwrap());
        let (start, end) = (v.at(Point::node(0)).unwrap(), v.at(Point::node(n)).unwrap());
        assert_eq!(left, -inner + last * end - first * start, "N = {n}");
    }
}

#[test]
fn the_transfer_lemma() {
    let mut random = Dyadic(3);
    for scale in scales() {
        let (n, h) = (scale.steps(), scale.step_size());
        let f: Function<Whole, f64> = random.function(scale);
        let half = f.restrict::<Midpoints>().unwrap();
        let v: Function<Nodes, f64> = random.function(scale);
        let left = product(&half, &v.extension().restrict().unwrap()).integral().unwrap();

        let around = f.mean_around();
        assert_eq!(around, half.mean_around());
        let inner = total(&product(&around, &v.restrict().unwrap()));
        let (first, last) = (half.at(Point::midpoint(0)).unwrap(), half.at(Point::midpoint(n - 1)).unwrap());
        let (start, end) = (v.at(Point::node(0)).unwrap(), v.at(Point::node(n)).unwrap());
        assert_eq!(left, inner + h / 2.0 * (last * end + first * start), "N = {n}");

        // [f]_∘(t) = [f]_{½,-}(σ_∘(t))
        let minus = half.mean_minus();
        for (point, value) in around.iter() {
            assert_eq!(minus.at(scale.sigma::<Whole>(point).unwrap()), Ok(value));
        }
    }
}

#[test]
fn du_bois_reymond() {
    // The test functions that vanish at both ends are spanned by those that are 1 at one interior node:
    // integrals against them read f there off, and nowhere else.
    let mut random = Dyadic(4);
    for scale in scales().filter(|scale| scale.steps() < 64) {
        let h = scale.step_size();
        let f: Function<Plus<Nodes>, f64> = random.function(scale);
        for node in scale.points::<Interior>() {
            let v = Function::over(scale, |point| if point == node { 1.0 } else { 0.0 });
            assert_eq!(product(&f, &v).integral(), Ok(h * f.at(node).unwrap()));
        }
        let ends = Function::<Plus<Nodes>, f64>::over(scale, |point| {
            if point == Point::node(0) { random.next() } else { 0.0 }
        });
        let v = Function::over(scale, |point| if point == Point::node(0) { 0.0 } else { random.next() });
        assert_eq!(product(&ends, &v).integral(), Ok(0.0), "f is free at the ends");
    }
}

#[test]
fn the_adjoint_of_delta_plus_is_minus_delta_minus() {
    let mut random = Dyadic(5);
    for scale in scales() {
        let n = scale.steps();
        let (f, v): (Function<Nodes, f64>, Function<Nodes, f64>) =
            (random.function(scale), random.function(scale));
        let left = product(&f.delta_plus(), &v.restrict().unwrap()).integral().unwrap();
        let right = total(&product(&v.delta_minus(), &f.restrict().unwrap()));
        let at = |i| f.at(Point::node(i)).unwrap() * v.at(Point::node(i)).unwrap();
        assert_eq!(left, -right + at(n) - at(0));
    }
}

#[test]
fn derivative_and_antiderivative_are_inverse() {
    let mut random = Dyadic(6);
    for scale in scales() {
        let f: Function<Nodes, f64> = random.function(scale);
        let start = *f.at(Point::node(0)).unwrap();
        assert_eq!(f.delta_plus().antiderivative(start), f);
        let g: Function<Midpoints, f64> = random.function(scale);
        let slope = g.antiderivative(start).extension().delta_plus().restrict();
        assert_eq!(slope, Ok(g));
        for lambda in [0.0, 0.25, 0.5, 1.0] {
            let g = Lambda::new(scale, lambda, (0..scale.steps()).map(|_| random.next()).collect()).unwrap();
            assert_eq!(g.antiderivative(start).delta_plus().values(), g.values());
        }
    }
}

#[test]
fn the_rules_integrate_what_they_should() {
    let scale = TimeScale::new(0.5, 2.5, 8).unwrap();
    // ∫ t dt = 3; every rule is off by (λ - 1/2) h (b - a).
    for lambda in [0.0, 0.25, 0.5, 1.0] {
        let rule = Lambda::sample(scale, lambda, |t| t).unwrap();
        assert_eq!(rule.integral(), Ok(3.0 + (lambda - 0.5) * 0.25 * 2.0));
    }
    let half = scale.sample::<Midpoints, _>(|t| t * t);
    assert_eq!(half.integral(), Lambda::sample(scale, 0.5, |t| t * t).unwrap().integral());
    let left = scale.sample::<Plus<Nodes>, _>(|t| t * t);
    assert_eq!(left.integral(), Lambda::sample(scale, 0.0, |t| t * t).unwrap().integral());
    let constant = Lambda::sample(scale, 0.25, |t| t).unwrap();
    assert_eq!(constant.step_function(0.75), constant.values().get(1));
    assert_eq!(constant.step_function(2.4), constant.values().last());
    assert!([0.4, 2.5, f64::NAN].map(|t| constant.step_function(t)).iter().all(Option::is_none));
}

#[test]
fn vectors_are_values_too() {
    let scale = TimeScale::new(0.0, 1.0, 4).unwrap();
    let circle = scale.sample::<Nodes, SVector<f64, 2>>(|t| SVector::from([t * t, 1.0 - t]));
    let [x, y] = [0, 1].map(|i| circle.map(|v| v[i]));
    let slopes = circle.delta_plus();
    assert_eq!(slopes.map(|v| v[0]), x.delta_plus());
    assert_eq!(slopes.map(|v| v[1]), y.delta_plus());
    assert_eq!(slopes.integral(), Ok(SVector::from([1.0, -1.0])));
}

#[test]
fn on_any_data_the_lemmas_hold_up_to_rounding() {
    // N terms of size up to 2^14, divided by h and multiplied again: a few roundings each.
    let mut random = Dyadic(7);
    for n in [1, 5, 50] {
        let scale = TimeScale::new(0.1, 0.7, n).unwrap();
        let h = scale.step_size();
        let f = Function::<Midpoints, f64>::over(scale, |_| random.next() / 3.0);
        let v = Function::<Nodes, f64>::over(scale, |_| random.next() / 7.0);
        let slope = v.extension().delta_plus().restrict().unwrap();
        let left = product(&f, &slope).integral().unwrap();
        let derivative = f.delta_minus();
        let inner: f64 = (1..n).map(|i| derivative.values()[i - 1] * v.values()[i]).sum();
        let right = -h * inner + f.values()[n - 1] * v.values()[n] - f.values()[0] * v.values()[0];
        let size = 2f64.powi(14) / 3.0 * 2f64.powi(14) / 7.0 * n as f64;
        assert!((left - right).abs() <= 16.0 * f64::EPSILON * size, "{left} {right}");
    }
}
