//! The values of closures in the compiler; their agreement with `rustc` is tested in `tests/steps/values.rs`.

use super::{drift, same_as_rust, value};
use crate::symbolic::{Expr, Function, Rational};

#[test]
fn coordinates_have_the_names_of_their_patterns() {
    let points = drift("|[[x, _], b]: [[f64; 2]; 2], p: [[f64; 2]; 2]| x * b[0] * p[1][1]");
    let names: Vec<_> = points.phase.q.iter().map(|&s| points.graph.symbol_name(s).to_owned()).collect();
    assert_eq!(names, ["x", "q[0][1]", "b[0]", "b[1]"]);
}

#[test]
fn parameters_in_the_order_of_their_use() {
    let closure = "|q, p| sigma * q.powi(n) + self.a * p + self.masses[2] * masses[1 + 1] + table[7] + n as f64 \
                   + G * PI * std::f64::consts::PI + Self::K + N as f64 + a + grid[1][0]";
    let model = drift(closure);
    let mut seen = Vec::new();
    for parameter in &model.parameters {
        let name = model.graph.symbol_name(parameter.symbol);
        seen.push(format!("{name} = {}", parameter.tokens.to_string().replace(' ', "")));
    }
    let expected = [
        "sigma = self.sigma",
        "n = (self.nas::core::primitive::f64)",
        "a = self.a",
        "masses[2] = self.masses[2]",
        "table[7] = (||__wzvi::Some((*self.table.get(7usize)?)))()\
         .unwrap_or(__wzvi::f64::NAN)",
        "G = G",
        "PI = PI",
        "PI = std::f64::consts::PI",
        "Self::K = Self::K",
        "N = (Nas::core::primitive::f64)",
        "grid[1][0] = self.grid[1][0]",
    ];
    assert_eq!(seen, expected);
}

#[test]
fn integers_of_the_struct_select() {
    macro_rules! same_for_every_integer {
        ($n:ident: $($closure:expr),* $(,)?) => {
            $( for $n in [-3, -1, 0, 1, 2, 3, 4, 7, 1_000_000] {
                same_as_rust!($closure, [0.3], [1.7], { $n = $n });
            } )*
        };
    }
    same_for_every_integer!(
        n:
        |q: f64, p: f64| if n == 0 { q } else { p },
        |q: f64, p: f64| if n == 3 { q } else { p },
        |q: f64, p: f64| if 3 != n { q } else { p },
        |q: f64, p: f64| if n < 2 || n == 7 { q } else { p },
        |q: f64, p: f64| if 2 * n > 5 { q } else { p },
        |q: f64, p: f64| if -1 < n && n <= 3 { q } else { p },
        |q: f64, p: f64| match n {
            0 => q,
            -1 | 2 => q * p,
            3..=5 => p,
            6.. => p - q,
            _ => 2.0,
        },
        |q: f64, p: f64| match n {
            ..0 => q,
            _ if n == 1 => p,
            _ => 2.0,
        },
        |q: f64, p: f64| match n == 2 {
            true => q,
            false => p,
        },
        |q: f64, p: f64| if if n > 1 { q > p } else { true } { q } else { p },
        |q: f64, p: f64| if if n > 1 { false } else { q < p } { q } else { p },
        |q: f64, p: f64| if (q < p) == (n > 2) { q } else { p },
        |q: f64, p: f64| {
            let yes = true;
            if (q > p) != yes && yes && yes == (n > 2) { q } else { p }
        },
        |q: f64, p: f64| match q > p {
            false => q + p,
            true => p,
        },
        |q: f64, p: f64| {
            let (x, y) = match n {
                1 => (q, p),
                _ => (p, q),
            };
            x - 2.0 * y
        },
        |q: f64, p: f64| (0..4)
            .map(|i| match i {
                0 => q,
                1..=2 => p * i as f64,
                _ => q * p,
            })
            .sum::<f64>(),
    );
}

#[test]
fn an_integer_that_selects_is_one_parameter() {
    let model = drift("|q, p| match n { 0 => q, 1 => p, 2..5 => q * p, _ => 0.0 }");
    assert_eq!(model.parameters.len(), 1);
    let shown = model.graph.display(model.drift);
    assert!(shown.contains("n"), "{shown}");
}

#[test]
fn lists_of_the_struct_are_iterated() {
    let closure = "|q: [f64; 3], _| q.iter().zip(&self.masses).map(|(q, m)| m * q * q).sum::<f64>()";
    let parameters = [("masses[0]", 1.0), ("masses[1]", 2.0), ("masses[2]", 3.0)];
    assert_eq!(value(closure, &[1.0, 2.0, 3.0], &[0.0; 3], &parameters), 1.0 + 8.0 + 27.0);
}

#[test]
fn the_graph_is_the_hand_built_one() {
    let mut model = drift("|q, p| 0.5 * a * (q * q + p * p) + (q - p).cos() / 3.0 + q.powi(n)");
    let [q, p] = [model.phase.q[0], model.phase.p[0]];
    let (a, n) = (model.parameters[0].symbol, model.parameters[1].symbol);
    let graph = &mut model.graph;
    let [q, p, a, n] = [q, p, a, n].map(|symbol| graph.symbol(symbol));
    let two = Rational::integer(2);
    let (qq, pp) = (graph.power(q, two), graph.power(p, two));
    let squares = graph.add(qq, pp);
    let product = graph.multiply(a, squares);
    let difference = graph.subtract(q, p);
    let cosine = graph.apply(Function::Cos, &[difference]);
    let power = graph.apply(Function::Powf, &[q, n]);
    let third = Rational::new(1, 3).unwrap();
    let expected =
        graph.linear_combination(&[(product, Rational::HALF), (cosine, third), (power, Rational::ONE)]);
    assert_eq!(model.drift, expected);
}

#[test]
fn known_conditions_leave_no_trace() {
    let mut model = drift("|q, p| if 1 < 2 && 0.5 <= 0.5 { q } else { p / 0.0 }");
    let q = model.phase.q[0];
    let expected = model.graph.symbol(q);
    assert_eq!(model.drift, expected);
}

#[test]
fn long_sums_are_linear_and_shallow() {
    let terms: Vec<String> = (0..1000).map(|i| format!("q * {i}.5")).collect();
    let closure = format!("|q, p| p + {}", terms.join(" + "));
    let expected: f64 = 1.7 + (0..1000).map(|i| 0.3 * (f64::from(i) + 0.5)).sum::<f64>();
    assert!((value(&closure, &[0.3], &[1.7], &[]) - expected).abs() < 1e-9 * expected);
}

/// Slopes are those of differences where the function is smooth, and limits where the chain rule gives 0
/// times infinity.
#[test]
fn slopes_have_their_limits() {
    // A function of x and y, a point where it is special, and its slopes there.
    let cases = [
        ("(x - 1.0).max(0.0).powf(1.5) + 0.0 * y", [1.0, 0.5], [0.0, 0.0]),
        ("(x - 1.0).max(0.0).powf(1.5) * y", [0.3, 0.5], [0.0, 0.0]),
        ("(y - x).max(0.0).powf(2.5)", [1.0, 1.0], [0.0, 0.0]),
        ("0.0_f64.max(1.0 - x).sqrt().powi(3) * y", [1.0, 0.5], [0.0, 0.0]),
        ("{ let u = (x - y).max(0.0); u * u.cbrt() }", [0.5, 0.5], [0.0, 0.0]),
        ("x * x.cbrt() * y", [0.0, 0.5], [0.0, 0.0]),
        ("x.powi(2) * x.cbrt() * x.abs().sqrt() * y", [0.0, 0.5], [0.0, 0.0]),
        ("x * x.sqrt() * x.cbrt() * y", [0.0, 0.5], [0.0, 0.0]),
        ("x.cbrt().powi(5) + y", [0.0, 0.5], [0.0, 1.0]),
        ("x * x.abs().powf(1.5) * y", [0.0, 0.5], [0.0, 0.0]),
        ("(x * x).powf(0.75) + y", [0.0, 0.5], [0.0, 1.0]),
        ("(2.0 * (x - y).powi(4)).powf(0.4)", [0.5, 0.5], [0.0, 0.0]),
        ("x.abs().powf(1.5) - y", [0.0, 0.5], [0.0, -1.0]),
        ("x.hypot(y).powi(2)", [0.0, 0.0], [0.0, 0.0]),
        ("x.hypot(y).powf(1.5)", [0.0, 0.0], [0.0, 0.0]),
        ("(x * x + 3.0 * y * y).powf(0.7)", [0.0, 0.0], [0.0, 0.0]),
        ("(6.0 * x.hypot(y)).cos()", [0.0, 0.0], [0.0, 0.0]),
        ("a * (a * (x * x + y * y).sqrt()).cosh() * x", [0.0, 0.0], [2.0, 0.0]),
        ("x.hypot(y) - x.hypot(y).sin()", [0.0, 0.0], [0.0, 0.0]),
        ("x.hypot(y) * x.hypot(y).sin() + y", [0.0, 0.0], [0.0, 1.0]),
        // Exponents that are parameters, a = 2.
        ("(x - 1.0).max(0.0).powf(a - 0.5) * y", [1.0, 0.5], [0.0, 0.0]),
        ("x.abs().powf(0.8 * a) + y", [0.0, 0.5], [0.0, 1.0]),
        ("(x * x).powf(0.4 * a) + y", [0.0, 0.5], [0.0, 1.0]),
        ("(x * x + y * y).powf(0.3 * a)", [0.0, 0.0], [0.0, 0.0]),
        ("x.hypot(y).powf(0.6 * a)", [0.0, 0.0], [0.0, 0.0]),
        ("x.hypot(y).hypot(a).powi(3)", [0.0, 0.0], [0.0, 0.0]),
    ];
    for (closure, special, expected) in cases {
        let mut model = drift(&format!("|[x, y], [u, v]| {closure} + 0.0 * (u + v)"));
        let (value, q) = (model.drift, model.phase.q.clone());
        let slopes: Vec<_> = q.iter().map(|&x| model.graph.derivative(value, x)).collect();
        let curvatures: Vec<_> = slopes.iter().map(|&slope| model.graph.hessian_entry(slope, q[0])).collect();
        let at = |roots: &[Expr], point: [f64; 2]| {
            let of = |symbol| q.iter().position(|&own| own == symbol).map_or(2.0, |i| point[i]);
            model.graph.evaluate(roots, &of)
        };
        assert_eq!(at(&slopes, special), expected, "{closure}");
        let curved = at(&curvatures, special);
        assert!(curved.iter().all(|entry| entry.is_finite()), "{closure}: {curved:?}");
        for [x, y] in [[1.7, 0.4], [0.3, 1.1], [2.2, 2.9]] {
            // With derivatives up to 1000 the difference is off by d², and by 1e-16 f / d in its rounding.
            let d = 1e-6;
            for (i, of) in [[d, 0.0], [0.0, d]].into_iter().enumerate() {
                let moved = |s: f64| [x + s * of[0], y + s * of[1]];
                let slope = |root| (at(&[root], moved(1.0))[0] - at(&[root], moved(-1.0))[0]) / (2.0 * d);
                let pairs = [(slopes[i], value), (curvatures[i], slopes[i])];
                for (derivative, of) in pairs.into_iter().take(2 - i) {
                    let (found, wanted) = (at(&[derivative], [x, y])[0], slope(of));
                    assert!(
                        (found - wanted).abs() < 1e-6 * (1.0 + wanted.abs()),
                        "{closure}: {found} {wanted}"
                    );
                }
            }
        }
    }
}
