//! Generators of structured meshes.

mod ball;
mod disc;
mod half_disc;
mod ring;
mod tube;

use super::{MeshError, TetMesh, TriMesh};
use crate::geometry::{Coordinates, Vector};
use crate::space::{Solid, Space};
use nalgebra::Vector3;

pub use ball::{BallPart, ball, ball_nodes};
pub use disc::{disc, disc_nodes};
pub use half_disc::{Facing, half_disc, half_disc_nodes};
pub use ring::ring;
pub use tube::tube;

/// Maximum number of cells of a generator: their triangles are as many as a mesh can have.
const MAX_CELLS: usize = (1 << 28) - 1;
/// Maximum number of nodes of a mesh.
const MAX_NODES: usize = (1 << 29) - 1;

/// Tells whether cells in two or three directions would be too many for a mesh.
fn too_many(cells: &[usize]) -> bool {
    let product =
        |extra: usize| cells.iter().fold(1, |all: usize, n| all.saturating_mul(n.saturating_add(extra)));
    // A rectangle is two triangles, a box six tetrahedra.
    let parts = if cells.len() > 2 { 3 } else { 1 };
    product(0).saturating_mul(parts) > MAX_CELLS || product(1) > MAX_NODES
}

/// Checks what a rectangle or a box is made of.
fn check<V: Coordinates>(origin: &V, size: &V, cells: &[usize]) -> Result<(), MeshError> {
    let fault = |reason| {
        let [origin, size] = [origin, size].map(|v| v.entries().to_vec());
        Err(MeshError::Block { origin, size, cells: cells.to_vec(), reason })
    };
    if !origin.is_finite() {
        return fault("the origin must be finite");
    }
    if !(size.is_finite() && size.entries().iter().all(|s| *s > 0.0)) {
        return fault(if cells.len() > 2 {
            "all sizes must be positive and finite"
        } else {
            "both sizes must be positive and finite"
        });
    }
    if cells.contains(&0) {
        return fault("at least one cell is needed in each direction");
    }
    if too_many(cells) {
        return fault("more than 2^28 - 1 cells or 2^29 - 1 nodes");
    }
    Ok(())
}

/// Meshes the rectangle `origin + [0, size_x] × [0, size_y]` with `cells[0] × cells[1]` rectangles,
/// each cut from its lower left to its upper right corner.
///
/// Node `(i, j)` has the number `j (cells_x + 1) + i` and lies at `origin + size · (i, j)/cells`, the
/// last exactly at `origin + size`. The sides are named `bottom`, `right`, `top` and `left`.
///
/// # Errors
/// A size that is not positive and finite, no cells, or more than the limits of a mesh: 2²⁸ − 1 cells, 2²⁹ − 1 nodes.
pub fn block(
    origin: impl Into<Vector>,
    size: impl Into<Vector>,
    cells: [usize; 2],
) -> Result<TriMesh, MeshError> {
    let (origin, size) = (origin.into(), size.into());
    check(&origin, &size, &cells)?;
    let [nx, ny] = cells;
    let coordinate = |c: usize, k: usize| {
        if k == cells[c] { origin[c] + size[c] } else { origin[c] + size[c] * k as f64 / cells[c] as f64 }
    };
    let node = |i: usize, j: usize| (j * (nx + 1) + i) as u32;
    let mut points = Vec::with_capacity((nx + 1) * (ny + 1));
    for j in 0..=ny {
        for i in 0..=nx {
            points.push(Vector::new(coordinate(0, i), coordinate(1, j)));
        }
    }
    let mut triangles = Vec::with_capacity(2 * nx * ny);
    for j in 0..ny {
        for i in 0..nx {
            let [a, b, c, d] = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
            triangles.push([a, b, c]);
            triangles.push([a, c, d]);
        }
    }
    let horizontal = |j: usize| (0..nx).map(|i| [node(i, j), node(i + 1, j)]).collect();
    let vertical = |i: usize| (0..ny).map(|j| [node(i, j), node(i, j + 1)]).collect();
    let groups = vec![
        ("bottom".to_string(), horizontal(0)),
        ("right".to_string(), vertical(nx)),
        ("top".to_string(), horizontal(ny)),
        ("left".to_string(), vertical(0)),
    ];
    TriMesh::new(points, triangles, groups)
}

/// Meshes the box `origin + [0, size_x] × [0, size_y] × [0, size_z]` with boxes, each cut into the six tetrahedra around its diagonal
/// from the smallest to the largest coordinates.
///
/// Nodes are numbered along x first and along z last. The sides are named `left` and `right` (x), `front` and `back` (y), `bottom` and `top` (z).
///
/// # Errors
/// A size that is not positive and finite, no cells, or more than the limits of a mesh.
pub fn cuboid(
    origin: impl Into<Vector3<f64>>,
    size: impl Into<Vector3<f64>>,
    cells: [usize; 3],
) -> Result<TetMesh, MeshError> {
    /// The axes in the order in which the edges from the first corner of a tetrahedron to its last one follow them, and the order of the corners
    /// that gives a positive volume.
    const PATHS: [([usize; 3], [usize; 4]); 6] = {
        const EVEN: [usize; 4] = [0, 1, 2, 3];
        const ODD: [usize; 4] = [0, 2, 1, 3];
        [
            ([0, 1, 2], EVEN),
            ([1, 2, 0], EVEN),
            ([2, 0, 1], EVEN),
            ([0, 2, 1], ODD),
            ([1, 0, 2], ODD),
            ([2, 1, 0], ODD),
        ]
    };
    let (origin, size) = (origin.into(), size.into());
    check(&origin, &size, &cells)?;
    let steps = [1, cells[0] + 1, (cells[0] + 1) * (cells[1] + 1)];
    let places = |counts: [usize; 3]| {
        let [nx, ny, nz] = counts;
        (0..nz).flat_map(move |k| (0..ny).flat_map(move |j| (0..nx).map(move |i| [i, j, k])))
    };
    let coordinate = |c: usize, k: usize| {
        if k == cells[c] { origin[c] + size[c] } else { origin[c] + size[c] * k as f64 / cells[c] as f64 }
    };
    let points: Vec<Vector3<f64>> =
        places(cells.map(|n| n + 1)).map(|place| Vector3::from_fn(|c, _| coordinate(c, place[c]))).collect();
    let mut tetrahedra = Vec::with_capacity(6 * cells.iter().product::<usize>());
    let mut groups =
        ["left", "right", "front", "back", "bottom", "top"].map(|name| (name.to_owned(), Vec::new()));
    for place in places(cells) {
        let first: usize = place.iter().zip(steps).map(|(k, step)| k * step).sum();
        for ([a, b, c], order) in PATHS {
            let along = [0, steps[a], steps[a] + steps[b], steps[a] + steps[b] + steps[c]];
            let corners = order.map(|k| first + along[k]);
            tetrahedra.push(corners.map(|n| n as u32));
            for k in 0..4 {
                let facet = Solid::facet(k).map(|corner| corners[corner]);
                for axis in 0..3 {
                    let on = |end: usize| facet.iter().all(|n| n / steps[axis] % (cells[axis] + 1) == end);
                    for (side, end) in [(2 * axis, 0), (2 * axis + 1, cells[axis])] {
                        if on(end) {
                            groups[side].1.push(facet.map(|n| n as u32));
                        }
                    }
                }
            }
        }
    }
    TetMesh::new(points, tetrahedra, groups.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::id::NodeId;

    #[test]
    fn paper_mesh_has_190_nodes_and_exact_corners() {
        let m = block([0.0, 1.0], [2.0, 0.1], [18, 9]).unwrap();
        assert_eq!(m.points().len(), 190);
        assert_eq!(m.cells().len(), 324);
        assert_eq!(*m.points().last().unwrap(), Vector::new(2.0, 1.1));
        assert_eq!(m.group("top").unwrap().len(), 18);
        let area: f64 = (0..324).map(|t| m.measure(t)).sum();
        assert!((area - 0.2).abs() < 1e-15);
        // Euler: V − E + T = 1 for a disc.
        assert_eq!(190 - m.topology().facets().len() as i64 + 324, 1);
        for &e in m.group("top").unwrap() {
            assert_eq!(m.facet_normal(e), Vector::new(0.0, 1.0));
        }
    }

    #[test]
    fn impossible_blocks_are_refused() {
        assert!(block([0.0, 0.0], [1.0, 0.0], [1, 1]).is_err());
        assert!(block([0.0, 0.0], [1.0, 1.0], [0, 1]).is_err());
        // One triangle or node more than a mesh can have is detected before the mesh is made.
        for cells in [[usize::MAX, 2], [1 << 14, 1 << 14], [1, (1 << 28) - 1]] {
            let e = block([0.0, 0.0], [1.0, 1.0], cells).unwrap_err();
            assert!(matches!(e, MeshError::Block { .. }), "{e}");
        }
        assert!(block([f64::NAN, 0.0], [1.0, 1.0], [1, 1]).is_err());
    }

    #[test]
    fn a_box_of_tetrahedra_is_closed_and_has_its_volume() {
        let mesh = cuboid([0.3, -1.0, 2.0], [2.0, 1.0, 0.5], [4, 3, 2]).unwrap();
        assert_eq!((mesh.points().len(), mesh.cells().len(), mesh.turned()), (5 * 4 * 3, 6 * 4 * 3 * 2, 0));
        let volume: f64 = (0..mesh.cells().len()).map(|t| mesh.measure(t)).sum();
        assert!((volume - 1.0).abs() < 1e-14);
        // The boundary is closed: no resultant, and ∮ x·n dA = 3 V.
        let (mut sum, mut thrice) = (Vector3::zeros(), 0.0);
        for &facet in mesh.topology().boundary_facets() {
            let area = mesh.facet_normal(facet) * mesh.facet_measure(facet);
            sum += area;
            thrice += mesh.facet_middle(facet).dot(&area);
        }
        assert!(sum.norm() < 1e-14 && (thrice - 3.0).abs() < 1e-13);
        // Euler: V − E + F − C = 1 for a ball.
        let edges = mesh.topology().node_neighbours().1.len() / 2;
        let [v, f, c] = [mesh.points().len(), mesh.topology().facets().len(), mesh.cells().len()];
        assert_eq!(v + f, 1 + edges + c);
        for (name, normal, area, facets) in [
            ("left", -Vector3::x(), 0.5, 12),
            ("right", Vector3::x(), 0.5, 12),
            ("front", -Vector3::y(), 1.0, 16),
            ("back", Vector3::y(), 1.0, 16),
            ("bottom", -Vector3::z(), 2.0, 24),
            ("top", Vector3::z(), 2.0, 24),
        ] {
            let group = mesh.group(name).unwrap();
            assert_eq!(group.len(), facets, "{name}");
            assert!((group.iter().map(|f| mesh.facet_measure(*f)).sum::<f64>() - area).abs() < 1e-14);
            assert!(group.iter().all(|f| (mesh.facet_normal(*f) - normal).norm() < 1e-15), "{name}");
        }
    }

    #[test]
    fn faults_of_tetrahedra_are_named() {
        let unit = || -> Vec<[f64; 3]> {
            vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 1.0]]
        };
        // Either order of the nodes is accepted.
        let turned = TetMesh::new(unit(), vec![[0u32, 2, 1, 3], [1, 2, 3, 4]], vec![]).unwrap();
        assert_eq!(turned.turned(), 1);
        assert_eq!(turned.cells()[0], [0, 1, 2, 3].map(NodeId::new));
        // Two tetrahedra on the same side of a face.
        let fault = |points, cells: Vec<[u32; 4]>| TetMesh::new(points, cells, vec![]).unwrap_err();
        let both = fault(unit(), vec![[0, 1, 2, 3], [0, 1, 2, 4]]);
        assert!(matches!(both, MeshError::NonManifold { ref nodes, .. } if *nodes == [0, 1, 2]), "{both}");
        // Two that share an edge only.
        let mut edge = unit();
        edge.extend([[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]);
        edge.remove(4);
        let pinched = fault(edge, vec![[0, 1, 2, 3], [0, 3, 4, 5]]);
        assert!(matches!(pinched, MeshError::BowTie { node: 0, .. }), "{pinched}");
        let flat =
            fault(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.3, 0.3, 0.0]], vec![[0, 1, 2, 3]]);
        assert!(
            flat.to_string().starts_with("tetrahedron 0 at (0.325, 0.325, 0) has the signed volume 0e0"),
            "{flat}"
        );
    }
}
