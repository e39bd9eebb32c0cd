//! Cases without messages, contrasted with cases that have one; the messages themselves are in
//! `tests/compiler/ui/messages`.

use proc_macro2::TokenStream;

use super::STRUCT;
use crate::diagnostics::Diagnostics;
use crate::input;

/// The messages about `attribute` on `item`.
fn messages(attribute: &str, item: &str) -> Vec<String> {
    let mut diagnostics = Diagnostics::new();
    let attribute: TokenStream = attribute.parse().unwrap();
    let system = input::read_struct(item.parse().unwrap(), &mut diagnostics);
    let declaration = input::read_attribute(attribute, &mut diagnostics);
    if let (Some(system), Some(mut declaration)) = (system, declaration)
        && let Some(phase_space) = input::read_phase_space(&mut declaration, &mut diagnostics)
    {
        let _ = crate::lower::lower(system, declaration, &phase_space, &mut diagnostics);
    }
    let found = diagnostics.errors().iter().map(ToString::to_string).collect();
    drop(diagnostics.finish());
    found
}

/// No message about an attribute.
#[track_caller]
fn assert_accepted(attribute: &str, item: &str) {
    let found = messages(attribute, item);
    assert!(found.is_empty(), "{attribute}\nfound {found:#?}");
}

#[test]
fn what_is_close_to_a_mistake_is_accepted() {
    let item = "struct Charged { q: f64, t: f64, mass: f64 }";
    assert_accepted("drift = |x, y| q * y / mass + self.t * x, embedding = Midpoint", item);
    let named = "drift = |q, p| p, invariant = [momentum = |q, p| p, |q, p| p * p], embedding = Midpoint";
    assert_accepted(named, STRUCT);
    // Neutral or correct names.
    for names in ["x, v", "phi, p_phi", "p, s", "_, p", "p, _", "psi, q", "p, psi"] {
        assert_accepted(&format!("drift = |{names}| 1.0, embedding = Midpoint"), STRUCT);
    }
}

#[test]
fn sums_in_sums() {
    let nested = |times: usize| {
        let line = "let a = (0..q.len()).map(|i| a * q[i] * p[i]).sum::<f64>();";
        format!(
            "drift = |q: &[f64], p: &[f64]| {{ let a = 1.0; {} a }}, embedding = Midpoint",
            line.repeat(times)
        )
    };
    assert_accepted(&nested(16), STRUCT);
    let found = messages(&nested(40), STRUCT);
    assert!(found.iter().any(|text| text.contains("nested more than 16 deep")), "{found:?}");
}

/// The left neighbour on a ring, in all forms of a state.
#[test]
fn rings_are_written_with_a_size_before_the_difference() {
    let on = |state: &str, size: &str, index: &str| {
        let bond = format!("0.5 * (q[i] - q[{index}]).powi(2)");
        let sum = format!("(0..{size}).map(|i| 0.5 * p[i] * p[i] + {bond}).sum::<f64>()");
        format!("drift = |q: {state}, p: {state}| {sum}, embedding = Midpoint")
    };
    for (state, size) in [("[f64; 4]", "4"), ("[f64; 40]", "40"), ("[f64; N]", "N"), ("&[f64]", "q.len()")] {
        for negative in ["(i - 1) % SIZE", "(i - 2) % SIZE", "i - 1"] {
            let found = messages(&on(state, size, &negative.replace("SIZE", size)), STRUCT);
            assert_eq!(found.len(), 1, "{state} {negative}: {found:?}");
            let remedy = match negative.trim_start_matches("(i - ").split_once(')') {
                Some((by, _)) => format!("write `(i + {size} - {by}) % {size}`"),
                None => "begin the loop later, or write `(i + n - 1) % n`".to_owned(),
            };
            assert!(found[0].contains(&remedy), "{state} {negative}: {found:?}");
        }
        for right in ["(i + SIZE - 1) % SIZE", "(i as i32 - 1).rem_euclid(SIZE as i32) as usize"] {
            assert_accepted(&on(state, size, &right.replace("SIZE", size)), STRUCT);
        }
        // Inside of a sum over the points before i there is no i = 0.
        let before = "(0..i).map(|j| q[j] * q[i - 1]).sum::<f64>()";
        let body = format!("(0..{size}).map(|i| 0.5 * p[i] * p[i] + {before}).sum::<f64>()");
        assert_accepted(&format!("drift = |q: {state}, p: {state}| {body}, embedding = Midpoint"), STRUCT);
    }
    let long = messages(&on("[f64; 4_000_000]", "4_000_000", "i + 1"), STRUCT);
    assert!(long[0].contains("it reaches 4000000"), "{long:?}");
}
