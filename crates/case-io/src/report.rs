//! `report.json`: what a run found, with the exact keys and their order. [`JSON_SCHEMA`] describes them for other programs.
//!
//! JSON has no NaN: serde_json would write `null` without a word. [`Report::to_json`] therefore refuses a number
//! that is not finite and names its place. If a value may be unknown its type is an [`Option`], written as `null`.

mod bodies;
mod certificate;
mod contact;
mod finite;
mod results;
mod spin;
mod sweep;

pub use bodies::{BodySummary, CellCount, FreeMotion, RigidSideSummary};
pub use certificate::{Bounds, Certificate, Checks, Coulomb, Parts, ProjectedLoad, Split};
pub use contact::{
    ContactLine, ContactStretch, ContactSummary, ContactSurface, FrictionLine, FrictionSummary,
    FrictionSurface, SurfaceArea, SurfacePatch,
};
pub(crate) use finite::{NotFinite, check as check_finite};
pub use results::{
    CutResult, LineResults, PeakStress, PrincipalStress, PrincipalStresses, Reaction, Results, StressLimit,
};
pub use spin::Spin;
pub use sweep::{SWEEP_SCHEMA, SweepPanel, SweepReport, SweepRow};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use thiserror::Error;

/// The version of report.json that this crate writes.
pub const SCHEMA: u32 = 1;

/// The JSON Schema (2020-12) of report.json, with the unit of each number as `x-unit`.
pub const JSON_SCHEMA: &str = include_str!("../report.schema.json");

/// The key of `run` under which the hash of the case is kept, see [`crate::Case::hash`].
pub const CASE_HASH: &str = "case_hash";

/// Why a report cannot be written or read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReportError {
    /// A number that is infinite or NaN, since the data are extreme; never written.
    #[error("the report's {field} is {value}; only finite numbers are written")]
    NotFinite {
        /// Dotted path of the number.
        field: String,
        /// The number.
        value: f64,
    },
    /// Not JSON, or not the keys of a report.
    #[error("this is not a report: {0}")]
    Json(#[from] serde_json::Error),
}

impl From<NotFinite> for ReportError {
    fn from(NotFinite { field, value }: NotFinite) -> Self {
        Self::NotFinite { field, value }
    }
}

/// The whole report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// [`SCHEMA`].
    pub schema: u32,
    /// How the run ended.
    pub status: Status,
    /// Every setting with its value, see [`crate::Case::settings_json`].
    pub case: Value,
    /// The bodies in the file's order.
    pub bodies: Vec<BodySummary>,
    /// The contact interfaces.
    pub contact: Vec<ContactSummary>,
    /// One row per iteration.
    pub iterations: Vec<IterationRow>,
    /// The law that the run solved: `frictionless`, `tresca` or `coulomb`.
    #[serde(default)]
    pub problem: String,
    /// The bound of the last row; `None` with Coulomb friction, for which no bound is known.
    pub certificate: Option<Certificate>,
    /// The residual with Coulomb friction; left out without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coulomb: Option<Coulomb>,
    /// The numbers engineers ask for, of the last row.
    pub results: Results,
    /// One row per adaptive step; empty if the run was not adaptive.
    pub adaptive: Vec<AdaptiveRow>,
    /// The load steps that were solved, the last of which is the answer.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub steps: Vec<StepSummary>,
    /// Notes on how the case was read, such as cells that were split.
    #[serde(default)]
    pub notes: Vec<String>,
    /// Wall times.
    pub timings: Timings,
    /// Host, threads, version, start, flags, the hash of the case; free of form.
    pub run: Map<String, Value>,
}

/// A load step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StepSummary {
    /// Its number, from 1.
    pub step: usize,
    /// The factors of the named conditions at its end.
    pub factors: Map<String, Value>,
    /// How it ended.
    pub status: Status,
    /// The contact interfaces.
    pub contact: Vec<ContactSummary>,
    /// The numbers engineers ask for.
    pub results: Results,
    /// The bound of its increment; `None` with Coulomb friction.
    pub certificate: Option<Certificate>,
    /// The residual with Coulomb friction; left out without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coulomb: Option<Coulomb>,
}

impl StepSummary {
    /// Checks that all of its numbers are finite.
    ///
    /// # Errors
    /// [`ReportError::NotFinite`] with the place of the first one that is not.
    pub fn check(&self) -> Result<(), ReportError> {
        Ok(check_finite(self)?)
    }
}

/// How a run ended.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// One word, such as `converged`.
    pub word: String,
    /// The exit status.
    pub code: u8,
    /// Why, in a few words or as a comparison.
    pub reason: String,
}

/// One iteration.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct IterationRow {
    /// From 1.
    pub iteration: usize,
    /// θ of the update that follows; `None` for a method without θ.
    pub theta: Option<f64>,
    /// ε_t.
    pub precision: Option<f64>,
    /// η_NNDD.
    pub eta_nndd: Option<f64>,
    /// η_dis, if it was estimated.
    pub eta_dis: Option<f64>,
    /// The bound of the energy error, if it was estimated.
    pub e_cre: Option<f64>,
    /// Pairs with a positive force.
    pub contact_nodes: usize,
    /// `Σ r²_i`, N/m, if it is finite.
    pub contact_force: Option<f64>,
    /// The contact forces of both bodies in the file's order, N/m, positive in compression, if they are finite:
    /// equal at the discrete solution.
    pub contact_forces: [Option<f64>; 2],
    /// How the contact problem was solved.
    pub qp_path: Option<String>,
    /// Iterations of the contact problem.
    pub qp_iterations: usize,
    /// The Newton step of method newton-nn, from 1; `None` for its first two iterations, and with other methods.
    pub step: Option<usize>,
    /// The inner iterations of this step so far.
    pub inner: Option<usize>,
}

/// One adaptive step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AdaptiveRow {
    /// From 1.
    pub step: usize,
    /// Nodes of both bodies.
    pub nodes: usize,
    /// Node pairs on the interface.
    pub pairs: usize,
    /// In load steps the step, from 1, with the largest relative bound or residual: the step of the numbers below.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub load_step: Option<usize>,
    /// The bound; `None` with Coulomb friction.
    pub e_cre: Option<f64>,
    /// The bound relative to the energy norm.
    pub relative: Option<f64>,
    /// With Coulomb friction the residual.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub e_b: Option<f64>,
    /// The residual relative to the energy norm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub relative_residual: Option<f64>,
    /// Iterations of this step; with Coulomb friction the steps of the fixed point.
    pub iterations: usize,
    /// `a(u, u)` of both bodies.
    pub energy_norm_squared: f64,
    /// Largest equivalent stress of the recovered stress, Pa.
    #[serde(default)]
    pub peak_stress: Option<f64>,
}

/// Disjoint wall times that add up to `total`, s.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Timings {
    /// Reading or generating meshes.
    pub mesh: f64,
    /// Pattern, stiffness and loads.
    pub assembly: f64,
    /// Ordering, symbolic and numeric factorisation, interface operators.
    pub factorisation: f64,
    /// The loop, contact problems, recovery of displacements.
    pub iterations: f64,
    /// Everything for certificates.
    pub estimate: f64,
    /// Writing files.
    pub write: f64,
    /// All of it.
    pub total: f64,
}

impl Report {
    /// Writes the report as JSON, indented, with a line break at its end.
    ///
    /// # Errors
    /// A number that is not finite.
    pub fn to_json(&self) -> Result<String, ReportError> {
        to_json(self)
    }

    /// Reads a report.
    ///
    /// # Errors
    /// Not JSON, or not a report.
    pub fn from_json(text: &str) -> Result<Self, ReportError> {
        Ok(serde_json::from_str(text)?)
    }

    /// Returns the certificate, if there is one and its checks hold.
    pub fn valid_certificate(&self) -> Option<&Certificate> {
        self.certificate.as_ref().filter(|certificate| certificate.valid)
    }

    /// Returns the hash of the case, if the report carries one.
    pub fn case_hash(&self) -> Option<&str> {
        self.run.get(CASE_HASH)?.as_str()
    }
}

/// Writes JSON whose numbers are all finite, indented, with a line break at its end.
fn to_json<T: Serialize>(value: &T) -> Result<String, ReportError> {
    check_finite(value)?;
    let mut text = serde_json::to_string_pretty(value)?;
    text.push('\n');
    Ok(text)
}

#[cfg(test)]
pub(crate) mod tests;
