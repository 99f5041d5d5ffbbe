//! `sweep.json`: the runs of a sweep, and of what.

use super::{IterationRow, ReportError, to_json};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// The version of sweep.json that this crate writes.
pub const SWEEP_SCHEMA: u32 = 1;

/// One run of a sweep.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SweepRow {
    /// The swept value as TOML.
    pub value: String,
    /// The status word of the run.
    pub status: String,
    /// Tells if the certificate of its last iteration is valid.
    #[serde(default)]
    pub valid: bool,
    /// Its last iteration; without `e_cre` and `eta_dis` if they are not bounds.
    pub iteration: IterationRow,
    /// The allowance for round-off in `e_cre`, if that is a bound.
    #[serde(default)]
    pub round_off: Option<f64>,
}

/// The runs with one set of other settings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SweepPanel {
    /// The settings against the case, `KEY=VALUE`.
    pub settings: Vec<String>,
    /// Its name among the panels: its size and, if that is not enough, its settings.
    #[serde(default)]
    pub name: String,
    /// Nodes of both bodies.
    pub nodes: usize,
    /// One run per value.
    pub rows: Vec<SweepRow>,
}

/// A sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweepReport {
    /// [`SWEEP_SCHEMA`].
    pub schema: u32,
    /// Every setting of the case with its value.
    pub case: Value,
    /// The swept key.
    pub key: String,
    /// Iterations of each run, unless they are what is swept.
    pub iterations: usize,
    /// The case itself, then the panels asked for.
    pub panels: Vec<SweepPanel>,
    /// Circumstances of the run, such as version, case file and overrides.
    pub run: Map<String, Value>,
}

impl SweepReport {
    /// Writes the sweep as JSON, indented, with a line break at its end.
    ///
    /// # Errors
    /// A number that is not finite.
    pub fn to_json(&self) -> Result<String, ReportError> {
        to_json(self)
    }
}
