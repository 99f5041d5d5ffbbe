//! Lengths and normals of the contact line.
//!
//! The normal is a frozen field `n(s) = Σ φ_i n_i`, linear between unit normals at the nodes. Edge normals would lock: two
//! matching polygons interlock at their corners under linearised kinematics. A corner between declared curves, or straight stretches beside them, is
//! one of the bodies themselves: it ends the line, see [`super::matching::ended_at_corners`].

use super::common_refinement::Facing;
use super::common_refinement::curve::{smooth_beyond, turns_into};
use super::matching::Stretch;
use super::{ContactNormal, outline};
use fem_core::body::Body;
use fem_core::geometry::{PARALLEL, Vector, angle_between, cross, norm};
use fem_core::interface::{ContactFacet, InterfaceError, NodePair};
use fem_core::mesh::id::FacetId;
use fem_core::smooth::STRAIGHT;
use std::collections::HashMap;

/// Cosine of the largest angle between neighbouring normals: 60 degrees.
const TURN: f64 = 0.5;
/// Sine of the largest angle between a support's direction and the contact line: a little more than the 60 degrees that an edge may be from
/// the normals at its ends, so that a support along the edge is accepted.
pub(super) const SUPPORT: f64 = 0.867;

/// Sets tributary lengths and normals of all pairs.
///
/// * `facing`: the normals from a common refinement, at every pair; averages of cut surfaces would be edge normals.
pub(super) fn choose(
    bodies: [&Body; 2],
    chain: &[Stretch],
    pairs: &mut [NodePair],
    edges: &[ContactFacet],
    normal: ContactNormal,
    facing: Option<&[&Facing]>,
) -> Result<(), InterfaceError> {
    for edge in edges {
        for pair in edge.pairs {
            pairs[pair as usize].weight += 0.5 * edge.measure;
        }
    }
    match normal {
        ContactNormal::Fixed(direction) => {
            let common = given(bodies[0], edges, direction)?;
            pairs.iter_mut().for_each(|p| p.normal = common);
        }
        ContactNormal::Averaged => {
            let (mut first_pair, mut first_edge) = (0, 0);
            for stretch in chain {
                let (last_pair, last_edge) =
                    (first_pair + stretch.nodes.len(), first_edge + stretch.edges.len());
                let found = &edges[first_edge..last_edge];
                match facing {
                    Some(facing) => {
                        check_corners(bodies[0], pairs, found)?;
                        frozen(
                            bodies[0],
                            &mut pairs[first_pair..last_pair],
                            found,
                            &facing[first_pair..last_pair],
                        );
                    }
                    None => averaged(bodies[0], pairs, first_pair..last_pair, found, stretch)?,
                }
                (first_pair, first_edge) = (last_pair, last_edge);
            }
        }
    }
    let turns = turns(pairs, edges);
    for (pair, turn) in pairs.iter_mut().zip(turns) {
        free_direction(bodies, pair, turn)?;
    }
    check_turns(bodies, pairs, edges)
}

/// Checks a given direction against every edge and normalises it.
fn given(body: &Body, edges: &[ContactFacet], direction: Vector) -> Result<Vector, InterfaceError> {
    let length = norm(direction);
    let unit = 1.0 / length * direction;
    for edge in edges {
        let cosine = unit.dot(&body.mesh().facet_normal(edge.facets[0]));
        if !(cosine >= TURN && length.is_finite()) {
            let point = body.mesh().facet_middle(edge.facets[0]);
            return Err(InterfaceError::NormalAway {
                normal: direction.into(),
                point: point.into(),
                degrees: cosine.acos().to_degrees(),
            });
        }
    }
    Ok(unit)
}

/// Finds the sharpest turn between neighbouring edges of the first body's side of the line: its place and the cosine of its angle.
pub(super) fn sharpest_turn(
    body: &Body,
    pairs: &[NodePair],
    edges: &[ContactFacet],
) -> Option<(Vector, f64)> {
    let mut before: HashMap<u32, Vector> = HashMap::new();
    let mut sharpest: Option<(Vector, f64)> = None;
    for edge in edges {
        let normal = body.mesh().facet_normal(edge.facets[0]);
        for k in edge.pairs {
            let Some(other) = before.insert(k, normal) else { continue };
            let cosine = other.dot(&normal).clamp(-1.0, 1.0);
            if sharpest.is_none_or(|s| cosine < s.1) {
                sharpest = Some((body.mesh().points()[pairs[k as usize].nodes[0]], cosine));
            }
        }
    }
    sharpest
}

/// Rejects corners of more than 60 degrees.
fn check_corners(body: &Body, pairs: &[NodePair], edges: &[ContactFacet]) -> Result<(), InterfaceError> {
    match sharpest_turn(body, pairs, edges) {
        Some((point, cosine)) if cosine < TURN => {
            Err(InterfaceError::Curved { point: point.into(), degrees: cosine.acos().to_degrees() })
        }
        _ => Ok(()),
    }
}

/// Uses the normals of a common refinement; on a straight stretch all nodes have the normal of the first edge.
fn frozen(body: &Body, pairs: &mut [NodePair], edges: &[ContactFacet], facing: &[&Facing]) {
    let common = body.mesh().facet_normal(edges[0].facets[0]);
    for (pair, facing) in pairs.iter_mut().zip(facing) {
        pair.normal = facing.normal;
    }
    if pairs.iter().all(|p| cross(common, p.normal).abs() <= STRAIGHT && common.dot(&p.normal) > 0.0) {
        pairs.iter_mut().for_each(|p| p.normal = common);
    }
}

/// Averages the edge normals at the nodes of one stretch; a straight one has a single normal. If the outline continues
/// smoothly at an end, the edge beyond it counts. Otherwise the normal at the end of a curved stretch is the neighbour's
/// mirrored at the last edge, which is exact for a circle, as with a common refinement. On declared curves the normals are
/// the curves' own.
fn averaged(
    body: &Body,
    pairs: &mut [NodePair],
    range: std::ops::Range<usize>,
    edges: &[ContactFacet],
    stretch: &Stretch,
) -> Result<(), InterfaceError> {
    let of = |edge: &ContactFacet| body.mesh().facet_normal(edge.facets[0]);
    let common = of(&edges[0]);
    let (first, last) = (range.start, range.end - 1);
    let mut beyond =
        if edges.len() == last - first { edges_beyond(body, &pairs[first..=last], edges) } else { [None; 2] };
    for (beyond, _) in beyond.iter_mut().zip(stretch.corners).filter(|(_, corner)| *corner) {
        *beyond = None;
    }
    let is_common = |e: &ContactFacet| cross(common, of(e)).abs() <= STRAIGHT && common.dot(&of(e)) > 0.0;
    // A single edge may be part of a curve.
    if edges.iter().all(is_common) && (edges.len() > 1 || beyond == [None; 2]) {
        pairs[range].iter_mut().for_each(|p| p.normal = common);
        return Ok(());
    }
    check_corners(body, pairs, edges)?;
    for edge in edges {
        for k in edge.pairs {
            let pair = &mut pairs[k as usize];
            pair.normal += edge.measure * of(edge);
        }
    }
    for (end, beyond) in [first, last].into_iter().zip(beyond) {
        if let Some(edge) = beyond {
            pairs[end].normal += body.mesh().facet_measure(edge) * body.mesh().facet_normal(edge);
        }
    }
    for pair in &mut pairs[range] {
        pair.normal = 1.0 / norm(pair.normal) * pair.normal;
    }
    if edges.len() == last - first && edges.len() > 1 {
        let ends = [(first, first + 1, &edges[0]), (last, last - 1, &edges[edges.len() - 1])];
        for ((end, neighbour, edge), _) in ends.into_iter().zip(beyond).filter(|(_, beyond)| beyond.is_none())
        {
            let (own, next) = (of(edge), pairs[neighbour].normal);
            pairs[end].normal = 2.0 * next.dot(&own) * own - next;
        }
    }
    let points = stretch.points(body, &stretch.nodes);
    let pieces = outline::pieces(body, &stretch.edges, &points, stretch.is_cut());
    let known =
        outline::normals(&pieces, &points, |k| of(&edges[k]), [stretch.is_closed(), stretch.is_cut()]);
    for (pair, normal) in pairs[first..=last].iter_mut().zip(known) {
        pair.normal = normal.unwrap_or(pair.normal);
    }
    for (node, normal) in &stretch.faced {
        pairs[first..=last].iter_mut().filter(|p| p.nodes[0] == *node).for_each(|p| p.normal = *normal);
    }
    Ok(())
}

/// Finds the edges beyond the two ends of an open stretch at which the outline continues smoothly.
fn edges_beyond(body: &Body, pairs: &[NodePair], edges: &[ContactFacet]) -> [Option<FacetId>; 2] {
    let (mesh, last) = (body.mesh(), pairs.len() - 1);
    let node = |k: usize| pairs[k].nodes[0];
    let ends = |k: usize| [node(k), node(last - k)].map(|n| mesh.points()[n]);
    let found = [(node(0), &edges[0]), (node(last), &edges[edges.len() - 1])]
        .map(|(end, edge)| Some((end, mesh.topology().boundary_beyond(edge.facets[0], end)?)));
    let points = found.map(|found| {
        let (end, edge) = found?;
        mesh.topology().facets()[edge].into_iter().find(|n| *n != end).map(|n| mesh.points()[n])
    });
    let smooth = smooth_beyond([ends(0), ends(1)], (last > 1).then(|| ends(2)), points);
    [0, 1].map(|e| smooth[e].and(found[e]).map(|(_, edge)| edge))
}

/// Computes by how much the line turns at each pair: the largest angle to a neighbour's normal, in radians.
fn turns(pairs: &[NodePair], edges: &[ContactFacet]) -> Vec<f64> {
    let mut turns = vec![0.0f64; pairs.len()];
    for edge in edges {
        let [i, j] = edge.pairs.map(|k| k as usize);
        let angle = angle_between(pairs[i].normal, pairs[j].normal);
        turns[i] = turns[i].max(angle);
        turns[j] = turns[j].max(angle);
    }
    turns
}

/// On a curved line, turns the normal of a pair whose node is supported in one direction into the free direction.
/// Rejects nodes on rollers whose normal displacement is imposed, or nearly so. Otherwise the normal is the line's,
/// and the node's frame is not orthogonal, see [`crate::dof::DofMap`].
fn free_direction(bodies: [&Body; 2], pair: &mut NodePair, turn: f64) -> Result<(), InterfaceError> {
    let constraint = |b: usize| &bodies[b].node_constraints()[pair.nodes[b]];
    let refused = |b: usize| {
        Err(InterfaceError::SupportedNode { body: b, point: bodies[b].mesh().points()[pair.nodes[b]].into() })
    };
    if (0..2).all(|b| bodies[b].node_constraints()[pair.nodes[b]].is_clamped()) {
        return Ok(());
    }
    let mut normal = pair.normal;
    for b in 0..2 {
        if constraint(b).rigid_side.is_some() {
            return refused(b);
        }
        let held = constraint(b).held;
        // The other body's support may have turned the normal already.
        if !held.is_none()
            && normal == pair.normal
            && let Some(free) = held.complement().nearest(normal)
            && turns_into(normal, free, turn)
        {
            normal = free;
        }
    }
    for b in 0..2 {
        let held = constraint(b).held;
        // If it is clamped, only the other body has an unknown there.
        if !held.is_all() && norm(held.components(normal)) > SUPPORT * norm(normal) {
            return refused(b);
        }
    }
    pair.normal = normal;
    Ok(())
}

/// Rejects lines whose normals turn too much along an edge, or are too far from the edge's own.
fn check_turns(bodies: [&Body; 2], pairs: &[NodePair], edges: &[ContactFacet]) -> Result<(), InterfaceError> {
    for edge in edges {
        let [a, b] = edge.pairs.map(|k| pairs[k as usize].normal).map(|n| 1.0 / norm(n) * n);
        let own = bodies[0].mesh().facet_normal(edge.facets[0]);
        let other = -bodies[1].mesh().facet_normal(edge.facets[1]);
        let worst = [a.dot(&b), a.dot(&own), b.dot(&own)].into_iter().fold(1.0, f64::min);
        if !(worst >= TURN - PARALLEL) {
            let degrees = worst.clamp(-1.0, 1.0).acos().to_degrees();
            return Err(InterfaceError::Curved {
                point: bodies[0].mesh().facet_middle(edge.facets[0]).into(),
                degrees,
            });
        }
        if (a + b).dot(&other) <= 0.0 {
            return Err(InterfaceError::NotFacing {
                point: bodies[0].mesh().facet_middle(edge.facets[0]).into(),
            });
        }
    }
    Ok(())
}
