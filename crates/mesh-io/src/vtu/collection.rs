//! Collections of files over time: `.pvd` with all parts, and `.vtu.series` of one part.

use super::VtuError;
use crate::words::attribute;
use serde_json::{Value, json};
use std::fmt::Write as _;

/// One file of a collection.
#[derive(Clone, Debug, PartialEq)]
pub struct PvdEntry {
    /// Time, number of the iteration, or adaptive step.
    pub timestep: f64,
    /// Number of the part within the time step.
    pub part: usize,
    /// Name of the part.
    pub name: String,
    /// The file, relative to the collection.
    pub file: String,
}

/// Makes a collection (`.pvd`) of files over time steps.
///
/// # Errors
/// A time step that is not finite.
pub fn pvd(entries: &[PvdEntry]) -> Result<String, VtuError> {
    let mut xml = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\">\n  <Collection>\n",
    );
    for (entry, e) in entries.iter().enumerate() {
        if !e.timestep.is_finite() {
            return Err(VtuError::NotFinite { name: "timestep".to_owned(), entry, value: e.timestep });
        }
        let _ = writeln!(
            xml,
            "    <DataSet timestep=\"{}\" group=\"\" part=\"{}\" name=\"{}\" file=\"{}\"/>",
            e.timestep,
            e.part,
            attribute(&e.name),
            attribute(&e.file)
        );
    }
    xml.push_str("  </Collection>\n</VTKFile>\n");
    Ok(xml)
}

/// Makes a series (`.vtu.series`) of the files of one part, as ParaView reads it: JSON with each file and its time.
///
/// * `files`: names relative to the series, and times.
///
/// # Errors
/// A time that is not finite.
pub fn series(files: &[(String, f64)]) -> Result<String, VtuError> {
    if let Some((entry, (_, value))) = files.iter().enumerate().find(|(_, (_, time))| !time.is_finite()) {
        return Err(VtuError::NotFinite { name: "time".to_owned(), entry, value: *value });
    }
    let files: Vec<Value> = files.iter().map(|(name, time)| json!({ "name": name, "time": time })).collect();
    Ok(format!("{:#}\n", json!({ "file-series-version": "1.0", "files": files })))
}
