//! The names of the deformed bodies, beside the panel or above it.

use super::axis::extent;
use super::cells::Cell;
use super::colour::INK;
use super::sheet::{self, FINE, Frame, PIXEL, SMALL, Sheet, Words, path};
use fem_core::geometry::{Vector, norm};

/// Room between the panel and the sheet's right edge for the bodies' names.
pub(super) const BESIDE: f64 = 84.0 * PIXEL;
/// Room above the panel for names of bodies side by side.
pub(super) const ABOVE: f64 = 24.0 * PIXEL;
/// Room between the panel and a name beside it, and behind the name.
const SPACE: f64 = 6.0 * PIXEL;
/// Distance of names from each other, one below and one beside the other.
const APART: [f64; 2] = [18.0 * PIXEL, 10.0 * PIXEL];
/// Size to which names shrink before they are cut.
const LEAST: f64 = 10.0 * PIXEL;
/// The part of the lower body's height that two bodies share if they are at the same height.
const SHARED: f64 = 0.3;

/// A name with what is drawn of its body.
struct Named<'a> {
    name: &'a str,
    cells: &'a [Cell],
    /// The extent of the cells in both directions.
    extents: [(f64, f64); 2],
}

impl Named<'_> {
    fn middle(&self, c: usize) -> f64 {
        0.5 * (self.extents[c].0 + self.extents[c].1)
    }
}

/// Writes the bodies' names beside the panel at the height of each, or above it for bodies side by side.
pub(super) fn names(sheet: &mut Sheet, frame: Frame, bodies: &[(&str, Vec<Cell>)]) {
    let named = bodies.iter().filter_map(|(name, cells)| {
        let [x, y] = [0, 1].map(|c| extent(cells.iter().flat_map(|cell| cell.corners.map(|p| p[c]))));
        Some(Named { name, cells, extents: [x?, y?] })
    });
    let mut named: Vec<Named<'_>> = named.collect();
    let spread = |c: usize| extent(named.iter().map(|n| n.middle(c))).map_or(0.0, |e| e.1 - e.0);
    // To a pixel: both spreads of nested bodies are 0.
    let beside = spread(1) + PIXEL >= spread(0);
    let along = usize::from(beside);
    named.sort_by(|a, b| a.middle(along).total_cmp(&b.middle(along)));
    let nested = nested(&named);
    let room = if beside { BESIDE - 2.0 * SPACE } else { frame.width / bodies.len().max(1) as f64 };
    let mut free = f64::NEG_INFINITY;
    for body in &named {
        let name = sheet::cut(body.name, LEAST, room);
        let size = sheet::fitting(&name, SMALL, room);
        if beside {
            let at = [frame.right() + 1.3 * SPACE, body.middle(1).max(free)];
            Words::new(size).flush_left().write(sheet, &name, at);
            if nested {
                leader(sheet, body.cells, Vector::new(at[0] - 2.0 * PIXEL, at[1]));
            }
            free = at[1] + APART[0];
        } else {
            let half = 0.5 * sheet::width_of(&name, size);
            let x = body.middle(0).max(free + half).max(half + PIXEL);
            Words::new(size).write(sheet, &name, [x, frame.top - 13.0 * PIXEL]);
            free = x + half + APART[1];
        }
    }
}

/// Says whether bodies are at the same height, so that a name beside the panel may be that of either.
fn nested(named: &[Named<'_>]) -> bool {
    let heights = || named.iter().map(|n| n.extents[1]).enumerate();
    heights().any(|(k, a)| {
        heights().take(k).any(|(_, b)| {
            let shared = a.1.min(b.1) - a.0.max(b.0);
            shared > SHARED * (a.1 - a.0).min(b.1 - b.0)
        })
    })
}

/// Draws a line from a name to the nearest cell of its body, which gets a dot.
fn leader(sheet: &mut Sheet, cells: &[Cell], from: Vector) {
    let far = |p: &Vector| norm(*p - from);
    if let Some(to) = cells.iter().map(Cell::middle).min_by(|p, q| far(p).total_cmp(&far(q))) {
        sheet.stroke(&path(&[from, to]), INK, FINE);
        sheet.disc(to, 2.0 * PIXEL, INK);
    }
}

#[cfg(test)]
mod tests {
    use crate::plot::{BodyPicture, deformed};
    use fem_core::geometry::Vector;
    use fem_core::mesh::TriMesh;

    #[test]
    fn bodies_at_one_height_have_lines_from_their_names() {
        let dots = |offset: [f64; 2]| {
            let low = [[0.0, 0.0], [4.0, 0.0], [0.0, 2.0]];
            let high = low.map(|[x, y]| [x + offset[0], y + offset[1]]);
            let [low, high] = [low, high]
                .map(|p| TriMesh::new(p.map(Vector::from).to_vec(), vec![[0, 1, 2]], vec![]).unwrap());
            let rest = [Vector::zeros(); 3];
            let body = |name, mesh| BodyPicture { name, mesh, displacement: &rest, density: &[1.0] };
            let svg = deformed("Two", &[body("low", &low), body("high", &high)], &[], &[]);
            assert!(svg.contains("low") && svg.contains("high"));
            svg.matches("<circle").count()
        };
        assert_eq!(dots([0.0, 2.0]), 0);
        assert_eq!(dots([0.0, 0.5]), 2);
    }
}
