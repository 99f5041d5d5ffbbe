//! Supports on single nodes.

use super::{Evaluation, Imposed, SAME_DIRECTION, finite};
use crate::body::{BodyError, ConditionPlace};
use crate::boundary::Support;
use crate::directions::Directions;
use crate::geometry::{self, Coordinates};
use crate::mesh::id::NodeId;
use crate::space::Space;
use std::collections::BTreeMap;

/// A support on a single node is at a boundary node that is closer to the given place than this, over the diagonal of the body.
const AT_NODE: f64 = 1e-6;

impl<S: Space> Evaluation<'_, S> {
    /// Finds the boundary node at a place.
    pub(super) fn node_at(&self, place: ConditionPlace, at: S::Vector) -> Result<NodeId, BodyError> {
        finite(place, at, at.entries().iter().sum())?;
        let (points, topology) = (self.mesh.points(), self.mesh.topology());
        let nodes = topology.boundary_facets().iter().flat_map(|&facet| topology.facets()[facet]);
        let distance = |node: &NodeId| geometry::norm(points[*node] - at);
        let nearest = nodes.min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let tolerance = AT_NODE * self.mesh.diagonal();
        match nearest {
            Some(node) if distance(&node) <= tolerance => Ok(node),
            Some(node) => Err(BodyError::NoNode { place, point: at.into(), nearest: points[node].into() }),
            None => Err(BodyError::NoNode { place, point: at.into(), nearest: at.into() }),
        }
    }

    /// Imposes a condition on a single node; returns the directions in which it holds it. No facet has a reaction: what the node
    /// carries is missing in the equilibrium of the facets around it.
    pub(super) fn impose_at(
        &mut self,
        place: ConditionPlace,
        node: NodeId,
        support: &Support<S>,
    ) -> Result<BTreeMap<NodeId, Directions<S>>, BodyError> {
        let Support::Components(components) = support else { return Err(BodyError::SingleNode { place }) };
        let mut held = Directions::NONE;
        for (direction, data) in Directions::<S>::ALL.basis().iter().copied().zip(components.as_ref()) {
            let Some(data) = data else { continue };
            let magnitude = data.at(self.mesh.points()[node]).abs();
            self.constrain(place, node, &Imposed { direction, data, magnitude })?;
            held = held.with(direction, SAME_DIRECTION);
        }
        Ok(BTreeMap::from([(node, held)]))
    }
}
