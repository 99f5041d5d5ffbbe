//! Checkpoints of adaptive runs: what an interrupted run needs to be resumed.
//!
//! A file holds one line, `nndd checkpoint 4` and the SHA-256 of the rest, and then JSON. Two are kept, the newest and
//! the one before it, each written under a temporary name and renamed: whenever a process is killed, one is whole. A
//! file that was damaged afterwards is recognised by its hash, and the older one is used.

use crate::output::{OutputDirectory, OutputError, ResultKind};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};
use thiserror::Error;

pub use crate::output::{CHECKPOINT as NEWEST, CHECKPOINT_BEFORE as PREVIOUS};

/// How files of this version begin.
const HEAD: &str = "nndd checkpoint 4 ";

/// A run, and how far it has come.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Checkpoint {
    /// The identity of the case: [`crate::Case::identity`]. Only a run of the same case may resume from here.
    pub case: Value,
    /// How far it has come; `None` before its first mesh is solved.
    pub progress: Option<Progress>,
}

/// The course of an adaptive run up to a mesh that is to be solved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// In each pair the side that carries λ, 0 or 1.
    pub imposed: Vec<usize>,
    /// The compliances by which the roles were chosen, m³/N; `None` if the case says who carries λ.
    pub compliance: Option<[f64; 2]>,
    /// The second mesh and every one after it; the last one is to be solved.
    pub meshes: Vec<FinerMesh>,
    /// One entry per mesh solved.
    pub steps: Vec<Step>,
}

/// How a mesh came from the one before it, and where its iteration starts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FinerMesh {
    /// Round by round the cells of each body that were refined.
    pub rounds: Vec<Vec<Vec<u32>>>,
    /// λ at each pair, m; with friction each pair's tangential part follows.
    pub lambda: Vec<f64>,
    /// True for each pair that was in contact; `None` if that is not known.
    pub active: Option<Vec<bool>>,
}

/// A mesh that was solved.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// Nodes of all bodies.
    pub nodes: usize,
    /// Pairs on the interface.
    pub pairs: usize,
    /// In load steps the step, from 1, of the bound.
    #[serde(default)]
    pub load_step: Option<usize>,
    /// The guaranteed bound.
    pub e_cre: Option<f64>,
    /// The bound over the energy norm.
    pub relative: Option<f64>,
    /// True if the checks of the bound hold.
    pub certified: bool,
    /// With Coulomb friction the residual.
    #[serde(default)]
    pub e_b: Option<f64>,
    /// The residual over the energy norm.
    #[serde(default)]
    pub relative_residual: Option<f64>,
    /// Iterations on this mesh.
    pub iterations: usize,
    /// `a(u, u)` of all bodies, J/m.
    pub energy_norm_squared: Option<f64>,
    /// Largest von Mises stress of the recovered stress, Pa.
    pub peak_stress: Option<f64>,
    /// When it had been solved, in seconds of work since the start.
    pub seconds: f64,
}

/// Why a run cannot be resumed.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum CheckpointError {
    /// No run was started there, or none that got as far as a checkpoint.
    #[error(
        "nothing to resume: no adaptive run was ever started in {}, or it failed on its first mesh", directory.display()
    )]
    NeverStarted {
        /// The directory of the run.
        directory: PathBuf,
    },
    /// The run has finished.
    #[error(
        "nothing to resume: the run in {} has finished ({word}) and its result is there", directory.display()
    )]
    Finished {
        /// The directory of the run.
        directory: PathBuf,
        /// The status word of the result.
        word: String,
    },
    /// All checkpoints are damaged.
    #[error("no checkpoint in {} can be used: {reason}", directory.display())]
    Damaged {
        /// The directory of the run.
        directory: PathBuf,
        /// The fault of each checkpoint.
        reason: String,
    },
}

/// Writes the newest checkpoint of a run; what was the newest becomes the one before.
///
/// The checkpoint of a run that has solved no mesh stays among the collected files until the end: if such a run is killed,
/// nothing is lost and the next one may begin.
///
/// # Errors
/// Errors of the operating system.
pub fn write(directory: &mut OutputDirectory, checkpoint: &Checkpoint) -> Result<(), OutputError> {
    let mut body = serde_json::to_vec(checkpoint).map_err(|e| OutputError::Io {
        what: "write",
        path: directory.path().join(NEWEST),
        source: e.into(),
    })?;
    body.push(b'\n');
    let head = format!("{HEAD}{}\n", digest(&body));
    if checkpoint.progress.is_none() {
        return directory.write(NEWEST, &[head.as_bytes(), &body].concat());
    }
    directory.write_after_renaming(NEWEST, PREVIOUS, &[head.as_bytes(), &body])
}

/// Removes both checkpoints of a run that needs them no more.
///
/// # Errors
/// Errors of the operating system.
pub fn remove(directory: &mut OutputDirectory) -> Result<(), OutputError> {
    [NEWEST, PREVIOUS].into_iter().try_for_each(|name| directory.remove(name))
}

/// Reads the newest intact checkpoint, and a note if that is not the newest one.
///
/// # Errors
/// There is no checkpoint, or all are damaged.
pub fn read(directory: &Path) -> Result<(Checkpoint, Option<String>), CheckpointError> {
    let mut damaged = Vec::new();
    for name in [NEWEST, PREVIOUS] {
        match read_file(&directory.join(name)) {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {}
            Err(error) => damaged.push(format!("{name} cannot be read ({error})")),
            Ok(bytes) => match decode(&bytes) {
                Ok(checkpoint) => {
                    let note = damaged.first().map(|fault| format!("{fault}; the run resumes from {name}"));
                    return Ok((checkpoint, note));
                }
                Err(fault) => damaged.push(format!("{name} {fault}")),
            },
        }
    }
    let directory = directory.to_owned();
    if damaged.is_empty() {
        return Err(match recorded_word(&directory) {
            Some(word) => CheckpointError::Finished { directory, word },
            None => CheckpointError::NeverStarted { directory },
        });
    }
    Err(CheckpointError::Damaged { directory, reason: damaged.join(", ") })
}

/// Reads a file, and nothing that would not come to an end, such as a pipe or a device.
fn read_file(path: &Path) -> std::io::Result<Vec<u8>> {
    if !std::fs::metadata(path)?.is_file() {
        return Err(std::io::Error::other("it is no file"));
    }
    std::fs::read(path)
}

/// Reads the status word of the result in a directory.
fn recorded_word(directory: &Path) -> Option<String> {
    let bytes = read_file(&directory.join(ResultKind::Solve.record())).ok()?;
    let report: Value = serde_json::from_slice(&bytes).ok()?;
    Some(report.get("status")?.get("word")?.as_str()?.to_owned())
}

fn digest(body: &[u8]) -> String {
    Sha256::digest(body).iter().map(|byte| format!("{byte:02x}")).collect()
}

fn decode(bytes: &[u8]) -> Result<Checkpoint, &'static str> {
    let rest = bytes.strip_prefix(HEAD.as_bytes()).ok_or("is not a checkpoint of this version")?;
    let end = rest.iter().position(|&b| b == b'\n').ok_or("is damaged")?;
    let (hash, body) = (&rest[..end], &rest[end + 1..]);
    if hash != digest(body).as_bytes() {
        return Err("is damaged");
    }
    serde_json::from_slice(body).map_err(|_| "is not a checkpoint of this version")
}

/// Lists where two cases differ: the dotted path of each setting, what the checkpoint has, what the case has now.
pub fn differences(checkpoint: &Value, now: &Value) -> Vec<String> {
    let mut found = Vec::new();
    compare(checkpoint, now, &mut String::new(), &mut found);
    found
}

fn compare(old: &Value, new: &Value, path: &mut String, found: &mut Vec<String>) {
    let mut inside = |key: &str, old: Option<&Value>, new: Option<&Value>| {
        let length = path.len();
        path.push_str(if path.is_empty() { "" } else { "." });
        path.push_str(key);
        compare(old.unwrap_or(&Value::Null), new.unwrap_or(&Value::Null), path, found);
        path.truncate(length);
    };
    match (old, new) {
        (Value::Object(a), Value::Object(b)) => {
            for key in a.keys().chain(b.keys().filter(|key| !a.contains_key(*key))) {
                inside(key, a.get(key), b.get(key));
            }
        }
        (Value::Array(a), Value::Array(b)) if a.iter().chain(b).any(|v| v.is_object() || v.is_array()) => {
            for k in 0..a.len().max(b.len()) {
                inside(&k.to_string(), a.get(k), b.get(k));
            }
        }
        _ if old != new => found.push(format!("{path} was {} and is {}", shown(old), shown(new))),
        _ => {}
    }
}

fn shown(value: &Value) -> String {
    if value.is_null() { "not given".to_owned() } else { value.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn checkpoint(lambda: f64) -> Checkpoint {
        let mesh = FinerMesh { rounds: vec![vec![vec![1, 2], vec![]]], lambda: vec![lambda], active: None };
        let step = Step {
            nodes: 8,
            pairs: 2,
            load_step: None,
            e_cre: Some(0.1 + 0.2),
            relative: None,
            certified: true,
            e_b: None,
            relative_residual: None,
            iterations: 3,
            energy_norm_squared: Some(f64::MIN_POSITIVE),
            peak_stress: Some(0.3),
            seconds: 0.0,
        };
        let progress = Progress { imposed: vec![1], compliance: None, meshes: vec![mesh], steps: vec![step] };
        Checkpoint { case: json!({"a": 1}), progress: Some(progress) }
    }

    #[test]
    fn the_newest_whole_checkpoint_is_read_to_the_last_bit() {
        let temp = tempfile::tempdir().unwrap();
        let path = temp.path();
        assert!(matches!(read(path), Err(CheckpointError::NeverStarted { .. })));
        let mut directory = OutputDirectory::open(path, ResultKind::Solve, "hash", false).unwrap();
        for lambda in [1.0 / 3.0, -1e-300, 0.7] {
            write(&mut directory, &checkpoint(lambda)).unwrap();
            assert_eq!(read(path), Ok((checkpoint(lambda), None)));
        }
        // One byte wrong, cut anywhere, gone: the one before is there.
        let whole = std::fs::read(path.join(NEWEST)).unwrap();
        for damage in [0, 30, 100, whole.len() - 1] {
            let mut bytes = whole.clone();
            bytes[damage] ^= 1;
            for bytes in [&bytes[..], &whole[..damage]] {
                std::fs::write(path.join(NEWEST), bytes).unwrap();
                let (found, note) = read(path).unwrap();
                assert_eq!(found, checkpoint(-1e-300));
                assert!(note.unwrap().contains("resumes from checkpoint-previous.nndd"));
            }
        }
        std::fs::remove_file(path.join(NEWEST)).unwrap();
        assert_eq!(read(path), Ok((checkpoint(-1e-300), None)));
        std::fs::write(path.join(PREVIOUS), "nothing").unwrap();
        assert!(matches!(read(path), Err(CheckpointError::Damaged { .. })));
        remove(&mut directory).unwrap();
        assert!(matches!(read(path), Err(CheckpointError::NeverStarted { .. })));
    }

    #[test]
    fn differences_name_the_setting() {
        let old =
            json!({"solver": {"theta": 0.4, "qp": "auto"}, "body": [{"cells": [4, 2]}, {"cells": [1, 1]}]});
        let mut new = old.clone();
        assert!(differences(&old, &new).is_empty());
        new["solver"]["theta"] = json!(0.5);
        new["body"][1]["cells"] = json!([1, 2]);
        new["adapt"] = json!({"fraction": 0.5});
        assert_eq!(
            differences(&old, &new),
            [
                "solver.theta was 0.4 and is 0.5",
                "body.1.cells was [1,1] and is [1,2]",
                "adapt was not given and is {\"fraction\":0.5}"
            ]
        );
    }
}
