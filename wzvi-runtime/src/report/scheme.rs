//! A scheme as a value: types go in, one list of them comes out.

use std::hint::black_box;
use std::marker::PhantomData;
use std::time::{Duration, Instant};

use crate::error::{ConfigError, Error, NoiseError};
use crate::increments::{Interval, Noise};
use crate::names::short_name;
use crate::plan::Plan;
use crate::simulate::{Node, Simulation};
use crate::state::State;
use crate::step::Stepper;
use crate::system::{Discretized, Hamiltonian};
use crate::trajectory::Iterations;

/// How a path went.
pub(crate) struct Outcome<V> {
    pub(crate) last: State<V>,
    pub(crate) iterations: u64,
    pub(crate) largest: u32,
    pub(crate) failure: Option<Error>,
}

/// One embedding of a system.
pub(crate) trait Scheme<H: Hamiltonian> {
    /// The embedding as it is written, `Corrected<DeltaPlus>`.
    fn name(&self) -> String;

    /// What the compiler found out.
    fn plan(&self) -> Plan;

    /// One path through given increments, seen at every node.
    fn run(
        &self,
        system: &H,
        path: &Given<'_, H::Vector>,
        see: &mut dyn FnMut(&State<H::Vector>),
    ) -> Result<Outcome<H::Vector>, Error>;

    /// How long several paths take, one after the other, `passes` times over; nothing but steps is inside.
    fn time(&self, system: &H, paths: &[Given<'_, H::Vector>], passes: u32) -> Result<Duration, ConfigError>;
}

/// A path to take: where from, in which steps.
pub(crate) struct Given<'a, V> {
    pub(crate) start: &'a State<V>,
    pub(crate) h: f64,
    pub(crate) steps: usize,
    /// Rows of one increment per noise; empty without noise.
    pub(crate) increments: &'a [f64],
}

impl<V> Given<'_, V> {
    #[inline(always)]
    fn rows(&self, processes: usize) -> impl Iterator<Item = &[f64]> {
        (0..self.steps).map(move |i| self.increments.get(i * processes..(i + 1) * processes).unwrap_or(&[]))
    }
}

/// Increments that were drawn before, by rows.
struct Rows<'a>(&'a [f64]);

impl Noise for Rows<'_> {
    fn increments(&mut self, interval: &Interval, dw: &mut [f64]) -> Result<(), NoiseError> {
        let rows = self.0.len().checked_div(dw.len()).unwrap_or(0);
        let row =
            usize::try_from(interval.step).ok().and_then(|step| self.0.chunks_exact(dw.len()).nth(step));
        let exhausted = NoiseError::Exhausted { step: interval.step, available: rows };
        row.map(|row| dw.copy_from_slice(row)).ok_or(exhausted)
    }
}

/// The scheme `E`.
pub(crate) struct Embedding<E>(PhantomData<fn() -> E>);

impl<E> Embedding<E> {
    pub(crate) fn new() -> Self {
        Self(PhantomData)
    }
}

impl<H: Discretized<E>, E> Scheme<H> for Embedding<E> {
    fn name(&self) -> String {
        short_name::<E>()
    }

    fn plan(&self) -> Plan {
        H::PLAN
    }

    fn run(
        &self,
        system: &H,
        path: &Given<'_, H::Vector>,
        see: &mut dyn FnMut(&State<H::Vector>),
    ) -> Result<Outcome<H::Vector>, Error> {
        let run =
            Simulation::<H, E>::new(system, path.h).start(path.start.clone()).noise(Rows(path.increments));
        let run = run
            .steps(path.steps as u64)
            .record_every(0)
            .inspect(|state: &State<H::Vector>, _: &Node<'_>| see(state));
        let (trajectory, failure) = run.run_partial()?;
        let Iterations { total, largest, .. } = trajectory.iterations();
        Ok(Outcome { last: trajectory.last().clone(), iterations: total, largest, failure })
    }

    fn time(&self, system: &H, paths: &[Given<'_, H::Vector>], passes: u32) -> Result<Duration, ConfigError> {
        let processes = system.noises();
        let mut steppers = Vec::with_capacity(paths.len());
        for path in paths {
            steppers.push(Stepper::<H, E>::new(system, path.h)?);
        }
        let Some(first) = paths.first() else { return Ok(Duration::ZERO) };
        let mut state = first.start.clone();
        let begin = Instant::now();
        for _ in 0..passes {
            for (path, stepper) in paths.iter().zip(&mut steppers) {
                state.clone_from(path.start);
                for dw in path.rows(processes) {
                    // Only paths that were seen to reach the end are timed.
                    if stepper.step(&mut state, dw).is_err() {
                        break;
                    }
                }
                black_box(&state);
            }
        }
        Ok(begin.elapsed())
    }
}
