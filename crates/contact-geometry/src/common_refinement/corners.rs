//! Ends the stretches of both surfaces at corners between known pieces that face each other.

use super::chain::Chain;
use super::line;
use super::overlap::{ROUND_OFF, SAME};
use crate::outline::{self, Beside};
use fem_core::body::{Body, Piece};
use fem_core::geometry::{Vector, norm, right_normal};
use fem_core::mesh::id::NodeId;
use std::collections::HashMap;

/// A corner faces another one if it is at most this many times as far away as the nearest point: between two surfaces at a constant distance that turn
/// by 90 degrees the corners are 1.41 times as far apart.
const OPPOSITE: f64 = 1.5;
/// Corners closer than this fraction of the smaller body's diagonal are the same.
const TOUCHING: f64 = 1e-6;

/// A stretch with its known pieces.
struct Outline {
    points: Vec<Vector>,
    pieces: Vec<Option<Piece>>,
    beside: Vec<Beside>,
    closed: bool,
}

impl Outline {
    fn new(body: &Body, chain: &Chain) -> Self {
        let points = line::points_of(body, &chain.nodes);
        let pieces = line::pieces_of(body, (&chain.nodes, chain.corners), &points);
        let outward = |k: usize| right_normal(points[k], points[k + 1]);
        let beside = outline::beside(&pieces, &points, outward, chain.is_closed());
        Self { closed: chain.is_closed(), beside, pieces, points }
    }

    /// Lists the places of its nodes, each once.
    fn nodes(&self) -> std::ops::Range<usize> {
        0..self.points.len() - usize::from(self.closed)
    }

    fn shortest(&self) -> f64 {
        self.points.windows(2).map(|w| norm(w[1] - w[0])).fold(f64::INFINITY, f64::min)
    }
}

/// A place of the other surface.
enum Faced {
    /// A node, by stretch and place, at which it has a corner, or is not known.
    Corner([usize; 2]),
    /// A smooth piece with this outward normal.
    Smooth(Vector),
    /// None, or one that is not known.
    Unknown,
}

/// Divides the stretches at corners of the reference that face a corner of the other surface, or a node beside which that is not known. A smooth
/// piece of the other surface gives its normal to the corner instead. Returns the new places of corners of the other surface, which coincide with
/// the reference's up to the rounding of the meshes.
pub(super) fn end_stretches(
    bodies: [&Body; 2],
    chains: &mut [Vec<Chain>; 2],
    reference: usize,
) -> HashMap<NodeId, Vector> {
    let (r, o) = (reference, 1 - reference);
    let mut moved = HashMap::new();
    if !bodies[r].has_curves() {
        return moved;
    }
    let outlines =
        [0, 1].map(|b| chains[b].iter().map(|chain| Outline::new(bodies[b], chain)).collect::<Vec<_>>());
    let size = bodies[0].mesh().diagonal().min(bodies[1].mesh().diagonal());
    let mut cuts = [0, 1].map(|b: usize| vec![Vec::new(); chains[b].len()]);
    for (i, own) in outlines[r].iter().enumerate() {
        for k in own.nodes().filter(|k| own.beside[*k].is_corner()) {
            let point = own.points[k];
            match faced(own, k, &outlines[o]) {
                Faced::Corner([j, l]) => {
                    cuts[r][i].push(k);
                    cuts[o][j].push(l);
                    let off = norm(outlines[o][j].points[l] - point);
                    let spacing = own.shortest().min(outlines[o][j].shortest());
                    if off > ROUND_OFF * spacing && off <= (TOUCHING * size).min(SAME * spacing) {
                        moved.insert(chains[o][j].nodes[l], point);
                    }
                }
                Faced::Smooth(normal) => {
                    let node = chains[r][i].nodes[k];
                    chains[r][i].faced.push((node, -normal));
                }
                Faced::Unknown => {}
            }
        }
    }
    for (chains, cuts) in chains.iter_mut().zip(cuts) {
        *chains =
            std::mem::take(chains).into_iter().zip(cuts).flat_map(|(c, cuts)| divided(c, cuts)).collect();
    }
    moved
}

/// Finds the place of the other surface that a corner faces.
///
/// * `k`: the place of the corner on its own stretch.
fn faced(own: &Outline, k: usize, others: &[Outline]) -> Faced {
    let point = own.points[k];
    let Some(outward) = own.beside[k].normal() else { return Faced::Unknown };
    let mut nearest: Option<(f64, usize, usize, f64)> = None;
    for (j, other) in others.iter().enumerate() {
        for (m, w) in other.points.windows(2).enumerate() {
            let along = w[1] - w[0];
            let t = ((point - w[0]).dot(&along) / along.dot(&along)).clamp(0.0, 1.0);
            let distance = norm(w[0] + t * along - point);
            if nearest.is_none_or(|best| distance < best.0) {
                nearest = Some((distance, j, m, t));
            }
        }
    }
    let Some((distance, j, m, t)) = nearest else { return Faced::Unknown };
    let other = &others[j];
    let same = SAME * own.shortest().min(other.shortest());
    let off = |l: &usize| norm(other.points[*l] - point);
    let close = |reach: f64, takes: &dyn Fn(&Beside) -> bool| {
        let close = other.nodes().filter(|l| off(l) <= reach && takes(&other.beside[*l]));
        close.min_by(|a, b| off(a).total_cmp(&off(b)))
    };
    let corner = close(OPPOSITE * distance + same, &Beside::is_corner);
    if let Some(l) = corner.or_else(|| close(same, &|beside| !beside.is_smooth())) {
        return Faced::Corner([j, l]);
    }
    let at_node = [(0.0, m), (1.0, m + 1)].into_iter().find(|(end, _)| t == *end);
    let normal = match at_node {
        Some((_, l)) => Some(&other.beside[l]).filter(|beside| beside.is_smooth()).and_then(Beside::normal),
        None => other.pieces[m].map(|piece| {
            let [from, to] = [other.points[m], other.points[m + 1]];
            piece.normal((1.0 - t) * from + t * to, right_normal(from, to))
        }),
    };
    normal.filter(|normal| normal.dot(&outward) < -0.5).map_or(Faced::Unknown, Faced::Smooth)
}

/// Divides a stretch at places, in any order and possibly at its ends.
fn divided(chain: Chain, mut cuts: Vec<usize>) -> Vec<Chain> {
    let (edges, closed) = (chain.nodes.len() - 1, chain.is_closed());
    cuts.retain(|k| closed || (1..edges).contains(k));
    cuts.sort_unstable();
    cuts.dedup();
    if cuts.is_empty() {
        return vec![chain];
    }
    let node = |k: usize| chain.nodes[if closed { k % edges } else { k }];
    let part = |([from, to], corners): ([usize; 2], [bool; 2])| Chain {
        nodes: (from..=to).map(node).collect(),
        corners,
        faced: chain.faced.clone(),
        inserted: false,
    };
    outline::divided(edges, closed, &cuts).into_iter().map(part).collect()
}
