//! The discrete Lagrangian of a composed step.

use crate::algebra::state::Vector;
use crate::scheme::system::Segment;

/// The end of a sequence of parts: `Q`, `R`, and the sum `A` of their discrete Lagrangians.
#[derive(Clone, Debug)]
pub(crate) struct SequenceEnd<V> {
    pub(crate) q: V,
    pub(crate) p: V,
    pub(crate) action: f64,
}

/// `L_d = A + R · (q_{i+1} - Q)`; NaN if a part of the step has no solution, or sizes do not fit.
pub(crate) fn value<V: Vector>(
    segment: &Segment<V>,
    dw: &[f64],
    noises: usize,
    follow: impl FnOnce() -> Option<SequenceEnd<V>>,
) -> f64 {
    if segment.q0.components().len() != segment.p.components().len() || dw.len() != noises {
        return f64::NAN;
    }
    follow().map_or(f64::NAN, |SequenceEnd { q, p, action }| {
        let gaps = segment.q1.components().iter().zip(q.components()).map(|(q1, q)| q1 - q);
        action + p.components().iter().zip(gaps).map(|(p, gap)| p * gap).sum::<f64>()
    })
}
