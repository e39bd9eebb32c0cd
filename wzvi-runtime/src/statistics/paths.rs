//! Whole paths, kept on request.
//!
//! Tested by `tests/ensembles/statistics.rs`.

use crate::error::{ConfigError, wrong};
use crate::ground::names::free;
use crate::ground::numbers::{Numbers, Tape};
use crate::saving::table::TableRows;
use crate::statistics::results::Statistics;
use crate::statistics::statistic::{Seen, Statistic, Tables};

/// The observables of every path at every recorded node.
#[derive(Clone, Debug, PartialEq)]
pub struct PathValues {
    nodes: usize,
    observables: usize,
    /// The number of the first path of these.
    first: u64,
    /// By path, node, observable; NaN from the node on that a path does not reach.
    values: Vec<f64>,
}

impl PathValues {
    pub(crate) fn new(nodes: usize, observables: usize) -> Self {
        Self { nodes, observables, first: 0, values: Vec::new() }
    }

    /// Bytes for so many paths.
    pub(crate) fn bytes(paths: u64, nodes: usize, observables: usize) -> u128 {
        u128::from(paths) * (nodes * observables * size_of::<f64>()) as u128
    }

    /// Takes the memory for so many paths.
    pub(crate) fn reserve(&mut self, paths: u64) -> Result<(), ConfigError> {
        let bytes = Self::bytes(paths, self.nodes, self.observables);
        let numbers = usize::try_from(bytes / size_of::<f64>() as u128).unwrap_or(usize::MAX);
        let room = self.values.try_reserve_exact(numbers);
        room.or_else(|_| wrong(format!("there is no memory for the {bytes} bytes of all paths: keep fewer")))
    }

    /// How many paths there are.
    pub fn count(&self) -> usize {
        self.values.len() / (self.nodes * self.observables).max(1)
    }

    /// The observables of a path at a recorded node, NaN if it failed before; `None` for a path or node that
    /// does not exist.
    pub fn at(&self, path: usize, node: usize) -> Option<&[f64]> {
        if path >= self.count() || node >= self.nodes {
            return None;
        }
        let first = (path * self.nodes + node) * self.observables;
        self.values.get(first..first + self.observables)
    }
}

/// Collects paths if they are kept.
impl Statistic for Option<PathValues> {
    fn see(&mut self, path: u64, seen: &Seen<'_>) {
        let (Some(paths), Seen::Values { node, values: seen }) = (self, *seen) else { return };
        let PathValues { nodes, observables, first, values } = paths;
        let width = *nodes * *observables;
        if node == 0 {
            // Every path begins.
            *first = if values.is_empty() { path } else { *first };
            values.resize(values.len() + width, f64::NAN);
        }
        let place = (path - *first) as usize * width + node * *observables;
        if let Some(to) = values.get_mut(place..place + *observables) {
            to.copy_from_slice(seen);
        }
    }

    fn merge(&mut self, later: &Self) {
        if let (Some(ours), Some(theirs)) = (self, later) {
            ours.values.extend_from_slice(&theirs.values);
        }
    }

    fn rows<'s>(&'s self, run: &'s Statistics) -> Tables<'s> {
        let varying = run.origin.as_ref().map_or(&[][..], |origin| &origin.varying);
        let each = self.iter().flat_map(move |paths| {
            let nodes = move |path| run.nodes().iter().enumerate().map(move |node| (paths, path, node));
            (0..paths.count()).flat_map(nodes)
        });
        let mut rows = TableRows::of(each)
            .column("path", |&(_, path, _)| path as u64)
            .column("time", |(.., (_, node))| node.time());
        for (name, own) in varying {
            let name = free(name, rows.names().chain(run.observables().iter().map(String::as_str)));
            rows = rows.column(name, |&(_, path, _)| own.get(path).copied().unwrap_or(f64::NAN));
        }
        for (index, name) in run.observables().iter().enumerate() {
            rows = rows.column(name, move |&(paths, path, (node, _))| {
                paths.at(path, node).map_or(f64::NAN, |values| values[index])
            });
        }
        Tables(vec![rows.parts("paths")])
    }
}

impl Numbers for Option<PathValues> {
    fn pass(&mut self, tape: &mut Tape) {
        let Some(PathValues { nodes, observables, values, .. }) = self else { return };
        let length = tape.length(values.len());
        values.resize(length, f64::NAN);
        tape.numbers(values);
        if !length.is_multiple_of((*nodes * *observables).max(1)) {
            tape.refuse();
        }
    }
}
