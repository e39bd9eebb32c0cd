//! Variational integrators for (stochastic) Hamiltonian systems, derived at compile time: for long runs and
//! many paths in which energy, phase-space volume and first integrals must not drift.
//!
//! You write the Hamiltonian as a closure. `#[hamiltonian]` embeds the action principle in discrete time,
//! differentiates the discrete Lagrangian symbolically and emits the step that solves the discrete
//! Euler-Lagrange equations:
//!
//! ```
//! use wzvi::prelude::*;
//!
//! /// A pendulum; length and mass are 1.
//! #[hamiltonian(
//!     drift = |angle, momentum| 0.5 * momentum * momentum - g * angle.cos(),
//!     embedding = [Midpoint, Verlet],                    // the schemes to generate
//! )]
//! struct Pendulum {
//!     /// Acceleration of gravity.
//!     g: f64,
//! }
//!
//! fn main() -> Result<(), wzvi::Error> {
//!     let pendulum = Pendulum { g: 9.81 };
//!     let path = pendulum
//!         .simulate::<Verlet>(0.01)                      // step size
//!         .start(State::new([2.0], [0.0]))               // angle and momentum at t = 0
//!         .until(10.0)
//!         .run()?;
//!     println!("{}, energy off by at most {:.1e}", path.last(), path.energy_drift(&pendulum));
//!     assert!(path.energy_drift(&pendulum) < 3e-3);
//!     Ok(())
//! }
//! ```
//!
//! Noise is one more closure, and many paths are one more call. Kubo's oscillator is a rotation whose angle
//! diffuses:
//!
//! ```
//! use wzvi::prelude::*;
//!
//! #[hamiltonian(
//!     drift = |q, p| 0.5 * a * (q * q + p * p),
//!     noise = [|q, p| 0.5 * sigma * (q * q + p * p)],
//!     embedding = Midpoint,
//!     invariant = [|q, p| q * q + p * p],
//! )]
//! struct Kubo {
//!     /// Mean angular frequency.
//!     a: f64,
//!     /// Intensity of the noise.
//!     sigma: f64,
//! }
//!
//! fn main() -> Result<(), wzvi::Error> {
//!     let kubo = Kubo { a: 1.5, sigma: 1.0 };
//!     let start = State::new([0.0], [1.0]);
//!     let path = kubo.simulate::<Midpoint>(0.02).start(start).noise(Wiener::seed(7)).until(20.0).run()?;
//!     assert!(path.energy_drift(&kubo) < 1e-13);
//!
//!     let statistics = kubo
//!         .ensemble::<Midpoint>(0.02)                    // in vector registers and on all cores
//!         .start(start)
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
//! Non-Hamiltonian terms are declared beside the drift. Friction and a temperature make a heat bath, whose
//! part of the step is exact:
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
//! Constraints are declared beside it, too. [`Rattle`](embedding::Rattle) keeps the path on their manifold; a
//! rotation matrix brings its own:
//!
//! ```
//! use wzvi::constraints::RigidBody;
//! use wzvi::nalgebra::{Rotation3, Vector3};
//! use wzvi::prelude::*;
//!
//! #[hamiltonian(
//!     drift = |q: Rotation, p| {
//!         let row = |i: usize| (0..3).map(|a| p[i][a] * p[i][a] / (2.0 * d[a])).sum::<f64>();
//!         row(0) + row(1) + row(2) + weight * q[2][2]
//!     },
//!     embedding = Rattle,
//! )]
//! struct Top {
//!     d: [f64; 3],
//!     weight: f64,
//! }
//!
//! fn main() -> Result<(), Box<dyn std::error::Error>> {
//!     let body = RigidBody::new([1.0, 1.0, 1.5])?;
//!     let top = Top { d: body.masses(), weight: 2.0 };
//!     let tilted = Rotation3::from_axis_angle(&Vector3::x_axis(), 0.3);
//!     let start = body.state(tilted, Vector3::new(0.0, 0.0, 5.0));
//!     let path = top.simulate::<Rattle>(0.01).start(start).until(10.0).run()?;
//!     let vertical = body.angular_momentum_in_space(path.last()).z;
//!     assert!((vertical - 7.5 * 0.3_f64.cos()).abs() < 1e-12);
//!     Ok(())
//! }
//! ```
//!
//! # The tour
//!
//! * **A system** has a drift `H_0` and noises `H_k`, in the sense of Stratonovich:
//!   `dq = Σ_m ∂H_m/∂p ∘ dX_m`, `dp = -Σ_m ∂H_m/∂q ∘ dX_m` with `X_0 = t`, `X_k = W_k`. The struct implements
//!   [`Hamiltonian`](system::Hamiltonian): energies, gradients, proven first integrals. Functions that carry
//!   [`#[hamiltonian_fn]`](hamiltonian_fn) may be shared between Hamiltonians, modules and crates.
//! * **A scheme** is a type, an [embedding]: order 2 with [`Verlet`](embedding::Verlet) and `Midpoint`, 4 to
//!   8 with [`Composed`](embedding::Composed), up to 32 with [`Gauss`](embedding::Gauss). For each one listed
//!   the struct implements [`Discretized`](system::Discretized): [`PLAN`](plan::Plan) states the facts,
//!   `EQUATIONS` prints the derivation.
//! * **A run**: `system.simulate::<E>(h)` builds a [`Simulation`](simulate::Simulation), which gives a
//!   [`Trajectory`](trajectory::Trajectory) with tables and plots; `system.ensemble::<E>(h)` builds an
//!   [`Ensemble`](ensemble::Ensemble), which gives [`Statistics`](ensemble::Statistics).
//!   `system.stepper::<E>(h)` takes [one step at a time](step::Stepper), and allocates nothing.
//! * **Between and beyond the nodes**: [dense] output, crossings of [sections](section), derivatives by
//!   [start and parameters](simulate::Simulation::tangent), [averages along a path](series), [modified]
//!   energies.
//! * **Long runs** stop and resume with the same bits by a [`Checkpoint`](checkpoint::Checkpoint).
//! * **Errors** are values that say where, why and what to do, and leave the state unchanged; [`Error`]
//!   unites them.
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
//!
//! Documentation that you build yourself shows the items of a feature only with that feature:
//! `cargo doc --features plot,correlation`.

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
/// | `calculus` | `Ito`: the noises are in the sense of Ito, and the system is converted to that of Stratonovich, or refused |
/// | `constraint` | a list of [constraints] `g(q) = 0` or `g(q, t) = 0`, closures of the coordinates; `[\|q, k\| ...; N]` is a family of `N`. Their schemes are [`Rattle`](embedding::Rattle), its compositions and [`GBaoab`](embedding::GBaoab) |
/// | `embedding` | a [scheme](embedding), or a list of schemes; only these are generated |
/// | `invariant` | a list of first integrals, which the compiler must prove; `[name = \|q, p\| ...]` names them |
/// | `observe` | a list of named functions of the state, `[radius = \|q, p\| ...]`, for [tables, plots and statistics](system::Quantity); steps and proofs do not depend on them |
/// | `export` | a list of schemes beside the embeddings, or `[]`: programs in other languages make and run the system ([`Exported`](exported::Exported)) |
/// | `crate` | the path of this crate, if you renamed it |
///
/// Only `drift` and `embedding` are required. The struct implements [`Hamiltonian`](system::Hamiltonian), and
/// [`Discretized<E>`](system::Discretized) for each scheme `E`, with its [`PLAN`](plan::Plan) and its
/// `EQUATIONS`. The trait [`Integrate`](integrate::Integrate) of the prelude begins its runs.
///
/// # Example and phase spaces
///
pub use wzvi_macros::hamiltonian;
pub use wzvi_macros::hamiltonian_fn;
pub use wzvi_runtime::algebra::{lanes, memory, scalar, state};
pub use wzvi_runtime::calculus;
#[cfg(feature = "ensemble")]
pub use wzvi_runtime::ensemble;
pub use wzvi_runtime::ground::{handle, numbers, variables};
/// The crate that [`Ensemble::run_on`](ensemble::Ensemble::run_on) takes its communicators from.
#[cfg(feature = "mpi")]
pub use wzvi_runtime::mpi;
/// The vectors of a [`State`](state::State): functions generic over the scheme name them, as in
/// `fn run<E>(kubo: &Kubo) where Kubo: Discretized<E, Vector = SVector<f64, 1>>`.
pub use wzvi_runtime::nalgebra;
#[cfg(feature = "noise")]
pub use wzvi_runtime::noise;
#[cfg(feature = "svg")]
pub use wzvi_runtime::plot;
#[cfg(feature = "report")]
pub use wzvi_runtime::report;
pub use wzvi_runtime::saving::table;
pub use wzvi_runtime::scheme::{
    bath, clock, compose, constraints, dense, elements, embedding, modified, plan, system,
};
pub use wzvi_runtime::trajectory::Error;
pub use wzvi_runtime::trajectory::{
    chaos, checkpoint, events, recorded as trajectory, retry, section, series, simulate, step,
};
pub use wzvi_runtime::{exported, increments, integrate};

/// Errors. Each says where, why and what to do; none leaves a state changed.
pub mod error {
    pub use wzvi_runtime::error::*;
    pub use wzvi_runtime::trajectory::error::*;
}

#[cfg(not(feature = "report"))]
#[doc(hidden)]
pub mod absent;

#[doc(hidden)]
pub mod checks;

pub mod functions;

/// Everything that a program needs: `use wzvi::prelude::*`.
pub mod prelude {
    #[cfg(not(feature = "report"))]
    #[doc(hidden)]
    pub use crate::absent::WorkPrecision;
    pub use crate::functions::SpecialFunctions;
    pub use wzvi_macros::{hamiltonian, hamiltonian_fn};
    pub use wzvi_runtime::algebra::state::State;
    pub use wzvi_runtime::ground::handle::Handle;
    pub use wzvi_runtime::increments::{Increments, Noise};
    pub use wzvi_runtime::integrate::Integrate;
    #[cfg(feature = "noise")]
    pub use wzvi_runtime::noise::{StepNormals, Wiener, WongZakai};
    #[cfg(feature = "report")]
    pub use wzvi_runtime::report::WorkPrecision;
    pub use wzvi_runtime::scheme::clock::Eps;
    pub use wzvi_runtime::scheme::constraints::Rotation;
    pub use wzvi_runtime::scheme::elements::Iteration;
    pub use wzvi_runtime::scheme::embedding::prelude::*;
    pub use wzvi_runtime::scheme::plan::{Knowledge, NoiseClass, Plan, Solver};
    pub use wzvi_runtime::scheme::system::{Discretized, Hamiltonian, SystemState};
    pub use wzvi_runtime::trajectory::checkpoint::Checkpoint;
    pub use wzvi_runtime::trajectory::events::Terminal;
    pub use wzvi_runtime::trajectory::recorded::Trajectory;
    pub use wzvi_runtime::trajectory::retry::Retry;
    pub use wzvi_runtime::trajectory::section::Direction;
    pub use wzvi_runtime::trajectory::step::Stepper;
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
    pub use crate::functions::{ErrorFunctions, SpecialFunctions};
    pub use wzvi_macros::__continue;

    pub use wzvi_runtime::algebra::scalar::{
        ComputesWith, Constant, ConstantsIn, Factored, Mask, Number, Reals, Rounded, Scalar, Special, Truths,
        Varied,
    };
    pub use wzvi_runtime::algebra::solve::*;
    pub use wzvi_runtime::algebra::state::{State, Vector};
    pub use wzvi_runtime::algebra::state_sum::{FixedCompensatedSum, PlainSum, StateSum};
    pub use wzvi_runtime::error::{ConfigError, StepFailure};
    pub use wzvi_runtime::ground::variables::{Labels, Variables};
    pub use wzvi_runtime::nalgebra::{DVector, SVector};
    pub use wzvi_runtime::scheme::bath;
    pub use wzvi_runtime::scheme::clock;
    pub use wzvi_runtime::scheme::compose;
    pub use wzvi_runtime::scheme::constraints;
    pub use wzvi_runtime::scheme::elements;
    pub use wzvi_runtime::scheme::embedding;
    pub use wzvi_runtime::scheme::gauss;
    pub use wzvi_runtime::scheme::modified::Conservative;
    pub use wzvi_runtime::scheme::plan::{Facts, Knowledge, NoiseClass, Plan, Solver};
    pub use wzvi_runtime::scheme::system::{
        Discretized, Hamiltonian, Kind, LiftParameter, Scheme, Solution, Straight, StraightLine, covector,
        gradient, varied,
    };

    pub use crate::__bindings as bindings;

    /// Stands for each binding of generated code until it is bound: a pattern may shadow a function, but not
    /// a constant.
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
        Clock: "docs/guide/clock.md",
        Constraints: "docs/guide/constraints.md",
        Contributors: "docs/guide/contributors.md",
        Cookbook: "docs/guide/cookbook.md",
        CookbookDynamics: "docs/guide/cookbook-dynamics.md",
        CookbookFiles: "docs/guide/cookbook-files.md",
        CookbookNoise: "docs/guide/cookbook-noise.md",
        CookbookParts: "docs/guide/cookbook-parts.md",
        CookbookSpins: "docs/guide/cookbook-spins.md",
        Elements: "docs/guide/elements.md",
        Ensembles: "docs/guide/ensembles.md",
        Errors: "docs/guide/errors.md",
        Facts: "docs/guide/facts.md",
        First: "docs/guide/first.md",
        Forces: "docs/guide/forces.md",
        FromDiffrax: "docs/guide/from-diffrax.md",
        FromHeyoka: "docs/guide/from-heyoka.md",
        FromOpenmm: "docs/guide/from-openmm.md",
        FromPython: "docs/guide/from-python.md",
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
