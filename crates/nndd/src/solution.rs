//! How an iteration ended, and what it leaves.

use crate::iterate::{Iterate, IterationRow};
use crate::spectrum::Spectrum;
use contact_qp::QpStatus;

/// How an iteration ended.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum NnddStatus {
    /// The stopping criterion was met.
    StoppedByCriterion,
    /// All allowed iterations were used.
    MaxIterations,
    /// η_NNDD grows, or λ leaves the numbers: θ is too large.
    Diverged {
        /// The smallest η_NNDD; infinite where not even the first is a finite number.
        best: f64,
        /// θ converges below this (full contact), where that could be estimated.
        theta_limit: Option<f64>,
    },
    /// η_NNDD fell by less than 10 % in 60 iterations, and either not at each of them or by less than 0.1 %; or in 6, at
    /// round-off.
    Stalled {
        /// The smallest η_NNDD: the attainable floor where it is at round-off.
        floor: f64,
        /// Whether that floor is round-off, against the first iteration.
        at_round_off: bool,
    },
    /// Somebody outside ended it.
    Interrupted,
    /// Ω₂'s contact problem was not solved.
    ContactQpUnsolved(QpStatus),
}

/// A switch from the Neumann-Neumann iteration to the interface Newton method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Switch {
    /// How the iteration ended before the switch.
    pub after: NnddStatus,
    /// How the Newton method ended. If it is not solved, the solution is that of the iteration.
    pub newton: QpStatus,
}

/// The result of [`crate::solve`].
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct NnddSolution {
    /// How it ended.
    pub status: NnddStatus,
    /// The switch to the interface Newton method, if there was one.
    pub switch: Option<Switch>,
    /// One row per iteration; after a switch one more, of the Newton method.
    pub history: Vec<IterationRow>,
    /// The last iteration.
    pub last: Iterate,
    /// θ at the start: as given, or chosen; 0 for Newton's method, which has none.
    pub theta: f64,
    /// The spectrum by which θ was chosen; where a given θ failed, the one that says which would do.
    pub spectrum: Option<Spectrum>,
    /// How often Clarabel was called in all.
    pub clarabel_calls: usize,
}
