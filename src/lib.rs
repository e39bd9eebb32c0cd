//! Variational integrators for (stochastic) Hamiltonian systems, derived at compile time.
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
//! Without noise, order 8 and 16 are as easy to have as order 2:
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
//! What is not Hamiltonian stands beside it. Friction and a temperature make a heat bath, whose part of the step is exact:
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
//! * **Shared functions.** Hamiltonians see through calls of functions that carry [`#[hamiltonian_fn]`](hamiltonian_fn), and of
//!   methods of an `impl` that carries it: potentials can live in modules and crates of their own, and facts and
//!   derivatives are those of the inlined expression.
//! * **Schemes** are types, the [embeddings](embedding): where the discrete antiderivative reads `q`. For each one
//!   listed the struct implements [`Discretized`](system::Discretized); its [`PLAN`](plan::Plan) says what the compiler
//!   found out (how the step is solved, whether the scheme is consistent, whether the energy is kept) and its
//!   `EQUATIONS` print what was derived.
//! * **One step at a time**: `kubo.stepper::<Midpoint>(h)?` is a [`Stepper`](step::Stepper);
//!   `stepper.step(&mut state, &[dw])?` allocates nothing and on an error leaves the state bit for bit as it was.
//! * **One path**: `kubo.simulate::<Midpoint>(h)` builds a [`Simulation`](simulate::Simulation), and running it gives a
//!   [`Trajectory`](trajectory::Trajectory): states, increments, drifts of energy and invariants, what is left of the
//!   discrete Euler-Lagrange equations. Given numbers serve as noise, too:
//!   [`Increments::from`](increments::Increments).
//! * **Many paths**: `kubo.ensemble::<Midpoint>(h)` builds an [`Ensemble`](ensemble::Ensemble), and running it gives [`Statistics`](ensemble::Statistics), the
//!   same bits however the work is split.
//! * **Order**: [`Verlet`](embedding::Verlet), compositions [`Composed`](embedding::Composed) of order 4 to 8, and [`Gauss`](embedding::Gauss) of order 2 to 32.
//! * **Results**: [`path.table()`](trajectory::Trajectory::table) has columns with the names of the closure, as CSV, JSON and (feature `columnar`) Parquet; with the
//!   feature `plot`, `path.plot()` draws.
//! * **Between the nodes**: [dense] output of every scheme, recorded times and exact ends, and the crossings of [sections](section).
//! * **The discrete calculus** behind it, time scales and the operators on them, is [`calculus`];
//!   [`Trajectory::observable`](trajectory::Trajectory::observable) takes a path there.
//! * **Is the step short enough?** `system.shadow_energy::<E>(&state, h)` is the [modified] energy that symplectic steps keep, to its first terms;
//!   how far it drifts in a run says whether the theory behind them applies.
//! * **How much error for how much time**: with the feature `report`, `report::WorkPrecision` measures schemes against
//!   each other and writes tables, plots and one HTML page.
//! * **Long runs**: with the feature `serde`, `checkpoint::Checkpoint` lets a run that was stopped go on, bit for bit.
//! * **Errors** are values that say where, why and what to do; [`Error`] is the sum of them all.
//!
//! # Features
//!
//! | feature | default | brings |
//! |---|---|---|
//! | `noise` | yes | Wiener paths, Wong-Zakai approximations, normals from ChaCha8 |
//! | `ensemble` | yes | many paths: lanes, threads, statistics |
//! | `plot` | | `path.plot()`, figures as SVG and PNG |
//! | `report` | | error against run time: tables, plots, one HTML page |
//! | `serde` | | checkpoints; states and paths that serialise |
//! | `columnar` | | Parquet files |
//! | `interrupt` | | Ctrl-C during a long ensemble keeps what is done |
//! | `mpi` | | ensembles on many machines (needs an MPI library) |

#![cfg_attr(docsrs, feature(doc_cfg))]

pub use wzvi_macros::{hamiltonian, hamiltonian_fn};
pub use wzvi_runtime::algebra::{lanes, memory, scalar, state};
#[cfg(feature = "ensemble")]
pub use wzvi_runtime::ensemble;
pub use wzvi_runtime::ground::{calculus, numbers, variables};
/// The crate that [`Ensemble::run_on`](ensemble::Ensemble::run_on) takes its communicators from.
#[cfg(feature = "mpi")]
pub use wzvi_runtime::mpi;
/// The vectors of a [`State`](state::State): functions generic over the scheme name them, as in
/// `fn run<E>(kubo: &Kubo) where Kubo: Discretized<E, Vector = SVector<f64, 1>>`.
pub use wzvi_runtime::nalgebra;
#[cfg(feature = "noise")]
pub use wzvi_runtime::noise;
pub use wzvi_runtime::path::Error;
#[cfg(feature = "serde")]
pub use wzvi_runtime::path::checkpoint;
pub use wzvi_runtime::path::{retry, section, series, simulate, step, trajectory};
#[cfg(feature = "plot")]
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

#[cfg(not(all(feature = "report", feature = "serde")))]
#[doc(hidden)]
pub mod absent;

#[doc(hidden)]
pub mod checks;

/// Everything that a scene needs: `use wzvi::prelude::*`.
pub mod prelude {
    #[cfg(not(feature = "serde"))]
    #[doc(hidden)]
    pub use crate::absent::Checkpoint;
    #[cfg(not(feature = "report"))]
    #[doc(hidden)]
    pub use crate::absent::WorkPrecision;
    pub use wzvi_macros::{hamiltonian, hamiltonian_fn};
    pub use wzvi_runtime::algebra::state::State;
    pub use wzvi_runtime::increments::{Increments, Noise};
    pub use wzvi_runtime::integrate::Integrate;
    #[cfg(feature = "noise")]
    pub use wzvi_runtime::noise::{StepNormals, Wiener, WongZakai};
    #[cfg(feature = "serde")]
    pub use wzvi_runtime::path::checkpoint::Checkpoint;
    pub use wzvi_runtime::path::retry::Retry;
    pub use wzvi_runtime::path::step::Stepper;
    pub use wzvi_runtime::path::trajectory::Trajectory;
    #[cfg(feature = "report")]
    pub use wzvi_runtime::report::WorkPrecision;
    pub use wzvi_runtime::scheme::elements::Iteration;
    pub use wzvi_runtime::scheme::embedding::{
        Aba864, Aba1064, Baoab, BlanesMoan4, BlanesMoan6, Chin4, Composed, Corrected, DeltaMinus, DeltaPlus,
        Gauss, GjI, Gjf, KahanLi6, KahanLi8, Lambda, Midpoint, Mixed, Obabo, Own, Splitting, Srkn6, Suzuki4,
        SuzukiUmeno8, TakahashiImada4, Thermostat, Uncorrected, Verlet, Yoshida4, Yoshida6,
    };
    pub use wzvi_runtime::scheme::plan::{Knowledge, NoiseClass, Plan, Solver};
    pub use wzvi_runtime::scheme::system::{Discretized, Hamiltonian, SystemState};
}

/// What generated code names. Its version is pinned to that of the macro; nothing here is for people.
#[doc(hidden)]
pub mod __private {
    pub use core;
    pub use core::cmp::Ord;
    pub use core::convert::{Into, TryInto};
    pub use core::default::Default;
    pub use core::marker::{PhantomData, Sized};
    pub use core::mem::drop;
    pub use core::ops::Range;
    pub use core::option::Option::{self, None, Some};
    pub use core::primitive::{bool, f64, i128, isize, str, u32, usize};
    pub use core::result::Result::{self, Err, Ok};

    pub use crate::checks;
    pub use wzvi_macros::__continue;

    pub use wzvi_runtime::algebra::carry::{Carry, Compensation, Plain};
    pub use wzvi_runtime::algebra::lanes::Lanes;
    pub use wzvi_runtime::algebra::scalar::{Beside, Constant, Mask, Number, Over, Rounded, Scalar};
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
        Apart, Gradient, Hamiltonian, Kind, Listed, Scheme, Solution, Straight, StraightLine, covector,
        gradient,
    };

    /// What bindings of generated code are called until they are bound: a pattern may shadow a function, and not a
    /// constant.
    pub fn binding() {}
}

/// What the documents say compiles and runs.
#[cfg(doctest)]
mod documents {
    macro_rules! pages {
        ($($page:ident: $file:literal),* $(,)?) => {
            $(#[doc = include_str!(concat!("../", $file))] pub struct $page;)*
        };
    }

    pages! {
        Readme: "README.md",
        Benchmarks: "docs/benchmarks.md",
        Elements: "docs/elements.md",
        Ensembles: "docs/ensembles.md",
        Forces: "docs/forces.md",
        Order: "docs/order.md",
        Output: "docs/output.md",
        Stability: "docs/stability.md",
        Choosing: "docs/guide/choosing.md",
        Contributors: "docs/guide/contributors.md",
        Errors: "docs/guide/errors.md",
        Facts: "docs/guide/facts.md",
        First: "docs/guide/first.md",
        Baths: "docs/guide/forces.md",
        Introduction: "docs/guide/introduction.md",
        Language: "docs/guide/language.md",
        Long: "docs/guide/long.md",
        Noise: "docs/guide/noise.md",
        Results: "docs/guide/results.md",
        Theory: "docs/guide/theory.md",
    }

    #[cfg(feature = "mpi")]
    pages! {
        Cluster: "docs/cluster.md",
    }
}
