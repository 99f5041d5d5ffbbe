//! The same body with moved nodes.

use super::error::CommonRefinementError;
use fem_core::body::Body;
use fem_core::geometry::{Vector, norm};
use fem_core::mesh::TriMesh;
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::mesh::refine::{Refinement, RefinementEdges};
use std::collections::{BTreeMap, HashMap};

/// Number of moved nodes of each body, and their largest motion, m.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Moves {
    pub(super) count: [usize; 2],
    pub(super) largest: [f64; 2],
}

impl Moves {
    /// Adds nodes of body `b`, given as it was before they moved.
    pub(super) fn add(&mut self, b: usize, body: &Body, moved: &HashMap<NodeId, Vector>) {
        self.count[b] += moved.len();
        let way = |(node, to): (&NodeId, &Vector)| norm(*to - body.mesh().points()[*node]);
        self.largest[b] = moved.iter().map(way).fold(self.largest[b], f64::max);
    }
}

/// Moves the nodes that were snapped.
pub(super) fn with_moved(
    body: Body,
    number: usize,
    moved: &HashMap<NodeId, Vector>,
) -> Result<Body, CommonRefinementError> {
    if moved.is_empty() {
        return Ok(body);
    }
    let mut points = body.mesh().points().to_vec();
    for (&node, &point) in moved {
        points[node] = point;
    }
    replaced(&body, number, points, &BTreeMap::new())
}

/// Creates the same body with moved nodes, or with other edges in some groups.
pub(super) fn replaced(
    body: &Body,
    number: usize,
    points: Vec<Vector>,
    changed: &BTreeMap<&str, Vec<FacetId>>,
) -> Result<Body, CommonRefinementError> {
    let mesh = body.mesh();
    let edges = mesh.topology().facets();
    let groups = mesh.groups().iter().map(|(name, all)| {
        let kept = changed.get(name.as_str()).unwrap_or(all);
        (name.clone(), kept.iter().map(|&e| edges[e]).collect())
    });
    let now = TriMesh::oriented(points, mesh.cells().to_vec(), groups.collect())
        .map_err(|source| CommonRefinementError::Mesh { body: number, source })?;
    // A refinement without cuts: conditions stay on their edges.
    let same = Refinement {
        refinement_edges: RefinementEdges::longest(&now),
        parent_cell: (0..mesh.cells().len() as u32).collect(),
        parent_nodes: Vec::new(),
        middle: vec![NodeId::NONE; edges.len()],
        on_chord: Vec::new(),
        mesh: now,
    };
    body.refined(&same).map_err(|source| CommonRefinementError::Body { body: number, source })
}
