//! The settings of a run of paths, which identify its results.

/// The settings without which a result means nothing.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Provenance {
    pub(crate) system: String,
    pub(crate) scheme: String,
    pub(crate) h: f64,
    /// Why the system has no equilibrium, if it has none.
    pub(crate) no_equilibrium: Option<&'static str>,
    /// Time of the first state.
    pub(crate) start: f64,
    pub(crate) steps: u64,
    /// 0 for a noise without one.
    pub(crate) seed: u64,
    /// The source of the increments, in words; `none` for steps without increments.
    pub(crate) noise: String,
    /// The requested number of paths, an upper limit.
    pub(crate) paths: u64,
    /// Parameters by name that are the same for all paths.
    pub(crate) parameters: Vec<(String, f64)>,
    /// Parameters that differ, path by path, where paths are kept.
    pub(crate) varying: Vec<(String, Vec<f64>)>,
}
