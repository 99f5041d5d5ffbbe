//! Coloured cells as a few SVG paths, one for each shade: many times smaller than an element for each cell.

use super::bands::{BANDS, colour_of};
use fem_core::geometry::{Vector, cross};
use std::fmt::Write as _;

/// Above this many cells, the field of their means at the nodes is drawn instead.
pub(super) const MOST_CELLS: usize = 6_000;
/// Below this many cells, their edges are drawn too.
pub(super) const WITH_EDGES: usize = 4_000;

/// A triangle on the sheet, in whole units, and its value.
pub(super) struct Cell {
    pub(super) corners: [Vector; 3],
    pub(super) value: f64,
}

impl Cell {
    fn twice_area(&self) -> f64 {
        let [a, b, c] = self.corners;
        cross(b - a, c - a)
    }

    /// The cell as a closed path.
    pub(super) fn path(&self) -> String {
        let [a, b, c] = self.corners;
        let (u, v) = (b - a, c - b);
        format!("M{} {}l{} {} {} {}z", a[0], a[1], u[0], u[1], v[0], v[1])
    }
}

/// The shade of a position between 0 and 1 on the scale; `None` without a position.
fn shade(position: f64) -> Option<usize> {
    position.is_finite().then(|| ((position.clamp(0.0, 1.0) * BANDS as f64) as usize).min(BANDS - 1))
}

/// Returns the SVG elements of the cells; `position` places a value on the colour scale.
pub(super) fn elements(cells: &[Cell], position: impl Fn(f64) -> f64) -> String {
    let mut paths = vec![String::new(); BANDS];
    // If corners fall on one line, the line around the piece is all there is to see, and printers draw it to the edge.
    for cell in cells.iter().filter(|cell| cell.twice_area() != 0.0) {
        if let Some(k) = shade(position(cell.value)) {
            paths[k] += &cell.path();
        }
    }
    // A line of the same colour around each piece hides the seams between them.
    let mut out = "<g stroke-width=\"2\" stroke-linejoin=\"round\">\n".to_owned();
    for (k, path) in paths.iter().enumerate().filter(|(_, p)| !p.is_empty()) {
        let colour = colour_of(k);
        let _ = writeln!(out, "<path fill=\"{colour}\" stroke=\"{colour}\" d=\"{path}\"/>");
    }
    out + "</g>\n"
}

/// The edges of the cells: a thin light line that shows the mesh on every shade; nothing if there are many.
pub(super) fn edges(cells: &[Cell]) -> String {
    if cells.len() > WITH_EDGES {
        return String::new();
    }
    let all: String = cells.iter().filter(|cell| cell.twice_area() != 0.0).map(Cell::path).collect();
    format!(
        "<path d=\"{all}\" fill=\"none\" stroke=\"#FFFFFF\" stroke-opacity=\"0.3\" stroke-width=\"1.4\"/>\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_without_area_on_the_sheet_are_left_out() {
        let cell = |corners: [[f64; 2]; 3]| Cell { corners: corners.map(Vector::from), value: 1.0 };
        let flat = [[4.0, 4.0], [4.0, 4.0], [5.0, 4.0]];
        let drawn = [
            cell([[0.0, 0.0], [8.0, 0.0], [0.0, 8.0]]),
            cell(flat),
            cell([[1.0, 1.0], [2.0, 2.0], [3.0, 3.0]]),
        ];
        let text = elements(&drawn, |_| 0.5) + &edges(&drawn);
        assert!(text.contains("M0 0l8 0 -8 8z"), "{text}");
        // Once filled, once as a thin edge.
        assert_eq!(text.matches('M').count(), 2, "{text}");
    }
}
