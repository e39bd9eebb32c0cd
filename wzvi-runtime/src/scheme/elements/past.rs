//! The unknowns of past steps, from which the next one starts.

use super::Quadrature;
use super::memory::{Lists, Memory, Scratch};
use crate::algebra::scalar::Scalar;

impl<S: Scalar> Scratch<'_, S> {
    /// Extrapolates the unknowns of past steps: `3x_n - 3x_{n-1} + x_{n-2}`, to a lower order if fewer are `known`, zero if none are.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn guess(&mut self, known: u8) {
        let x = &mut *self.lists.x;
        if known == 0 {
            return x.fill(S::from_f64(0.0));
        }
        let [a, b, c] = self.solver.past.each_ref().map(|past| &past[..x.len()]);
        match known {
            1 => x.copy_from_slice(a),
            2 => {
                for (x, (&a, &b)) in x.iter_mut().zip(a.iter().zip(b)) {
                    *x = a * 2.0 - b;
                }
            }
            _ => {
                for (x, ((&a, &b), &c)) in x.iter_mut().zip(a.iter().zip(b).zip(c)) {
                    *x = (a - b) * 3.0 + c;
                }
            }
        }
    }
}

impl<S: Scalar> Memory<S> {
    /// Records the unknowns of a successful step.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn record(&mut self, scheme: &Quadrature, degrees: usize) {
        let Lists { x, .. } = self.work.lists(scheme, degrees);
        if self.solver.past[0].len() != x.len() {
            self.solver.past.iter_mut().for_each(|past| past.resize(x.len(), S::from_f64(0.0)));
        }
        self.solver.past.rotate_right(1);
        self.solver.past[0].copy_from_slice(x);
        self.count_past();
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn count_past(&mut self) {
        self.known = (self.known + 1).min(3);
    }
}
