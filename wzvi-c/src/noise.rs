//! The noise that settings name. It is one type, so that each scheme is compiled once.

use wzvi::error::NoiseError;
use wzvi::increments::{Identity, Increments, Interval, NoNoise, Noise};
use wzvi::noise::{Paths, StepNormals, Wiener, WongZakai};
use wzvi::plan::Plan;

use crate::error::TaskError;
use crate::settings::Settings;

/// A noise that was chosen by its name.
#[derive(Clone, Debug)]
pub enum NamedNoise {
    /// `steps`
    Steps(StepNormals),
    /// `wiener`
    Wiener(Wiener),
    /// `wong-zakai`
    WongZakai(Box<WongZakai>),
    /// Increments that are given.
    Given(Increments),
    /// None, of a system that needs none.
    None(NoNoise),
}

macro_rules! each {
    ($self:ident, $noise:ident => $value:expr) => {
        match $self {
            Self::None($noise) => $value,
            Self::Steps($noise) => $value,
            Self::Wiener($noise) => $value,
            Self::WongZakai($noise) => $value,
            Self::Given($noise) => $value,
        }
    };
}

impl Noise for NamedNoise {
    fn prepare(&mut self, plan: &Plan, h: f64, processes: usize, start: f64) -> Result<(), NoiseError> {
        each!(self, noise => noise.prepare(plan, h, processes, start))
    }

    fn increments(&mut self, interval: &Interval, dw: &mut [f64]) -> Result<(), NoiseError> {
        each!(self, noise => noise.increments(interval, dw))
    }

    fn increments_of_part(&mut self, interval: &Interval, h: f64, dw: &mut [f64]) -> Result<(), NoiseError> {
        each!(self, noise => noise.increments_of_part(interval, h, dw))
    }

    fn increments_within(
        &mut self,
        interval: &Interval,
        h: f64,
        part: [f64; 2],
        dw: &mut [f64],
    ) -> Result<(), NoiseError> {
        each!(self, noise => noise.increments_within(interval, h, part, dw))
    }

    fn increments_of_own_size(
        &mut self,
        interval: &Interval,
        h: f64,
        part: [f64; 2],
        dw: &mut [f64],
    ) -> Result<(), NoiseError> {
        each!(self, noise => noise.increments_of_own_size(interval, h, part, dw))
    }

    fn is_divisible(&self) -> bool {
        each!(self, noise => noise.is_divisible())
    }

    fn largest_increment(&self, h: f64) -> f64 {
        each!(self, noise => noise.largest_increment(h))
    }

    fn skip_paths(&mut self, paths: u64) -> bool {
        each!(self, noise => noise.skip_paths(paths))
    }

    fn identity(&self) -> Option<Identity> {
        each!(self, noise => noise.identity())
    }
}

impl Paths for NamedNoise {
    fn set_path(&mut self, path: u64) {
        each!(self, noise => noise.set_path(path));
    }

    fn step_normals(&self) -> Option<StepNormals> {
        each!(self, noise => noise.step_normals())
    }

    fn seed_number(&self) -> Option<u64> {
        each!(self, noise => noise.seed_number())
    }
}

/// A truncation of `k`; none for 0, and the default of the run if it was not set.
macro_rules! truncated {
    ($noise:expr, $k:expr) => {
        match $k {
            None => $noise,
            Some(0.0) => $noise.untruncated(),
            Some(k) => $noise.truncated(k),
        }
    };
}

impl NamedNoise {
    /// The noise of a task whose steps need so many increments: `increments`, or the noise `noise` with its
    /// `seed`.
    ///
    /// # Errors
    /// For an unknown name, and for a setting that is missing or belongs to another noise.
    pub fn of(settings: &Settings, processes: usize) -> Result<Self, TaskError> {
        match Self::given(settings)? {
            Some(noise) => Ok(noise),
            None if processes == 0 => Ok(Self::None(NoNoise)),
            None => Err(TaskError::setting(
                "the system has noise: set a `seed`, and `noise` for another one than `steps`, or `increments`",
            )),
        }
    }

    fn given(settings: &Settings) -> Result<Option<Self>, TaskError> {
        let name = settings.text("noise")?;
        if let Some(increments) = settings.reals("increments")? {
            let others = ["noise", "seed", "path", "width", "truncation", "antithetic"];
            if let Some(other) = others.into_iter().find(|other| settings.has(other)) {
                return Err(TaskError::setting(format!(
                    "`increments` are the noise of the run: leave `{other}` out"
                )));
            }
            return Ok(Some(Self::Given(match increments.shape[..] {
                [_, _, ..] => Increments::from(increments.rows()),
                _ => Increments::from(increments.values),
            })));
        }
        let Some(seed) = settings.natural("seed")? else {
            let others = ["noise", "path", "width", "truncation", "antithetic"];
            return match others.into_iter().find(|other| settings.has(other)) {
                Some(other) => Err(TaskError::setting(format!("`{other}` needs a `seed`"))),
                None => Ok(None),
            };
        };
        let (path, width) = (settings.natural("path")?.unwrap_or(0), settings.real("width")?);
        let truncation = settings.real("truncation")?;
        let is_antithetic = settings.flag("antithetic")?;
        if is_antithetic && name.is_some_and(|name| name != "steps") {
            return Err(TaskError::setting("`antithetic` pairs are those of the noise `steps`"));
        }
        if width.is_some() && name != Some("wong-zakai") {
            return Err(TaskError::setting("`width` belongs to the noise `wong-zakai`"));
        }
        Ok(Some(match name.unwrap_or("steps") {
            "steps" => {
                let noise = StepNormals::seed(seed).path(path);
                let noise = if is_antithetic { noise.antithetic() } else { noise };
                Self::Steps(truncated!(noise, truncation))
            }
            "wiener" => {
                let noise = Wiener::seed(seed).path(path);
                Self::Wiener(truncated!(noise, truncation))
            }
            "wong-zakai" => {
                let width =
                    width.ok_or_else(|| TaskError::setting("the noise `wong-zakai` needs its `width`"))?;
                let noise = WongZakai::averaged(width).seed(seed).path(path);
                Self::WongZakai(Box::new(truncated!(noise, truncation)))
            }
            other => {
                return Err(TaskError::setting(format!(
                    "there is no noise `{other}`: there are `steps`, `wiener` and `wong-zakai`, and given `increments`"
                )));
            }
        }))
    }
}
