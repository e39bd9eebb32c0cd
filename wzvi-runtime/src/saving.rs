//! Files on the disk, which appear complete or not at all; tables as text and columns.

#[cfg(feature = "columnar")]
mod columnar;
mod error;
pub(crate) mod file;
pub mod table;

pub use error::FileError;
