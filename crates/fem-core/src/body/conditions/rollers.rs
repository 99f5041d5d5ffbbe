//! The normals of rollers: of flat parts of a side, and at nodes between facets.

use super::SAME_DIRECTION;
use crate::directions::Directions;
use crate::geometry::{Coordinates, FLAT_SIDE, norm};
use crate::mesh::Mesh;
use crate::mesh::id::{FacetId, NodeId};
use crate::space::Space;
use std::collections::{HashMap, HashSet};

/// If the normals of rollers on neighbouring facets differ by at most this, they fix a node along their mean; if they
/// differ by more, they clamp it.
const SMOOTH: f64 = 30.0;

/// Cosine of the turn, 1 degree, from which two parts of a roller are told apart.
const TURN: f64 = 0.99985;

/// Finds the normal of each facet of a roller. All facets of a flat part have the same normal.
pub(super) fn flattened<S: Space>(mesh: &Mesh<S>, facets: &[FacetId]) -> HashMap<FacetId, S::Vector> {
    let normals: HashMap<FacetId, S::Vector> =
        facets.iter().map(|facet| (*facet, mesh.facet_normal(*facet))).collect();
    let mut found = normals.clone();
    for part in parts(mesh, facets, &normals) {
        let corners = |facet: &FacetId| {
            let nodes = mesh.topology().oriented_facet(*facet, mesh.cells());
            S::axes(|k| mesh.points()[nodes[k]])
        };
        let corners: Vec<_> = part.iter().map(corners).collect();
        if let Some(normal) = S::flat_normal(&corners, FLAT_SIDE) {
            found.extend(part.into_iter().map(|facet| (facet, normal)));
        }
    }
    found
}

/// Lists the parts of a side within which the normal turns little from each facet to the next one.
fn parts<S: Space>(
    mesh: &Mesh<S>,
    facets: &[FacetId],
    normals: &HashMap<FacetId, S::Vector>,
) -> Vec<Vec<FacetId>> {
    // Facets meet in what remains without one corner: a node, or an edge.
    let rims = |facet: FacetId| {
        let nodes = mesh.topology().facets()[facet];
        (0..S::DIM).map(move |left_out| S::axes(|k| if k == left_out { NodeId::NONE } else { nodes[k] }))
    };
    let key = |mut rim: Vec<NodeId>| {
        rim.sort_unstable();
        rim
    };
    let mut at_rim: HashMap<Vec<NodeId>, Vec<FacetId>> = HashMap::new();
    for &facet in facets {
        for rim in rims(facet) {
            at_rim.entry(key(rim.into_iter().collect())).or_default().push(facet);
        }
    }
    let (mut parts, mut reached) = (Vec::new(), HashSet::new());
    for &seed in facets {
        if !reached.insert(seed) {
            continue;
        }
        let (mut part, mut next) = (vec![seed], 0);
        while let Some(&facet) = part.get(next) {
            next += 1;
            for rim in rims(facet) {
                for &beside in &at_rim[&key(rim.into_iter().collect())] {
                    if normals[&beside].times(&normals[&facet]) > TURN && reached.insert(beside) {
                        part.push(beside);
                    }
                }
            }
        }
        parts.push(part);
    }
    parts
}

/// Lists the normals of a roller's facets at each of their nodes, times the measures of the facets, in the order of the facets.
pub(super) fn at_nodes<S: Space>(
    mesh: &Mesh<S>,
    normals: &HashMap<FacetId, S::Vector>,
) -> HashMap<NodeId, Vec<S::Vector>> {
    let mut facets: Vec<(&FacetId, &S::Vector)> = normals.iter().collect();
    facets.sort_unstable_by_key(|(facet, _)| **facet);
    let mut found: HashMap<NodeId, Vec<S::Vector>> = HashMap::new();
    for (facet, normal) in facets {
        for node in mesh.topology().facets()[*facet] {
            found.entry(node).or_default().push(*normal * mesh.facet_measure(*facet));
        }
    }
    found
}

/// The mean of those weighted normals that are within [`SMOOTH`] of the facet's own; on a flat side the facet's own.
pub(super) fn mean<S: Space>(all: &[S::Vector], own: S::Vector) -> S::Vector {
    let near = all.iter().filter(|n| n.times(&own) >= SMOOTH.to_radians().cos() * norm(**n));
    let mean = near.fold(S::Vector::ZERO, |sum, n| sum + *n);
    let mean = mean * (1.0 / norm(mean));
    if Directions::<S>::along(own).sine(mean) <= SAME_DIRECTION { own } else { mean }
}
