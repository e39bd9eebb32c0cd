//! The compiler of `wzvi`: one attribute, [`macro@hamiltonian`]. Users depend on the facade crate `wzvi`.
//!
//! Data flows one way: `input` reads what was declared, `lower` turns the closures into symbolic expressions,
//! `discretise` derives the discrete Euler-Lagrange equations and `emit` writes them as Rust. Each module
//! imports only modules above it:
//!
//! | module | contents |
//! |---|---|
//! | `key`, `distinct`, `tokens` | the keys of the attribute, lists without repetition, streams of tokens |
//! | `symbolic` | expressions, derivatives, proofs |
//! | `diagnostics`, `dependency` | the collector of errors and the messages; whether the generated names lead anywhere |
//! | `embedding` | schemes by name |
//! | `input` | declarations of the user |
//! | `model`, `indices` | systems as sums of elements; their indices as Rust |
//! | `lower`, `functions` | from Rust to terms; functions that Hamiltonians share |
//! | `discretise` | discrete Lagrangians, equations, facts |
//! | `passes` | from systems to systems |
//! | `choose` | straight lines or loops, for each scheme |
//! | `check` | refusals of the mathematics |
//! | `describe`, `emit` | the text of `EQUATIONS`; Rust code |
//! | `compile` | all stages on one page |

mod check;
mod choose;
mod compile;
mod dependency;
mod describe;
mod diagnostics;
mod discretise;
mod distinct;
mod embedding;
mod emit;
mod functions;
mod indices;
mod input;
mod key;
mod lower;
mod model;
mod passes;
mod symbolic;
mod tokens;

use proc_macro2::TokenStream;

/// The expansion, unless the names in it would lead nowhere.
fn with_dependency(
    attribute: TokenStream,
    item: TokenStream,
    expand: fn(TokenStream, TokenStream) -> TokenStream,
) -> TokenStream {
    match dependency::missing(&attribute) {
        Some(error) => [item, error.to_compile_error()].into_iter().collect(),
        None => expand(attribute, item),
    }
}

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
/// The other keys are `force`, `noise_force`, `friction`, `damping`, `temperature`, `constraint`, `clock`,
/// `calculus`, `observe` and `export`. In `observe = [radius = |q, p| ...]` are functions of the state with
/// their names, for results alone. `export = []` implements `Exported`, by which programs in other languages
/// make and run the system; `export = [Composed<Verlet, KahanLi8>]` adds schemes for these.
///
/// The patterns of a closure declare the phase space. They are the coordinates, the momenta and, if it is
/// named, time:
///
/// | pattern | phase space |
/// |---|---|
/// | `\|q, p\|` | one degree of freedom |
/// | `\|[x, y], [px, py]\|` | named degrees of freedom |
/// | `\|q: [f64; 3], p: [f64; 3]\|` | indexed; the length may be a constant or a const generic of the struct |
/// | `\|q: [[f64; 3]; N], p: [[f64; 3]; N]\|` | points |
/// | `\|q: &[f64], p: &[f64]\|` | the size is that of the state |
/// | `\|q: Rotation, p\|` | a rotation matrix with its constraints; `[Rotation; N]` for several |
/// | `\|q, p, t\|` | any of these with explicit time |
///
/// In `noise = [|q, p, k| sigma * q[k]; N]` the last parameter is the index of the noise. The fields of the
/// struct are in scope by name. Bodies are Rust expressions and are type-checked as such; sums over sites
/// stay loops.
///
/// A type of the program is an embedding by its quadrature points `l` in `q_l = (1 - l) q_i + l q_{i+1}` and
/// their weights, which add up to 1: `embedding = [Midpoint, Trapezoidal = [(0, 1/2), (1, 1/2)]]` with
/// `struct Trapezoidal;`. Numbers are exact: integers, fractions and decimals.
///
/// Mistakes are compile errors at the tokens that they are about. One is a scheme whose limit is not the
/// Stratonovich system, another an `invariant` that is not conserved.
#[proc_macro_attribute]
pub fn hamiltonian(
    attribute: proc_macro::TokenStream,
    item: proc_macro::TokenStream,
) -> proc_macro::TokenStream {
    with_dependency(attribute.into(), item.into(), compile::expand).into()
}

/// Makes a function, or the methods of an `impl` of the struct, callable from Hamiltonians.
///
/// ```text
/// #[hamiltonian_fn]
/// pub fn morse(r: f64, d: f64) -> f64 {
///     let e = 1.0 - (-r).exp();
///     d * e * e
/// }
///
/// #[hamiltonian(drift = |q, p| 0.5 * p * p + morse(q, d) + self.wall(q), embedding = Midpoint)]
/// struct Molecule { d: f64 }
///
/// #[hamiltonian_fn]
/// impl Molecule {
///     fn wall(&self, q: f64) -> f64 { self.d * q.powi(4) }
/// }
/// ```
///
/// The function itself does not change. A Hamiltonian inlines its body at the call, like that of a local
/// closure: facts and derivatives are those of the inlined expression.
///
/// * It may come from another module or crate, by a path or by an import under its own name.
/// * It may call other such functions, but not itself.
/// * Its parameters are numbers, arrays and slices.
/// * Constants are named from a root (`crate::units::KB`, `std::f64::consts::PI`) or declared inside.
/// * Methods belong to one `impl` in the module of the struct.
///
/// `#[hamiltonian_fn(crate = path)]` names the facade crate.
#[proc_macro_attribute]
pub fn hamiltonian_fn(
    attribute: proc_macro::TokenStream,
    item: proc_macro::TokenStream,
) -> proc_macro::TokenStream {
    with_dependency(attribute.into(), item.into(), functions::define).into()
}

/// Resumes an expansion with the tokens of a shared function. Only generated code calls it.
#[doc(hidden)]
#[proc_macro]
pub fn __continue(tokens: proc_macro::TokenStream) -> proc_macro::TokenStream {
    functions::resume(tokens.into(), compile::expand_with_definitions).into()
}
