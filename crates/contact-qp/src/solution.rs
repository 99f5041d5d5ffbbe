//! What is returned: the answer, how it was found, and how good it is.

use crate::active_set::ActiveSet;
use crate::kkt::KktResiduals;
use std::fmt;

/// Says how the solution ended. Only [`QpStatus::Solved`] is an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum QpStatus {
    /// Bounds and signs hold exactly, and the KKT residuals are below the tolerance.
    Solved,
    /// Clarabel reached a reduced accuracy only; like the words below, where the polish found no answer from there.
    AlmostSolved,
    /// Clarabel found the objective unbounded below: `P` is singular and nothing holds the free direction.
    Unbounded,
    /// Clarabel reached the limit of its iterations.
    MaxIterations,
    /// Clarabel made no more progress.
    InsufficientProgress,
    /// Clarabel ended with a numerical error.
    NumericalError,
    /// Clarabel converged, but no active set with right signs and small KKT residuals was found from it.
    PolishFailed,
}

impl QpStatus {
    /// Tells whether the answer can be used.
    #[must_use]
    pub fn is_solved(self) -> bool {
        self == Self::Solved
    }
}

impl fmt::Display for QpStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Solved => "solved",
            Self::AlmostSolved => "almost solved",
            Self::Unbounded => "unbounded",
            Self::MaxIterations => "iteration limit reached",
            Self::InsufficientProgress => "insufficient progress",
            Self::NumericalError => "numerical error",
            Self::PolishFailed => "polish failed",
        })
    }
}

/// Says by which road the returned answer was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QpPath {
    /// The warm start was the right active set: one linear solution.
    WarmStart,
    /// Primal-dual active-set steps.
    ActiveSet,
    /// Clarabel, then the polish.
    Clarabel,
}

impl fmt::Display for QpPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::WarmStart => "warm-start",
            Self::ActiveSet => "active-set",
            Self::Clarabel => "clarabel",
        })
    }
}

/// Holds the answer of [`solve`](crate::solve).
///
/// Whatever the status: `x ≥ l` and `multipliers ≥ 0` exactly, `x_i == l_i` bit for bit on active bounds, and a
/// multiplier of exactly 0 on the others. When the status is not [`QpStatus::Solved`] the values are the last
/// iterate of Clarabel moved onto the bounds, and `kkt` says how far from a solution they are.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct QpSolution {
    /// Minimiser `x`, n entries.
    pub x: Vec<f64>,
    /// Multipliers `r = P x + q` of the bounds, ≥ 0, one per bounded index, in the order of `bounded`.
    pub multipliers: Vec<f64>,
    /// Bounds that hold with equality.
    pub active: ActiveSet,
    /// How the solution ended.
    pub status: QpStatus,
    /// Road by which this answer was found.
    pub path: QpPath,
    /// Iterations of that road: interior-point iterations for [`QpPath::Clarabel`], else active sets tried (1 for
    /// a warm start that was right). 0 when there is no unknown.
    pub iterations: usize,
    /// Active sets tried after Clarabel, to polish its answer; 1 when its set was right, 0 on the other roads.
    pub polish_steps: usize,
    /// Times Clarabel was called: 1, or 0 where the active-set steps had found the answer.
    pub clarabel_calls: usize,
    /// The four KKT residuals of the values returned here.
    pub kkt: KktResiduals,
}
