//! What the pages share: verdicts, tables of numbers, medians.

use std::collections::HashMap;
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

/// Counts of violations by family: of an earlier run, to be shown beside those of today.
#[derive(Default)]
pub(crate) struct Counts(HashMap<String, Vec<usize>>);

impl Counts {
    /// Reads `family,count,count,…` from a file of the folder; empty if there is no such file.
    pub(crate) fn read(folder: &Path, name: &str) -> Self {
        let text = fs::read_to_string(folder.join(name)).unwrap_or_default();
        let line = |line: &str| {
            let mut cells = line.split(',');
            Some((cells.next()?.to_owned(), cells.map(str::parse).collect::<Result<_, _>>().ok()?))
        };
        Self(text.lines().filter_map(line).collect())
    }

    /// Adds a family, and formats its counts: with an arrow behind those of an earlier run.
    pub(crate) fn add(&mut self, family: &str, counts: &[usize], earlier: &Self) -> Vec<String> {
        let family = family.replace(',', ";");
        let old = earlier.0.get(&family);
        let shown = counts.iter().enumerate().map(|(k, now)| match old.and_then(|o| o.get(k)) {
            Some(before) => format!("{before} → {now}"),
            None => now.to_string(),
        });
        let shown = shown.collect();
        self.0.insert(family, counts.to_vec());
        shown
    }

    /// Formats the counts as they are read.
    pub(crate) fn csv(&self) -> String {
        let mut lines: Vec<String> = (self.0.iter())
            .map(|(family, counts)| {
                let counts: Vec<String> = counts.iter().map(usize::to_string).collect();
                format!("{family},{}\n", counts.join(","))
            })
            .collect();
        lines.sort();
        lines.concat()
    }
}
