//! Conditions that end a run before all its paths are done.

use crate::error::{ConfigError, above_zero, wrong};
use crate::ground::digits::ShortestDecimal;
use crate::statistics::LossError;
use crate::statistics::{Statistics, StatisticsNode as Node, TargetStatus};

/// An error that is estimated from fewer paths is not trusted.
const LEAST_PATHS: u64 = 1024;

/// The largest share of one sample in the sum of squares with which an error is trusted. A sum of ten
/// comparable parts or more is known to `1/√10`, and its root, the error, to a sixth. In tails as heavy as
/// that of `exp(3 W)`, whose sum of squares consists of its largest parts at any size that can be run, it is
/// the share that says so: what it leaves of the coverage is measured below.
const MOST_SHARE: f64 = 0.1;

/// When the user has enough of a run, or too much.
#[derive(Default)]
pub(super) struct Control {
    /// Observables and the standard errors that are small enough for them.
    pub(super) targets: Vec<(String, f64)>,
    /// The fraction of the paths that may fail, if it is not [`MOST_LOSSES`].
    pub(super) losses: Option<f64>,
}

/// The fraction of the paths that may fail unless the user says otherwise.
pub(super) const MOST_LOSSES: f64 = 0.01;

impl Control {
    /// The fraction of the paths that may fail.
    pub(super) fn allowed_losses(&self) -> Result<f64, ConfigError> {
        match self.losses.unwrap_or(MOST_LOSSES) {
            fraction if (0.0..=1.0).contains(&fraction) => Ok(fraction),
            fraction => {
                wrong(format!("losses of {}: take a fraction from 0 to 1", ShortestDecimal(fraction)))
            }
        }
    }

    /// The targets, if they are for some of the observables `names`.
    pub(super) fn targets(&self, names: &[String]) -> Result<ErrorTargets, ConfigError> {
        let target = |(name, target): &(String, f64)| {
            above_zero(*target, |target| format!("a standard error of {target} as target"))?;
            Ok((super::checks::observable(name, names)?, *target))
        };
        Ok(ErrorTargets(self.targets.iter().map(target).collect::<Result<_, _>>()?))
    }
}

/// Observables by index, with the standard errors that are small enough.
pub(super) struct ErrorTargets(Vec<(usize, f64)>);

impl ErrorTargets {
    /// Whether all errors are small enough, and about how many paths that takes, of `limit` at most.
    pub(super) fn errors_reached(&self, statistics: &Statistics, limit: u64) -> (bool, u64) {
        let Some(end) = statistics.last() else { return (false, limit) };
        if self.0.is_empty() {
            return (false, limit);
        }
        let ratios = self.0.iter().map(|target| ratio(end, target));
        let ratio = ratios.fold(0.0, |largest, ratio| if ratio <= largest { largest } else { ratio });
        // Also for NaN, where paths have no finite values: only the limit ends the run.
        let expected = (ratio * ratio * statistics.begun() as f64).ceil();
        let expected = if expected < limit as f64 { expected as u64 } else { limit };
        (self.statuses(statistics).iter().all(|(_, status)| *status == TargetStatus::Met), expected)
    }

    /// The status of each target.
    pub(super) fn statuses(&self, statistics: &Statistics) -> Vec<(usize, TargetStatus)> {
        let Some(end) = statistics.last() else { return Vec::new() };
        let status = |target: &(usize, f64)| match target {
            (observable, _) if end.is_constant(*observable) => TargetStatus::Constant,
            target if end.count() >= LEAST_PATHS && ratio(end, target) <= 1.0 => {
                // Without any deviation no path has a share of it.
                if end.largest_share(target.0) > MOST_SHARE {
                    TargetStatus::Dominated
                } else {
                    TargetStatus::Met
                }
            }
            _ => TargetStatus::NotMet,
        };
        self.0.iter().map(|target| (target.0, status(target))).collect()
    }
}

/// An error in units of its target; NaN where it is not known.
fn ratio(end: &Node, (observable, target): &(usize, f64)) -> f64 {
    if end.is_constant(*observable) { f64::NAN } else { end.error_bound(*observable) / target }
}

/// The statistics, unless more than this fraction of the paths failed.
pub(super) fn unless_lost(statistics: Statistics, allowed: f64) -> Result<Statistics, Box<LossError>> {
    let (failed, begun) = (statistics.failed(), statistics.begun());
    match statistics.failures().first().copied() {
        Some(first) if failed as f64 > allowed * begun as f64 => {
            Err(Box::new(LossError { failed, begun, allowed, first, statistics: Box::new(statistics) }))
        }
        _ => Ok(statistics),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::blocks::draw_lanes;
    use crate::noise::random;
    use crate::noise::step_normals::STEPS;
    use crate::statistics::{RecordedNodes, Seen};

    /// Normals and uniform numbers, ten of the one or sixteen of the other from a block.
    struct Draws {
        key: [u32; 8],
        block: u64,
    }

    impl Draws {
        fn words(&mut self) -> [u32; 16] {
            self.block += 1;
            random::block(&self.key, 0, self.block)
        }

        fn normals(&mut self) -> [f64; STEPS] {
            self.block += 1;
            let mut drawn = [[0.0]; STEPS];
            draw_lanes(|_| (self.key, 0, self.block), &mut drawn);
            drawn.map(|[normal]| normal)
        }
    }

    /// Mean, number of samples and whether all of it was met, where samples come in blocks of 512 as in a
    /// run.
    fn run(target: f64, most: u64, mut block: impl FnMut(&mut Vec<f64>)) -> (f64, u64, TargetStatus) {
        let node = Node::new(1, true, (false, false), Vec::new());
        let empty = Statistics::new(vec!["x".into()], RecordedNodes::new(&[0.0], &node, Vec::new()));
        let mut statistics = empty.clone();
        let targets = ErrorTargets(vec![(0, target)]);
        let mut samples = Vec::new();
        while !targets.errors_reached(&statistics, most).0 && statistics.begun() < most {
            while samples.len() < 512 {
                block(&mut samples);
            }
            let mut part = empty.clone();
            for (path, sample) in (0..).zip(samples.drain(..512)) {
                part.see(path, &Seen::Values { node: 0, values: &[sample] });
            }
            statistics.merge(&part).unwrap();
        }
        let [(_, status)] = targets.statuses(&statistics)[..] else { panic!("one target") };
        (statistics.nodes()[0].mean(0), statistics.begun(), status)
    }

    /// How often a run that says that it met its target is farther than 1.96 targets from the truth, where a
    /// fraction of 0.05 is the law of a normal mean with that very error: that is promised, and three
    /// binomial deviations are allowed beyond. The sample variance alone is farther in 0.11 to 0.39 of the
    /// runs of the rare event and of the heavy tail. `tests/laws` has many more runs, and tails that are
    /// heavier.
    #[test]
    fn targets_that_are_met_cover() {
        let rare = |draws: &mut Draws, to: &mut Vec<f64>| {
            to.extend(draws.words().map(|word| f64::from(u8::from(f64::from(word) < 1e-3 * 2f64.powi(32)))));
        };
        let heavy = |draws: &mut Draws, to: &mut Vec<f64>| {
            to.extend(draws.normals().map(|x| (2.0 * x).exp()));
        };
        let normal = |draws: &mut Draws, to: &mut Vec<f64>| to.extend(draws.normals());
        type Sampler<'s> = &'s dyn Fn(&mut Draws, &mut Vec<f64>);
        let e2 = 2f64.exp();
        let cases: [(&str, Sampler<'_>, f64, f64); 4] = [
            ("rare", &rare, 1e-3, 1e-3),
            ("rare", &rare, 1e-3, 3e-4),
            ("heavy", &heavy, e2, 0.1 * e2),
            ("normal", &normal, 0.0, 0.02),
        ];
        for (number, (name, sample, mean, target)) in (0..).zip(cases) {
            let mut draws = Draws { key: [5, 0, 0, number, 0, 0, 7, 0], block: 0 };
            let (mut runs, mut drawn, mut met, mut far, mut paths) = (0, 0, 0, 0, 0);
            while runs < 1000 && drawn < 400_000 {
                runs += 1;
                let (found, n, status) = run(target, 1 << 18, |to| sample(&mut draws, to));
                drawn += n;
                // One of the heavy samples may have too large a share of the variance, whatever their number.
                assert!(status == TargetStatus::Met || name == "heavy", "{name} {target}");
                if status == TargetStatus::Met {
                    met += 1;
                    far += u32::from((found - mean).abs() > 1.96 * target);
                    paths += n;
                }
            }
            assert!(10 * met > runs, "{name} {target}: {met} of {runs} were met");
            let (fraction, paths) = (f64::from(far) / f64::from(met), paths as f64 / f64::from(met));
            println!("{name}, target {target:.1e}: beyond 1.96 targets in {fraction:.3}, {paths:.0} paths");
            let deviation = (0.05 * 0.95 / f64::from(met)).sqrt();
            assert!(fraction < 0.05 + 3.0 * deviation, "{name} {target}: {fraction} of {met}");
        }
    }
}
