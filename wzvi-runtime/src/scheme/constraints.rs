//! Holonomic constraints `g(q, t) = 0`: motion on the manifold that they leave.
//!
//! The discrete Lagrangian of [`Verlet`](crate::scheme::compose::Verlet) with `-(h/2) λ · g(q_i)` and
//! `-(h/2) μ · g(q_{i+1})` added has the steps of RATTLE, for `G = ∂g/∂q`:
//!
//! ```text
//! P = p_i - (h/2) (∂H/∂q(q_i, P, t_i) + G(q_i, t_i)ᵀ λ)
//! q_{i+1} = q_i + (h/2) (∂H/∂p(q_i, P, t_i) + ∂H/∂p(q_{i+1}, P, t_{i+1})),   g(q_{i+1}, t_{i+1}) = 0
//! p_{i+1} = P - (h/2) (∂H/∂q(q_{i+1}, P, t_{i+1}) + G(q_{i+1}, t_{i+1})ᵀ μ)
//! (G ∂H/∂p + ∂g/∂t)(q_{i+1}, p_{i+1}, t_{i+1}) = 0
//! ```
//!
//! They are symmetric, symplectic on the manifold, and of order two; compositions have higher orders. RATTLE
//! is due to H. C. Andersen (J. Comput. Phys. 52, 1983), the proof that it is symplectic to B. J. Leimkuhler
//! and R. D. Skeel (J. Comput. Phys. 112, 1994), its form for any Hamiltonian to L. O. Jay (SIAM J. Numer.
//! Anal. 33, 1996), and its compositions to S. Reich (SIAM J. Numer. Anal. 33, 1996); see E. Hairer, C.
//! Lubich, G. Wanner, *Geometric Numerical Integration*, section VII.1.4. For `T(p) + V(q, t)` a step is a
//! word of three parts, as without constraints: a kick, a drift, a kick. Each part has the impulse `Gᵀ ν`
//! that keeps its end on the manifold: that of the drift is found by Newton's method, that of a kick by one
//! projection of the momenta. A projection before a drift changes nothing but `ν`, and is left out.

mod dense;
mod evaluation;
mod flows;
mod general;
mod general_manifold;
mod layout;
mod manifold;
mod memory;
mod past;
mod rattle;
mod rigid_body;
mod sparse;
mod word;

pub use dense::DenseConstraints;
pub use evaluation::ConstraintRows;
pub use general::{GeneralRattle, GeneralRattleConstants, GeneralRattleMemory};
pub use layout::ConstraintLayout;
pub(crate) use manifold::put_on;
pub use manifold::{Distance, Manifold, ManifoldPoint};
pub use memory::ConstraintMemory;
pub(crate) use memory::ConstraintScratch;
pub(crate) use rattle::constrained_plan;
pub use rattle::{Rattle, RattleSteps};
pub use rigid_body::{InertiaError, RigidBody, Rotation};
pub use sparse::SparseConstraints;
pub(crate) use word::{ConstrainedStep, Relaxes};

use crate::algebra::scalar::Scalar;
use crate::scheme::elements::{Elements, EvaluationPoint};

/// Constraints hold to so many roundings of the coordinates that they read.
const ROUNDINGS: f64 = 4.0 * f64::EPSILON;
/// The most iterations of a step. Newton's method takes three or four.
const MOST_ITERATIONS: u32 = 24;

/// A system with constraints; generated.
pub trait Constrained: Elements {
    /// The arrangement of the Jacobian of the constraints.
    type Layout: ConstraintLayout;

    /// Whether a constraint reads the time.
    const READ_TIME: bool;

    /// Whether `H_0` is `p · W p / 2 + V(q, t)` with a constant diagonal matrix `W`, and neither a noise nor
    /// a force reads momenta.
    const HAS_SQUARES: bool;

    /// The number of constraints, where the compiler knows it; else `usize::MAX`.
    const CONSTRAINTS: usize;

    /// The number of constraints.
    fn constraints(&self) -> usize;

    /// Gives the value of each constraint, its derivatives by coordinates and by the time to `into`, term by
    /// term, in the same order at every state.
    fn constrain<S: Scalar>(&self, at: &EvaluationPoint<'_, S>, into: &mut impl ConstraintRows<S>);
}
