//! Figures of a run as SVG text: the problem, indicators against a swept value, the convergence history, the adaptive one, the deformed
//! bodies coloured by error density, and pressure and opening along the contact.
//!
//! Every function takes plain numbers and returns a whole SVG document. Numbers that cannot be drawn (not
//! finite, or not positive on a logarithmic axis) are left out; if nothing is left the figure says
//! `no data`. Colours are those of Okabe and Ito and of the viridis map, which remain distinct to
//! colour-blind readers, and series differ by marker and dash as well.

mod adaptive;
mod axis;
mod cells;
mod colour;
mod contact;
mod convergence;
mod deformed;
mod legend;
mod look;
mod outline;
mod series;
mod sheet;
mod sketch;
mod sweep;
#[cfg(test)]
mod tests;

pub(crate) use adaptive::adaptive;
pub(crate) use contact::{ContactProfile, contact};
pub(crate) use convergence::{ConvergenceRow, convergence};
pub(crate) use deformed::{BodyPicture, Closing, deformed};
pub(crate) use sketch::{Held, SketchBody, SketchEdge, sketch};
pub(crate) use sweep::{SweepSeries, sweep};

/// Why a figure could not be drawn.
#[derive(Debug, thiserror::Error)]
pub(crate) enum PlotError {
    /// The drawing library failed.
    #[error("the figure could not be drawn: {0}")]
    Draw(String),
    /// Two arrays that belong together differ in length.
    #[error("{what}: {found} values, expected {expected}")]
    Length {
        /// Which array.
        what: &'static str,
        /// The length asked for.
        expected: usize,
        /// The length given.
        found: usize,
    },
    /// A triangle names a point that does not exist.
    #[error("triangle {triangle} names point {point}, but there are {points} points")]
    Index {
        /// The triangle, from 0.
        triangle: usize,
        /// The point it names.
        point: u32,
        /// How many points there are.
        points: usize,
    },
}

impl<E: std::error::Error + Send + Sync> From<plotters::drawing::DrawingAreaErrorKind<E>> for PlotError {
    fn from(error: plotters::drawing::DrawingAreaErrorKind<E>) -> Self {
        PlotError::Draw(error.to_string())
    }
}

/// Returns an error unless `found` equals `expected`.
fn same_length(what: &'static str, expected: usize, found: usize) -> Result<(), PlotError> {
    if expected == found { Ok(()) } else { Err(PlotError::Length { what, expected, found }) }
}
