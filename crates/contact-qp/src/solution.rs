//! The solution of a programme, the way that led to it, and its accuracy.

use crate::bound_state::BoundState;
use crate::residuals::KktResiduals;
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

/// How often each way to a solution was taken; `0` for the ones that were not needed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct QpCounts {
    /// Active sets tried before Clarabel was called.
    pub active_sets: usize,
    /// Calls of Clarabel with few of the bounds of a large programme.
    pub shrunk_calls: usize,
    /// Calls of Clarabel with the whole programme.
    pub whole_calls: usize,
    /// Iterations of Clarabel in all its calls.
    pub interior_points: usize,
    /// Active sets tried from the ones of Clarabel: 1 if its set was right.
    pub polish_sets: usize,
    /// Steps that lowered the objective, one unknown at a time.
    pub descent_steps: usize,
    /// Programmes for multipliers with the right signs.
    pub fitted: usize,
}

impl QpCounts {
    /// Adds the counts of another programme.
    pub(crate) fn add(&mut self, other: Self) {
        self.active_sets += other.active_sets;
        self.shrunk_calls += other.shrunk_calls;
        self.whole_calls += other.whole_calls;
        self.interior_points += other.interior_points;
        self.polish_sets += other.polish_sets;
        self.descent_steps += other.descent_steps;
        self.fitted += other.fitted;
    }

    /// Returns the method that these counts make, and its iterations.
    pub(crate) fn path(&self) -> (QpPath, usize) {
        match (self.clarabel_calls(), self.active_sets) {
            (0, 1) => (QpPath::WarmStart, 1),
            (0, sets) => (QpPath::ActiveSet, sets),
            _ => (QpPath::Clarabel, self.interior_points),
        }
    }

    /// Returns the number of calls of Clarabel.
    #[must_use]
    pub fn clarabel_calls(&self) -> usize {
        self.shrunk_calls + self.whole_calls
    }
}

/// The solution of a [`BoxQp`](crate::BoxQp).
///
/// For every status `x` is within its bounds exactly, at a bound bit for bit if its place says so, and multipliers have the right signs.
/// If the status is not [`QpStatus::Solved`], the values are the last ones of Clarabel moved into the bounds, and `kkt` measures how far
/// from a solution they are.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BoxSolution {
    /// `x`, n entries.
    pub x: Vec<f64>,
    /// `y = P x + q − Gᵀ a`: ≥ 0 at lower bounds, ≤ 0 at upper bounds, exactly 0 between them.
    pub multipliers: Vec<f64>,
    /// `a`, of least norm if rows depend on each other.
    pub row_multipliers: Vec<f64>,
    /// Where each unknown is.
    pub states: Vec<BoundState>,
    /// How the solve ended.
    pub status: QpStatus,
    /// Method that found this solution.
    pub path: QpPath,
    /// Iterations of that method: active sets tried, 1 for a right start, or iterations of Clarabel. 0 without unknowns.
    pub iterations: usize,
    /// How often each way was taken.
    pub counts: QpCounts,
    /// How far it is from the KKT conditions.
    pub kkt: KktResiduals,
}
