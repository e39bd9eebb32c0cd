//! How much error for how much time: measurements, tables, plots and one HTML page.
//!
//! ```ignore
//! let report = kubo.work_precision()
//!     .start(State::new([0.0], [1.0]))
//!     .until(1.0)
//!     .step_sizes((4..=9).map(|k| 2f64.powi(-k)))
//!     .paths(400)
//!     .seed(7)
//!     .exact(|t, wiener| kubo.exact(t, wiener[0]))
//!     .observe("q", |state| state.q[0])
//!     .scheme::<Midpoint>()
//!     .scheme::<Corrected<DeltaPlus>>()
//!     .run()?;
//! report.print();
//! report.write("target/wzvi/kubo")?; // CSV, JSON, SVG, PNG and index.html
//! ```
//!
//! For each scheme and step size these are measured:
//!
//! * the strong error, root mean square over paths of `|z_N - z(T)|`, with its standard error;
//! * the weak errors of observables, with 95 % confidence intervals;
//! * the drift Hamiltonian: its linear trend over the run and the oscillation about that;
//! * failed steps (counted, not fatal) and Newton iterations;
//! * the run time: increments are drawn into memory first and timed by themselves, then the steps alone.
//!   After a warm-up the timings of all schemes and step sizes take turns, to and fro; medians and quartiles
//!   are given.
//!
//! Slopes are fitted on the part of the curve that is straight ([`fit`]).

mod accuracy;
mod data;
mod document;
mod figures;
mod files;
pub mod fit;
mod machine;
mod measure;
mod measurement;
mod method;
mod noise;
mod overlay;
mod pareto;
pub mod statistics;
mod table;
mod write;

pub use crate::trajectory::error::ReportError;
pub use data::{Cell, Report, Weak};
pub use document::Document;
pub use files::write_file;
pub use machine::Machine;
pub use measure::WorkPrecision;
pub use overlay::Overlay;
pub use pareto::Choice;

pub use crate::plot::{Axis, Figure, Look, Series, number};

/// A time with its unit, for people.
pub fn duration(seconds: f64) -> String {
    let (factor, unit) = match seconds {
        s if s >= 1.0 => (1.0, "s"),
        s if s >= 1e-3 => (1e3, "ms"),
        s if s >= 1e-6 => (1e6, "µs"),
        _ => (1e9, "ns"),
    };
    format!("{} {unit}", number(seconds * factor))
}
