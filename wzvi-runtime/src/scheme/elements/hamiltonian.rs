//! Sums of elements as a Hamiltonian: values and derivatives of one Hamiltonian from those of its role.

use std::cell::Cell;
use std::ops::Range;

use super::{Elements, EvaluationPoint, PairColumns, Partials, Role, check, places, slopes};
use crate::algebra::scalar::Scalar;
use crate::algebra::state::{State, Vector};
use crate::error::{ConfigError, StepFailure};
use crate::ground::variables::Variables;
use crate::scheme::constraints::Manifold;
use crate::scheme::system::{Gradient, Hamiltonian, Kind};

/// Whether `q` and `p` are those of a state of the system.
pub(super) fn fits<H: Elements, S>(system: &H, q: &[S], p: &[S]) -> bool {
    // An empty sum is 0.
    let is_empty = q.is_empty() && system.degrees() == 0 && places::check(system, 0).is_ok();
    q.len() == p.len() && (is_empty || check(system, q.len()).is_ok())
}

/// The role of Hamiltonian `term`, and its acting noises.
fn role_of(term: usize) -> (Role, Range<usize>) {
    match term.checked_sub(1) {
        None => (Role::Drift, 0..0),
        Some(noise) => (Role::Noise, noise..term),
    }
}

/// The forces beside the drift; `into` is zero.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn forces<H: Elements, S: Scalar>(
    system: &H,
    at: &EvaluationPoint<'_, S>,
    into: &mut [S],
    columns: &mut PairColumns,
) {
    slopes(system, Role::Force.times(1.0), at, Partials::BY_COORDINATES, into, &mut [], columns);
    into.iter_mut().for_each(|slope| *slope = -*slope);
}

thread_local! {
    /// The columns of queries, which have no memory of their own. Steps have theirs.
    static COLUMNS: Cell<PairColumns> = const { Cell::new(PairColumns::EMPTY) };
}

/// Asks with the columns of this thread; with others where they are in use, or already destroyed.
fn with_columns(ask: impl FnOnce(&mut PairColumns)) {
    let mut columns = COLUMNS.try_with(Cell::take).unwrap_or_default();
    ask(&mut columns);
    COLUMNS.try_with(|kept| kept.set(columns)).unwrap_or_default();
}

/// For users and for schemes that need no more than a Hamiltonian. States that do not fit give NaN.
impl<H: Elements> Hamiltonian for H {
    type Vector = <H as Elements>::Vector;
    const KIND: Kind = H::FACTS.kind;

    fn degrees(&self) -> usize {
        Elements::degrees(self)
    }

    fn check(&self, degrees: usize) -> Result<(), StepFailure> {
        check(self, degrees)
    }

    fn friction_rate(&self) -> f64 {
        Elements::friction_rate(self, &[])
    }

    fn validate(&self) -> Result<(), ConfigError> {
        Elements::validate(self)
    }

    fn manifold(&self) -> Option<&dyn Manifold> {
        Elements::manifold(self)
    }

    fn noises(&self) -> usize {
        Elements::noises(self)
    }

    fn invariants(&self) -> usize {
        Elements::invariants(self)
    }

    fn observables(&self) -> usize {
        Elements::observables(self)
    }

    fn variables(&self) -> Variables {
        Elements::variables(self)
    }

    fn parameter(&self, index: usize) -> Option<(&'static str, f64)> {
        Elements::parameter(self, index)
    }

    fn integers(&self) -> &'static [usize] {
        Elements::integers(self)
    }

    fn evaluate<S: Scalar>(&self, term: usize, q: &[S], p: &[S], t: f64) -> S {
        if term > self.noises() || !fits(self, q, p) {
            return S::from_f64(f64::NAN);
        }
        let (dw, (role, acting)) = ([S::from_f64(1.0)], role_of(term));
        self.value(
            role,
            1.0,
            &EvaluationPoint { acting, ..EvaluationPoint::new([q, p], Scalar::from_f64(t), &[], &dw) },
        )
    }

    fn differentiate<S: Scalar>(
        &self,
        term: usize,
        q: &[S],
        p: &[S],
        t: f64,
        by_q: &mut [S],
        by_p: &mut [S],
    ) {
        let is_known =
            term <= self.noises() && fits(self, q, p) && by_q.len() == q.len() && by_p.len() == q.len();
        let start = S::from_f64(if is_known { 0.0 } else { f64::NAN });
        by_q.fill(start);
        by_p.fill(start);
        if is_known {
            let (dw, (role, acting)) = ([S::from_f64(1.0)], role_of(term));
            let at =
                EvaluationPoint { acting, ..EvaluationPoint::new([q, p], Scalar::from_f64(t), &[], &dw) };
            with_columns(|columns| slopes(self, role.times(1.0), &at, Partials::ALL, by_q, by_p, columns));
        }
    }

    fn differentiate_noises(&self, dw: &[f64], state: &State<H::Vector>, into: &mut Gradient<H::Vector>) {
        let (q, p) = (state.q.components(), state.p.components());
        let [by_q, by_p] = [&mut into.q, &mut into.p].map(Vector::components_mut);
        let is_known =
            dw.len() == self.noises() && fits(self, q, p) && by_q.len() == q.len() && by_p.len() == q.len();
        let start = if is_known { 0.0 } else { f64::NAN };
        by_q.fill(start);
        by_p.fill(start);
        if is_known {
            let at =
                EvaluationPoint { acting: 0..dw.len(), ..EvaluationPoint::new([q, p], state.t, &[], dw) };
            with_columns(|columns| {
                slopes(self, Role::Noise.times(1.0), &at, Partials::ALL, by_q, by_p, columns)
            });
        }
    }

    fn force<S: Scalar>(&self, q: &[S], p: &[S], t: f64, into: &mut [S]) {
        let is_known = fits(self, q, p) && into.len() == q.len();
        into.fill(S::from_f64(if is_known { 0.0 } else { f64::NAN }));
        if is_known && H::FACTS.kind.is_forced {
            let at = EvaluationPoint::new([q, p], Scalar::from_f64(t), &[], &[]);
            with_columns(|columns| forces(self, &at, into, columns));
        }
    }

    fn invariant(&self, number: usize, state: &State<H::Vector>) -> f64 {
        value_beside(self, Role::Integral(number), number < self.invariants(), state)
    }

    fn observable(&self, number: usize, state: &State<H::Vector>) -> f64 {
        value_beside(self, Role::Observable(number), number < self.observables(), state)
    }
}

/// The value of what is declared beside the Hamiltonians; NaN if it is not, or the state does not fit.
fn value_beside<H: Elements>(system: &H, role: Role, is_known: bool, state: &State<H::Vector>) -> f64 {
    let (q, p) = (state.q.components(), state.p.components());
    if !is_known || !fits(system, q, p) {
        return f64::NAN;
    }
    system.value(role, 1.0, &EvaluationPoint::new([q, p], state.t, &[], &[]))
}
