//! Parameters that the Hamiltonian divides by are not zero: what cancels, and what does not.

#![allow(clippy::unwrap_used, reason = "a test may stop")]

use super::expand;

/// The lines of the equations, without indentation.
fn lines(attribute: &str, item: &str) -> Vec<String> {
    let code = expand(attribute.parse().unwrap(), item.parse().unwrap()).to_string();
    assert!(!code.contains("compile_error"), "{attribute}: {code}");
    let start = code.find("EQUATIONS").unwrap();
    let text = code[start..].split('"').nth(1).unwrap();
    text.split("\\n").map(|line| line.trim().to_owned()).collect()
}

#[track_caller]
fn has(attribute: &str, item: &str, expected: &[&str]) {
    let lines = lines(&format!("{attribute}, embedding = Midpoint"), item);
    for line in expected {
        assert!(lines.iter().any(|known| known == line), "no line {line:?} in\n{}", lines.join("\n"));
    }
}

#[test]
fn divisors_cancel_in_what_is_derived() {
    has(
        "drift = |q, p| p * p / (2.0 * m) + 0.5 * m * omega * omega * q * q",
        "struct S { m: f64, omega: f64 }",
        &["H0 = p²/(2 m) + m omega² q²/2", "H_pp(H_q,H_q) = m omega^4 q²", "H_qq(H_p,H_p) = omega² p²/m"],
    );
    // Sums of parameters.
    has(
        "drift = |q, p| p * p / (2.0 * (m + n)) + 0.5 * (m + n) * q * q, noise = |q, p| q / (m + n)",
        "struct S { m: f64, n: f64 }",
        &["H0 = p²/(2 (m + n)) + q² (m + n)/2", "{H1, H0} = -p/(m + n)²"],
    );
    // In what the user wrote, too, where the parameter is in another denominator.
    has(
        "drift = |q, p| p * p / (2.0 * m) + m * m * q * q / m",
        "struct S { m: f64 }",
        &["H0 = p²/(2 m) + m q²"],
    );
    has(
        "drift = |q, p| p * p / (2.0 * m) + q * q, force = |q, p| k * m / m, friction = gamma",
        "struct S { m: f64, k: f64, gamma: f64 }",
        &["F0 = k"],
    );
}

#[test]
fn entries_of_lists_cancel() {
    let kinetic = "p.iter().zip(mass).map(|(p, m)| 0.5 * p * p / m).sum::<f64>()";
    let bonds = "(1..q.len()).map(|i| mass[i] * mass[i - 1] * (q[i] - q[i - 1]).powi(2)).sum::<f64>()";
    let chain = format!("drift = |q: &[f64], p: &[f64]| {kinetic} + {bonds}");
    let text = |attribute: &str| {
        lines(&format!("{attribute}, embedding = DeltaPlus"), "struct S { mass: Vec<f64>, a: f64 }")
            .join("\n")
    };
    let plain = text(&chain);
    for line in ["[2 mass[i] p[i + 1] (q[i + 1] - q[i])]", "[4 mass[i + 1]² mass[i] (q[i + 1] - q[i])²]"] {
        assert!(plain.contains(line), "no {line} in {plain}");
    }
    // A force that divides by an entry, of which it is not known that the drift divides by it, too.
    let other =
        text(&format!("{chain}, force = |q: &[f64], p: &[f64]| (0..q.len()).map(|i| mass[i] * a / mass[i])"));
    assert!(other.contains("[mass[i] a δq[i]/mass[i]]"), "{other}");
    assert!(other.contains("a mass[i] p[i]/mass[i]²"), "{other}");
}

#[test]
fn divisors_that_may_be_zero_stay() {
    // The only division: without it the Hamiltonian would have a value at zero.
    has("drift = |q, p| 0.5 * p * p + m * m * q * q / m", "struct S { m: f64 }", &["H0 = p²/2 + m² q²/m"]);
    // A branch that may not be taken.
    has(
        "drift = |q, p| 0.5 * p * p + if a > 0.0 { q * q / a } else { q * q }, force = |q, p| k * a / a",
        "struct S { a: f64, k: f64 }",
        &["F0 = a k/a"],
    );
    // Finite at zero.
    has(
        "drift = |q, p| 0.5 * p * p + (-q * q / a).exp() + 1.0 / (1.0 + 1.0 / b), force = |q, p| k * a * b / (a * b)",
        "struct S { a: f64, b: f64, k: f64 }",
        &["F0 = a b k/(a b)"],
    );
    // Other terms than the drift.
    has(
        "drift = |q, p| 0.5 * p * p + q * q, noise = |q, p| s * q / a, force = |q, p| k * a / a",
        "struct S { a: f64, s: f64, k: f64 }",
        &["F0 = a k/a"],
    );
    // A loop that may have no turn, and another division.
    has(
        "drift = |q: &[f64], p: &[f64]| 0.5 * p[0] * p[0] + (1..q.len()).map(|i| q[i] * q[i] / a).sum::<f64>(), \
         force = |q: &[f64], p: &[f64]| (0..q.len()).map(|i| k * a / a)",
        "struct S { a: f64, k: f64 }",
        &["F0 · δq = Σ_(i=0..n - 1) [a k δq[i]/a]"],
    );
}
