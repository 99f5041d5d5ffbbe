//! Supports on single nodes.

use super::{Evaluation, Imposed, SAME_DIRECTION, finite};
use crate::body::{BodyError, ConditionPlace};
use crate::boundary::Support;
use crate::directions::Directions;
use crate::geometry::{self, Vector};
use crate::mesh::id::NodeId;
use std::collections::BTreeMap;

/// A support on a single node is at a boundary node that is closer to the given place than this, over the diagonal of the body.
const AT_NODE: f64 = 1e-6;

impl Evaluation<'_> {
    /// Finds the boundary node at a place.
    pub(super) fn node_at(&self, place: ConditionPlace, at: Vector) -> Result<NodeId, BodyError> {
        finite(place, at, at[0] + at[1])?;
        let (points, topology) = (self.mesh.points(), self.mesh.topology());
        let nodes = topology.boundary_facets().iter().flat_map(|&edge| topology.facets()[edge]);
        let distance = |node: &NodeId| geometry::norm(points[*node] - at);
        let nearest = nodes.min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let tolerance = AT_NODE * self.mesh.diagonal();
        match nearest {
            Some(node) if distance(&node) <= tolerance => Ok(node),
            Some(node) => Err(BodyError::NoNode { place, point: at, nearest: points[node] }),
            None => Err(BodyError::NoNode { place, point: at, nearest: at }),
        }
    }

    /// Imposes a condition on a single node; returns the directions in which it holds it. No edge has a reaction: what the node
    /// carries is missing in the equilibrium of the edges around it.
    pub(super) fn impose_at(
        &mut self,
        place: ConditionPlace,
        node: NodeId,
        support: &Support,
    ) -> Result<BTreeMap<NodeId, Directions>, BodyError> {
        let Support::Components(components) = support else { return Err(BodyError::SingleNode { place }) };
        let mut held = Directions::NONE;
        for (direction, data) in Directions::ALL.basis().iter().copied().zip(components) {
            let Some(data) = data else { continue };
            let magnitude = data.at(self.mesh.points()[node]).abs();
            self.constrain(place, node, &Imposed { direction, data, magnitude })?;
            held = held.with(direction, SAME_DIRECTION);
        }
        Ok(BTreeMap::from([(node, held)]))
    }
}
