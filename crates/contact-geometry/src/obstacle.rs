//! Pairs sides of bodies with rigid obstacles.

use super::matching::{TOLERANCE, walk};
use super::normals::SUPPORT;
use super::{depth, facet_size, measure_arc, pairing};
use fem_core::body::Body;
use fem_core::geometry::{Coordinates, norm};
use fem_core::interface::{
    ContactFacet, ContactInterface, Gap, GapChange, InterfaceError, Line, NodePair, Obstacle, RigidLine,
};
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::mesh::topology::NONE;
use fem_core::space::Space;
use std::collections::HashMap;

/// Cosine of the largest angle between a contact edge and the obstacle: 60 degrees.
const FACING: f64 = 0.5;
/// An overlap of the undeformed body up to this fraction of its diagonal is rounding of the mesh: it touches.
const TOUCHING: f64 = 1e-6;
/// A change of the gap up to this fraction of the body's diagonal is round-off.
const ROUND_OFF: f64 = 1e-9;

/// Pairs a side of a body with a rigid obstacle: each node with the nearest point of the line. Edges that do not face the
/// line, by more than 60 degrees, are free. The gap is linear along the edges. A node at an end of a straight side that a
/// support clamps has no pair if the obstacle's motion is imposed: the opening there is known, and its edge takes the pressure of
/// its other end.
///
/// * `surface`: the edge group; `obstacle`: the one that the pair is made with.
/// * `gap`: a given one overrides the distance from the line, which is then at most 5 % of an edge; `None`: the distance, ≥ 0 to rounding of
///   the mesh; [`Gap::Interference`] keeps an overlap.
///
/// # Errors
/// A side that does not face the line, overlaps it, or is held or loaded, a clamped node that is pressed into the obstacle, see
/// [`InterfaceError`].
pub fn against(
    body: &Body,
    surface: &str,
    obstacle: &Obstacle,
    gap: Option<&Gap>,
) -> Result<ContactInterface, InterfaceError> {
    let line = &obstacle.line;
    let mesh = body.mesh();
    let all = pairing::group(body, 0, surface)?;
    let edges: Vec<FacetId> = all.iter().copied().filter(|edge| faces(body, line, *edge)).collect();
    if edges.is_empty() {
        return Err(InterfaceError::NotFacing { point: mesh.facet_middle(all[0]).into() });
    }
    pairing::check_free(body, 0, surface, &edges)?;
    let chain = walk(body, &edges);
    check_apart(body, line, &edges, gap)?;
    let mut line_of_nodes = Chained { may_be_clamped: obstacle.is_held(), ..Chained::default() };
    for stretch in &chain {
        line_of_nodes.add(body, line, stretch.nodes.as_slice(), &stretch.edges, gap)?;
    }
    depth::check([Some(body), None], &line_of_nodes.pairs, &line_of_nodes.edges)?;
    let gap_change = gap.and_then(|_| change(body, line, &line_of_nodes.pairs));
    let gap = gap.cloned().unwrap_or(Gap::Geometric);
    let (interface, _) = line_of_nodes.into_interface(body, obstacle, gap)?;
    Ok(interface.with_gap_change(gap_change))
}

/// Creates the interface of a refined body against the same obstacle, and the parents of its pairs.
///
/// * `middle`: the new node in the middle of each old edge, or [`NodeId::NONE`].
pub(super) fn refined_against(
    interface: &ContactInterface,
    body: &Body,
    middle: &[NodeId],
    obstacle: &Obstacle,
) -> Result<(ContactInterface, Vec<[u32; 2]>), InterfaceError> {
    let line = &obstacle.line;
    let (old_pairs, old_edges, _) = interface.line();
    let old_arcs = interface.line_arc_lengths();
    let gap = Some(interface.gap()).filter(|gap| !matches!(gap, Gap::Geometric));
    let mut starting = vec![None; old_pairs.len()];
    old_edges.iter().for_each(|edge| starting[edge.pairs[0] as usize] = Some(edge));
    let mut found = Chained { may_be_clamped: obstacle.is_held(), ..Chained::default() };
    let mut parents = Vec::new();
    let mut number = vec![0; old_pairs.len()];
    for (k, pair) in old_pairs.iter().enumerate() {
        number[k] = found.pairs.len() as u32;
        found.pairs.push(NodePair { weight: 0.0, ..*pair });
        found.arc_lengths.push(old_arcs[k]);
        parents.push([k as u32; 2]);
        let halved = starting[k].map(|edge| (edge, middle[edge.facets[0].index()]));
        if let Some((edge, node)) = halved.filter(|(_, node)| *node != NodeId::NONE) {
            let pair = found.pair(body, line, node, gap)?;
            found.pairs.push(NodePair { gap: interface.gap_factor() * pair.gap, ..pair });
            found.arc_lengths.push(old_arcs[k] + 0.5 * edge.measure);
            parents.push(edge.pairs);
        }
    }
    for edge in old_edges {
        let [i, j] = edge.pairs.map(|k| number[k as usize]);
        let ends = match middle[edge.facets[0].index()] {
            NodeId::NONE => vec![[i, j]],
            _ => vec![[i, i + 1], [i + 1, j]],
        };
        for ends in ends {
            let [a, b] = ends.map(|k| found.pairs[k as usize].nodes[0]);
            if let Some(edge) = body.mesh().topology().find_edge(a, b) {
                found.join(body, ends, edge);
            }
        }
    }
    if body.has_curves() {
        found.arc_lengths = measure_arc(found.pairs.len(), &found.edges);
    }
    let (finer, numbers) = found.into_interface(body, obstacle, interface.gap().clone())?;
    let finer = finer.with_gap_factor(interface.gap_factor());
    let kept = parents.into_iter().zip(numbers).filter(|(_, n)| *n != NONE);
    let parents = kept.map(|(parents, _)| interface.numbers(parents)).collect();
    Ok((finer, parents))
}

/// Refuses a side with a node inside the obstacle, with the deepest one; if the gap is given, a side that is apart from it or
/// inside by more than a part of an edge.
pub(super) fn check_apart<S: Space>(
    body: &Body<S>,
    line: &RigidLine<S>,
    facets: &[FacetId],
    gap: Option<&Gap<S>>,
) -> Result<(), InterfaceError> {
    let mesh = body.mesh();
    let given = matches!(gap, Some(Gap::Given(_) | Gap::Touching));
    let at = |node: NodeId, facet: FacetId| {
        let spacing = facet_size::<S>(mesh.facet_measure(facet));
        let distance = line.distance(mesh.points()[node]).0;
        let off = if given { distance.abs() - TOLERANCE * spacing } else { -distance };
        (off, distance, node, spacing)
    };
    let nodes = |facet: &FacetId| mesh.topology().facets()[*facet].into_iter();
    let all = facets.iter().flat_map(|facet| nodes(facet).map(|node| at(node, *facet)));
    let Some((off, distance, node, spacing)) = all.max_by(|a, b| a.0.total_cmp(&b.0)) else { return Ok(()) };
    let point = mesh.points()[node];
    if given && off > 0.0 {
        return Err(InterfaceError::Distance { point: point.into(), gap: distance, spacing });
    }
    if !given && !matches!(gap, Some(Gap::Interference)) && off > TOUCHING * mesh.diagonal() {
        return Err(InterfaceError::Overlap { point: point.into(), depth: off, spacing });
    }
    Ok(())
}

/// Creates the pair of a node and an obstacle, without a weight.
///
/// * `nodes`: the node, and the number of the pair.
pub(super) fn pair_with<S: Space>(
    body: &Body<S>,
    line: &RigidLine<S>,
    nodes: [NodeId; 2],
    gap: Option<&Gap<S>>,
) -> Result<NodePair<S>, InterfaceError> {
    let point = body.mesh().points()[nodes[0]];
    let (distance, normal) = line.distance(point);
    let gap = match gap {
        Some(Gap::Given(data)) => data.at(point),
        Some(Gap::Touching | Gap::Bonded { .. }) => 0.0,
        Some(Gap::Interference) => distance,
        Some(Gap::Geometric) | None => {
            let size = body.mesh().diagonal();
            if distance < -TOUCHING * size {
                let around = body.mesh().topology().cells_around(nodes[0]).first();
                let root = 1.0 / S::DIM as f64;
                let spacing = around.map_or(size, |t| body.mesh().measure(*t as usize).powf(root));
                return Err(InterfaceError::Overlap { point: point.into(), depth: -distance, spacing });
            }
            distance.max(0.0)
        }
    };
    if !gap.is_finite() {
        return Err(InterfaceError::BadGap { point: point.into(), value: gap });
    }
    Ok(NodePair { nodes, normal, gap, weight: 0.0 })
}

/// Tells whether a facet faces an obstacle, to 60 degrees.
pub(super) fn faces<S: Space>(body: &Body<S>, line: &RigidLine<S>, facet: FacetId) -> bool {
    line.distance(body.mesh().facet_middle(facet)).1.times(&body.mesh().facet_normal(facet)) >= FACING
}

/// Finds the node at which a given gap differs most from the distance of the line.
pub(super) fn change<S: Space>(
    body: &Body<S>,
    line: &RigidLine<S>,
    pairs: &[NodePair<S>],
) -> Option<GapChange<S>> {
    let points = body.mesh().points();
    let change = |pair: &NodePair<S>| {
        let point = points[pair.nodes[0]];
        GapChange { point, drawn: line.distance(point).0, used: pair.gap / pair.normal_length() }
    };
    let size = |c: &GapChange<S>| (c.used - c.drawn).abs();
    let largest = pairs.iter().map(change).max_by(|a, b| size(a).total_cmp(&size(b)));
    largest.filter(|c| size(c) > ROUND_OFF * body.mesh().diagonal())
}

/// Pairs and edges along an obstacle.
#[derive(Default)]
struct Chained {
    pairs: Vec<NodePair>,
    edges: Vec<ContactFacet>,
    /// At each pair, m.
    arc_lengths: Vec<f64>,
    /// The arc length so far, m.
    arc_length: f64,
    /// Set if a support may clamp a node: the obstacle's motion is imposed.
    may_be_clamped: bool,
}

impl Chained {
    /// Makes the interface without clamped pairs, and lists the number of each pair in it, or [`NONE`].
    fn into_interface(
        self,
        body: &Body,
        obstacle: &Obstacle,
        gap: Gap,
    ) -> Result<(ContactInterface, Vec<u32>), InterfaceError> {
        let profiles = vec![None; self.edges.len()];
        let line = Line { pairs: self.pairs, edges: self.edges, arc_lengths: self.arc_lengths, profiles };
        line.against(body, obstacle, gap)
    }

    /// Adds a stretch.
    fn add(
        &mut self,
        body: &Body,
        line: &RigidLine,
        nodes: &[NodeId],
        edges: &[FacetId],
        gap: Option<&Gap>,
    ) -> Result<(), InterfaceError> {
        let mut number: HashMap<NodeId, u32> = HashMap::new();
        for (k, &node) in nodes.iter().enumerate() {
            if k > 0 {
                self.arc_length += body.mesh().facet_measure(edges[k - 1]);
            }
            number.insert(node, self.pairs.len() as u32);
            let pair = self.pair(body, line, node, gap)?;
            self.pairs.push(pair);
            self.arc_lengths.push(self.arc_length);
        }
        for (k, &edge) in edges.iter().enumerate() {
            let ends = [nodes[k], nodes[(k + 1) % nodes.len()]].map(|n| number[&n]);
            self.join(body, ends, edge);
        }
        Ok(())
    }

    /// Creates the pair of a node and the obstacle.
    fn pair(
        &self,
        body: &Body,
        line: &RigidLine,
        node: NodeId,
        gap: Option<&Gap>,
    ) -> Result<NodePair, InterfaceError> {
        let (point, normal) = (body.mesh().points()[node], line.distance(body.mesh().points()[node]).1);
        let constraint = &body.node_constraints()[node];
        let allowed = self.may_be_clamped && constraint.is_clamped();
        if !allowed && norm(constraint.held.components(normal)) > SUPPORT {
            return Err(InterfaceError::SupportedNode { body: 0, point: point.into() });
        }
        pair_with(body, line, [node, NodeId::new(self.pairs.len())], gap)
    }

    /// Adds the edge between two pairs and its length to their tributary lengths.
    fn join(&mut self, body: &Body, ends: [u32; 2], edge: FacetId) {
        let length = body.mesh().facet_measure(edge);
        for k in ends {
            self.pairs[k as usize].weight += 0.5 * length;
        }
        // The line decides which edges are bent once it is complete.
        self.edges.push(ContactFacet {
            pairs: ends,
            facets: [edge; 2],
            measure: length,
            bent: false,
            clamped: [None; 2],
        });
    }
}
