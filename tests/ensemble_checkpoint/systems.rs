//! What the tests run, and how they compare.

use std::path::{Path, PathBuf};

use wzvi::checkpoint::{Checkpoint, CheckpointError};
use wzvi::ensemble::{Ensemble, Statistics};
use wzvi::prelude::*;

/// Undefined for negative `q`, where some paths go: they fail.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + a * q * q.sqrt(),
    noise = [|q, p| -sigma * q],
    embedding = [DeltaPlus, Midpoint],
)]
#[derive(Clone, Debug)]
pub(crate) struct Edge {
    pub(crate) a: f64,
    pub(crate) sigma: f64,
}

pub(crate) const EDGE: Edge = Edge { a: 1.0, sigma: 0.5 };

/// Four blocks and a part of a fifth.
pub(crate) const PATHS: u64 = 4 * 512 + 100;

impl Edge {
    /// Everything that statistics can have.
    pub(crate) fn run<E>(&self) -> Ensemble<'_, Self, E>
    where
        Self: Discretized<E, Vector = wzvi::nalgebra::SVector<f64, 1>>,
    {
        self.summed().keep_paths(1 << 20)
    }

    /// Everything that does not grow with the number of paths.
    pub(crate) fn summed<E>(&self) -> Ensemble<'_, Self, E>
    where
        Self: Discretized<E, Vector = wzvi::nalgebra::SVector<f64, 1>>,
    {
        self.ensemble::<E>(0.05)
            .start(State::new([1.0], [0.5]))
            .paths(PATHS)
            .seed(7)
            .steps(24)
            .record_every(6)
            .observe("q", |state| state.q[0])
            .observe("mixed", |state| state.q[0].ln() - state.p[0])
            .first_passage("rising", |state| state.p[0] - 0.6)
            .quantiles()
            .histogram("q", 0.0, 2.0, 20)
            .threads(2)
            .allow_losses(1.0)
    }

    pub(crate) fn kept(&self, file: &Path) -> Ensemble<'_, Self, DeltaPlus> {
        self.run().checkpoint(Checkpoint::to(file))
    }
}

/// The text of a number says which one it is; zeros keep their sign.
pub(crate) fn bits(statistics: &Statistics) -> String {
    format!("{statistics:?}")
}

/// The run that nobody stopped.
pub(crate) fn whole() -> String {
    let statistics = EDGE.run::<DeltaPlus>().run().unwrap();
    assert!((10..500).contains(&statistics.failed()), "{}", statistics.failed());
    let rising = statistics.passage("rising").unwrap();
    assert!(rising.passed() > 100 && rising.censored() > 0 && rising.lost() > 0, "{rising:?}");
    bits(&statistics)
}

/// A folder of the test's own, empty.
pub(crate) fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("ensemble-checkpoint").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// The error of a checkpoint.
pub(crate) fn refused(outcome: Result<Statistics, wzvi::Error>) -> CheckpointError {
    match outcome {
        Err(wzvi::Error::Checkpoint(error)) => error,
        Err(other) => panic!("{other:?}"),
        Ok(_) => panic!("the run went through"),
    }
}

/// Names and contents of the files in a folder.
pub(crate) fn contents(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut files: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .map(|path| (path.clone(), std::fs::read(path).unwrap_or_default()))
        .collect();
    files.sort();
    files
}
