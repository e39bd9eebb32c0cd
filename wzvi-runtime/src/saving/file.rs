//! Files that appear complete or not at all: whatever happens, the name refers to the old contents or to the
//! new ones.
//!
//! Content is written under a temporary name in the same folder, flushed to the disk, and then renamed; the
//! folder is flushed after that.
//!
//! * The temporary name is this writer's own: `.wzvi-<checksum of the name>-<random>.part`, created anew,
//!   never opened if it exists, and locked while its writer lives. A lock that is free marks a file left
//!   behind by a process that was killed ([`remove_parts`]).
//! * A symbolic link stays, and the file that it leads to is replaced. Permissions stay, too. Another hard
//!   link to the old content keeps it.
//! * A device, a pipe, a folder or a read-only file is refused, untouched.
//!
//! Tested by `wzvi-runtime/src/saving/file/tests.rs`.

use std::fs::{self, File, Metadata, TryLockError};
use std::hash::{BuildHasher, RandomState};
use std::io::Read;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use crate::saving::FileError;

use crate::ground::checksum::Checksum;

/// Links to links that are followed, as on Linux.
const MOST_LINKS: usize = 40;
/// Names that are tried: each is free but for a chance of 2^-64.
const MOST_NAMES: usize = 16;

/// Has the names in the folder of `path` written to the disk.
pub(crate) fn flush_folder(path: &Path) -> io::Result<()> {
    // Elsewhere a folder cannot be opened, and renaming is written through.
    if cfg!(unix) { File::open(folder(path))?.sync_all() } else { Ok(()) }
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Creates a folder and its parents.
pub(crate) fn create_folder(path: &Path) -> Result<(), FileError> {
    fs::create_dir_all(path).map_err(FileError::system(path, "create the folder"))
}

/// The file behind a name and all symbolic links. If it exists, it is a regular file.
#[derive(Debug)]
pub(crate) struct Target {
    path: PathBuf,
    /// The metadata of the file that is there.
    metadata: Option<Metadata>,
}

impl Target {
    /// Follows `path` in order to do `action`.
    pub(crate) fn of(path: &Path, action: &'static str) -> Result<Self, FileError> {
        let mut target = path.to_owned();
        for _ in 0..=MOST_LINKS {
            let metadata = match fs::symlink_metadata(&target) {
                Err(error) if error.kind() == io::ErrorKind::NotFound => {
                    return Ok(Self { path: target, metadata: None });
                }
                metadata => metadata.map_err(FileError::system(path, action))?,
            };
            let kind = metadata.file_type();
            if kind.is_symlink() {
                let next = fs::read_link(&target).map_err(FileError::system(path, action))?;
                // The target of a link is relative to the folder of the link.
                target = folder(&target).join(next);
            } else if kind.is_file() {
                return Ok(Self { path: target, metadata: Some(metadata) });
            } else {
                return Err(FileError::Special {
                    path: path.to_owned(),
                    action,
                    found: super::error::name(kind),
                });
            }
        }
        let cause = io::Error::other("too many symbolic links");
        Err(FileError::system(path, action)(cause))
    }

    pub(crate) fn into_path(self) -> PathBuf {
        self.path
    }
}

/// New content of a file, complete and on the disk, which does not have its name yet; without
/// [`Staged::publish`] it goes.
#[derive(Debug)]
pub(crate) struct Staged {
    /// The name that the user gave.
    asked: PathBuf,
    target: PathBuf,
    /// The temporary name; `None` when it is no longer there.
    part: Option<PathBuf>,
    /// Holds the lock.
    file: File,
}

impl Staged {
    /// Writes the future content of `path`.
    pub(crate) fn write(
        path: &Path,
        write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
    ) -> Result<Self, FileError> {
        let Target { path: target, metadata } = Target::of(path, WRITE)?;
        let failed = || FileError::system(path, WRITE);
        if metadata.as_ref().is_some_and(|there| there.permissions().readonly()) {
            return Err(failed()(io::Error::new(io::ErrorKind::PermissionDenied, "it is read-only")));
        }
        let (part, file) = create_part(&target).map_err(failed())?;
        let mut staged = Self { asked: path.to_owned(), target, part: Some(part), file };
        staged.fill(metadata, write).map_err(failed())?;
        Ok(staged)
    }

    fn fill(
        &mut self,
        replaced: Option<Metadata>,
        write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
    ) -> io::Result<()> {
        if let Some(replaced) = replaced {
            self.file.set_permissions(replaced.permissions())?;
        }
        let mut buffer = BufWriter::new(self.file.try_clone()?);
        write(&mut buffer)?;
        // A full disk shows here at the latest.
        buffer.into_inner().map_err(io::IntoInnerError::into_error)?.sync_all()
    }

    /// Gives the content its name.
    pub(crate) fn publish(mut self) -> Result<(), FileError> {
        let Some(part) = &self.part else { return Ok(()) };
        let renamed = fs::rename(part, &self.target);
        if renamed.is_ok() {
            self.part = None;
        }
        renamed.and_then(|()| flush_folder(&self.target)).map_err(FileError::system(&self.asked, WRITE))
    }
}

impl Drop for Staged {
    fn drop(&mut self) {
        if let Some(part) = &self.part {
            // The earlier failure is the one to report.
            let _ = fs::remove_file(part);
        }
    }
}

/// Replaces several files. The first one says that the others belong together: it is gone while they are
/// replaced, and comes last.
pub(crate) fn publish_set(staged: Vec<Staged>) -> Result<(), FileError> {
    let mut staged = staged.into_iter();
    let Some(seal) = staged.next() else { return Ok(()) };
    match fs::remove_file(&seal.target) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => {
            return Err(FileError::system(&seal.asked, WRITE)(error));
        }
        _ => staged.try_for_each(Staged::publish)?,
    }
    seal.publish()
}

const WRITE: &str = "write";

/// Replaces the content of `path` by the output of `write`. Nothing is left behind if this fails.
pub(crate) fn replace(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<(), FileError> {
    Staged::write(path, write)?.publish()
}

/// [`replace`] in a folder that is made if it is not there.
pub(crate) fn replace_in_folder(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<(), FileError> {
    create_folder(folder(path))?;
    replace(path, write)
}

/// Opens a file for reading; `None` if there is none.
pub(crate) fn open(path: &Path) -> Result<Option<File>, FileError> {
    let target = Target::of(path, READ)?;
    match File::open(&target.path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        file => file.map(Some).map_err(FileError::system(path, READ)),
    }
}

const READ: &str = "read";

/// The ending of temporary files.
const PART: &str = ".part";

/// The start of the temporary names of a file. It does not grow with the name of the file, which may have all
/// the length that the file system allows.
fn prefix(target: &Path) -> String {
    let mut checksum = Checksum::default();
    checksum.add(target.file_name().unwrap_or_default().as_encoded_bytes());
    format!(".wzvi-{checksum:?}-")
}

/// A new file under a temporary name, locked where the system has locks.
fn create_part(target: &Path) -> io::Result<(PathBuf, File)> {
    let mut last = io::ErrorKind::AlreadyExists.into();
    for _ in 0..MOST_NAMES {
        // Keys from the system's source of randomness: process numbers repeat in containers, clocks in
        // clones.
        let random = RandomState::new().hash_one(target);
        let part = folder(target).join(format!("{}{random:016x}{PART}", prefix(target)));
        match File::create_new(&part) {
            Ok(file) => {
                let is_taken = matches!(file.try_lock(), Err(TryLockError::WouldBlock));
                // Another process may have removed the file before it was locked; from now on none can.
                if !is_taken && part.exists() {
                    return Ok((part, file));
                }
            }
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => last = error,
            Err(error) => return Err(error),
        }
    }
    Err(last)
}

/// Removes temporary files of `path` whose writers have ended before they gave them their name: nobody has
/// them locked, and they start like `magic` as far as they go. One that cannot be removed does no harm.
pub(crate) fn remove_parts(path: &Path, magic: &[u8]) {
    let Ok(entries) = fs::read_dir(folder(path)) else { return };
    let prefix = prefix(path);
    for entry in entries.flatten() {
        let name = entry.file_name();
        let is_part = name.to_str().is_some_and(|name| name.starts_with(&prefix) && name.ends_with(PART));
        if is_part && entry.file_type().is_ok_and(|kind| kind.is_file()) {
            let _ = remove_left_behind(&entry.path(), magic);
        }
    }
}

fn remove_left_behind(part: &Path, magic: &[u8]) -> io::Result<()> {
    let file = File::open(part)?;
    if file.try_lock().is_err() {
        return Ok(());
    }
    let mut start = Vec::new();
    (&file).take(magic.len() as u64).read_to_end(&mut start)?;
    if magic.starts_with(&start) { fs::remove_file(part) } else { Ok(()) }
}

#[cfg(all(test, unix))]
mod tests;
