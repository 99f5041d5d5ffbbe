//! Generators of structured meshes.

mod disc;
mod half_disc;
mod ring;

use super::{MeshError, TriMesh};
use crate::geometry::Vector;

pub use disc::{disc, disc_nodes};
pub use half_disc::{Facing, half_disc, half_disc_nodes};
pub use ring::ring;

/// Maximum number of cells of a generator: their triangles are as many as a mesh can have.
const MAX_CELLS: usize = (1 << 28) - 1;
/// Maximum number of nodes of a mesh.
const MAX_NODES: usize = (1 << 29) - 1;

/// Tells whether cells in two directions would be too many for a mesh.
fn too_many(cells: [usize; 2]) -> bool {
    let [a, b] = cells;
    let nodes = a.saturating_add(1).saturating_mul(b.saturating_add(1));
    a.saturating_mul(b) > MAX_CELLS || nodes > MAX_NODES
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
    let fault = |reason| MeshError::Block { origin: origin.into(), size: size.into(), cells, reason };
    if !(origin[0].is_finite() && origin[1].is_finite()) {
        return Err(fault("the origin must be finite"));
    }
    if !(size[0] > 0.0 && size[1] > 0.0 && size[0].is_finite() && size[1].is_finite()) {
        return Err(fault("both sizes must be positive and finite"));
    }
    let [nx, ny] = cells;
    if nx == 0 || ny == 0 {
        return Err(fault("at least one cell is needed in each direction"));
    }
    if too_many(cells) {
        return Err(fault("more than 2^28 - 1 cells or 2^29 - 1 nodes"));
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paper_mesh_has_190_nodes_and_exact_corners() {
        let m = block([0.0, 1.0], [2.0, 0.1], [18, 9]).unwrap();
        assert_eq!(m.points().len(), 190);
        assert_eq!(m.cells().len(), 324);
        assert_eq!(*m.points().last().unwrap(), Vector::new(2.0, 1.1));
        assert_eq!(m.group("top").unwrap().len(), 18);
        let area: f64 = (0..324).map(|t| m.area(t)).sum();
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
}
