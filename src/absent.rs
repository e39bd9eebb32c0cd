//! Substitutes in the prelude for types of features that are off, so that the compiler names the feature.

/// Never implemented: a type of the feature `report` is used without it.
#[diagnostic::on_unimplemented(
    message = "`WorkPrecision` needs the feature `report` of wzvi, which is off",
    label = "switch it on with `cargo add wzvi --features report`"
)]
pub trait ReportFeature {
    /// The type of the value that the feature would make.
    type Value;
    /// The value.
    fn value(self) -> Self::Value;
}

/// Error against run time: needs the feature `report`.
///
/// ```compile_fail,E0277
/// let study = wzvi::prelude::WorkPrecision::new(&1.0);
/// ```
#[derive(Debug)]
pub enum WorkPrecision {}

impl WorkPrecision {
    /// Says which feature is off.
    #[expect(clippy::new_ret_no_self, reason = "stands in for the constructor of the same name")]
    pub fn new<T: ReportFeature>(system: T) -> T::Value {
        system.value()
    }
}
