//! The springs of a body: their nodal forces, and the facets around a node that are on springs.

use crate::body::{Body, moments};
use crate::mesh::id::{FacetId, NodeId};
use crate::space::Space;

/// Computes the nodal forces of the springs of a displaced body, Cartesian, N/m in the plane, N in space: with the sides that they act on.
///
/// * `displacement`: of each node, m; of an empty one zero.
pub fn spring_forces<'a, S: Space>(
    body: &'a Body<S>,
    displacement: &'a [S::Vector],
) -> impl Iterator<Item = (NodeId, S::Vector)> + 'a {
    let mesh = body.mesh();
    body.facet_springs().flat_map(move |(facet, springs)| {
        let nodes = mesh.topology().facets()[facet];
        let moved = S::axes(|k| displacement.get(nodes[k].index()).copied().unwrap_or_default());
        let forces = moments::<S>(&springs.stretched(&moved).traction(), mesh.facet_measure(facet));
        nodes.into_iter().zip(forces)
    })
}

/// The facets on springs, with each of their nodes, ascending by nodes.
pub(super) struct SpringsAround(Vec<(NodeId, FacetId)>);

impl SpringsAround {
    pub(super) fn new<S: Space>(body: &Body<S>) -> Self {
        let topology = body.mesh().topology();
        let mut all: Vec<_> = body
            .facet_springs()
            .flat_map(|(facet, _)| topology.facets()[facet].into_iter().map(move |node| (node, facet)))
            .collect();
        all.sort_unstable();
        Self(all)
    }

    /// Lists the facets on springs around a node.
    pub(super) fn of(&self, node: NodeId) -> impl Iterator<Item = FacetId> + '_ {
        let first = self.0.partition_point(|(other, _)| *other < node);
        self.0[first..].iter().take_while(move |(other, _)| *other == node).map(|(_, facet)| *facet)
    }
}
