//! The star of a vertex: its triangles and the edges between them, in order.

use fem_core::mesh::TriMesh;
use fem_core::mesh::id::{EdgeId, NodeId};
use fem_core::mesh::topology::NONE;

/// The star of a vertex, counter-clockwise: spoke `j` comes before triangle `j`. An open star begins and ends
/// at a boundary edge and has one spoke more than triangles.
#[derive(Default)]
pub(crate) struct Star {
    pub(crate) triangles: Vec<u32>,
    pub(crate) spokes: Vec<EdgeId>,
}

impl Star {
    /// Collects the star of a vertex.
    pub(crate) fn walk(&mut self, mesh: &TriMesh, node: NodeId) {
        let topology = mesh.topology();
        let around = topology.triangles_around(node);
        let before = |t: u32| topology.triangle_edges()[t as usize][corner(mesh, t, node)];
        let after = |t: u32| topology.triangle_edges()[t as usize][(corner(mesh, t, node) + 2) % 3];
        let start = around.iter().copied().find(|&t| topology.is_boundary(before(t)));
        self.triangles.clear();
        self.spokes.clear();
        let mut current = start.unwrap_or(around[0]);
        for _ in 0..around.len() {
            self.triangles.push(current);
            self.spokes.push(before(current));
            let [a, b] = topology.edge_triangles()[after(current)];
            let next = if a == current { b } else { a };
            if next == NONE {
                self.spokes.push(after(current));
                break;
            }
            current = next;
        }
    }

    /// Tells whether the vertex lies inside the mesh.
    pub(crate) fn is_closed(&self) -> bool {
        self.spokes.len() == self.triangles.len()
    }
}

/// Finds which corner of a triangle a node is.
pub(crate) fn corner(mesh: &TriMesh, triangle: u32, node: NodeId) -> usize {
    let corners = &mesh.triangles()[triangle as usize];
    match corners.iter().position(|&n| n == node) {
        Some(corner) => corner,
        None => unreachable!("node {node} is not one of the corners {corners:?} of triangle {triangle}"),
    }
}
