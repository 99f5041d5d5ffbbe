//! Coloured cells as a few SVG paths, one for each shade: many times smaller than an element for each cell.

use super::axis::extent;
use super::colour::viridis;
use fem_core::geometry::{Vector, cross};
use std::fmt::Write as _;

/// Shades of the colour scale.
pub(super) const SHADES: usize = 64;
/// Above this many cells, small squares with the mean of the cells in them are drawn instead.
pub(super) const MOST_CELLS: usize = 20_000;
/// Squares drawn at most, and the smallest side of one.
const MOST_SQUARES: f64 = 60_000.0;
const SMALLEST_SQUARE: f64 = 8.0;
/// The part of a square that must be covered if no cell covers its middle.
const ENOUGH: f64 = 0.6;
/// Below this many cells, their edges are drawn too.
pub(super) const WITH_EDGES: usize = 4_000;

/// A triangle on the sheet, in whole units, and its density.
pub(super) struct Cell {
    pub(super) corners: [Vector; 3],
    pub(super) density: f64,
}

impl Cell {
    fn twice_area(&self) -> f64 {
        let [a, b, c] = self.corners;
        cross(b - a, c - a)
    }

    pub(super) fn middle(&self) -> Vector {
        let [a, b, c] = self.corners;
        (a + b + c) / 3.0
    }

    /// The cell as a closed path.
    pub(super) fn path(&self) -> String {
        let [a, b, c] = self.corners;
        let (u, v) = (b - a, c - b);
        format!("M{} {}l{} {} {} {}z", a[0], a[1], u[0], u[1], v[0], v[1])
    }
}

/// The shade of a position between 0 and 1 on the scale.
fn shade(position: f64) -> usize {
    if position.is_finite() { (position.clamp(0.0, 1.0) * (SHADES - 1) as f64).round() as usize } else { 0 }
}

/// The colour of a shade.
pub(super) fn colour_of(shade: usize) -> String {
    viridis(shade as f64 / (SHADES - 1) as f64)
}

/// Returns the SVG elements of the cells; `position` places a density on the colour scale.
pub(super) fn elements(cells: &[&Cell], position: impl Fn(f64) -> f64) -> String {
    if cells.len() <= MOST_CELLS { triangles(cells, position) } else { squares(cells, position) }
}

fn triangles(cells: &[&Cell], position: impl Fn(f64) -> f64) -> String {
    let mut paths = vec![String::new(); SHADES];
    // If corners fall on one line, the line around the piece is all there is to see, and printers draw it to the edge.
    for cell in cells.iter().filter(|cell| cell.twice_area() != 0.0) {
        paths[shade(position(cell.density))] += &cell.path();
    }
    let mut out = joined(&paths, 2);
    if cells.len() <= WITH_EDGES {
        // The edges once more on top: a thin light line that shows the mesh on every shade.
        let all: String = paths.concat();
        let _ = writeln!(
            out,
            "<path d=\"{all}\" fill=\"none\" stroke=\"#FFFFFF\" stroke-opacity=\"0.35\" stroke-width=\"1.6\"/>"
        );
    }
    out
}

/// One path for each shade; a line of the same colour around each piece hides the seams between them.
fn joined(paths: &[String], line: u32) -> String {
    let mut out = format!("<g stroke-width=\"{line}\" stroke-linejoin=\"round\">\n");
    for (k, path) in paths.iter().enumerate().filter(|(_, p)| !p.is_empty()) {
        let colour = colour_of(k);
        let _ = writeln!(out, "<path fill=\"{colour}\" stroke=\"{colour}\" d=\"{path}\"/>");
    }
    out.push_str("</g>\n");
    out
}

/// A regular grid of squares over the cells, with the sums for the mean in each.
struct Grid {
    origin: Vector,
    side: f64,
    size: [usize; 2],
    sums: Vec<Sum>,
}

impl Grid {
    fn over(cells: &[&Cell]) -> Grid {
        let ends =
            [0, 1].map(|k| extent(cells.iter().flat_map(|c| c.corners.map(|p| p[k]))).unwrap_or_default());
        let [w, h] = ends.map(|(lo, hi)| (hi - lo).max(1.0));
        let side = (w * h / MOST_SQUARES).sqrt().ceil().max(SMALLEST_SQUARE);
        let size = [w, h].map(|length| (length / side) as usize + 1);
        Grid { origin: ends.map(|e| e.0).into(), side, size, sums: vec![Sum::default(); size[0] * size[1]] }
    }

    /// The column or row (`k` = 0 or 1) of a coordinate.
    fn index(&self, k: usize, x: f64) -> usize {
        (((x - self.origin[k]) / self.side).max(0.0) as usize).min(self.size[k] - 1)
    }

    /// Adds a cell to the square it lies in, weighted by its area, or, if it is larger than a square, to
    /// every square whose middle it covers; marks the squares whose middle it covers.
    fn add(&mut self, cell: &Cell) {
        let [a, b, c] = cell.corners;
        let twice = cell.twice_area();
        let (area, square) = (0.5 * twice.abs(), self.side * self.side);
        // A covered square in which no cell has its centre gets the colour of what covers it.
        let weight = if area < square { 1e-6 * area } else { square };
        if area < square {
            let middle = cell.middle();
            let [i, j] = [0, 1].map(|k| self.index(k, middle[k]));
            self.sums[j * self.size[0] + i].add(cell.density, area.max(0.5));
        }
        let [columns, rows] = [0, 1].map(|k| {
            let (lo, hi) = extent([a[k], b[k], c[k]]).unwrap_or_default();
            self.index(k, lo)..=self.index(k, hi)
        });
        for j in rows {
            for i in columns.clone() {
                let m = self.origin + self.side * Vector::new(i as f64 + 0.5, j as f64 + 0.5);
                let inside = |p: Vector, q: Vector| cross(q - p, m - p) * twice.signum() >= 0.0;
                if twice != 0.0 && inside(a, b) && inside(b, c) && inside(c, a) {
                    let sum = &mut self.sums[j * self.size[0] + i];
                    sum.add(cell.density, weight);
                    sum.covered = true;
                }
            }
        }
    }
}

/// Sums over the cells in a square.
#[derive(Clone, Default)]
struct Sum {
    density: f64,
    weight: f64,
    covered: bool,
}

impl Sum {
    fn add(&mut self, density: f64, weight: f64) {
        self.density += density * weight;
        self.weight += weight;
    }

    /// The mean in a square, `None` if the bodies cover little of it.
    fn mean(&self, square: f64) -> Option<f64> {
        let enough = self.covered || self.weight > ENOUGH * square;
        (enough && self.weight > 0.0).then(|| self.density / self.weight)
    }
}

fn squares(cells: &[&Cell], position: impl Fn(f64) -> f64) -> String {
    let mut grid = Grid::over(cells);
    cells.iter().for_each(|cell| grid.add(cell));
    let mut paths = vec![String::new(); SHADES];
    let side = grid.side;
    for (j, row) in grid.sums.chunks(grid.size[0]).enumerate() {
        let shades: Vec<Option<usize>> =
            row.iter().map(|sum| sum.mean(side * side).map(|m| shade(position(m)))).collect();
        let mut x = grid.origin[0];
        let y = grid.origin[1] + j as f64 * side;
        // Neighbours of one shade in a row make one rectangle.
        for run in shades.chunk_by(|a, b| a == b) {
            let w = run.len() as f64 * side;
            if let Some(k) = run[0] {
                let _ = write!(paths[k], "M{x} {y}h{w}v{side}h-{w}z");
            }
            x += w;
        }
    }
    joined(&paths, 4)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_without_area_on_the_sheet_are_left_out() {
        let cell = |corners: [[f64; 2]; 3]| Cell { corners: corners.map(Vector::from), density: 1.0 };
        let flat = [[4.0, 4.0], [4.0, 4.0], [5.0, 4.0]];
        let drawn = [
            cell([[0.0, 0.0], [8.0, 0.0], [0.0, 8.0]]),
            cell(flat),
            cell([[1.0, 1.0], [2.0, 2.0], [3.0, 3.0]]),
        ];
        let text = elements(&drawn.iter().collect::<Vec<_>>(), |_| 0.5);
        assert!(text.contains("M0 0l8 0 -8 8z"), "{text}");
        // Once filled, once as a thin edge.
        assert_eq!(text.matches('M').count(), 2, "{text}");
    }
}
