//! A solved case.

use case_io::report::{AdaptiveRow, Status};
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
    /// The longest step between two checks of the clock: its name and its seconds.
    pub longest_step: Option<(&'static str, f64)>,
}
