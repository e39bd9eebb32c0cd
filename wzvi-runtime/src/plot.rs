//! Plots: figures as data, drawn as SVG and PNG without a font or a display on the machine (feature `plot`).
//!
//! ```ignore
//! let path = kubo.simulate::<Midpoint>(0.02)./* ... */run()?;
//! path.plot().phase_portrait().write("portrait.svg")?;
//! path.plot().energy_drift(&kubo).write("drift.png")?;
//! path.plot().orbit("q", "p")?.write("orbit.svg")?;
//! statistics.plot().histogram("q")?.write("density.svg")?;
//! ```
//!
//! [`Trajectory::plot`](crate::trajectory::recorded::Trajectory::plot) and `Statistics::plot` make figures of
//! paths and of ensembles. A [`Figure`] of your own takes any points, and a [`Sheet`] puts several into one
//! file. Colours are those of Okabe and Ito, which every kind of colour vision tells apart.

mod axes;
#[cfg(feature = "ensemble")]
mod chaos;
mod drawing;
mod figure;
mod layout;
mod path;
mod sheet;
#[cfg(feature = "ensemble")]
mod statistics;
mod ticks;

pub use crate::trajectory::error::PlotError;
#[cfg(feature = "ensemble")]
pub use chaos::ChaosMapPlot;
pub(crate) use drawing::Plot;
pub use figure::{Axis, Colour, Figure, Look, Series, Shades};
pub(crate) use layout::Layout;
pub use path::PathPlot;
pub use sheet::Sheet;
#[cfg(feature = "ensemble")]
pub use statistics::StatisticsPlot;

/// A number with three significant digits, for people.
pub fn number(value: f64) -> String {
    crate::ground::digits::number(value)
}
