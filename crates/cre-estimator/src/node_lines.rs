//! The direction in which a contact node leaves all lines that it lies on.

use crate::recovery::Recovery;
use crate::side::side_sign;
use fem_core::body::NodeConstraint;
use fem_core::directions::Directions;
use fem_core::geometry::{Coordinates, norm};
use fem_core::interface::{ContactProblem, NodePair};
use fem_core::mesh::id::NodeId;
use fem_core::space::Space;
use std::collections::HashMap;

/// A node whose motion opens one of its edges by less than this fraction is not moved; the checks reject a remaining
/// penetration.
const SMALLEST_GAIN: f64 = 0.1;
/// A node that would have to move by more than this multiple of the opening is not moved.
const LONGEST: f64 = 100.0;
/// An opening below one by less than this is one.
const ONE: f64 = 1e-9;
/// Normals whose sine is smaller are one.
const PARALLEL: f64 = 1e-9;

/// The contact lines of each node: pairs, and the sides of the body in them.
pub(crate) struct NodeLines<'a, S: Recovery> {
    pub(crate) problem: &'a ContactProblem<S>,
    of_node: HashMap<(usize, NodeId), Vec<(usize, usize)>>,
}

impl<'a, S: Recovery> NodeLines<'a, S> {
    pub(crate) fn new(problem: &'a ContactProblem<S>) -> Self {
        let mut of_node: HashMap<(usize, NodeId), Vec<(usize, usize)>> = HashMap::new();
        for (k, pair) in problem.contacts.iter().enumerate() {
            let interface = &pair.interface;
            let corners = |facet| (0..S::DIM).map(move |corner| interface.corner_pair(facet, corner));
            // Clamped corners are on the line, but no pairs of it.
            let nodes = interface.pairs().iter().chain(interface.facets().iter().flat_map(corners));
            for (of, (side, body)) in nodes.flat_map(|of| pair.elastic_sides().map(move |side| (of, side))) {
                let lines = of_node.entry((body, of.nodes[side])).or_default();
                if lines.last().is_none_or(|(last, _)| *last != k) {
                    lines.push((k, side));
                }
            }
        }
        Self { problem, of_node }
    }

    /// Returns the direction `d` in which the node of a body moves to open its pair, `d·n ≥ 1`, with the sign of the normal: the shortest one
    /// that its supports leave free and that opens every pair of the node by at least one. `None` if it cannot move, or if that would close a bent
    /// edge of the node: nodes of rigid sides, and those held along the normal.
    pub(crate) fn direction(&self, body: usize, side: usize, pair: &NodePair<S>) -> Option<S::Vector> {
        let node = pair.nodes[side];
        let (mut normals, mut beside) = (Vec::new(), Vec::new());
        for (k, side) in self.of_node.get(&(body, node)).into_iter().flatten().copied() {
            let interface = &self.problem.contacts[k].interface;
            let (pairs, outward) = (interface.pairs(), -side_sign(side));
            normals.extend(pairs.iter().filter(|of| of.nodes[side] == node).map(|of| of.normal * outward));
            for edge in interface.facets().iter().filter(|edge| edge.bent) {
                let corners = || (0..S::DIM).map(|corner| interface.corner_pair(edge, corner));
                for (of, other) in corners().flat_map(|of| corners().map(move |other| (of, other))) {
                    if of.nodes[side] == node && other.nodes != of.nodes {
                        beside.push(other.normal * outward);
                    }
                }
            }
        }
        let away = shortest(&normals, &self.problem.bodies[body].node_constraints()[node])?;
        beside.iter().all(|n| away.times(n) > SMALLEST_GAIN).then(|| away * -side_sign(side))
    }
}

/// Finds the shortest displacement that a support leaves free with a part of at least one along all normals.
fn shortest<S: Space>(normals: &[S::Vector], constraint: &NodeConstraint<S>) -> Option<S::Vector> {
    let free = constraint.held.complement();
    let candidates: Vec<S::Vector> = match free.basis() {
        [] => Vec::new(),
        [free] => normals.iter().map(|n| *free * (1.0 / free.times(n))).collect(),
        _ => {
            let normals: Vec<S::Vector> = normals.iter().map(|n| free.project(*n)).collect();
            let alone = normals.iter().map(|n| *n * (1.0 / n.times(n)));
            alone.chain(crossings::<S>(&normals, free.count())).collect()
        }
    };
    let opens = |d: &S::Vector| normals.iter().all(|n| n.times(d) >= 1.0 - ONE) && norm(*d) <= LONGEST;
    candidates.into_iter().filter(opens).min_by(|a, b| a.times(a).total_cmp(&b.times(b)))
}

/// Computes the vectors with a part of one along two or more normals, up to the number of free directions, and no part beside these.
fn crossings<S: Space>(normals: &[S::Vector], free: usize) -> Vec<S::Vector> {
    let mut found = Vec::new();
    let mut sets: Vec<Vec<usize>> = (0..normals.len()).map(|k| vec![k]).collect();
    while let Some(set) = sets.pop() {
        if set.len() >= 2 {
            let span = set
                .iter()
                .fold(Directions::<S>::NONE, |span, k| span.with(normals[*k] / norm(normals[*k]), PARALLEL));
            let beside = span.complement();
            if span.count() == set.len() {
                let vectors = S::axes(|k| match set.get(k) {
                    Some(k) => normals[*k],
                    None => beside.basis()[k - set.len()],
                });
                let across = S::across(&vectors);
                let sum = (1..set.len()).fold(across[0], |sum, k| sum + across[k]);
                found.push(sum * (1.0 / across[0].times(&vectors[0])));
            }
        }
        if set.len() < free {
            let last = set.last().copied().unwrap_or(0);
            sets.extend((last + 1..normals.len()).map(|k| [set.as_slice(), &[k]].concat()));
        }
    }
    found
}
