//! What a run of paths was asked for: what its results are of.

/// The settings without which a result means nothing.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Origin {
    pub(crate) system: String,
    pub(crate) scheme: String,
    pub(crate) h: f64,
    /// Time of the first state.
    pub(crate) start: f64,
    pub(crate) steps: u64,
    /// 0 for a noise without one.
    pub(crate) seed: u64,
    /// What the increments are of, in words; `none` where the steps take none.
    pub(crate) noise: String,
    /// Paths that were asked for, at most.
    pub(crate) paths: u64,
    /// Parameters by name that are those of all paths.
    pub(crate) parameters: Vec<(String, f64)>,
    /// Those that are not, path by path, where paths are kept.
    pub(crate) varying: Vec<(String, Vec<f64>)>,
}
