//! Errors on the way from a problem to its certified solution.

use cre_estimator::EstimatorError;
use fem_core::assembly::AssemblyError;
use fem_core::condensation::FactorError;
use fem_core::interface::RefineError;
use nndd::NnddError;
use thiserror::Error;

/// Why a problem could not be solved.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SolveError {
    /// A body cannot be assembled, for example a floating one.
    #[error("body {body}: {source}")]
    Assembly {
        /// The body, from 0, in the order passed in.
        body: usize,
        /// What is wrong.
        source: AssemblyError,
    },
    /// A body cannot be factorised.
    #[error("body {body}: {source}")]
    Factor {
        /// The body, from 0, in the order passed in.
        body: usize,
        /// What is wrong.
        source: FactorError,
    },
    /// The iteration cannot be run.
    #[error(transparent)]
    Nndd(#[from] NnddError),
    /// The first iterate cannot be certified.
    #[error(transparent)]
    Estimator(#[from] EstimatorError),
    /// The problem cannot be refined.
    #[error(transparent)]
    Refine(#[from] RefineError),
    /// The observer ended the run before its first iteration: see [`crate::Observer::must_stop`].
    #[error("the run was ended before its first iteration")]
    Stopped,
    /// A checkpoint belongs to another problem.
    #[error("the checkpoint does not belong to this problem: {what}")]
    Checkpoint {
        /// What does not fit.
        what: &'static str,
    },
}
