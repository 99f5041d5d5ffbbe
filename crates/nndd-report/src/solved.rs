//! A solved case.

use case_io::report::{AdaptiveRow, Status, StepSummary};
use case_io::table::ContactRow;
use certified_contact::CertifiedSolution;

/// A solved case.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Solved {
    /// The answer, with its certificate.
    pub solution: CertifiedSolution,
    /// How the run ended.
    pub status: Status,
    /// One row per mesh of an adaptive run.
    pub adaptive: Vec<AdaptiveRow>,
    /// The relative change of the largest recovered stress from the mesh before.
    pub peak_change: Option<f64>,
    /// Notes about the refinement.
    pub notes: Vec<String>,
    /// Seconds from the start to the end of each of these meshes.
    pub step_seconds: Vec<f64>,
    /// The load steps that were solved; empty if the case has none. The answer is that of the last one.
    pub steps: Vec<SolvedStep>,
    /// The longest step between two checks of the clock: its name and its seconds.
    pub longest_step: Option<(&'static str, f64)>,
}

/// What is kept of a load step.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SolvedStep {
    /// Its entry in report.json.
    pub summary: StepSummary,
    /// The rows of contact.csv, pair by pair.
    pub rows: Vec<Vec<ContactRow>>,
}

impl Solved {
    /// Takes the answer of one solve.
    pub(crate) fn of(solution: CertifiedSolution, status: Status) -> Self {
        Self {
            solution,
            status,
            adaptive: Vec::new(),
            peak_change: None,
            notes: Vec::new(),
            step_seconds: Vec::new(),
            steps: Vec::new(),
            longest_step: None,
        }
    }
}
