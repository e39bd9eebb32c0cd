//! The roles of terms: which of them are evaluated, and with which increments.

/// The role of terms in a system. Terms with one role are evaluated together, with one weight and the same
/// rule for their increments. Code of a system matches on the roles that it has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// `h H_0`, in the step Hamiltonian.
    Drift,
    /// `Σ_k ΔW_k H_k`, in the step Hamiltonian: of the noises that [act](super::EvaluationPoint::acting).
    Noise,
    /// The counter-term of a scheme, of second order in the increments, in the step Hamiltonian.
    CounterTerm,
    /// The force beside the drift: derivatives `-h f` by coordinates, no value.
    Force,
    /// A part of `drift = [H_A, H_B]`, of which 0 is `H_A` and 1 is `H_B`, times `h`.
    Summand(usize),
    /// The friction of a bath: rates `γ_i`, or the matrix `Γ`, as a covector.
    Friction,
    /// The temperature of a bath: a value, or a covector of one temperature per degree of freedom.
    Temperature,
    /// A first integral, by its number in the list of the system: a value.
    Integral(usize),
    /// An observable that the system declares, by its number in the list of the system: a value.
    Observable(usize),
    /// The clock `Q(q, p, t)` of the system, the wanted step in units of `eps`: a value, and derivatives
    /// where a scheme extends the phase space by it.
    Clock,
    /// `G = -d ln Q/dt` along the drift with its forces and friction: a value.
    ClockRate,
}

/// A role and the weight of its terms at a quadrature point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WeightedRole {
    /// The role.
    pub role: Role,
    /// The factor of values and derivatives beside the increments.
    pub weight: f64,
}

impl Role {
    /// The role with this weight.
    pub const fn times(self, weight: f64) -> WeightedRole {
        WeightedRole { role: self, weight }
    }
}
