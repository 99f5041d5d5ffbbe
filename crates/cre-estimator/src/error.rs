//! Why an estimate could not be made.

use thiserror::Error;

/// Why an estimate could not be made.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum EstimatorError {
    /// An array has the wrong length.
    #[error("{what} has {found} entries; {expected} are needed")]
    Length {
        /// Which array.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The length needed.
        expected: usize,
    },
    /// An array has an entry that is infinite or not a number.
    #[error("{what} has an entry that is not finite")]
    NotFinite {
        /// Which array.
        what: &'static str,
    },
    /// The stars of the relaxation and their vectors do not fit in memory.
    #[error("the estimate of the error needs {} MiB, which cannot be had", bytes / (1 << 20))]
    OutOfMemory {
        /// Bytes asked for.
        bytes: usize,
    },
    /// The squares of stresses and energies underflow: nothing can be checked.
    #[error(
        "the stresses (largest {stress:.1e}) and the energy ({energy:.1e}) are too small for their squares; use other units"
    )]
    TooSmall {
        /// The largest component of a stress, Pa.
        stress: f64,
        /// `a(u, u)` of both bodies together, J/m.
        energy: f64,
    },
}
