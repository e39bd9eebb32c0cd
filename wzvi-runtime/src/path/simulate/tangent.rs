//! Derivatives of the end of a run by its start.

use nalgebra::DMatrix;

use super::{Setup, Simulation, Unobserved, prepared};
use crate::algebra::memory::Threads;
use crate::algebra::scalar::Dual;
use crate::algebra::state::{State, Vector};
use crate::error::{ConfigError, StepError, StepFailure};
use crate::increments::{Interval, Noise};
use crate::path::Error;
use crate::path::retry::{Subdivision, Whole};
use crate::path::step::StepInfo;
use crate::path::steps::{Single, TakeStep, Unmonitored, take_steps};
use crate::scheme::continuation::is_near;
use crate::scheme::dense::copy_state;
use crate::scheme::system::{At, Discretized, MemoryOf, PreparedOf, Scheme, SchemeOf, anew, as_they_are};

/// Derivatives that are taken beside each other.
const BESIDE: usize = 4;
type Number = Dual<BESIDE>;

/// The end of a run, and its derivative by the start.
#[derive(Clone, Debug, PartialEq)]
pub struct Tangent<V> {
    /// The state at the end.
    pub end: State<V>,
    /// `∂(q, p)(end) / ∂(q, p)(start)`: twice as many rows and columns as there are degrees of freedom, coordinates first. With given increments it is
    /// symplectic to rounding where the scheme is.
    pub by_start: DMatrix<f64>,
}

impl<H, E, N> Simulation<'_, H, E, N, Unobserved, Whole>
where
    H: Discretized<E>,
    N: Noise,
{
    /// Runs the path, and takes the derivative of its end by its start along: by dual numbers through every step, the solution of its equations included, with the
    /// increments as they are. With each step go `⌈d/2⌉` in dual numbers of four derivatives, for `d` degrees of freedom.
    ///
    /// ```ignore
    /// use wzvi::prelude::*;
    ///
    /// #[hamiltonian(drift = |q, p| 0.5 * p * p - q.cos(), embedding = Midpoint)]
    /// struct Pendulum;
    ///
    /// let tangent = Pendulum.simulate::<Midpoint>(0.05).start(State::new([3.0], [0.0])).until(5.0).tangent()?;
    /// assert!((tangent.by_start.determinant() - 1.0).abs() < 1e-12);
    /// # Ok::<(), wzvi::Error>(())
    /// ```
    ///
    /// # Errors
    /// Those of [`Simulation::run`]; [`ConfigError::Setting`] for what it has no meaning for: observables, sections, recorded nodes, a checkpoint, an exact end.
    /// [`StepFailure::OtherSolution`] where a step was found by following it, which dual numbers do not, and they end elsewhere.
    pub fn tangent(self) -> Result<Tangent<H::Vector>, Error> {
        let Self { setup, noise, observer: Unobserved, .. } = self;
        let Setup { system, h, span, recorded, observables, sections, keeping, .. } = setup;
        // Nothing is shown, and no step is halved.
        let Setup { is_watched, threads, is_quiet: _, retry, .. } = setup;
        let (start, grid) = span.checked::<H, E>(system, h)?;
        let is_recorded = recorded.every.is_some() || !recorded.times.is_empty();
        let unused = [
            ("`observe`", !observables.is_empty()),
            ("`section`", !sections.is_empty()),
            ("`record_every` and `record_at`", is_recorded),
            ("a checkpoint", keeping.is_set()),
            ("`exactly`", grid.shorter.is_some()),
        ];
        if let Some((setting, _)) = unused.into_iter().find(|(_, is_set)| *is_set) {
            return Err(
                ConfigError::Setting(format!("`tangent` has no use for {setting}: leave it out")).into()
            );
        }
        let degrees = start.q.components().len();
        let processes = system.increments(degrees);
        let mut noise = prepared::<H, E, N>(noise, &grid, processes)?;
        let whole = Subdivision::new(system, h, retry, is_watched, Threads::asked(threads)?)?;
        let mut stepper = Varied::<H, E>::new(whole, system, h, &start)?;
        let (mut state, mut dw) = (start, vec![0.0; processes]);
        let mut path = Single {
            stepper: &mut stepper,
            state: &mut state,
            noise: &mut noise,
            dw: &mut dw,
            start: grid.start,
            h,
            account: &mut (),
        };
        take_steps(&mut path, 0..grid.steps, &mut Unmonitored)?;
        Ok(Tangent { by_start: stepper.matrix(degrees), end: state })
    }
}

/// What takes the steps of a run, and the derivatives of its state by that of the start.
struct Varied<'a, H: Discretized<E>, E> {
    whole: Subdivision<'a, H, E>,
    system: &'a H,
    prepared: PreparedOf<H, E>,
    h: f64,
    blocks: Vec<Block<MemoryOf<H, E, Number>>>,
    dw: Vec<Number>,
    /// The state before a step, and one of both ends that dual numbers have.
    before: State<H::Vector>,
    end: H::Vector,
}

/// Some columns of the matrix.
struct Block<M> {
    q: Vec<Number>,
    p: Vec<Number>,
    memory: M,
}

impl<'a, H: Discretized<E>, E> Varied<'a, H, E> {
    fn new(
        whole: Subdivision<'a, H, E>,
        system: &'a H,
        h: f64,
        start: &State<H::Vector>,
    ) -> Result<Self, ConfigError> {
        let degrees = start.q.components().len();
        let block = |first: usize| {
            let unit = |i: usize| Dual {
                value: 0.0,
                derivative: std::array::from_fn(|column| f64::from(first + column == i)),
            };
            let [q, p] = [0, degrees].map(|offset| (offset..offset + degrees).map(unit).collect());
            Block { q, p, memory: Default::default() }
        };
        Ok(Self {
            whole,
            system,
            prepared: SchemeOf::<H, E>::prepare(system, &as_they_are, h)?,
            h,
            blocks: (0..2 * degrees).step_by(BESIDE).map(block).collect(),
            dw: Vec::new(),
            before: start.clone(),
            end: start.q.clone(),
        })
    }

    /// The derivatives of the step to this state.
    ///
    /// # Errors
    /// If a step has no solution, or another one.
    fn vary(&mut self, after: &State<H::Vector>, dw: &[f64]) -> Result<(), StepFailure> {
        let Self { system, prepared, h, blocks, dw: own, before, end, .. } = self;
        own.clear();
        own.extend(dw.iter().map(|dw| Dual::constant(*dw)));
        for Block { q, p, memory } in blocks {
            for (numbers, values) in [(&mut *q, &before.q), (&mut *p, &before.p)] {
                numbers.iter_mut().zip(values.components()).for_each(|(number, value)| number.value = *value);
            }
            let at = At { t: before.t, h: *h, q: &mut *q, p: &mut *p, dw: &*own };
            anew::advance::<H, SchemeOf<H, E>, f64, Number>(system, prepared, at, memory)?;
            for (numbers, before, after) in [(&*q, &before.q, &after.q), (&*p, &before.p, &after.p)] {
                end.components_mut().iter_mut().zip(numbers).for_each(|(x, number)| *x = number.value);
                if !is_near(before, [after, end]) {
                    return Err(StepFailure::OtherSolution { apart: apart(before, [after, end]) });
                }
            }
        }
        Ok(())
    }

    fn matrix(&self, degrees: usize) -> DMatrix<f64> {
        DMatrix::from_fn(2 * degrees, 2 * degrees, |row, column| {
            let Block { q, p, .. } = &self.blocks[column / BESIDE];
            let number = if row < degrees { &q[row] } else { &p[row - degrees] };
            number.derivative[column % BESIDE]
        })
    }
}

/// How far two ends of a step are from each other, relative to the way to the first.
fn apart<V: Vector>(start: &V, [a, b]: [&V; 2]) -> f64 {
    let ends = a.components().iter().zip(b.components()).zip(start.components());
    ends.map(|((a, b), start)| ((a - b) / (a - start)).abs()).fold(0.0, f64::max)
}

impl<H: Discretized<E>, E> TakeStep<H::Vector> for Varied<'_, H, E> {
    fn take_step<N: Noise>(
        &mut self,
        state: &mut State<H::Vector>,
        interval: &Interval,
        noise: &mut Option<N>,
        dw: &mut [f64],
    ) -> Result<StepInfo, Error> {
        copy_state(&mut self.before, state);
        let info = self.whole.take_step(state, interval, noise, dw)?;
        let (step, t, h) = (interval.step, self.before.t, self.h);
        self.vary(state, dw).map_err(|cause| StepError { step, t, h, cause })?;
        Ok(info)
    }
}
