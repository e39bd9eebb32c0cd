//! Derivatives of the end of a run by its start, by parameters of the system and by the step size.

use std::array::from_fn;
use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::{Simulation, Unobserved};
use crate::algebra::scalar::{Constant, Dual, Over, Scalar};
use crate::algebra::state::{State, Vector, copy_state};
use crate::error::{ConfigError, StepError, StepFailure, wrong};
use crate::increments::{Noise, Whole};
use crate::path::Error;
use crate::path::retry::Subdivision;
use crate::path::steps::Step;
use crate::scheme::continuation::is_near;
use crate::scheme::system::{
    At, Discretized, Hamiltonian, Lift, MemoryOf, PreparedOf, Scheme, SchemeOf, anew, as_they_are,
};

/// Derivatives that are taken beside each other.
const BESIDE: usize = 4;
type Number = Dual<BESIDE>;

/// The end of a run, and its derivatives.
#[derive(Clone, Debug, PartialEq)]
pub struct Tangent<V> {
    /// The state at the end.
    pub end: State<V>,
    /// `∂(q, p)(end) / ∂(q, p)(start)`: twice as many rows and columns as there are degrees of freedom, coordinates first. With given increments it is
    /// symplectic to rounding where the scheme is.
    pub by_start: DMatrix<f64>,
    /// `∂(q, p)(end) / ∂θ`, a column for each parameter that [`Simulation::tangent_by`] names; none of [`Simulation::tangent`].
    pub by_parameters: DMatrix<f64>,
    /// `∂(q, p)(end) / ∂h` for the same number of steps from the same time, where [`Simulation::tangent_by`] was called.
    pub by_step_size: Option<DVector<f64>>,
}

impl<H, E, N> Simulation<'_, H, E, N, Unobserved, Whole>
where
    H: Discretized<E>,
    N: Noise,
{
    /// Runs the path together with the derivative of its end by its start: dual numbers pass through every step, including the solution of its
    /// equations, with the same increments. Each step takes `⌈d/2⌉` more in dual numbers of four derivatives, for `d` degrees of freedom.
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
    /// Those of [`Simulation::run`]; [`ConfigError::Setting`] for settings without meaning here: observables, sections, recorded nodes, a checkpoint,
    /// an exact end, and what would stop the run. [`StepFailure::OtherSolution`] where a step was followed along its length, and dual numbers, which do not do that, end
    /// elsewhere.
    pub fn tangent(self) -> Result<Tangent<H::Vector>, Error> {
        self.varied(None)
    }

    /// As [`Simulation::tangent`], with the derivatives of the end by parameters of the system and by the step size, for the same increments.
    /// Parameters are numbers that the Hamiltonians read from the struct, by their names there. Each step takes `⌈(n + 1)/4⌉` more in dual numbers
    /// for `n` parameters.
    ///
    /// ```ignore
    /// use wzvi::prelude::*;
    ///
    /// #[hamiltonian(drift = |q, p| 0.5 * p * p + 0.5 * omega * omega * q * q, embedding = Midpoint)]
    /// struct Oscillator { omega: f64 }
    ///
    /// let oscillator = Oscillator { omega: 2.0 };
    /// let run = |h: f64| oscillator.simulate::<Midpoint>(h).start(State::new([1.0], [0.0])).steps(100);
    /// let tangent = run(0.05).tangent_by(&["omega"])?;
    /// let by_omega = tangent.by_parameters[(0, 0)];
    /// # let _ = by_omega;
    /// # Ok::<(), wzvi::Error>(())
    /// ```
    ///
    /// # Errors
    /// Those of [`Simulation::tangent`], and [`ConfigError::Setting`] for a name that is not a parameter (an integer has no derivative), and for
    /// entries of lists in steps that are not in straight lines.
    pub fn tangent_by(self, parameters: &[&str]) -> Result<Tangent<H::Vector>, Error> {
        self.varied(Some(parameters))
    }

    fn varied(self, parameters: Option<&[&str]>) -> Result<Tangent<H::Vector>, Error> {
        let bare = self.bare("tangent")?;
        let degrees = bare.start.q.components().len();
        let mut varied = Varied::<H, E>::new(bare.system, bare.h, &bare.start, parameters)?;
        let end = bare.run(|whole, step| varied.take_step(whole, step))?;
        let named = parameters.map_or(0, <[&str]>::len);
        Ok(Tangent {
            by_start: matrix(&varied.by_start, degrees, 0..2 * degrees),
            by_parameters: matrix(&varied.by_constants, degrees, 0..named),
            by_step_size: parameters
                .map(|_| matrix(&varied.by_constants, degrees, named..named + 1).column(0).into_owned()),
            end,
        })
    }
}

/// The derivatives of the state of a run.
struct Varied<'a, H: Discretized<E>, E> {
    system: &'a H,
    h: f64,
    /// By the state of the start, and by parameters and the step size.
    by_start: Vec<Columns<H, E, f64, BESIDE>>,
    by_constants: Vec<Columns<H, E, Number, BESIDE>>,
    dw: Vec<Number>,
    /// The state before a step, and one of both ends that dual numbers have.
    before: State<H::Vector>,
    end: H::Vector,
}

/// `N` columns of a matrix of derivatives, with constants `K` that may have derivatives themselves.
pub(super) struct Columns<H: Discretized<E>, E, K: Constant, const N: usize> {
    prepared: PreparedOf<H, E, K>,
    h: K,
    pub(super) q: Vec<Dual<N>>,
    pub(super) p: Vec<Dual<N>>,
    memory: MemoryOf<H, E, Dual<N>>,
}

impl<H: Discretized<E>, E, K: Constant, const N: usize> Columns<H, E, K, N>
where
    Dual<N>: Over<K>,
{
    /// Of steps of size `h`, from these derivatives of the state.
    pub(super) fn new(
        system: &H,
        lift: Lift<'_, K>,
        h: K,
        [q, p]: [Vec<Dual<N>>; 2],
    ) -> Result<Self, ConfigError> {
        let prepared = SchemeOf::<H, E>::prepare(system, lift, h)?;
        Ok(Self { prepared, h, q, p, memory: Default::default() })
    }

    /// The derivatives of the step number `step` from one state to another.
    ///
    /// # Errors
    /// If it has no solution, or another one.
    pub(super) fn vary(
        &mut self,
        system: &H,
        step: u64,
        [before, after]: [&State<H::Vector>; 2],
        dw: &[Dual<N>],
        end: &mut H::Vector,
    ) -> Result<(), StepFailure> {
        let Self { prepared, h, q, p, memory } = self;
        for (numbers, values) in [(&mut *q, &before.q), (&mut *p, &before.p)] {
            numbers.iter_mut().zip(values.components()).for_each(|(number, value)| number.value = *value);
        }
        // So many step sizes from the start.
        let t = (*h - h.lane(0)) * step as f64 + before.t;
        let at = At { t, h: *h, q: &mut q[..], p: &mut p[..], dw };
        anew::advance::<H, SchemeOf<H, E>, K, Dual<N>>(system, prepared, at, memory)?;
        ends_at([q, p], [before, after], end)
    }
}

/// Columns of a matrix, by row `(q, p)`.
fn matrix<H: Discretized<E>, E, K: Constant>(
    columns: &[Columns<H, E, K, BESIDE>],
    degrees: usize,
    range: Range<usize>,
) -> DMatrix<f64> {
    DMatrix::from_fn(2 * degrees, range.len(), |row, column| {
        let column = range.start + column;
        let Columns { q, p, .. } = &columns[column / BESIDE];
        let number = if row < degrees { &q[row] } else { &p[row - degrees] };
        number.derivative[column % BESIDE]
    })
}

/// The numbers of parameters with these names.
///
/// # Errors
/// [`ConfigError::Setting`] for a name that does not exist, and for one that does not name all of what the number is.
fn numbers(system: &impl Hamiltonian, names: &[&str]) -> Result<Vec<usize>, ConfigError> {
    let known: Vec<&str> = (0..).map_while(|index| system.parameter(index)).map(|(name, _)| name).collect();
    let find = |name: &&str| {
        let number = known.iter().position(|other| other == name);
        let twin =
            known.iter().enumerate().find(|(other, twin)| Some(*other) != number && are_alike(name, twin));
        match (number, twin) {
            (Some(_), Some((_, twin))) => wrong(format!(
                "`tangent_by` does not know what `{name}` is: the Hamiltonians read `{twin}`, too, which may be the same number or \
                 another of the same name"
            )),
            (Some(number), None) => Ok(number),
            (None, _) => wrong(format!(
                "`tangent_by` knows no parameter `{name}`: numbers that the Hamiltonians read are `{}`",
                known.join("`, `")
            )),
        }
    };
    names.iter().map(find).collect()
}

/// Whether two names may be those of one number, or of two: the same name, or entries of one list of which an index is not a number.
fn are_alike(a: &str, b: &str) -> bool {
    let list = |name: &str| name.split_once('[').map(|(list, _)| list.to_owned());
    let is_open =
        |name: &str| name.split(['[', ']']).skip(1).any(|index| index.contains(char::is_alphabetic));
    a == b || list(a).is_some() && list(a) == list(b) && (is_open(a) || is_open(b))
}

impl<'a, H: Discretized<E>, E> Varied<'a, H, E> {
    fn new(
        system: &'a H,
        h: f64,
        start: &State<H::Vector>,
        parameters: Option<&[&str]>,
    ) -> Result<Self, ConfigError> {
        let degrees = start.q.components().len();
        let of_start = |first: usize| {
            let unit = |i: usize| Number::variable(0.0, i.wrapping_sub(first));
            let lists = [0, degrees].map(|offset| (offset..offset + degrees).map(unit).collect());
            Columns::new(system, &as_they_are, h, lists)
        };
        let of_constants = |first: usize, numbers: &[usize]| {
            let lift = |number: usize, value: f64| Dual {
                value,
                derivative: from_fn(|column| f64::from(numbers.get(first + column) == Some(&number))),
            };
            let h = Number::variable(h, numbers.len() - first);
            let lists = [0, 1].map(|_| vec![Number::from_f64(0.0); degrees]);
            Columns::new(system, &lift, h, lists)
        };
        let by_constants = match parameters {
            None => Vec::new(),
            Some(names) => {
                let numbers = numbers(system, names)?;
                let firsts = (0..=numbers.len()).step_by(BESIDE);
                firsts.map(|first| of_constants(first, &numbers)).collect::<Result<_, ConfigError>>()?
            }
        };
        let firsts = (0..2 * degrees).step_by(BESIDE);
        Ok(Self {
            system,
            h,
            by_start: firsts.map(of_start).collect::<Result<_, ConfigError>>()?,
            by_constants,
            dw: Vec::new(),
            before: start.clone(),
            end: start.q.clone(),
        })
    }

    /// The derivatives of the step to this state.
    ///
    /// # Errors
    /// If a step has no solution, or another one.
    fn vary(&mut self, step: u64, after: &State<H::Vector>, dw: &[f64]) -> Result<(), StepFailure> {
        let Self { system, by_start, by_constants, dw: own, before, end, .. } = self;
        own.clear();
        own.extend(dw.iter().map(|dw| Dual::constant(*dw)));
        for columns in by_start {
            columns.vary(system, step, [before, after], own, end)?;
        }
        for columns in by_constants {
            columns.vary(system, step, [before, after], own, end)?;
        }
        Ok(())
    }

    /// Takes a step, and differentiates it.
    fn take_step<N: Noise>(
        &mut self,
        whole: &mut Subdivision<'_, H, E>,
        step: Step<'_, H::Vector, N>,
    ) -> Result<(), Error> {
        let Step { state, interval, noise, dw } = step;
        copy_state(&mut self.before, state);
        whole.take_step(Step { state, interval, noise, dw })?;
        let (step, t, h) = (interval.step, self.before.t, self.h);
        Ok(self.vary(step, state, dw).map_err(|cause| StepError { step, t, h, cause })?)
    }
}

/// Checks that the step in dual numbers from the first state ends at the second; `end` is scratch.
///
/// # Errors
/// [`StepFailure::OtherSolution`]
fn ends_at<const N: usize, V: Vector>(
    [q, p]: [&[Dual<N>]; 2],
    [start, known]: [&State<V>; 2],
    end: &mut V,
) -> Result<(), StepFailure> {
    for (numbers, start, known) in [(q, &start.q, &known.q), (p, &start.p, &known.p)] {
        end.components_mut().iter_mut().zip(numbers).for_each(|(x, number)| *x = number.value);
        if !is_near(start, [known, end]) {
            return Err(StepFailure::OtherSolution { apart: apart(start, [known, end]) });
        }
    }
    Ok(())
}

/// How far two ends of a step are from each other, relative to the way to the first.
fn apart<V: Vector>(start: &V, [a, b]: [&V; 2]) -> f64 {
    let ends = a.components().iter().zip(b.components()).zip(start.components());
    ends.map(|((a, b), start)| ((a - b) / (a - start)).abs()).fold(0.0, f64::max)
}
