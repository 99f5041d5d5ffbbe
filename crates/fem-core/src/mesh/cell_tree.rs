//! Finds the cells of a mesh at a point, and those that meet another cell.

use super::Mesh;
use super::overlap::{CellBox, CellBoxes, common_part, envelope, tree};
use crate::geometry::Coordinates;
use crate::space::{Plane, Space};

/// Boxes among which the nearest cell of a point outside of the mesh is looked for.
const NEAREST: usize = 8;

/// The cells of a mesh by their boxes: a search takes `O(log T)` for `T` cells.
pub struct CellTree<'a, S: Space = Plane> {
    mesh: &'a Mesh<S>,
    tree: CellBoxes<S>,
}

/// A cell at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellAt<S: Space = Plane> {
    /// Its number, from 0.
    pub cell: usize,
    /// The barycentric coordinates of the point, which sum to one; negative ones if it is outside.
    pub weights: S::Corners<f64>,
}

impl<'a, S: Space> CellTree<'a, S> {
    /// Sorts the cells of a mesh.
    pub fn new(mesh: &'a Mesh<S>) -> Self {
        let all: Vec<u32> = (0..mesh.cells().len() as u32).collect();
        Self { mesh, tree: tree(mesh, &all) }
    }

    /// Returns the mesh.
    pub fn mesh(&self) -> &'a Mesh<S> {
        self.mesh
    }

    /// Lists the cells to which a point belongs, by ascending number.
    ///
    /// * `width`: how far outside the point may be of a line or plane through a facet, m: coordinates in files have few digits.
    pub fn around(&self, point: S::Vector, width: f64) -> Vec<CellAt<S>> {
        let margin = S::Vector::of(|_| width);
        let near =
            self.tree.locate_in_envelope_intersecting(&envelope::<S>(&[point - margin, point + margin]));
        let belongs = |at: &CellAt<S>| {
            let heights = self.heights(at.cell);
            at.weights.into_iter().zip(heights).all(|(weight, height)| weight * height >= -width)
        };
        let mut found: Vec<CellAt<S>> = near.map(|cell| self.at(cell.data, point)).filter(belongs).collect();
        found.sort_by_key(|at| at.cell);
        found
    }

    /// Returns the heights of a cell over the facets opposite to its corners, m.
    pub fn heights(&self, cell: usize) -> S::Corners<f64> {
        let corners = self.mesh.corners(cell);
        let product = S::DIM as f64 * S::measure(&corners);
        S::corners(|k| {
            let opposite = S::facet((k + 1) % (S::DIM + 1));
            product / S::facet_measure(&S::axes(|i| corners[opposite[i]]))
        })
    }

    /// Finds the cell in which a point lies, or for a point outside of the mesh one that is near; `None` without cells.
    pub fn nearest(&self, point: S::Vector) -> Option<CellAt<S>> {
        let deepest =
            |a: &CellAt<S>, b: &CellAt<S>| a.least().total_cmp(&b.least()).then(b.cell.cmp(&a.cell));
        self.around(point, 0.0).into_iter().max_by(deepest).or_else(|| {
            let near = self.tree.nearest_neighbor_iter(&S::place(point)).take(NEAREST);
            near.map(|cell| self.at(cell.data, point)).max_by(deepest)
        })
    }

    /// Lists the cells that meet another cell, by ascending number, each with the measure of the common part, m² or m³.
    pub(crate) fn common_measures(&self, corners: S::Corners<S::Vector>) -> Vec<(usize, f64)> {
        let near = self.tree.locate_in_envelope_intersecting(&envelope::<S>(corners.as_ref()));
        let common = |cell: &CellBox<S>| {
            let parts = common_part::<S>(corners, self.mesh.corners(cell.data));
            Some((cell.data, parts.iter().map(S::measure).sum::<f64>())).filter(|(_, measure)| *measure > 0.0)
        };
        let mut found: Vec<(usize, f64)> = near.filter_map(common).collect();
        // The order of the tree is no order for a sum.
        found.sort_by_key(|(cell, _)| *cell);
        found
    }

    fn at(&self, cell: usize, point: S::Vector) -> CellAt<S> {
        let corners = self.mesh.corners(cell);
        let whole = S::measure(&corners);
        let mut weights =
            S::corners(|k| S::measure(&S::corners(|j| if j == k { point } else { corners[j] })) / whole);
        weights[0] = (1..=S::DIM).fold(1.0, |rest, k| rest - weights[k]);
        CellAt { cell, weights }
    }
}

impl<S: Space> CellAt<S> {
    fn least(&self) -> f64 {
        self.weights.into_iter().fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Vector, norm};
    use crate::mesh::generate::block;

    #[test]
    fn cells_are_found_at_points_inside_and_outside() {
        let mesh = block([0.0, 0.0], [2.0, 1.0], [7, 5]).unwrap();
        let tree = CellTree::new(&mesh);
        for point in [[0.3, 0.4], [0.0, 0.0], [2.0, 1.0], [1.1, 1.0]].map(Vector::from) {
            let found = tree.nearest(point).unwrap();
            let corners = mesh.corners(found.cell);
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
        assert!(mesh.corners(beside.cell).iter().any(|p| p[0] == 2.0), "{beside:?}");
    }

    #[test]
    fn common_measures_cover_a_triangle_once() {
        let mesh = block([0.0, 0.0], [2.0, 1.0], [7, 5]).unwrap();
        let tree = CellTree::new(&mesh);
        let corners = [[0.13, 0.21], [1.7, 0.3], [0.9, 0.95]].map(Vector::from);
        let found = tree.common_measures(corners);
        let area: f64 = found.iter().map(|(_, area)| area).sum();
        assert!((area / crate::geometry::signed_area(corners) - 1.0).abs() < 1e-13, "{area}");
        assert!(found.windows(2).all(|w| w[0].0 < w[1].0));
    }
}
