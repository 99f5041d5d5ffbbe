//! Finds cells that overlap: a mesh may be valid edge by edge and still cover an area twice.

use super::TriMesh;
use crate::geometry::{self, Vector, clipped, cross, norm};
use rayon::prelude::*;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

/// Overlaps narrower than this fraction of the mesh's diagonal are rounding of coordinates: the cells touch.
const WIDTH: f64 = 1e-6;
/// An overlap that covers this fraction of the smaller cell counts, however small the cell is.
const PART: f64 = 0.01;
/// Triangles whose common box is compared with the cells first.
const TOGETHER: usize = 64;

/// Two cells that overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct CellOverlap {
    /// The two triangles, from 0: in one mesh the smaller number first, for two meshes one number of each mesh.
    pub triangles: [usize; 2],
    /// A point of both, m.
    pub point: Vector,
    /// Common area, m².
    pub area: f64,
}

impl TriMesh {
    /// Finds the two cells with the smallest numbers that overlap by more than rounding of their coordinates;
    /// `None` if there is no overlap. Cells that touch along a line, such as the two faces of a slit, do not overlap.
    ///
    /// Only cells at the boundary are compared with the others. The number of cells over a point is the winding
    /// number of the boundary there, so it changes only across boundary edges. If its maximum is above one, a
    /// boundary edge bounds the region of the maximum, and the cell inside that edge overlaps another.
    ///
    /// The time is proportional to `T log B` for `T` cells, `B` of them at the boundary.
    pub fn overlapping_cells(&self) -> Option<CellOverlap> {
        let topology = self.topology();
        let boundary = topology.boundary_facets();
        let mut outer: Vec<u32> = boundary.iter().map(|&e| topology.facet_cells()[e][0]).collect();
        outer.sort_unstable();
        outer.dedup();
        let tree = tree(self, &outer);
        let width = WIDTH * self.diagonal();
        first_near(&tree, self, |t| {
            let near = overlapping(&tree, self, self.corners(t), width);
            let found = near.filter(|found| found.0 != t).map(|(other, point, area)| CellOverlap {
                triangles: [t.min(other), t.max(other)],
                point,
                area,
            });
            found.min_by_key(|found| found.triangles)
        })
    }

    /// Finds one of the given cells that overlaps a cell of another mesh by more than rounding of their coordinates.
    ///
    /// * `cells`: triangles of this mesh.
    pub fn overlap_with(&self, cells: &[u32], other: &Self) -> Option<CellOverlap> {
        let tree = tree(self, cells);
        let width = WIDTH * self.diagonal().min(other.diagonal());
        first_near(&tree, other, |t| {
            let near = overlapping(&tree, self, other.corners(t), width);
            let found = near.map(|(own, point, area)| CellOverlap { triangles: [own, t], point, area });
            found.min_by_key(|found| found.triangles)
        })
    }
}

/// Returns what is found first among the triangles of a mesh that are near the cells of a tree.
fn first_near(
    tree: &RTree<Cell>,
    mesh: &TriMesh,
    found: impl Fn(usize) -> Option<CellOverlap> + Sync,
) -> Option<CellOverlap> {
    let count = mesh.cells().len();
    (0..count.div_ceil(TOGETHER)).into_par_iter().find_map_first(|k| {
        let together = k * TOGETHER..count.min((k + 1) * TOGETHER);
        // Neighbours have numbers near each other: most of these boxes are away from all cells of the tree.
        let corners: Vec<Vector> = together.clone().flat_map(|t| mesh.corners(t)).collect();
        let mut near = tree.locate_in_envelope_intersecting(&envelope(&corners));
        near.next().and_then(|_| together.into_iter().find_map(&found))
    })
}

/// A cell by its bounding box.
pub(super) type Cell = GeomWithData<Rectangle<[f64; 2]>, usize>;

pub(super) fn tree(mesh: &TriMesh, cells: &[u32]) -> RTree<Cell> {
    let boxes = cells.iter().map(|&t| {
        let [low, high] = geometry::bounding_box(&mesh.corners(t as usize)).map(Into::into);
        GeomWithData::new(Rectangle::from_corners(low, high), t as usize)
    });
    RTree::bulk_load(boxes.collect())
}

pub(super) fn envelope(points: &[Vector]) -> AABB<[f64; 2]> {
    let [low, high] = geometry::bounding_box(points).map(Into::into);
    AABB::from_corners(low, high)
}

/// Lists the cells of a tree that overlap a triangle: number, a common point and the common area.
fn overlapping<'a>(
    tree: &'a RTree<Cell>,
    mesh: &'a TriMesh,
    corners: [Vector; 3],
    width: f64,
) -> impl Iterator<Item = (usize, Vector, f64)> + 'a {
    let near = tree.locate_in_envelope_intersecting(&envelope(&corners));
    near.filter_map(move |cell| {
        let (point, area) = common(corners, mesh.corners(cell.data), width)?;
        Some((cell.data, point, area))
    })
}

/// Computes the polygon that two triangles have in common, relative to the first corner of the first one.
pub(super) fn intersection(a: [Vector; 3], b: [Vector; 3]) -> Option<Vec<Vector>> {
    // So points far from the origin lose no digits.
    let [a, b] = [a, b].map(|t| t.map(|p| p - a[0]));
    let mut polygon = a.to_vec();
    for k in 0..3 {
        let (from, along) = (b[k], b[(k + 1) % 3] - b[k]);
        polygon = clipped(&polygon, |p| cross(along, p - from));
        if polygon.len() < 3 {
            return None;
        }
    }
    Some(polygon)
}

/// Computes the centroid and the area of the intersection of two triangles, if it is wider than `width`.
fn common(a: [Vector; 3], b: [Vector; 3], width: f64) -> Option<(Vector, f64)> {
    let polygon = intersection(a, b)?;
    let (mut area, mut moment, mut extent) = (0.0, Vector::zeros(), 0.0f64);
    let first = polygon[0];
    for pair in polygon[1..].windows(2) {
        let [u, v] = [pair[0] - first, pair[1] - first];
        let part = 0.5 * cross(u, v);
        area += part;
        moment += part / 3.0 * (u + v);
    }
    for (k, p) in polygon.iter().enumerate() {
        extent = polygon[..k].iter().fold(extent, |e, q| e.max(norm(*p - *q)));
    }
    let smaller = geometry::signed_area(a).min(geometry::signed_area(b));
    let counts = area > width * extent || area > PART * smaller;
    (counts && area > 0.0).then(|| (a[0] + (first + 1.0 / area * moment), area))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::generate::block;
    use crate::mesh::id::NodeId;

    /// Several meshes as one, without common nodes.
    fn together(parts: &[(Vec<Vector>, Vec<[NodeId; 3]>)]) -> TriMesh {
        let (mut points, mut cells) = (Vec::new(), Vec::new());
        for (p, t) in parts {
            let first = points.len();
            points.extend_from_slice(p);
            cells.extend(t.iter().map(|t| t.map(|n| NodeId::new(n.index() + first))));
        }
        TriMesh::new(points, cells, Vec::new()).unwrap()
    }

    fn piece(origin: [f64; 2], size: [f64; 2], cells: [usize; 2]) -> (Vec<Vector>, Vec<[NodeId; 3]>) {
        let mesh = block(origin, size, cells).unwrap();
        (mesh.points().to_vec(), mesh.cells().to_vec())
    }

    #[test]
    fn a_piece_inside_another_is_found_wherever_it_lies() {
        for far in [0.0, 1e9] {
            for (shift, size) in
                [([0.52, 0.51], 1e-3), ([0.9, 0.9], 3.0), ([-1.0, 0.3], 1.2), ([-3.0, -3.0], 9.0)]
            {
                let main = piece([far, 0.0], [1.0, 1.0], [12, 7]);
                let other = piece([far + shift[0], shift[1]], [size, size], [1, 1]);
                let found = together(&[main, other]).overlapping_cells();
                let found = found.unwrap_or_else(|| panic!("nothing found at {far} {shift:?}"));
                assert!(found.area > 0.0 && found.triangles[1] >= 168, "{found:?}");
                let [x, y] = [found.point[0] - far, found.point[1]];
                assert!((0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&y), "{found:?}");
            }
        }
    }

    #[test]
    fn a_piece_of_one_mesh_inside_another_mesh_is_found() {
        let (main, extra) = (piece([0.0, 1.0], [1.0, 1.0], [4, 4]), piece([0.3, 0.4], [0.3, 0.3], [1, 1]));
        let upper = together(&[main, extra]);
        let lower = block([0.0, 0.0], [1.0, 1.0], [5, 5]).unwrap();
        let found = upper.overlap_with(&[32, 33], &lower).unwrap();
        assert!(found.triangles[0] >= 32 && found.point[1] < 0.7, "{found:?}");
        // The other cells only touch.
        let others: Vec<u32> = (0..32).collect();
        assert_eq!(upper.overlap_with(&others, &lower), None);
    }

    #[test]
    fn cells_that_touch_do_not_overlap() {
        // Side by side, nodes against edges: the faces of a slit, rounded to seven digits.
        let left = || piece([0.0, 0.0], [0.333_333_3, 1.0], [3, 7]);
        for third in [1.0 / 3.0, 0.333_333_3] {
            let right = piece([third, 0.0], [1.0 - third, 1.0], [5, 11]);
            let mesh = together(&[left(), right]);
            assert_eq!(mesh.overlapping_cells(), None, "{third}");
        }
        let overlapping = piece([0.3333, 0.0], [0.6, 1.0], [5, 11]);
        assert!(together(&[left(), overlapping]).overlapping_cells().is_some());
        // A turned mesh, whose coordinates are rounded, and one far away.
        let mesh = block([0.0, 0.0], [3.0, 1.0], [40, 20]).unwrap();
        for (angle, far) in [(0.0f64, 0.0), (0.7, 0.0), (0.7, 1e6), (2.0, -1e9)] {
            let (s, c) = angle.sin_cos();
            let turned = mesh.points().iter().map(|p| [c * p[0] - s * p[1] + far, s * p[0] + c * p[1]]);
            let turned = TriMesh::new(turned.collect(), mesh.cells().to_vec(), Vec::new()).unwrap();
            assert_eq!(turned.overlapping_cells(), None, "{angle} {far}");
        }
    }

    #[test]
    fn a_strip_that_winds_over_itself_is_found() {
        // A ring of 400 degrees: every edge joins two cells at most, and the last 40 degrees lie over the first.
        let strip = |turn: f64, cells: u32| {
            let at = |r: f64, k: u32| {
                let (s, c) = (turn * f64::from(k) / f64::from(cells)).to_radians().sin_cos();
                [r * c, r * s]
            };
            let points = (0..=cells).flat_map(|k| [at(1.0, k), at(2.0, k)]).collect();
            let pair = |k: u32| [[2 * k, 2 * k + 1, 2 * k + 3], [2 * k, 2 * k + 3, 2 * k + 2]];
            TriMesh::new(points, (0..cells).flat_map(pair).collect(), Vec::new()).unwrap()
        };
        assert_eq!(strip(359.0, 36).overlapping_cells(), None);
        assert!(strip(400.0, 36).overlapping_cells().is_some());
    }
}
