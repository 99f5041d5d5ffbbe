//! Errors of an estimate.

use contact_qp::QpError;
use neumann_neumann::BalancingError;
use thiserror::Error;

/// Why an estimate could not be made.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum EstimatorError {
    /// An array has the wrong length.
    #[error("{what} has {found} entries; {expected} are needed")]
    Length {
        /// The name of the array.
        what: String,
        /// Its length.
        found: usize,
        /// The length needed.
        expected: usize,
    },
    /// An array has an entry that is infinite or NaN.
    #[error("{what} has an entry that is not finite")]
    NotFinite {
        /// The name of the array.
        what: String,
    },
    /// The stars of the relaxation and their vectors do not fit in memory.
    #[error("the error estimate needs {} MiB, which could not be allocated", bytes / (1 << 20))]
    OutOfMemory {
        /// Requested bytes.
        bytes: usize,
    },
    /// The squares of stresses and energies underflow: the checks are impossible.
    #[error(
        "the stresses (largest {stress:.1e}) and the energy ({energy:.1e}) underflow when squared; rescale the units"
    )]
    TooSmall {
        /// The largest component of a stress, Pa.
        stress: f64,
        /// `a(u, u)` of both bodies together, J/m.
        energy: f64,
    },
    /// The motion of an obstacle that is free to move is not among the fields.
    #[error("obstacle {} is free to move: its motion is not among the displacements", obstacle + 1)]
    FreeObstacle {
        /// The obstacle, from 0.
        obstacle: usize,
    },
    /// Fields of other codes are certified without friction only.
    #[error("pair {} has friction; fields of other programs are certified without friction only", pair + 1)]
    FrictionOfField {
        /// The pair, from 0.
        pair: usize,
    },
    /// A side on springs is in contact, and was cut after the field was computed.
    #[error(
        "a side of body {} is on springs and in contact with surfaces that do not match; its field is certified on meshes that match only",
        body + 1
    )]
    SpringsOfField {
        /// The body, from 0.
        body: usize,
    },
    /// The pressure that keeps the floating bodies in balance could not be computed.
    #[error("the pressure in balance: {0}")]
    Balance(#[from] QpError),
    /// The operators of a body in subdomains could not be made.
    #[error(transparent)]
    Subdomains(#[from] BalancingError),
}
