//! The identity of a run as names and texts, so that differences can be listed.

use std::fmt::{self, Write};

use crate::algebra::state::{State, Vector};
use crate::ground::checksum::Checksum;
use crate::ground::names::short_name;
use crate::scheme::system::{Discretized, Hamiltonian, PreparedOf};
use crate::trajectory::checkpoint::Difference;
use crate::trajectory::recording::Recording;
use crate::trajectory::retry::Retry;
use crate::trajectory::section::Sections;

/// Names and values.
pub(crate) type Fields = Vec<(String, String)>;

/// The settings of a path, each of which the user knows.
pub(super) fn settings(recording: &Recording, retry: Retry, is_compensated: bool) -> Fields {
    let mut fields = Fields::new();
    let mut set = |name: &str, value: String| fields.push((name.to_owned(), value));
    set("record_every", recording.every.to_string());
    if !recording.times.is_empty() {
        set("record_at (checksum)", checksum(recording.times.iter().copied().map(f64::to_bits)));
    }
    set("the halvings allowed", retry.most().to_string());
    set("compensated summation", is_compensated.to_string());
    fields
}

/// The sections of a run.
pub(crate) fn sections<V>(sections: &Sections<'_, V>, start: &State<V>) -> Fields {
    let mut fields = Fields::new();
    if !sections.is_empty() {
        fields.push(("the sections".to_owned(), sections.in_words()));
        let values = sections.values(start).into_iter().map(f64::to_bits);
        fields.push(("what the sections are at the start (checksum)".to_owned(), checksum(values)));
    }
    fields
}

/// The fields that identify a step: the version of wzvi, the system, the scheme, their sizes and the step
/// size.
pub(super) fn scheme<H: Hamiltonian, E>(system: &H, degrees: usize, h: f64) -> Fields {
    scheme_of([short_name::<H>(), short_name::<E>()], [degrees, system.noises()], h)
}

fn scheme_of([system, scheme]: [String; 2], [degrees, noises]: [usize; 2], h: f64) -> Fields {
    let fields = [
        ("the version of wzvi", env!("CARGO_PKG_VERSION").to_owned()),
        ("the system", system),
        ("the scheme", scheme),
        ("the number of degrees of freedom", degrees.to_string()),
        ("the number of noises", noises.to_string()),
        ("the step size", format!("{h:?}")),
    ];
    fields.map(|(name, value)| (name.to_owned(), value)).into()
}

/// The parameters that the system names.
pub(super) fn parameters<H: Hamiltonian>(system: &H) -> Fields {
    let mut fields = Fields::new();
    for index in 0..MOST_PARAMETERS {
        let Some((name, value)) = system.parameter(index) else { break };
        fields.push((format!("the parameter {name}"), format!("{value:?}")));
    }
    fields
}

/// Parameters that a file names; the others show in the checksums.
const MOST_PARAMETERS: usize = 64;

/// Checksums of internal data: what the compiler derived, what is computed once from
/// parameters and step size, and the Hamiltonians at the start.
pub(super) fn derived<H: Discretized<E>, E>(
    system: &H,
    prepared: &PreparedOf<H, E>,
    start: &State<H::Vector>,
) -> Fields {
    let mut constants = Checksum::default();
    // Numbers are written exactly, and taking them in cannot fail.
    let _ = write!(TextChecksum(&mut constants), "{prepared:?}");
    let mut equations = Checksum::default();
    equations.add(H::EQUATIONS.as_bytes());
    vec![
        ("the derivation (checksum)".to_owned(), format!("{equations:?}")),
        (CONSTANTS.to_owned(), format!("{constants:?}")),
        (forces_at("start"), forces(system, start)),
    ]
}

const CONSTANTS: &str = "what the step computes once from the parameters (checksum)";

pub(super) fn forces_at(place: &str) -> String {
    format!("what energies and forces are at the {place} (checksum)")
}

/// The checksum of the energy, of its gradient, and of that of all noises at a state, each with a weight of
/// its own: it tells parameters apart that matter there.
pub(super) fn forces<H: Hamiltonian>(system: &H, state: &State<H::Vector>) -> String {
    let mut checksum = Checksum::default();
    let (q, p) = (state.q.components(), state.p.components());
    add_numbers(&mut checksum, &[system.evaluate(0, q, p, state.t)]);
    let mut gradient = system.energy_gradient(state);
    add_numbers(&mut checksum, gradient.q.components());
    add_numbers(&mut checksum, gradient.p.components());
    if system.noises() > 0 {
        system.differentiate_noises(&weights(system.noises()), state, &mut gradient);
        add_numbers(&mut checksum, gradient.q.components());
        add_numbers(&mut checksum, gradient.p.components());
    }
    let force = gradient.q.components_mut();
    system.force(q, p, state.t, force);
    if has_any(force) || H::KIND.is_conformal {
        add_numbers(&mut checksum, force);
        add_numbers(&mut checksum, &[system.friction_rate()]);
    }
    format!("{checksum:?}")
}

// Loops over numbers alone, which are compiled once for all systems.

fn add_numbers(checksum: &mut Checksum, numbers: &[f64]) {
    numbers.iter().for_each(|number| checksum.add(&number.to_bits().to_le_bytes()));
}

/// A weight for each noise.
fn weights(noises: usize) -> Vec<f64> {
    (0..noises).map(|k| 1.0 + 1.0 / (2.0 + k as f64)).collect()
}

/// Whether a number is not zero.
fn has_any(force: &[f64]) -> bool {
    force.iter().any(|force| *force != 0.0)
}

/// The checksum of several words.
pub(crate) fn checksum(words: impl IntoIterator<Item = u64>) -> String {
    let mut checksum = Checksum::default();
    words.into_iter().for_each(|word| checksum.add(&word.to_le_bytes()));
    format!("{checksum:?}")
}

/// Text into a checksum, without holding it.
struct TextChecksum<'c>(&'c mut Checksum);

impl Write for TextChecksum<'_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.add(text.as_bytes());
        Ok(())
    }
}

/// The differences of two lists of fields, in the order of `run`.
pub(super) fn differences(checkpoint: &Fields, run: &Fields) -> Vec<Difference> {
    let value = |fields: &Fields, name: &str| {
        fields.iter().find(|(field, _)| field == name).map(|(_, value)| value.clone())
    };
    let only_there = checkpoint.iter().filter(|(name, _)| value(run, name).is_none());
    let names = run.iter().chain(only_there).map(|(name, _)| name);
    names
        .map(|name| Difference {
            field: name.clone(),
            checkpoint: value(checkpoint, name),
            run: value(run, name),
        })
        .filter(|difference| difference.checkpoint != difference.run)
        .collect()
}

/// The differences of two first states of `d` degrees of freedom, bit by bit.
pub(super) fn start_differences(d: usize, checkpoint: &[u64], run: &[u64]) -> Vec<Difference> {
    let show = |word: Option<&u64>| word.map(|word| format!("{:?}", f64::from_bits(*word)));
    (0..checkpoint.len().max(run.len()))
        .map(|i| (i, checkpoint.get(i), run.get(i)))
        .filter(|(_, there, here)| there != here)
        .map(|(i, there, here)| {
            let component = match i.checked_sub(1) {
                None => "t".to_owned(),
                Some(i) if i < d => format!("q[{i}]"),
                Some(i) => format!("p[{}]", i - d),
            };
            Difference {
                field: format!("{component} of the start"),
                checkpoint: show(there),
                run: show(here),
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::differences;

    #[test]
    fn differences_go_both_ways() {
        let fields = |pairs: &[(&str, &str)]| {
            pairs.iter().map(|(name, value)| (name.to_string(), value.to_string())).collect()
        };
        let found =
            differences(&fields(&[("a", "1"), ("b", "2")]), &fields(&[("c", "3"), ("a", "1"), ("b", "4")]));
        let found: Vec<String> = found.iter().map(ToString::to_string).collect();
        assert_eq!(found, ["c is not set there and 3 here", "b is 2 there and 4 here"]);
        let found = differences(&fields(&[("b", "2")]), &fields(&[]));
        assert_eq!(found[0].to_string(), "b is 2 there and not set here");
    }
}
