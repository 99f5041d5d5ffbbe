//! Looks at the content of a directory before a run begins, and tells which files belong to a result.

use super::lock::LOCK_FILE;
use super::{CHECKPOINT, CHECKPOINT_BEFORE, OutputError, ResultKind, STAGING, TEMPORARY, failed};
use crate::report::CASE_HASH;
use std::ffi::OsStr;
use std::fs;
use std::path::Path;

/// The content of a directory before the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Before {
    /// Nothing that counts.
    Nothing,
    /// A result of the same case.
    SameCase,
    /// A result of another case, to be replaced by force.
    OtherCase,
    /// Something else, which stays.
    Foreign,
}

/// Directories below the output directory that hold files of a result.
pub(super) const BELOW: [&str; 2] = ["figures", "fields"];

/// Says whether a file of an earlier result has this name.
pub(super) fn is_result(below: &Path, name: &OsStr) -> bool {
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
        }
        _ => ending(".vtu"),
    }
}

/// Looks at what a directory holds; the inner error is what `force` overrules.
pub(super) fn inspect(
    path: &Path,
    kind: ResultKind,
    case_hash: &str,
) -> Result<Result<Before, OutputError>, OutputError> {
    let mut names = Vec::new();
    for entry in fs::read_dir(path).map_err(failed("read", path))? {
        let name = entry.map_err(failed("read", path))?.file_name();
        if name != LOCK_FILE && !name.to_string_lossy().starts_with(TEMPORARY) {
            names.push(name);
        }
    }
    // In alphabetical order, so that the message does not depend on the file system.
    names.sort();
    let Some(found) = names.first() else { return Ok(Ok(Before::Nothing)) };
    let mut recorded =
        ResultKind::ALL.into_iter().filter_map(|k| Some((k, recorded_hash(&path.join(k.record()))?)));
    let unfinished = [CHECKPOINT, CHECKPOINT_BEFORE].iter().any(|name| path.join(name).is_file());
    let foreign = names.iter().find(|name| {
        !is_result(Path::new(""), name) && !BELOW.iter().any(|below| *below == name.as_os_str())
    });
    Ok(match recorded.next() {
        // A run that was interrupted has a report as well; a finished one no longer has a checkpoint.
        Some((ResultKind::Solve, hash)) if unfinished && hash == case_hash => {
            Err(OutputError::Unfinished { path: path.to_owned() })
        }
        Some((found, hash)) if found == kind && hash == case_hash && recorded.next().is_none() => {
            Ok(Before::SameCase)
        }
        Some(_) => Err(OutputError::OtherCase { path: path.to_owned() }),
        None if unfinished => Err(OutputError::Unfinished { path: path.to_owned() }),
        // A run that was killed while its files took their places: they are parts of that result.
        None if foreign.is_none() && path.join(STAGING).is_dir() => Ok(Before::SameCase),
        None => {
            let found = foreign.unwrap_or(found).to_string_lossy().into_owned();
            Err(OutputError::NotOurs { path: path.to_owned(), found })
        }
    })
}

/// Reads the hash of the case that a record is of; `None` if it is not a record.
fn recorded_hash(record: &Path) -> Option<String> {
    // A device or a pipe would not come to an end.
    let bytes = record.is_file().then(|| fs::read(record).ok()).flatten()?;
    let record: serde_json::Value = serde_json::from_slice(&bytes).ok()?;
    Some(record.get("run")?.get(CASE_HASH)?.as_str()?.to_owned())
}
