//! Why a linear problem cannot be solved.

use contact_qp::QpError;
use thiserror::Error;

/// Why the operators of a linear problem could not be made.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum BalancingError {
    /// The springs of a floating body are not seen on its interface: its contact normals depend on each other or on its supports.
    #[error("the interface of body {} does not see all of its rigid motions", body + 1)]
    DependentRows {
        /// The body, from 0.
        body: usize,
    },
    /// The matrix of the coarse space could not be factorised.
    #[error("the matrix of the rigid motions cannot be factorised: {0}")]
    Coarse(#[from] QpError),
}
