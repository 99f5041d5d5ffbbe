//! Finds the cells of a mesh at a point, and those that meet a triangle.

use super::TriMesh;
use super::overlap::{Cell, envelope, intersection, tree};
use crate::geometry::{Vector, cross, norm};
use rstar::RTree;

/// Boxes among which the nearest cell of a point outside of the mesh is looked for.
const NEAREST: usize = 8;

/// The cells of a mesh by their boxes: a search takes `O(log T)` for `T` cells.
pub struct CellTree<'a> {
    mesh: &'a TriMesh,
    tree: RTree<Cell>,
}

/// A cell at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellAt {
    /// The triangle, from 0.
    pub triangle: usize,
    /// The barycentric coordinates of the point, which sum to one; negative ones if it is outside.
    pub weights: [f64; 3],
}

impl<'a> CellTree<'a> {
    /// Sorts the cells of a mesh.
    pub fn new(mesh: &'a TriMesh) -> Self {
        let all: Vec<u32> = (0..mesh.cells().len() as u32).collect();
        Self { mesh, tree: tree(mesh, &all) }
    }

    /// Returns the mesh.
    pub fn mesh(&self) -> &'a TriMesh {
        self.mesh
    }

    /// Lists the cells to which a point belongs, by ascending number.
    ///
    /// * `width`: how far outside the point may be of a line through two corners, m: coordinates in files have few digits.
    pub fn around(&self, point: Vector, width: f64) -> Vec<CellAt> {
        let margin = Vector::repeat(width);
        let near = self.tree.locate_in_envelope_intersecting(&envelope(&[point - margin, point + margin]));
        let belongs = |at: &CellAt| {
            let heights = self.heights(at.triangle);
            at.weights.iter().zip(heights).all(|(weight, height)| weight * height >= -width)
        };
        let mut found: Vec<CellAt> = near.map(|cell| self.at(cell.data, point)).filter(belongs).collect();
        found.sort_by_key(|at| at.triangle);
        found
    }

    /// Returns the heights of a triangle over the sides opposite to its corners, m.
    pub fn heights(&self, triangle: usize) -> [f64; 3] {
        let [a, b, c] = self.mesh.corners(triangle);
        let twice = cross(b - a, c - a);
        [norm(c - b), norm(a - c), norm(b - a)].map(|side| twice / side)
    }

    /// Finds the cell in which a point lies, or for a point outside of the mesh one that is near; `None` without cells.
    pub fn nearest(&self, point: Vector) -> Option<CellAt> {
        let deepest =
            |a: &CellAt, b: &CellAt| a.least().total_cmp(&b.least()).then(b.triangle.cmp(&a.triangle));
        self.around(point, 0.0).into_iter().max_by(deepest).or_else(|| {
            let near = self.tree.nearest_neighbor_iter(&[point[0], point[1]]).take(NEAREST);
            near.map(|cell| self.at(cell.data, point)).max_by(deepest)
        })
    }

    /// Lists the cells that meet a triangle, by ascending number, each with the common area, m².
    pub(crate) fn common_areas(&self, corners: [Vector; 3]) -> Vec<(usize, f64)> {
        let near = self.tree.locate_in_envelope_intersecting(&envelope(&corners));
        let common = |cell: &Cell| {
            let polygon = intersection(corners, self.mesh.corners(cell.data))?;
            let parts =
                polygon[1..].windows(2).map(|pair| 0.5 * cross(pair[0] - polygon[0], pair[1] - polygon[0]));
            Some((cell.data, parts.sum::<f64>())).filter(|(_, area)| *area > 0.0)
        };
        let mut found: Vec<(usize, f64)> = near.filter_map(common).collect();
        // The order of the tree is no order for a sum.
        found.sort_by_key(|(cell, _)| *cell);
        found
    }

    fn at(&self, triangle: usize, point: Vector) -> CellAt {
        let [a, b, c] = self.mesh.corners(triangle);
        let whole = cross(b - a, c - a);
        let (s, r) = (cross(point - a, c - a) / whole, cross(b - a, point - a) / whole);
        CellAt { triangle, weights: [1.0 - s - r, s, r] }
    }
}

impl CellAt {
    fn least(&self) -> f64 {
        self.weights.into_iter().fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::generate::block;

    #[test]
    fn cells_are_found_at_points_inside_and_outside() {
        let mesh = block([0.0, 0.0], [2.0, 1.0], [7, 5]).unwrap();
        let tree = CellTree::new(&mesh);
        for point in [[0.3, 0.4], [0.0, 0.0], [2.0, 1.0], [1.1, 1.0]].map(Vector::from) {
            let found = tree.nearest(point).unwrap();
            let corners = mesh.corners(found.triangle);
            let again: Vector = corners.iter().zip(found.weights).map(|(p, w)| w * p).sum();
            assert!(norm(again - point) < 1e-14 && found.least() >= -1e-12, "{found:?}");
        }
        // All six cells around an inner node.
        let inner = mesh.points()[9];
        assert_eq!(tree.around(inner, 0.0).len(), 6);
        assert_eq!(tree.around(Vector::new(2.1, 0.5), 0.09).len(), 0);
        // One of the row beside the point, and three of the rows above and below, whose lines are as near.
        assert_eq!(tree.around(Vector::new(2.1, 0.5), 0.11).len(), 4);
        let beside = tree.nearest(Vector::new(2.01, 0.5)).unwrap();
        assert!(mesh.corners(beside.triangle).iter().any(|p| p[0] == 2.0), "{beside:?}");
    }

    #[test]
    fn common_areas_cover_a_triangle_once() {
        let mesh = block([0.0, 0.0], [2.0, 1.0], [7, 5]).unwrap();
        let tree = CellTree::new(&mesh);
        let corners = [[0.13, 0.21], [1.7, 0.3], [0.9, 0.95]].map(Vector::from);
        let found = tree.common_areas(corners);
        let area: f64 = found.iter().map(|(_, area)| area).sum();
        assert!((area / crate::geometry::signed_area(corners) - 1.0).abs() < 1e-13, "{area}");
        assert!(found.windows(2).all(|w| w[0].0 < w[1].0));
    }
}
