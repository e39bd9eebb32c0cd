//! Structs of the run time with the fields that differ from their usual values:
//! `Facts { noise: ..., ..usual }`.
//!
//! A misspelled field does not compile here. A test compares the fields with those of the run time.

use proc_macro2::TokenStream;
use quote::quote;

macro_rules! overrides {
    ($($(#[doc = $doc:literal])* $name:ident of $of:ident: $($field:ident)+;)+) => {$(
        $(#[doc = $doc])*
        #[derive(Default)]
        pub(crate) struct $name {
            $(pub(crate) $field: Option<TokenStream>,)+
        }

        impl $name {
            /// `usual` with the fields that are given.
            pub(crate) fn over(self, path: &TokenStream, usual: TokenStream) -> TokenStream {
                let mut fields = TokenStream::new();
                $(fields.extend(self.$field.map(|value| quote!($field: #value,)));)+
                if fields.is_empty() { usual } else { quote!(#path { #fields ..#usual }) }
            }
        }
    )+

        #[cfg(test)]
        const FIELDS: &[(&str, &[&str])] = &[$((stringify!($of), &[$(stringify!($field)),+])),+];
    };
}

overrides! {
    /// The facts of a system that do not depend on the scheme.
    FactOverrides of Facts: noise conserves_energy energy_jumps commuting has_weak_order_two is_damped has_pieces kind bath summands
        has_tiles has_pairs gathers has_one_velocity has_constant_curvature coupled_degrees collective_variables;
    /// Friction, forces and explicit time of a system.
    KindOverrides of Kind: is_conformal is_forced has_noise_forces reads_time;
    /// Friction of a bath.
    FrictionOverrides of Friction: is_heated is_matrix is_per_state has_diagonal_masses has_temperatures is_timed;
    /// The quadrature of steps in loops.
    QuadratureOverrides of Quadrature: unknowns remembers linearity;
}

/// `true` where it holds.
pub(crate) fn holds(statement: bool) -> Option<TokenStream> {
    statement.then(|| quote!(true))
}

#[cfg(test)]
mod tests {
    use super::FIELDS;

    /// The source of the run time that declares each struct.
    const SOURCES: [&str; 4] = ["plan.rs", "system.rs", "bath.rs", "elements/quadrature.rs"];

    #[test]
    fn the_run_time_has_these_fields() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../wzvi-runtime/src/scheme/");
        for ((name, fields), source) in FIELDS.iter().zip(SOURCES) {
            let text = std::fs::read_to_string(format!("{folder}{source}")).unwrap_or_default();
            let body = text
                .split_once(&format!("pub struct {name} {{"))
                .and_then(|(_, rest)| rest.split_once("\n}"));
            let (body, _) = body.unwrap_or_default();
            for field in *fields {
                assert!(
                    body.contains(&format!("pub {field}: ")),
                    "`{name}` of the run time has no field `{field}`"
                );
            }
        }
    }
}
