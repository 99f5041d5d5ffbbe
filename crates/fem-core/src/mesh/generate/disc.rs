//! Full discs: rollers and pins.

use super::MAX_NODES;
use crate::geometry::Vector;
use crate::mesh::id::NodeId;
use crate::mesh::{MeshError, TriMesh};
use std::f64::consts::FRAC_PI_3;

/// Meshes a full disc with concentric rings of nodes: ring `k` has `6 k` of them, so that all cells have nearly the same size
/// and shape. The side is named `rim` and has `6·cells` edges.
///
/// * `centre`, `radius`: m.
/// * `cells`: rings from the centre to the rim.
/// * `start`: direction of the first node of each ring, degrees.
///
/// # Errors
/// Numbers that are not finite, a radius that is not positive, no cells, or more nodes than a mesh can have.
pub fn disc(centre: impl Into<Vector>, radius: f64, cells: usize, start: f64) -> Result<TriMesh, MeshError> {
    let centre = centre.into();
    let fault = |reason| Err(MeshError::Generator { kind: "disc", reason });
    if !(centre[0].is_finite() && centre[1].is_finite() && start.is_finite()) {
        return fault("the centre and the start must be finite");
    }
    if !(radius > 0.0 && radius.is_finite()) {
        return fault("the radius must be positive and finite");
    }
    if cells == 0 || disc_nodes(cells) > MAX_NODES as u64 {
        return fault("at least one cell is needed, and at most 2^29 - 1 nodes");
    }
    // Ring k begins after the centre and the rings inside it.
    let first = |k: usize| if k == 0 { 0 } else { 1 + 3 * k * (k - 1) };
    let mut points = vec![centre];
    for k in 1..=cells {
        let r = radius * k as f64 / cells as f64;
        for j in 0..6 * k {
            let angle = start.to_radians() + FRAC_PI_3 * j as f64 / k as f64;
            points.push(centre + r * Vector::new(angle.cos(), angle.sin()));
        }
    }
    let node = |k: usize, j: usize| NodeId::new(first(k) + if k == 0 { 0 } else { j % (6 * k) });
    let mut triangles = Vec::with_capacity(6 * cells * cells);
    for k in 1..=cells {
        for sector in 0..6 {
            let [inner, outer] = [sector * (k - 1), sector * k];
            for i in 0..k {
                triangles.push([node(k, outer + i), node(k, outer + i + 1), node(k - 1, inner + i)]);
            }
            for i in 0..k - 1 {
                triangles.push([node(k - 1, inner + i), node(k, outer + i + 1), node(k - 1, inner + i + 1)]);
            }
        }
    }
    let rim = (0..6 * cells).map(|j| [node(cells, j), node(cells, j + 1)]).collect();
    TriMesh::oriented(points, triangles, vec![("rim".to_string(), rim)])
}

/// Counts the nodes of [`disc`].
pub fn disc_nodes(cells: usize) -> u64 {
    let n = cells as u64;
    n.saturating_mul(n.saturating_add(1)).saturating_mul(3).saturating_add(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disc_is_whole_and_its_cells_are_alike() {
        let mesh = disc([1.0, -2.0], 0.5, 8, 30.0).unwrap();
        assert_eq!(mesh.points().len() as u64, disc_nodes(8));
        assert_eq!(mesh.group("rim").unwrap().len(), 48);
        assert_eq!(mesh.topology().boundary_facets().len(), 48);
        let area: f64 = (0..mesh.cells().len()).map(|t| mesh.measure(t)).sum();
        // The area of the polygon.
        let polygon = 24.0 * 0.25 * (FRAC_PI_3 / 8.0).sin();
        assert!((area - polygon).abs() < 1e-14, "{area} {polygon}");
        assert!(mesh.smallest_angle() > 35.0, "{}", mesh.smallest_angle());
        for faulty in
            [disc([f64::NAN, 0.0], 1.0, 1, 0.0), disc([0.0; 2], 0.0, 1, 0.0), disc([0.0; 2], 1.0, 0, 0.0)]
        {
            assert!(matches!(faulty, Err(MeshError::Generator { kind: "disc", .. })));
        }
    }
}
