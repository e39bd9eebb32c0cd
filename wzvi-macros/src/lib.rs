//! The compiler of `wzvi`: one attribute, [`macro@hamiltonian`]. Users depend on the facade crate `wzvi`.
//!
//! Data flows one way: `input` reads what was declared, `lower` turns the closures into symbolic expressions,
//! `discretise` derives the discrete Euler-Lagrange equations and `emit` writes them as Rust.

mod backend;
mod check;
mod compile;
mod diagnostics;
mod discretise;
mod elements;
mod emit;
mod input;
mod lower;
mod model;
#[cfg(test)]
mod stopwatch;
mod symbolic;
mod unroll;

/// Turns the Hamiltonians of a system into variational integrators.
///
/// ```text
/// #[hamiltonian(
///     drift = |q, p| 0.5 * a * (q * q + p * p),          // H_0
///     noise = [|q, p| 0.5 * sigma * (q * q + p * p)],    // H_1, ...; leave it out for a deterministic system
///     embedding = [Midpoint, Uncorrected<DeltaPlus>],    // one scheme, or a list
///     invariant = [|q, p| q * q + p * p],                // optional: first integrals that must be proven
///     crate = ::wzvi,                                    // optional: the path of the facade crate
/// )]
/// struct Kubo { a: f64, sigma: f64 }
/// ```
///
/// The parameters of a closure are the coordinates, the momenta and, if it is named, time: `|q, p|` is one degree of
/// freedom, `|[x, y], [px, py]|` names several, `|q: [f64; 3], p: [f64; 3]|` indexes them. The size may be a constant or a
/// const generic, `|q: &[f64], p: &[f64]|` has that of the state, and `[[f64; 3]; N]` are points: sums then stay loops, and
/// `noise = [|q, p, k| sigma * q[k]; N]` is one noise for each `k`. The fields of the struct
/// are in scope by name. Bodies are Rust expressions and are type-checked as such.
#[proc_macro_attribute]
pub fn hamiltonian(
    attribute: proc_macro::TokenStream,
    item: proc_macro::TokenStream,
) -> proc_macro::TokenStream {
    compile::expand(attribute.into(), item.into()).into()
}
