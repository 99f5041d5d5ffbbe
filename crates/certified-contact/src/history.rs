//! The course of a run.

use nndd::IterationRow;

/// One iteration with what was estimated at it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// What the iteration knows.
    pub iteration: IterationRow,
    /// The discretisation indicator, where it was computed.
    pub eta_dis: Option<f64>,
    /// The guaranteed bound of this iteration's pair, where it was computed.
    pub e_cre: Option<f64>,
}
