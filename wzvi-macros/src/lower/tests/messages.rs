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
