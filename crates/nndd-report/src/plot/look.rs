//! What distinguishes series: colour, dash and marker.

use super::PlotError;
use super::sheet::{Area, UNITS};
use plotters::element::{Circle, Cross, PathElement, Polygon, TriangleMarker};
use plotters::style::{Color, RGBColor, ShapeStyle};

/// Dashes drawn on a series; longer lines are drawn whole.
const MOST_DASHES: f64 = 2000.0;

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

/// Name, colour, dash and marker of a series.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look {
    pub(super) name: &'static str,
    pub(super) colour: RGBColor,
    /// Lengths of dash and gap in pixels.
    pub(super) dash: Option<(i32, i32)>,
    pub(super) marker: Marker,
    /// Thickness of the line in units.
    pub(super) thickness: u32,
}

/// Draws a line through points given in units.
pub(super) fn stroke(area: &Area<'_>, look: &Look, path: &[(i32, i32)]) -> Result<(), PlotError> {
    let style = ShapeStyle { color: look.colour.to_rgba(), filled: false, stroke_width: look.thickness };
    if path.len() < 2 {
        return Ok(());
    }
    let length: f64 = path.windows(2).map(|w| distance(w[0], w[1])).sum();
    match look.dash {
        Some((on, off)) if length / f64::from((on + off) * UNITS) <= MOST_DASHES => {
            for dash in dashes(path, f64::from(on * UNITS), f64::from(off * UNITS)) {
                area.draw(&PathElement::new(dash, style))?;
            }
        }
        _ => area.draw(&PathElement::new(path, style))?,
    }
    Ok(())
}

/// Draws the marker of a series at a point given in units.
pub(super) fn mark(area: &Area<'_>, look: &Look, at: (i32, i32)) -> Result<(), PlotError> {
    let r = 4 * UNITS;
    let filled = look.colour.filled();
    match look.marker {
        Marker::None => {}
        Marker::Disc => area.draw(&Circle::new(at, r, filled))?,
        Marker::Triangle => area.draw(&TriangleMarker::new(at, r + UNITS, filled))?,
        Marker::Cross => area.draw(&Cross::new(at, r, look.colour.stroke_width(look.thickness)))?,
        Marker::Square => {
            let (x, y, h) = (at.0, at.1, r - UNITS / 2);
            let corners = [(x - h, y - h), (x + h, y - h), (x + h, y + h), (x - h, y + h)];
            area.draw(&Polygon::new(corners, filled))?;
        }
    }
    Ok(())
}

fn distance(a: (i32, i32), b: (i32, i32)) -> f64 {
    f64::from(a.0 - b.0).hypot(f64::from(a.1 - b.1))
}

/// Cuts a path into dashes of a length with gaps of another between them.
fn dashes(path: &[(i32, i32)], on: f64, off: f64) -> Vec<Vec<(i32, i32)>> {
    let mut done = vec![];
    let (mut drawing, mut left, mut dash) = (true, on, vec![path[0]]);
    for w in path.windows(2) {
        let length = distance(w[0], w[1]);
        let mut s = 0.0;
        while length - s > left {
            s += left;
            let t = s / length;
            let at = |a: i32, b: i32| (f64::from(a) + t * f64::from(b - a)).round() as i32;
            let p = (at(w[0].0, w[1].0), at(w[0].1, w[1].1));
            if drawing {
                dash.push(p);
                done.push(std::mem::take(&mut dash));
            } else {
                dash = vec![p];
            }
            drawing = !drawing;
            left = if drawing { on } else { off };
        }
        left -= length - s;
        if drawing {
            dash.push(w[1]);
        }
    }
    if drawing && dash.len() > 1 {
        done.push(dash);
    }
    done
}
