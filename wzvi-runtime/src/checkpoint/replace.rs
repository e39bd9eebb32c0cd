//! Files that are replaced as a whole: whatever happens, what is there is the old content or the new one.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

/// `path` with more at the end of its name.
pub(super) fn with_ending(path: &Path, ending: &str) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(ending);
    name.into()
}

/// The ending of temporary files.
const PART: &str = ".part";

/// Where this process writes what is to become `path`: no other process that is alive on the machine uses that name.
fn part(path: &Path) -> PathBuf {
    with_ending(path, &format!(".{}{PART}", std::process::id()))
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Has the names in the folder of `path` written to the disk.
pub(super) fn flush_folder(path: &Path) -> io::Result<()> {
    // Elsewhere a folder cannot be opened, and renaming is written through.
    if cfg!(unix) { File::open(folder(path))?.sync_all() } else { Ok(()) }
}

/// Writes `content` under a temporary name, has it written to the disk, gives it the name `path`, and has that written
/// to the disk as well. Nothing is left behind if this fails.
pub(super) fn replace(path: &Path, content: &[u8]) -> io::Result<()> {
    let part = part(path);
    let written = File::create_new(&part).and_then(|mut file| {
        file.write_all(content)?;
        // A full disk shows here at the latest.
        file.sync_all()
    });
    let renamed = written.and_then(|()| fs::rename(&part, path));
    match renamed {
        Ok(()) => flush_folder(path),
        // Not ours to remove.
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => Err(error),
        Err(error) => {
            // It may not even be there; the first failure is the one to tell.
            let _ = fs::remove_file(&part);
            Err(error)
        }
    }
}

/// Removes temporary files that a process left behind which was stopped in [`replace`]: named like them, and starting
/// like `magic` as far as they go. One that cannot be removed does no harm.
pub(super) fn remove_parts(path: &Path, magic: &[u8]) {
    let Some(prefix) = path.file_name().and_then(|name| name.to_str()) else { return };
    let Ok(entries) = fs::read_dir(folder(path)) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let process = name
            .to_str()
            .and_then(|name| name.strip_prefix(prefix)?.strip_prefix('.')?.strip_suffix(PART))
            .filter(|process| !process.is_empty() && process.bytes().all(|byte| byte.is_ascii_digit()));
        if process.is_some() && starts_like(&entry.path(), magic) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

fn starts_like(path: &Path, magic: &[u8]) -> bool {
    let mut start = Vec::new();
    let read = File::open(path).and_then(|file| file.take(magic.len() as u64).read_to_end(&mut start));
    read.is_ok() && magic.starts_with(&start)
}
