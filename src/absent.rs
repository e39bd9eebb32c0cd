//! What stands in the prelude for types of features that are off, so that the compiler names the feature.

/// Never implemented: a type of the feature `report` is used without it.
#[cfg(not(feature = "report"))]
#[diagnostic::on_unimplemented(
    message = "`WorkPrecision` needs the feature `report` of wzvi, which is off",
    label = "switch it on with `cargo add wzvi --features report`"
)]
pub trait ReportFeature {
    /// What would be made.
    type Value;
    /// It.
    fn value(self) -> Self::Value;
}

/// Error against run time: needs the feature `report`.
///
/// ```compile_fail,E0277
/// let study = wzvi::prelude::WorkPrecision::new(&1.0);
/// ```
#[cfg(not(feature = "report"))]
#[derive(Debug)]
pub enum WorkPrecision {}

#[cfg(not(feature = "report"))]
impl WorkPrecision {
    /// Says which feature is off.
    #[expect(clippy::new_ret_no_self, reason = "stands in for the constructor of the same name")]
    pub fn new<T: ReportFeature>(system: T) -> T::Value {
        system.value()
    }
}

/// Never implemented: a type of the feature `serde` is used without it.
#[cfg(not(feature = "serde"))]
#[diagnostic::on_unimplemented(
    message = "`Checkpoint` needs the feature `serde` of wzvi, which is off",
    label = "switch it on with `cargo add wzvi --features serde`"
)]
pub trait SerdeFeature {
    /// What would be made.
    type Value;
    /// It.
    fn value(self) -> Self::Value;
}

/// A file that lets a run go on: needs the feature `serde`.
///
/// ```compile_fail,E0277
/// let file = wzvi::prelude::Checkpoint::to("run.checkpoint");
/// ```
#[cfg(not(feature = "serde"))]
#[derive(Debug)]
pub enum Checkpoint {}

#[cfg(not(feature = "serde"))]
impl Checkpoint {
    /// Says which feature is off.
    pub fn to<T: SerdeFeature>(path: T) -> T::Value {
        path.value()
    }
}
