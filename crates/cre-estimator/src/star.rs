//! Stars of vertices: their triangles and the edges between them, in order.

use fem_core::mesh::TriMesh;
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::mesh::topology::NONE;

/// The star of a vertex, counter-clockwise: spoke `j` comes before triangle `j`. An open star begins and ends
/// at a boundary edge and has one spoke more than triangles.
#[derive(Clone, Copy)]
pub(crate) struct Star<'a> {
    pub(crate) triangles: &'a [Sector],
    pub(crate) spokes: &'a [Spoke],
}

/// The stars of some vertices, one after another.
#[derive(Default)]
pub(crate) struct StarList {
    triangles: Vec<Sector>,
    spokes: Vec<Spoke>,
    /// The ends of each star's triangles and spokes.
    ends: Vec<[usize; 2]>,
}

/// A triangle of a star.
#[derive(Clone, Copy)]
pub(crate) struct Sector {
    pub(crate) triangle: u32,
    /// The corner of the triangle at the vertex, 0 to 2.
    pub(crate) corner: u8,
    /// The edge opposite to the vertex.
    pub(crate) rim: FacetId,
}

/// An edge of a star that begins at the vertex.
#[derive(Clone, Copy)]
pub(crate) struct Spoke {
    pub(crate) edge: FacetId,
    /// The node at its other end.
    pub(crate) ring: NodeId,
    /// True if the triangle after it is the edge's first one.
    pub(crate) leads_to_first: bool,
}

impl Star<'_> {
    /// Tells whether the vertex lies inside the mesh.
    pub(crate) fn is_closed(&self) -> bool {
        self.spokes.len() == self.triangles.len()
    }
}

impl StarList {
    pub(crate) fn clear(&mut self) {
        self.triangles.clear();
        self.spokes.clear();
        self.ends.clear();
    }

    fn starts(&self, k: usize) -> [usize; 2] {
        k.checked_sub(1).map_or([0; 2], |before| self.ends[before])
    }

    /// Returns a star by its number.
    pub(crate) fn get(&self, k: usize) -> Star<'_> {
        let ([triangle, spoke], [last_triangle, last_spoke]) = (self.starts(k), self.ends[k]);
        Star { triangles: &self.triangles[triangle..last_triangle], spokes: &self.spokes[spoke..last_spoke] }
    }

    /// Appends the star of a vertex.
    pub(crate) fn walk(&mut self, mesh: &TriMesh, node: NodeId) {
        let topology = mesh.topology();
        let around = topology.cells_around(node);
        if !self.follow(mesh, node, around[0]) {
            // An open star begins at the boundary.
            let begins = |t: &u32| {
                let k = corner(&mesh.cells()[*t as usize], *t, node);
                topology.is_boundary(topology.cell_facets()[*t as usize][k])
            };
            if let Some(start) = around.iter().copied().find(begins) {
                self.follow(mesh, node, start);
            }
        }
        self.ends.push([self.triangles.len(), self.spokes.len()]);
    }

    /// Follows the triangles around a vertex from one of them on. Returns whether they lead back to it.
    fn follow(&mut self, mesh: &TriMesh, node: NodeId, start: u32) -> bool {
        let [triangle, spoke] = self.starts(self.ends.len());
        let Self { triangles, spokes, .. } = self;
        let topology = mesh.topology();
        triangles.truncate(triangle);
        spokes.truncate(spoke);
        let mut current = start;
        let mut leads_to_first = true;
        loop {
            let corners = &mesh.cells()[current as usize];
            let edges = &topology.cell_facets()[current as usize];
            let k = corner(corners, current, node);
            let (next, last) = ((k + 1) % 3, (k + 2) % 3);
            spokes.push(Spoke { edge: edges[k], ring: corners[next], leads_to_first });
            triangles.push(Sector { triangle: current, corner: k as u8, rim: edges[next] });
            let [a, b] = topology.facet_cells()[edges[last]];
            leads_to_first = a != current;
            current = if leads_to_first { a } else { b };
            if current == NONE {
                spokes.push(Spoke { edge: edges[last], ring: corners[last], leads_to_first: false });
                return false;
            }
            if current == start {
                spokes[spoke].leads_to_first = leads_to_first;
                return true;
            }
        }
    }
}

/// Finds which corner of a triangle a node is.
fn corner(corners: &[NodeId; 3], triangle: u32, node: NodeId) -> usize {
    match corners.iter().position(|&n| n == node) {
        Some(corner) => corner,
        None => unreachable!("node {node} is not one of the corners {corners:?} of triangle {triangle}"),
    }
}
