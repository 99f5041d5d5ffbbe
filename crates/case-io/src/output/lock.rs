//! The lock file of a directory of results.
//!
//! The file is locked through the operating system, which releases it however the process ends; its
//! presence alone means only that an earlier run was killed.

use super::{OutputError, failed};
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

/// Name of the lock file.
pub(super) const LOCK_FILE: &str = ".nndd.lock";

/// Held while a run writes to a directory; the file is removed when it is dropped.
#[derive(Debug)]
pub(super) struct Lock {
    path: PathBuf,
    file: Option<File>,
}

impl Lock {
    pub(super) fn take(directory: &Path) -> Result<Self, OutputError> {
        let path = directory.join(LOCK_FILE);
        loop {
            let mut file = match open(&path) {
                Ok(Some(file)) => file,
                Ok(None) => continue,
                Err(error) => return Err(failed("write", &path)(error)),
            };
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    let holder = read_holder(&mut file);
                    return Err(OutputError::Locked { path: directory.to_owned(), holder });
                }
                // A file system without locks: better unguarded than unusable.
                Err(TryLockError::Error(error)) if error.kind() == io::ErrorKind::Unsupported => {}
                Err(TryLockError::Error(error)) => return Err(failed("lock", &path)(error)),
            }
            // Between opening and locking the former holder may have removed the file: then this lock guards
            // nothing that others can see. Nor is a file written to that anything else put there.
            if is_own(&file, &path) {
                // On a full disk the holder stays unnamed.
                let _ = file.set_len(0).and_then(|()| writeln!(file, "{}", std::process::id()));
                return Ok(Self { path, file: Some(file) });
            }
        }
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // Removed while it is still locked, so that nobody locks a file that is about to go. Nothing can be done
        // about a failure here, and a file left behind does no harm. A file of that name may be another run's, if the
        // directory was removed and made again.
        if self.file.as_ref().is_some_and(|file| is_own(file, &self.path)) {
            let _ = fs::remove_file(&self.path);
        }
        drop(self.file.take());
    }
}

/// Opens the lock file, new or left behind. Links are not followed; `None` if another run removed the file meanwhile.
fn open(path: &Path) -> io::Result<Option<File>> {
    let mut options = OpenOptions::new();
    options.read(true).write(true);
    match options.clone().create_new(true).open(path) {
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
        other => return other.map(Some),
    }
    let found = match fs::symlink_metadata(path) {
        Ok(found) => found,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(error),
    };
    if !found.is_file() || has_other_names(&found) {
        return Err(io::Error::other(
            "it is a link or no file, and only a lock of this program may be there",
        ));
    }
    match options.open(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        other => other.map(Some),
    }
}

/// Says whether a file has further names (hard links), under which its content would change too.
#[cfg(unix)]
fn has_other_names(found: &fs::Metadata) -> bool {
    std::os::unix::fs::MetadataExt::nlink(found) > 1
}

#[cfg(not(unix))]
fn has_other_names(_found: &fs::Metadata) -> bool {
    false
}

fn read_holder(file: &mut File) -> Option<u32> {
    let mut text = String::new();
    file.take(32).read_to_string(&mut text).ok()?;
    text.trim().parse().ok()
}

/// Says whether a path leads to what was opened.
pub(super) fn is_at(file: &File, path: &Path) -> bool {
    is_same(file, path, fs::metadata(path))
}

/// Says whether a path is what was opened, and no link to it.
fn is_own(file: &File, path: &Path) -> bool {
    is_same(file, path, fs::symlink_metadata(path))
}

#[cfg(unix)]
fn is_same(file: &File, _path: &Path, found: io::Result<fs::Metadata>) -> bool {
    use std::os::unix::fs::MetadataExt;
    match (file.metadata(), found) {
        (Ok(a), Ok(b)) => (a.dev(), a.ino()) == (b.dev(), b.ino()),
        _ => false,
    }
}

/// Elsewhere an open file cannot be removed, so what was opened is what is there.
#[cfg(not(unix))]
fn is_same(_file: &File, path: &Path, _found: io::Result<fs::Metadata>) -> bool {
    path.exists()
}
