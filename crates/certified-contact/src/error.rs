//! Errors on the way from a problem to its certified solution.

use cre_estimator::EstimatorError;
use fem_core::interface::{FactorError, InterfaceError, RefineError};
use fem_core::prepared::PrepareError;
use nndd::NnddError;
use thiserror::Error;

/// Why a problem could not be solved.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SolveError {
    /// The bodies cannot be assembled or factorised, for example floating ones.
    #[error(transparent)]
    Prepare(PrepareError),
    /// The iteration cannot be run.
    #[error(transparent)]
    Nndd(#[from] NnddError),
    /// The first iterate cannot be certified.
    #[error(transparent)]
    Estimator(#[from] EstimatorError),
    /// The problem cannot be refined.
    #[error(transparent)]
    Refine(#[from] RefineError),
    /// The conditions cannot be imposed with the factors of a load step.
    #[error(transparent)]
    Factors(#[from] FactorError),
    /// The slip of a load step is not finite.
    #[error(transparent)]
    Slip(#[from] InterfaceError),
    /// A problem without Coulomb friction.
    #[error("no pair has Coulomb friction; solve the problem with `solve`, which certifies the solution")]
    NoCoulomb,
    /// The observer ended the run before its first iteration: see [`crate::Observer::must_stop`].
    #[error("the run was ended before its first iteration")]
    Stopped,
    /// A checkpoint belongs to another problem.
    #[error("the checkpoint does not belong to this problem: {what}")]
    Checkpoint {
        /// The difference, in words.
        what: &'static str,
    },
}
