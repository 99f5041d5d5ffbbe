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
            let mut file = open(&path).map_err(failed("write", &path))?;
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
            // nothing that others can see.
            if is_at(&file, &path) {
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
        if self.file.as_ref().is_some_and(|file| is_at(file, &self.path)) {
            let _ = fs::remove_file(&self.path);
        }
        drop(self.file.take());
    }
}

/// Opens the lock file, new or left behind.
fn open(path: &Path) -> io::Result<File> {
    OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path)
}

fn read_holder(file: &mut File) -> Option<u32> {
    let mut text = String::new();
    file.take(32).read_to_string(&mut text).ok()?;
    text.trim().parse().ok()
}

/// Says whether a path leads to what was opened.
#[cfg(unix)]
pub(super) fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    match (file.metadata(), fs::metadata(path)) {
        (Ok(a), Ok(b)) => (a.dev(), a.ino()) == (b.dev(), b.ino()),
        _ => false,
    }
}

/// Elsewhere an open file cannot be removed, so what was opened is what is there.
#[cfg(not(unix))]
pub(super) fn is_at(_file: &File, path: &Path) -> bool {
    path.exists()
}
