//! Variational integrators for (stochastic) Hamiltonian systems, derived at compile time: for long runs and many paths in
//! which energy, phase-space volume and first integrals must not drift.
//!
//! You write the Hamiltonians. `#[hamiltonian]` embeds the action principle in discrete time, differentiates the
//! discrete Lagrangian symbolically and emits the step that solves the discrete Euler-Lagrange equations:
//!
//! ```
//! use wzvi::prelude::*;
//!
//! /// Kubo oscillator: a rotation whose angle diffuses.
//! #[hamiltonian(
//!     drift = |q, p| 0.5 * a * (q * q + p * p),
//!     noise = [|q, p| 0.5 * sigma * (q * q + p * p)],
//!     embedding = [Uncorrected<DeltaPlus>, Corrected<DeltaPlus>, Midpoint],
//!     invariant = [|q, p| q * q + p * p],
//! )]
//! #[derive(Clone, Debug)]
//! pub struct Kubo {
//!     /// Mean angular frequency.
//!     pub a: f64,
//!     /// Intensity of the noise.
//!     pub sigma: f64,
//! }
//!
//! fn main() -> Result<(), wzvi::Error> {
//!     let kubo = Kubo { a: 1.5, sigma: 1.0 };
//!     let path = kubo
//!         .simulate::<Midpoint>(0.02)                    // step size h
//!         .start(State::new([0.0], [1.0]))               // q, p at t = 0
//!         .noise(WongZakai::averaged(0.02).seed(7))      // or Wiener::seed(7), or given increments
//!         .until(20.0)
//!         .run()?;
//!     println!("{:?} drift of H: {:.1e}", path.last(), path.energy_drift(&kubo));
//!     assert!(path.energy_drift(&kubo) < 1e-13);
//!
//!     let statistics = kubo
//!         .ensemble::<Midpoint>(0.02)                    // many paths, in vector registers and on all cores
//!         .start(State::new([0.0], [1.0]))
//!         .paths(10_000)
//!         .seed(7)
//!         .until(2.0)
//!         .observe("q", |state| state.q[0])
//!         .run()?;
//!     println!("{} ± {}", statistics.mean("q")?, statistics.standard_error("q")?);
//!     Ok(())
//! }
//! ```
//!
//! Without noise, orders 8 and 16 need only the name of another scheme:
//!
//! ```
//! use wzvi::prelude::*;
//!
//! #[hamiltonian(
//!     drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) - 1.0 / (x * x + y * y).sqrt(),
//!     embedding = [Verlet, Gauss<8>],
//!     invariant = [|[x, y], [px, py]| x * py - y * px],
//! )]
//! struct Kepler;
//!
//! fn main() -> Result<(), wzvi::Error> {
//!     let start = State::new([0.5, 0.0], [0.0, 3.0_f64.sqrt()]);
//!     let explicit = Kepler.simulate::<Composed<Verlet, KahanLi8>>(0.02).start(start).until(10.0).run()?;
//!     let implicit = Kepler.simulate::<Gauss<8>>(0.1).start(start).until(10.0).run()?;
//!     assert!((explicit.last().q - implicit.last().q).norm() < 1e-8);
//!     Ok(())
//! }
//! ```
//!
//! Non-Hamiltonian terms are declared beside the drift. Friction and a temperature make a heat bath, whose part of the step is exact:
//!
//! ```
//! use wzvi::prelude::*;
//!
//! #[hamiltonian(
//!     drift = |q, p| 0.5 * p * p + 0.25 * (q * q - 1.0).powi(2),
//!     force = |q, p, t| push * t.cos(),
//!     friction = gamma,
//!     temperature = kt,
//!     embedding = Baoab,
//! )]
//! struct DoubleWell {
//!     push: f64,
//!     gamma: f64,
//!     kt: f64,
//! }
//!
//! fn main() -> Result<(), wzvi::Error> {
//!     let well = DoubleWell { push: 0.1, gamma: 0.5, kt: 0.2 };
//!     let run = well.simulate::<Baoab>(0.05).start(State::new([-1.0], [0.0])).noise(StepNormals::seed(1));
//!     println!("{}", run.until(100.0).run()?.last());
//!     Ok(())
//! }
//! ```
//!
//! # The tour
//!
//! * **System.** With drift `H_0` and noises `H_k`, in the sense of Stratonovich,
//!   `dq = Σ_m ∂H_m/∂p ∘ dX_m`, `dp = -Σ_m ∂H_m/∂q ∘ dX_m` with `X_0 = t`, `X_k = W_k`. The struct implements
//!   [`Hamiltonian`](system::Hamiltonian): energies, gradients, proven first integrals.
//! * **Shared functions.** Hamiltonians may call functions that carry [`#[hamiltonian_fn]`](hamiltonian_fn), and methods of
//!   an `impl` that carries it. Potentials can live in modules and crates of their own; facts and derivatives are those of
//!   the inlined expression.
//! * **Schemes** are types, the [embeddings](embedding): the points at which the discrete antiderivative evaluates `q`. For
//!   each one listed the struct implements [`Discretized`](system::Discretized). Its [`PLAN`](plan::Plan) states the facts:
//!   how the step is solved, whether the scheme is consistent, whether the energy is conserved. Its `EQUATIONS` print the
//!   derivation.
//! * **One step at a time**: `kubo.stepper::<Midpoint>(h)?` is a [`Stepper`](step::Stepper);
//!   `stepper.step(&mut state, &[dw])?` allocates nothing, and on an error leaves the state unchanged, bit for bit.
//! * **One path**: `kubo.simulate::<Midpoint>(h)` builds a [`Simulation`](simulate::Simulation), and running it gives a
//!   [`Trajectory`](trajectory::Trajectory): states, increments, drifts of energy and invariants, the residual of the
//!   discrete Euler-Lagrange equations. [`Increments::from`](increments::Increments) drives it with increments of your
//!   own.
//! * **Many paths**: `kubo.ensemble::<Midpoint>(h)` builds an [`Ensemble`](ensemble::Ensemble), and running it gives [`Statistics`](ensemble::Statistics), with
//!   the same bits however the work is split.
//! * **Order**: [`Verlet`](embedding::Verlet), compositions [`Composed`](embedding::Composed) of order 4 to 8, and [`Gauss`](embedding::Gauss) of order 2 to 32.
//! * **Results**: [`path.table()`](trajectory::Trajectory::table) has columns with the names of the closure, as CSV, JSON and (feature `columnar`) Parquet; with the
//!   feature `plot`, `path.plot()` draws figures.
//! * **Between the nodes**: [dense] output of every scheme, recorded times and exact ends, and the crossings of [sections](section).
//! * **The discrete calculus**, time scales and the operators on them, is [`calculus`];
//!   [`Trajectory::observable`](trajectory::Trajectory::observable) turns a path into a function on a time scale.
//! * **Is the step short enough?** `system.shadow_energy::<E>(&state, h)` is the [modified] energy that symplectic steps conserve, to its first terms;
//!   its drift in a run shows whether that theory applies.
//! * **Error against run time**: with the feature `report`, `report::WorkPrecision` measures schemes against
//!   each other and writes tables, plots and one HTML page.
//! * **Long runs**: a [`Checkpoint`](checkpoint::Checkpoint) lets a stopped run resume, bit for bit.
//! * **Derivatives**: [`Simulation::tangent`](simulate::Simulation::tangent) returns the end of a run with its derivative by the start, `tangent_by` those by parameters, and
//!   `adjoint` the gradient of a function of the end; [`scalar::Dual`] is the number type behind them.
//! * **Averages along one path**, with errors that include correlations: [`time_averages()`](simulate::Simulation::time_averages) and [`series`]. Temperatures and
//!   equipartition are among them; with the feature `correlation` there are correlation functions, too.
//! * **Errors** are values that say where, why and what to do; [`Error`] unites them.
//!
//! # Features
//!
//! | feature | default | brings |
//! |---|---|---|
//! | `noise` | yes | Wiener paths, Wong-Zakai approximations, normals from ChaCha8 |
//! | `ensemble` | yes | many paths: lanes, threads, statistics |
//! | `svg` | | `path.plot()`, `statistics.plot()`, figures as SVG |
//! | `plot` | | the same as SVG and PNG |
//! | `report` | | error against run time: tables, plots, one HTML page |
//! | `serde` | | serialisation of states and paths |
//! | `columnar` | | Parquet files |
//! | `correlation` | | correlation functions and times along a path, mean square displacements |
//! | `interrupt` | | Ctrl-C stops runs whose handle enables it; they keep their results so far |
//! | `mpi` | | ensembles on many machines (needs an MPI library) |

#![cfg_attr(docsrs, feature(doc_cfg))]

/// The attribute that derives everything: facts, discrete Lagrangian, equations and steps of a system.
///
/// | key | value |
/// |---|---|
/// | `drift` | the Hamiltonian `H_0`, a closure; or its two parts `[H_A, H_B]`, for [splittings](embedding::Composed) that solve each exactly |
/// | `noise` | a list of Hamiltonians `H_k`, each driven by a Wiener process in the sense of Stratonovich; `[\|q, p, k\| ...; N]` is a family of `N` |
/// | `force` | a force beside the Hamiltonian: a closure that returns one entry for each degree of freedom |
/// | `noise_force` | a list of such forces, each driven by a Wiener process |
/// | `friction` | rates in 1/time: an expression of fields, a list by degree of freedom, or a closure of the coordinates |
/// | `damping` | in its place, a matrix in mass/time that acts on the velocities |
/// | `temperature` | `kT` of the [heat bath](bath), in units of energy: an expression of fields |
/// | `embedding` | a [scheme](embedding), or a list of schemes; only these are generated |
/// | `invariant` | a list of first integrals, which the compiler must prove; `[name = \|q, p\| ...]` names them |
/// | `crate` | the path of this crate, if you renamed it |
///
/// Only `drift` and `embedding` are required. The struct implements [`Hamiltonian`](system::Hamiltonian), and [`Discretized<E>`](system::Discretized) for each
/// scheme `E`, with its [`PLAN`](plan::Plan) and its `EQUATIONS`. The trait [`Integrate`](integrate::Integrate) of the prelude begins its runs.
///
/// # Example and phase spaces
///
pub use wzvi_macros::hamiltonian;
pub use wzvi_macros::hamiltonian_fn;
pub use wzvi_runtime::algebra::{lanes, memory, scalar, state};
#[cfg(feature = "ensemble")]
pub use wzvi_runtime::ensemble;
pub use wzvi_runtime::ground::{calculus, handle, numbers, variables};
/// The crate that [`Ensemble::run_on`](ensemble::Ensemble::run_on) takes its communicators from.
#[cfg(feature = "mpi")]
pub use wzvi_runtime::mpi;
/// The vectors of a [`State`](state::State): functions generic over the scheme name them, as in
/// `fn run<E>(kubo: &Kubo) where Kubo: Discretized<E, Vector = SVector<f64, 1>>`.
pub use wzvi_runtime::nalgebra;
#[cfg(feature = "noise")]
pub use wzvi_runtime::noise;
pub use wzvi_runtime::path::Error;
pub use wzvi_runtime::path::{checkpoint, retry, section, series, simulate, step, trajectory};
#[cfg(feature = "svg")]
pub use wzvi_runtime::plot;
#[cfg(feature = "report")]
pub use wzvi_runtime::report;
pub use wzvi_runtime::saving::table;
pub use wzvi_runtime::scheme::{bath, compose, dense, elements, embedding, modified, plan, system};
pub use wzvi_runtime::{increments, integrate};

/// Errors. Each says where, why and what to do; none leaves a state changed.
pub mod error {
    pub use wzvi_runtime::error::*;
    pub use wzvi_runtime::path::Error;
}

#[cfg(not(feature = "report"))]
#[doc(hidden)]
pub mod absent;

#[doc(hidden)]
pub mod checks;

/// Everything that a program needs: `use wzvi::prelude::*`.
pub mod prelude {
    #[cfg(not(feature = "report"))]
    #[doc(hidden)]
    pub use crate::absent::WorkPrecision;
    pub use wzvi_macros::{hamiltonian, hamiltonian_fn};
    pub use wzvi_runtime::algebra::state::State;
    pub use wzvi_runtime::ground::handle::Handle;
    pub use wzvi_runtime::increments::{Increments, Noise};
    pub use wzvi_runtime::integrate::Integrate;
    #[cfg(feature = "noise")]
    pub use wzvi_runtime::noise::{StepNormals, Wiener, WongZakai};
    pub use wzvi_runtime::path::checkpoint::Checkpoint;
    pub use wzvi_runtime::path::retry::Retry;
    pub use wzvi_runtime::path::step::Stepper;
    pub use wzvi_runtime::path::trajectory::Trajectory;
    #[cfg(feature = "report")]
    pub use wzvi_runtime::report::WorkPrecision;
    pub use wzvi_runtime::scheme::elements::Iteration;
    pub use wzvi_runtime::scheme::embedding::prelude::*;
    pub use wzvi_runtime::scheme::plan::{Knowledge, NoiseClass, Plan, Solver};
    pub use wzvi_runtime::scheme::system::{Discretized, Hamiltonian, SystemState};
}

/// Names for generated code. Its version is pinned to that of the macro; nothing here is for users.
#[doc(hidden)]
pub mod __private {
    pub use core;
    pub use core::cmp::Ord;
    pub use core::convert::{Into, TryInto};
    pub use core::default::Default;
    pub use core::marker::{PhantomData, Sized};
    pub use core::mem::drop;
    pub use core::ops::{FnMut, Range};
    pub use core::option::Option::{self, None, Some};
    pub use core::primitive::{bool, f64, i128, isize, str, u32, usize};
    pub use core::result::Result::{self, Err, Ok};

    pub use crate::checks;
    pub use wzvi_macros::__continue;

    pub use wzvi_runtime::algebra::carry::{Carry, Compensation, Plain};
    pub use wzvi_runtime::algebra::scalar::{
        Constant, Factored, Mask, Number, Of, Over, Reals, Rounded, Scalar, Truths, Varied,
    };
    pub use wzvi_runtime::algebra::solve::*;
    pub use wzvi_runtime::algebra::state::{State, Vector};
    pub use wzvi_runtime::error::{ConfigError, StepFailure};
    pub use wzvi_runtime::ground::variables::{Labels, Variables};
    pub use wzvi_runtime::nalgebra::{DVector, SVector};
    pub use wzvi_runtime::scheme::bath;
    pub use wzvi_runtime::scheme::compose;
    pub use wzvi_runtime::scheme::elements;
    pub use wzvi_runtime::scheme::embedding;
    pub use wzvi_runtime::scheme::gauss;
    pub use wzvi_runtime::scheme::modified::Conservative;
    pub use wzvi_runtime::scheme::plan::{Facts, Knowledge, NoiseClass, Plan, Solver};
    pub use wzvi_runtime::scheme::system::{
        Discretized, Hamiltonian, Kind, Lift, Scheme, Solution, Straight, StraightLine, covector, gradient,
        varied,
    };

    pub use crate::__bindings as bindings;

    /// Stands for each binding of generated code until it is bound: a pattern may shadow a function, but not a
    /// constant.
    pub fn binding() {}
}

/// The names that generated code binds, so that no constant around can stand for them.
#[doc(hidden)]
#[macro_export]
macro_rules! __bindings {
    ($($name:ident)*) => {
        use $crate::__private::{$(binding as $name),*};
    };
}

/// The programs of the documents, as tests.
#[cfg(doctest)]
mod documents {
    macro_rules! pages {
        ($($page:ident: $file:literal),* $(,)?) => {
            $(#[doc = include_str!(concat!("../", $file))] pub struct $page;)*
        };
    }

    pages! {
        Readme: "README.md",
        Benchmarks: "docs/guide/benchmarks.md",
        Choosing: "docs/guide/choosing.md",
        Contributors: "docs/guide/contributors.md",
        Cookbook: "docs/guide/cookbook.md",
        CookbookDynamics: "docs/guide/cookbook-dynamics.md",
        CookbookFiles: "docs/guide/cookbook-files.md",
        CookbookNoise: "docs/guide/cookbook-noise.md",
        CookbookParts: "docs/guide/cookbook-parts.md",
        Elements: "docs/guide/elements.md",
        Ensembles: "docs/guide/ensembles.md",
        Errors: "docs/guide/errors.md",
        Facts: "docs/guide/facts.md",
        First: "docs/guide/first.md",
        Forces: "docs/guide/forces.md",
        FromDiffrax: "docs/guide/from-diffrax.md",
        FromHeyoka: "docs/guide/from-heyoka.md",
        FromOpenmm: "docs/guide/from-openmm.md",
        FromRebound: "docs/guide/from-rebound.md",
        FromSciml: "docs/guide/from-sciml.md",
        Glossary: "docs/guide/glossary.md",
        Introduction: "docs/guide/introduction.md",
        Language: "docs/guide/language.md",
        Long: "docs/guide/long.md",
        Noise: "docs/guide/noise.md",
        Order: "docs/guide/order.md",
        Output: "docs/guide/output.md",
        Results: "docs/guide/results.md",
        Routes: "docs/guide/routes.md",
        Stability: "docs/guide/stability.md",
        Theory: "docs/guide/theory.md",
    }

    #[cfg(feature = "mpi")]
    pages! {
        Cluster: "docs/guide/cluster.md",
    }
}
