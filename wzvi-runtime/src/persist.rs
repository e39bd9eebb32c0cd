//! What goes to the disk: files that appear complete or not at all, and tables as text.

pub(crate) mod file;
#[cfg(any(feature = "ensemble", feature = "report"))]
pub(crate) mod table;

pub use file::FileError;
