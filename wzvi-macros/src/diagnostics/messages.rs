//! The messages about declarations: the struct, the attribute and the phase space. One function per mistake.
//! Tests: `tests/compiler/ui/messages`.

use std::fmt::Display;

use proc_macro2::Span;
use quote::ToTokens;
use syn::{Error, Item};

use super::{at, closest, quoted, source, suggest};
use crate::key::Key;
use crate::symbolic::{Rational, Special};

const PATTERNS: &str = "the supported patterns are `|q, p|`, `|[x, y], [px, py]|` and `|q: [f64; 3], p: [f64; 3]|`, each with \
                        time as an optional third parameter";

messages! {
    nested_too_deeply(token) = "this is nested too deeply to compile; name parts of the expression with \
        `let`";
    not_a_function(item) = "`#[hamiltonian_fn]` goes on a function, or on the `impl` of a struct for its \
        methods";
    methods_of_trait(path) = "`#[hamiltonian_fn]` goes on an `impl` of the struct itself, not of a trait";
    generic_function(parameter) = "a function of Hamiltonians takes numbers, arrays and slices: it has no \
        generic parameters; the length of a slice is `x.len()`";
    unmarked_function(name) {
        found = name.to_token_stream().to_string();
        import = match Special::named(&found) {
            Some(_) => format!("; `use wzvi::functions::{found}` imports a function of this name"),
            None => String::new(),
        };
    } = "`{name}` has no attribute `#[hamiltonian_fn]`, which a function needs to be called by a Hamiltonian{import}";
    special_function(found) = "a function of Hamiltonians is a plain function of its arguments, or takes \
        `&self`";
    relative_constant(path) = "the body of this function is compiled where it is called, and this name may \
        mean something else there: name the constant from a root, as in `crate::units::KB` or \
        `std::f64::consts::PI`, declare it inside with `const`, or pass it";
    recursion(call) = "this function calls itself, and recursion cannot be differentiated; write the sum or product \
        with an iterator";
    /// `#[cfg(...)]` inside of a Hamiltonian.
    condition_of_build(attribute) = "the compiler of Hamiltonians cannot evaluate conditions of the build; write `#[cfg(...)]` \
        above `#[hamiltonian]`, on one struct for each case, or choose a constant outside, as in `const K: f64 = if \
        cfg!(feature = \"stiff\") {{ 4.0 }} else {{ 1.0 }};`";
    condition_in_function(attribute) = "the compiler of Hamiltonians cannot evaluate conditions of the build; write \
        `#[cfg(...)]` above `#[hamiltonian_fn]`, on one function or `impl` for each case, or choose a constant, as in `const \
        K: f64 = if cfg!(feature = \"stiff\") {{ 4.0 }} else {{ 1.0 }};` outside and `crate::K` here";
    condition_of_struct(attribute) = "the compiler of Hamiltonians cannot evaluate conditions of the build; write `#[cfg(...)]` \
        above `#[hamiltonian]`, on one struct for each case";
    /// A field whose place or type depends on the condition.
    condition_of_field(attribute) = "the compiler of Hamiltonians cannot evaluate conditions of the build, which decide \
        the place or the type of this field; write one struct for each case, with `#[cfg(...)]` above its `#[hamiltonian]`";
    attribute_inside(attribute) = "this attribute is unknown, and could change what the Hamiltonian means; leave it out (`allow`, \
        `expect`, comments and `rustfmt::skip` are known)";
    attribute_of_function(attribute) = "this attribute is unknown, and could change the function after it was read; leave it \
        out, or write it above `#[hamiltonian_fn]`";
    expected_key(tokens) { keys = keys(); } = "expected `key = value`; the keys are {keys}";
    duplicate_key(key) = "`{key}` is given twice; merge the two";
    friction_and_damping(key) = "`friction` (rates, 1/time) and `damping` (a matrix, mass/time) describe the same \
        friction: keep one of them";
    missing_value(key) = "`{key} =` has no value";
    unexpected_after_value(tokens) { keys = keys(); } = "expected `,` and the next `key = value`; the keys are \
        {keys}";
    missing_comma(key) = "expected `,` before `{key}`";
    not_a_path(found) = "expected the path of the crate `wzvi`, such as `crate = ::wzvi`";
    not_a_closure(found) = "expected a closure over coordinates and momenta, such as `|q, p| 0.5 * p * p`";
    async_closure(token) = "a Hamiltonian is a function of the state: it cannot be `async`";
    family_in_list(tokens) = "a family in a list has brackets of its own: `noise = \
        [[|q, p, k| ...; N], |q, p| ...]`, `constraint = [[|q, k| ...; N], |q| ...]`";
    parts_of_drift(brackets) = "a drift is one Hamiltonian, or two parts: `drift = [|q, p| ..., \
        |q, p| ...]`";
    family_of_invariants(count) = "first integrals are listed one by one: `invariant = [|q, p| ..., |q, p| \
        ...]`";
    family_of_observables(count) = "observables are listed one by one, each with its name: `observe = [left = |q, p| ..., \
        right = |q, p| ...]`";
    unnamed_observable(closure) = "results have an observable under its name, and this one has none: write `observe = [name = |q, p| \
        ...]`";
    /// An observable with the name of another quantity of the system.
    taken_name(name, of: &str) = "`{name}` is the name of {of}, and tables, plots and statistics show both: give this observable \
        another name";
    name_of_other(name) = "first integrals and observables have names, `invariant = [energy = |q, p| ...]`, `observe = [radius = |q, \
        p| ...]`; other Hamiltonians have none: leave it out";
    not_exported(found) = "`export` lists the types of schemes beside those of `embedding`, as in `export = [Composed<Verlet, KahanLi8>]`, \
        or none, `export = []`";
    /// `export` on a struct that borrows.
    export_of_borrow(lifetime) = "programs in other languages give the fields of an exported system, which thus owns them: write \
        `Vec<f64>` in place of `&[f64]`, or leave `export` out";
    not_a_scheme(found, schemes: &str) = "expected an embedding; there are {schemes}";
    /// More stages than the tables of coefficients have.
    gauss_stages(found) = "`Gauss<S>` has 1 to 16 stages; `Gauss<1>` is `Midpoint`";
    duplicate_embedding(found, embedding: &impl Display) = "`{embedding}` is listed twice; once is enough";
    scheme_arguments(found, example: &str) = "wrong generic arguments; write it as in `{example}`";
    wrapper_inside(found) = "`Corrected` and `Uncorrected` wrap a whole scheme: \
        `Corrected<Mixed<Midpoint, DeltaPlus>>`, never inside another";
    whole_inside(found) { scheme = source(&found); } = "`{scheme}` is listed by itself: `Corrected`, `Uncorrected` and `Mixed` take schemes of quadrature \
        points, such as `DeltaPlus`, `Midpoint`, `DeltaMinus` and `Lambda<N, D>`";
    thermostat_inside(found) = "a thermostat wraps a scheme that is not itself a thermostat: `Thermostat<Midpoint>`, \
        `Thermostat<Gauss<2>>`";
    mixed_inside_mixed(found) = "the arguments of `Mixed` are `DeltaPlus`, `Midpoint`, `DeltaMinus` or \
        `Lambda<N, D>`";
    lambda_range(found) = "`Lambda<N, D>` is the quadrature point N/D: it needs 0 <= N <= D and D > 0";
    lambda_literal(found) = "the arguments of `Lambda<N, D>` are integer literals, as in `Lambda<1, 3>`";
    points_of_other(found) = "quadrature points belong to a type of your program that is not listed yet: \
        `Trapezoidal = [(0, 1/2), (1, 1/2)]` with `struct Trapezoidal;`";
    points_twice(found) = "this type has quadrature points already; give them once";
    not_points(found) = "expected quadrature points with their weights, such as `[(0, 1/2), (1, 1/2)]`";
    too_many_points(found) = "a step has at most 16 quadrature points";
    point_number(found) = "expected a number that is known exactly: an integer, a fraction such as `1/3`, or a \
        decimal, of integers below 2^53";
    point_outside(found) = "a quadrature point is from 0, where the step starts, to 1, where it ends";
    point_again(found) = "this point is listed already; add up the weights";
    point_without_weight(found) = "a point of weight 0 does nothing; leave it out";
    weights_of_points(found, sum: &impl Display) = "the weights of quadrature points must add up to 1; these add up to {sum}";
    inexact_points(found) = "these fractions are too long: their sums and products have to be fractions of numbers below 2^53";
    momenta_disagree(momenta, q: &impl Display, p: &impl Display) = "the momenta are `{p}`, but the \
        coordinates are `{q}`; both need the same shape";
    field_named_like_variable(variable) = "the struct has a field `{variable}`, too: in this closure the \
        name means the variable; give one of them another name, as in `|x, \
        y|`";
    shapes_disagree_within(pattern, found: &impl Display, expected: &impl Display) = "this pattern has the \
        shape `{found}`, but `{expected}` is expected here";
    no_degrees(found) = "a system has at least one degree of freedom";
    too_many_degrees(found, limit: usize) = "at most {limit} degrees of freedom are supported: each is a \
        variable of its own";
    unsupported_phase_pattern(pattern) = "this pattern cannot declare a phase space; {PATTERNS}";
    unsupported_phase_type(ty) = "coordinates and momenta are `f64`, arrays of them or `&[f64]`; {PATTERNS}";
    size_not_literal(size) = "only the outermost size may be a constant, a const generic or known at run \
        time; write a number here";
    time_is_real(pattern) = "the third parameter is time: a name, of type `f64` if it is given";
    return_type(ty) = "the value of a Hamiltonian is an `f64`";
    empty_list(list, key: &syn::Ident) = "this list is empty; leave `{key}` out if there is none";
    no_scheme(list, schemes: &str) = "this list is empty; list at least one scheme of {schemes}";
    unknown_key(key) {
        word = key.to_string();
        meant = suggest(intended_key(&word).map(Key::name));
        keys = keys();
    } = "unknown key `{word}`; the keys are {keys}{meant}";
    unknown_embedding(name, meant: Option<&str>, schemes: &str) {
        meant = suggest(meant);
    } = "unknown embedding `{name}`; there are {schemes}{meant}";
    /// A name that requests another sense of the stochastic integral.
    key_of_ito(key) = "{STRATONOVICH}";
    embedding_of_ito(name) = "there is no embedding `{name}`: {STRATONOVICH}";
    unknown_letter(ty) = "the letters of a splitting are `A` (drift), `B` (kick) and `O` (friction and noise of the \
        bath); `A<1, 4>` and `B<1, 4>` take a quarter of the step";
    share_of_letter(ty) = "the share of a letter is a fraction of two integers above 0: `A<1, 4>` and `B<1, 4>` take a quarter of \
        the step; there are no steps backwards in a bath";
    long_word(word, most: usize, letters: usize) = "a splitting has at most {most} letters, this one {letters}";
    missing_letter(word, letter: &str) = "a splitting needs drifts `A`, kicks `B` and friction `O`: there is no `{letter}`";
    shares_of_letters(word, letter: &str, total: Option<Rational>) {
        total = total.map_or("something else".to_owned(), |total| total.to_string());
    } = "the shares of `{letter}` add up to {total}, not to 1: each kind of letter covers the step once";
    /// A composition is not listed, but its base is.
    composed(found, base: &syn::Type) {
        base = source(base);
        scheme = source(&found);
        is_clocked = ["Clocked", "Extended", "Logarithmic"].iter().any(|clock| base.starts_with(clock));
        step = if is_clocked { "Eps(0.3)" } else { "h" };
    } = "compositions are not listed: list `{base}`, \
        and name the composition where it runs, `simulate::<{scheme}>({step})`";
    composed_alone(found) = "compositions are not listed: list the scheme that is composed, as in `embedding = Verlet`, and name the \
        composition where it runs, `simulate::<Composed<Verlet, Yoshida4>>(h)`";
    /// The weights of a composition in the place of a scheme.
    weights_alone(found) { scheme = source(&found); } = "`{scheme}` composes steps of another scheme, and is not listed: list that \
        scheme, as in `embedding = Verlet`, and name the composition where it runs, `simulate::<Composed<Verlet, {scheme}>>(h)`";
    not_a_clock(found) = "a clock is `curvature`, `curvature(w0)` with a frequency `w0`, `pairs`, or a closure whose value is the \
        wanted length of a step up to a factor, `clock = |q, p| ...`";
    unsymmetric_clocked(found, scheme: &impl Display) = "a clock needs a symmetric scheme, which a step backwards undoes, and `{scheme}` is \
        none: write `Clocked<Verlet>`, `Clocked<Midpoint>` or `Clocked<Gauss<8>>`";
    /// `Clocked<Baoab>`
    clock_around_other(found, scheme: &impl Display) = "a clock goes around `Verlet`, `Midpoint` or `Gauss<S>`, and around their compositions where \
        these run; `{scheme}` has steps of one size";
    clocked_constraints(found, scheme: &impl Display) = "there is no clock on a manifold of constraints; write `{scheme}`, with steps of one size";
    /// `Extended<Midpoint>`
    extended_of_other(found, scheme: &impl Display) = "steps in the extended phase space are known for `Gauss<S>` with 2 to 16 stages and for \
        `Verlet`; write `Extended<Gauss<8>>`, or `Clocked<{scheme}>` if that scheme is symmetric";
    clock_inside_clock(found) = "a scheme has one clock; list the schemes one by one";
    /// A scheme with a clock inside of a thermostat.
    clock_inside(found) { scheme = source(&found); } = "`{scheme}` is listed by itself: its clock is around a whole step of a system without a bath, \
        as in `Clocked<Verlet>`";
    logarithmic_exponent(found) = "the arguments of `Logarithmic<N, D>` are two integers above 0, whose quotient is the exponent of its \
        clock: `Logarithmic<1, 1>` is the logarithmic Hamiltonian";
    clocked_composition(found, clock: &str, base: &syn::Type) {
        base = source(base);
        scheme = source(&found);
    } = "compositions are not listed: list `{clock}<{base}>`, and name the composition where it runs, `simulate::<{scheme}>(Eps(0.3))`";
    closure_arity(patterns, found: usize) { plural = if found == 1 { "" } else { "s" }; } = "a Hamiltonian takes \
        coordinates, momenta and, if it needs it, time; this takes {found} parameter{plural}: {PATTERNS}";
    constraint_arity(patterns, found: usize) { plural = if found == 1 { "" } else { "s" }; } = "a constraint takes coordinates and, \
        if it needs it, time; this takes {found} parameter{plural}: write `|q| ...` or `|q, t| ...`, and for a family `[|q, k| ...; N]`";
    misplaced_rotation(pattern) = "`Rotation` is the type of all coordinates: `|q: Rotation, p|` for a body, `|q: [Rotation; N], p|` \
        for several. Momenta are matrices without constraints: write `p`, or `p: [[f64; 3]; 3]`. A body with other coordinates \
        beside its rotation is declared by `q: [f64; D]`, with the constraints of the matrix written out";
    /// A nonholonomic constraint.
    momenta_in_constraint(pattern) {
        remedy = match syn::parse2::<syn::Ident>(pattern.clone()) {
            Ok(name) => {
                format!("; if `{name}` is the time, call it `t`; if it is the number of a member, write the family with its size, \
                    `constraint = [|q, {name}| ...; N]`")
            }
            _ => "; leave its momenta out".to_owned(),
        };
    } = "a constraint is a function of the coordinates and the time, `|q| ...` or `|q, t| ...`: one that reads momenta is not holonomic, \
        and motion under it follows from no Lagrangian{remedy}";
    /// `|q, p, w|` in a system with noise.
    third_name(pattern) { name = source(&pattern); } = "the third parameter of a Hamiltonian is the time, and this system has noise: a \
        noise is a Hamiltonian of its own, as in `noise = |q, p| sigma * q`; a family has its number as parameter, `noise = [|q, p, k| \
        sigma * q[k]; N]`; if `{name}` is the time, call it `t`";
    swapped_names(patterns, q: &syn::Pat, p: &syn::Pat) {
        first = q.to_token_stream();
        second = p.to_token_stream();
    } = "coordinates come before momenta: write `|{second}, \
        {first}|`; if `{first}` really are coordinates, give them and the momenta other names";
    shapes_disagree(pattern, found: &impl Display, drift: &impl Display, is_real: bool) {
        remedy = match is_real {
            true => "give both closures one coordinate".to_owned(),
            false => format!("write it as `q: {drift}` or destructure it"),
        };
    } = "this is `{found}`, but the phase space of the drift is `{drift}`; {remedy}";
    tuple_phase_pattern(pattern, parts: &impl ToTokens) { parts = source(parts); } = "coordinates and momenta are two parameters, not a tuple: write \
        `|q, p|` for one degree of freedom, or `|[{parts}], ...|` if these are several coordinates";
}

/// A value of `calculus`.
pub(crate) fn unknown_calculus_at(place: Span) -> Error {
    Error::new(
        place,
        "the sense of the noises is `calculus = Ito` or `calculus = Stratonovich`, which is the default",
    )
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

/// The key that a misspelled name may stand for.
pub(crate) fn intended_key(name: &str) -> Option<Key> {
    closest(name, Key::ALL.iter().map(|key| key.name())).and_then(Key::named).or_else(|| synonym(name))
}

/// The key that other texts call `key`.
fn synonym(name: &str) -> Option<Key> {
    match name {
        "hamiltonian" | "energy" | "h" | "H" | "h0" | "H0" => Some(Key::Drift),
        "diffusion" | "stochastic" => Some(Key::Noise),
        "scheme" | "schemes" | "method" | "integrator" | "quadrature" => Some(Key::Embedding),
        "integral" | "first_integral" | "conserved" | "casimir" => Some(Key::Invariant),
        "observable" | "observables" | "output" | "outputs" => Some(Key::Observe),
        "time_transformation" | "density" | "monitor" | "adaptive" => Some(Key::Clock),
        "constraints" | "holonomic" | "rods" | "manifold" => Some(Key::Constraint),
        _ => None,
    }
}

const STRATONOVICH: &str = "noises are in the sense of Stratonovich; for an equation in the sense of Ito write the key `calculus = Ito`, which \
                            converts it: see \"From Ito to Stratonovich\" in docs/guide/noise.md";

/// Whether a name requests another sense of the stochastic integral, or a scheme in that sense.
pub(crate) fn is_of_ito(name: &syn::Ident) -> bool {
    let name = name.to_string().to_lowercase();
    ["ito", "itô", "stratonovich", "eulermaruyama", "milstein", "interpretation"].contains(&name.as_str())
}

/// The weights and tables of compositions.
pub(crate) fn is_composition(name: &str) -> bool {
    const NAMES: &str = "Yoshida4 Suzuki4 Yoshida6 KahanLi6 SuzukiUmeno8 KahanLi8 BlanesMoan4 BlanesMoan6 Srkn6 Aba864 Aba1064 \
                         Chin4 TakahashiImada4";
    NAMES.split(' ').any(|known| known == name)
}

pub(crate) fn missing_key(key: Key) -> Error {
    let example = match key {
        Key::Drift => "drift = |q, p| 0.5 * p * p + 0.5 * q * q",
        _ => "embedding = Midpoint",
    };
    Error::new(Span::call_site(), format!("`{}` is missing; for example `{example}`", key.name()))
}

/// A program that reaches the macros through another crate.
pub(crate) fn no_dependency() -> Error {
    let message = "this package does not depend on `wzvi`, which the generated code names: add it, `cargo add wzvi`, or name the path \
                   through the crate that re-exports it, with the key `crate = that_crate::wzvi`";
    Error::new(Span::call_site(), message)
}

/// The keys as a list.
fn keys() -> String {
    let names: Vec<&str> = Key::ALL.iter().map(|key| key.name()).collect();
    let (last, others) = names.split_last().unwrap_or((&"", &[]));
    format!("{} and {}", quoted(others.iter().copied()), quoted([*last]))
}
