//! What goes to the disk: files that appear complete or not at all, tables as text, and checkpoints.

#[cfg(feature = "serde")]
pub mod checkpoint;
#[cfg(not(feature = "serde"))]
#[path = "persist/checkpoint/absent.rs"]
pub(crate) mod checkpoint;
#[cfg(any(feature = "ensemble", feature = "serde"))]
pub(crate) mod file;
#[cfg(feature = "ensemble")]
pub(crate) mod table;

#[cfg(any(feature = "ensemble", feature = "serde"))]
pub use file::FileError;
