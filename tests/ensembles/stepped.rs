//! A path by a stepper, which those of ensembles are.

use wzvi::error::StepError;
use wzvi::increments::Interval;
use wzvi::prelude::*;
use wzvi::state::Vector;
use wzvi::step::StepInfo;

/// Takes `state` along plain steps with the increments of `noise`, up to the first that fails: what each step says, and the error.
pub(crate) fn stepped<E, H: Discretized<E>>(
    system: &H,
    h: f64,
    state: &mut State<H::Vector>,
    mut noise: impl Noise,
    steps: u64,
) -> (Vec<StepInfo>, Option<StepError>) {
    let mut stepper = system.stepper::<E>(h).unwrap().plain();
    let (start, mut dw) = (state.t, vec![0.0; system.increments(state.q.components().len())]);
    noise.prepare(&H::PLAN, h, dw.len(), start).unwrap();
    let mut infos = Vec::new();
    let error = (0..steps).find_map(|step| {
        noise.increments(&Interval { start, h, step }, &mut dw).unwrap();
        stepper.step(state, &dw).map(|info| infos.push(info)).err()
    });
    (infos, error)
}
