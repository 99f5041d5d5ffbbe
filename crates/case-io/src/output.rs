//! Safe files: every file is written under a temporary name in its own directory and renamed, and a directory of
//! results is owned by one run and one case.

mod lock;

use crate::links::BrokenLink;
use crate::report::CASE_HASH;
use lock::{LOCK_FILE, Lock};
use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Component, Path, PathBuf};
use thiserror::Error;

/// Temporary files begin with this; one that a killed run left behind does not count as content.
const TEMPORARY: &str = ".nndd-tmp-";

/// What a directory of results is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResultKind {
    /// One run.
    Solve,
    /// Runs for several values of one setting.
    Sweep,
}

impl ResultKind {
    const ALL: [Self; 2] = [Self::Solve, Self::Sweep];

    /// Returns the file that makes a directory a complete result of this kind: it is written last.
    pub fn record(self) -> &'static str {
        match self {
            Self::Solve => "report.json",
            Self::Sweep => "sweep.json",
        }
    }
}

/// The newest checkpoint of a run that has not come to its end.
pub const CHECKPOINT: &str = "checkpoint.nndd";
/// The one before it.
pub const CHECKPOINT_BEFORE: &str = "checkpoint-previous.nndd";

/// Why a file or directory cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The path is a file.
    #[error("{} is not a directory", path.display())]
    NotADirectory {
        /// The path.
        path: PathBuf,
    },
    /// A symbolic link in the path leads nowhere.
    #[error("{} {link}; create what it points to, or choose another directory with --out", link.link.display())]
    BrokenLink {
        /// The link and its target.
        link: BrokenLink,
    },
    /// Another run writes there at this moment.
    #[error("{} is in use by another run{}; wait for it, or choose another directory with --out", path.display(), holder.map(|p| format!(" (process {p})")).unwrap_or_default())]
    Locked {
        /// The directory.
        path: PathBuf,
        /// The process that holds it, where it is known.
        holder: Option<u32>,
    },
    /// The directory holds a run that was ended before it had a result.
    #[error("{} holds a run that did not come to its end; go on with it by --resume, or begin anew with --force", path.display())]
    Unfinished {
        /// The directory.
        path: PathBuf,
    },
    /// The directory holds something that is no complete result.
    #[error("{} is not empty and was not written by nndd (found \"{found}\"); use --out DIR, or --force to write anyway", path.display())]
    NotOurs {
        /// The directory.
        path: PathBuf,
        /// One of the entries.
        found: String,
    },
    /// The directory holds the result of another case.
    #[error("{} holds the result of another case; choose another directory with --out, or replace it with --force", path.display())]
    OtherCase {
        /// The directory.
        path: PathBuf,
    },
    /// A file name that would lead out of the directory.
    #[error("\"{name}\" is not a file name below the output directory")]
    Name {
        /// The name.
        name: String,
    },
    /// The operating system's complaint.
    #[error("cannot {what} {}: {source}", path.display())]
    Io {
        /// What was tried.
        what: &'static str,
        /// With which file.
        path: PathBuf,
        /// What came of it.
        source: io::Error,
    },
}

fn failed<'a>(what: &'static str, path: &'a Path) -> impl FnOnce(io::Error) -> OutputError + 'a {
    move |source| OutputError::Io { what, path: path.to_owned(), source }
}

/// Writes a file under a temporary name in the same directory and renames it: whatever happens, the final name holds
/// either the old content or the whole new one.
///
/// # Errors
/// What the operating system or the closure reports; the temporary file is removed.
pub fn write_file(
    path: &Path,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), OutputError> {
    let directory = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(TEMPORARY);
    // Results are for sharing: the usual permissions (less the umask), not those of a private temporary file.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.tempfile_in(directory).map_err(failed("write", path))?;
    let mut buffered = BufWriter::new(&mut file);
    content(&mut buffered).and_then(|()| buffered.flush()).map_err(failed("write", path))?;
    drop(buffered);
    file.persist(path).map_err(|e| failed("write", path)(e.error))?;
    Ok(())
}

/// What a directory held before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Before {
    /// Nothing that counts.
    Nothing,
    /// A result of the same case.
    SameCase,
    /// A result of another case, to be replaced by force.
    OtherCase,
    /// Something else, which stays.
    Foreign,
}

/// A directory of results that this run alone writes to.
///
/// Files are written as they come; [`OutputDirectory::finish`] removes what an earlier result had and this one has
/// not. The lock goes when the value is dropped.
#[derive(Debug)]
pub struct OutputDirectory {
    path: PathBuf,
    before: Before,
    written: BTreeSet<PathBuf>,
    /// Kept alive: dropping it releases the lock.
    _lock: Lock,
}

impl OutputDirectory {
    /// Opens a directory for the results of one case, and locks it.
    ///
    /// A missing or empty directory is fine. A result of the same case will be replaced, unless a checkpoint lies beside it,
    /// with which its run could go on. Anything else is refused, unless `force` is given.
    ///
    /// * `case_hash`: [`crate::Case::hash`] or what else names the case, compared with the one on record.
    ///
    /// # Errors
    /// See [`OutputError`]; nothing has been changed then, except that a missing directory may have been created.
    pub fn open(path: &Path, kind: ResultKind, case_hash: &str, force: bool) -> Result<Self, OutputError> {
        if let Some(link) = BrokenLink::find(path) {
            return Err(OutputError::BrokenLink { link });
        }
        if path.exists() && !path.is_dir() {
            return Err(OutputError::NotADirectory { path: path.to_owned() });
        }
        fs::create_dir_all(path).map_err(failed("create", path))?;
        let lock = Lock::take(path)?;
        let before = inspect(path, kind, case_hash)?;
        let before = match before {
            Ok(before) => before,
            Err(_) if force && ResultKind::ALL.iter().any(|k| path.join(k.record()).is_file()) => {
                Before::OtherCase
            }
            Err(_) if force => Before::Foreign,
            Err(refusal) => return Err(refusal),
        };
        Ok(Self { path: path.to_owned(), before, written: BTreeSet::new(), _lock: lock })
    }

    /// Opens a directory in which a run of the same case is to go on, and locks it.
    ///
    /// # Errors
    /// No directory, or another run in it.
    pub fn reopen(path: &Path) -> Result<Self, OutputError> {
        if let Some(link) = BrokenLink::find(path) {
            return Err(OutputError::BrokenLink { link });
        }
        if !path.is_dir() {
            return Err(OutputError::NotADirectory { path: path.to_owned() });
        }
        let lock = Lock::take(path)?;
        Ok(Self { path: path.to_owned(), before: Before::SameCase, written: BTreeSet::new(), _lock: lock })
    }

    /// Returns the directory.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Says whether an earlier result is being replaced.
    pub fn replaces_a_result(&self) -> bool {
        matches!(self.before, Before::SameCase | Before::OtherCase)
    }

    /// Returns what was written so far, relative to the directory, in alphabetical order.
    pub fn written(&self) -> impl Iterator<Item = &Path> {
        self.written.iter().map(PathBuf::as_path)
    }

    /// Writes one file; directories in its name are created.
    ///
    /// * `name`: relative to the directory, such as `figures/history.svg`.
    ///
    /// # Errors
    /// A name that leads elsewhere, and what the operating system reports.
    pub fn write(&mut self, name: &str, content: &[u8]) -> Result<(), OutputError> {
        self.write_with(name, |out| out.write_all(content))
    }

    /// Renames a file to an older name, if it is there, and writes it anew.
    ///
    /// * `pieces`: the content, one after the other.
    ///
    /// # Errors
    /// See [`OutputDirectory::write`].
    pub fn write_after_renaming(
        &mut self,
        name: &str,
        older: &str,
        pieces: &[&[u8]],
    ) -> Result<(), OutputError> {
        let (from, to) = (self.path.join(name), self.path.join(older));
        match fs::rename(&from, &to) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                return Err(failed("rename", &from)(error));
            }
            Err(_) => {}
            Ok(()) => {
                self.written.insert(PathBuf::from(older));
            }
        }
        self.write_with(name, |out| pieces.iter().try_for_each(|piece| out.write_all(piece)))
    }

    /// Counts a file that an earlier part of this run wrote as one of this run.
    pub fn keep(&mut self, name: &str) {
        if self.path.join(name).is_file() {
            self.written.insert(PathBuf::from(name));
        }
    }

    /// Removes a file that this run may have written, if it is there.
    ///
    /// # Errors
    /// What the operating system reports.
    pub fn remove(&mut self, name: &str) -> Result<(), OutputError> {
        self.written.remove(Path::new(name));
        remove(&self.path.join(name))
    }

    /// Writes one file piece by piece, see [`OutputDirectory::write`].
    ///
    /// # Errors
    /// See [`OutputDirectory::write`]; and what the closure reports.
    pub fn write_with(
        &mut self,
        name: &str,
        content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), OutputError> {
        let relative = Path::new(name);
        let plain = relative.components().all(|c| matches!(c, Component::Normal(_)));
        if name.is_empty() || !plain || relative.file_name() == Some(OsStr::new(LOCK_FILE)) {
            return Err(OutputError::Name { name: name.to_owned() });
        }
        if self.before == Before::OtherCase && self.written.is_empty() {
            // Half of one case beside the record of another would be taken for a complete result.
            for kind in ResultKind::ALL {
                remove(&self.path.join(kind.record()))?;
            }
        }
        let path = self.path.join(relative);
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent).map_err(failed("create", parent))?;
        }
        write_file(&path, content)?;
        self.written.insert(relative.to_owned());
        Ok(())
    }

    /// Ends a run: removes the files of the result that this one replaced, as far as this run has not written them.
    /// Files that are not this program's stay.
    ///
    /// # Errors
    /// What the operating system reports.
    pub fn finish(self) -> Result<(), OutputError> {
        if self.replaces_a_result() {
            for directory in ["", "figures", "fields"] {
                self.remove_old(Path::new(directory))?;
            }
        }
        Ok(())
    }

    fn remove_old(&self, below: &Path) -> Result<(), OutputError> {
        let directory = self.path.join(below);
        if !directory.is_dir() {
            return Ok(());
        }
        for entry in fs::read_dir(&directory).map_err(failed("read", &directory))? {
            let entry = entry.map_err(failed("read", &directory))?;
            let relative = below.join(entry.file_name());
            let is_file = entry.file_type().is_ok_and(|t| t.is_file());
            if is_file && is_result(below, &entry.file_name()) && !self.written.contains(&relative) {
                remove(&entry.path())?;
            }
        }
        Ok(())
    }
}

fn remove(path: &Path) -> Result<(), OutputError> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(failed("remove", path)(error)),
        _ => Ok(()),
    }
}

/// Says whether a file of an earlier result has this name.
fn is_result(below: &Path, name: &OsStr) -> bool {
    let name = name.to_string_lossy();
    let ending = |ending: &str| name.ends_with(ending);
    match below.to_str() {
        Some("figures") => ending(".svg"),
        Some("") => {
            ["report.html", "history.csv", "contact.csv", "adaptive.csv"].contains(&name.as_ref())
                || ResultKind::ALL.iter().any(|kind| kind.record() == name)
                || name.starts_with("sweep") && ending(".csv")
                || [".vtu", ".pvd", ".vtu.series"].into_iter().any(ending)
                || [CHECKPOINT, CHECKPOINT_BEFORE].contains(&name.as_ref())
                || name.starts_with(TEMPORARY)
        }
        _ => ending(".vtu"),
    }
}

/// Looks at what a directory holds; the inner error is what `force` overrules.
fn inspect(
    path: &Path,
    kind: ResultKind,
    case_hash: &str,
) -> Result<Result<Before, OutputError>, OutputError> {
    let mut found = None;
    for entry in fs::read_dir(path).map_err(failed("read", path))? {
        let name = entry.map_err(failed("read", path))?.file_name().to_string_lossy().into_owned();
        if name != LOCK_FILE && !name.starts_with(TEMPORARY) {
            // The alphabetically first, so that the message does not depend on the file system.
            found = Some(found.map_or(name.clone(), |f: String| f.min(name)));
        }
    }
    let Some(found) = found else { return Ok(Ok(Before::Nothing)) };
    let mut recorded =
        ResultKind::ALL.into_iter().filter_map(|k| Some((k, recorded_hash(&path.join(k.record()))?)));
    let unfinished = [CHECKPOINT, CHECKPOINT_BEFORE].iter().any(|name| path.join(name).is_file());
    Ok(match recorded.next() {
        // A run that was interrupted has a report as well; one that came to its end has no checkpoint any more.
        Some((ResultKind::Solve, hash)) if unfinished && hash == case_hash => {
            Err(OutputError::Unfinished { path: path.to_owned() })
        }
        Some((found, hash)) if found == kind && hash == case_hash && recorded.next().is_none() => {
            Ok(Before::SameCase)
        }
        Some(_) => Err(OutputError::OtherCase { path: path.to_owned() }),
        None if unfinished => Err(OutputError::Unfinished { path: path.to_owned() }),
        None => Err(OutputError::NotOurs { path: path.to_owned(), found }),
    })
}

/// Reads the hash of the case that a record is of; `None` where it is no record.
fn recorded_hash(record: &Path) -> Option<String> {
    let record: serde_json::Value = serde_json::from_slice(&fs::read(record).ok()?).ok()?;
    Some(record.get("run")?.get(CASE_HASH)?.as_str()?.to_owned())
}

#[cfg(test)]
mod tests;
