//! Parts that the pages share: verdicts, tables of numbers, medians.

use std::fmt::Display;
use std::fs;
use std::path::Path;

/// Says whether a target is met, or by how much it is missed.
pub(crate) fn verdict(found: f64, target: f64) -> String {
    if found <= target {
        "met".into()
    } else if found.is_finite() {
        format!("missed by {:.1} %", 100.0 * (found / target - 1.0))
    } else {
        "missed: no value".into()
    }
}

/// Formats a row of a table.
pub(crate) fn row(cells: &[&dyn Display]) -> String {
    let cells: Vec<String> = cells.iter().map(|c| c.to_string()).collect();
    format!("| {} |", cells.join(" | "))
}

/// Formats the head of a table.
pub(crate) fn head(names: &[&str]) -> String {
    format!("| {} |\n|{}", names.join(" | "), "---|".repeat(names.len()))
}

/// Computes the median of some numbers; NaN without numbers.
pub(crate) fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Writes a file of a study.
pub(crate) fn write(folder: &Path, name: &str, text: &str) -> Result<(), Box<dyn std::error::Error>> {
    let path = folder.join(name);
    fs::create_dir_all(folder)
        .and_then(|()| fs::write(&path, text))
        .map_err(|e| format!("{}: {e}", path.display()).into())
}
