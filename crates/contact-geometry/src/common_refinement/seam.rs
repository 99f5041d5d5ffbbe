//! Opens closed contact lines: both begin at one point, where a node of each faces a node of the other.

use super::chain::{self, Chain, Fixed, Motion};
use super::cut::on_curve;
use super::error::CommonRefinementError;
use super::line::{Line, Opposite};
use super::moved::{Moves, with_moved};
use super::overlap::{self, Overlap, ROUND_OFF, SAME, SNAP};
use crate::ContactNormal;
use fem_core::body::Body;
use fem_core::geometry::norm;
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::mesh::refine::{self, RefinementEdges};
use std::collections::HashMap;

/// Rotates closed stretches. Two closed stretches that face each other begin at the same point: at two nodes that
/// nearly coincide, which are snapped, or at a node of the other side inserted in the reference. Others begin
/// farthest from the other surface.
///
/// * `moves`: nodes that moved are added.
pub(super) fn open(
    bodies: &mut [Body; 2],
    chains: &mut [Vec<Chain>; 2],
    reference: usize,
    normal: ContactNormal,
    moves: &mut Moves,
) -> Result<(), CommonRefinementError> {
    let mut partnered = Vec::new();
    for i in 0..chains[reference].len() {
        if !chains[reference][i].is_closed() {
            continue;
        }
        let first = chains[reference][i].nodes[0];
        let distance = |chain: &Chain| nearest(bodies, reference, first, chain).1;
        let others = chains[1 - reference].iter().enumerate();
        let closest = (others.filter(|(j, c)| c.is_closed() && !partnered.contains(j)))
            .min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
        let Some((j, _)) = closest else {
            away(bodies, chains, reference, i);
            continue;
        };
        partnered.push(j);
        begin_together(bodies, chains, [i, j], reference, normal, moves)?;
    }
    for j in 0..chains[1 - reference].len() {
        if chains[1 - reference][j].is_closed() && !partnered.contains(&j) {
            away(bodies, chains, 1 - reference, j);
        }
    }
    Ok(())
}

/// Finds the position in the other body's stretch that is nearest to a node of body `b`, and the distance.
fn nearest(bodies: &[Body; 2], b: usize, node: NodeId, chain: &Chain) -> (usize, f64) {
    let point = bodies[b].mesh().points()[node];
    let distance = |n: &NodeId| norm(bodies[1 - b].mesh().points()[*n] - point);
    let distances = chain.nodes.iter().map(distance).enumerate();
    distances.min_by(|x, y| x.1.total_cmp(&y.1)).unwrap_or((0, f64::INFINITY))
}

/// Rotates a closed stretch so that it begins at its node `k`.
fn rotate(chain: &mut Chain, k: usize) {
    chain.nodes.pop();
    let count = chain.nodes.len();
    chain.nodes.rotate_left(k % count);
    chain.nodes.push(chain.nodes[0]);
}

fn rotate_to(chain: &mut Chain, node: NodeId) {
    if let Some(k) = chain.nodes.iter().position(|n| *n == node) {
        rotate(chain, k);
    }
}

/// Starts stretch `i` of body `b` at its node that is farthest from the other body's surface.
fn away(bodies: &[Body; 2], chains: &mut [Vec<Chain>; 2], b: usize, i: usize) {
    let distance = |node: NodeId| {
        let all = chains[1 - b].iter().map(|c| nearest(bodies, b, node, c).1);
        all.fold(f64::INFINITY, f64::min)
    };
    let nodes = chains[b][i].nodes.iter().map(|&n| distance(n)).enumerate();
    if let Some((k, _)) = nodes.max_by(|x, y| x.1.total_cmp(&y.1)) {
        rotate(&mut chains[b][i], k);
    }
}

/// Starts stretch `i` of the reference and `j` of the other body at the same point.
fn begin_together(
    bodies: &mut [Body; 2],
    chains: &mut [Vec<Chain>; 2],
    [i, j]: [usize; 2],
    reference: usize,
    normal: ContactNormal,
    moves: &mut Moves,
) -> Result<(), CommonRefinementError> {
    let (r, o) = (reference, 1 - reference);
    let (k, _) = nearest(bodies, r, chains[r][i].nodes[0], &chains[o][j]);
    rotate(&mut chains[o][j], k);
    let motions = [0, 1].map(|b| chain::motions(&bodies[b], &chains[b], &Fixed::new(&bodies[b])));
    let line = Line::new(&bodies[r], &chains[r][i], r, normal);
    let found = overlap::between(&line, &Opposite::new(&bodies[o], &chains[o][j]), r, &motions)?;
    let Some(mut overlap) = found else { return Ok(()) };
    let Some((at, offset)) = closest(&overlap, o) else { return Ok(()) };
    let mut seam = [0, 1].map(|b| overlap.sites[b][at[b]].node);
    if offset > ROUND_OFF && !(offset < SNAP && slide(bodies, &mut overlap, at, o, moves)?) {
        seam = insert(bodies, &mut chains[r][i], &overlap, r)?;
    }
    rotate_to(&mut chains[r][i], seam[r]);
    rotate_to(&mut chains[o][j], seam[o]);
    Ok(())
}

/// Finds the two inner nodes, one of each body, that are closest relative to the smaller edge next to them: two that face each
/// other, or two of which the node of body `other` can be moved onto the reference's, whose normals do not change.
fn closest(overlap: &Overlap, other: usize) -> Option<([usize; 2], f64)> {
    let inner = |b: usize| 1..overlap.sites[b].len().saturating_sub(1);
    let mut best: Option<([usize; 2], f64)> = None;
    let mut j = inner(1).start;
    for i in inner(0) {
        let distance = |j: usize| (overlap.sites[1][j].s - overlap.sites[0][i].s).abs();
        while j + 1 < inner(1).end && distance(j + 1) <= distance(j) {
            j += 1;
        }
        if j >= inner(1).end {
            break;
        }
        let offset = distance(j) / overlap.spacing(0, i).min(overlap.spacing(1, j));
        let fits = match overlap.sites[other][[i, j][other]].motion {
            Motion::None => offset <= ROUND_OFF,
            Motion::Shifts => offset <= SAME,
            Motion::Slides => true,
        };
        if best.is_none_or(|b| fits && offset < b.1) {
            best = Some(([i, j], if fits { offset } else { f64::INFINITY }));
        }
    }
    best
}

/// Snaps the node of body `b` onto the other; false if it may not move that far.
fn slide(
    bodies: &mut [Body; 2],
    overlap: &mut Overlap,
    at: [usize; 2],
    b: usize,
    moves: &mut Moves,
) -> Result<bool, CommonRefinementError> {
    let mut now = HashMap::new();
    if overlap::try_motion(overlap, &bodies[b], b, at, &mut now)? {
        moves.add(b, &bodies[b], &now);
        bodies[b] = with_moved(bodies[b].clone(), b, &now)?;
        return Ok(true);
    }
    Ok(false)
}

/// Inserts the other side's node that is nearest to the middle of a reference's edge, and returns the two nodes.
fn insert(
    bodies: &mut [Body; 2],
    own: &mut Chain,
    overlap: &Overlap,
    reference: usize,
) -> Result<[NodeId; 2], CommonRefinementError> {
    let sites = &overlap.sites[reference];
    let mut best = ([NodeId::NONE; 2], [sites[0].node; 2], f64::NEG_INFINITY, 0.0);
    for w in sites.windows(2) {
        for x in &overlap.sites[1 - reference] {
            let central = (x.s - w[0].s).min(w[1].s - x.s) / (w[1].s - w[0].s);
            if central > best.2 {
                best = ([w[0].node, w[1].node], [x.node; 2], central, x.s);
            }
        }
    }
    let (ends, mut seam, _, s) = best;
    let mesh = bodies[reference].mesh();
    let [from, to] = ends.map(|n| mesh.points()[n]);
    let fault = CommonRefinementError::Folded { point: from };
    let edge = mesh.topology().find_edge(ends[0], ends[1]).ok_or(fault)?;
    let mut marked = vec![false; mesh.topology().facets().len()];
    marked[edge] = true;
    let t = overlap.curve.crossing(s, from, to);
    let point = (1.0 - t) * from + t * to;
    let edges = RefinementEdges::preferring(mesh, &marked);
    let curve = on_curve(&bodies[reference], &overlap.curve, edge, s, point);
    let here = |e: FacetId| (e == edge).then_some(point);
    let refinement = refine::refine_onto(mesh, &edges, &marked, here, |e| curve.filter(|_| e == edge))
        .map_err(|source| CommonRefinementError::Mesh { body: reference, source })?;
    seam[reference] = refinement.middle[edge];
    let place = own.nodes.windows(2).position(|w| w == ends).map_or(own.nodes.len() - 1, |k| k + 1);
    own.nodes.insert(place, seam[reference]);
    own.inserted = true;
    bodies[reference] = (bodies[reference].refined(&refinement))
        .map_err(|source| CommonRefinementError::Body { body: reference, source })?;
    Ok(seam)
}
