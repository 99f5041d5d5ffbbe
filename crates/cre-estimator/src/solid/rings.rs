//! The edges of a mesh of tetrahedra, each with the faces and cells around it.

use fem_core::mesh::TetMesh;
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::space::{Solid, Space};

/// A cell of a ring.
#[derive(Clone, Copy)]
pub(crate) struct RingCell {
    pub(crate) cell: u32,
    /// Its two faces that contain the edge, by their places in the cell.
    pub(crate) faces: [u8; 2],
    /// These faces by their places in the ring.
    pub(crate) places: [u32; 2],
}

/// All edges, ascending by their nodes.
pub(crate) struct Rings {
    nodes: Vec<[NodeId; 2]>,
    /// The cells of edge `k` begin at `starts[k][0]`, its faces at `starts[k][1]`.
    starts: Vec<[u32; 2]>,
    cells: Vec<RingCell>,
    faces: Vec<FacetId>,
}

/// One edge and what is around it.
#[derive(Clone, Copy)]
pub(crate) struct Ring<'a> {
    pub(crate) nodes: [NodeId; 2],
    pub(crate) cells: &'a [RingCell],
    /// Ascending.
    pub(crate) faces: &'a [FacetId],
}

impl Rings {
    pub(crate) fn new(mesh: &TetMesh) -> Self {
        let topology = mesh.topology();
        let mut sides: Vec<([NodeId; 2], u32, [u8; 2])> = Vec::with_capacity(6 * mesh.cells().len());
        for (cell, corners) in mesh.cells().iter().enumerate() {
            for (i, j) in (0..4).flat_map(|i| (i + 1..4).map(move |j| (i, j))) {
                let mut faces = (0..4u8).filter(|k| {
                    let facet = Solid::facet(usize::from(*k));
                    facet.contains(&i) && facet.contains(&j)
                });
                if let (Some(first), Some(second)) = (faces.next(), faces.next()) {
                    let (a, b) = (corners[i], corners[j]);
                    sides.push(([a.min(b), a.max(b)], cell as u32, [first, second]));
                }
            }
        }
        sides.sort_unstable();
        let mut rings =
            Self { nodes: Vec::new(), starts: vec![[0; 2]], cells: Vec::new(), faces: Vec::new() };
        for sides in sides.chunk_by(|a, b| a.0 == b.0) {
            let facet = |cell: u32, k: u8| topology.cell_facets()[cell as usize][usize::from(k)];
            let first = rings.faces.len();
            let mut around: Vec<FacetId> =
                sides.iter().flat_map(|(_, cell, faces)| faces.map(|k| facet(*cell, k))).collect();
            around.sort_unstable();
            around.dedup();
            rings.faces.extend(around);
            let around = &rings.faces[first..];
            rings.cells.extend(sides.iter().map(|&(_, cell, faces)| {
                let place = |k: u8| around.binary_search(&facet(cell, k)).unwrap_or(0) as u32;
                RingCell { cell, faces, places: faces.map(place) }
            }));
            rings.nodes.push(sides[0].0);
            rings.starts.push([rings.cells.len() as u32, rings.faces.len() as u32]);
        }
        rings
    }

    pub(crate) fn len(&self) -> usize {
        self.nodes.len()
    }

    pub(crate) fn get(&self, k: usize) -> Ring<'_> {
        let [[cell, face], [last_cell, last_face]] = [self.starts[k], self.starts[k + 1]];
        Ring {
            nodes: self.nodes[k],
            cells: &self.cells[cell as usize..last_cell as usize],
            faces: &self.faces[face as usize..last_face as usize],
        }
    }
}
