//! Whether a step is too long for the fastest motion, and whether that does harm.
//!
//! A stiff direction of frequency `ω >> 1/h` turns by nearly `π` in a mid-point step: its part of the motion alternates,
//! with an envelope of frequency `Ω = 4 / (ω h²)`. A linear force is solved rightly all the same. Where the stiff direction
//! turns with the slow motion, at the angular velocity `v`, the envelope loses its stability once `Ω` is below about
//! `0.6 v`: the alternating part then grows without bound although every step is solved to the last digit (U. Ascher and S.
//! Reich, "The midpoint scheme and variants for Hamiltonian systems", SIAM J. Sci. Comput. 21, 1999, describe the failure).
//! On the way there the energy at the nodes is off by `v² / 8Ω²` of twice the kinetic energy.
//!
//! What is watched is therefore: three steps in a row whose unknowns are not what the steps before extrapolate to, not even
//! in sign and size (each was hard, see [`StepInfo::is_hard`](super::StepInfo)), and an energy that differs from that where the
//! first hard step began by more than a quarter of the largest `|P · Δq / h|` and by more than the rounding of its own terms. It costs
//! nothing until a step is hard.

use crate::carry::Carry;
use crate::continuation::{Continued, Hard, Taken, solve_by_continuation};
use crate::error::StepFailure;
use crate::plan::{Knowledge, NoiseClass};
use crate::scalar::Rounded;
use crate::state::{State, Vector};
use crate::system::{Discretized, Hamiltonian};

/// Hard steps in a row that make a pattern.
const PATTERN: u64 = 3;
/// The energy error, in units of `|P · Δq / h|`, that no resolved motion has: `v² / 8Ω²` with `Ω = v / √2`.
const HARMFUL: f64 = 0.25;

/// What was seen of the hard steps of a run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ResolutionMonitor {
    is_ignored: bool,
    /// Hard steps in a row, and the number of the last.
    pattern: u64,
    last: u64,
    /// `H` where the first hard step of the run began; NaN before.
    energy: f64,
    /// The largest `|P · Δq / h|` of the hard steps.
    scale: f64,
}

/// What rounding does to the energy at all states that round to this one.
#[cold]
fn rounding_of_energy<H: Hamiltonian>(system: &H, state: &State<H::Vector>) -> f64 {
    let lift =
        |of: &H::Vector| -> Vec<Rounded> { of.components().iter().copied().map(Rounded::nearest).collect() };
    system.evaluate(0, &lift(&state.q), &lift(&state.p), state.t).error
}

impl Default for ResolutionMonitor {
    fn default() -> Self {
        Self { is_ignored: false, pattern: 0, last: 0, energy: f64::NAN, scale: 0.0 }
    }
}

impl ResolutionMonitor {
    pub(super) fn ignored() -> Self {
        Self { is_ignored: true, ..Self::default() }
    }

    pub(super) fn restarted(self) -> Self {
        Self { is_ignored: self.is_ignored, ..Self::default() }
    }

    /// Takes step number `step`, which failed for `cause` in the short way, from zero and with care. By value, as all of [`Hard`]: the
    /// caller keeps its own in registers.
    ///
    /// # Errors
    /// Those of [`solve_by_continuation`], and [`StepFailure::Unresolved`] where it does harm.
    #[inline(always)]
    pub(crate) fn careful_step<H: Discretized<E>, E, C: Carry<f64>>(
        self,
        hard: Hard<'_, H, E, C>,
        step: u64,
        cause: StepFailure,
    ) -> Result<(Taken<H, E, C>, Self), StepFailure> {
        let (system, h, t) = (hard.system, hard.h, hard.t);
        let from = State { q: hard.q.clone(), p: hard.p.clone(), t };
        let solved = solve_by_continuation(hard, cause)?;
        let to = State { q: solved.q, p: solved.p, t };
        let watched = self.after::<H, E>(system, &from, &to, h, step)?;
        Ok((Continued { q: to.q, p: to.p, ..solved }, watched))
    }

    /// With the hard step number `step` from `from` to `to`.
    ///
    /// # Errors
    /// [`StepFailure::Unresolved`] if it does harm; only where the energy is known to be kept by the continuous system.
    #[cold]
    #[inline(never)]
    fn after<H: Discretized<E>, E>(
        mut self,
        system: &H,
        from: &State<H::Vector>,
        to: &State<H::Vector>,
        h: f64,
        step: u64,
    ) -> Result<Self, StepFailure> {
        let keeps_energy = matches!(H::PLAN.noise, NoiseClass::None)
            && matches!(H::PLAN.conserves_energy, Knowledge::Proven);
        if self.is_ignored || !keeps_energy {
            return Ok(self);
        }
        self.pattern = if self.last + 1 == step { self.pattern + 1 } else { 1 };
        self.last = step;
        // Steps that were not hard have kept it.
        if self.energy.is_nan() {
            self.energy = system.energy(from);
        }
        let (q0, q1) = (from.q.components(), to.q.components());
        let (p0, p1) = (from.p.components(), to.p.components());
        let moved = q1.iter().zip(q0).zip(p1.iter().zip(p0));
        let action: f64 = moved.map(|((q1, q0), (p1, p0))| 0.5 * (p0 + p1) * (q1 - q0)).sum();
        self.scale = self.scale.max((action / h).abs());
        if self.pattern >= PATTERN {
            let energy_error = (system.energy(to) - self.energy).abs();
            // The terms of both energies are of the same size.
            let rounding = || 2.0 * rounding_of_energy(system, to).max(rounding_of_energy(system, from));
            let harmful = HARMFUL * self.scale;
            if energy_error > harmful && energy_error > harmful + rounding() {
                return Err(StepFailure::Unresolved { energy_error, scale: self.scale });
            }
        }
        Ok(self)
    }

    /// What a checkpoint keeps.
    #[cfg(feature = "serde")]
    pub(super) fn pass(&mut self, tape: &mut crate::numbers::Tape) {
        let Self { is_ignored: _, pattern, last, energy, scale } = self;
        tape.word(pattern);
        tape.word(last);
        tape.numbers([energy, scale]);
    }
}
