//! What closures mean.

use super::{drift, same_as_rust, value};
use crate::symbolic::{Function, Rational};

/// One degree of freedom, at (0.3, 1.7), against `rustc`.
macro_rules! check {
    ($a:ident, $sigma:ident; $($closure:expr),* $(,)?) => {
        $( same_as_rust!($closure, [0.3], [1.7], { $a = 1.25, $sigma = 0.5 }); )*
    };
}

#[test]
fn arithmetic_and_precedence() {
    check!(a, sigma;
        |q, p| 0.5 * a * (q * q + p * p),
        |q, p| q - p - a,
        |q, p| q / p / a * sigma - -q,
        |q, p| 1e-3 * q + 2_000.5 * p + 2f64,
        |q: f64, p: f64| { p * p / 2. + (1.0 - (q).cos()) },
        |_, p| p,
        |q, _| q,
    );
}

#[test]
fn functions_in_method_and_path_form() {
    check!(a, sigma;
        |q: f64, p: f64| q.powi(3) + p.powi(-2) + q.powf(1.5) + p.sqrt().cbrt().recip(),
        |q: f64, p: f64| q.exp()
            + p.exp2()
            + q.exp_m1()
            + p.ln()
            + q.ln_1p()
            + p.log(3.0)
            + p.log2()
            + p.log10(),
        |q: f64, p: f64| q.sin()
            + p.cos()
            + q.tan()
            + q.asin()
            + q.acos()
            + p.atan()
            + q.atan2(p)
            + q.hypot(p),
        |q: f64, p: f64| q.sinh() + p.cosh() + q.tanh() + q.asinh() + p.acosh() + q.atanh(),
        |q: f64, p: f64| q.abs() + p.signum() + q.min(p) + q.max(a) + p.clamp(0.0, 1.0) + q.mul_add(p, a),
        |q: f64, p: f64| q.to_radians() + p.to_degrees(),
        |q, p| f64::sin(q) + f64::powi(p, 2) + std::primitive::f64::hypot(q, p) + f64::max(q, a),
        |q: f64, p: f64| {
            let (s, c) = q.sin_cos();
            s * p.sin_cos().1 + c
        },
    );
}

#[test]
fn bindings_closures_and_branches() {
    check!(a, sigma;
        |q, p| {
            let q = q * 2.0;
            let r: f64 = q + p;
            r * r
        },
        |q, p| {
            let v = |x: f64, (y, z): (f64, f64)| x * y + z;
            v(q, (p, a)) + v(p, (a, q))
        },
        |q, p| {
            let a = 3.0;
            a * q * p
        },
        |q, p| if q > p && !(p == 0.0) || q == p {
            q
        } else if q <= 0.3 {
            p * 2.0
        } else {
            a
        },
        |q, p| {
            let (x, y) = if q != 0.3 { (q, p) } else { (p, q) };
            x - 2.0 * y
        },
        |q, p| {
            let mut s = 0.0;
            for i in 1..=3 {
                s += q * i as f64;
                s *= 1.5;
            }
            s - p
        },
        |q, p| {
            let mut f = 0.0;
            let g = move |x: f64| x + f;
            f = 1.0;
            g(q) + p + f
        },
        |q, p| {
            let [x, .., z] = [q, a, p];
            x * 2.0 + z
        },
        |q, p| {
            const K: f64 = 2.5;
            K * q + if true { p } else { q }
        },
        |q, p| {
            let r = &q;
            *r * p
        },
    );
}

#[test]
fn integers_and_iterators() {
    check!(a, sigma;
        |q, p| (0..4).map(|i| q * (i * i % 3 + 7 / 2) as f64).sum::<f64>() + p,
        |q, p| (1..=3).rev().skip(1).step_by(1).map(|i| p + f64::from(i)).product::<f64>() * q,
        |q, p| [q, p, a].iter().zip([1.0, 2.0, 3.0]).map(|(x, c)| x * c).sum(),
        |q, p| [q, p, a].windows(2).map(|w| (w[1] - w[0]).powi(2)).sum::<f64>(),
        |q, p| [q, p].iter().copied().enumerate().fold(a, |acc, (i, x)| acc * x + i as f64),
        |q, p| [q, p].iter().chain(&[a]).cloned().map(f64::sin).sum::<f64>(),
        |q, p| (0..6).filter(|i| i % 2 == 0).map(|i| q.powi(i) * p).sum(),
        |q, p| (0..2)
            .flat_map(|i| (0..2).map(move |j| (i, j)))
            .map(|(i, j)| q * i as f64 + p * j as f64)
            .sum(),
        |q, p| (0..3).zip(1..).map(|(i, j)| q * (i * j) as f64 + p).sum(),
        |q, p| {
            let v = [q, p, a];
            v[1..].iter().sum::<f64>() + v.len() as f64 + v[(1 + 2) % 3]
        },
        |q, p| {
            let v: Vec<f64> = (0..3).map(|i| q + i as f64).collect();
            v[2] * p
        },
        |q, p| {
            let z = [0.5; 3];
            z.map(|x| x * q).iter().sum::<f64>() + p
        },
    );
}

#[test]
fn shapes_of_phase_space() {
    let named = value("|[x, y], [px, py]| x * py - y * px", &[1.0, 2.0], &[3.0, 5.0], &[]);
    assert_eq!(named, -1.0);
    let indexed = "|q: [f64; 3], p: [f64; 3]| (0..3).map(|i| q[(i + 1) % 3] * p[i]).sum::<f64>()";
    assert_eq!(value(indexed, &[1.0, 2.0, 3.0], &[1.0, 10.0, 100.0], &[]), 2.0 + 30.0 + 100.0);
    let points = "|q: [[f64; 2]; 2], _| q[0][1] + 10.0 * q[1][0]";
    assert_eq!(value(points, &[1.0, 2.0, 3.0, 4.0], &[0.0; 4], &[]), 32.0);
    let time = "|q, p, t| q * p * t";
    assert_eq!(value(time, &[2.0], &[4.0], &[]), 6.0);
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
