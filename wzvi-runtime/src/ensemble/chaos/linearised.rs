//! A system together with two deviations from its path, and the growth of the first: the state of a larger
//! step.
//!
//! ```text
//! (q, δ_1 q, δ_2 q, ln |δ_1|, Σ k l_k),   (p, δ_1 p, δ_2 p, Σ Y_k, max ln |δ_1|)
//! ```
//!
//! A step is one of the system in dual numbers, whose parts are lanes where the step is in lanes. Then
//! deviations are divided by their lengths. All that runs paths of an ensemble runs these: lanes, threads,
//! checkpoints.
#![expect(clippy::needless_range_loop, reason = "plain loops over arrays are what becomes vector code")]

use std::array::from_fn;

use nalgebra::DVector;

use crate::algebra::memory::{StepMemory, step_memory};
use crate::algebra::scalar::{ComputesWith, Constant, Dual, Mask, Scalar};
use crate::algebra::solve::Effort;
use crate::algebra::state::{State, Vector};
use crate::algebra::state_sum::PlainSum;
use crate::error::{ConfigError, StepFailure};
use crate::scheme::plan::{Plan, Solver};
use crate::scheme::system::{
    Discretized, Hamiltonian, LiftParameter, MemoryOf, Movable, PreparedOf, Properties, Scheme, SchemeOf,
    StepArguments, anew, as_they_are, fits,
};
use crate::trajectory::chaos::Growth;

/// Deviations of a path.
pub(super) const NUMBER: usize = 2;
/// The sums in the list of the coordinates, and in that of the momenta.
const SUMS: usize = 2;

type LinearisedNumber<S> = Dual<NUMBER, S>;

/// A system with deviations.
#[derive(Debug)]
pub(crate) struct Linearised<'a, H> {
    pub(super) system: &'a H,
    /// The time of the start and the step size of a run.
    pub(super) start: f64,
    pub(super) h: f64,
}

/// The steps of `E` in such a system.
#[derive(Debug)]
pub(crate) enum WithDeviations<E> {
    #[expect(dead_code, reason = "a type alone")]
    Of(std::marker::PhantomData<fn() -> E>),
}

/// The length of a list for so many degrees of freedom.
fn length(degrees: usize) -> usize {
    (1 + NUMBER) * degrees + SUMS
}

/// The degrees of freedom of a list of this length.
fn degrees(length: usize) -> usize {
    length.saturating_sub(SUMS) / (1 + NUMBER)
}

/// The state of a path with deviations at its start.
pub(super) fn lifted<V: Vector>(state: &State<V>, deviations: &[Vec<f64>]) -> State<DVector<f64>> {
    let Growth { ln_length, weighted, means, fli } = Growth::<f64>::new();
    let list = |vector: &V, first: usize, sums: [f64; SUMS]| {
        let own = vector.components();
        let mut list = own.to_vec();
        deviations.iter().for_each(|deviation| list.extend_from_slice(&deviation[first..first + own.len()]));
        list.extend(sums);
        DVector::from_vec(list)
    };
    let q = list(&state.q, 0, [ln_length, weighted]);
    let p = list(&state.p, state.q.components().len(), [means, fli]);
    State { q, p, t: state.t }
}

/// The deviations of a state, and the growth of the first.
pub(super) fn parts(state: &State<DVector<f64>>) -> ([Vec<f64>; NUMBER], Growth<f64>) {
    let degrees = degrees(state.q.len());
    let deviation = |number: usize| {
        let range = (1 + number) * degrees..(2 + number) * degrees;
        [&state.q.as_slice()[range.clone()], &state.p.as_slice()[range]].concat()
    };
    (from_fn(deviation), growth([state.q.as_slice(), state.p.as_slice()]))
}

fn growth<S: Scalar>([q, p]: [&[S]; 2]) -> Growth<S> {
    let first = q.len() - SUMS;
    Growth { ln_length: q[first], weighted: q[first + 1], means: p[first], fli: p[first + 1] }
}

impl<H: Hamiltonian> Hamiltonian for Linearised<'_, H> {
    type Vector = DVector<f64>;

    fn degrees(&self) -> usize {
        match self.system.degrees() {
            0 => 0,
            degrees => length(degrees),
        }
    }

    fn check(&self, number: usize) -> Result<(), StepFailure> {
        if fits(self, number) && number == length(degrees(number)) {
            return self.system.check(degrees(number));
        }
        Err(StepFailure::Dimension { expected: self.system.degrees().max(1), got: degrees(number) })
    }

    fn validate(&self) -> Result<(), ConfigError> {
        self.system.validate()
    }

    fn noises(&self) -> usize {
        self.system.noises()
    }

    fn parameter(&self, index: usize) -> Option<(&'static str, f64)> {
        self.system.parameter(index)
    }

    fn integers(&self) -> &'static [usize] {
        self.system.integers()
    }

    fn evaluate<S: Scalar>(&self, term: usize, q: &[S], p: &[S], t: f64) -> S {
        let degrees = degrees(q.len());
        match (q.get(..degrees), p.get(..degrees)) {
            (Some(q), Some(p)) => self.system.evaluate(term, q, p, t),
            _ => S::from_f64(f64::NAN),
        }
    }

    fn differentiate<S: Scalar>(&self, term: usize, q: &[S], p: &[S], t: f64, dq: &mut [S], dp: &mut [S]) {
        let degrees = degrees(q.len());
        [&mut *dq, &mut *dp].into_iter().for_each(|list| list.fill(S::from_f64(0.0)));
        if let (Some(q), Some(p), Some(dq), Some(dp)) =
            (q.get(..degrees), p.get(..degrees), dq.get_mut(..degrees), dp.get_mut(..degrees))
        {
            self.system.differentiate(term, q, p, t, dq, dp);
        }
    }
}

/// The constants of the system, which all paths share, in any kind of number.
#[derive(Clone, Debug)]
pub(crate) struct LinearisedConstants<P>(P);

/// The memory of steps of the system, and room for its numbers.
#[derive(Debug)]
pub(crate) struct LinearisedMemory<M, S: Scalar> {
    inner: M,
    q: Vec<LinearisedNumber<S>>,
    p: Vec<LinearisedNumber<S>>,
    dw: Vec<LinearisedNumber<S>>,
}

impl<M: Default, S: Scalar> Default for LinearisedMemory<M, S> {
    fn default() -> Self {
        Self { inner: M::default(), q: Vec::new(), p: Vec::new(), dw: Vec::new() }
    }
}

step_memory! {
    impl[M: StepMemory, S: Scalar] StepMemory for LinearisedMemory<M, S> { kept: inner; scratch: q, p, dw }
}

impl<H: Discretized<E>, E> Discretized<WithDeviations<E>> for Linearised<'_, H> {
    type Scheme = WithDeviations<E>;
    type Prepared = LinearisedConstants<PreparedOf<H, E>>;
    const EQUATIONS: &'static str = H::EQUATIONS;
}

impl<H: Discretized<E>, E> Scheme<Linearised<'_, H>> for WithDeviations<E> {
    /// Nothing around the step solves equations.
    const PLAN: Plan = Plan { solver: Solver::Explicit, ..H::PLAN };
    const PROPERTIES: Properties = Properties {
        remembers: H::PROPERTIES.remembers,
        in_lanes: H::PROPERTIES.in_lanes
            && (matches!(H::PLAN.solver, Solver::Explicit) || H::PROPERTIES.differentiates_lanes),
        is_variational: false,
        ..Properties::of(&<Self as Scheme<Linearised<'_, H>>>::PLAN, 0)
    };
    type Prepared<K: Constant> = LinearisedConstants<PreparedOf<H, E>>;
    type Unclocked = Self;
    type Memory<S: Scalar> = LinearisedMemory<MemoryOf<H, E, LinearisedNumber<S>>, S>;
    type CompensatedSum<S: Scalar> = PlainSum;
    type Sum<S: Scalar> = PlainSum;

    fn increments(system: &Linearised<'_, H>, length: usize) -> usize {
        system.system.increments(degrees(length))
    }

    fn prepare<K: Constant>(
        system: &Linearised<'_, H>,
        _: LiftParameter<'_, K>,
        h: K,
    ) -> Result<LinearisedConstants<PreparedOf<H, E>>, ConfigError> {
        SchemeOf::<H, E>::prepare(system.system, &as_they_are, h.lane(0)).map(LinearisedConstants)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance<K: Constant, S: ComputesWith<K>, C, const CAREFUL: bool>(
        system: &Linearised<'_, H>,
        LinearisedConstants(prepared): &LinearisedConstants<PreparedOf<H, E>>,
        at: StepArguments<'_, S, K, impl Movable<S> + ?Sized>,
        memory: &mut Self::Memory<S>,
        _: &mut C,
    ) -> Result<Effort, StepFailure> {
        // Plain loops: closures in adapters of `std` would be compiled without the instructions of the lanes.
        let StepArguments { t, h, q, p, dw } = at.lists();
        let (t, h, degrees) = (t.lane(0), h.lane(0), degrees(q.len()));
        let LinearisedMemory { inner, q: dual_q, p: dual_p, dw: dual_dw } = memory;
        dual_q.resize(degrees, Dual::default());
        dual_p.resize(degrees, Dual::default());
        dual_dw.resize(dw.len(), Dual::default());
        for i in 0..degrees {
            dual_q[i].value = q[i];
            dual_p[i].value = p[i];
            for number in 0..NUMBER {
                dual_q[i].derivative[number] = q[(1 + number) * degrees + i];
                dual_p[i].derivative[number] = p[(1 + number) * degrees + i];
            }
        }
        for k in 0..dw.len() {
            dual_dw[k].value = dw[k];
        }
        let step = StepArguments { t, h, q: &mut dual_q[..], p: &mut dual_p[..], dw: dual_dw };
        // No path is solved with care on account of another in its lanes: paths then go one by one.
        let effort = if S::LANES > 1 {
            SchemeOf::<H, E>::advance::<f64, LinearisedNumber<S>, PlainSum, false>(
                system.system,
                prepared,
                step,
                inner,
                &mut PlainSum,
            )?
        } else {
            anew::advance::<H, SchemeOf<H, E>, f64, LinearisedNumber<S>>(
                system.system,
                prepared,
                step,
                inner,
            )?
        };

        let zero = S::from_f64(0.0);
        let mut squares = [zero; NUMBER];
        for i in 0..degrees {
            for number in 0..NUMBER {
                let (x, y) = (dual_q[i].derivative[number], dual_p[i].derivative[number]);
                squares[number] = squares[number] + x * x + y * y;
            }
        }
        let mut sums = growth([&*q, &*p]);
        // Whole steps before, and with this one, which may be shorter.
        let before = ((t - system.start) / system.h).round();
        sums.add(sums.ln_length + squares[0].ln() * 0.5, [before, before + h / system.h]);
        let mut is_good = sums.means.is_finite();
        for number in 0..NUMBER {
            is_good = is_good & zero.less(squares[number]) & squares[number].is_finite();
        }
        if !is_good.all() {
            return Err(StepFailure::NonFinite);
        }
        for number in 0..NUMBER {
            let shrunk = squares[number].sqrt().recip();
            for i in 0..degrees {
                q[(1 + number) * degrees + i] = dual_q[i].derivative[number] * shrunk;
                p[(1 + number) * degrees + i] = dual_p[i].derivative[number] * shrunk;
            }
        }
        for i in 0..degrees {
            q[i] = dual_q[i].value;
            p[i] = dual_p[i].value;
        }
        let first = q.len() - SUMS;
        (q[first], q[first + 1], p[first], p[first + 1]) =
            (sums.ln_length, sums.weighted, sums.means, sums.fli);
        Ok(effort)
    }
}
