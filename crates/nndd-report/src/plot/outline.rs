//! The boundary of a mesh, as closed lines.

use fem_core::mesh::TriMesh;
use fem_core::mesh::id::NodeId;
use std::collections::BTreeMap;

/// Returns the boundary of a mesh as lines through point numbers, each ending where it began.
pub(super) fn outline(mesh: &TriMesh) -> Vec<Vec<NodeId>> {
    let edges = mesh.topology().boundary_facets().iter();
    let edges = edges.map(|edge| mesh.topology().oriented_facet(*edge, mesh.cells()));
    // The edges of the boundary touch in pairs, so one begins and one ends at each of its points.
    let mut next: BTreeMap<NodeId, NodeId> = edges.map(|[from, to]| (from, to)).collect();
    let mut lines = vec![];
    while let Some((start, second)) = next.pop_first() {
        let mut line = vec![start, second];
        line.extend(std::iter::successors(next.remove(&second), |at| next.remove(at)));
        lines.push(line);
    }
    lines
}
