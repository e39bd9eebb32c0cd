//! The steps that the short way cannot take: solved from zero with a line search, then along the step as it grows.
//!
//! The equations of a step may have several solutions, and Newton's method from far away finds any of them. The right
//! one is connected with the state: it comes from no change at all as the Hamiltonian of the step, `λ (h H_0 + Σ_k ΔW_k
//! H_k)`, grows from `λ = 0` to 1, which is to solve the steps of size `λh` with increments `λΔW`. Where a solution is
//! not found beyond doubt ([`Effort::doubtful`]) it is followed along `λ = 1/n, 2/n, ... 1`, each start extrapolated from
//! those before. It is accepted if no part was in doubt, or if the parts become shorter as `n` grows, as those of a
//! continuous curve do: a jump to another solution stays as long as it is. A kink of `H` is passed in the second way. If
//! the curve ends before `λ = 1`, at the same place for every `n`, the step has no solution.
//!
//! A stiff force that is far from its balance swings many times along `λ`, and no reasonable `n` resolves that. Then the
//! solution from zero is taken if its Jacobian has the orientation of that for `λ = 0`, as the connected one has and the
//! next one has not, and the step is reported as doubtful.

use crate::carry::Carry;
use crate::error::StepFailure;
use crate::few::{Few, List};
use crate::memory::StepMemory;
use crate::scalar::Scalar;
use crate::solve::Effort;
use crate::state::Vector;
use crate::system::{Discretized, Hamiltonian};

/// Parts of a step in which its solution is followed, one after the other.
const PARTS: [u32; 3] = [4, 16, 64];
/// With four times as many parts the longest is half as long, even where the curve has the slope of a square root.
const SHRINKING: f64 = 0.6;

/// A step to take: its data, and what the steps before left.
///
/// By value, as is what comes back: the caller keeps its own in registers.
pub(crate) struct Hard<'a, H: Discretized<E>, E, C> {
    pub(crate) system: &'a H,
    pub(crate) prepared: H::Prepared,
    pub(crate) t: f64,
    pub(crate) h: f64,
    pub(crate) q: H::Vector,
    pub(crate) p: H::Vector,
    pub(crate) dw: List<'a, f64>,
    pub(crate) carry: C,
}

/// A step that was taken after all.
pub(crate) struct Continued<V, M, C> {
    pub(crate) q: V,
    pub(crate) p: V,
    pub(crate) memory: M,
    pub(crate) carry: C,
    pub(crate) effort: Effort,
}

pub(crate) type Taken<H, E, C> = Continued<<H as Hamiltonian>::Vector, <H as Discretized<E>>::Memory<f64>, C>;
type Outcome<H, E, C> = Result<Taken<H, E, C>, StepFailure>;

/// Takes a step that failed for `cause`.
///
/// # Errors
/// `cause` where nothing can be done about it, [`StepFailure::NoSolution`] where the solution ends, else what stands in
/// its way.
#[cold]
#[inline(never)]
pub(crate) fn solve_by_continuation<H: Discretized<E>, E, C: Carry<f64>>(
    hard: Hard<'_, H, E, C>,
    cause: StepFailure,
) -> Outcome<H, E, C> {
    let inputs = hard.q.components().iter().chain(hard.p.components()).chain(&*hard.dw).chain([&hard.t]);
    let is_hopeless = cause.is_of_arguments();
    if is_hopeless || inputs.into_iter().any(|x| !x.is_finite()) {
        return Err(cause);
    }
    let found = hard.solve(&hard.prepared, hard.h, &hard.dw, Default::default());
    match found {
        Ok(found) if !found.effort.doubtful => Ok(found),
        found => match hard.follow() {
            Ok(end) => Ok(end),
            Err(End { reached, is_fold: true }) => Err(StepFailure::NoSolution { reached }),
            Err(End { reached, is_fold: false }) => match found? {
                found if found.effort.is_reversed == hard.is_reversed_at_rest() => Ok(found),
                _ => Err(StepFailure::NoSolution { reached }),
            },
        },
    }
}

/// Where the curve of solutions could not be followed any further.
struct End {
    reached: f64,
    /// Whether it ends there, as far as two resolutions can tell.
    is_fold: bool,
}

impl<H: Discretized<E>, E, C: Carry<f64>> Hard<'_, H, E, C> {
    /// The step of size `h`, started from what `memory` extrapolates.
    fn solve(
        &self,
        prepared: &H::Prepared,
        h: f64,
        dw: &[f64],
        mut memory: H::Memory<f64>,
    ) -> Outcome<H, E, C> {
        let (mut q, mut p, mut carry) = (self.q.clone(), self.p.clone(), self.carry.clone());
        let (q_slice, p_slice) = (q.components_mut(), p.components_mut());
        let effort = self.system.advance_carrying::<f64, C, true>(
            prepared,
            self.t,
            h,
            q_slice,
            p_slice,
            dw,
            &mut memory,
            &mut carry,
        )?;
        Ok(Continued { q, p, memory, carry, effort })
    }

    fn follow(&self) -> Result<Taken<H, E, C>, End> {
        let mut ends = [0.0; PARTS.len()];
        let mut before: Option<f64> = None;
        for (end, parts) in ends.iter_mut().zip(PARTS) {
            match self.follow_in(parts) {
                Ok(curve) => {
                    let is_continuous = before.is_some_and(|longest| curve.longest <= SHRINKING * longest);
                    if is_continuous || !curve.is_doubtful {
                        return Ok(curve.end);
                    }
                    before = Some(curve.longest);
                    *end = 1.0;
                }
                Err(reached) => *end = reached,
            }
            // Not even a sixteenth of the step has a solution: shorter parts are no step of this size.
            if parts == PARTS[1] && *end == 0.0 {
                break;
            }
        }
        let [_, coarse, fine] = ends;
        // From one part before it to one part after, by the coarser of the two.
        let is_same = (fine - coarse).abs() <= 1.5 / f64::from(PARTS[1]);
        Err(End { reached: fine.min(coarse), is_fold: is_same && coarse > 0.0 && fine < 1.0 })
    }

    /// Whether the Jacobian of no step at all has a negative determinant.
    fn is_reversed_at_rest(&self) -> bool {
        let h = self.h * f64::EPSILON;
        let step = self.system.prepare(h).ok().and_then(|prepared| {
            let still = vec![0.0; self.dw.len()];
            self.solve(&prepared, h, &still, Default::default()).ok()
        });
        step.is_some_and(|step| step.effort.is_reversed)
    }

    /// The solution followed in equal parts, or where it ended.
    fn follow_in(&self, parts: u32) -> Result<Curve<H, E, C>, f64> {
        let mut many = Vec::new();
        let mut few = Few::of(&self.dw);
        let dw: &mut [f64] = match &mut few {
            Some(few) => few,
            None => {
                many.resize(self.dw.len(), 0.0);
                &mut many
            }
        };
        let d = self.q.components().len();
        let longest = [H::Vector::zeros(d), H::Vector::zeros(d)];
        let mut moves = Moves { from: [self.q.clone(), self.p.clone()], longest };
        let mut memory = H::Memory::default();
        let (mut iterations, mut is_doubtful) = (0, false);
        let mut part = 1;
        loop {
            let reached = f64::from(part - 1) / f64::from(parts);
            // Exactly 1 for the last.
            let fraction = f64::from(part) / f64::from(parts);
            for (scaled, dw) in dw.iter_mut().zip(&*self.dw) {
                *scaled = fraction * dw;
            }
            let h = fraction * self.h;
            let prepared = self.system.prepare(h).map_err(|_| reached)?;
            let step = self.solve(&prepared, h, dw, memory).map_err(|_| reached)?;
            iterations += step.effort.iterations;
            is_doubtful |= step.effort.doubtful;
            moves.add(&step.q, &step.p);
            if part == parts {
                let longest = moves.longest_relative_to([&self.q, &self.p]);
                // Whoever takes it has no doubt.
                let effort = Effort { iterations, doubtful: false, ..step.effort };
                let mut memory = step.memory;
                // Of parts of a step: no guide for the next.
                memory.forget();
                let end = Continued { q: step.q, p: step.p, carry: step.carry, effort, memory };
                return Ok(Curve { end, longest, is_doubtful });
            }
            memory = step.memory;
            part += 1;
        }
    }
}

/// The curve of solutions from no step to the whole one.
struct Curve<H: Discretized<E>, E, C> {
    end: Taken<H, E, C>,
    /// The longest part, relative to the whole way of its component.
    longest: f64,
    is_doubtful: bool,
}

/// How far the parts went, by component.
struct Moves<V> {
    from: [V; 2],
    longest: [V; 2],
}

impl<V: Vector> Moves<V> {
    fn add(&mut self, q: &V, p: &V) {
        for ((from, longest), to) in self.from.iter_mut().zip(&mut self.longest).zip([q, p]) {
            let components = from.components().iter().zip(longest.components_mut());
            for ((from, longest), to) in components.zip(to.components()) {
                *longest = longest.max((to - from).abs());
            }
            from.clone_from(to);
        }
    }

    /// The longest part of any component against its whole way from `start`.
    fn longest_relative_to(&self, start: [&V; 2]) -> f64 {
        let mut most = 0.0_f64;
        for ((end, longest), start) in self.from.iter().zip(&self.longest).zip(start) {
            let components = end.components().iter().zip(longest.components()).zip(start.components());
            for ((end, longest), start) in components {
                // A part is the difference of two states, and as uncertain as they are.
                let rounding = f64::EPSILON * (end.abs() + start.abs());
                most = most.max((longest - rounding).max(0.0).relative_to((end - start).abs()));
            }
        }
        most
    }
}
