//! Hamiltonians as sums of elements: systems whose size the compiler does not know, or need not know.
//!
//! ```text
//! H = Σ_e Σ_(loops of e) H_e(locals of e)
//! ```
//!
//! An element is a scalar expression without loops, in a few local variables, and the loops that place it. A local
//! variable is a component of `q` or `p`, an entry of a field, or a number made of loop variables; its index is an
//! [`crate::model::index::Index`]. The discrete Lagrangian is then a sum of elements, too, `ℓ_e = -c H_e(P, Q_l)` with `c = h` or an
//! increment, beside `P · Δq`. Everything is derived from it element by element: derivatives are local and symbolic, and
//! the emitted code adds them up in loops, so that neither its size nor the time to compile it depends on the size of
//! the system.
//!
//! ```text
//! closures --lower--> expressions with symbols for sums --passes/collect--> elements
//!          --facts--> separable? diagonal? affine? what is known of the noise --plan--> unknowns of each scheme
//!          --emit--> `Elements`: values, slopes and curvatures in loops; the iteration is `wzvi::elements`
//! ```

pub(crate) mod describe;
pub(crate) mod parts;
pub(crate) mod plan;
pub(crate) mod staged;
