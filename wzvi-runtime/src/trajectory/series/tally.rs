//! Running averages of a run that keeps no path.

use super::BatchMeans;
use crate::algebra::state::State;
use crate::error::{UnknownName, above_zero, wrong};
use crate::ground::digits::ShortestDecimal;
use crate::ground::numbers::{Numbers, Tape};
use crate::trajectory::Error;
use crate::trajectory::checkpoint::checksum;
use crate::trajectory::options::Observable;
use crate::trajectory::simulate::{Node, Observer};

/// Observables, and the errors that are small enough for them.
pub(super) type NamedTargets = Vec<(String, f64)>;

/// The averages of a run that keeps no path.
pub(crate) struct Averaged<'a, V> {
    pub(crate) names: Vec<String>,
    pub(crate) functions: Vec<Observable<'a, V>>,
    /// The time of its start, and its step size.
    pub(crate) start: f64,
    pub(crate) h: f64,
    /// How many steps there are from one value to the next.
    pub(crate) stride: u64,
}

/// When it is looked again whether errors are small enough: after so many values, and after a fiftieth more.
const LOOKS: u64 = 64;

/// The values of observables at every `stride`-th node.
pub(crate) struct Tally<'a, V> {
    averaged: Averaged<'a, V>,
    /// Time from the start that is discarded.
    discarded: f64,
    /// The target errors, infinite where there is no target.
    wanted: Vec<f64>,
    batches: Vec<BatchMeans>,
    /// How many values there were at the last look at the errors.
    looked: u64,
}

impl<'a, V> Tally<'a, V> {
    /// A tally of these observables.
    pub(super) fn new(
        averaged: Averaged<'a, V>,
        discarded: f64,
        targets: &NamedTargets,
    ) -> Result<Self, Error> {
        if !(discarded.is_finite() && discarded >= 0.0) {
            return wrong(format!(
                "`discard({})`: take a finite time, 0 or more",
                ShortestDecimal(discarded)
            ));
        }
        let names = &averaged.names;
        let mut wanted = vec![f64::INFINITY; names.len()];
        for (name, target) in targets {
            let place = UnknownName::find("observable", name, names.iter().zip(0..))?;
            above_zero::<Error>(*target, |target| format!("an error of {target} for `{name}`"))?;
            wanted[place] = wanted[place].min(*target);
        }
        let batches = vec![BatchMeans::new(); names.len()];
        Ok(Self { averaged, discarded, wanted, batches, looked: 0 })
    }

    /// Whether all errors are small enough.
    pub(super) fn meets_targets(&self) -> bool {
        let mut all = self.batches.iter().zip(&self.wanted);
        all.all(|(batches, wanted)| *wanted == f64::INFINITY || batches.meets(*wanted))
    }

    /// With their names.
    pub(super) fn batches(&self) -> impl Iterator<Item = (&String, &BatchMeans)> {
        self.averaged.names.iter().zip(&self.batches)
    }

    fn count(&self) -> u64 {
        self.batches.first().map_or(0, BatchMeans::count)
    }
}

impl<V> Observer<V> for Tally<'_, V> {
    const AVERAGES: bool = true;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn observe(&mut self, state: &State<V>, node: &Node<'_>) {
        let is_seen = node.step > 0 && node.step.is_multiple_of(self.averaged.stride);
        if !is_seen || (state.t - self.averaged.start).abs() < self.discarded {
            return;
        }
        for (batches, function) in self.batches.iter_mut().zip(&self.averaged.functions) {
            batches.add(function(state));
        }
        let count = self.count();
        if count - self.looked >= LOOKS.max(self.looked / 50) {
            self.looked = count;
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn next(&self, node: u64) -> u64 {
        (node / self.averaged.stride + 1).saturating_mul(self.averaged.stride)
    }

    /// Whether the errors were looked at after the last value, and were small enough.
    fn has_enough(&self) -> bool {
        let has_targets = self.wanted.iter().any(|wanted| wanted.is_finite());
        has_targets && self.looked == self.count() && self.meets_targets()
    }

    fn described(&self, start: &State<V>) -> Vec<(String, String)> {
        let values = self.averaged.functions.iter().map(|function| function(start).to_bits());
        let fields = [
            ("the averages of", self.averaged.names.join(", ")),
            ("the nodes from one value to the next", self.averaged.stride.to_string()),
            ("the time that is discarded", format!("{:?}", self.discarded)),
            ("what is averaged, at the start (checksum)", checksum(values)),
        ];
        fields.map(|(name, value)| (name.to_owned(), value)).into()
    }

    fn pass(&mut self, tape: &mut Tape) {
        tape.word(&mut self.looked);
        self.batches.pass(tape);
    }
}
