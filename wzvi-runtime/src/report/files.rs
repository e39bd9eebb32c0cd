//! Files of a report: complete or not at all.
//!
//! Tested by `tests/paths/report/files.rs`.

use std::io::Write;
use std::path::Path;

use super::ReportError;
use crate::saving::file;

/// Writes a file under a temporary name in the same folder and renames it: a reader, or a run that was
/// killed, sees the old file or the new one. Symbolic links are followed; anything but a regular file is
/// refused.
///
/// # Errors
/// [`ReportError::File`] with the path asked for; nothing is left behind then.
pub fn write_file(path: &Path, content: &[u8]) -> Result<(), ReportError> {
    Ok(file::replace(path, |file| file.write_all(content))?)
}
