//! Runs the criterion suites and reads what they estimated.

use crate::workspace::{Outcome, Workspace, read, stream};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// One benchmark of criterion, times in nanoseconds.
#[derive(Debug, PartialEq)]
pub(super) struct Estimate {
    pub(super) name: String,
    pub(super) median: f64,
    pub(super) lower: f64,
    pub(super) upper: f64,
    pub(super) level: f64,
}

impl Estimate {
    /// Width of the confidence interval over the median.
    pub(super) fn width(&self) -> f64 {
        (self.upper - self.lower) / self.median
    }
}

/// Runs suites and returns their estimates by name.
///
/// * `suites`: their names.
/// * `more`: arguments for criterion.
pub(super) fn measure(workspace: &Workspace, suites: &[&str], more: &[&str]) -> Outcome<Vec<Estimate>> {
    let started = SystemTime::now();
    // All of the workspace at once, with the features the tests use: otherwise each crate compiles its own numeric stack.
    let mut command = workspace.cargo(&["bench", "--workspace"]);
    for suite in suites {
        command.args(["--bench", suite]);
    }
    if !more.is_empty() {
        command.arg("--").args(more);
    }
    if stream(&mut command)? != Some(0) {
        return Err("a benchmark failed".to_owned());
    }
    let mut files = vec![];
    find_estimates(&workspace.target.join("criterion"), started, &mut files);
    let mut estimates = files.iter().map(|f| estimate_at(f)).collect::<Outcome<Vec<_>>>()?;
    estimates.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(estimates)
}

/// Collects the files `new/estimates.json` below a folder that were written since `started`.
fn find_estimates(folder: &Path, started: SystemTime, found: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for path in entries.filter_map(Result::ok).map(|e| e.path()) {
        if path.is_dir() {
            find_estimates(&path, started, found);
        } else if path.ends_with("new/estimates.json") {
            let written = path.metadata().and_then(|m| m.modified());
            if written.is_ok_and(|w| w >= started) {
                found.push(path);
            }
        }
    }
}

/// Reads an estimate and, from the file beside it, its name.
fn estimate_at(path: &Path) -> Outcome<Estimate> {
    let about = read(&path.with_file_name("benchmark.json"))?;
    parse_estimate(&about, &read(path)?).map_err(|e| format!("{}: {e}", path.display()))
}

/// Reads criterion's `benchmark.json` and `estimates.json`.
pub(super) fn parse_estimate(benchmark: &str, estimates: &str) -> Outcome<Estimate> {
    let benchmark: Value = serde_json::from_str(benchmark).map_err(|e| e.to_string())?;
    let estimates: Value = serde_json::from_str(estimates).map_err(|e| e.to_string())?;
    let median = &estimates["median"];
    let interval = &median["confidence_interval"];
    let number =
        |v: &Value, key: &str| v[key].as_f64().ok_or_else(|| format!("found no number {key} of the median"));
    Ok(Estimate {
        name: benchmark["full_id"].as_str().ok_or("found no full_id")?.to_owned(),
        median: number(median, "point_estimate")?,
        lower: number(interval, "lower_bound")?,
        upper: number(interval, "upper_bound")?,
        level: number(interval, "confidence_level")?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn estimate() -> Estimate {
        let benchmark = r#"{"group_id": "condense", "full_id": "condense/body, fine"}"#;
        let estimates = r#"{"mean": {"point_estimate": 9.0},
            "median": {"confidence_interval": {"confidence_level": 0.95, "lower_bound": 1150.5, "upper_bound": 1250.0},
                       "point_estimate": 1200.25, "standard_error": 3.0}}"#;
        parse_estimate(benchmark, estimates).unwrap()
    }

    #[test]
    fn estimates_are_read() {
        let expected = Estimate {
            name: "condense/body, fine".into(),
            median: 1200.25,
            lower: 1150.5,
            upper: 1250.0,
            level: 0.95,
        };
        assert_eq!(estimate(), expected);
    }

    #[test]
    fn estimates_without_a_median_are_refused() {
        assert!(parse_estimate(r#"{"full_id": "a"}"#, r#"{"mean": {}}"#).is_err());
        assert!(parse_estimate("{}", r#"{"median": {}}"#).is_err());
        assert!(parse_estimate("{", "{}").is_err());
    }

    #[test]
    fn estimates_are_found_by_age() {
        let folder = std::env::temp_dir().join(format!("xtask-estimates-{}", std::process::id()));
        let new = folder.join("group").join("name").join("new");
        std::fs::create_dir_all(&new).unwrap();
        std::fs::write(new.join("estimates.json"), "{}").unwrap();
        let count = |since| {
            let mut found = vec![];
            find_estimates(&folder, since, &mut found);
            found.len()
        };
        assert_eq!(count(SystemTime::UNIX_EPOCH), 1);
        assert_eq!(count(SystemTime::now() + std::time::Duration::from_secs(3600)), 0);
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
