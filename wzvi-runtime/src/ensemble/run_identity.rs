//! The identity of an ensemble, for its checkpoint.

use super::Ensemble;
use super::job::EnsembleJob;
use super::starts::{DrawPurpose, STARTS};
use crate::algebra::state::{State, Vector};
use crate::error::ConfigError;
use crate::ground::checksum::Checksum;
use crate::ground::numbers::Numbers as _;
use crate::increments::Identity;
use crate::scheme::system::Discretized;
use crate::statistics::{Statistics, StatisticsNode};
use crate::trajectory::Error;
use crate::trajectory::checkpoint::{
    self, Checkpoint, CheckpointError, CheckpointKeeper, CheckpointKind, CheckpointSetting, RunDescription,
    RunExtent,
};
use crate::trajectory::recording::RecordedTime;
use crate::trajectory::span::NodeGrid;
use crate::trajectory::step::Stepper;
use crate::trajectory::steps::SinglePath;

/// Steps after which observables are compared.
const COMPARED_STEPS: u64 = 3;
/// Starts of paths that are compared where they are those of a function.
const COMPARED_STARTS: u64 = 512;
/// Recorded nodes that a file lists; of more it has the checksum.
const MOST_LISTED: usize = 32;

impl<H: Discretized<E>, E, N, P> Ensemble<'_, H, E, N, P> {
    /// Resumes from the checkpoint if its file exists and belongs to this run. Writes checkpoints during the
    /// run and at its end: see [`crate::trajectory::checkpoint`]. A run that is stopped at any moment and
    /// started again gives the same statistics, bit for bit. Only the number of paths may grow from one run
    /// to the next: of one system, from one start, from [`Ensemble::starts`], or from the same list of
    /// starts. Systems by path must be the same.
    ///
    /// With [`Ensemble::until_error`] the run ends at once if the checkpoint meets the targets. Otherwise,
    /// and after a stop, it continues.
    ///
    /// Functions cannot be compared: observables and events are told apart by their names and by their values
    /// at the start and at the next three nodes of path 0.
    pub fn checkpoint(mut self, checkpoint: Checkpoint) -> Self {
        self.setup.keeping = CheckpointSetting::to(checkpoint);
        self
    }
}

/// Brings empty statistics to where the checkpoint is, if there is one.
pub(super) fn open<H: Discretized<E>, E>(
    keeping: CheckpointSetting,
    job: &EnsembleJob<'_, H, E>,
    statistics: &mut Statistics,
) -> Result<CheckpointKeeper, Error> {
    if !keeping.is_set() {
        return Ok(CheckpointKeeper::default());
    }
    if job.source.identity().is_none() {
        return Err(CheckpointError::Noise.into());
    }
    let extent = RunExtent { kind: CheckpointKind::Ensemble, all: job.paths, unit: job.chunk };
    keeping.open(extent, described(job, Vec::new())?, &mut |tape| statistics.pass(tape))
}

/// The properties that tell this run from others, with further settings of its kind.
pub(super) fn described<H: Discretized<E>, E>(
    job: &EnsembleJob<'_, H, E>,
    more: Vec<(&str, String)>,
) -> Result<RunDescription, Error> {
    let (of_starts, drawn) = starts(job)?;
    let settings = RunSettings {
        grid: &job.grid,
        recorded: &job.observed.recorded,
        empty: &job.observed.empty,
        clip: job.source.clip(job.grid.h),
        chunk: job.chunk,
        most_halvings: job.retry.most(),
        is_watched: job.is_watched,
    };
    let mut settings = settings.listed(more, of_starts);
    settings.extend(checkpoint::sections(&job.crossed.sections, &job.starts.first));
    settings.extend(systems(job));
    settings.extend(job.source.identity().map(Identity::into_settings).unwrap_or_default());
    let described =
        RunDescription::of(job.systems.common, &job.prepared.whole, job.grid.h, &job.starts.first, settings);
    Ok(described.starting(drawn).observing(&observed(job)?))
}

/// The settings of a run that say nothing of its system: listing them is compiled once for all systems.
struct RunSettings<'j> {
    grid: &'j NodeGrid,
    recorded: &'j [RecordedTime],
    empty: &'j Statistics,
    clip: f64,
    chunk: u64,
    most_halvings: u32,
    is_watched: bool,
}

impl RunSettings<'_> {
    /// By name, with further ones and that of the starts.
    fn listed(&self, more: Vec<(&str, String)>, of_starts: (String, String)) -> Vec<(String, String)> {
        let (empty, names) = (self.empty, self.empty.observables());
        let nodes: Vec<u64> = self.recorded.iter().map(|recorded| recorded.node).collect();
        let listed = match nodes.len() {
            0..=MOST_LISTED => format!("{nodes:?}"),
            count => format!("{count} (checksum {})", checkpoint::checksum(nodes)),
        };
        let events: Vec<&str> = empty.passages().iter().map(|passages| passages.name()).collect();
        let first = empty.nodes().first();
        let histograms = first.map_or(&[][..], StatisticsNode::histograms).iter().zip(empty.histogrammed());
        let histograms: Vec<String> = histograms
            .map(|(bins, observable)| {
                let (name, count) = (&names[*observable], bins.counts().len());
                format!("{name}: {count} from {:?} to {:?}", bins.edge(0), bins.edge(count))
            })
            .collect();
        let quantiles = first.is_some_and(|node| node.quantiles(0).is_some());
        let has_covariances = first.is_some_and(StatisticsNode::has_covariances);
        let settings = [
            ("the number of steps", self.grid.steps.to_string()),
            ("the steps before the recorded nodes", listed),
            ("the largest normal increment", format!("{:?}", self.clip)),
            ("the number of paths in a chunk", self.chunk.to_string()),
            ("the observables", names.join(", ")),
            ("the events", events.join(", ")),
            ("quantiles", quantiles.to_string()),
            ("the histograms", histograms.join(", ")),
            ("paths are kept", empty.paths.is_some().to_string()),
            ("covariances", has_covariances.to_string()),
            ("the halvings allowed", self.most_halvings.to_string()),
            ("energies are watched", self.is_watched.to_string()),
        ];
        let mut settings: Vec<(String, String)> =
            settings.into_iter().chain(more).map(|(name, value)| (name.to_owned(), value)).collect();
        if let Some(shorter) = self.grid.shorter {
            settings.push(("the size of the last step".to_owned(), format!("{shorter:?}")));
        }
        settings.push(of_starts);
        let inside = self.recorded.iter().filter(|recorded| recorded.is_inside);
        let inside: Vec<u64> = inside.map(|recorded| recorded.t.to_bits()).collect();
        if !inside.is_empty() {
            let name = "the recorded times between nodes (checksum)".to_owned();
            settings.push((name, checkpoint::checksum(inside)));
        }
        if let Some(crossings) = empty.crossings().first() {
            settings.push(("the crossings that are kept".to_owned(), crossings.most().to_string()));
        }
        let (added, words) = empty.added();
        if !added.is_empty() {
            settings.push(("the statistics that were added".to_owned(), added.join(", ")));
            settings.push(("their settings (checksum)".to_owned(), checkpoint::checksum(words)));
        }
        settings
    }
}

/// The identity of the starts, and the checksums by path of those of a function, of which the first are
/// compared. All starts of a list are compared, also where the run has fewer paths.
fn starts<H: Discretized<E>, E>(
    job: &EnsembleJob<'_, H, E>,
) -> Result<((String, String), Vec<u64>), ConfigError> {
    let name = "the states where paths start";
    let said = |what: &str| (name.to_owned(), what.to_owned());
    let Some(starts) = &job.starts.own else { return Ok((said("one state"), Vec::new())) };
    let listed = starts.listed();
    let mut checksums = Vec::new();
    for path in 0..listed.unwrap_or(COMPARED_STARTS.min(job.paths)) {
        let State { q, p, .. } =
            starts.of(DrawPurpose::Start, job.starts.seed, path).ok_or(ConfigError::Missing(STARTS))?;
        checksums.push(checksum_of([q.components(), p.components()]));
    }
    Ok(match listed {
        Some(_) => ((format!("{name} (checksum)"), checkpoint::checksum(checksums)), Vec::new()),
        None => (said("those of a function"), checksums),
    })
}

/// The checksum of a state.
fn checksum_of(numbers: [&[f64]; 2]) -> u64 {
    let mut checksum = Checksum::default();
    numbers.into_iter().flatten().for_each(|x| checksum.add(&x.to_bits().to_le_bytes()));
    checksum.value()
}

/// The identity of the systems: the numbers that their Hamiltonians read.
fn systems<H: Discretized<E>, E>(job: &EnsembleJob<'_, H, E>) -> Option<(String, String)> {
    if !job.systems.are_own() {
        return None;
    }
    let mut bits = Vec::new();
    for system in &job.systems.own {
        let mut index = 0;
        while let Some((_, value)) = system.parameter(index) {
            bits.push(value.to_bits());
            index += 1;
        }
    }
    Some(("the systems of the paths (checksum)".into(), checkpoint::checksum(bits)))
}

/// The identity of functions that cannot be compared: their values at the start and at the first nodes of
/// path 0, which the run visits itself. `p` and `p²` are the same at rest, but not a step later.
fn observed<H: Discretized<E>, E>(job: &EnsembleJob<'_, H, E>) -> Result<Vec<f64>, Error> {
    let mut seen = Vec::new();
    let mut see = |state: &State<H::Vector>| {
        let first = seen.len();
        seen.resize(first + job.observed.observables.len(), 0.0);
        job.observe(0, state, &mut seen[first..]);
        for event in &job.crossed.events {
            seen.push(event(state));
        }
    };
    let (mut state, mut dw, steps) = (job.starts.first.clone(), vec![0.0; job.processes()], job.grid.whole());
    see(&state);
    let mut noise = job.source.path(0);
    let mut path = SinglePath {
        stepper: &mut Stepper::<H, E, _>::of_many_paths(job.systems.of(0), job.grid.h, false)?,
        state: &mut state,
        noise: &mut Some(&mut *noise),
        dw: &mut dw,
        first: job.grid.first(),
    };
    let taken = (0..steps.min(COMPARED_STEPS)).try_for_each(|step| {
        let (stepper, step) = path.step(step);
        stepper.take_step(step)?;
        see(path.state);
        Ok(())
    });
    // A path that fails has fewer.
    match taken {
        Ok(()) | Err(Error::Step(_) | Error::Noise(_)) => Ok(seen),
        Err(error) => Err(error),
    }
}
