//! Values at the nodes for figures: von Mises' stress of the recovered stress, and means of values that are constant in the cells.

use cre_estimator::{RecoveredStress, Recovery};
use fem_core::body::Body;
use fem_core::mesh::TriMesh;
use fem_core::mesh::id::NodeId;

/// Some triangles of a mesh with a value at each of their nodes.
#[derive(Clone, Debug)]
pub(crate) struct NodalPatch {
    /// The triangles.
    pub(crate) triangles: Vec<[NodeId; 3]>,
    /// One value for each node of the mesh; NaN at nodes that no triangle of the patch has.
    pub(crate) values: Vec<f64>,
}

/// Averages a value of the cells at the nodes of some of them: `v(n) = Σ |T| v(T) / Σ |T|` over the given cells at `n`. NaN at
/// nodes without such a cell.
pub(crate) fn averaged(
    mesh: &TriMesh,
    cells: impl Iterator<Item = usize>,
    value: impl Fn(usize) -> f64,
) -> Vec<f64> {
    let mut sums = vec![[0.0; 2]; mesh.points().len()];
    for t in cells {
        let (area, value) = (mesh.measure(t), value(t));
        for node in mesh.cells()[t] {
            let sum = &mut sums[node.index()];
            *sum = [sum[0] + area * value, sum[1] + area];
        }
    }
    sums.into_iter().map(|[sum, area]| sum / area).collect()
}

/// Lists von Mises' stress of the recovered stress at the nodes for each material separately, since stresses jump between materials; NaN at
/// nodes of other materials. `None` if the constants of a material do not say it.
pub(crate) fn von_mises_by_material<S: Recovery>(
    body: &Body<S>,
    stress: &RecoveredStress<S>,
) -> Option<Vec<Vec<f64>>> {
    let materials = body.materials().list();
    let temperature = |node: usize| body.temperature().get(node).copied().unwrap_or_default();
    let mut values = vec![vec![f64::NAN; body.mesh().points().len()]; materials.len()];
    for (node, material, stress) in stress.values() {
        values[material][node.index()] =
            S::von_mises(&materials[material], stress, temperature(node.index()))?;
    }
    Some(values)
}

/// Makes a patch of [`von_mises_by_material`] for each material.
pub(crate) fn von_mises(body: &Body, stress: &RecoveredStress) -> Option<Vec<NodalPatch>> {
    let mesh = body.mesh();
    let of_material =
        |material: usize| (0..mesh.cells().len()).filter(move |t| body.materials().index(*t) == material);
    let patch = |(material, values): (usize, Vec<f64>)| NodalPatch {
        triangles: of_material(material).map(|t| mesh.cells()[t]).collect(),
        values,
    };
    let all = von_mises_by_material(body, stress)?.into_iter().enumerate();
    Some(all.map(patch).filter(|patch| !patch.triangles.is_empty()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_have_the_mean_of_their_cells_by_area() {
        // Areas 1 and 3 with the values 2 and 6; the last point has no cell of the patch.
        let points = [[0.0, 0.0], [2.0, 0.0], [0.0, 1.0], [0.0, -3.0], [2.0, -3.0]];
        let triangles = vec![[0, 1, 2], [0, 3, 1], [1, 3, 4]];
        let mesh = TriMesh::new(points.to_vec(), triangles, vec![]).unwrap();
        let values = averaged(&mesh, 0..2, |t| [2.0, 6.0][t]);
        assert_eq!(values[..4], [5.0, 5.0, 2.0, 6.0]);
        assert!(values[4].is_nan());
    }
}
