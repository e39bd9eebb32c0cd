//! Derivatives of the end of a run by its start, by parameters of the system and by the step size.
//!
//! A derivative by the start is a column that every step multiplies by a matrix. Before its numbers leave the
//! range of `f64` it is divided by a power of two, which changes no digit; the exponents are summed.

use std::array::from_fn;
use std::f64::consts::LN_2;
use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::{Simulation, Summation, Unobserved};
use crate::algebra::memory::{MemoryRequest, StepMemory};
use crate::algebra::scalar::{ComputesWith, Constant, Dual, Scalar};
use crate::algebra::state::{State, Vector, copy_state};
use crate::algebra::state_sum::StateSum;
use crate::error::{ConfigError, DerivativeError, StepError, StepFailure, wrong};
use crate::increments::Noise;
use crate::scheme::continuation::is_near;
use crate::scheme::system::{
    DEVIATIONS, Discretized, Hamiltonian, LiftParameter, MemoryOf, PreparedOf, Scheme, SchemeOf,
    StepArguments, TakenStep, anew, as_they_are,
};
use crate::trajectory::Error;
use crate::trajectory::retry::Subdivision;
use crate::trajectory::steps::StepToTake;

/// Derivatives that are taken beside each other.
pub(crate) const COLUMNS: usize = DEVIATIONS;
type ParameterDual = Dual<COLUMNS>;

/// The exponent of two from which a column is scaled. One step, whose matrix is far below `2^500`, does not
/// leave the range of numbers.
const LARGE: i64 = 500;
/// Sizes of columns between which no exponent is as large.
const USUAL_SIZES: std::ops::Range<f64> = 1e-150..1e150;

/// `x 2^exponent`
pub(super) fn scaled(mut x: f64, mut exponent: i64) -> f64 {
    while exponent != 0 && x != 0.0 && x.is_finite() {
        let part = exponent.clamp(-1000, 1000);
        x *= Scalar::powi(2.0, part as i32);
        exponent -= part;
    }
    x
}

/// Whether `f64` has `size 2^exponent` with all its digits: the largest entry of a column, which is zero only
/// where the whole column is.
pub(super) fn is_held(size: f64, exponent: i64) -> bool {
    let size_held = scaled(size, exponent);
    size == 0.0 || (size_held >= f64::MIN_POSITIVE && size_held.is_finite())
}

/// Its natural logarithm.
pub(super) fn ln_scaled(size: f64, exponent: i64) -> f64 {
    Scalar::ln(size) + exponent as f64 * LN_2
}

/// The end of a run, and its derivatives.
#[derive(Clone, Debug, PartialEq)]
pub struct Tangent<V> {
    /// The state at the end.
    pub end: State<V>,
    /// `∂(q, p)(end) / ∂(q, p)(start)`: twice as many rows and columns as there are degrees of freedom,
    /// coordinates first. With given increments it is symplectic to rounding where the scheme is.
    pub by_start: DMatrix<f64>,
    /// `∂(q, p)(end) / ∂θ`, a column for each parameter that [`Simulation::tangent_by`] names; none of
    /// [`Simulation::tangent`].
    pub by_parameters: DMatrix<f64>,
    /// `∂(q, p)(end) / ∂h` for the same number of steps from the same time, where [`Simulation::tangent_by`]
    /// was called. The end moves with `h`, unless the last step is shorter: then it stays, and the last step
    /// becomes shorter by as much as the others become longer.
    pub by_step_size: Option<DVector<f64>>,
}

impl<H, E, N, S> Simulation<'_, H, E, N, Unobserved, S>
where
    H: Discretized<E>,
    N: Noise,
    S: Summation<H, E>,
{
    /// Runs the path together with the derivative of its end by its start, with the same increments. An
    /// explicit step is repeated `⌈d/2⌉` times in dual numbers of four derivatives, for `d` degrees of
    /// freedom. An implicit one is solved without them; its Jacobian at the solution serves all columns,
    /// `x' = -J⁻¹ r'` for the equations `r(x) = 0`.
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
    /// The errors of [`Simulation::run`]; [`ConfigError::Setting`] for settings without meaning here:
    /// observables, sections, recorded nodes, a checkpoint. [`Error::Stopped`] where it was stopped.
    /// [`StepFailure::OtherSolution`] where a step was followed along its length, and dual numbers, which do
    /// not do that, end elsewhere. [`DerivativeError`] where the derivatives by one variable of the start are
    /// out of the range of `f64`, as after a long run with friction or of a chaotic system: it has the
    /// logarithm of their size.
    pub fn tangent(self) -> Result<Tangent<H::Vector>, Error> {
        self.varied(None)
    }

    /// As [`Simulation::tangent`], with the derivatives of the end by parameters of the system and by the
    /// step size, for the same increments. Parameters are numbers that the Hamiltonians read from the struct,
    /// by their names there. Each step takes `⌈(n + 1)/4⌉` more in dual numbers for `n` parameters.
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
    /// The errors of [`Simulation::tangent`], and [`ConfigError::Setting`] for a name that is not a parameter
    /// (an integer has no derivative), and for entries of lists in steps that are not in straight lines.
    pub fn tangent_by(self, parameters: &[&str]) -> Result<Tangent<H::Vector>, Error> {
        self.varied(Some(parameters))
    }

    fn varied(self, parameters: Option<&[&str]>) -> Result<Tangent<H::Vector>, Error> {
        let bare = self.bare("tangent", true)?;
        let degrees = bare.start.q.components().len();
        let mut varied = TangentRun::<H, E>::new(bare.system, bare.h, &bare.start, parameters)?;
        let mut steps = 0;
        let end = bare.run(|whole, step| {
            steps = step.interval.step + 1;
            varied.take_step(whole, step)
        })?;
        varied.are_held(steps, end.t)?;
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

/// The variable of a column of derivatives: a coordinate or a momentum of the start, or a parameter; the step
/// size comes after all parameters.
#[derive(Clone, Copy)]
enum TangentVariable {
    Start(usize),
    Constant(usize),
}

/// The derivatives of the state of a run.
struct TangentRun<'a, H: Discretized<E>, E> {
    system: &'a H,
    h: f64,
    /// By the state of the start, and by parameters and the step size.
    by_start: Vec<TangentColumns<H, E, f64, COLUMNS>>,
    by_constants: Vec<TangentColumns<H, E, ParameterDual, COLUMNS>>,
    shared: SharedStep<H, E, COLUMNS>,
    /// The names of those parameters, and their numbers.
    names: Vec<String>,
    numbers: Vec<usize>,
    dw: Vec<ParameterDual>,
    /// The state before a step, and one of both ends that dual numbers have.
    before: State<H::Vector>,
    end: H::Vector,
}

/// `N` columns of a matrix of derivatives, with constants `K` that may have derivatives themselves.
pub(crate) struct TangentColumns<H: Discretized<E>, E, K: Constant, const N: usize> {
    prepared: PreparedOf<H, E, K>,
    h: K,
    /// The derivative of the step size of the run, with the value zero.
    by_size: K,
    pub(crate) q: Vec<Dual<N>>,
    pub(crate) p: Vec<Dual<N>>,
    /// The derivatives of each column are `2^exponent` times those of the numbers.
    pub(crate) exponents: [i64; N],
    memory: MemoryOf<H, E, Dual<N>>,
}

/// The data that all columns of derivatives of one step share: its values, and the factors of its Jacobian.
pub(crate) struct SharedStep<H: Discretized<E>, E, const N: usize> {
    memory: MemoryOf<H, E, Dual<N>>,
    /// Whether they belong to the next step, too.
    is_solved: bool,
    /// Scratch of formulas for the derivative, and whether it has what they need of this step.
    room: MemoryOf<H, E, f64>,
    is_linear: bool,
    /// The number of columns.
    count: usize,
}

/// A step that has been taken, and what it left where its derivatives may follow from that.
pub(crate) struct Past<'a, H: Discretized<E>, E> {
    pub(crate) step: u64,
    pub(crate) ends: [&'a State<H::Vector>; 2],
    pub(crate) dw: &'a [f64],
    pub(crate) memory: Option<&'a MemoryOf<H, E, f64>>,
}

impl<H: Discretized<E>, E, const N: usize> SharedStep<H, E, N> {
    /// For so many columns.
    pub(crate) fn new(count: usize) -> Self {
        Self {
            memory: Default::default(),
            is_solved: false,
            room: Default::default(),
            is_linear: false,
            count,
        }
    }

    /// Begins another step.
    pub(crate) fn begin(&mut self) {
        (self.is_solved, self.is_linear) = (false, false);
    }
}

impl<H: Discretized<E>, E, K: Constant, const N: usize> TangentColumns<H, E, K, N>
where
    Dual<N>: ComputesWith<K>,
{
    /// Columns for steps of size `h`, from these derivatives of the state.
    pub(crate) fn new(
        system: &H,
        lift: LiftParameter<'_, K>,
        h: K,
        [q, p]: [Vec<Dual<N>>; 2],
    ) -> Result<Self, ConfigError> {
        let (prepared, by_size) = (SchemeOf::<H, E>::prepare(system, lift, h)?, h - h.lane(0));
        Ok(Self { prepared, h, by_size, q, p, exponents: [0; N], memory: Default::default() })
    }

    /// Goes on with a last step of another size, after so many steps of the run: the end stays where it is
    /// when the step size changes.
    pub(crate) fn resize(
        &mut self,
        system: &H,
        lift: LiftParameter<'_, K>,
        size: f64,
        steps: u64,
    ) -> Result<(), ConfigError> {
        self.h = self.by_size * -(steps as f64) + size;
        self.prepared = SchemeOf::<H, E>::prepare(system, lift, self.h)?;
        self.memory.tell(&MemoryRequest::Forget);
        Ok(())
    }

    /// The largest derivative of a column.
    pub(crate) fn size(&self, column: usize) -> f64 {
        size_of_column([&self.q, &self.p], column)
    }

    /// The column with the largest derivatives.
    fn largest(&self) -> usize {
        let mut largest = 0;
        for column in 1..N {
            if self.size(column) > self.size(largest) {
                largest = column;
            }
        }
        largest
    }

    /// Divides columns by powers of two, so that the next step cannot leave the range of numbers. Only where
    /// steps multiply them: not where constants have derivatives, which steps add.
    pub(crate) fn rescale(&mut self) {
        // The largest of each column at once, as nearly all steps leave them where they are.
        let mut sizes = [0.0_f64; N];
        for number in self.q.iter().chain(&self.p) {
            for (size, derivative) in sizes.iter_mut().zip(number.derivative) {
                *size = if derivative.abs() > *size { derivative.abs() } else { *size };
            }
        }
        if sizes.iter().all(|size| USUAL_SIZES.contains(size)) {
            return;
        }
        for column in 0..N {
            let size = self.size(column);
            // Its exponent; that of zero is far below all others.
            let exponent = (size.to_bits() >> 52) as i64 - 1023;
            if size == 0.0 || !size.is_finite() || exponent.abs() <= LARGE {
                continue;
            }
            for number in self.q.iter_mut().chain(&mut self.p) {
                number.derivative[column] = scaled(number.derivative[column], -exponent);
            }
            self.exponents[column] += exponent;
            // Past steps have other factors.
            self.memory.tell(&MemoryRequest::Forget);
        }
    }

    /// Replaces a column.
    pub(crate) fn put(&mut self, column: usize, derivatives: &[f64]) {
        for (number, derivative) in self.q.iter_mut().chain(&mut self.p).zip(derivatives) {
            number.derivative[column] = *derivative;
        }
        self.exponents[column] = 0;
        self.memory.tell(&MemoryRequest::Forget);
    }

    /// The derivatives of the step number `step` from one state to another.
    ///
    /// # Errors
    /// If it has no solution, or another one.
    pub(crate) fn vary(
        &mut self,
        system: &H,
        step: u64,
        [before, after]: [&State<H::Vector>; 2],
        dw: &[Dual<N>],
        end: &mut H::Vector,
    ) -> Result<(), StepFailure> {
        let Self { prepared, h, by_size, q, p, exponents: _, memory } = self;
        for (numbers, values) in [(&mut *q, &before.q), (&mut *p, &before.p)] {
            set_values(numbers, values.components());
        }
        // So many step sizes from the start.
        let t = *by_size * step as f64 + before.t;
        let at = StepArguments { t, h: *h, q: &mut q[..], p: &mut p[..], dw };
        anew::advance::<H, SchemeOf<H, E>, K, Dual<N>>(system, prepared, at, memory)?;
        ends_at([q, p], [before, after], end)
    }
}

impl<H: Discretized<E>, E, K: Constant, const N: usize> TangentColumns<H, E, K, N>
where
    Dual<N>: ComputesWith<K>,
{
    /// [`TangentColumns::vary`] with what other columns have found of the same step, and with the solution
    /// that it left.
    ///
    /// # Errors
    /// The errors of [`TangentColumns::vary`].
    pub(crate) fn vary_sharing(
        &mut self,
        shared: &mut SharedStep<H, E, N>,
        system: &H,
        past: &Past<'_, H, E>,
        dw: &[Dual<N>],
        end: &mut H::Vector,
    ) -> Result<(), StepFailure> {
        if !shared.is_solved
            && let Some(taken) = past.memory
        {
            SchemeOf::<H, E>::hand_values(taken, &mut shared.memory);
        }
        self.memory.tell(&MemoryRequest::Derivatives(shared.count));
        shared.memory.hand_values(&mut self.memory, shared.is_solved);
        let varied = self.vary(system, past.step, past.ends, dw, end);
        self.memory.hand_values(&mut shared.memory, false);
        shared.is_solved = varied.is_ok();
        varied
    }
}

impl<H: Discretized<E>, E> TangentColumns<H, E, f64, COLUMNS> {
    /// [`TangentColumns::vary_sharing`], by formulas for the derivative of the step where its scheme has
    /// some.
    ///
    /// # Errors
    /// The errors of [`TangentColumns::vary`].
    pub(crate) fn multiply(
        &mut self,
        shared: &mut SharedStep<H, E, COLUMNS>,
        system: &H,
        past: &Past<'_, H, E>,
        dw: &[Dual<COLUMNS>],
        end: &mut H::Vector,
    ) -> Result<(), StepFailure> {
        let Some(memory) = past.memory else {
            return self.vary_sharing(shared, system, past, dw, end);
        };
        let before = past.ends[0];
        let taken = TakenStep {
            t: before.t,
            h: self.h,
            q: before.q.components(),
            p: before.p.components(),
            dw: past.dw,
            memory,
            is_first: !shared.is_linear,
        };
        let deviations = [&mut self.q[..], &mut self.p[..]];
        if !SchemeOf::<H, E>::multiply(system, &self.prepared, taken, &mut shared.room, deviations) {
            return self.vary_sharing(shared, system, past, dw, end);
        }
        shared.is_linear = true;
        if are_finite([&self.q, &self.p]) { Ok(()) } else { Err(StepFailure::NonFinite) }
    }
}

// Loops over numbers alone, which are compiled once for all systems.

fn size_of_column<const N: usize>([q, p]: [&[Dual<N>]; 2], column: usize) -> f64 {
    q.iter().chain(p).map(|number| number.derivative[column].abs()).fold(0.0, f64::max)
}

fn set_values<const N: usize>(numbers: &mut [Dual<N>], values: &[f64]) {
    numbers.iter_mut().zip(values).for_each(|(number, value)| number.value = *value);
}

/// Whether all derivatives are.
fn are_finite<const N: usize>([q, p]: [&[Dual<N>]; 2]) -> bool {
    let mut zero = Dual::<N>::default();
    q.iter().chain(p).for_each(|number| zero = zero + number.infinitesimal() * 0.0);
    zero == Dual::default()
}

/// Columns of a matrix, by row `(q, p)`.
fn matrix<H: Discretized<E>, E, K: Constant>(
    columns: &[TangentColumns<H, E, K, COLUMNS>],
    degrees: usize,
    range: Range<usize>,
) -> DMatrix<f64> {
    DMatrix::from_fn(2 * degrees, range.len(), |row, column| {
        let column = range.start + column;
        let TangentColumns { q, p, exponents, .. } = &columns[column / COLUMNS];
        let number = if row < degrees { &q[row] } else { &p[row - degrees] };
        scaled(number.derivative[column % COLUMNS], exponents[column % COLUMNS])
    })
}

/// The numbers of parameters with these names.
///
/// # Errors
/// [`ConfigError::Setting`] for a name that does not exist, for an integer, and for a name that does not name
/// all of what the number is.
fn numbers(system: &impl Hamiltonian, names: &[&str]) -> Result<Vec<usize>, ConfigError> {
    let mut known = Vec::new();
    while let Some((name, _)) = system.parameter(known.len()) {
        known.push(name);
    }
    numbers_among(&known, system.integers(), names)
}

fn numbers_among(known: &[&str], integers: &[usize], names: &[&str]) -> Result<Vec<usize>, ConfigError> {
    let reals = || (0..).zip(known).filter(|(number, _)| !integers.contains(number)).map(|(_, name)| *name);
    let find = |name: &&str| {
        let number = known.iter().position(|other| other == name);
        let twin =
            known.iter().enumerate().find(|(other, twin)| Some(*other) != number && are_alike(name, twin));
        match (number, twin) {
            (Some(_), Some((_, twin))) => wrong(format!(
                "`tangent_by` does not know what `{name}` is: the Hamiltonians read `{twin}`, too, which may be the same number or \
                 another of the same name"
            )),
            (Some(number), None) if integers.contains(&number) => wrong(format!(
                "nothing has a derivative by `{name}`, an integer: take differences of runs, or make it a field of type `f64`"
            )),
            (Some(number), None) => Ok(number),
            (None, _) => wrong(format!(
                "`tangent_by` knows no parameter `{name}`: numbers that the Hamiltonians read are `{}`",
                reals().collect::<Vec<_>>().join("`, `")
            )),
        }
    };
    names.iter().map(find).collect()
}

/// Whether two names may be those of one number, or of two: the same name, or entries of one list of which an
/// index is not a number.
fn are_alike(a: &str, b: &str) -> bool {
    let list = |name: &str| name.split_once('[').map(|(list, _)| list.to_owned());
    let is_open =
        |name: &str| name.split(['[', ']']).skip(1).any(|index| index.contains(char::is_alphabetic));
    a == b || list(a).is_some() && list(a) == list(b) && (is_open(a) || is_open(b))
}

/// The variables of columns from `first` on, at these places.
fn units(places: Range<usize>, first: usize) -> Vec<ParameterDual> {
    places.map(|i| ParameterDual::variable(0.0, i.wrapping_sub(first))).collect()
}

fn quoted(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| format!("`{name}`")).collect()
}

impl<'a, H: Discretized<E>, E> TangentRun<'a, H, E> {
    fn new(
        system: &'a H,
        h: f64,
        start: &State<H::Vector>,
        parameters: Option<&[&str]>,
    ) -> Result<Self, ConfigError> {
        let degrees = start.q.components().len();
        let numbers = match parameters {
            Some(names) => Some(numbers(system, names)?),
            None => None,
        };
        let (mut by_start, mut by_constants) = (Vec::new(), Vec::new());
        for first in (0..2 * degrees).step_by(COLUMNS) {
            let lists = [units(0..degrees, first), units(degrees..2 * degrees, first)];
            by_start.push(TangentColumns::new(system, &as_they_are, h, lists)?);
        }
        if let Some(numbers) = &numbers {
            for first in (0..=numbers.len()).step_by(COLUMNS) {
                let h = ParameterDual::variable(h, numbers.len() - first);
                let zeros = || vec![ParameterDual::from_f64(0.0); degrees];
                let lists = [zeros(), zeros()];
                by_constants.push(TangentColumns::new(system, &lifted(numbers, first), h, lists)?);
            }
        }
        Ok(Self {
            system,
            h,
            by_start,
            by_constants,
            shared: SharedStep::new(2 * degrees + parameters.map_or(0, |names| names.len() + 1)),
            names: quoted(parameters.unwrap_or_default()),
            numbers: numbers.unwrap_or_default(),
            dw: Vec::new(),
            before: start.clone(),
            end: start.q.clone(),
        })
    }

    /// The derivatives of the step to this state.
    ///
    /// # Errors
    /// If a step has no solution, another one, or no finite derivative.
    fn vary(
        &mut self,
        step: u64,
        after: &State<H::Vector>,
        dw: &[f64],
        memory: Option<&MemoryOf<H, E, f64>>,
    ) -> Result<(), Error> {
        let Self { system, by_start, by_constants, shared, dw: own, before, end, .. } = self;
        own.clear();
        own.extend(dw.iter().copied().map(Dual::constant));
        shared.begin();
        let past = Past { step, ends: [before, after], dw, memory };
        let mut failed = None;
        for (block, columns) in by_start.iter_mut().enumerate() {
            let varied = columns.multiply(shared, system, &past, own, end);
            failed = failed.or(varied
                .err()
                .map(|cause| (cause, TangentVariable::Start(COLUMNS * block + columns.largest()))));
            columns.rescale();
        }
        for (block, columns) in by_constants.iter_mut().enumerate() {
            let varied = columns.vary_sharing(shared, system, &past, own, end);
            failed = failed.or(varied
                .err()
                .map(|cause| (cause, TangentVariable::Constant(COLUMNS * block + columns.largest()))));
        }
        match failed {
            None => Ok(()),
            // The step itself has a finite end.
            Some((StepFailure::NonFinite, by)) => {
                let (by, t) = (self.name(by), self.before.t);
                Err(Box::new(DerivativeError { by, ln_size: f64::INFINITY, step, t }).into())
            }
            Some((cause, _)) => Err(StepError { step, t: self.before.t, h: self.h, cause }.into()),
        }
    }

    /// The name of a column.
    fn name(&self, by: TangentVariable) -> String {
        let (degrees, variables) = (self.before.q.components().len(), self.system.variables());
        match by {
            TangentVariable::Start(i) if i < degrees => format!("`{}` of the start", variables.q.name(i)),
            TangentVariable::Start(i) => format!("`{}` of the start", variables.p.name(i - degrees)),
            TangentVariable::Constant(i) => {
                self.names.get(i).map_or("the step size", String::as_str).to_owned()
            }
        }
    }

    /// Whether numbers hold the derivatives by the start, after so many steps.
    ///
    /// # Errors
    /// [`DerivativeError`]
    fn are_held(&self, step: u64, t: f64) -> Result<(), Error> {
        for (block, columns) in self.by_start.iter().enumerate() {
            for (column, &exponent) in columns.exponents.iter().enumerate() {
                let size = columns.size(column);
                if !is_held(size, exponent) {
                    let (by, ln_size) = (
                        self.name(TangentVariable::Start(COLUMNS * block + column)),
                        ln_scaled(size, exponent),
                    );
                    return Err(Box::new(DerivativeError { by, ln_size, step, t }).into());
                }
            }
        }
        Ok(())
    }

    /// Takes a step, and differentiates it.
    fn take_step<N: Noise, C: StateSum<f64>>(
        &mut self,
        whole: &mut Subdivision<'_, H, E, C>,
        step: StepToTake<'_, H::Vector, N>,
    ) -> Result<(), Error> {
        let StepToTake { state, interval, noise, dw } = step;
        if whole.size() != self.h {
            self.resize(whole.size(), interval.step)?;
        }
        copy_state(&mut self.before, state);
        let taken = whole.take_step(StepToTake { state, interval, noise, dw })?;
        self.vary(interval.step, state, dw, whole.memory(taken))
    }

    /// Goes on with a last step of another size, after so many steps.
    #[cold]
    fn resize(&mut self, size: f64, steps: u64) -> Result<(), ConfigError> {
        let Self { system, by_start, by_constants, numbers, .. } = self;
        for columns in by_start {
            columns.resize(system, &as_they_are, size, steps)?;
        }
        for (first, columns) in (0..).step_by(COLUMNS).zip(by_constants) {
            columns.resize(system, &lifted(numbers, first), size, steps)?;
        }
        self.h = size;
        Ok(())
    }
}

/// Parameters of these numbers, from the first of a block on, as variables.
fn lifted(numbers: &[usize], first: usize) -> impl Fn(usize, f64) -> ParameterDual {
    move |number, value| Dual {
        value,
        derivative: from_fn(|column| f64::from(numbers.get(first + column) == Some(&number))),
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
            return Err(StepFailure::OtherSolution { apart: distance(start, [known, end]) });
        }
    }
    Ok(())
}

/// How far two ends of a step are from each other, relative to the way to the first.
fn distance<V: Vector>(start: &V, [a, b]: [&V; 2]) -> f64 {
    let ends = a.components().iter().zip(b.components()).zip(start.components());
    ends.map(|((a, b), start)| ((a - b) / (a - start)).abs()).fold(0.0, f64::max)
}
