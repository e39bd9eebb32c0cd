//! The systems of a library, and their schemes, by name.

use std::panic::{AssertUnwindSafe, catch_unwind};

use wzvi::exported::{Exported, FieldDescription};
use wzvi::handle::Handle;
use wzvi::plan::Plan;
use wzvi::system::Discretized;

use crate::error::TaskError;
use crate::results::Results;
use crate::settings::Settings;

/// The end of a run: its results and, if it ended early, the error that ended it.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The results up to the end.
    pub results: Results,
    /// Why the run ended early.
    pub error: Option<TaskError>,
}

/// A run of a system by a scheme.
pub type Run = fn(&Settings, &Handle) -> Result<Outcome, TaskError>;

/// A kind of run that a library has.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// Its name.
    pub name: &'static str,
    /// Its settings beside the common ones.
    pub settings: &'static [&'static str],
    /// The run.
    pub run: Run,
}

/// A scheme of a system.
#[derive(Clone, Debug)]
pub struct Scheme {
    /// Its name, as it was written.
    pub name: &'static str,
    /// Its facts.
    pub plan: Plan,
    /// Whether its steps follow a clock.
    pub is_clocked: bool,
    /// Its equations.
    pub equations: &'static str,
    /// Its kinds of runs.
    pub kinds: Vec<Kind>,
}

/// A system with its schemes.
#[derive(Clone, Debug)]
pub struct System {
    /// The name of its type.
    pub name: &'static str,
    /// Its documentation.
    pub doc: &'static str,
    /// Its fields.
    pub fields: &'static [FieldDescription],
    /// The closures of its attribute, each with its key.
    pub closures: &'static [(&'static str, &'static str)],
    /// Its schemes.
    pub schemes: Vec<Scheme>,
}

/// A list of schemes `(E, (F, ()))` of the system `H`.
pub trait Schemes<H> {
    /// Adds them, with these names.
    fn collect(names: &[&'static str], into: &mut Vec<Scheme>);
}

impl<H> Schemes<H> for () {
    fn collect(_names: &[&'static str], _into: &mut Vec<Scheme>) {}
}

impl<H, E, R> Schemes<H> for (E, R)
where
    H: Exported + Discretized<E> + Send + Sync,
    R: Schemes<H>,
{
    fn collect(names: &[&'static str], into: &mut Vec<Scheme>) {
        let (name, rest) = names.split_first().map_or(("", names), |(name, rest)| (*name, rest));
        into.push(Scheme {
            name,
            plan: H::PLAN,
            is_clocked: H::PROPERTIES.is_clocked,
            equations: H::EQUATIONS,
            kinds: vec![
                Kind { name: "path", settings: crate::path::SETTINGS, run: crate::path::path::<H, E> },
                #[cfg(feature = "ensemble")]
                Kind {
                    name: "ensemble",
                    settings: crate::ensemble::SETTINGS,
                    run: crate::ensemble::ensemble::<H, E>,
                },
                #[cfg(feature = "chaos")]
                Kind {
                    name: "indicators",
                    settings: crate::chaos::INDICATORS,
                    run: crate::chaos::indicators::<H, E>,
                },
                #[cfg(feature = "chaos")]
                Kind {
                    name: "lyapunov",
                    settings: crate::chaos::LYAPUNOV,
                    run: crate::chaos::lyapunov::<H, E>,
                },
                #[cfg(all(feature = "chaos", feature = "ensemble"))]
                Kind { name: "map", settings: crate::chaos::MAP, run: crate::chaos::map::<H, E> },
                #[cfg(feature = "chaos")]
                Kind { name: "tangent", settings: crate::chaos::TANGENT, run: crate::chaos::tangent::<H, E> },
            ],
        });
        R::collect(rest, into);
    }
}

impl System {
    /// The description and the runs of a system.
    pub fn of<H>() -> Self
    where
        H: Exported,
        H::Schemes: Schemes<H>,
    {
        let mut schemes = Vec::new();
        H::Schemes::collect(H::SCHEMES, &mut schemes);
        Self { name: H::NAME, doc: H::DOC, fields: H::FIELDS, closures: H::CLOSURES, schemes }
    }

    /// The scheme with this name; without a name the only one.
    fn scheme(&self, name: Option<&str>) -> Result<&Scheme, TaskError> {
        let found = match (name, &self.schemes[..]) {
            (None, [only]) => Some(only),
            _ => self.schemes.iter().find(|scheme| Some(scheme.name) == name),
        };
        found.ok_or_else(|| {
            let names: Vec<_> = self.schemes.iter().map(|scheme| scheme.name).collect();
            let wrong = match name {
                Some(name) => format!("`{}` was not compiled for the scheme `{name}`", self.name),
                None => format!("`{}` has several schemes: set `scheme`", self.name),
            };
            TaskError::setting(format!("{wrong}: there are `{}`", names.join("`, `")))
        })
    }

    /// Runs a task of this kind. A panic, which is a mistake of the library or of the user's own functions, is
    /// an error.
    ///
    /// # Errors
    /// For a kind, a scheme or a setting that does not exist or is invalid.
    pub fn run(&self, kind: &str, settings: &Settings, handle: &Handle) -> Result<Outcome, TaskError> {
        let scheme = self.scheme(settings.text("scheme")?)?;
        let Some(found) = scheme.kinds.iter().find(|known| known.name == kind) else {
            let names: Vec<_> = scheme.kinds.iter().map(|kind| kind.name).collect();
            return Err(TaskError::setting(format!(
                "this library was not compiled for runs of the kind `{kind}`: there are `{}`",
                names.join("`, `")
            )));
        };
        settings.check(kind, found.settings, self.fields)?;
        catch_unwind(AssertUnwindSafe(|| (found.run)(settings, handle))).unwrap_or_else(|panic| {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            let text = text.or(panic.downcast_ref::<&str>().copied()).unwrap_or("without a message");
            Err(TaskError::panicked(text))
        })
    }
}
