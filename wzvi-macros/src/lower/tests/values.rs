//! The values of closures in the compiler; their agreement with `rustc` is tested in `tests/steps/values.rs`.

use super::{drift, same_as_rust, value};
use crate::symbolic::{Function, Rational};

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
