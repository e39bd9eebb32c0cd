//! The discrete embeddings, as types.
//!
//! Each places the quadrature point `q_l = (1 - l) q_i + l q_{i+1}` of the discrete antiderivative in
//!
//! ```text
//! L_d = P · (q_{i+1} - q_i) - Σ_m c_m H_m(P, q_{l_m}, t_i + l_m h),    c_0 = h,  c_k = ΔW_k.
//! ```
//!
//! They carry no data: `#[hamiltonian(embedding = ...)]` names them. Any type can be declared an embedding by
//! its points and weights: `embedding = [Trapezoidal = [(0, 1/2), (1, 1/2)]]`.

use std::marker::PhantomData;

pub use crate::scheme::bath::{Baoab, GBaoab, GjI, Gjf, Obabo, Splitting, Thermostat};
pub use crate::scheme::clock::{Clocked, Extended, Logarithmic};
pub use crate::scheme::constraints::Rattle;
pub use crate::scheme::gauss::Gauss;
pub use crate::scheme::system::{OneStep, Own};

pub use crate::scheme::compose::{
    Aba864, Aba1064, BlanesMoan4, BlanesMoan6, Chin4, Composed, KahanLi6, KahanLi8, Partitioned, Srkn6,
    Suzuki4, SuzukiUmeno8, TakahashiImada4, Verlet, Weights, Yoshida4, Yoshida6,
};

/// `l = 0`: the paper's order-one embedding (Δ₊, ∫ Δt).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DeltaPlus;

/// `l = 1/2`: the paper's mid-point embedding, of deterministic order two; consistent with every Stratonovich
/// system.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Midpoint;

/// `l = 1`: the adjoint of [`DeltaPlus`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DeltaMinus;

/// `l = N/D`, with `0 <= N <= D`: the paper's λ-antiderivative.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Lambda<const N: u32, const D: u32>;

/// The quadrature point of `Drift` for the drift Hamiltonian and that of `Noise` for every noise Hamiltonian.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Mixed<Drift, Noise>(PhantomData<(Drift, Noise)>);

/// `E` with the counter-term `Σ_jk (1/2 - l) ΔW_j ΔW_k ∂H_j/∂q · ∂H_k/∂p` in the step Hamiltonian. This makes
/// it consistent, and of strong order one if the noises commute. If all these products are constant, it is
/// `E` itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Corrected<E>(PhantomData<E>);

/// `E` without a counter-term, although its limit may not be the Stratonovich system: the paper's experiment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Uncorrected<E>(PhantomData<E>);

/// The names that a program gets with the prelude.
pub mod prelude {
    pub use super::{
        Aba864, Aba1064, Baoab, BlanesMoan4, BlanesMoan6, Chin4, Clocked, Composed, Corrected, DeltaMinus,
        DeltaPlus, Extended, GBaoab, Gauss, GjI, Gjf, KahanLi6, KahanLi8, Lambda, Logarithmic, Midpoint,
        Mixed, Obabo, Own, Rattle, Splitting, Srkn6, Suzuki4, SuzukiUmeno8, TakahashiImada4, Thermostat,
        Uncorrected, Verlet, Yoshida4, Yoshida6,
    };
}
