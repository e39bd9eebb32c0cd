//! Files that appear complete or not at all.

use std::fs;
use std::io::Write;
use std::path::Path;

use super::ReportError;

/// Creates a folder and what leads to it.
///
/// # Errors
/// [`ReportError::File`].
pub fn create_folder(path: &Path) -> Result<(), ReportError> {
    fs::create_dir_all(path).map_err(|error| ReportError::file(path, "create the folder", error))
}

/// Writes a file under a temporary name in the same folder and renames it: a reader, or a run that was killed, sees the
/// old file or the new one.
///
/// # Errors
/// [`ReportError::File`] with the path asked for; nothing is left behind then.
pub fn write_file(path: &Path, content: &[u8]) -> Result<(), ReportError> {
    let failed = |error: std::io::Error| ReportError::file(path, "write", error);
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".wzvi-").suffix(".part");
    // As for any other file, the umask has the last word.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.tempfile_in(folder).map_err(failed)?;
    file.write_all(content).map_err(failed)?;
    // A full disk shows here at the latest.
    file.as_file().sync_all().map_err(failed)?;
    file.persist(path).map_err(|error| failed(error.error))?;
    Ok(())
}
