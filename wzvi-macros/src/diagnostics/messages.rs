//! The messages about declarations: the struct, the attribute and the phase space. One function per mistake.

use std::fmt::Display;

use proc_macro2::{Ident, Span, TokenStream};
use quote::ToTokens;
use syn::{Error, Item};

use super::closest;

const KEYS: &str = "`drift`, `noise`, `force`, `noise_force`, `friction`, `damping`, `temperature`, `embedding`, `invariant` \
                    and `crate`";
const SCHEMES: &str = "`DeltaPlus`, `Midpoint`, `DeltaMinus`, `Lambda<N, D>`, `Mixed<Drift, Noise>`, `Verlet`, `Gauss<S>`, \
                       `Corrected<E>`, `Uncorrected<E>`, and, with friction, `Baoab`, `Obabo`, `Gjf`, `GjI` and `Thermostat<E>`";
const PATTERNS: &str = "supported are `|q, p|`, `|[x, y], [px, py]|` and `|q: [f64; 3], p: [f64; 3]|`, each with \
                        time as an optional third parameter";

pub(super) fn at(tokens: impl ToTokens, message: impl Display) -> Error {
    Error::new_spanned(tokens, message)
}

/// `text`, and what may have been meant.
pub(super) fn suggest(text: String, suggestion: Option<&str>) -> String {
    match suggestion {
        Some(suggestion) => format!("{text}; did you mean `{suggestion}`?"),
        None => text,
    }
}

pub(crate) fn nested_too_deeply(token: impl ToTokens) -> Error {
    at(token, "this is nested too deeply to compile; name parts of the expression with `let`")
}

pub(crate) fn not_a_struct(item: &Item) -> Error {
    let message = "`#[hamiltonian]` goes on a struct, whose fields are the parameters of the system";
    match item {
        Item::Enum(item) => at(item.enum_token, message),
        Item::Union(item) => at(item.union_token, message),
        Item::Fn(item) => at(&item.sig, message),
        other => at(other, message),
    }
}

pub(crate) fn not_a_function(item: &Item) -> Error {
    at(item, "`#[hamiltonian_fn]` goes on a function, or on the `impl` of a struct for its methods")
}

pub(crate) fn methods_of_trait(path: impl ToTokens) -> Error {
    at(path, "`#[hamiltonian_fn]` goes on an `impl` of the struct itself, not of a trait")
}

pub(crate) fn generic_function(parameter: impl ToTokens) -> Error {
    at(
        parameter,
        "a function of Hamiltonians takes numbers, arrays and slices: it has no generic parameters; the length of a slice \
         is `x.len()`",
    )
}

pub(crate) fn special_function(found: impl ToTokens) -> Error {
    at(found, "a function of Hamiltonians is a plain function of its arguments, or takes `&self`")
}

pub(crate) fn relative_constant(path: impl ToTokens) -> Error {
    at(
        path,
        "the body of this function is compiled where it is called, and this name may mean something else there: name the \
         constant from a root, as in `crate::units::KB` or `std::f64::consts::PI`, declare it inside with `const`, or pass it",
    )
}

pub(crate) fn recursion(call: impl ToTokens) -> Error {
    at(
        call,
        "this function calls itself: its derivative would never end; write the sum or product with an iterator",
    )
}

pub(crate) fn expected_key(tokens: TokenStream) -> Error {
    at(tokens, format!("expected `key = value`; the keys are {KEYS}"))
}

/// The key that `key` may stand for.
pub(crate) fn intended_key(key: &syn::Ident) -> Option<&'static str> {
    let key = key.to_string();
    let keys = [
        "drift",
        "noise",
        "force",
        "noise_force",
        "friction",
        "damping",
        "temperature",
        "embedding",
        "invariant",
        "crate",
    ];
    closest(&key, keys).or_else(|| synonym(&key))
}

pub(crate) fn unknown_key(key: &syn::Ident) -> Error {
    if is_of_ito(key) {
        return at(key, STRATONOVICH);
    }
    let suggestion = intended_key(key);
    at(key, suggest(format!("unknown key `{key}`; the keys are {KEYS}"), suggestion))
}

const STRATONOVICH: &str = "noises are in the sense of Stratonovich; an equation of Ito, `dX = a dt + Σ_k b_k dW_k`, has the Stratonovich drift \
                            `a - ½ Σ_k (∂b_k/∂X) b_k`: see \"From Ito to Stratonovich\" in docs/guide/noise.md";

/// Whether a name asks for another sense of the stochastic integral, or for a scheme that has it.
fn is_of_ito(name: &syn::Ident) -> bool {
    let name = name.to_string().to_lowercase();
    ["ito", "itô", "stratonovich", "eulermaruyama", "milstein", "interpretation", "calculus"]
        .contains(&name.as_str())
}

/// What other texts call the same thing.
fn synonym(key: &str) -> Option<&'static str> {
    match key {
        "hamiltonian" | "energy" | "h" | "H" | "h0" | "H0" => Some("drift"),
        "diffusion" | "stochastic" => Some("noise"),
        "scheme" | "schemes" | "method" | "integrator" | "quadrature" => Some("embedding"),
        "integral" | "first_integral" | "conserved" | "casimir" => Some("invariant"),
        _ => None,
    }
}

pub(crate) fn unknown_strategy(name: &syn::Ident) -> Error {
    at(name, format!("unknown strategy `{name}`; there are `inline` and `sweep`"))
}

pub(crate) fn duplicate_key(key: &syn::Ident) -> Error {
    at(key, format!("`{key}` is given twice; merge the two"))
}

pub(crate) fn friction_and_damping(key: &syn::Ident) -> Error {
    at(key, "`friction` (rates, 1/time) and `damping` (a matrix, mass/time) say the same: keep one of them")
}

pub(crate) fn missing_value(key: &syn::Ident) -> Error {
    at(key, format!("`{key} =` has no value"))
}

pub(crate) fn missing_key(key: &str) -> Error {
    let example = match key {
        "drift" => "drift = |q, p| 0.5 * p * p + 0.5 * q * q",
        _ => "embedding = Midpoint",
    };
    Error::new(Span::call_site(), format!("`{key}` is missing; for example `{example}`"))
}

pub(crate) fn unexpected_after_value(tokens: TokenStream) -> Error {
    at(tokens, format!("expected `,` and the next `key = value`; the keys are {KEYS}"))
}

pub(crate) fn missing_comma(key: &syn::Ident) -> Error {
    at(key, format!("expected `,` before `{key}`"))
}

pub(crate) fn not_a_path(found: impl ToTokens) -> Error {
    at(found, "expected the path of the crate `wzvi`, such as `crate = ::wzvi`")
}

pub(crate) fn empty_list(key: &syn::Ident, list: &TokenStream) -> Error {
    let remedy = match key.to_string().as_str() {
        "embedding" => format!("list at least one scheme of {SCHEMES}"),
        key => format!("leave `{key}` out if there is none"),
    };
    at(list, format!("this list is empty; {remedy}"))
}

pub(crate) fn not_a_closure(found: impl ToTokens) -> Error {
    at(found, "expected a closure over coordinates and momenta, such as `|q, p| 0.5 * p * p`")
}

pub(crate) fn async_closure(token: TokenStream) -> Error {
    at(token, "a Hamiltonian is a function of the state: it cannot be `async`")
}

pub(crate) fn family_in_list(tokens: TokenStream) -> Error {
    at(
        tokens,
        "a family of noises beside others stands in brackets of its own: `noise = [[|q, p, k| ...; N], |q, p| ...]`",
    )
}

pub(crate) fn parts_of_drift(brackets: impl ToTokens) -> Error {
    at(brackets, "a drift is one Hamiltonian, or two that take turns: `drift = [|q, p| ..., |q, p| ...]`")
}

pub(crate) fn family_of_invariants(count: impl ToTokens) -> Error {
    at(count, "first integrals are listed one by one: `invariant = [|q, p| ..., |q, p| ...]`")
}

pub(crate) fn name_of_other(name: &Ident) -> Error {
    at(
        name,
        "first integrals have names, `invariant = [energy = |q, p| ...]`, and no other Hamiltonians: leave it out",
    )
}

pub(crate) fn not_a_scheme(found: impl ToTokens) -> Error {
    at(found, format!("expected an embedding; there are {SCHEMES}"))
}

pub(crate) fn unknown_embedding(name: &syn::Ident) -> Error {
    if is_of_ito(name) {
        return at(name, format!("there is no embedding `{name}`: {STRATONOVICH}"));
    }
    let names = [
        "DeltaPlus",
        "Midpoint",
        "DeltaMinus",
        "Lambda",
        "Mixed",
        "Verlet",
        "Gauss",
        "Corrected",
        "Uncorrected",
        "Baoab",
        "Obabo",
        "Gjf",
        "GjI",
        "Thermostat",
    ];
    let suggestion = scheme_synonym(&name.to_string()).or_else(|| closest(&name.to_string(), names));
    at(name, suggest(format!("unknown embedding `{name}`; there are {SCHEMES}"), suggestion))
}

/// More stages than there are coefficients for.
pub(crate) fn gauss_stages(found: impl ToTokens) -> Error {
    at(found, "`Gauss<S>` has 1 to 16 stages; `Gauss<1>` is `Midpoint`")
}

/// A composition is not listed, but its base is.
pub(crate) fn composed(found: impl ToTokens, base: &syn::Type) -> Error {
    let base = base.to_token_stream();
    at(found, format!("compositions are not listed: list `{base}`, and its compositions are there"))
}

/// What other texts call the same scheme.
fn scheme_synonym(name: &str) -> Option<&'static str> {
    Some(match name {
        "ImplicitMidpoint" | "MidPoint" | "ImplicitMidpointRule" => "Midpoint",
        "SymplecticEuler" | "SymplecticEulerA" | "SemiImplicitEuler" | "EulerA" => "DeltaPlus",
        "SymplecticEulerB" | "EulerB" => "DeltaMinus",
        "Langevin" | "BAOAB" => "Baoab",
        "OBABO" => "Obabo",
        "GJF" => "Gjf",
        "GJI" => "GjI",
        _ => return None,
    })
}

pub(crate) fn duplicate_embedding(found: impl ToTokens, embedding: &impl Display) -> Error {
    at(found, format!("`{embedding}` is listed twice; once is enough"))
}

pub(crate) fn scheme_arguments(found: impl ToTokens, example: &str) -> Error {
    at(found, format!("wrong generic arguments; write it as in `{example}`"))
}

pub(crate) fn wrapper_inside(found: impl ToTokens) -> Error {
    at(
        found,
        "`Corrected` and `Uncorrected` go around a whole scheme: `Corrected<Mixed<Midpoint, DeltaPlus>>`, \
         never inside another",
    )
}

pub(crate) fn thermostat_inside(found: impl ToTokens) -> Error {
    at(
        found,
        "a thermostat goes around a scheme that is none: `Thermostat<Midpoint>`, `Thermostat<Gauss<2>>`",
    )
}

pub(crate) fn mixed_inside_mixed(found: impl ToTokens) -> Error {
    at(found, "the arguments of `Mixed` are `DeltaPlus`, `Midpoint`, `DeltaMinus` or `Lambda<N, D>`")
}

pub(crate) fn lambda_range(found: impl ToTokens) -> Error {
    at(found, "`Lambda<N, D>` is the quadrature point N/D: it needs 0 <= N <= D and D > 0")
}

pub(crate) fn lambda_literal(found: impl ToTokens) -> Error {
    at(found, "the arguments of `Lambda<N, D>` are integer literals, as in `Lambda<1, 3>`")
}

pub(crate) fn closure_arity(patterns: TokenStream, found: usize) -> Error {
    let plural = if found == 1 { "" } else { "s" };
    at(
        patterns,
        format!(
            "a Hamiltonian takes coordinates, momenta and, if it needs it, time; this takes {found} parameter{plural}: \
             {PATTERNS}"
        ),
    )
}

pub(crate) fn swapped_names(q: &syn::Pat, p: &syn::Pat) -> Error {
    let [first, second] = [q, p].map(|pattern| pattern.to_token_stream().to_string());
    at(
        quote::quote! { #q #p },
        format!(
            "coordinates come before momenta: write `|{second}, {first}|`; if `{first}` are coordinates indeed, give them \
             and the momenta other names"
        ),
    )
}

pub(crate) fn momenta_disagree(momenta: impl ToTokens, q: &impl Display, p: &impl Display) -> Error {
    at(momenta, format!("the momenta are `{p}`, but the coordinates are `{q}`; both need the same shape"))
}

pub(crate) fn field_named_like_variable(variable: &Ident) -> Error {
    at(
        variable,
        format!(
            "the struct has a field `{variable}`, too: in this closure the name means the variable, and nothing tells them apart; give \
             one of them another name, as in `|x, y|`"
        ),
    )
}

pub(crate) fn shapes_disagree(
    pattern: impl ToTokens,
    found: &impl Display,
    (drift, is_real): (&impl Display, bool),
) -> Error {
    let remedy = match is_real {
        true => "give both closures one coordinate".to_owned(),
        false => format!("write it as `q: {drift}` or destructure it"),
    };
    at(pattern, format!("this is `{found}`, but the phase space of the drift is `{drift}`; {remedy}"))
}

pub(crate) fn shapes_disagree_within(
    pattern: impl ToTokens,
    found: &impl Display,
    expected: &impl Display,
) -> Error {
    at(pattern, format!("this pattern has the shape `{found}`, but `{expected}` is expected here"))
}

pub(crate) fn no_degrees(found: impl ToTokens) -> Error {
    at(found, "a system has at least one degree of freedom")
}

pub(crate) fn too_many_degrees(found: impl ToTokens, limit: usize) -> Error {
    at(found, format!("at most {limit} degrees of freedom are supported: each is a variable of its own"))
}

pub(crate) fn tuple_phase_pattern(pattern: &syn::PatTuple) -> Error {
    let parts: Vec<String> = pattern.elems.iter().map(|part| part.to_token_stream().to_string()).collect();
    at(
        pattern,
        format!(
            "coordinates and momenta are two parameters, not a tuple: write `|q, p|` for one degree of freedom, or \
             `|[{}], ...|` if these are several coordinates",
            parts.join(", ")
        ),
    )
}

pub(crate) fn unsupported_phase_pattern(pattern: impl ToTokens) -> Error {
    at(pattern, format!("this pattern cannot declare a phase space; {PATTERNS}"))
}

pub(crate) fn unsupported_phase_type(ty: impl ToTokens) -> Error {
    at(ty, format!("coordinates and momenta are `f64`, arrays of them or `&[f64]`; {PATTERNS}"))
}

pub(crate) fn size_not_literal(size: impl ToTokens) -> Error {
    at(
        size,
        "only the outermost size may be a constant, a const generic or known at run time; write a number here",
    )
}

pub(crate) fn time_is_real(pattern: impl ToTokens) -> Error {
    at(pattern, "the third parameter is time: a name, of type `f64` if it is given")
}

pub(crate) fn return_type(ty: impl ToTokens) -> Error {
    at(ty, "the value of a Hamiltonian is an `f64`")
}
