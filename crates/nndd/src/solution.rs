//! The result of an iteration and how it ended.

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
    /// η_NNDD grows or λ overflows: θ is too large.
    Diverged {
        /// The smallest η_NNDD; infinite if even the first one is not finite.
        best: f64,
        /// The iteration converges for θ below this (full contact), if it could be estimated.
        theta_limit: Option<f64>,
    },
    /// No progress: η_NNDD fell by less than 10 % in 60 iterations, and either not in each of them or by less than
    /// 0.1 %. At round-off level, 6 iterations are enough.
    Stalled {
        /// The smallest η_NNDD: the attainable floor if it is at round-off level.
        floor: f64,
        /// Whether that floor is round-off, relative to the first iteration.
        at_round_off: bool,
    },
    /// The discrete problem is solved, but the pressures that hold floating bodies in balance on the meshed outline differ from its
    /// forces by more than the criterion allows. A finer mesh brings them together.
    BalanceError {
        /// The measured η_NNDD.
        eta_nndd: f64,
    },
    /// The caller ended it.
    Interrupted,
    /// The contact problem of an Ω₂ was not solved.
    ContactQpUnsolved(QpStatus),
}

/// The result of [`crate::solve`].
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct NnddSolution {
    /// How it ended.
    pub status: NnddStatus,
    /// One row per iteration.
    pub history: Vec<IterationRow>,
    /// The last iteration.
    pub last: Iterate,
    /// Initial θ, given or chosen; 0 for the exact solution, which does not use θ.
    pub theta: f64,
    /// The spectrum from which θ was chosen; if a given θ failed, the spectrum that shows which θ would converge.
    pub spectrum: Option<Spectrum>,
    /// Total number of calls of Clarabel.
    pub clarabel_calls: usize,
}
