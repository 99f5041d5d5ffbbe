//! The normals of rollers: of straight parts of a side, and at nodes between edges.

use super::SAME_DIRECTION;
use crate::geometry::{self, Vector, cross};
use crate::mesh::TriMesh;
use crate::mesh::id::{FacetId, NodeId};
use std::collections::HashMap;

/// If the normals of rollers on neighbouring edges differ by at most this, they fix a node along their mean; if they
/// differ by more, they clamp it.
const SMOOTH: f64 = 30.0;

/// A roller has one direction on a part of a side whose nodes are within this fraction of its length of a straight line: coordinates
/// in a file have few digits.
const STRAIGHT: f64 = 1e-5;

/// Cosine of the turn, 1 degree, from which two parts of a roller are told apart.
const TURN: f64 = 0.99985;

/// Finds the normal of each edge of a roller. All edges of a straight part have the normal of the line through its ends.
pub(super) fn straightened(mesh: &TriMesh, edges: &[FacetId]) -> HashMap<FacetId, Vector> {
    let (points, topology) = (mesh.points(), mesh.topology());
    let mut found: HashMap<FacetId, Vector> =
        edges.iter().map(|edge| (*edge, mesh.facet_normal(*edge))).collect();
    for nodes in mesh.walks(edges, |a, b| a.cmp(&b)) {
        let between = |w: &[NodeId]| topology.find_edge(w[0], w[1]);
        let part: Vec<FacetId> = nodes.windows(2).filter_map(between).collect();
        let normals: Vec<Vector> = part.iter().map(|edge| mesh.facet_normal(*edge)).collect();
        let mut first = 0;
        for last in 0..part.len() {
            if normals.get(last + 1).is_some_and(|next| next.dot(&normals[last]) > TURN) {
                continue;
            }
            let [start, end] = [points[nodes[first]], points[nodes[last + 1]]];
            let chord = geometry::right_normal(start, end);
            let limit = STRAIGHT * geometry::norm(end - start);
            let line = &nodes[first..=last + 1];
            if line.iter().all(|n| (points[*n] - start).dot(&chord).abs() <= limit) {
                found.extend(part[first..=last].iter().map(|edge| (*edge, chord)));
            }
            first = last + 1;
        }
    }
    found
}

/// Lists the normals of a roller's edges at each of their nodes, times the edges' lengths, in the order of the edges.
pub(super) fn at_nodes(mesh: &TriMesh, normals: &HashMap<FacetId, Vector>) -> HashMap<NodeId, Vec<Vector>> {
    let mut edges: Vec<(&FacetId, &Vector)> = normals.iter().collect();
    edges.sort_unstable_by_key(|(edge, _)| **edge);
    let mut found: HashMap<NodeId, Vec<Vector>> = HashMap::new();
    for (edge, normal) in edges {
        for node in mesh.topology().facets()[*edge] {
            found.entry(node).or_default().push(mesh.facet_measure(*edge) * normal);
        }
    }
    found
}

/// The mean of those weighted normals that are within [`SMOOTH`] of the edge's own; on a straight side the edge's own.
pub(super) fn mean(all: &[Vector], own: Vector) -> Vector {
    let near = all.iter().filter(|n| n.dot(&own) >= SMOOTH.to_radians().cos() * geometry::norm(**n));
    let mean = near.fold(Vector::zeros(), |sum, n| sum + n);
    let mean = 1.0 / geometry::norm(mean) * mean;
    if cross(mean, own).abs() <= SAME_DIRECTION { own } else { mean }
}
