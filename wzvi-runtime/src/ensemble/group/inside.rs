//! Between the nodes of a group: its dense output.

use super::scalar_path::subdivision_of;
use super::{Group, Systems};
use crate::algebra::state::State;
use crate::increments::Interval;
use crate::scheme::dense::DenseOutput;
use crate::scheme::system::Discretized;
use crate::trajectory::Error;

/// Sees the dense output of a part of a step, its increments, and whether it is the last part.
type SeeInside<'s, V> = &'s mut dyn FnMut(&DenseOutput<V>, &[f64], bool);

impl<H: Discretized<E>, E, P: Systems, const L: usize> Group<'_, '_, H, E, P, L> {
    /// Shows the step of a lane that led from `before` to this node, part by part if it was halved.
    ///
    /// # Errors
    /// The errors of steps that have been taken before, and of a noise that had increments for them: never.
    pub(in crate::ensemble) fn look_inside(
        &mut self,
        lane: usize,
        node: u64,
        before: &State<H::Vector>,
        dense: &mut DenseOutput<H::Vector>,
        see: SeeInside<'_, H::Vector>,
    ) -> Result<(), Error> {
        let (job, path, step) = (self.job, self.path(lane), node - 1);
        self.state_at(lane, node);
        self.increments_of(lane, step);
        let nodes = [before, &self.states[if self.is_stepped() { lane } else { 0 }]];
        let halvings = self.halvings_of(lane, step);
        if halvings > 0 {
            let subdivision = subdivision_of(&mut self.subdivision, job, path, self.size)?;
            let mut noise = (!self.scalar_increments.is_empty()).then(|| job.source.path(path));
            let interval = Interval { step, ..job.grid.first() };
            let mut parts = 1_u64 << halvings;
            let noise = &mut noise.as_deref_mut();
            return subdivision.revisit(before, interval, noise, halvings, &mut |stepper, nodes, dw| {
                parts -= 1;
                stepper.fill(nodes, dw, dense);
                see(dense, dw, parts == 0);
            });
        }
        match self.steppers.get(lane) {
            Some(stepper) if self.is_stepped() => stepper.fill(nodes, &self.scalar_increments, dense),
            _ => {
                debug_assert!(!H::PROPERTIES.has_polynomial, "a stepper keeps it");
                dense.fill_by_rates::<H, E>(job.system_of(path), nodes, self.size, &self.scalar_increments);
            }
        }
        see(dense, &self.scalar_increments, true);
        Ok(())
    }
}
