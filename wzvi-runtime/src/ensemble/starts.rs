//! Starts and systems of their own for the paths of an ensemble.

use crate::algebra::state::{State, Vector};
use crate::error::{ConfigError, StepFailure, wrong};
use crate::noise::random::{self, pair};
use crate::scheme::system::Discretized;

/// A function from the generator of a path.
pub(super) type Sampler<'a, T> = Box<dyn Fn(&mut Draw) -> T + Send + Sync + 'a>;

/// A property of each path: its first state, or its system.
pub(super) enum ByPath<'a, T> {
    Listed(Vec<T>),
    Drawn(Sampler<'a, T>),
}

/// Whether each path of an ensemble has a system of its own: steps are compiled for one of the two.
pub trait Systems {
    /// Whether it has.
    const ARE_OWN: bool = false;
    /// Whether a coarser path goes beside each, on the same Brownian path.
    const ARE_PAIRED: bool = false;
    /// Whether each path is a run of its own, since events act on it.
    const ARE_RUNS: bool = false;
    /// The kind of these paths where each has a system of its own.
    type Own: Systems;
}

/// Each path is a run of its own, with events that act on it.
#[derive(Clone, Copy, Debug)]
pub enum RunByPath {}

impl Systems for RunByPath {
    const ARE_RUNS: bool = true;
    type Own = Self;
}

/// All paths are of one system.
#[derive(Clone, Copy, Debug)]
pub enum OneSystem {}

/// Each path has its own system.
#[derive(Clone, Copy, Debug)]
pub enum SystemByPath {}

/// All paths are of one system, in steps of two sizes: those of a level of a multilevel run.
#[derive(Clone, Copy, Debug)]
pub(super) enum Paired {}

impl Systems for OneSystem {
    type Own = SystemByPath;
}

impl Systems for Paired {
    const ARE_PAIRED: bool = true;
    type Own = Self;
}

impl Systems for SystemByPath {
    const ARE_OWN: bool = true;
    type Own = Self;
}

/// The kind of a draw: starts and systems are independent.
#[derive(Clone, Copy, Debug)]
pub(super) enum DrawPurpose {
    Start,
    System,
}

impl<T: Clone> ByPath<'_, T> {
    /// The value of a path; `None` beyond the end of a list.
    pub(super) fn of(&self, drawn: DrawPurpose, seed: u64, path: u64) -> Option<T> {
        match self {
            Self::Listed(list) => usize::try_from(path).ok().and_then(|path| list.get(path)).cloned(),
            Self::Drawn(sampler) => Some(sampler(&mut Draw::new(drawn, seed, path))),
        }
    }
}

impl<T> ByPath<'_, T> {
    /// How many there are, if they are listed.
    pub(super) fn listed(&self) -> Option<u64> {
        match self {
            Self::Listed(list) => Some(list.len() as u64),
            Self::Drawn(_) => None,
        }
    }

    /// The values of so many paths; fewer if the list is shorter.
    ///
    /// # Errors
    /// If there is no memory for them.
    pub(super) fn into_list(self, drawn: DrawPurpose, seed: u64, paths: u64) -> Result<Vec<T>, ConfigError> {
        match self {
            Self::Listed(list) => Ok(list),
            Self::Drawn(sampler) => {
                let mut list = Vec::new();
                if usize::try_from(paths).ok().and_then(|paths| list.try_reserve_exact(paths).ok()).is_none()
                {
                    return wrong(format!(
                        "there is no memory for the systems of {paths} paths, which are all made before the run: ask for fewer `.paths(...)`"
                    ));
                }
                list.extend((0..paths).map(|path| sampler(&mut Draw::new(drawn, seed, path))));
                Ok(list)
            }
        }
    }
}

/// The error for a list that is too short.
pub(super) const STARTS: &str =
    "a start for each path: give `.starts_from(states)` as many as there are paths";

pub(super) const SYSTEMS: &str =
    "a system for each path: give `.systems_from(systems)` as many as there are paths";

/// Whether `state` can be where path `path` starts, at the time `t` of the others.
///
/// # Errors
/// [`ConfigError::PathStart`] and [`ConfigError::Setting`].
pub(super) fn check<H: Discretized<E>, E>(
    system: &H,
    state: &State<H::Vector>,
    path: u64,
    degrees: usize,
    t: f64,
) -> Result<(), ConfigError> {
    let numbers = StartNumbers { q: state.q.components(), p: state.p.components(), t: state.t };
    check_numbers(&numbers, path, degrees, t)?;
    match system.check(degrees) {
        Ok(()) => Ok(()),
        Err(cause) => Err(ConfigError::PathStart { path, cause }),
    }
}

/// The numbers of a start.
struct StartNumbers<'s> {
    q: &'s [f64],
    p: &'s [f64],
    t: f64,
}

/// Checks the numbers of the start of a path, for so many degrees of freedom and the time `t` of path 0.
fn check_numbers(
    &StartNumbers { q, p, t: own }: &StartNumbers<'_>,
    path: u64,
    degrees: usize,
    t: f64,
) -> Result<(), ConfigError> {
    let bad = |cause| Err(ConfigError::PathStart { path, cause });
    if let Some(&got) = [q.len(), p.len()].iter().find(|&&got| got != degrees) {
        return bad(StepFailure::Dimension { expected: degrees, got });
    }
    if !q.iter().chain(p).chain([&own]).all(|x| x.is_finite()) {
        return bad(StepFailure::NonFiniteInput);
    }
    if own != t {
        return wrong(format!(
            "path {path} starts at t = {own}, path 0 at {t}: the paths of an ensemble have their nodes at the same times"
        ));
    }
    Ok(())
}

/// Whether every path's system can be in the place of `system`.
///
/// # Errors
/// [`ConfigError::PathSystem`]: of another size, with another number of noises, or with indices out of range.
pub(super) fn check_systems<H: Discretized<E>, E>(
    systems: &[H],
    system: &H,
    degrees: usize,
) -> Result<(), ConfigError> {
    for (path, own) in systems.iter().enumerate() {
        let noises = [own.increments(degrees), system.increments(degrees)];
        let cause = match own.check(degrees) {
            Err(cause) => ConfigError::Start(cause),
            Ok(()) if noises[0] != noises[1] => {
                ConfigError::Setting(format!("it has {} noises, the others have {}", noises[0], noises[1]))
            }
            Ok(()) => continue,
        };
        return Err(ConfigError::PathSystem { path: path as u64, cause: Box::new(cause) });
    }
    Ok(())
}

/// Random numbers for the start, or for the system, of one path, by the seed of the ensemble and the number
/// of the path.
///
/// They are those of ChaCha8 under a key that no increment is drawn with, so that starts, systems and noise
/// are independent, and they depend on neither the step size nor the scheme: two ensembles of the same seed
/// start at the same states.
#[derive(Clone, Debug)]
pub struct Draw {
    key: [u32; 8],
    path: u64,
    /// Triples of words that were used.
    used: u64,
    block: [u32; 16],
    spare: Option<f64>,
}

/// The version of this layout of the key, which no other layout has (`noise::step_normals`).
const VERSION: u32 = 0x8000_0003;
/// Triples of words in a block.
const TRIPLES: u64 = 5;

impl Draw {
    fn new(drawn: DrawPurpose, seed: u64, path: u64) -> Self {
        let key = [seed as u32, (seed >> 32) as u32, drawn as u32, 0, 0, 0, VERSION, 0];
        Self { key, path, used: 0, block: [0; 16], spare: None }
    }

    /// The number of the path, from 0.
    pub fn path(&self) -> u64 {
        self.path
    }

    /// A number from the standard normal distribution.
    pub fn normal(&mut self) -> f64 {
        match self.spare.take() {
            Some(normal) => normal,
            None => {
                let [normal, spare] = pair(self.words());
                self.spare = Some(spare);
                normal
            }
        }
    }

    /// A number from the uniform distribution on `(0, 1)`: the middle of one of `2^53` equal parts.
    pub fn uniform(&mut self) -> f64 {
        let [high, low, _] = self.words();
        let part = ((u64::from(high) << 32) | u64::from(low)) >> 11;
        // Below 1 for the last part as well, whose middle rounds to even.
        (part as f64 + 0.5).min((1_u64 << 53) as f64 - 1.0) / (1_u64 << 53) as f64
    }

    fn words(&mut self) -> [u32; 3] {
        let (block, place) = (self.used / TRIPLES, 3 * (self.used % TRIPLES) as usize);
        if place == 0 {
            self.block = random::block(&self.key, self.path, block);
        }
        self.used += 1;
        [self.block[place], self.block[place + 1], self.block[place + 2]]
    }
}

#[cfg(test)]
mod tests {
    use super::{Draw, DrawPurpose};
    use crate::noise::step_normals;

    /// 20 000 of each: mean and variance of both distributions within five standard errors; no two paths or
    /// seeds alike.
    #[test]
    fn draws_have_their_distributions() {
        let n = 20_000;
        let sample = |draw: fn(&mut Draw) -> f64, seed, path| {
            let mut generator = Draw::new(DrawPurpose::Start, seed, path);
            (0..n).map(|_| draw(&mut generator)).collect::<Vec<f64>>()
        };
        let count = f64::from(n);
        let moments = |x: &[f64]| {
            let mean = x.iter().sum::<f64>() / count;
            (mean, x.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / count)
        };
        let (normals, uniforms) = (sample(Draw::normal, 7, 3), sample(Draw::uniform, 7, 3));
        let (mean, variance) = moments(&normals);
        assert!(mean.abs() < 5.0 / count.sqrt(), "{mean}");
        assert!((variance - 1.0).abs() < 5.0 * (2.0 / count).sqrt(), "{variance}");
        let (mean, variance) = moments(&uniforms);
        assert!((mean - 0.5).abs() < 5.0 / (12.0 * count).sqrt(), "{mean}");
        // The fourth central moment is 1/80: the variance has the variance (1/80 - 1/144)/n.
        assert!((variance - 1.0 / 12.0).abs() < 5.0 * (1.0 / 180.0 / count).sqrt(), "{variance}");
        assert!(uniforms.iter().all(|x| 0.0 < *x && *x < 1.0));
        for (seed, path) in [(7, 4), (8, 3), (3, 7)] {
            let other = sample(Draw::normal, seed, path);
            let product = normals.iter().zip(&other).map(|(x, y)| x * y).sum::<f64>() / count;
            assert!(product.abs() < 5.0 / count.sqrt(), "{seed} {path}: {product}");
        }
        assert_eq!(normals, sample(Draw::normal, 7, 3));
    }

    /// Keys of increments differ from those of starts, whatever seed, process, step size and level.
    #[test]
    fn starts_have_a_key_of_their_own() {
        assert_ne!(Draw::new(DrawPurpose::System, 1, 0).key[6], step_normals::key(1, 0, 0.1, 0)[6]);
    }
}
