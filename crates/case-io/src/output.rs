//! Safe files: every file is written under a temporary name in its own directory and renamed, and a directory of
//! results is owned by one run and one case.
//!
//! A run collects its files in a hidden directory beside the earlier result. They take the place of that result when all of
//! them are written, so a full disk or a killed run loses nothing that was there before.

mod directory;
mod inspect;
mod lock;

use mesh_io::BrokenLink;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use thiserror::Error;

pub use directory::{OutputDirectory, Presence};

/// Temporary files begin with this; one that a killed run left behind does not count as content.
const TEMPORARY: &str = ".nndd-tmp-";

/// The hidden directory in which a run collects its files.
const STAGING: &str = ".nndd-tmp-run";

/// The kind of result that a directory holds.
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

/// The newest checkpoint of an unfinished run.
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
    /// A symbolic link in the path is broken.
    #[error("{} {link}", link.link.display())]
    BrokenLink {
        /// The link and its target.
        link: BrokenLink,
    },
    /// Something in the directory is a link, and files would be written elsewhere.
    #[error("{} is a link, which is not followed", path.display())]
    Link {
        /// The link.
        path: PathBuf,
    },
    /// Another run writes there at this moment.
    #[error("{} is in use by another run{}", path.display(), holder.map(|p| format!(" (process {p})")).unwrap_or_default())]
    Locked {
        /// The directory.
        path: PathBuf,
        /// The process that holds it, if it is known.
        holder: Option<u32>,
    },
    /// The directory holds a run that was ended before it had a result.
    #[error("{} holds an unfinished run", path.display())]
    Unfinished {
        /// The directory.
        path: PathBuf,
    },
    /// The directory holds something that is not a complete result.
    #[error("{} is not empty and was not written by nndd (found \"{found}\")", path.display())]
    NotOurs {
        /// The directory.
        path: PathBuf,
        /// One of the entries.
        found: String,
    },
    /// The directory holds the result of another case.
    #[error("{} holds the result of another case", path.display())]
    OtherCase {
        /// The directory.
        path: PathBuf,
    },
    /// The directory was removed while a run used it.
    #[error("{} was removed or replaced while the run was using it", path.display())]
    Vanished {
        /// The directory.
        path: PathBuf,
    },
    /// A file name that would lead out of the directory.
    #[error("\"{name}\" is not a file name below the output directory")]
    Name {
        /// The name.
        name: String,
    },
    /// An error of the operating system.
    #[error("cannot {what} {}: {source}", path.display())]
    Io {
        /// The action that failed, such as `write`.
        what: &'static str,
        /// With which file.
        path: PathBuf,
        /// The error.
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
/// Errors of the operating system and of the closure; the temporary file is then removed.
pub(crate) fn write_file(
    path: &Path,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), OutputError> {
    let directory = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(TEMPORARY);
    // Results are for sharing: they get the usual permissions (less the umask). A temporary file would be private.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.tempfile_in(directory).map_err(failed("write", path))?;
    let mut buffered = BufWriter::new(&mut file);
    content(&mut buffered).and_then(|()| buffered.flush()).map_err(failed("write", path))?;
    drop(buffered);
    file.persist(path).map_err(|e| failed("write", path)(e.error))?;
    Ok(())
}

#[cfg(test)]
mod tests;
