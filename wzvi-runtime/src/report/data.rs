//! The raw numbers of a measurement.
//!
//! Tested by `tests/paths/report/files.rs`.

use serde::Serialize;

use super::Overlay;
use super::fit::{Sample, Slope, fit};
use super::machine::Machine;
use super::statistics::{Estimate, Spread};

/// The weak error of one observable.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Weak {
    /// Name of the observable.
    pub observable: String,
    /// `E f(z_N) - E f(z(T))`, signed.
    pub bias: Estimate,
}

/// The measurements of one scheme at one step size.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cell {
    /// The scheme.
    pub scheme: String,
    /// Step size.
    pub h: f64,
    /// Steps to the end.
    pub steps: usize,
    /// Paths that reached the end.
    pub paths: usize,
    /// Paths that ended early: a step failed.
    pub failures: usize,
    /// The error of the first path that ended early.
    pub failure: Option<String>,
    /// Root mean square over paths of `|z_N - z(T)|`, Euclidean in (q, p).
    pub strong: Estimate,
    /// Weak errors, in the order of the observables.
    pub weak: Vec<Weak>,
    /// Root mean square over paths of the linear trend of H_0, times the length of the run.
    pub energy_trend: Estimate,
    /// Root mean square over paths of the change of H_0 about that trend.
    pub energy_oscillation: Estimate,
    /// Newton iterations per step.
    pub iterations: f64,
    /// The largest number of iterations in one step.
    pub largest_iterations: u32,
    /// Seconds for the steps of one path; `None` if it was not timed.
    pub time: Option<Spread>,
    /// Seconds to draw the increments of one path.
    pub noise_time: Option<Spread>,
    /// The numbers of the paths that reached the end.
    pub path_numbers: Vec<u64>,
    /// `|z_N - z(T)|` of each of them.
    pub errors: Vec<f64>,
    /// Every timing of the steps of one path, seconds.
    pub times: Vec<f64>,
    /// Every timing of the increments of one path, seconds.
    pub noise_times: Vec<f64>,
}

impl Cell {
    /// Seconds for one path, noise included: medians.
    pub fn seconds(&self) -> Option<f64> {
        Some(self.time?.median + self.noise_time.map_or(0.0, |noise| noise.median))
    }
}

/// One measurement of a system: everything, ready to print and to write.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// The title of the measurement.
    pub title: String,
    /// The program and the machine.
    pub machine: Machine,
    /// Length of each run.
    pub span: f64,
    /// Noises of the system.
    pub noises: usize,
    /// Seed of the paths.
    pub seed: u64,
    /// The reference that states were compared with.
    pub reference: String,
    /// Whether the drift Hamiltonian of the system is a first integral: "Proven", "Refuted" or "Unknown".
    pub conserves_energy: String,
    /// Whether the measurement was stopped before its end.
    pub interrupted: bool,
    /// The measurements, scheme by scheme, large steps first.
    pub cells: Vec<Cell>,
    /// Points measured elsewhere.
    pub overlay: Vec<Overlay>,
}

impl Report {
    /// The schemes, in order.
    pub fn schemes(&self) -> Vec<&str> {
        let mut names: Vec<&str> = vec![];
        for cell in &self.cells {
            if !names.contains(&cell.scheme.as_str()) {
                names.push(&cell.scheme);
            }
        }
        names
    }

    /// The measurements of a scheme, large steps first.
    pub fn of<'a>(&'a self, scheme: &'a str) -> impl Iterator<Item = &'a Cell> + 'a {
        self.cells.iter().filter(move |cell| cell.scheme == scheme)
    }

    /// The fitted slope of the strong error of a scheme.
    pub fn slope(&self, scheme: &str) -> Slope {
        let samples: Vec<Sample> = self
            .cells
            .iter()
            .filter(|cell| cell.scheme == scheme)
            .map(|cell| Sample {
                h: cell.h,
                error: cell.strong.value,
                standard_error: cell.strong.standard_error,
            })
            .collect();
        fit(&samples)
    }
}
