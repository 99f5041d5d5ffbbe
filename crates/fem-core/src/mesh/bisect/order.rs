//! The order of the edges of all bodies, and the representatives of their nodes.

use super::edges;
use crate::mesh::TetMesh;
use crate::mesh::id::NodeId;
use crate::partition::Partition;
use crate::space::{Solid, Space};
use std::collections::BTreeMap;

type Vector = <Solid as Space>::Vector;

/// A strict order of the edges of several meshes: by `|x_r − x_s|²` to 10 digits, then the smaller, then the larger of `r` and `s`.
///
/// `r` and `s` are the representatives of the ends, and `x` their places. These are never moved, so that no edge changes its place in the order.
#[derive(Clone, Debug)]
pub struct EdgeOrder {
    /// The representative of each node of each body.
    pub(super) representatives: Vec<Vec<u32>>,
    /// The place of each representative, m.
    pub(super) places: Vec<Vector>,
    /// The number of nodes of the first mesh of each body.
    pub(super) first: Vec<usize>,
}

/// Nodes of one cell that contact pairs join: no order tells their edge from a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JoinedNodes {
    /// The body, from 0.
    pub body: usize,
    /// One of the nodes.
    pub node: NodeId,
}

/// A body and one of its nodes.
pub type BodyNode = (usize, NodeId);

impl EdgeOrder {
    /// Chooses the representative of each node of first meshes: of all nodes that pairs join, the one with the smallest number in the smallest body.
    /// Bodies that are apart are moved next to each other first, by the mean distance of their pairs.
    ///
    /// * `pairs`: two nodes of two bodies each.
    ///
    /// # Errors
    /// A cell two of whose nodes have one representative.
    pub fn new(meshes: &[&TetMesh], pairs: &[[BodyNode; 2]]) -> Result<Self, JoinedNodes> {
        let first: Vec<usize> = meshes.iter().map(|mesh| mesh.points().len()).collect();
        let starts = starts(&first);
        let mut joined = Partition::new(starts[first.len()]);
        for pair in pairs {
            let [a, b] = pair.map(|(body, node)| starts[body] + node.index());
            joined.join(a, b);
        }
        let shifts = shifts(meshes, pairs);
        let points =
            meshes.iter().zip(shifts).flat_map(|(mesh, shift)| mesh.points().iter().map(move |x| x + shift));
        let places = points.collect();
        let of_body = |b: usize| (starts[b]..starts[b + 1]).map(|node| joined.first(node) as u32).collect();
        let representatives: Vec<Vec<u32>> = (0..first.len()).map(of_body).collect();
        for (body, (mesh, of)) in meshes.iter().zip(&representatives).enumerate() {
            for [a, b] in mesh.cells().iter().flat_map(edges) {
                if of[a.index()] == of[b.index()] {
                    return Err(JoinedNodes { body, node: a });
                }
            }
        }
        Ok(Self { representatives, places, first })
    }

    /// Returns the representative of each node of a body.
    pub fn representatives(&self, body: usize) -> &[u32] {
        &self.representatives[body]
    }

    /// Tells whether a node is one of the first mesh of its body.
    pub fn is_first(&self, (body, node): BodyNode) -> bool {
        node.index() < self.first[body]
    }
}

/// Lists where each body begins in an array of all bodies, and the end.
pub(super) fn starts(counts: &[usize]) -> Vec<usize> {
    let mut starts = vec![0];
    for (k, count) in counts.iter().enumerate() {
        starts.push(starts[k] + count);
    }
    starts
}

/// Finds the motions without rotation that bring the bodies to their partners: each to those that were placed before it.
fn shifts(meshes: &[&TetMesh], pairs: &[[BodyNode; 2]]) -> Vec<Vector> {
    let mut between: BTreeMap<[usize; 2], (Vector, f64)> = BTreeMap::new();
    for pair in pairs {
        let [x, y] = pair.map(|(body, node)| meshes[body].points()[node]);
        let [a, b] = pair.map(|(body, _)| body);
        for (key, distance) in [([a, b], x - y), ([b, a], y - x)] {
            let (sum, count) = between.entry(key).or_insert((Vector::zeros(), 0.0));
            *sum += distance;
            *count += 1.0;
        }
    }
    let mut shifts: Vec<Option<Vector>> = vec![None; meshes.len()];
    // How far a body has to move to those that are placed; none if it touches none of them.
    let wanted = |body: usize, shifts: &[Option<Vector>]| {
        let (mut sum, mut all) = (Vector::zeros(), 0.0);
        for (&[to, _], (distance, count)) in between.iter().filter(|(key, _)| key[1] == body) {
            if let Some(shift) = shifts[to] {
                sum += distance + shift * *count;
                all += count;
            }
        }
        (all > 0.0).then(|| sum / all)
    };
    for _ in 0..meshes.len() {
        let waiting = || (0..meshes.len()).filter(|b| shifts[*b].is_none());
        let next = waiting().find_map(|b| Some((b, wanted(b, &shifts)?)));
        let Some((body, shift)) = next.or_else(|| Some((waiting().next()?, Vector::zeros()))) else { break };
        shifts[body] = Some(shift);
    }
    shifts.into_iter().map(Option::unwrap_or_default).collect()
}
