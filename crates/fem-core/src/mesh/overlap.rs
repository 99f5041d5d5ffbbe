//! Finds cells that overlap: a mesh may be valid facet by facet and still cover a place twice.

use super::Mesh;
use crate::geometry::{self, norm};
use crate::space::{Plane, Space};
use rayon::prelude::*;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

/// Overlaps narrower than this fraction of the mesh's diagonal are rounding of coordinates: the cells touch.
const WIDTH: f64 = 1e-6;
/// An overlap that covers this fraction of the smaller cell counts, however small the cell is.
const PART: f64 = 0.01;
/// Boxes that have less than this fraction of their smaller extent in common hold no overlap that counts as a part.
const THIN: f64 = 1e-3;
/// Cells whose common box is compared with the other cells first.
const TOGETHER: usize = 64;

/// Two cells that overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct CellOverlap<S: Space = Plane> {
    /// The two cells, from 0: in one mesh the smaller number first, for two meshes one number of each mesh.
    pub cells: [usize; 2],
    /// A point of both, m.
    pub point: S::Vector,
    /// The measure of their common part, m² or m³.
    pub measure: f64,
}

impl<S: Space> Mesh<S> {
    /// Finds the two cells with the smallest numbers that overlap by more than rounding of their coordinates;
    /// `None` if there is no overlap. Cells that touch, such as the two faces of a slit, do not overlap.
    ///
    /// Only cells at the boundary are compared with the others. The number of cells over a point is the winding
    /// number of the boundary there, so it changes only across boundary facets. If its maximum is above one, a
    /// boundary facet bounds the region of the maximum, and the cell inside that facet overlaps another.
    ///
    /// The time is proportional to `T log B` for `T` cells, `B` of them at the boundary.
    pub fn overlapping_cells(&self) -> Option<CellOverlap<S>> {
        let topology = self.topology();
        let boundary = topology.boundary_facets();
        let mut outer: Vec<u32> = boundary.iter().map(|&e| topology.facet_cells()[e][0]).collect();
        outer.sort_unstable();
        outer.dedup();
        let tree = tree(self, &outer);
        let width = WIDTH * self.diagonal();
        first_near(&tree, self, |t| {
            let facets = topology.cell_facets()[t];
            let is_outer = facets.into_iter().any(|f| topology.is_boundary(f));
            // Of two cells at the boundary the first one finds the other. Neighbours lie on different sides of their facet.
            let is_left_out = |other: usize| {
                is_outer && other <= t
                    || facets.into_iter().any(|f| topology.facet_cells()[f].contains(&(other as u32)))
            };
            let near = overlapping(&tree, self, self.corners(t), width, is_left_out);
            let found = near
                .map(|found| CellOverlap { cells: [t.min(found.cells[0]), t.max(found.cells[0])], ..found });
            found.min_by_key(|found| found.cells)
        })
    }

    /// Finds one of the given cells that overlaps a cell of another mesh by more than rounding of their coordinates.
    ///
    /// * `cells`: numbers of cells of this mesh.
    pub fn overlap_with(&self, cells: &[u32], other: &Self) -> Option<CellOverlap<S>> {
        let tree = tree(self, cells);
        let width = WIDTH * self.diagonal().min(other.diagonal());
        first_near(&tree, other, |t| {
            let near = overlapping(&tree, self, other.corners(t), width, |_| false);
            let found = near.map(|found| CellOverlap { cells: [found.cells[0], t], ..found });
            found.min_by_key(|found| found.cells)
        })
    }
}

/// Returns what is found first among the cells of a mesh that are near the cells of a tree.
fn first_near<S: Space>(
    tree: &CellBoxes<S>,
    mesh: &Mesh<S>,
    found: impl Fn(usize) -> Option<CellOverlap<S>> + Sync,
) -> Option<CellOverlap<S>> {
    let count = mesh.cells().len();
    (0..count.div_ceil(TOGETHER)).into_par_iter().find_map_first(|k| {
        let together = k * TOGETHER..count.min((k + 1) * TOGETHER);
        // Neighbours have numbers near each other: most of these boxes are away from all cells of the tree.
        let corners: Vec<S::Vector> = together.clone().flat_map(|t| mesh.corners(t)).collect();
        let mut near = tree.locate_in_envelope_intersecting(&envelope::<S>(&corners));
        near.next().and_then(|_| together.into_iter().find_map(&found))
    })
}

/// A cell by its bounding box.
pub(super) type CellBox<S> = GeomWithData<Rectangle<<S as Space>::Place>, usize>;

/// Cells by their boxes.
pub(super) type CellBoxes<S> = RTree<CellBox<S>>;

pub(super) fn tree<S: Space>(mesh: &Mesh<S>, cells: &[u32]) -> CellBoxes<S> {
    let boxes = cells.iter().map(|&t| {
        let [low, high] = geometry::bounding_box(mesh.corners(t as usize).as_ref()).map(S::place);
        GeomWithData::new(Rectangle::from_corners(low, high), t as usize)
    });
    RTree::bulk_load(boxes.collect())
}

pub(super) fn envelope<S: Space>(points: &[S::Vector]) -> AABB<S::Place> {
    let [low, high] = geometry::bounding_box(points).map(S::place);
    AABB::from_corners(low, high)
}

/// Lists the cells of a tree that overlap another cell.
///
/// * `is_left_out`: the cells that are not looked at.
fn overlapping<'a, S: Space>(
    tree: &'a CellBoxes<S>,
    mesh: &'a Mesh<S>,
    corners: S::Corners<S::Vector>,
    width: f64,
    is_left_out: impl Fn(usize) -> bool + 'a,
) -> impl Iterator<Item = CellOverlap<S>> + 'a {
    let [low, high] = geometry::bounding_box(corners.as_ref());
    let near = tree.locate_in_envelope_intersecting(&envelope::<S>(corners.as_ref()));
    near.filter_map(move |cell| {
        let other = mesh.corners(cell.data);
        let [other_low, other_high] = geometry::bounding_box(other.as_ref());
        let is_thin = (0..S::DIM).any(|c| {
            let least = (high[c] - low[c]).min(other_high[c] - other_low[c]);
            high[c].min(other_high[c]) - low[c].max(other_low[c]) < width.min(THIN * least)
        });
        if is_thin || is_left_out(cell.data) {
            return None;
        }
        let (point, measure) = common::<S>(corners, other, width)?;
        Some(CellOverlap { cells: [cell.data; 2], point, measure })
    })
}

/// Cuts the common part of two cells into cells, relative to the first corner of the first one: so points far from the origin lose no digits.
pub(super) fn common_part<S: Space>(
    a: S::Corners<S::Vector>,
    b: S::Corners<S::Vector>,
) -> Vec<S::Corners<S::Vector>> {
    S::common_part(&S::corners(|k| a[k] - a[0]), &S::corners(|k| b[k] - a[0]))
}

/// Computes the centroid and the measure of the common part of two cells, if it is wider than `width`.
fn common<S: Space>(
    a: S::Corners<S::Vector>,
    b: S::Corners<S::Vector>,
    width: f64,
) -> Option<(S::Vector, f64)> {
    let parts = common_part::<S>(a, b);
    let first = parts.first()?[0];
    let (mut measure, mut moment, mut extent) = (0.0, S::Vector::default(), 0.0f64);
    for part in &parts {
        let of_part = S::measure(part);
        measure += of_part;
        let arms: S::Vector = part.into_iter().map(|p| p - first).sum();
        moment += arms * (of_part / (S::DIM + 1) as f64);
    }
    let is_wide = |extent: f64| measure > width * extent.powi(S::DIM as i32 - 1);
    let is_large = measure > PART * S::measure(&a).min(S::measure(&b));
    // Nearly all common parts are rounding, and thin already for a part of their extent.
    let points: Vec<S::Vector> = parts.iter().flat_map(|part| *part).collect();
    let from_first = points.iter().map(|p| norm(*p - first)).fold(0.0, f64::max);
    if !is_large && is_wide(from_first) {
        for (k, p) in points.iter().enumerate() {
            extent = points[..k].iter().fold(extent, |e, q| e.max(norm(*p - *q)));
        }
    }
    let counts = is_large || is_wide(from_first.max(extent));
    (counts && measure > 0.0).then(|| (a[0] + (first + moment / measure), measure))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vector;
    use crate::mesh::generate::{block, cuboid};
    use crate::mesh::id::NodeId;
    use crate::mesh::{TetMesh, TriMesh};
    use crate::space::Solid;
    use nalgebra::{Rotation3, Vector3};

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
                assert!(found.measure > 0.0 && found.cells[1] >= 168, "{found:?}");
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
        assert!(found.cells[0] >= 32 && found.point[1] < 0.7, "{found:?}");
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

    /// Boxes of tetrahedra as one mesh, without common nodes.
    fn boxes(all: &[([f64; 3], [f64; 3], [usize; 3])]) -> TetMesh {
        let (mut points, mut cells) = (Vec::new(), Vec::new());
        for (origin, size, counts) in all {
            let mesh = cuboid(*origin, *size, *counts).unwrap();
            let first = points.len();
            points.extend_from_slice(mesh.points());
            cells.extend(mesh.cells().iter().map(|t| t.map(|n| NodeId::new(n.index() + first))));
        }
        TetMesh::new(points, cells, Vec::new()).unwrap()
    }

    #[test]
    fn a_solid_piece_inside_another_is_found_wherever_it_lies() {
        for far in [0.0, 1e9] {
            for (at, size) in [
                ([0.52, 0.51, 0.3], 1e-3),
                ([0.9, 0.9, 0.9], 3.0),
                ([-1.0, 0.3, 0.2], 1.2),
                ([-3.0, -3.0, -3.0], 9.0),
            ] {
                let main = ([far, 0.0, 0.0], [1.0; 3], [7, 5, 4]);
                let mesh = boxes(&[main, ([far + at[0], at[1], at[2]], [size; 3], [1; 3])]);
                let found = mesh.overlapping_cells();
                let found = found.unwrap_or_else(|| panic!("nothing found at {far} {at:?}"));
                assert!(found.measure > 0.0 && found.cells[1] >= 840, "{found:?}");
                let [x, y, z] = [found.point[0] - far, found.point[1], found.point[2]];
                assert!([x, y, z].iter().all(|x| (0.0..=1.0).contains(x)), "{found:?}");
            }
        }
    }

    #[test]
    fn solid_cells_that_touch_do_not_overlap() {
        let whole = ([0.0; 3], [0.333_333_3, 1.0, 1.0], [2, 5, 4]);
        for third in [1.0 / 3.0, 0.333_333_3] {
            let right = ([third, 0.0, 0.0], [1.0 - third, 1.0, 1.0], [3, 7, 3]);
            assert_eq!(boxes(&[whole, right]).overlapping_cells(), None, "{third}");
        }
        let deep = ([0.3333, 0.0, 0.0], [0.6, 1.0, 1.0], [3, 7, 3]);
        assert!(boxes(&[whole, deep]).overlapping_cells().is_some());
        // Turned about an axis that is not a coordinate's, and far away.
        let mesh = cuboid([0.0; 3], [3.0, 1.0, 1.0], [12, 5, 4]).unwrap();
        for (angle, far) in [(0.7, 0.0), (0.7, 1e6), (2.0, -1e9)] {
            let turn = Rotation3::from_scaled_axis(Vector3::new(1.0, 2.0, 3.0).normalize() * angle);
            let turned = mesh.points().iter().map(|p| turn * p + Vector3::repeat(far)).collect::<Vec<_>>();
            let turned = TetMesh::new(turned, mesh.cells().to_vec(), Vec::new()).unwrap();
            assert_eq!(turned.overlapping_cells(), None, "{angle} {far}");
        }
    }

    #[test]
    fn the_common_parts_of_cells_cover_a_tetrahedron_once() {
        let mesh = cuboid([0.0; 3], [2.0, 1.0, 1.0], [5, 4, 3]).unwrap();
        let corners =
            [[0.13, 0.21, 0.1], [1.7, 0.3, 0.2], [0.9, 0.95, 0.3], [0.8, 0.5, 0.97]].map(Vector3::from);
        let parts = |t: usize| common_part::<Solid>(corners, mesh.corners(t));
        let volume: f64 = (0..mesh.cells().len()).flat_map(parts).map(|part| Solid::measure(&part)).sum();
        assert!((volume / Solid::measure(&corners) - 1.0).abs() < 1e-13, "{volume}");
    }
}
