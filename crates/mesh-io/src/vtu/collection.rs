//! Collections of files over time: `.pvd` with all parts, and `.vtu.series` of one part.

use super::VtuError;
use crate::words::escaped;
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
            escaped(&e.name),
            escaped(&e.file)
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
    let mut text = String::from("{\n  \"file-series-version\": \"1.0\",\n  \"files\": [");
    for (k, (name, time)) in files.iter().enumerate() {
        let comma = if k > 0 { "," } else { "" };
        let _ = write!(
            text,
            "{comma}\n    {{\n      \"name\": {},\n      \"time\": {time:?}\n    }}",
            quoted(name)
        );
    }
    text.push_str(if files.is_empty() { "]\n}\n" } else { "\n  ]\n}\n" });
    Ok(text)
}

/// Writes a text as a JSON string.
fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            c if c < ' ' => {
                let _ = write!(out, "\\u{:04x}", u32::from(c));
            }
            c => out.push(c),
        }
    }
    out.push('"');
    out
}
