//! What goes to the disk: files that appear complete or not at all, and tables as text and columns.

#[cfg(feature = "columnar")]
mod columnar;
mod error;
pub(crate) mod file;
pub mod table;

pub use error::FileError;
