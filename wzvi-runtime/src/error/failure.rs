//! Why a step failed.

use super::internal::MISTAKE;
use super::{BathError, FailedLanes, IndexError, StepPromise};

/// Why a step failed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepFailure {
    /// Newton's method, or a pinned fixed point, neither converged nor stagnated at rounding level.
    NotConverged {
        /// Iterations spent.
        iterations: u32,
        /// The last correction relative to the unknown, largest component.
        correction: f64,
    },
    /// The matrix of the step is singular to working precision: its smallest pivot against its largest entry.
    Singular {
        /// Absolute value of the pivot.
        pivot: f64,
        /// Largest absolute value in the matrix.
        scale: f64,
    },
    /// The solution that continues the state could not be followed from a step of size zero to the whole
    /// step.
    NoSolution {
        /// Fraction of the step, of `h` and of the increments, up to which there is one.
        reached: f64,
    },
    /// The steps are too long for the motion. Either the energy has been off by more than a tenth of the size
    /// of the motion for 64 steps, or the halves of a divided step do not agree.
    Unresolved {
        /// The smallest change of the energy over these steps, or the difference between the halves, in units
        /// of energy.
        energy_error: f64,
        /// The mean of `|p · Δq / h|` so far, twice the kinetic energy of a mechanical system.
        scale: f64,
        /// Whether a jump of `H` may be the cause instead: no proof says that it is continuous.
        may_jump: bool,
    },
    /// The state is finite, and its energy is not a number: a step left the domain of `H`.
    UndefinedEnergy,
    /// Only in [derivatives](crate::trajectory::simulate::Simulation::tangent): dual numbers solve each step
    /// anew, and found another solution than the step, or did not come back to its start.
    OtherSolution {
        /// The difference between the two relative to the length of the step, largest component.
        apart: f64,
    },
    /// The sweeps of a Gauss method do not contract, and its equations are too many for Newton's method,
    /// which factors one matrix of all stages.
    TooManyUnknowns {
        /// Unknowns of all stages.
        unknowns: usize,
        /// The largest number that is factored.
        most: usize,
    },
    /// No step of this size ends on the manifold of the constraints: the way along the tangent is long
    /// against the radius of curvature. On a sphere there is no end beyond the radius.
    BeyondCurvature {
        /// The number of the constraint, from 0; the message counts from 1, as `EQUATIONS` does.
        constraint: usize,
        /// The way `h |v|` of the coordinates that it reads, in their units.
        length: f64,
        /// The radius of curvature along this way, likewise: their ratio is taken in the metric of the
        /// masses.
        radius: f64,
    },
    /// A constraint follows from the others at the state, or may follow from them within the step: its
    /// gradient is a combination of theirs, as where a linkage is folded. Or it moves no positive mass.
    Dependent {
        /// The number of the constraint, from 0; the message counts from 1, as `EQUATIONS` does.
        constraint: usize,
    },
    /// The state is not on the manifold of the constraints.
    OffManifold {
        /// The relative distance of the coordinates:
        /// [`Distance::coordinates`](crate::scheme::constraints::Distance::coordinates).
        coordinates: f64,
        /// The relative distance of the momenta:
        /// [`Distance::momenta`](crate::scheme::constraints::Distance::momenta).
        momenta: f64,
    },
    /// No point of the manifold of the constraints was found near a state.
    NoProjection {
        /// Corrections.
        iterations: u32,
        /// The largest constraint that is left, relative to its terms.
        residual: f64,
    },
    /// The [clock](crate::scheme::clock) of the system is not positive at the state.
    ClockNotPositive {
        /// Its value, in units of time.
        value: f64,
    },
    /// The density of a [clock](crate::scheme::clock) would not stay positive: the clock changes by its own
    /// size within a step.
    ClockTooCoarse {
        /// The density that came out, in units of 1/time.
        density: f64,
    },
    /// An [event](crate::trajectory::events) happens again and again within one step, as the bounces of a
    /// ball that comes to rest.
    TooManyEvents {
        /// The time of the last one.
        t: f64,
        /// How many happened in the step.
        events: usize,
    },
    /// In the flow of a Kepler problem, a body meets its centre: it has no angular momentum to rounding, or
    /// starts there. The motion ends with the collision.
    Collision {
        /// The number of the body, from 0, in the order of the coordinates; the message counts likewise.
        body: usize,
    },
    /// The new state (or an intermediate value) overflowed or is undefined.
    NonFinite,
    /// The new state is not finite, and neither is a parameter of the system, the probable cause.
    Infinite {
        /// Its name in the Hamiltonians.
        parameter: &'static str,
    },
    /// The number of increments is not the number that a step needs.
    Increments {
        /// Number of noises, and of the normals of a bath.
        expected: usize,
        /// Number of increments given.
        got: usize,
    },
    /// The state does not have the degrees of freedom of the system.
    Dimension {
        /// Degrees of freedom.
        expected: usize,
        /// Components given.
        got: usize,
    },
    /// An integer of the system is out of range.
    Index(IndexError),
    /// Friction, temperature or masses are invalid at this state.
    Bath(BathError),
    /// The state or an increment that was given is NaN or infinite.
    NonFiniteInput,
    /// Only in a step of several paths in lanes: the paths of these lanes could not take the step and are
    /// unchanged, the others have taken it. A step of one of them alone reports the cause.
    Lanes(FailedLanes),
    /// A bug of wzvi: an assumption of the step does not hold. The state is unchanged.
    Internal(StepPromise),
}

impl StepFailure {
    /// Whether no way to solve the step would change it: the system, the state and the increments do not
    /// belong together.
    pub(crate) fn is_of_arguments(&self) -> bool {
        matches!(
            self,
            Self::Increments { .. }
                | Self::Dimension { .. }
                | Self::Index(_)
                | Self::Bath(_)
                | Self::Internal(_)
                | Self::Dependent { .. }
                | Self::OffManifold { .. }
                | Self::NoProjection { .. }
        )
    }
}

messages! { StepFailure:
    Self::NotConverged { iterations, correction } =>
        "the equations of the step are not solved after {iterations} iterations (last correction {correction:.1e}); \
         take a smaller step";
    Self::Singular { pivot, scale } =>
        "the matrix of the step is singular (pivot {pivot:.1e} at scale {scale:.1e}), a pole of the scheme; \
         take a smaller step or truncate the increments";
    Self::ClockNotPositive { value } =>
        "the clock is {value:e} at the state, and a clock is positive: \
         start elsewhere, or give the system a clock that is positive where the path goes";
    Self::ClockTooCoarse { density } =>
        "the clock changes by more than its size within a step (density {density:.1e}): take a smaller `Eps`";
    Self::TooManyEvents { t, events } =>
        "events accumulate at t = {} ({events} in this step): infinitely many in finite time have no continuation; \
         end the run with `Terminal` before that, or take a shorter step where they are only many",
        crate::ground::digits::ShortestDecimal(*t);
    Self::NoSolution { reached } =>
        "the solution that continues the state could not be followed beyond {:.0} % of the step; \
         take a smaller step, or subdivide with `.retry(Retry::halving(n))`", 100.0 * reached;
    Self::Unresolved { energy_error, scale, may_jump: false } =>
        "the step is too long for the motion: the energy is off by {energy_error:.1e}, and stays off, where the \
         mean of p · dq/dt is {scale:.1e}; take a smaller step, subdivide with `.retry(Retry::halving(n))`, or check the \
         energy yourself with `.unwatched()`";
    Self::Unresolved { energy_error, scale, may_jump: true } =>
        "the step is too long for the motion, or H jumps: the energy is off by {energy_error:.1e}, and stays off, where the \
         mean of p · dq/dt is {scale:.1e}; if H is continuous, take a smaller step, or subdivide with \
         `.retry(Retry::halving(n))`; if it jumps, check the energy yourself with `.unwatched()`";
    Self::UndefinedEnergy =>
        "the energy of the new state is not a number: the step left the domain of H; take a smaller step, subdivide with \
         `.retry(Retry::halving(n))`, or check the energy yourself with `.unwatched()`";
    Self::OtherSolution { apart } =>
        "dual numbers found another end of the step, {apart:.1e} of its length away, so the derivative is not known: its equations have \
         several solutions, the steps are unstable, so that the way back is lost in rounding, or `adjoint` names a scheme that is not the adjoint one; \
         take a smaller step";
    Self::TooManyUnknowns { unknowns, most } =>
        "sweeps over the stages do not contract, and Newton's method would have to factor {unknowns} unknowns, more than {most}; \
         take a smaller step";
    Self::BeyondCurvature { constraint, length, radius } =>
        "no end of the step is on the manifold of constraint g{}: the way h |v| = {length:.3e} is long against its radius of curvature \
         {radius:.3e}; take a smaller step, or subdivide with `.retry(Retry::halving(n))`", constraint + 1;
    Self::Dependent { constraint } =>
        "constraint g{} follows from the others at this state or near it: its gradient is a combination of theirs, as where a linkage is \
         folded; leave it out, go past the fold with other steps, or check that masses are positive and finite", constraint + 1;
    Self::OffManifold { coordinates, momenta } =>
        "the state is not on the manifold of the constraints: its coordinates are off by {coordinates:.1e} and its momenta by {momenta:.1e} of \
         the terms of a constraint; give one that is, or add `.project_start()`";
    Self::NoProjection { iterations, residual } =>
        "no point of the manifold of the constraints was found near the state: after {iterations} corrections, a constraint is {residual:.1e} of \
         its terms; give a state nearer to the manifold, and check the numbers in the constraints";
    Self::Collision { body } =>
        "body {body} (from 0) of a Kepler problem meets its centre within the step, where its motion ends; end the run before, or give \
         the body angular momentum";
    Self::NonFinite => "the new state is not finite; take a smaller step or check the domain of H";
    Self::Infinite { parameter } =>
        "the new state is not finite, and the parameter `{parameter}` of the system is infinite; give it a finite value, or take a smaller \
         step where the Hamiltonian is finite with it";
    Self::Increments { expected, got } =>
        "the system has {expected} noise{}, but {got} increment{} given",
        if *expected == 1 { "" } else { "s" }, if *got == 1 { " was" } else { "s were" };
    Self::Dimension { expected, got: 0 } =>
        "q or p is empty; a run of the system needs {expected} degree{} of freedom at least",
        if *expected == 1 { "" } else { "s" };
    Self::Dimension { expected, got } =>
        "q and p must have {expected} component{} each, but one of them has {got}",
        if *expected == 1 { "" } else { "s" };
    Self::Index(error) => "{error}";
    Self::Bath(error) => "{error}";
    Self::Lanes(_) => "the step failed in some lanes";
    Self::Internal(promise) => "{MISTAKE}: {promise}";
    Self::NonFiniteInput => "the state or an increment is NaN or infinite before the step";
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The advice of each message: a shorter step, never a longer one.
    #[test]
    fn every_message_ends_with_its_remedy() {
        let halving = "take a smaller step, or subdivide with `.retry(Retry::halving(n))`";
        let advised = [
            (StepFailure::NotConverged { iterations: 50, correction: 0.1 }, "take a smaller step"),
            (
                StepFailure::Singular { pivot: 0.0, scale: 1.0 },
                "take a smaller step or truncate the increments",
            ),
            (StepFailure::NoSolution { reached: 0.5 }, halving),
            (StepFailure::OtherSolution { apart: 0.5 }, "take a smaller step"),
            (StepFailure::TooManyUnknowns { unknowns: 2000, most: 1500 }, "take a smaller step"),
            (StepFailure::NonFinite, "take a smaller step or check the domain of H"),
        ];
        for (failure, remedy) in advised {
            let message = failure.to_string();
            assert!(message.ends_with(&format!("; {remedy}")), "{message}");
        }
        let unresolved =
            |may_jump| StepFailure::Unresolved { energy_error: 0.2, scale: 1.0, may_jump }.to_string();
        for watched in [unresolved(false), StepFailure::UndefinedEnergy.to_string()] {
            assert!(
                watched.contains("; take a smaller step, subdivide with `.retry(Retry::halving(n))`, or "),
                "{watched}"
            );
        }
        let undecided = unresolved(true);
        let causes =
            ["too long for the motion, or H jumps", "take a smaller step, or subdivide", "`.unwatched()`"];
        assert!(causes.iter().all(|said| undecided.contains(said)), "{undecided}");
    }
}
