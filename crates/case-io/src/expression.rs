//! Expressions in `x` and `y`, for solids also in `z`: data of a case that differ from point to point.
//!
//! ```
//! use case_io::Expression;
//! let load = Expression::parse("30 * sin(pi * x / 2) - y^2")?;
//! assert!((load.at([1.0, 2.0]) - 26.0).abs() < 1e-14);
//! let error = Expression::parse("30 * sinn(x)").unwrap_err();
//! assert_eq!((error.span, error.help.as_deref()), (5..9, Some("did you mean `sin`?")));
//! # Ok::<(), case_io::ExpressionError>(())
//! ```
//!
//! Numbers, `x`, `y` (and `z`), `pi`, the operators `+ - * / ^`, parentheses, and the functions of [`FUNCTIONS`]. A power binds
//! more strongly than a sign, `-x^2 = -(x^2)`, and has one exponent: `a^b^c` is refused.

mod nodal;
mod parse;
#[cfg(test)]
mod tests;
mod value;
mod words;

use std::fmt;
use std::ops::{Index, Range};
use std::sync::Arc;
use thiserror::Error;

pub use nodal::{NodalData, NodalFunction};
pub use value::{AtNodes, Given, Value};
pub use words::{COORDINATES, FUNCTIONS};
pub(crate) use words::{joined, quoted};

/// The longest expression, in bytes.
pub const LONGEST_EXPRESSION: usize = 1000;

/// The most parentheses that are open at one place.
pub const DEEPEST_EXPRESSION: usize = 50;

/// Why a text is not an expression.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{message}")]
#[non_exhaustive]
pub struct ExpressionError {
    /// The bytes of the text that are wrong.
    pub span: Range<usize>,
    /// The fault, with the text that was found.
    pub message: String,
    /// The text that was expected there.
    pub expected: Option<String>,
    /// One fix.
    pub help: Option<String>,
}

/// A text that was read once, to be evaluated at many points.
#[derive(Clone)]
pub struct Expression {
    text: String,
    tree: Arc<parse::Node>,
}

impl Expression {
    /// Reads an expression of the plane, in `x` and `y`.
    ///
    /// # Errors
    /// The first fault, with its place in the text: an unknown name or character, a syntax error, more than [`LONGEST_EXPRESSION`] bytes,
    /// or more than [`DEEPEST_EXPRESSION`] open parentheses.
    pub fn parse(text: &str) -> Result<Self, ExpressionError> {
        Self::parse_in(text, &COORDINATES[..2])
    }

    /// Reads an expression.
    ///
    /// * `coordinates`: the names of the coordinates, the first of [`COORDINATES`].
    ///
    /// # Errors
    /// See [`Self::parse`].
    pub(crate) fn parse_in(
        text: &str,
        coordinates: &'static [&'static str],
    ) -> Result<Self, ExpressionError> {
        Ok(Self { tree: Arc::new(parse::parse(text, coordinates)?), text: text.to_owned() })
    }

    /// Returns the text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Evaluates the expression at a point, an array or a vector of its coordinates; NaN or infinite if it is not defined.
    pub fn at(&self, point: impl Index<usize, Output = f64>) -> f64 {
        self.tree.at(&point)
    }

    /// Says whether the value is the same everywhere because no coordinate is in the text.
    pub fn is_constant(&self) -> bool {
        !self.tree.uses_coordinates()
    }
}

impl PartialEq for Expression {
    fn eq(&self, other: &Self) -> bool {
        self.text == other.text
    }
}

impl fmt::Debug for Expression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Expression({:?})", self.text)
    }
}
