//! Coloured cells as a few SVG paths, one for each shade: many times smaller than an element for each cell.

use super::colour::viridis;
use std::fmt::Write as _;

/// Shades of the colour scale.
pub(super) const SHADES: usize = 64;
/// Above this many cells, small squares with the mean of the cells in them are drawn instead.
pub(super) const MOST_CELLS: usize = 20_000;
/// Squares drawn at most.
const MOST_SQUARES: f64 = 60_000.0;
/// Below this many cells, their edges are drawn too.
const WITH_EDGES: usize = 4_000;

/// A triangle on the sheet, in units, and its density.
pub(super) struct Cell {
    pub(super) corners: [(i32, i32); 3],
    pub(super) density: f64,
}

/// The shade of a position between 0 and 1 on the scale.
pub(super) fn shade(position: f64) -> usize {
    if position.is_finite() { (position.clamp(0.0, 1.0) * (SHADES - 1) as f64).round() as usize } else { 0 }
}

/// The colour of a shade, as SVG writes it.
fn colour_of(shade: usize) -> String {
    let c = viridis(shade as f64 / (SHADES - 1) as f64);
    format!("#{:02X}{:02X}{:02X}", c.0, c.1, c.2)
}

/// Returns the SVG elements of the cells; `position` places a density on the colour scale.
pub(super) fn elements(cells: &[Cell], position: impl Fn(f64) -> f64) -> String {
    if cells.len() <= MOST_CELLS { triangles(cells, position) } else { squares(cells, position) }
}

fn triangles(cells: &[Cell], position: impl Fn(f64) -> f64) -> String {
    let mut paths = vec![String::new(); SHADES];
    // If corners fall on one line, the line around the piece is all there is to see, and printers draw it to the edge.
    for cell in cells.iter().filter(|cell| twice_area(cell.corners) != 0) {
        let [a, b, c] = cell.corners;
        let path = &mut paths[shade(position(cell.density))];
        let _ = write!(path, "M{} {}l{} {} {} {}z", a.0, a.1, b.0 - a.0, b.1 - a.1, c.0 - b.0, c.1 - b.1);
    }
    let edges = cells.len() <= WITH_EDGES;
    let mut out = joined(&paths, 2);
    if edges {
        // The edges once more on top: a thin light line that shows the mesh on every shade.
        let all: String = paths.concat();
        let _ = writeln!(
            out,
            "<path d=\"{all}\" fill=\"none\" stroke=\"#FFFFFF\" stroke-opacity=\"0.35\" stroke-width=\"1.6\"/>"
        );
    }
    out
}

/// Twice the signed area of a triangle on the sheet.
fn twice_area([a, b, c]: [(i32, i32); 3]) -> i64 {
    i64::from(b.0 - a.0) * i64::from(c.1 - a.1) - i64::from(b.1 - a.1) * i64::from(c.0 - a.0)
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
    left: i32,
    top: i32,
    side: i32,
    columns: usize,
    rows: usize,
    sums: Vec<Sum>,
}

impl Grid {
    fn over(cells: &[Cell]) -> Grid {
        let corners = || cells.iter().flat_map(|c| c.corners);
        let (left, right) = corners().fold((i32::MAX, i32::MIN), |(a, b), p| (a.min(p.0), b.max(p.0)));
        let (top, bottom) = corners().fold((i32::MAX, i32::MIN), |(a, b), p| (a.min(p.1), b.max(p.1)));
        let (w, h) = (f64::from(right - left).max(1.0), f64::from(bottom - top).max(1.0));
        let side = (w * h / MOST_SQUARES).sqrt().ceil().max(8.0) as i32;
        let (columns, rows) = ((w as i32 / side + 1) as usize, (h as i32 / side + 1) as usize);
        Grid { left, top, side, columns, rows, sums: vec![Sum::default(); columns * rows] }
    }

    /// Adds a cell to the square it lies in, weighted by its area, or, if it is larger than a square, to
    /// every square whose middle it covers; marks the squares whose middle it covers.
    fn add(&mut self, cell: &Cell) {
        let [a, b, c] = cell.corners;
        let cross = |p: (i32, i32), q: (i32, i32), r: (i32, i32)| {
            i64::from(q.0 - p.0) * i64::from(r.1 - p.1) - i64::from(q.1 - p.1) * i64::from(r.0 - p.0)
        };
        let column = |x: i32| ((x - self.left) / self.side).clamp(0, self.columns as i32 - 1) as usize;
        let row = |y: i32| ((y - self.top) / self.side).clamp(0, self.rows as i32 - 1) as usize;
        let (first, last) = (column(a.0.min(b.0).min(c.0)), column(a.0.max(b.0).max(c.0)));
        let (low, high) = (row(a.1.min(b.1).min(c.1)), row(a.1.max(b.1).max(c.1)));
        let twice = cross(a, b, c);
        let (area, square) = (0.5 * twice.abs() as f64, f64::from(self.side).powi(2));
        let (i, j) = (column((a.0 + b.0 + c.0) / 3), row((a.1 + b.1 + c.1) / 3));
        // A covered square in which no cell has its centre gets the colour of what covers it.
        let weight = if area < square { 1e-6 * area } else { square };
        if area < square {
            self.sums[j * self.columns + i].add(cell.density, area.max(0.5));
        }
        for j in low..=high {
            for i in first..=last {
                let half = self.side / 2;
                let m = (self.left + i as i32 * self.side + half, self.top + j as i32 * self.side + half);
                let inside = |v: i64| if twice < 0 { v <= 0 } else { v >= 0 };
                if twice != 0 && inside(cross(a, b, m)) && inside(cross(b, c, m)) && inside(cross(c, a, m)) {
                    let sum = &mut self.sums[j * self.columns + i];
                    sum.add(cell.density, weight);
                    sum.covered = true;
                }
            }
        }
    }

    /// The mean in a square, `None` if the bodies cover little of it.
    fn mean(&self, i: usize, j: usize) -> Option<f64> {
        let sum = &self.sums[j * self.columns + i];
        let enough = sum.covered || sum.weight > 0.6 * f64::from(self.side).powi(2);
        (enough && sum.weight > 0.0).then(|| sum.density / sum.weight)
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
}

fn squares(cells: &[Cell], position: impl Fn(f64) -> f64) -> String {
    let mut grid = Grid::over(cells);
    cells.iter().for_each(|cell| grid.add(cell));
    let mut paths = vec![String::new(); SHADES];
    for j in 0..grid.rows {
        let shades: Vec<Option<usize>> =
            (0..grid.columns).map(|i| grid.mean(i, j).map(|m| shade(position(m)))).collect();
        let mut i = 0;
        // Neighbours of one shade in a row make one rectangle.
        for run in shades.chunk_by(|a, b| a == b) {
            if let Some(k) = run[0] {
                let (x, y) = (grid.left + i as i32 * grid.side, grid.top + j as i32 * grid.side);
                let w = run.len() as i32 * grid.side;
                let _ = write!(paths[k], "M{x} {y}h{w}v{}h-{w}z", grid.side);
            }
            i += run.len();
        }
    }
    joined(&paths, 4)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_without_area_on_the_sheet_are_left_out() {
        let cell = |corners| Cell { corners, density: 1.0 };
        let flat = [(4, 4), (4, 4), (5, 4)];
        let drawn = [cell([(0, 0), (8, 0), (0, 8)]), cell(flat), cell([(1, 1), (2, 2), (3, 3)])];
        let text = elements(&drawn, |_| 0.5);
        assert!(text.contains("M0 0l8 0 -8 8z"), "{text}");
        // Once filled, once as a thin edge.
        assert_eq!(text.matches('M').count(), 2, "{text}");
    }
}
