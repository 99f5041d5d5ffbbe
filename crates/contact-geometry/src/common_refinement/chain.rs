//! The stretches (connected parts) of a contact surface, oriented with their body on the left.

use fem_core::body::Body;
use fem_core::geometry::{self, Vector};
use fem_core::mesh::TriMesh;
use fem_core::mesh::id::{FacetId, NodeId};
use std::collections::{HashMap, HashSet};

/// Cosine of the turn, 30 degrees, from which a node is a corner that does not move.
const CORNER: f64 = 0.866;

/// One stretch.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Chain {
    /// Nodes in order; a closed stretch ends with its first node.
    pub(super) nodes: Vec<NodeId>,
    /// True if its first node was inserted in an edge.
    pub(super) inserted: bool,
    /// For its first and its last node: true at a corner at which another stretch continues.
    pub(super) corners: [bool; 2],
    /// Normals that smooth pieces of the other body give to its corners, out of its own body.
    pub(super) faced: Vec<(NodeId, Vector)>,
}

impl Chain {
    pub(super) fn is_closed(&self) -> bool {
        self.nodes.len() > 1 && self.nodes.first() == self.nodes.last() && !self.is_cut()
    }

    /// Tells whether it is a part of a longer stretch, between corners.
    pub(super) fn is_cut(&self) -> bool {
        self.corners != [false; 2]
    }
}

/// Sorts the edges of a surface into stretches, the one with the smallest first point (x, y) first. `None` if an edge
/// lies inside the body.
pub(super) fn chains(mesh: &TriMesh, surface: &[FacetId]) -> Option<Vec<Chain>> {
    if surface.iter().any(|edge| !mesh.topology().is_boundary(*edge)) {
        return None;
    }
    let walks = mesh.walks(surface, |a, b| before(mesh, a, b));
    let mut chains: Vec<Chain> = walks.into_iter().map(|nodes| Chain { nodes, ..Chain::default() }).collect();
    chains.sort_by(|a, b| before(mesh, a.nodes[0], b.nodes[0]));
    Some(chains)
}

fn before(mesh: &TriMesh, a: NodeId, b: NodeId) -> std::cmp::Ordering {
    let [p, q] = [a, b].map(|n| mesh.points()[n]);
    p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1])).then(a.cmp(&b))
}

/// The surface's points in the order of (x, y): distinguishes two surfaces with equal numbers of edges, whatever their
/// orientation.
pub(super) fn sorted_points(mesh: &TriMesh, chains: &[Chain]) -> Vec<Vector> {
    let mut points: Vec<Vector> = chains.iter().flat_map(|c| &c.nodes).map(|&n| mesh.points()[n]).collect();
    points.sort_by(|p, q| p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1])));
    points
}

/// How freely a node may be moved along its surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Motion {
    /// Not at all: the direction of a roller would change, or it is a corner between two stretches.
    None,
    /// Only within rounding: an end, a corner, a supported node, a node at which a group or a material begins.
    Shifts,
    /// An inner node.
    Slides,
}

/// Nodes of a body that are not moved freely, whatever stretch they belong to.
pub(super) struct Fixed {
    /// A group begins there, or has more than two edges.
    ends: HashSet<NodeId>,
    /// On rollers.
    rollers: HashSet<NodeId>,
}

impl Fixed {
    /// Finds them in one pass over all groups.
    pub(super) fn new(body: &Body) -> Self {
        let mut ends = HashSet::new();
        for edges in body.mesh().groups().values() {
            let mut count: HashMap<NodeId, usize> = HashMap::new();
            for node in edges.iter().flat_map(|&e| body.mesh().topology().facets()[e]) {
                *count.entry(node).or_default() += 1;
            }
            ends.extend(count.into_iter().filter(|(_, c)| *c != 2).map(|(node, _)| node));
        }
        Self { ends, rollers: body.roller_nodes().collect() }
    }
}

/// Tells how each node of the stretches may move along its surface.
pub(super) fn motions(body: &Body, chains: &[Chain], fixed: &Fixed) -> HashMap<NodeId, Motion> {
    let mesh = body.mesh();
    let topology = mesh.topology();
    let mut motions: HashMap<NodeId, Motion> = HashMap::new();
    for chain in chains {
        for (k, &node) in chain.nodes.iter().enumerate() {
            let inner = k > 0 && k + 1 < chain.nodes.len();
            let held = !body.node_constraints()[node].held.is_none();
            let cells = topology.cells_around(node);
            let first = body.material(cells[0] as usize);
            let mixed = cells.iter().any(|&t| body.material(t as usize) != first);
            let corner = inner && {
                let edge = |a: NodeId, b: NodeId| topology.find_edge(a, b).map(|e| mesh.facet_normal(e));
                match [edge(chain.nodes[k - 1], node), edge(node, chain.nodes[k + 1])] {
                    [Some(m), Some(n)] => m.dot(&n) < CORNER,
                    _ => true,
                }
            };
            let slides = inner && !held && !mixed && !corner;
            let cut = (k == 0 && chain.corners[0]) || (k + 1 == chain.nodes.len() && chain.corners[1]);
            let motion = match slides && !fixed.ends.contains(&node) {
                _ if cut || fixed.rollers.contains(&node) => Motion::None,
                true => Motion::Slides,
                false => Motion::Shifts,
            };
            motions.insert(node, motion);
        }
    }
    motions
}

/// Computes the smallest angle of the cells that touch one of the nodes, in degrees.
pub(super) fn smallest_angle(mesh: &TriMesh, nodes: impl Iterator<Item = NodeId>) -> f64 {
    let mut smallest = 180.0f64;
    for node in nodes.filter(|n| *n != NodeId::NONE) {
        for &t in mesh.topology().cells_around(node) {
            smallest = smallest.min(geometry::smallest_angle(mesh.corners(t as usize)));
        }
    }
    smallest
}
