//! What goes to the disk: files that appear complete or not at all, tables as text and columns, and checkpoints.

#[cfg(feature = "serde")]
pub mod checkpoint;
#[cfg(not(feature = "serde"))]
#[path = "persist/checkpoint/absent.rs"]
pub(crate) mod checkpoint;
#[cfg(feature = "columnar")]
mod columnar;
pub(crate) mod file;
pub mod table;

pub use file::FileError;
