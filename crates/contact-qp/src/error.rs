//! Errors: the input was invalid, or the matrix was not positive definite.

use thiserror::Error;

/// Why a quadratic programme is invalid.
///
/// How an iteration *ended* is not an error but a [`QpStatus`](crate::QpStatus). Each variant gives the
/// place, what was found there and what was expected.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum QpError {
    /// An array has the wrong number of entries.
    #[error("`{what}` has {found} entries, expected {expected}")]
    Length {
        /// Name of the array.
        what: &'static str,
        /// Number of entries it must have.
        expected: usize,
        /// Number of entries it has.
        found: usize,
    },
    /// A disc has an unknown that does not exist, or that is in another disc.
    #[error("a disc has the unknown {place}, expected one of {unknowns} unknowns, each in one disc only")]
    Disc {
        /// The unknown.
        place: usize,
        /// Number of unknowns.
        unknowns: usize,
    },
    /// A number is infinite or NaN.
    ///
    /// Only bounds may be infinite.
    #[error("`{what}[{place}]` is {found}, expected a finite number")]
    NotFinite {
        /// Name of the array.
        what: &'static str,
        /// Place in the array (column-major for a dense matrix).
        place: usize,
        /// The number found.
        found: f64,
    },
    /// A dense matrix is not symmetric.
    #[error(
        "matrix entry ({row}, {column}) is {found:e}, expected its mirror image {expected:e} \
         to within {tolerance:e}"
    )]
    NotSymmetric {
        /// Row, below the diagonal.
        row: usize,
        /// Column.
        column: usize,
        /// Entry `(row, column)`.
        found: f64,
        /// Entry `(column, row)`.
        expected: f64,
        /// Largest difference allowed.
        tolerance: f64,
    },
    /// `column_starts` does not begin at 0, decreases, or does not end at the number of entries.
    #[error("`column_starts[{place}]` is {found}, expected a value from {least} to {most}")]
    ColumnStarts {
        /// Place in `column_starts`.
        place: usize,
        /// The start found.
        found: usize,
        /// Smallest start allowed there.
        least: usize,
        /// Largest start allowed there.
        most: usize,
    },
    /// A sparse matrix has an entry below its diagonal.
    #[error("row {found} is stored in column {column}, expected rows 0 to {column}: upper triangle only")]
    BelowDiagonal {
        /// Column.
        column: usize,
        /// Row found there.
        found: usize,
    },
    /// The rows of a sparse column are unsorted or repeated.
    #[error("row {found} follows row {previous} in column {column}, expected a larger row")]
    RowOrder {
        /// Column.
        column: usize,
        /// Row stored just before.
        previous: usize,
        /// Row found.
        found: usize,
    },
    /// The bounds of an unknown exclude each other, or one of them is NaN.
    #[error("`lower[{place}]` is {lower} and `upper[{place}]` is {upper}, expected lower <= upper")]
    Bounds {
        /// The unknown.
        place: usize,
        /// Its lower bound.
        lower: f64,
        /// Its upper bound.
        upper: f64,
    },
    /// The matrix has a negative direction, in which the objective has no minimum.
    #[error("the matrix is not positive semi-definite, found at unknown {index}")]
    NotPositiveDefinite {
        /// Unknown whose pivot was negative (0 ≤ `index` < n).
        index: usize,
    },
    /// A setting is out of its range.
    #[error("setting `{what}` is {found}, expected {expected}")]
    Setting {
        /// Name of the setting.
        what: &'static str,
        /// Value found.
        found: f64,
        /// Allowed range, in words.
        expected: &'static str,
    },
    /// A library rejected data that had passed all checks.
    #[error("{library} rejected checked data: {message}")]
    Library {
        /// Name of the library.
        library: &'static str,
        /// Its message.
        message: String,
    },
}
