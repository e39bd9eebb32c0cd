//! The description of a library as JSON, for front ends and for people.

use serde_json::{Value, json};
use wzvi::plan::NoiseClass;

use crate::library::{Scheme, System};
use crate::settings::COMMON;
use crate::table::ABI;

/// An object with `abi`, `wzvi`, the version, and `systems`; each of these has `name`, `doc`, `fields` with
/// `name`, `type` and `doc`, `closures` with `key` and `text`, and `schemes`.
pub fn describe(systems: &[System]) -> String {
    let systems: Vec<_> = systems.iter().map(system).collect();
    json!({ "abi": ABI, "wzvi": env!("CARGO_PKG_VERSION"), "settings": COMMON, "systems": systems })
        .to_string()
}

fn system(system: &System) -> Value {
    let fields = system.fields.iter();
    let fields = fields.map(|field| json!({ "name": field.name, "type": field.ty, "doc": field.doc }));
    let closures = system.closures.iter().map(|(key, text)| json!({ "key": key, "text": text }));
    json!({
        "name": system.name,
        "doc": system.doc,
        "fields": fields.collect::<Vec<_>>(),
        "closures": closures.collect::<Vec<_>>(),
        "schemes": system.schemes.iter().map(scheme).collect::<Vec<_>>(),
    })
}

fn scheme(scheme: &Scheme) -> Value {
    let kinds = scheme.kinds.iter().map(|kind| (kind.name.to_owned(), json!(kind.settings)));
    json!({
        "name": scheme.name,
        "plan": scheme.plan.to_string(),
        "order": scheme.plan.order,
        "consistent": scheme.plan.consistent,
        "has_noise": scheme.plan.noise != NoiseClass::None,
        "has_clock": scheme.is_clocked,
        "equations": scheme.equations,
        "kinds": kinds.collect::<serde_json::Map<_, _>>(),
    })
}
