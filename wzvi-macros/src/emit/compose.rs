//! Schemes that compose steps of other schemes, or flows. Tests: `tests/steps/composition.rs`.

use proc_macro2::TokenStream;
use quote::quote;
use syn::ItemStruct;

use super::discretized;
use crate::describe::Texts;
use crate::discretise::{Flows, Plans};
use crate::embedding::Embedding;

/// The structure that steps of `Verlet` exploit.
pub(super) fn structure(plans: &Plans) -> TokenStream {
    if plans.listed.iter().any(Embedding::keeps_constraints) && !plans.is_general_on_manifold {
        return quote!(__wzvi::compose::Nystrom);
    }
    let structure = match plans.flows {
        None => quote!(__wzvi::compose::General),
        Some(Flows { is_nystrom: false, .. }) => quote!(__wzvi::compose::Separable),
        Some(Flows { is_nystrom: true, .. }) => quote!(__wzvi::compose::Nystrom),
    };
    // Compositions alternate the parts of the drift, or compose steps of the whole.
    match plans.forms {
        Some(_) => quote!(__wzvi::compose::Parted<#structure>),
        None => structure,
    }
}

/// The schemes that compose others.
pub(super) fn emit(item: &ItemStruct, plans: &Plans, texts: &Texts) -> TokenStream {
    let mut generated = TokenStream::new();
    for embedding in &plans.listed {
        let steps = match (embedding, embedding.substeps().as_slice()) {
            (Embedding::GBaoab, _) => quote!(__wzvi::embedding::GBaoab),
            (thermostat, _) if thermostat.is_thermostat() => self::thermostat(thermostat),
            (Embedding::Rattle, _) if plans.is_general_on_manifold => {
                quote!(__wzvi::constraints::GeneralRattle)
            }
            (Embedding::Rattle, _) => quote!(__wzvi::compose::WholeOf<Self, __wzvi::embedding::Rattle>),
            (_, []) => continue,
            (_, [whole]) if whole == embedding => continue,
            // `Gauss<1>` is a step of `Midpoint`.
            (Embedding::Gauss(_), [whole]) => {
                let whole = whole.path(&quote!(__wzvi));
                quote!(<Self as __wzvi::Discretized<#whole>>::Scheme)
            }
            (_, parts) => {
                // Inside a thermostat, the inner scheme has the same name as outside.
                let own = if let Embedding::Isolated(inner) = embedding { inner } else { embedding };
                let whole = if let [whole] = parts { whole } else { own }.path(&quote!(__wzvi));
                quote!(__wzvi::compose::WholeOf<Self, #whole>)
            }
        };
        generated.extend(discretized(item, embedding, &steps, texts.of(embedding), None));
    }
    generated
}

/// The scheme of steps with O parts of a bath.
fn thermostat(embedding: &Embedding) -> TokenStream {
    let wzvi = quote!(__wzvi);
    let word = match embedding {
        Embedding::Thermostat(inner) => {
            let inner = inner.path(&wzvi);
            return quote!(__wzvi::bath::ThermostatSteps<__wzvi::bath::Isolated<#inner>>);
        }
        Embedding::Splitting(word) => word.types(&wzvi),
        word => word.path(&wzvi),
    };
    quote!(__wzvi::bath::Splitting<#word>)
}
