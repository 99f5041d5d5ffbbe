//! Two runs side by side: their results with the differences, and the intervals that meet or do not.

mod problem;
mod rows;
mod shown;

use case_io::output::ResultKind;
use case_io::report::{CellCount, Report, ReportError, SCHEMA};
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

pub use problem::Problems;
pub use shown::{summary, table};

/// Why two runs cannot be compared.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CompareError {
    /// The report of a run cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The file is not JSON, or not the report of a run.
    #[error("cannot read {}: {source}", path.display())]
    NotAReport {
        /// The file.
        path: PathBuf,
        /// The fault of its text.
        source: ReportError,
    },
    /// The report has the format of another version of this program.
    #[error("cannot read {}: its schema is {found}", path.display())]
    OtherSchema {
        /// The file.
        path: PathBuf,
        /// The version of its format.
        found: u32,
    },
    /// The runs have other bodies.
    #[error("the bodies differ: A has {}, B has {}", bodies[0], bodies[1])]
    OtherBodies {
        /// The bodies of each run, in words.
        bodies: [String; 2],
    },
}

/// The values of both runs; `None` is not known, or not there.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Words.
    Words([String; 2]),
    /// Numbers.
    Numbers([Option<f64>; 2]),
    /// Bounds of an error, which are rounded up.
    Bounds([Option<f64>; 2]),
    /// Lower and upper bounds of a quantity of the exact solution.
    Intervals([Option<[f64; 2]>; 2]),
}

/// A result of both runs.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Row {
    /// The body or pair that has it, such as `body "upper"`; empty for the whole run.
    pub of: String,
    /// The name of the result.
    pub name: &'static str,
    /// Its values.
    pub values: Values,
}

impl Row {
    /// Returns the value of the second run less the first one's, if both are known and the difference is finite.
    pub fn difference(&self) -> Option<f64> {
        let (Values::Numbers([a, b]) | Values::Bounds([a, b])) = self.values else { return None };
        Some(b? - a?).filter(|difference| difference.is_finite())
    }

    /// Returns the difference in per cent of the first run's value.
    pub fn percent(&self) -> Option<f64> {
        let (Values::Numbers([a, _]) | Values::Bounds([a, _])) = self.values else { return None };
        let (a, difference) = (a?, self.difference()?);
        let percent = if difference == 0.0 { 0.0 } else { 100.0 * (difference / a.abs()) };
        Some(percent).filter(|percent| percent.is_finite())
    }

    /// Says if the intervals of both runs have a common point; `None` if one of them is not there.
    pub fn meet(&self) -> Option<bool> {
        let Values::Intervals([Some(a), Some(b)]) = self.values else { return None };
        Some(a[0] <= b[1] && b[0] <= a[1])
    }
}

/// Two runs side by side.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Comparison {
    /// The folders.
    pub folders: [PathBuf; 2],
    /// The results.
    pub rows: Vec<Row>,
    /// The settings that differ, with both values.
    pub settings: Vec<String>,
    /// The relation of the two problems.
    pub problems: Problems,
}

/// Compares the reports of two folders.
///
/// # Errors
/// A report that cannot be read, and runs with other bodies.
pub fn compare(folders: [&Path; 2]) -> Result<Comparison, CompareError> {
    let (a, b) = (read(folders[0])?, read(folders[1])?);
    let both = [&a, &b];
    let bodies = both.map(bodies);
    if bodies[0] != bodies[1] {
        return Err(CompareError::OtherBodies { bodies });
    }
    Ok(Comparison {
        folders: folders.map(Path::to_owned),
        rows: rows::rows(both),
        settings: problem::settings(both),
        problems: problem::relation(both),
    })
}

/// Reads the report of a folder.
fn read(folder: &Path) -> Result<Report, CompareError> {
    let path = folder.join(ResultKind::Solve.record());
    let text = match std::fs::read_to_string(&path) {
        Ok(text) => text,
        Err(source) => return Err(CompareError::Unreadable { path, source }),
    };
    match Report::from_json(&text) {
        Ok(report) if report.schema == SCHEMA => Ok(report),
        Ok(report) => Err(CompareError::OtherSchema { path, found: report.schema }),
        Err(source) => Err(CompareError::NotAReport { path, source }),
    }
}

/// Names the bodies of a run, in their order.
fn bodies(report: &Report) -> String {
    let solid = report.bodies.iter().any(|body| matches!(body.cells, CellCount::Tetrahedra(_)));
    let names: Vec<String> = report.bodies.iter().map(|body| format!("\"{}\"", body.name)).collect();
    format!("{} of {}", names.join(", "), if solid { "solids" } else { "the plane" })
}
