//! The boundary of a solid body as triangles, and the edges of it that are drawn.

use super::Vector;
use fem_core::body::Body;
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::space::Solid;

/// Faces that turn by more than this many degrees meet in an edge that is drawn.
const SHARP: f64 = 30.0;

/// A boundary face of a mesh.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SkinFace {
    /// Counter-clockwise from outside.
    pub(crate) nodes: [NodeId; 3],
    pub(crate) facet: FacetId,
    pub(crate) cell: usize,
    /// Out of the body, at rest.
    pub(crate) normal: Vector,
}

/// The boundary of a body.
#[derive(Clone, Debug)]
pub(crate) struct Skin {
    pub(crate) faces: Vec<SkinFace>,
}

impl Skin {
    pub(crate) fn of(body: &Body<Solid>) -> Skin {
        let (mesh, topology) = (body.mesh(), body.mesh().topology());
        let face = |facet: &FacetId| SkinFace {
            nodes: topology.oriented_facet(*facet, mesh.cells()),
            facet: *facet,
            cell: topology.facet_cells()[*facet][0] as usize,
            normal: mesh.facet_normal(*facet),
        };
        Skin { faces: topology.boundary_facets().iter().map(face).collect() }
    }

    /// Lists the edges between faces that turn sharply or whose keys differ, by their nodes.
    ///
    /// * `key`: the same for all faces of a part, of the number of a face.
    pub(crate) fn edges(&self, key: impl Fn(usize) -> usize) -> Vec<[NodeId; 2]> {
        let least = SHARP.to_radians().cos();
        let turns = |a: usize, b: usize| self.faces[a].normal.dot(&self.faces[b].normal) < least;
        self.between(|a, b| turns(a, b) || key(a) != key(b))
    }

    /// Lists the edges between faces whose keys differ, by their nodes.
    pub(crate) fn borders(&self, key: impl Fn(usize) -> usize) -> Vec<[NodeId; 2]> {
        self.between(|a, b| key(a) != key(b))
    }

    fn between(&self, differ: impl Fn(usize, usize) -> bool) -> Vec<[NodeId; 2]> {
        let of_face = |(k, face): (usize, &SkinFace)| {
            let [a, b, c] = face.nodes;
            [[a, b], [b, c], [c, a]].map(|[a, b]| ([a.min(b), a.max(b)], k))
        };
        let mut sides: Vec<([NodeId; 2], usize)> = self.faces.iter().enumerate().flat_map(of_face).collect();
        sides.sort_unstable();
        let is_drawn = |group: &&[([NodeId; 2], usize)]| match group {
            [(_, first), (_, second)] => differ(*first, *second),
            _ => true,
        };
        sides.chunk_by(|a, b| a.0 == b.0).filter(is_drawn).map(|group| group[0].0).collect()
    }
}
