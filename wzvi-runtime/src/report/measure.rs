//! Error against run time: the builder.
//!
//! Tested by `tests/paths/report/estimators.rs`.

use super::Overlay;
use super::method::MeasuredScheme;
use crate::algebra::state::State;
use crate::ground::digits::ShortestDecimal;
use crate::ground::names::short_name;
use crate::noise::{Driver, Paths, Wiener};
use crate::scheme::system::{Discretized, Hamiltonian};
use crate::trajectory::Error;
use crate::trajectory::exclusive_setting::{ExclusiveSetting, SOME};
use crate::trajectory::options::{Execution, Functions, options};
use crate::trajectory::span::{RunEnd, RunSpan};

type ExactSolution<'a, V> = Box<dyn Fn(f64, &[f64]) -> State<V> + Send + Sync + 'a>;
type ExactOnPath<'a, V> = Box<dyn Fn(f64, &mut Wiener) -> Result<State<V>, Error> + Send + Sync + 'a>;
type DriverOf<'a> = Box<dyn Fn(Wiener) -> Box<dyn Driver + 'a> + Send + Sync + 'a>;

pub(super) enum Reference<'a, H: Hamiltonian> {
    Exact(ExactSolution<'a, H::Vector>),
    OnPath(ExactOnPath<'a, H::Vector>),
    Finer(MeasuredScheme<H>, f64),
    Value(State<H::Vector>),
}

/// The settings that a measurement has in common with other runs.
pub(super) struct MeasurementSetup<'a, V> {
    pub(super) span: RunSpan<V>,
    pub(super) execution: Execution<'a>,
}

/// How much error several schemes make for how much time: [`WorkPrecision::run`] measures it.
///
/// A start, an end, step sizes, a reference and at least one scheme are needed. The paths are those of one
/// seed: every scheme, every step size and the reference see the same Wiener paths:
/// [thermostats](crate::scheme::bath), too, whose normals are increments of one Wiener process for each
/// degree of freedom, after those of the noises.
#[must_use = "nothing is measured before `run`"]
pub struct WorkPrecision<'a, H: Hamiltonian> {
    pub(super) system: &'a H,
    pub(super) title: String,
    pub(super) setup: MeasurementSetup<'a, H::Vector>,
    pub(super) steps: Vec<f64>,
    pub(super) paths: usize,
    pub(super) seed: u64,
    pub(super) repetitions: usize,
    pub(super) driver: DriverOf<'a>,
    pub(super) reference: ExclusiveSetting<Reference<'a, H>>,
    /// By name and with `E f(z(T))`, if known; otherwise the reference on the same path is compared with.
    pub(super) observables: Functions<'a, H::Vector, (String, Option<f64>)>,
    pub(super) methods: Vec<MeasuredScheme<H>>,
    pub(super) overlay: Vec<Overlay>,
    pub(super) failed: Option<Error>,
}

impl<'a, H: Hamiltonian> WorkPrecision<'a, H> {
    /// A measurement of `system`: 100 paths of seed 0, 7 timings of each scheme and step size.
    pub fn new(system: &'a H) -> Self {
        Self {
            system,
            title: short_name::<H>(),
            setup: MeasurementSetup { span: RunSpan::default(), execution: Execution::default() },
            steps: vec![],
            paths: 100,
            seed: 0,
            repetitions: 7,
            driver: Box::new(|wiener| Box::new(wiener)),
            reference: ExclusiveSetting::default(),
            observables: Functions::default(),
            methods: vec![],
            overlay: vec![],
            failed: None,
        }
    }

    /// The title of tables and pages; the name of the system's type by default.
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    options!(start, execution);

    /// The end of every path, in the time units of the Hamiltonian: a whole number of steps of each size
    /// away.
    pub fn until(mut self, end: f64) -> Self {
        self.setup.span.end.set("until", ShortestDecimal(end), RunEnd::Time(end));
        self
    }

    /// The step sizes, in any order.
    pub fn step_sizes(mut self, sizes: impl IntoIterator<Item = f64>) -> Self {
        self.steps = sizes.into_iter().collect();
        self
    }

    /// The number of paths over which errors are averaged. A system without noise takes one.
    pub fn paths(mut self, paths: usize) -> Self {
        self.paths = paths;
        self
    }

    /// The seed of the Wiener paths.
    pub fn seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// The number of timings after one warm-up; 0 measures no times.
    pub fn repetitions(mut self, repetitions: usize) -> Self {
        self.repetitions = repetitions;
        self
    }

    /// Drives the steps by a noise that is made from the Wiener path:
    /// `.noise(|wiener| WongZakai::of(wiener, 0.02).exact())`.
    pub fn noise<N: Paths + Clone + Send + Sync + 'a>(
        mut self,
        driver: impl Fn(Wiener) -> N + Send + Sync + 'a,
    ) -> Self {
        self.driver = Box::new(move |wiener| Box::new(driver(wiener)));
        self
    }

    /// Compares with an exact solution `exact(t, wiener)`, `wiener[k] = W_k(t) - W_k(t_0)`: those of the
    /// noises, and then those of a bath.
    pub fn exact(mut self, exact: impl Fn(f64, &[f64]) -> State<H::Vector> + Send + Sync + 'a) -> Self {
        self.reference.set("exact", SOME, Reference::Exact(Box::new(exact)));
        self
    }

    /// Compares with an exact solution that depends on the path at more than its end.
    pub fn exact_on_path(
        mut self,
        exact: impl Fn(f64, &mut Wiener) -> Result<State<H::Vector>, Error> + Send + Sync + 'a,
    ) -> Self {
        self.reference.set("exact_on_path", SOME, Reference::OnPath(Box::new(exact)));
        self
    }

    /// Compares with a run of the scheme `E` in steps of size `h` on the same Wiener paths.
    pub fn reference<E: 'static>(mut self, h: f64) -> Self
    where
        H: Discretized<E> + Sync,
    {
        self.reference.set("reference", ShortestDecimal(h), Reference::Finer(MeasuredScheme::of::<E>(), h));
        self
    }

    /// Compares with a state that is known.
    pub fn value(mut self, state: State<H::Vector>) -> Self {
        self.reference.set("value", SOME, Reference::Value(state));
        self
    }

    /// Measures the weak error of `f`: the mean over paths of `f(z_N) - f(z(T))` on the same path.
    pub fn observe(
        mut self,
        name: impl Into<String>,
        f: impl Fn(&State<H::Vector>) -> f64 + Send + Sync + 'a,
    ) -> Self {
        self.observables.push((name.into(), None), f);
        self
    }

    /// Measures the weak error of `f` against `E f(z(T))`, which is known.
    pub fn expectation(
        mut self,
        name: impl Into<String>,
        f: impl Fn(&State<H::Vector>) -> f64 + Send + Sync + 'a,
        expectation: f64,
    ) -> Self {
        self.observables.push((name.into(), Some(expectation)), f);
        self
    }

    /// Adds a scheme.
    pub fn scheme<E: 'static>(mut self) -> Self
    where
        H: Discretized<E> + Sync,
    {
        self.methods.push(MeasuredScheme::of::<E>());
        self
    }

    /// Shows points measured elsewhere beside these: a CSV file with lines `name,seconds,error`, one path
    /// each, with or without a line of headings. [`WorkPrecision::run`] reports what is wrong with it.
    pub fn overlay_csv(mut self, path: impl AsRef<std::path::Path>) -> Self {
        match Overlay::read(path.as_ref()) {
            Ok(points) => self.overlay.extend(points),
            Err(error) => self.failed = self.failed.or(Some(error.into())),
        }
        self
    }
}
