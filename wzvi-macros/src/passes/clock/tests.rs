//! Clocks and their rates against references, and against differences along the flow.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::collections::BTreeMap;

use super::clock;
use crate::choose::choose;
use crate::diagnostics::Diagnostics;
use crate::input;
use crate::lower::lower;
use crate::model::{Element, Form, Half, Index, Loop, Slot, System};
use crate::passes::collect::collect;
use crate::passes::friction::friction;
use crate::passes::unroll::unroll;
use crate::symbolic::{Expr, Symbol};

/// The fields, with their values.
const ITEM: &str = "struct System { k: f64, mu: f64, g: f64, w: f64, mass: Vec<f64>, gamma: f64 }";
const FIELDS: [(&str, f64); 5] = [("k", 1.3), ("mu", 0.01), ("g", 0.9), ("w", 0.4), ("gamma", 0.2)];
const MASSES: [f64; 5] = [3.0, 4.0, 5.0, 0.5, 1.5];

/// The system with its clock, or the messages.
fn derived(attribute: &str, form: Option<Form>) -> Result<System, String> {
    let mut diagnostics = Diagnostics::new();
    let system = derive(attribute, form, &mut diagnostics);
    match diagnostics.finish() {
        Ok(()) => Ok(system.unwrap()),
        Err(errors) => Err(errors.to_string()),
    }
}

fn derive(attribute: &str, form: Option<Form>, diagnostics: &mut Diagnostics) -> Option<System> {
    let container = input::read_struct(ITEM.parse().unwrap(), diagnostics)?;
    let mut declaration = input::read_attribute(attribute.parse().unwrap(), diagnostics)?;
    let phase_space = input::read_phase_space(&mut declaration, diagnostics)?;
    let mut system = lower(container, declaration, &phase_space, diagnostics)?;
    let listed: Vec<_> = system.embeddings.iter().map(|known| known.value.clone()).collect();
    system.form = form.unwrap_or(choose(&mut system, &listed).elements);
    unroll(&mut system);
    collect(&mut system, diagnostics);
    friction(&mut system, diagnostics);
    clock(&mut system, diagnostics);
    Some(system)
}

/// A state and the time.
struct At<'a> {
    q: &'a [f64],
    p: &'a [f64],
    t: f64,
}

/// The sum of elements in their loops.
fn value(system: &System, elements: &[Element], at: &At<'_>) -> f64 {
    let one = |element: &Element| in_loops(system, element, &element.loops, &mut BTreeMap::new(), at);
    elements.iter().map(one).sum()
}

fn in_loops(
    system: &System,
    element: &Element,
    loops: &[Loop],
    turns: &mut BTreeMap<u32, i128>,
    at: &At<'_>,
) -> f64 {
    let number = |index: &Index, turns: &BTreeMap<u32, i128>| {
        let of_size = index.at(turns).unwrap();
        of_size.as_integer().unwrap_or_else(|| panic!("{of_size:?}"))
    };
    if let Some((outer, inner)) = loops.split_first() {
        let mut sum = 0.0;
        for turn in number(&outer.start, turns)..number(&outer.end, turns) {
            turns.insert(outer.variable, turn);
            sum += in_loops(system, element, inner, turns, at);
        }
        turns.remove(&outer.variable);
        return sum;
    }
    let of_symbol = |symbol: Symbol| -> f64 {
        if symbol == system.t {
            return at.t;
        }
        let Some(local) = element.locals.iter().find(|local| local.symbol == symbol) else {
            let name = system.graph.symbol_name(symbol);
            return FIELDS.iter().find(|(known, _)| *known == name).unwrap_or_else(|| panic!("{name}")).1;
        };
        let place = |index: &Index| usize::try_from(number(index, turns)).unwrap();
        match &local.slot {
            Slot::State(Half::Coordinates, index) => at.q[place(index)],
            Slot::State(Half::Momenta, index) => at.p[place(index)],
            Slot::Entry(_, indices) => MASSES[place(&indices[0])],
            Slot::Collective(slot) => value(system, &system.collectives.of(*slot).elements, at),
            other => panic!("{other:?}"),
        }
    };
    let bounded = |expr: Expr| system.graph.evaluate_bounded(&[expr], &of_symbol)[0].value;
    bounded(element.value)
}

/// `Q` and `G`.
fn at(system: &System, at: &At<'_>) -> [f64; 2] {
    let clock = system.clock.as_ref().unwrap();
    [value(system, &clock.term.values, at), value(system, &clock.rate, at)]
}

/// `G` by differences of `ln Q` along the flow of the drift with forces and friction, whose velocities are
/// differences of the energy: both have relative errors near 1e-9 with these steps.
fn rate_by_differences(system: &System, here: &At<'_>) -> f64 {
    let degrees = here.q.len();
    let energy = |q: &[f64], p: &[f64]| value(system, &system.drift.values, &At { q, p, t: here.t });
    let slope = |i: usize, of_momentum: bool| {
        let difference = |h: f64| {
            let (mut q, mut p) = (here.q.to_vec(), here.p.to_vec());
            if of_momentum {
                p[i] += h
            } else {
                q[i] += h
            }
            energy(&q, &p)
        };
        let central = |h: f64| (difference(h) - difference(-h)) / (2.0 * h);
        (4.0 * central(1e-3) - central(2e-3)) / 3.0
    };
    let gamma = if system.conformal.is_some() { 0.2 } else { 0.0 };
    let velocity: Vec<f64> = (0..degrees).map(|i| slope(i, true)).collect();
    let force: Vec<f64> = (0..degrees).map(|i| -slope(i, false) - gamma * here.p[i]).collect();
    let log = |h: f64| {
        let moved = |x: &[f64], v: &[f64]| x.iter().zip(v).map(|(x, v)| x + h * v).collect::<Vec<f64>>();
        let (q, p) = (moved(here.q, &velocity), moved(here.p, &force));
        let clock = system.clock.as_ref().unwrap();
        value(system, &clock.term.values, &At { q: &q, p: &p, t: here.t + h }).ln()
    };
    let central = |h: f64| (log(h) - log(-h)) / (2.0 * h);
    -(4.0 * central(1e-3) - central(2e-3)) / 3.0
}

/// Checks the rate of a clock, and returns `Q`.
fn checked(attribute: &str, form: Option<Form>, q: &[f64], p: &[f64]) -> f64 {
    let system = derived(attribute, form).unwrap_or_else(|error| panic!("{attribute}: {error}"));
    let here = At { q, p, t: 0.3 };
    let [period, rate] = at(&system, &here);
    let expected = rate_by_differences(&system, &here);
    assert!((rate - expected).abs() < 1e-6 * (1.0 + expected.abs()), "{attribute}: {rate} {expected}");
    period
}

const KEPLER: &str = "drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) - 1.0 / (x * x + y * y).sqrt()";
const RESTRICTED: &str = "drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) + px * y - py * x \
    - (1.0 - mu) / ((x - mu).powi(2) + y * y).sqrt() - mu / ((x - mu + 1.0).powi(2) + y * y).sqrt()";
const BODIES: &str = "drift = |q: [[f64; 2]; 3], p: [[f64; 2]; 3]| \
    (0..3).map(|i| 0.5 * (p[i][0] * p[i][0] + p[i][1] * p[i][1]) / mass[i]).sum::<f64>() \
    - (0..3).map(|i| (0..i).map(|j| g * mass[i] * mass[j] \
        / ((q[i][0] - q[j][0]).powi(2) + (q[i][1] - q[j][1]).powi(2)).sqrt()).sum::<f64>()).sum::<f64>()";
const Q: [f64; 6] = [1.0, 3.0, -2.0, -1.0, 1.0, -1.2];
const P: [f64; 6] = [0.3, -0.2, 0.7, 0.5, -1.1, 0.4];

/// To 14 of the 34 digits, computed with mpmath from `tr((H_pp H_qq)²)^(-1/4)` and its derivative along the
/// flow.
#[test]
fn curvature_is_that_of_the_reference() {
    let rows = [
        (KEPLER, [0.3, 0.4], [-1.1, 0.7], [0.236_435_402_250_793_95, 0.3]),
        (RESTRICTED, [-0.95, 0.06], [0.2, -0.9], [0.130_393_004_601_569_85, -3.835_892_751_878_63]),
    ];
    for (drift, q, p, expected) in rows {
        let attribute = format!("{drift}, clock = curvature, embedding = Verlet");
        let system = derived(&attribute, None).unwrap();
        let found = at(&system, &At { q: &q, p: &p, t: 0.0 });
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-14 * expected.abs() * 10.0, "{drift}: {found} {expected}");
        }
    }
}

#[test]
fn text_is_in_distances() {
    let text = |attribute: &str| derived(attribute, None).unwrap().clock.unwrap().text;
    let drift = "drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) - k / x.hypot(y)";
    for drift in [drift, &drift.replace("x.hypot(y)", "(x * x + y * y).sqrt()")] {
        let text = text(&format!("{drift}, clock = curvature, embedding = Verlet"));
        assert!(text.starts_with("Clock\n  Q = r^(3/2)/(5^(1/4) √|k|)\n"), "{text}");
        assert!(text.contains("  G = -d ln Q/dt = -3 (x px + y py)/(2 r²)\n"), "{text}");
    }
    let in_space =
        "drift = |[x, y, z], [px, py, pz]| 0.5 * (px * px + py * py + pz * pz) - k / x.hypot(y).hypot(z)";
    let text = text(&format!("{in_space}, clock = curvature, embedding = Verlet"));
    assert!(text.starts_with("Clock\n  Q = r^(3/2)/(6^(1/4) √|k|)\n"), "{text}");
}

/// One distance, although the loops of `Q` and of `G` have variables of their own.
#[test]
fn text_of_pairs_is_in_distances() {
    let drift = BODIES.replace("[[f64; 2]; 3]", "&[[f64; 2]]").replace("(0..3)", "(0..q.len())");
    let attribute = format!("{drift}, clock = pairs, embedding = Verlet");
    let text = derived(&attribute, Some(Form::Loops)).unwrap().clock.unwrap().text;
    let sum = "[√5 |g| |mass[i]| |mass[j]| (1/mass[i] + 1/mass[j])/r³]";
    assert!(text.starts_with("Clock\n  Q = 1/√S1\n"), "{text}");
    assert!(text.contains(&format!("  S1 = Σ_(i=0..n - 1) Σ_(j=0..i - 1) {sum}\n")), "{text}");
    assert!(text.ends_with("  r = √((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)\n"), "{text}");
}

/// Differences of the energy and of `ln Q` know nothing of the compiler's derivatives.
#[test]
fn rates_are_those_along_the_flow() {
    use Form::{Loops, StraightLines};
    let with = |drift: &str, clock: &str| format!("{drift}, clock = {clock}, embedding = Verlet");
    let (q, p) = ([0.6, 0.5], [-0.4, 0.9]);
    for clock in [
        "curvature",
        "curvature(w)",
        "|[x, y], _| (x * x + y * y).powf(0.75)",
        "|[x, y], [px, _], t| (t * x + px * y).exp()",
    ] {
        checked(&with(KEPLER, clock), None, &q, &p);
        checked(&with(&format!("{KEPLER}, friction = gamma"), clock), None, &q, &p);
        checked(&with(RESTRICTED, clock), None, &q, &p);
    }
    let softened = KEPLER.replace("1.0 / (x * x", "1.0 / (0.04 + x * x");
    let as_sum = KEPLER.replace("- 1.0 /", "+ 0.1 * (x * x).powi(2) - 1.0 /");
    let coupled = KEPLER.replace("px * px", "px * px + 0.3 * px * py");
    let timed = as_sum.replace("0.1 *", "(0.1 + t * t) *").replace("py]|", "py], t|");
    for drift in [softened, as_sum, coupled, timed] {
        checked(&with(&drift, "curvature"), None, &q, &p);
    }
    let of_sites = [
        "curvature",
        "pairs",
        "|q, _| (0..3).map(|i| mass[i] * q[i][0] * q[i][0]).sum::<f64>()",
        "|q, p, t| (1.0 + t * (0..3).map(|i| q[i][0] * q[i][0]).sum::<f64>()).sqrt() * (p[1][0] - q[2][1]).exp()",
        "|q, _| { let mean = (0..3).map(|i| q[i][0]).sum::<f64>() / 3.0; \
            (1.0 + (0..3).map(|i| (q[i][0] - mean).powi(2)).sum::<f64>()).sqrt() }",
    ];
    for form in [StraightLines, Loops] {
        for clock in of_sites {
            checked(&with(BODIES, clock), Some(form), &Q, &P);
        }
    }
}

/// The softened distance and the general formula agree with second derivatives by differences.
#[test]
fn curvature_is_the_norm_of_second_derivatives() {
    let softened = KEPLER.replace("1.0 / (x * x", "1.0 / (0.04 + x * x");
    let as_sum = KEPLER.replace("- 1.0 /", "+ 0.1 * (x * x).powi(2) - 1.0 /");
    for drift in [KEPLER, &softened, &as_sum] {
        let system = derived(&format!("{drift}, clock = curvature(w), embedding = Verlet"), None).unwrap();
        let (q, p) = ([0.6, 0.5], [-0.4, 0.9]);
        let energy = |x: f64, y: f64| value(&system, &system.drift.values, &At { q: &[x, y], p: &p, t: 0.0 });
        let h = 1e-3;
        let [x, y] = q;
        let second = |dx: f64, dy: f64| {
            (energy(x + dx, y + dy) - 2.0 * energy(x, y) + energy(x - dx, y - dy)) / (h * h)
        };
        let (xx, yy) = (second(h, 0.0), second(0.0, h));
        let xy = (second(h, h) - second(h, -h)) / 4.0;
        let expected = (xx * xx + yy * yy + 2.0 * xy * xy + 0.4_f64.powi(4)).powf(-0.25);
        let [found, _] = at(&system, &At { q: &q, p: &p, t: 0.0 });
        // Differences of second order, with fourth derivatives near 100.
        assert!((found - expected).abs() < 1e-4 * expected, "{drift}: {found} {expected}");
    }
}

/// `√5 Σ g (m_i + m_j)/r³` for gravity, in both forms.
#[test]
fn pairs_follow_gravity() {
    let mut sum = 0.0;
    for i in 0..3 {
        for j in 0..i {
            let r = (Q[2 * i] - Q[2 * j]).hypot(Q[2 * i + 1] - Q[2 * j + 1]);
            sum += 5.0_f64.sqrt() * 0.9 * (MASSES[i] + MASSES[j]) / r.powi(3);
        }
    }
    for form in [Form::StraightLines, Form::Loops] {
        let period = checked(&format!("{BODIES}, clock = pairs, embedding = Verlet"), Some(form), &Q, &P);
        assert!((period - sum.powf(-0.5)).abs() < 1e-14 * period * 10.0, "{period}");
    }
}

/// Bonds of a chain in one dimension, and of any function of the distance.
#[test]
fn pairs_follow_bonds() {
    let chain = "drift = |q: [f64; 5], p: [f64; 5]| p.iter().map(|p| 0.5 * p * p).sum::<f64>() \
        + (1..5).map(|i| { let d = q[i] - q[i - 1]; 0.5 * d * d + 0.1 * d.powi(3) + 0.25 * d.powi(4) }).sum::<f64>()";
    let q = [0.0, 0.3, 1.1, 0.7, 1.9];
    let p = [0.2, -0.4, 0.1, 0.6, -0.5];
    let expected: f64 = (1..5)
        .map(|i| {
            let d: f64 = q[i] - q[i - 1];
            2.0 * (1.0 + 0.6 * d + 3.0 * d * d)
        })
        .sum();
    for form in [Form::StraightLines, Form::Loops] {
        let period = checked(&format!("{chain}, clock = pairs, embedding = Verlet"), Some(form), &q, &p);
        assert!((period - expected.powf(-0.5)).abs() < 1e-14 * period * 10.0, "{period}");
    }
    let yukawa = BODIES.replace(
        "/ ((q[i][0]",
        "* (-((q[i][0] - q[j][0]).powi(2) + (q[i][1] - q[j][1]).powi(2)).sqrt()).exp() / ((q[i][0]",
    );
    checked(&format!("{yukawa}, clock = pairs, embedding = Verlet"), Some(Form::Loops), &Q, &P);
}

/// A zero of the second derivatives is refused where it is found.
#[test]
fn zeros_ask_for_a_frequency() {
    let refused = |drift: &str, clock: &str| {
        derived(&format!("drift = {drift}, clock = {clock}, embedding = Verlet"), None)
            .err()
            .unwrap_or_default()
    };
    for drift in [
        "|q, p| 0.5 * p * p + 0.25 * q.powi(4)",
        "|q, p| 0.5 * p * p - k * q.cos()",
        "|q, p| 0.5 * p * p + 0.25 * q.powi(4) - 0.5 * k * q * q",
        "|[x, y], [px, py]| 0.5 * (px * px + py * py) - x.cos() - k * y.cos()",
    ] {
        assert!(refused(drift, "curvature").contains("curvature(w0)"), "{drift}");
        assert_eq!(refused(drift, "curvature(w)"), "", "{drift}");
    }
    for drift in [
        "|q, p| 0.5 * p * p + 0.5 * k * q * q",
        "|q, p| 0.5 * p * p + 1.0 / q",
        "|[x, y], [px, py]| 0.5 * (px * px + py * py + x * x + y * y) + x * x * y - y.powi(3) / 3.0",
    ] {
        assert_eq!(refused(drift, "curvature"), "", "{drift}");
    }
    assert!(refused("|q, p| 0.5 * p * p + k * q", "curvature").contains("constant steps are exact"));
}
