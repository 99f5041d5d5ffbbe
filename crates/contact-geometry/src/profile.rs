//! The measured gap between two pairs, see [`Profile`].

use super::common_refinement::curve::{Between, Curve};
use super::matching::Stretch;
use super::outline;
use fem_core::body::Body;
use fem_core::geometry::{Vector, norm};
use fem_core::interface::{ContactFacet, NodePair, Profile};
use fem_core::mesh::id::{FacetId, NodeId};
use std::collections::HashMap;

/// Creates the cubics from the gaps at the pairs and between them; `None` if the gap is linear.
pub(super) fn profiles(
    pairs: &[NodePair],
    edges: &[ContactFacet],
    between: &[Option<Between>],
) -> Vec<Option<Profile>> {
    let profile = |(edge, between): (&ContactFacet, &Option<Between>)| {
        let [i, j] = edge.pairs.map(|k| pairs[k as usize]).map(|pair| pair.gap / norm(pair.normal));
        let Between { gaps, pieces, .. } = (*between)?;
        match pieces {
            Some(pieces) => Profile::of_pieces(pieces, [i, j], gaps, edge.measure),
            None => Profile::through([i, gaps[0], gaps[1], j], edge.measure),
        }
    };
    edges.iter().zip(between).map(profile).collect()
}

/// Finds the values measured between the pairs of surfaces with a common refinement.
///
/// * `between`: from one of the first body's nodes to the next.
pub(super) fn of_refined(
    pairs: &[NodePair],
    edges: &[ContactFacet],
    between: &HashMap<[NodeId; 2], Between>,
) -> Vec<Option<Between>> {
    let find = |edge: &ContactFacet| {
        let [a, b] = edge.pairs.map(|k| pairs[k as usize].nodes[0]);
        let turned = |b: &Between| Between { gaps: [b.gaps[1], b.gaps[0]], ..*b };
        between.get(&[a, b]).copied().or_else(|| between.get(&[b, a]).map(turned))
    };
    edges.iter().map(find).collect()
}

/// Measures between the pairs of surfaces that match node by node: between the smooth curves through the nodes of each.
///
/// * `drawn`: the gap measured at each pair, m.
pub(super) fn of_matching(
    bodies: [&Body; 2],
    chain: &[Stretch],
    (pairs, drawn): (&[NodePair], &[f64]),
    edges: &[ContactFacet],
) -> Vec<Option<Between>> {
    let mut found = Vec::with_capacity(edges.len());
    let (mut first_pair, mut first_edge) = (0, 0);
    for stretch in chain {
        let own = &pairs[first_pair..first_pair + stretch.nodes.len()];
        let along = &edges[first_edge..first_edge + stretch.edges.len()];
        let curves = [0, 1].map(|b| {
            let nodes: Vec<NodeId> = own.iter().map(|p| p.nodes[b]).collect();
            let points = stretch.points(bodies[b], &nodes);
            let numbers: Vec<FacetId> = along.iter().map(|edge| edge.facets[b]).collect();
            let pieces = outline::pieces(bodies[b], &numbers, &points, stretch.is_cut());
            Curve::new(points).kept_open(!stretch.is_closed()).with_pieces(pieces)
        });
        for (k, edge) in along.iter().enumerate() {
            let [i, j] = edge.pairs.map(|k| k as usize);
            let at = |t: f64| {
                let normal = (1.0 - t) * pairs[i].normal + t * pairs[j].normal;
                let apart: Vector = curves[1].smooth(k, t) - curves[0].smooth(k, t);
                apart.dot(&normal) / norm(normal)
            };
            // The distance of the nodes themselves is known; the curves give the distance between them.
            let off = [drawn[i] - at(0.0), drawn[j] - at(1.0)];
            let gaps = [1.0 / 3.0, 2.0 / 3.0].map(|t| at(t) + (1.0 - t) * off[0] + t * off[1]);
            let uncertainty = curves.iter().map(|c| c.uncertainty(k)).sum();
            found.push(Some(Between {
                gaps,
                uncertainty,
                pieces: Curve::both([&curves[0], &curves[1]], [k; 2]),
            }));
        }
        (first_pair, first_edge) = (first_pair + own.len(), first_edge + along.len());
    }
    found
}
