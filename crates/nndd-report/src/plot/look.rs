//! The look of a series: colour, dash and marker.

use super::sheet::{PIXEL, Sheet, path};
use fem_core::geometry::Vector;

/// The shape that marks the points of a series.
#[derive(Clone, Copy, Debug)]
pub(super) enum Marker {
    /// No marker.
    None,
    /// A filled disc.
    Disc,
    /// A filled square.
    Square,
    /// A filled triangle.
    Triangle,
    /// A diagonal cross.
    Cross,
}

/// Half the width of a marker.
const MARKER: f64 = 4.0 * PIXEL;

/// Name, colour, dash and marker of a series.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look {
    pub(super) name: &'static str,
    pub(super) colour: &'static str,
    /// Lengths of dash and gap; empty for a whole line.
    pub(super) dash: &'static str,
    pub(super) marker: Marker,
    pub(super) thickness: f64,
}

impl Look {
    /// A whole line with a marker.
    pub(super) const fn new(
        name: &'static str,
        colour: &'static str,
        thickness: f64,
        marker: Marker,
    ) -> Look {
        Look { name, colour, dash: "", marker, thickness }
    }
    /// The same, dashed.
    pub(super) const fn dashed(self, dash: &'static str) -> Look {
        Look { dash, ..self }
    }
}

impl Sheet {
    /// Draws the line of a series.
    pub(super) fn line(&mut self, look: &Look, points: &[Vector]) {
        if points.len() > 1 {
            self.dashed(&path(points), look.colour, look.thickness, look.dash);
        }
    }

    /// Draws the marker of a series.
    pub(super) fn mark(&mut self, look: &Look, at: impl Into<Vector>) {
        let at = at.into();
        let [x, y] = at.into();
        // Shapes with corners have about the area of the disc.
        let (square, triangle) = (MARKER - 0.5 * PIXEL, MARKER + PIXEL);
        let (low, half) = (y + 0.5 * triangle, 0.866 * triangle);
        match look.marker {
            Marker::None => {}
            Marker::Disc => self.disc(at, MARKER, look.colour),
            Marker::Triangle => {
                self.fill(&path(&[[x, y - triangle], [x - half, low], [x + half, low]]), look.colour);
            }
            Marker::Square => {
                let [l, r, t, b] = [x - square, x + square, y - square, y + square];
                self.fill(&path(&[[l, t], [r, t], [r, b], [l, b]]), look.colour);
            }
            Marker::Cross => {
                let [l, r, t, b] = [x - MARKER, x + MARKER, y - MARKER, y + MARKER];
                let strokes = path(&[[l, t], [r, b]]) + &path(&[[l, b], [r, t]]);
                self.stroke(&strokes, look.colour, look.thickness);
            }
        }
    }
}
