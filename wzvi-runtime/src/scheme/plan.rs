//! Compile-time results about one scheme of one system.

use std::fmt;

use super::bath::Friction;
use super::compose::Form;
use super::elements::{CollectiveVariables, Partials, Role};
use super::system::Kind;

/// How the step is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solver {
    /// Every unknown is assigned in order.
    Explicit,
    /// The hardest block is affine in its unknowns: one linear solve. Steps in loops sweep while that
    /// contracts, and solve then, where the matrix differs from step to step.
    Linear,
    /// The hardest block needs Newton's method, with the exact Jacobian.
    Newton,
}

/// How the noise enters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoiseClass {
    /// No noise.
    None,
    /// From a thermostat only, whose part of a step is exact in law.
    Thermal,
    /// Every noise Hamiltonian is affine in (q, p): a constant shift.
    Additive,
    /// Every noise Hamiltonian reads q (and t) only.
    Position,
    /// Every noise Hamiltonian reads p (and t) only.
    Momentum,
    /// Anything else.
    Multiplicative,
}

/// The truth of a statement, as far as it is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Knowledge {
    /// It holds, by exact algebra.
    Proven,
    /// It fails at a point that the compiler found.
    Refuted,
    /// Neither could be shown.
    Unknown,
}

/// How a run without noise monitors its energy: [`Plan::energy_watch`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EnergyWatch {
    /// `H_0` is conserved, by proof: its values are compared with that at the start.
    FromStart,
    /// Nothing shows that `H_0` changes or jumps, and no proof excludes it. The values are compared with that
    /// at the start, and with that behind a jump where the run finds one.
    Undecided,
    /// Not at all: the text of `H_0` shows a jump, and a run cannot see every crossing of it.
    Discontinuous,
    /// Not at all: noise, forces, friction or explicit time change `H_0`.
    Never,
}

/// The energy that the steps of a scheme conserve to rounding in a linear system:
/// [`Properties::kept_energy`](crate::scheme::system::Properties::kept_energy).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KeptEnergy {
    /// `H`
    Hamiltonian,
    /// `H + h (l - 1/2) H_q · H_p`, for steps with the quadrature point `l`.
    Point(f64),
    /// `H - h²/8 H_q · H_pp H_q`, for [`Verlet`](crate::scheme::compose::Verlet).
    KickDriftKick,
    /// `H` up to oscillations: compositions of `Verlet`, and splittings into other parts.
    Nearly,
}

/// Compile-time facts about a system, whatever its scheme.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Facts {
    /// Degrees of freedom; `usize::MAX` where only the state knows them.
    pub degrees: usize,
    /// How the noise enters.
    pub noise: NoiseClass,
    /// As [`Plan::conserves_energy`].
    pub conserves_energy: Knowledge,
    /// As [`Plan::energy_jumps`].
    pub energy_jumps: bool,
    /// As [`Plan::commuting`].
    pub commuting: Knowledge,
    /// As [`Plan::has_weak_order_two`].
    pub has_weak_order_two: bool,
    /// Whether there is friction or a bath.
    pub is_damped: bool,
    /// Friction and temperature, where the O part of a thermostat can apply them.
    pub bath: Option<Friction>,
    /// Whether a branch depends on a condition in several coordinates or momenta: then a slope may read a
    /// variable although the second derivative vanishes.
    pub has_pieces: bool,
    /// Friction, forces and explicit time.
    pub kind: Kind,
    /// The forms of `H_A` and `H_B`, for `drift = [H_A, H_B]`.
    pub summands: Option<[Form; 2]>,
    /// Whether derivatives can be computed tile by tile: elements that read coordinates add to adjacent
    /// places, and those that read momenta read one each and add to its place.
    pub has_tiles: bool,
    /// Whether elements have rows of pairs, see [`Pair`](crate::scheme::elements::Pair): then derivatives of
    /// large systems in `f64` are vectorised.
    pub has_pairs: bool,
    /// The halves of the phase space with derivatives of elements whose
    /// [`Placements`](crate::scheme::elements::Placements) are evaluated in lanes: in large systems, with
    /// `f64`, these are vectorised.
    pub gathers: Partials,
    /// Whether all velocities are the derivatives of one element in one loop over all places.
    pub has_one_velocity: bool,
    /// Whether the second derivatives of the step Hamiltonian read neither the state nor the time nor
    /// increments; `false` without tiles.
    pub has_constant_curvature: bool,
    /// The most degrees of freedom of one point that depend on each other, where elements of loops couple no
    /// points.
    pub coupled_degrees: Option<usize>,
    /// The collective variables of each role that has any; empty where no step solves with them.
    pub collective_variables: &'static [CollectiveVariables],
}

impl Facts {
    /// The facts of an autonomous system without noise, without listed first integrals and without loops.
    pub const fn autonomous(degrees: usize) -> Self {
        Self {
            degrees,
            noise: NoiseClass::None,
            conserves_energy: Knowledge::Proven,
            energy_jumps: false,
            commuting: Knowledge::Proven,
            has_weak_order_two: true,
            is_damped: false,
            bath: None,
            has_pieces: false,
            kind: Kind::AUTONOMOUS,
            summands: None,
            has_tiles: false,
            has_pairs: false,
            gathers: Partials { by_q: false, by_p: false },
            has_one_velocity: false,
            has_constant_curvature: false,
            coupled_degrees: None,
            collective_variables: &[],
        }
    }

    /// The collective variables of a role, if it has any.
    pub(crate) fn collective_variables_of(&self, role: Role) -> Option<&'static CollectiveVariables> {
        self.collective_variables.iter().find(|variables| variables.role == role)
    }

    /// The plan of a scheme of this order with such a step.
    pub const fn plan(self, solver: Solver, unknowns: usize, order: u32, consistent: bool) -> Plan {
        let Self { noise, conserves_energy, energy_jumps, commuting, has_weak_order_two, .. } = self;
        Plan {
            solver,
            unknowns,
            order,
            noise,
            consistent,
            conserves_energy,
            energy_jumps,
            commuting,
            has_weak_order_two,
            is_out_of_equilibrium: match self.bath {
                Some(friction) => friction.is_out_of_equilibrium(),
                None => false,
            },
        }
    }

    /// The plan of an explicit step of order two made of flows.
    pub const fn explicit(self) -> Plan {
        self.plan(Solver::Explicit, 0, 2, true)
    }
}

/// Compile-time facts about a scheme: what the generated step does and what the system conserves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// How the hardest block of the step is solved.
    pub solver: Solver,
    /// Size of the largest coupled block of unknowns: 0 if explicit, `usize::MAX` where only the state knows
    /// it.
    pub unknowns: usize,
    /// Order in `h` without noise.
    pub order: u32,
    /// How the noise enters.
    pub noise: NoiseClass,
    /// Whether the scheme converges to the Stratonovich system as `h -> 0`.
    pub consistent: bool,
    /// Whether the continuous system conserves the drift Hamiltonian: `{H_k, H_0} = 0` for every noise, no
    /// explicit time, and no jump of `H_0`.
    pub conserves_energy: Knowledge,
    /// Whether jumps that the text of `H_0` shows are the only reason why it is not conserved: then it is,
    /// from one jump to the next.
    pub energy_jumps: bool,
    /// Whether `{H_j, H_k}` is constant for all noises: then the strong order of a consistent scheme is one.
    pub commuting: Knowledge,
    /// Whether increments that are frozen over a step leave a weak order of two: the noises commute and
    /// `Σ_k {H_k, {H_k, H_0}}` is constant, as for `H_k = -σ q` with constant masses. [`Plan::weak_order`]
    /// has the rest.
    pub has_weak_order_two: bool,
    /// Whether the temperature of the bath depends on the time or on the degree of freedom: then no Boltzmann
    /// law is stationary.
    pub is_out_of_equilibrium: bool,
}

/// One line:
/// `linear step (one unknown) of order 2; multiplicative noise: strong order 1, weak order 1; the system keeps its energy`.
impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self.solver {
            Solver::Explicit => "explicit step",
            Solver::Linear => "linear step",
            Solver::Newton => "step by Newton's method",
        })?;
        match (self.solver, self.unknowns) {
            (Solver::Explicit, _) => {}
            (_, 1) => f.write_str(" (one unknown)")?,
            (_, usize::MAX) => f.write_str(" (unknowns by the size of the state)")?,
            (_, unknowns) => write!(f, " ({unknowns} unknowns)")?,
        }
        write!(f, " of order {}", self.order)?;
        let noise = match self.noise {
            NoiseClass::None => None,
            NoiseClass::Thermal => Some("noise of a bath"),
            NoiseClass::Additive => Some("additive noise"),
            NoiseClass::Position => Some("noise of positions"),
            NoiseClass::Momentum => Some("noise of momenta"),
            NoiseClass::Multiplicative => Some("multiplicative noise"),
        };
        match (noise, self.strong_order(), self.weak_order()) {
            (None, ..) => {}
            (Some(noise), Some(strong), Some(weak)) => {
                write!(f, "; {noise}: strong order {strong}, weak order {weak}")?;
            }
            (Some(noise), ..) => write!(f, "; {noise}: does not converge to the Stratonovich system")?,
        }
        f.write_str(match self.conserves_energy {
            Knowledge::Proven => "; the system keeps its energy",
            Knowledge::Refuted if self.energy_jumps => "; the system keeps its energy between its jumps",
            Knowledge::Refuted => "; the energy of the system changes",
            Knowledge::Unknown => "; whether the system keeps its energy is not known",
        })?;
        f.write_str(if self.is_out_of_equilibrium {
            "; no equilibrium: its temperatures differ or change"
        } else {
            ""
        })
    }
}

impl Plan {
    /// How deterministic runs of a variational step monitor their energy.
    pub const fn energy_watch(&self) -> EnergyWatch {
        match (self.noise, self.conserves_energy) {
            (NoiseClass::None, Knowledge::Proven) => EnergyWatch::FromStart,
            (NoiseClass::None, Knowledge::Unknown) => EnergyWatch::Undecided,
            (NoiseClass::None, Knowledge::Refuted) if self.energy_jumps => EnergyWatch::Discontinuous,
            _ => EnergyWatch::Never,
        }
    }

    /// The order in `h` of the root mean square error of paths driven by the same increments; `None` if the
    /// scheme does not converge to the Stratonovich system. It is 1 if the brackets of the noises are known
    /// to be constant, else 1/2, since increments alone determine no more of the path.
    pub const fn strong_order(&self) -> Option<f64> {
        match (self.noise, self.consistent, self.commuting) {
            (NoiseClass::None, ..) => Some(self.order as f64),
            (_, false, _) => None,
            (NoiseClass::Thermal, true, _) => Some(1.0),
            (_, true, Knowledge::Proven) => Some(1.0),
            (_, true, _) => Some(0.5),
        }
    }

    /// The order in `h` of the error of expectations of smooth functions; `None` as for
    /// [`Plan::strong_order`].
    ///
    /// The mean of a step with frozen increments of commuting noises is, with `L_k` the derivative along the
    /// flow of `H_k`,
    ///
    /// ```text
    /// E exp(h L_0 + Σ_k ΔW_k L_k) = exp(h (L_0 + ½ Σ_k L_k²)) - (h²/12) Σ_k [L_k, [L_k, L_0]] + O(h³)
    /// ```
    ///
    /// so that the order is two where `Σ_k {H_k, {H_k, H_0}}` is constant ([`Plan::has_weak_order_two`]), and
    /// one elsewhere. A step of order two adds terms of third order in `h H_0 + Σ_k ΔW_k H_k`. If all noises
    /// read coordinates alone, or momenta alone, or are affine, the mean of these is a multiple of the same
    /// sum. For other noises the step needs order four.
    pub const fn weak_order(&self) -> Option<f64> {
        let least = if matches!(self.noise, NoiseClass::Multiplicative) { 4 } else { 2 };
        match (self.noise, self.consistent) {
            (NoiseClass::None, _) => Some(self.order as f64),
            (_, false) => None,
            (NoiseClass::Thermal, true) => Some(self.order as f64),
            (_, true) if self.has_weak_order_two && self.order >= least => Some(2.0),
            (_, true) => Some(1.0),
        }
    }

    /// Whether the increments of random paths are truncated by default. They are if the step is implicit and
    /// noise enters its equations, since an unbounded increment could hit a pole of the scheme.
    pub const fn truncates_increments(&self) -> bool {
        !matches!(self.solver, Solver::Explicit)
            && !matches!(self.noise, NoiseClass::None | NoiseClass::Thermal | NoiseClass::Additive)
    }
}
