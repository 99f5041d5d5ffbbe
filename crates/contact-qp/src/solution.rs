//! The result: the solution, the method that found it, and its accuracy.

use crate::active_set::ActiveSet;
use crate::kkt::KktResiduals;
use std::fmt;

/// How the solve ended. Only [`QpStatus::Solved`] is a solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum QpStatus {
    /// Bounds and signs hold exactly, and the KKT residuals are below the tolerance.
    Solved,
    /// Clarabel reached only a reduced accuracy. This status and those below are returned if the polish found no
    /// solution from there.
    AlmostSolved,
    /// Clarabel found the objective unbounded below: `P` is singular and a free direction is unconstrained.
    Unbounded,
    /// Clarabel found that no `x` within the bounds satisfies the equality rows.
    Infeasible,
    /// Clarabel reached its iteration limit.
    MaxIterations,
    /// Clarabel made no further progress.
    InsufficientProgress,
    /// Clarabel ended with a numerical error.
    NumericalError,
    /// Clarabel converged, but no active set with correct signs and small KKT residuals was found from it.
    PolishFailed,
}

impl QpStatus {
    /// Tells whether the solution is valid.
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
            Self::Infeasible => "infeasible",
            Self::MaxIterations => "iteration limit reached",
            Self::InsufficientProgress => "insufficient progress",
            Self::NumericalError => "numerical error",
            Self::PolishFailed => "polish failed",
        })
    }
}

/// The method that found the returned solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QpPath {
    /// The warm start was the correct active set: one linear solve.
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

/// The result of [`solve`](crate::solve).
///
/// For every status: `x ≥ l` and `multipliers ≥ 0` exactly, `x_i == l_i` bit for bit on active bounds, and a
/// multiplier of exactly 0 on the others. When the status is not [`QpStatus::Solved`] the values are the last
/// iterate of Clarabel moved onto the bounds, and `kkt` measures how far from a solution they are.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct QpSolution {
    /// Minimiser `x`, n entries.
    pub x: Vec<f64>,
    /// Multipliers `r = P x + q` of the bounds, ≥ 0, one per bounded index, in the order of `bounded`.
    pub multipliers: Vec<f64>,
    /// Bounds that hold with equality.
    pub active: ActiveSet,
    /// How the solve ended.
    pub status: QpStatus,
    /// Method that found this solution.
    pub path: QpPath,
    /// Iterations of that method: interior-point iterations for [`QpPath::Clarabel`], else active sets tried (1 for
    /// a correct warm start). 0 when there are no unknowns.
    pub iterations: usize,
    /// Active sets tried after Clarabel to polish its solution; 1 if its set was correct, 0 for the other methods.
    pub polish_steps: usize,
    /// Number of calls of Clarabel: 1, or 0 if the active-set steps had found the solution.
    pub clarabel_calls: usize,
    /// The four KKT residuals of the values returned here.
    pub kkt: KktResiduals,
}
