//! Values at the nodes from values that are constant in the cells: means weighted by the cells' areas.

use fem_core::body::Body;
use fem_core::mesh::TriMesh;
use fem_core::mesh::id::NodeId;
use fem_core::tensor::SymTensor2;

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
        let (area, value) = (mesh.area(t), value(t));
        for node in mesh.triangles()[t] {
            let sum = &mut sums[node.index()];
            *sum = [sum[0] + area * value, sum[1] + area];
        }
    }
    sums.into_iter().map(|[sum, area]| sum / area).collect()
}

/// Averages the stress of the cells at the nodes of a body, over all cells at a node: between materials it is a mean of
/// stresses that may jump.
pub(crate) fn stress(body: &Body, stress: &[SymTensor2]) -> Vec<SymTensor2> {
    averaged_stress(body, stress, |_| true)
}

/// Von Mises' stress of the averaged stress, for each material separately, since stresses jump between materials; `None` if the
/// constants of a material do not say it.
pub(crate) fn von_mises(body: &Body, stress: &[SymTensor2]) -> Option<Vec<NodalPatch>> {
    let mesh = body.mesh();
    let count = mesh.triangles().len();
    let mut materials: Vec<usize> = (0..count).map(|t| body.materials().index(t)).collect();
    materials.sort_unstable();
    materials.dedup();
    let patch = |material: usize| {
        let of = |t: &usize| body.materials().index(*t) == material;
        let first = (0..count).find(of)?;
        let nodal = averaged_stress(body, stress, |t| of(&t));
        let one = |s: SymTensor2| match s.xx.is_nan() {
            true => Some(f64::NAN),
            false => body.material(first).von_mises(s),
        };
        let values: Option<Vec<f64>> = nodal.into_iter().map(one).collect();
        Some(NodalPatch {
            triangles: (0..count).filter(of).map(|t| mesh.triangles()[t]).collect(),
            values: values?,
        })
    };
    materials.into_iter().map(patch).collect()
}

fn averaged_stress(body: &Body, stress: &[SymTensor2], cells: impl Fn(usize) -> bool) -> Vec<SymTensor2> {
    let components = [|s: SymTensor2| s.xx, |s: SymTensor2| s.yy, |s: SymTensor2| s.xy];
    let [xx, yy, xy] = components.map(|component| {
        let of = (0..stress.len()).filter(|t| cells(*t));
        averaged(body.mesh(), of, |t| component(stress[t]))
    });
    xx.into_iter().zip(yy).zip(xy).map(|((xx, yy), xy)| SymTensor2 { xx, yy, xy }).collect()
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
